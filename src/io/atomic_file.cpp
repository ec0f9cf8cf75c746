// Whole files in and out, with one wording for what the file system refuses.
#include "io/atomic_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <system_error>

#include "omma/error.h"

namespace omma {
namespace {

namespace fs = std::filesystem;

std::string reason() {
  return errno != 0 ? std::strerror(errno) : "unknown error";
}

}  // namespace

std::string read_file(const std::string& path, const WorkPart& work) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) throw Error(path + ": there is no such file");
  if (error) throw Error(path + ": cannot be opened: " + error.message());
  if (fs::is_directory(status)) throw Error(path + ": is a directory, expected a file");
  // A device such as /dev/zero would never end.
  if (!fs::is_regular_file(status)) throw Error(path + ": is not a regular file");

  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(path + ": cannot be opened: " + reason());
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) throw Error(path + ": cannot be read: " + error.message());
  std::string bytes(size, '\0');
  constexpr std::uintmax_t piece = 1 << 24;
  for (std::uintmax_t at = 0; at < size; at += piece) {
    const auto count = static_cast<std::streamsize>(std::min(piece, size - at));
    file.read(bytes.data() + at, count);
    if (file.gcount() != count) throw Error(path + ": cannot be read to its end: " + reason());
    work.reach(static_cast<double>(at) / static_cast<double>(size));
  }
  return bytes;
}

void write_file_atomically(const std::string& path, std::span<const char> bytes) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) throw Error(path + ": is a directory, expected a file to write");
  // Renaming over a device or a pipe would replace it by a file.
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw Error(path + ": exists and is not a regular file");
  // Through a symbolic link the file it points to is replaced, not the link.
  const fs::path target = fs::is_symlink(fs::symlink_status(path, error)) && fs::exists(status)
                              ? fs::canonical(path, error)
                              : fs::path(path);
  if (target.filename().empty()) throw Error("\"" + path + "\": is not the name of a file");

  const std::string temporary =
      target.string() + "." + std::to_string(std::random_device{}()) + ".tmp";
  errno = 0;
  std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
  if (!file) throw Error(path + ": cannot be written: " + reason());
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) {
    const std::string why = reason();
    fs::remove(temporary, error);
    throw Error(path + ": cannot be written: " + why);
  }
  fs::rename(temporary, target, error);
  if (error) {
    const std::string why = error.message();
    fs::remove(temporary, error);
    throw Error(path + ": cannot be written: " + why);
  }
}

}  // namespace omma
