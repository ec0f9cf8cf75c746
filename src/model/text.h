// Text as people and other programs are to see it: valid UTF-8 without control characters.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace omma {

// Bytes of the UTF-8 character that begins `text` (RFC 3629), which is not empty; 0 where none
// does.
std::size_t utf8_length(std::string_view text);

// The same text with control characters, and bytes that are no UTF-8, written as \n, \t, \xNN: a
// name that a file gives itself can say anything, to a terminal too.
std::string readable_text(std::string_view text);

// The same text with a file shown by its name alone: what is shown on pages is seen on other
// machines than the one with the file's folder.
std::string without_folder(std::string text, const std::string& path);

// A number of at most six digits, for messages.
std::string short_text(double value);

}  // namespace omma
