// Whole files: see whole_files.h. POSIX calls, as the standard library can neither sync, lock nor
// keep owners.
#include "io/whole_files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <system_error>
#include <utility>

#include "omma/error.h"

namespace omma {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t token_length = 12;
constexpr const char* ending = ".partial";

[[noreturn]] void fail(const std::string& path, const std::string& reason) {
  throw Error(path + ": cannot be written: " + reason);
}

// What `errno` says, read before anything else can change it.
[[noreturn]] void fail_of_system(const std::string& path) {
  fail(path, errno != 0 ? std::strerror(errno) : "unknown error");
}

std::string new_token() {
  std::random_device random;
  char text[2 * sizeof(std::uint64_t) + 1];
  const std::uint64_t number = (std::uint64_t{random()} << 32) | random();
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(number));
  return std::string(text).substr(0, token_length);
}

// The part of a name that its temporary file begins with. Names may have 255 bytes.
std::string stem_of(const std::string& name) {
  constexpr std::size_t longest = 200;
  if (name.size() <= longest) return name;
  std::size_t end = longest;
  while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xc0) == 0x80) --end;  // UTF-8
  return name.substr(0, end);
}

fs::path folder_of(const fs::path& target) {
  return target.has_parent_path() ? target.parent_path() : fs::path(".");
}

// Where a file called `path` is to be made, all links followed: a link may lead to what is not yet.
fs::path find_target(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) fail(path, "it is a directory");
  // Renaming over a device or a pipe would replace it by a file.
  if (fs::exists(status) && !fs::is_regular_file(status)) fail(path, "it is not a regular file");
  if (error == std::errc::too_many_symbolic_link_levels || error == std::errc::permission_denied)
    fail(path, error.message());
  fs::path target = path;
  while (fs::is_symlink(fs::symlink_status(target, error)))
    target = target.parent_path() / fs::read_symlink(target, error);
  if (target.filename().empty()) throw Error("\"" + path + "\": is not the name of a file");
  if (!fs::is_directory(folder_of(target), error))
    fail(path, "there is no directory " + folder_of(target).string());
  return target;
}

// Gives a new file what the one had that it will replace.
void keep_permissions(int descriptor, const struct stat& old) {
  mode_t mode = old.st_mode & 07777;
  if (fchown(descriptor, old.st_uid, old.st_gid) != 0) {
    mode &= 0777;  // no setuid of another owner
    // Nor may a group that is another one do more than everybody.
    if (fchown(descriptor, static_cast<uid_t>(-1), old.st_gid) != 0)
      mode = (mode & 0707) | ((mode & 07) << 3);
  }
  fchmod(descriptor, mode);
}

// Some file systems cannot sync (EINVAL); that is not the file's fault.
bool to_disk(int descriptor) {
  int result = 0;
  do result = fsync(descriptor);
  while (result != 0 && errno == EINTR);
  return result == 0 || errno == EINVAL || errno == ENOTSUP;
}

void sync_folder(const fs::path& folder) {
  // A folder that may be written but not read cannot be opened; the files are there all the same.
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  const bool synced = to_disk(descriptor);
  const int why = errno;
  ::close(descriptor);
  errno = why;
  if (!synced) fail_of_system(folder.string());
}

bool lock(int descriptor) {
  return flock(descriptor, LOCK_EX | LOCK_NB) == 0;
}

// Name and token of a temporary file, or nothing where it is none.
std::optional<std::pair<std::string, std::string>> parse_temporary(const std::string& name) {
  const std::size_t tail = 1 + token_length + std::strlen(ending);
  if (name.size() < tail + 2 || name[0] != '.' || !name.ends_with(ending)) return {};
  const std::size_t dot = name.size() - tail;
  const std::string token = name.substr(dot + 1, token_length);
  if (name[dot] != '.' || token.find_first_not_of("0123456789abcdef") != std::string::npos)
    return {};
  return std::pair(name.substr(1, dot - 1), token);
}

// Whether no process writes to a file. Where that is not known it is not said of anyone.
bool is_abandoned(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return false;
  const bool free = lock(descriptor);
  ::close(descriptor);
  return free;
}

}  // namespace

WholeFiles::WholeFiles() : token_(new_token()), process_(getpid()) {}

WholeFiles::~WholeFiles() {
  discard();
}

std::size_t WholeFiles::open(const std::string& path) {
  Part part{path, find_target(path), {}};
  const std::string name = "." + stem_of(part.target.filename().string()) + "." + token_ + ending;
  part.temporary = part.target.parent_path() / name;
  struct stat old {};
  const bool replaces = stat(part.target.c_str(), &old) == 0;
  parts_.push_back(std::move(part));
  Part& made = parts_.back();
  errno = 0;
  made.descriptor = ::open(made.temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC,
                           replaces ? 0600 : 0666);
  if (made.descriptor < 0) {
    const int why = errno;
    parts_.pop_back();
    errno = why;
    fail_of_system(path);
  }
  if (replaces) keep_permissions(made.descriptor, old);
  lock(made.descriptor);
  return parts_.size() - 1;
}

std::size_t WholeFiles::open_kept(const std::string& path, std::uintmax_t bytes) {
  Part part{path, find_target(path), {}};
  part.temporary = part.target.string() + ending;
  part.kept = true;
  const std::string name = part.temporary.string();
  errno = 0;
  part.descriptor = ::open(name.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  if (part.descriptor < 0) fail_of_system(name);
  parts_.push_back(part);  // closed with the others from here on
  if (!lock(part.descriptor) && errno == EWOULDBLOCK) fail(name, "another process is writing it");
  struct stat old {};
  if (stat(part.target.c_str(), &old) == 0) keep_permissions(part.descriptor, old);
  if (ftruncate(part.descriptor, static_cast<off_t>(bytes)) != 0 ||
      lseek(part.descriptor, 0, SEEK_END) < 0)
    fail_of_system(name);
  sync_folder(folder_of(part.target));
  return parts_.size() - 1;
}

void WholeFiles::write(std::size_t file, std::span<const char> bytes) {
  const Part& part = parts_.at(file);
  while (!bytes.empty()) {
    const ssize_t count = ::write(part.descriptor, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail_of_system(part.path);
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
}

std::string WholeFiles::temporary(std::size_t file) const {
  return parts_.at(file).temporary.string();
}

void WholeFiles::close(std::size_t file) {
  Part& part = parts_.at(file);
  if (part.closed) return;
  if (!to_disk(part.descriptor)) fail_of_system(part.path);
  part.closed = true;
  // One file in each folder stays open: its lock says that somebody is at work. All of them would
  // be more than a process may have open.
  const bool first = locked_folders_.insert(folder_of(part.target)).second;
  if (!first) ::close(std::exchange(part.descriptor, -1));
}

std::uintmax_t WholeFiles::sync(std::size_t file) {
  const Part& part = parts_.at(file);
  if (!to_disk(part.descriptor)) fail_of_system(part.path);
  return static_cast<std::uintmax_t>(lseek(part.descriptor, 0, SEEK_CUR));
}

void WholeFiles::finish() {
  for (std::size_t i = 0; i < parts_.size(); ++i) close(i);
  std::set<fs::path> folders;
  for (Part& part : parts_) {
    if (std::rename(part.temporary.c_str(), part.target.c_str()) != 0) fail_of_system(part.path);
    part.temporary.clear();
    folders.insert(folder_of(part.target));
  }
  for (const fs::path& folder : folders) sync_folder(folder);
  discard();
}

void WholeFiles::discard() noexcept {
  for (const Part& part : parts_) {
    // Before it is closed, as what has no lock is taken for a dead run's.
    if (!part.temporary.empty() && !part.kept && getpid() == process_)
      unlink(part.temporary.c_str());
    if (part.descriptor >= 0) ::close(part.descriptor);
  }
  parts_.clear();
  locked_folders_.clear();
}

void check_target(const std::string& path) {
  find_target(path);
}

std::uintmax_t kept_bytes(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(find_target(path).string() + ending, error);
  return error ? 0 : size;
}

std::vector<LeftBehind> left_behind(const std::vector<std::string>& paths) {
  std::map<fs::path, std::set<std::string>> names;
  for (const std::string& path : paths) {
    const fs::path target = find_target(path);
    names[folder_of(target)].insert(stem_of(target.filename().string()));
  }
  std::vector<LeftBehind> found;
  for (const auto& [folder, wanted] : names) {
    std::map<std::string, std::vector<fs::path>> by_token;
    std::set<std::string> living;
    std::error_code error;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
         entry.increment(error)) {
      const auto temporary = parse_temporary(entry->path().filename().string());
      if (!temporary) continue;
      const auto& [name, token] = *temporary;
      if (!is_abandoned(entry->path())) living.insert(token);
      if (wanted.contains(name)) by_token[token].push_back(entry->path());
    }
    for (auto& [token, files] : by_token) {
      if (living.contains(token)) continue;
      std::sort(files.begin(), files.end());
      for (const fs::path& file : files) {
        const std::uintmax_t bytes = fs::file_size(file, error);
        found.push_back({file.string(), error ? 0 : bytes});
      }
    }
  }
  return found;
}

}  // namespace omma
