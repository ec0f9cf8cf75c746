// Files of Windows: see files.h. Handles of its own instead of descriptors, as only they can be
// opened so that a file may be renamed while it is open.
#define WIN32_LEAN_AND_MEAN
#define NOMINMAX
#include <windows.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <string_view>
#include <vector>

#include "system/files.h"

namespace omma::system {
namespace {

namespace fs = std::filesystem;

constexpr DWORD for_all = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE;

HANDLE handle(File file) {
  return reinterpret_cast<HANDLE>(file);
}

// Calls `fill(buffer, size)`, which says how much room it wants, until that is there.
template <typename Fill>
std::wstring filled(const Fill& fill) {
  std::wstring text(MAX_PATH, L'\0');
  for (;;) {
    const DWORD size = fill(text.data(), static_cast<DWORD>(text.size()));
    const bool fits = size < text.size();
    text.resize(size);
    if (fits) return text;
  }
}

// Absolute and without dots; nothing where the system refuses.
std::wstring full_path(const fs::path& path) {
  return filled([&](wchar_t* buffer, DWORD size) {
    return GetFullPathNameW(path.c_str(), size, buffer, nullptr);
  });
}

// Who may do what with a file, as a descriptor; empty where there is none.
std::vector<std::byte> permissions(const fs::path& path) {
  const fs::path name = reachable(path);
  DWORD size = 0;
  GetFileSecurityW(name.c_str(), DACL_SECURITY_INFORMATION, nullptr, 0, &size);
  std::vector<std::byte> found(size);
  if (!GetFileSecurityW(name.c_str(), DACL_SECURITY_INFORMATION, found.data(), size, &size))
    found.clear();
  return found;
}

HANDLE open(const fs::path& path, DWORD access, DWORD how, std::vector<std::byte> like = {},
            DWORD flags = FILE_ATTRIBUTE_NORMAL) {
  SECURITY_ATTRIBUTES security{sizeof(SECURITY_ATTRIBUTES), like.empty() ? nullptr : like.data(),
                               FALSE};
  return CreateFileW(reachable(path).c_str(), access, for_all, &security, how, flags, nullptr);
}

}  // namespace

fs::path path_of(const std::string& text) {
  return std::u8string(text.begin(), text.end());
}

std::string text_of(const fs::path& path) {
  const std::u8string text = path.u8string();
  return {text.begin(), text.end()};
}

fs::path reachable(const fs::path& path) {
  constexpr std::size_t longest = 247;  // of a folder; a file's may have 259
  const std::wstring full = full_path(path);
  if (full.size() <= longest || full.starts_with(LR"(\\?\)")) return path;
  if (full.starts_with(LR"(\\)")) return LR"(\\?\UNC\)" + full.substr(2);
  return LR"(\\?\)" + full;
}

fs::path resolved(const fs::path& path, std::error_code& error) {
  error.clear();
  fs::path rest;
  for (fs::path begin = full_path(path);; begin = begin.parent_path()) {
    const HANDLE found = open(begin, 0, OPEN_EXISTING, {}, FILE_FLAG_BACKUP_SEMANTICS);
    if (found != INVALID_HANDLE_VALUE) {
      std::wstring whole = filled([&](wchar_t* buffer, DWORD size) {
        return GetFinalPathNameByHandleW(found, buffer, size, FILE_NAME_NORMALIZED);
      });
      CloseHandle(found);
      constexpr std::wstring_view network = LR"(\\?\UNC\)", local = LR"(\\?\)";
      if (whole.starts_with(network))
        whole.replace(0, network.size(), LR"(\\)");
      else if (whole.starts_with(local))
        whole.erase(0, local.size());
      if (!whole.empty()) return rest.empty() ? fs::path(whole) : whole / rest;
    }
    const DWORD why = GetLastError();
    const bool missing = why == ERROR_FILE_NOT_FOUND || why == ERROR_PATH_NOT_FOUND;
    if (!missing || !begin.has_relative_path()) {
      error.assign(static_cast<int>(why), std::system_category());
      return {};
    }
    rest = rest.empty() ? begin.filename() : begin.filename() / rest;
  }
}

// A link that leads to nothing is taken for a file, and replaced.
fs::path link_target(const fs::path& path) {
  const DWORD found = GetFileAttributesW(reachable(path).c_str());
  if (found == INVALID_FILE_ATTRIBUTES || (found & FILE_ATTRIBUTE_REPARSE_POINT) == 0) return path;
  std::error_code error;
  const fs::path target = resolved(path, error);
  return error ? path : target;
}

std::vector<fs::path> names_in(const fs::path& folder) {
  std::vector<fs::path> names;
  WIN32_FIND_DATAW entry;
  // What the folder's own name asks for need not be what the longer one does, which begins at 248.
  const fs::path all = reachable(folder / fs::path("any")).parent_path() / "*";
  const HANDLE found = FindFirstFileW(all.c_str(), &entry);
  if (found == INVALID_HANDLE_VALUE) return names;
  do {
    const std::wstring_view name = entry.cFileName;
    if (name != L"." && name != L"..") names.emplace_back(name);
  } while (FindNextFileW(found, &entry));
  FindClose(found);
  return names;
}

std::string reason() {
  const DWORD code = GetLastError();
  if (code == 0) return "unknown error";
  constexpr DWORD how = FORMAT_MESSAGE_FROM_SYSTEM | FORMAT_MESSAGE_IGNORE_INSERTS;
  wchar_t text[512];
  DWORD size = 0;
  for (const DWORD language : {DWORD{MAKELANGID(LANG_ENGLISH, SUBLANG_ENGLISH_US)}, DWORD{0}})
    if (size == 0) size = FormatMessageW(how, nullptr, code, language, text, 512, nullptr);
  while (size > 0 && (text[size - 1] <= L' ' || text[size - 1] == L'.')) --size;
  return size > 0 ? text_of(std::wstring(text, size)) : "error " + std::to_string(code);
}

File make_file(const fs::path& path, const fs::path& replaced) {
  return reinterpret_cast<File>(
      open(path, GENERIC_READ | GENERIC_WRITE, CREATE_NEW, permissions(replaced)));
}

File open_file(const fs::path& path) {
  return reinterpret_cast<File>(open(path, GENERIC_READ | GENERIC_WRITE | WRITE_DAC, OPEN_ALWAYS));
}

void keep_permissions(File file, const fs::path& replaced) {
  std::vector<std::byte> old = permissions(replaced);
  if (!old.empty()) SetKernelObjectSecurity(handle(file), DACL_SECURITY_INFORMATION, old.data());
}

void close_file(File file) noexcept {
  CloseHandle(handle(file));
}

// Locks of Windows keep others from what is locked: this is of a byte far behind every end.
Lock lock(File file) {
  OVERLAPPED where{};
  where.OffsetHigh = 0x7fffffff;
  if (LockFileEx(handle(file), LOCKFILE_EXCLUSIVE_LOCK | LOCKFILE_FAIL_IMMEDIATELY, 0, 1, 0,
                 &where))
    return Lock::taken;
  const DWORD why = GetLastError();
  const bool held = why == ERROR_LOCK_VIOLATION || why == ERROR_IO_PENDING;
  return held ? Lock::of_another : Lock::impossible;
}

bool is_unlocked(const fs::path& path) {
  const HANDLE file = open(path, GENERIC_READ, OPEN_EXISTING);
  if (file == INVALID_HANDLE_VALUE) return false;
  const bool free = lock(reinterpret_cast<File>(file)) == Lock::taken;
  CloseHandle(file);
  return free;
}

bool write(File file, std::span<const char> bytes) {
  constexpr std::size_t most = std::size_t{1} << 30;
  while (!bytes.empty()) {
    DWORD count = 0;
    if (!WriteFile(handle(file), bytes.data(), static_cast<DWORD>(std::min(bytes.size(), most)),
                   &count, nullptr))
      return false;
    bytes = bytes.subspan(count);
  }
  return true;
}

bool cut(File file, std::uintmax_t bytes) {
  LARGE_INTEGER end;
  end.QuadPart = static_cast<LONGLONG>(bytes);
  return SetFilePointerEx(handle(file), end, nullptr, FILE_BEGIN) && SetEndOfFile(handle(file));
}

std::uintmax_t position(File file) {
  LARGE_INTEGER at{};
  SetFilePointerEx(handle(file), at, &at, FILE_CURRENT);
  return static_cast<std::uintmax_t>(at.QuadPart);
}

bool sync(File file) {
  if (FlushFileBuffers(handle(file))) return true;
  const DWORD why = GetLastError();
  return why == ERROR_INVALID_FUNCTION || why == ERROR_NOT_SUPPORTED;
}

// Windows brings names to the disk as `replace` asks for it.
bool sync_folder(const fs::path&) {
  return true;
}

// Not ReplaceFile, which takes several steps and may be left between them.
bool replace(const fs::path& from, const fs::path& to) {
  return MoveFileExW(reachable(from).c_str(), reachable(to).c_str(),
                     MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH);
}

void remove_file(const fs::path& path) noexcept {
  try {
    DeleteFileW(reachable(path).c_str());
  } catch (const std::exception&) {  // no memory for the name: it stays, as after a killed run
  }
}

}  // namespace omma::system
