// What the standard library cannot do with files: make them locked and for one owner, bring them to
// the disk, replace one by another. On POSIX systems and on Windows (files_posix.cpp,
// files_windows.cpp); nothing else of the engine calls these systems for files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <system_error>
#include <vector>

namespace omma::system {

// What stands between folders of a path.
#ifdef _WIN32
inline constexpr const char* separators = "/\\";
#else
inline constexpr const char* separators = "/";
#endif

// Paths are UTF-8 in strings, on every system; on POSIX systems other bytes are kept as they are.
std::filesystem::path path_of(const std::string& text);
std::string text_of(const std::filesystem::path& path);

// The path by which the system, and std::filesystem, finds a file whatever the length of its name:
// Windows wants long ones absolute and behind \\?\. Only for such calls: it has no sensible parts.
std::filesystem::path reachable(const std::filesystem::path& path);

// Where a path leads when links of the part of it that exists are followed; absolute.
std::filesystem::path resolved(const std::filesystem::path& path, std::error_code& error);

// The file that is made, or replaced, where one of that name is written: all links followed, also
// one that leads to nothing yet.
std::filesystem::path link_target(const std::filesystem::path& path);

// Names of what is in a folder, in no order; none where it cannot be read. Of long names the standard
// library of MinGW lists another folder.
std::vector<std::filesystem::path> names_in(const std::filesystem::path& folder);

// An open file: a descriptor, or a handle of Windows.
using File = std::intptr_t;
inline constexpr File no_file = -1;

// What follows says by its result whether it went well; `reason` says why the last of them did not,
// in this thread.
std::string reason();

// A new file of that name, for writing. It gets the permissions that `replaced` has, and its owner
// and group where the system allows it, if there is such a file, and may be read by nobody else
// before; else what new files have.
File make_file(const std::filesystem::path& path, const std::filesystem::path& replaced);
// A file for writing that may be there already, cut or lengthened to nothing yet.
File open_file(const std::filesystem::path& path);
void keep_permissions(File file, const std::filesystem::path& replaced);
void close_file(File file) noexcept;

// A lock that others see, until the file is closed or the process ends, however it does. It keeps
// nobody from reading or writing.
enum class Lock { taken, of_another, impossible };
Lock lock(File file);
// Whether nobody holds a lock on a file. Where that is not known, no.
bool is_unlocked(const std::filesystem::path& path);

bool write(File file, std::span<const char> bytes);
// Cuts it to so many bytes, and goes to its end.
bool cut(File file, std::uintmax_t bytes);
std::uintmax_t position(File file);
// Brings it to the disk. Some file systems cannot; that counts as done.
bool sync(File file);
// The same for names in a folder. One that may be written but not read cannot be synced; the files
// are there all the same.
bool sync_folder(const std::filesystem::path& folder);

// At once: whoever opens `to` finds the one or the other.
bool replace(const std::filesystem::path& from, const std::filesystem::path& to);
void remove_file(const std::filesystem::path& path) noexcept;

}  // namespace omma::system
