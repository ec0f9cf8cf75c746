// CSV as RFC 4180 has it, with comment lines ahead of the header, and numbers as decimal text that
// may be in another unit than the number in memory, to the last bit. Nothing here knows eyes.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace omma {

struct CsvCell {
  std::string text;
  bool quoted = false;  // in the file; blanks around a text count only then
};

struct CsvRecord {
  std::size_t line = 0;  // where it begins, counted from 1
  std::vector<CsvCell> cells;
};

struct CsvText {
  std::vector<CsvRecord> comments;  // lines that begin with '#', one cell each, without the '#'
  std::vector<CsvRecord> records;   // the first is the header; all as long as it
};

// Throws omma::Error naming `name` and the line where quotes do not match, a record is longer or
// shorter than the header, or the text is not UTF-8. Empty lines are passed over.
CsvText parse_csv(std::string_view text, const std::string& name);

// A cell for a file: quoted where it must be, or always.
std::string csv_cell(std::string_view text, bool always_quoted = false);

// The shortest decimal text that is exactly this number times 10 to the power `shift`.
std::string decimal_text(double value, int shift = 0);
std::string decimal_text(float value, int shift = 0);

// The number nearest to the one written, times 10 to the power `shift`; false where it is no number
// or out of range. Infinities and nan are numbers where there is no shift.
bool parse_decimal(std::string_view text, int shift, double& value);
bool parse_decimal(std::string_view text, int shift, float& value);

// For messages: in quotes, short, on one line.
std::string shown_text(std::string_view text);

}  // namespace omma
