// CSV text in and out, and decimal numbers.
#include "io/csv_text.h"

#include <array>
#include <charconv>
#include <system_error>

#include "io/decimal_chars.h"
#include "model/text.h"
#include "omma/error.h"

namespace omma {
namespace {

bool is_blank(char c) {
  return c == ' ' || c == '\t';
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

[[noreturn]] void fail(const std::string& name, std::size_t line, const std::string& what) {
  throw Error(name + ", line " + std::to_string(line) + ": " + what);
}

void check_utf8(std::string_view text, const std::string& name) {
  std::size_t line = 1;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    if (length == 0) fail(name, line, "expected UTF-8 text, found other bytes");
    if (text.front() == '\n') ++line;
    text.remove_prefix(length);
  }
}

// Reads one record at a time off the front of a text.
struct CsvReader {
  const std::string& name;
  std::string_view rest;
  std::size_t line = 1;

  bool at_line_end() const {
    return rest.empty() || rest.front() == '\n' || rest.starts_with("\r\n");
  }
  void skip_line_end() {
    if (rest.starts_with('\r')) rest.remove_prefix(1);
    if (rest.starts_with('\n')) rest.remove_prefix(1);
    ++line;
  }

  CsvCell quoted_cell() {
    const std::size_t begin = line;
    CsvCell cell{"", true};
    rest.remove_prefix(1);
    while (true) {
      if (rest.empty()) fail(name, begin, "a quote opens here that nothing closes");
      const char c = rest.front();
      rest.remove_prefix(1);
      if (c == '\n') ++line;
      if (c != '"') {
        cell.text += c;
      } else if (rest.starts_with('"')) {
        cell.text += c;
        rest.remove_prefix(1);
      } else {
        break;
      }
    }
    while (!rest.empty() && is_blank(rest.front())) rest.remove_prefix(1);
    if (!at_line_end() && rest.front() != ',')
      fail(name, line, "expected a comma after the closing quote, found " + shown_text(rest));
    return cell;
  }

  CsvCell plain_cell() {
    std::size_t size = 0;
    while (size < rest.size() && rest[size] != ',' && rest[size] != '\n') ++size;
    std::string_view text = rest.substr(0, size);
    rest.remove_prefix(size);
    if (text.ends_with('\r') && !rest.starts_with(',')) text.remove_suffix(1);
    return {std::string(trimmed(text)), false};
  }

  CsvRecord record() {
    CsvRecord record{line, {}};
    while (true) {
      while (!rest.empty() && is_blank(rest.front())) rest.remove_prefix(1);
      record.cells.push_back(rest.starts_with('"') ? quoted_cell() : plain_cell());
      if (!rest.starts_with(',')) break;
      rest.remove_prefix(1);
    }
    skip_line_end();
    return record;
  }
};

// The text of a number that is 10 to the power `shift` times the one written; "" where the exponent
// is no number.
std::string shifted(std::string_view text, int shift) {
  if (shift == 0) return std::string(text);
  int exponent = 0;
  const std::size_t e = text.find_first_of("eE");
  if (e != std::string_view::npos) {
    std::string_view digits = text.substr(e + 1);
    if (digits.starts_with('+')) digits.remove_prefix(1);
    const auto [end, error] =
        std::from_chars(digits.data(), digits.data() + digits.size(), exponent);
    if (error != std::errc{} || end != digits.data() + digits.size() || exponent > 100000 ||
        exponent < -100000)
      return "";
  }
  return std::string(text.substr(0, e)) + "e" + std::to_string(exponent + shift);
}

template <typename T>
bool parse(std::string_view text, int shift, T& value) {
  text = trimmed(text);
  // from_chars knows no plus sign; two signs stay an error.
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  const std::string whole = shifted(text, shift);
  const char* last = whole.data() + whole.size();
  const auto [end, error] = omma::from_chars(whole.data(), last, value);
  return error == std::errc{} && end == last && !whole.empty();
}

template <typename T>
std::string shortest(T value, int shift) {
  std::array<char, 40> buffer{};
  const auto written =
      omma::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                     std::chars_format::scientific);
  const std::string_view text(buffer.data(), static_cast<std::size_t>(written.ptr - buffer.data()));
  const std::size_t e = text.find('e');
  if (e == std::string_view::npos) return std::string(text);  // inf, nan
  std::string digits, sign = text.front() == '-' ? "-" : "";
  for (const char c : text.substr(0, e))
    if (c >= '0' && c <= '9') digits += c;
  if (digits == "0") return sign + "0";
  int exponent = 0;
  const std::size_t first = text[e + 1] == '+' ? e + 2 : e + 1;
  std::from_chars(text.data() + first, text.data() + text.size(), exponent);
  exponent += shift;
  const int size = static_cast<int>(digits.size());
  if (exponent < -7 || exponent > 15)
    return sign + digits.substr(0, 1) +
           (size > 1 ? std::string(".").append(digits, 1) : std::string()) + "e" +
           std::to_string(exponent);
  if (exponent < 0)
    return sign + "0." + std::string(static_cast<std::size_t>(-exponent - 1), '0') + digits;
  const auto whole = static_cast<std::size_t>(exponent + 1);
  if (whole >= digits.size()) return sign + digits + std::string(whole - digits.size(), '0');
  return sign + digits.substr(0, whole) + "." + digits.substr(whole);
}

}  // namespace

CsvText parse_csv(std::string_view text, const std::string& name) {
  constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
  if (text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
  check_utf8(text, name);
  CsvText csv;
  CsvReader reader{name, text};
  while (!reader.rest.empty()) {
    if (reader.at_line_end()) {
      reader.skip_line_end();
    } else if (csv.records.empty() && reader.rest.front() == '#') {
      const std::size_t end = std::min(reader.rest.find('\n'), reader.rest.size());
      std::string_view line = reader.rest.substr(1, end - 1);
      reader.rest.remove_prefix(end);
      if (line.ends_with('\r')) line.remove_suffix(1);
      csv.comments.push_back({reader.line, {{std::string(trimmed(line)), false}}});
      reader.skip_line_end();
    } else {
      csv.records.push_back(reader.record());
      const CsvRecord& record = csv.records.back();
      const std::size_t expected = csv.records.front().cells.size();
      if (record.cells.size() != expected)
        fail(name, record.line,
             "expected " + std::to_string(expected) + " cells as in the header, found " +
                 std::to_string(record.cells.size()));
    }
  }
  return csv;
}

std::string csv_cell(std::string_view text, bool always_quoted) {
  const bool plain = !always_quoted && !text.empty() && text.front() != '#' &&
                     text.find_first_of(",\"\r\n") == std::string_view::npos &&
                     !is_blank(text.front()) && !is_blank(text.back());
  if (plain) return std::string(text);
  std::string cell = "\"";
  for (const char c : text) {
    if (c == '"') cell += c;
    cell += c;
  }
  return cell + "\"";
}

std::string decimal_text(double value, int shift) {
  return shortest(value, shift);
}

std::string decimal_text(float value, int shift) {
  return shortest(value, shift);
}

bool parse_decimal(std::string_view text, int shift, double& value) {
  return parse(text, shift, value);
}

bool parse_decimal(std::string_view text, int shift, float& value) {
  return parse(text, shift, value);
}

std::string shown_text(std::string_view text) {
  constexpr std::size_t most = 24;
  std::string shown = "\"";
  std::size_t end = std::min(most, text.size());
  while (end > 0 && end < text.size() && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80)
    --end;  // not cut inside a character
  for (const char c : text.substr(0, end)) {
    const bool plain = static_cast<unsigned char>(c) >= 0x20 && c != 0x7f;
    shown += plain ? c : '?';
  }
  return shown + (end < text.size() ? "...\"" : "\"");
}

}  // namespace omma
