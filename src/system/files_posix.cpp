// Files of POSIX systems: see files.h.
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "system/files.h"

namespace omma::system {
namespace {

namespace fs = std::filesystem;

int descriptor(File file) {
  return static_cast<int>(file);
}

void keep(int file, const struct stat& old) {
  mode_t mode = old.st_mode & 07777;
  if (fchown(file, old.st_uid, old.st_gid) != 0) {
    mode &= 0777;  // no setuid of another owner
    // Nor may a group that is another one do more than everybody.
    if (fchown(file, static_cast<uid_t>(-1), old.st_gid) != 0)
      mode = (mode & 0707) | ((mode & 07) << 3);
  }
  fchmod(file, mode);
}

}  // namespace

fs::path path_of(const std::string& text) {
  return text;
}

std::string text_of(const fs::path& path) {
  return path.string();
}

fs::path reachable(const fs::path& path) {
  return path;
}

fs::path resolved(const fs::path& path, std::error_code& error) {
  return fs::weakly_canonical(path, error);
}

fs::path link_target(const fs::path& path) {
  std::error_code error;
  fs::path target = path;
  while (fs::is_symlink(fs::symlink_status(target, error)))
    target = target.parent_path() / fs::read_symlink(target, error);
  return target;
}

std::vector<fs::path> names_in(const fs::path& folder) {
  std::vector<fs::path> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error))
    names.push_back(entry->path().filename());
  return names;
}

std::string reason() {
  return errno != 0 ? std::strerror(errno) : "unknown error";
}

File make_file(const fs::path& path, const fs::path& replaced) {
  struct stat old {};
  const bool replaces = stat(replaced.c_str(), &old) == 0;
  errno = 0;
  const int file =
      ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, replaces ? 0600 : 0666);
  if (file >= 0 && replaces) keep(file, old);
  return file;
}

File open_file(const fs::path& path) {
  errno = 0;
  return ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
}

void keep_permissions(File file, const fs::path& replaced) {
  struct stat old {};
  if (stat(replaced.c_str(), &old) == 0) keep(descriptor(file), old);
}

void close_file(File file) noexcept {
  ::close(descriptor(file));
}

Lock lock(File file) {
  if (flock(descriptor(file), LOCK_EX | LOCK_NB) == 0) return Lock::taken;
  return errno == EWOULDBLOCK ? Lock::of_another : Lock::impossible;
}

bool is_unlocked(const fs::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return false;
  const bool free = lock(file) == Lock::taken;
  ::close(file);
  return free;
}

bool write(File file, std::span<const char> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(descriptor(file), bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return true;
}

bool cut(File file, std::uintmax_t bytes) {
  return ftruncate(descriptor(file), static_cast<off_t>(bytes)) == 0 &&
         lseek(descriptor(file), 0, SEEK_END) >= 0;
}

std::uintmax_t position(File file) {
  return static_cast<std::uintmax_t>(lseek(descriptor(file), 0, SEEK_CUR));
}

bool sync(File file) {
  int result = 0;
  do result = fsync(descriptor(file));
  while (result != 0 && errno == EINTR);
  return result == 0 || errno == EINVAL || errno == ENOTSUP;
}

bool sync_folder(const fs::path& folder) {
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) return true;
  const bool synced = sync(file);
  const int why = errno;
  ::close(file);
  errno = why;
  return synced;
}

bool replace(const fs::path& from, const fs::path& to) {
  return std::rename(from.c_str(), to.c_str()) == 0;
}

void remove_file(const fs::path& path) noexcept {
  unlink(path.c_str());
}

}  // namespace omma::system
