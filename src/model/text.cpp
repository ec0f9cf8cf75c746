// Readable text, and the errors that are made of it.
#include "model/text.h"

#include <cstdint>
#include <cstdio>

#include "omma/error.h"
#include "system/files.h"

namespace omma {

Error::Error(const std::string& message) : std::runtime_error(readable_text(message)) {}

std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (byte(0) < 0x80) return 1;
  const std::size_t length = byte(0) >= 0xF0 ? 4 : byte(0) >= 0xE0 ? 3 : 2;
  if (byte(0) < 0xC2 || byte(0) > 0xF4 || text.size() < length) return 0;
  std::uint32_t code = byte(0) & (0x7Fu >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return 0;
    code = code << 6 | (byte(i) & 0x3Fu);
  }
  const bool overlong = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
  return overlong || (code >= 0xD800 && code < 0xE000) || code > 0x10FFFF ? 0 : length;
}

std::string readable_text(std::string_view text) {
  constexpr const char* digits = "0123456789abcdef";
  std::string readable;
  readable.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const auto byte = static_cast<unsigned char>(text[0]);
    // C0, delete, and C1 (U+0080 to U+009F), which terminals obey too.
    const bool control =
        byte < 0x20 || byte == 0x7f ||
        (byte == 0xc2 && length == 2 && static_cast<unsigned char>(text[1]) < 0xa0);
    const std::size_t count = length == 0 ? 1 : length;
    if (byte == '\n' || byte == '\t') {
      readable += byte == '\n' ? "\\n" : "\\t";
    } else if (length == 0 || control) {
      for (const char each : text.substr(0, count)) {
        const auto value = static_cast<unsigned char>(each);
        readable += {'\\', 'x', digits[value >> 4], digits[value & 15]};
      }
    } else {
      readable += text.substr(0, count);
    }
    text.remove_prefix(count);
  }
  return readable;
}

std::string without_folder(std::string text, const std::string& path) {
  const std::size_t folder = path.find_last_of(system::separators) + 1;
  if (folder == 0) return text;
  const std::string name = path.substr(folder);
  for (std::size_t at = text.find(path); at != std::string::npos; at = text.find(path, at))
    text.replace(at, path.size(), name);
  return text;
}

std::string short_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

}  // namespace omma
