// Whole files: see whole_files.h.
#include "io/whole_files.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <functional>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <system_error>
#include <utility>

#include "omma/error.h"
#include "system/files.h"
#include "system/process.h"

namespace omma {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t token_length = 12;
constexpr const char* ending = ".partial";

[[noreturn]] void fail(const std::string& path, const std::string& reason) {
  throw Error(path + ": cannot be written: " + reason);
}

// What the system says of its last call, read before anything else can change it.
[[noreturn]] void fail_of_system(const std::string& path) {
  fail(path, system::reason());
}

std::string new_token() {
  std::random_device random;
  char text[2 * sizeof(std::uint64_t) + 1];
  const std::uint64_t number = (std::uint64_t{random()} << 32) | random();
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(number));
  return std::string(text).substr(0, token_length);
}

// What the temporary file of a name begins with. Names may have 255 bytes; what is left out of a
// long one is there as a hash, as files of one call may differ in their ends alone.
std::string stem_of(const std::string& name) {
  constexpr std::size_t longest = 200;
  if (name.size() <= longest) return name;
  char hash[2 + 2 * sizeof(std::uint64_t)];
  std::snprintf(hash, sizeof hash, "~%016llx",
                static_cast<unsigned long long>(std::hash<std::string>()(name)));
  std::size_t end = longest - std::strlen(hash);
  while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xc0) == 0x80) --end;  // UTF-8
  return name.substr(0, end) + hash;
}

fs::path folder_of(const fs::path& target) {
  return target.has_parent_path() ? target.parent_path() : fs::path(".");
}

fs::path kept_name(fs::path target) {
  return target += ending;
}

// Where a file called `path` is to be made, all links followed: a link may lead to what is not yet.
fs::path find_target(const std::string& path) {
  std::error_code error;
  const fs::path given = system::path_of(path);
  const fs::file_status status = fs::status(system::reachable(given), error);
  if (fs::is_directory(status)) fail(path, "it is a directory");
  // Renaming over a device or a pipe would replace it by a file.
  if (fs::exists(status) && !fs::is_regular_file(status)) fail(path, "it is not a regular file");
  if (error == std::errc::too_many_symbolic_link_levels || error == std::errc::permission_denied)
    fail(path, error.message());
  fs::path target = system::link_target(given);
  if (target.filename().empty()) throw Error("\"" + path + "\": is not the name of a file");
  const fs::path folder = folder_of(target);
  if (!fs::is_directory(system::reachable(folder), error))
    fail(path, "there is no directory " + system::text_of(folder));
  return target;
}

void sync_folder(const fs::path& folder) {
  if (!system::sync_folder(folder)) fail_of_system(system::text_of(folder));
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

}  // namespace

WholeFiles::WholeFiles() : token_(new_token()), process_(system::process_id()) {}

WholeFiles::~WholeFiles() {
  discard();
}

std::size_t WholeFiles::open(const std::string& path) {
  Part part{path, find_target(path), {}};
  const std::string stem = stem_of(system::text_of(part.target.filename()));
  part.temporary = part.target.parent_path() / system::path_of("." + stem + "." + token_ + ending);
  parts_.push_back(std::move(part));
  Part& made = parts_.back();
  made.file = system::make_file(made.temporary, made.target);
  if (made.file == system::no_file) {
    const std::string why = system::reason();
    parts_.pop_back();  // it is not ours to remove
    fail(path, why);
  }
  system::lock(made.file);
  return parts_.size() - 1;
}

std::size_t WholeFiles::open_kept(const std::string& path, std::uintmax_t bytes) {
  Part part{path, find_target(path), {}};
  part.temporary = kept_name(part.target);
  part.kept = true;
  const std::string name = system::text_of(part.temporary);
  part.file = system::open_file(part.temporary);
  if (part.file == system::no_file) fail_of_system(name);
  parts_.push_back(part);  // closed with the others from here on
  if (system::lock(part.file) == system::Lock::of_another)
    fail(name, "another process is writing it");
  system::keep_permissions(part.file, part.target);
  if (!system::cut(part.file, bytes)) fail_of_system(name);
  sync_folder(folder_of(part.target));
  return parts_.size() - 1;
}

void WholeFiles::write(std::size_t file, std::span<const char> bytes) {
  const Part& part = parts_.at(file);
  if (!system::write(part.file, bytes)) fail_of_system(part.path);
}

std::string WholeFiles::temporary(std::size_t file) const {
  return system::text_of(parts_.at(file).temporary);
}

void WholeFiles::close(std::size_t file) {
  Part& part = parts_.at(file);
  if (part.closed) return;
  if (!system::sync(part.file)) fail_of_system(part.path);
  part.closed = true;
  // One file in each folder stays open: its lock says that somebody is at work. All of them would
  // be more than a process may have open.
  const bool first = locked_folders_.insert(folder_of(part.target)).second;
  if (!first) system::close_file(std::exchange(part.file, system::no_file));
}

std::uintmax_t WholeFiles::sync(std::size_t file) {
  const Part& part = parts_.at(file);
  if (!system::sync(part.file)) fail_of_system(part.path);
  return system::position(part.file);
}

void WholeFiles::finish() {
  for (std::size_t i = 0; i < parts_.size(); ++i) close(i);
  std::set<fs::path> folders;
  for (Part& part : parts_) {
    if (!system::replace(part.temporary, part.target)) fail_of_system(part.path);
    part.temporary.clear();
    folders.insert(folder_of(part.target));
  }
  for (const fs::path& folder : folders) sync_folder(folder);
  discard();
}

void WholeFiles::discard() noexcept {
  for (const Part& part : parts_) {
    // Before it is closed, as what has no lock is taken for a dead run's.
    if (!part.temporary.empty() && !part.kept && system::process_id() == process_)
      system::remove_file(part.temporary);
    if (part.file != system::no_file) system::close_file(part.file);
  }
  parts_.clear();
  locked_folders_.clear();
}

void check_target(const std::string& path) {
  find_target(path);
}

std::uintmax_t kept_bytes(const std::string& path) {
  std::error_code error;
  const fs::path kept = kept_name(find_target(path));
  const std::uintmax_t size = fs::file_size(system::reachable(kept), error);
  return error ? 0 : size;
}

std::vector<LeftBehind> left_behind(const std::vector<std::string>& paths) {
  std::map<fs::path, std::set<std::string>> names;
  for (const std::string& path : paths) {
    const fs::path target = find_target(path);
    names[folder_of(target)].insert(stem_of(system::text_of(target.filename())));
  }
  std::vector<LeftBehind> found;
  for (const auto& [folder, wanted] : names) {
    std::map<std::string, std::vector<fs::path>> by_token;
    std::set<std::string> living;
    for (const fs::path& entry : system::names_in(folder)) {
      const fs::path file = folder / entry;
      const auto temporary = parse_temporary(system::text_of(file.filename()));
      if (!temporary) continue;
      const auto& [name, token] = *temporary;
      if (!system::is_unlocked(file)) living.insert(token);
      if (wanted.contains(name)) by_token[token].push_back(file);
    }
    for (auto& [token, files] : by_token) {
      if (living.contains(token)) continue;
      std::sort(files.begin(), files.end());
      for (const fs::path& file : files) {
        std::error_code error;
        const std::uintmax_t bytes = fs::file_size(system::reachable(file), error);
        found.push_back({system::text_of(file), error ? 0 : bytes});
      }
    }
  }
  return found;
}

}  // namespace omma
