// The one writer of all formats: files get their names when all of them are whole, and together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "system/files.h"

namespace omma {

// Files that are written beside their targets as `.NAME.TOKEN.partial` and renamed by `finish`.
// Data and folders are synced, so that after a loss of power too a target is either what it was or
// complete. Symbolic links are followed: the file they lead to is replaced, the link stays. A file
// that was there keeps its permissions, and its owner and group where the system allows it; new
// files get what the umask leaves. All of it throws omma::Error that names the path.
class WholeFiles {
 public:
  WholeFiles();
  WholeFiles(const WholeFiles&) = delete;
  WholeFiles& operator=(const WholeFiles&) = delete;
  ~WholeFiles();  // as `discard`

  // A file that will be called `path`; the number that it goes by here.
  std::size_t open(const std::string& path);
  // The same, but as `path`.partial, which goes on after its first `bytes` and is never removed:
  // work that takes hours and is cut off can go on from there. One process at a time.
  std::size_t open_kept(const std::string& path, std::uintmax_t bytes);
  void write(std::size_t file, std::span<const char> bytes);
  // Where its bytes are meanwhile, for libraries that write to a path themselves.
  std::string temporary(std::size_t file) const;
  // Nothing more will be written to it: all is brought to the disk.
  void close(std::size_t file);
  // Brings what was written so far to the disk; its size.
  std::uintmax_t sync(std::size_t file);
  // Closes all and gives them their names.
  void finish();
  // Removes all that have no name yet and are not to be kept.
  void discard() noexcept;

 private:
  struct Part {
    std::string path;  // as the caller named it
    std::filesystem::path target, temporary;
    system::File file = system::no_file;
    bool closed = false;  // synced; `file` may stay for its lock
    bool kept = false;
  };

  std::string token_;
  long process_;  // a forked child must not remove its parent's files
  std::vector<Part> parts_;
  std::set<std::filesystem::path> locked_folders_;
};

// Throws omma::Error where a file of that name cannot be made: a directory, a device or a pipe has
// that name, or there is no folder for it.
void check_target(const std::string& path);

// Bytes of what `open_kept` has begun of a file with that name; 0 where there is none.
std::uintmax_t kept_bytes(const std::string& path);

// What runs that were killed left of files with these names. Those of a run that still goes on are
// not among them: it holds a lock on one file in each folder.
struct LeftBehind {
  std::string path;
  std::uintmax_t bytes = 0;
};
std::vector<LeftBehind> left_behind(const std::vector<std::string>& paths);

}  // namespace omma
