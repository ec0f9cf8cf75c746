// Whole files in and out, with one wording for what the file system refuses.
#include "io/atomic_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "io/whole_files.h"
#include "omma/error.h"
#include "system/files.h"
#include "threads/cancel.h"

namespace omma {
namespace {

namespace fs = std::filesystem;

std::string reason() {
  return errno != 0 ? std::strerror(errno) : "unknown error";
}

}  // namespace

std::string read_file(const std::string& path, const WorkPart& work) {
  std::error_code error;
  const fs::path name = system::reachable(system::path_of(path));
  const fs::file_status status = fs::status(name, error);
  if (status.type() == fs::file_type::not_found) throw Error(path + ": there is no such file");
  if (error) throw Error(path + ": cannot be opened: " + error.message());
  if (fs::is_directory(status)) throw Error(path + ": is a directory, expected a file");
  // A device such as /dev/zero would never end.
  if (!fs::is_regular_file(status)) throw Error(path + ": is not a regular file");

  errno = 0;
  std::ifstream file(name, std::ios::binary);
  if (!file) throw Error(path + ": cannot be opened: " + reason());
  const std::uintmax_t size = fs::file_size(name, error);
  if (error) throw Error(path + ": cannot be read: " + error.message());
  std::string bytes(size, '\0');
  constexpr std::uintmax_t piece = 1 << 24;
  for (std::uintmax_t at = 0; at < size; at += piece) {
    const auto count = static_cast<std::streamsize>(std::min(piece, size - at));
    file.read(bytes.data() + at, count);
    if (file.gcount() != count) throw Error(path + ": cannot be read to its end: " + reason());
    check_cancelled();
    work.reach(static_cast<double>(at) / static_cast<double>(size));
  }
  return bytes;
}

void write_file_atomically(const std::string& path, std::span<const char> bytes) {
  WholeFiles files;
  files.write(files.open(path), bytes);
  files.finish();
}

}  // namespace omma
