// Eyes as CSV: one ommatidium a line, columns with names that say the unit. The reader takes them
// in any order; docs/eyes.md lists them. What both sides must agree on stands here.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "omma/acceptance.h"
#include "omma/eye.h"

namespace omma {

// From the text of a CSV file; `path` names it in errors.
Eye parse_eye_csv(std::string_view text, const std::string& path);

// The whole eye as the text of a CSV file; reading it gives back the same bits.
std::string eye_csv_text(const Eye& eye);

enum class CsvQuantity { plain, text, length, angle, wavelength };

struct CsvColumnKind {
  const char* name;  // without the unit
  CsvQuantity quantity;
};

// The columns that Omma knows.
extern const std::vector<CsvColumnKind> csv_column_kinds;

// A unit that ends the name of a column: "mm" for lengths in mm, 10^-3 m.
struct CsvUnit {
  const char* name;
  CsvQuantity quantity;
  int shift;     // power of ten to metres, radians or nanometres
  bool degrees;  // to be turned into radians besides
};
extern const std::vector<CsvUnit> csv_units;

// The numbers of an Acceptance and their columns.
struct CsvKernelColumn {
  const char* name;
  double Acceptance::*field;
};
extern const std::vector<CsvKernelColumn> csv_kernel_columns;

// An extra column whose name means something to the reader is written with this ahead of it.
inline constexpr std::string_view csv_extra_prefix = "column:";
bool is_csv_column_known(std::string_view name);

}  // namespace omma
