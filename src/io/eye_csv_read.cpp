// Eyes from CSV text: which column is what, then one ommatidium a line.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <unordered_map>

#include "io/csv_text.h"
#include "io/eye_csv.h"
#include "io/eye_json.h"
#include "model/unit_axis.h"
#include "omma/error.h"
#include "optics/acceptance_hash.h"

namespace omma {
namespace {

using nlohmann::json;

// A column that Omma knows, as a file has it.
struct Found {
  std::size_t cell = 0;  // in each record
  CsvUnit unit{"", CsvQuantity::plain, 0, false};
};

struct Reader {
  std::string name;  // for errors
  CsvText csv;
  std::unordered_map<std::string, Found> found;             // by name without unit
  std::vector<std::pair<std::string, std::size_t>> extras;  // name and cell, in the file's order
  std::unordered_map<std::string, std::shared_ptr<const SensitivityTable>> tables;
  std::unordered_map<std::string, std::size_t> receptor_types;  // by name, the first of a name
  std::unordered_map<std::string, std::int32_t> acceptances;    // index by the text of its cells
  std::unordered_map<Acceptance, std::int32_t, AcceptanceHash> same_acceptances;

  bool has(const std::string& column) const { return found.contains(column); }
};

std::string units_of(const CsvColumnKind& kind) {
  std::string list;
  for (const CsvUnit& unit : csv_units)
    if (unit.quantity == kind.quantity)
      list += (list.empty() ? "" : " or ") + std::string(kind.name) + "_" + unit.name;
  return list;
}

// Suffixes that can only be meant as units, of which a column may know others.
bool looks_like_unit(std::string_view suffix) {
  static const std::vector<std::string_view> names = {
      "nm",     "um",      "mm",    "cm",     "m",      "km",      "in",
      "inch",   "micron",  "deg",   "rad",    "degree", "degrees", "radians",
      "radian", "microns", "metre", "metres", "meter",  "meters"};
  return std::find(names.begin(), names.end(), suffix) != names.end();
}

// Matches the name of a column with those known; false for an extra one.
bool match(const CsvColumnKind& kind, std::string name, const std::string& place, Found& found) {
  const std::string base = kind.name;
  if (kind.quantity == CsvQuantity::plain || kind.quantity == CsvQuantity::text)
    return name == base;
  if (name == base)
    throw Error(place + ": a name says its unit: expected " + units_of(kind) + ", found " + base);
  if (!name.starts_with(base + "_")) return false;
  std::string suffix = name.substr(base.size() + 1);
  if (suffix == "\u00b5m" || suffix == "\u03bcm") suffix = "um";
  for (const CsvUnit& unit : csv_units)
    if (unit.quantity == kind.quantity && suffix == unit.name) {
      found.unit = unit;
      return true;
    }
  if (looks_like_unit(suffix))
    throw Error(place + ": expected " + units_of(kind) + ", found " + shown_text(name));
  return false;
}

// Whether a table's first column has nothing but whole numbers, as labels of its rows are.
bool labels_rows(const CsvText& csv) {
  return std::all_of(csv.records.begin() + 1, csv.records.end(), [](const CsvRecord& record) {
    double label = 0;
    return !record.cells.empty() && parse_decimal(record.cells.front().text, 0, label) &&
           label == std::floor(label);
  });
}

void read_header(Reader& reader) {
  const CsvRecord& header = reader.csv.records.front();
  std::unordered_map<std::string, std::size_t> extras;  // cell by name
  for (std::size_t c = 0; c < header.cells.size(); ++c) {
    const std::string& name = header.cells[c].text;
    const std::string place =
        reader.name + ", line " + std::to_string(header.line) + ", column " + std::to_string(c + 1);
    if (name.empty() && c == 0 && labels_rows(reader.csv)) continue;  // as pandas writes them
    if (name.empty()) throw Error(place + ": expected a name, found none");
    std::string known;
    Found found;
    for (const CsvColumnKind& kind : csv_column_kinds)
      if (match(kind, name, place, found)) known = kind.name;
    if (known.empty()) {
      const bool prefixed = name.starts_with(csv_extra_prefix) && name != csv_extra_prefix;
      const std::string extra = prefixed ? name.substr(csv_extra_prefix.size()) : name;
      const auto [before, is_new] = extras.try_emplace(extra, c);
      if (!is_new)
        throw Error(place + ": " + shown_text(extra) + " is there twice, in column " +
                    std::to_string(before->second + 1) + " too");
      reader.extras.emplace_back(extra, c);
      continue;
    }
    found.cell = c;
    const auto [before, is_new] = reader.found.try_emplace(known, found);
    if (!is_new)
      throw Error(place + ": " + shown_text(known) + " is there twice, in column " +
                  std::to_string(before->second.cell + 1) + " too");
  }
}

void need(const Reader& reader, bool there, const std::string& what,
          const std::string& found = "none") {
  if (there) return;
  throw Error(reader.name + ", line " + std::to_string(reader.csv.records.front().line) +
              ": expected " + what + ", found " + found);
}

void check_columns(const Reader& reader) {
  const auto all = [&](const std::string& name) {
    return reader.has(name + "_x") && reader.has(name + "_y") && reader.has(name + "_z");
  };
  const auto any = [&](const std::string& name) {
    return reader.has(name + "_x") || reader.has(name + "_y") || reader.has(name + "_z");
  };
  const bool angles = reader.has("azimuth") && reader.has("elevation");
  need(reader, all("axis") || angles,
       "columns axis_x, axis_y, axis_z or azimuth_deg, elevation_deg");
  if (any("axis") && (reader.has("azimuth") || reader.has("elevation")))
    throw Error(reader.name +
                ": expected an axis or an azimuth and elevation, found columns of "
                "both");
  need(reader, all("position") || !any("position"), "all of position_x_mm, _y_mm and _z_mm or none",
       "some");
  need(reader, all("up") || !any("up"), "all of up_x, up_y and up_z or none", "some");
  need(reader, reader.has("acceptance_angle") || reader.has("kernel"),
       "a column acceptance_angle_deg (or kernel)");
}

[[noreturn]] void fail(const Reader& reader, const CsvRecord& record, std::size_t cell,
                       const std::string& what) {
  throw Error(reader.name + ", line " + std::to_string(record.line) + ", column " +
              shown_text(reader.csv.records.front().cells[cell].text) + ": " + what);
}

// The text of a cell, "" where the column is not there.
const std::string& cell_text(const Reader& reader, const CsvRecord& record,
                             const std::string& column) {
  static const std::string none;
  const auto found = reader.found.find(column);
  return found == reader.found.end() ? none : record.cells[found->second.cell].text;
}

// A finite number in metres, radians or nanometres; none where the cell is empty or not there.
template <typename T>
std::optional<T> number(const Reader& reader, const CsvRecord& record, const std::string& column) {
  const std::string& text = cell_text(reader, record, column);
  if (text.empty()) return std::nullopt;
  const Found& found = reader.found.at(column);
  T value{};
  bool good = false;
  if (found.unit.degrees) {
    double angle_deg = 0;
    good = parse_decimal(text, 0, angle_deg);
    value = static_cast<T>(angle_deg * degree);
  } else {
    good = parse_decimal(text, found.unit.shift, value);
  }
  if (!good || !std::isfinite(value))
    fail(reader, record, found.cell, "expected a number, found " + shown_text(text));
  return value;
}

template <typename T>
T required(const Reader& reader, const CsvRecord& record, const std::string& column) {
  const std::optional<T> value = number<T>(reader, record, column);
  if (!value) fail(reader, record, reader.found.at(column).cell, "expected a number, found none");
  return *value;
}

Vec3d vector(const Reader& reader, const CsvRecord& record, const std::string& name) {
  return {required<float>(reader, record, name + "_x"),
          required<float>(reader, record, name + "_y"),
          required<float>(reader, record, name + "_z")};
}

Vec3 axis(const Reader& reader, const CsvRecord& record) {
  Vec3 unit;
  if (reader.has("axis_x")) {
    unit = unit_axis(vector(reader, record, "axis"));
    if (!(dot(unit, unit) > 0))
      fail(reader, record, reader.found.at("axis_x").cell, "the axis must not be zero");
  } else {
    const double azimuth = required<double>(reader, record, "azimuth"),
                 elevation = required<double>(reader, record, "elevation");
    // What is a little over by rounding of radians is meant.
    if (std::fabs(elevation) > pi / 2 + 1e-6)
      fail(reader, record, reader.found.at("elevation").cell,
           "expected an elevation of -90 to 90 degrees, found " +
               shown_text(cell_text(reader, record, "elevation")) +
               " (a colatitude, from the pole down, is 90 degrees less the elevation)");
    unit = unit_axis({std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                      -std::cos(azimuth) * std::cos(elevation)});
  }
  return unit;
}

std::int32_t eye_id(const Reader& reader, const CsvRecord& record) {
  const std::string text = cell_text(reader, record, "eye_id");
  if (text.empty()) return 0;
  // With a point too: where some are missing pandas writes 1.0.
  double id = 0;
  if (!parse_decimal(text, 0, id) || !(id >= 0 && id <= INT32_MAX) || id != std::floor(id))
    fail(reader, record, reader.found.at("eye_id").cell,
         "expected a whole number of at least 0, found " + shown_text(text));
  return id;
}

Acceptance kernel(const Reader& reader, const CsvRecord& record, const Eye& eye) {
  Acceptance acceptance;
  const auto place = [&](const char* column) {
    return reader.name + ", line " + std::to_string(record.line) + ", column \"" + column + "\"";
  };
  acceptance.kernel = static_cast<Kernel>(
      index_of_name(acceptance_kernel_names, cell_text(reader, record, "kernel"), place("kernel")));
  const bool has_width = acceptance.kernel == Kernel::gaussian ||
                         acceptance.kernel == Kernel::pillbox ||
                         acceptance.kernel == Kernel::compoundray;
  if (has_width) acceptance.width_rad = static_cast<double>(eye.acceptance_angle_rad.back());
  if (acceptance.kernel == Kernel::airy || acceptance.kernel == Kernel::lens_rhabdom)
    acceptance.facet_diameter_m = static_cast<double>(eye.facet_diameter_m.back());
  for (const CsvKernelColumn& column : csv_kernel_columns)
    if (const auto value = number<double>(reader, record, column.name))
      acceptance.*column.field = *value;
  const std::string model = cell_text(reader, record, "kernel_model");
  if (!model.empty())
    acceptance.model =
        static_cast<RhabdomModel>(index_of_name(rhabdom_model_names, model, place("kernel_model")));
  const std::string table = cell_text(reader, record, "kernel_table");
  if (!table.empty()) {
    const auto found = reader.tables.find(table);
    if (found == reader.tables.end())
      throw Error(place("kernel_table") +
                  ": expected the name of a table in a line \"# kernel_table ...\" ahead of the "
                  "header, found " +
                  shown_text(table));
    acceptance.table = found->second;
  }
  validate_acceptance(acceptance, place("kernel"));
  return acceptance;
}

void add_kernel(Reader& reader, const CsvRecord& record, Eye& eye) {
  if (cell_text(reader, record, "kernel").empty()) {
    // What belongs to an angular sensitivity that is not named would change nothing, unseen.
    for (const auto& [column, found] : reader.found)
      if (column.starts_with("kernel_") && !record.cells[found.cell].text.empty())
        fail(reader, record, found.cell,
             "expected the name of what it belongs to in column \"kernel\", such as gaussian or "
             "airy, found none");
    if (!number<float>(reader, record, "acceptance_angle"))
      throw Error(reader.name + ", line " + std::to_string(record.line) +
                  ": expected an acceptance angle or a kernel, found neither");
    eye.acceptance_of.push_back(-1);
    return;
  }
  std::string key = decimal_text(eye.acceptance_angle_rad.back()) + '\n' +
                    decimal_text(eye.facet_diameter_m.back());
  for (const CsvColumnKind& kind : csv_column_kinds)
    if (std::string_view(kind.name).starts_with("kernel"))
      key += '\n' + cell_text(reader, record, kind.name);
  const auto [known, is_new] = reader.acceptances.try_emplace(key, 0);
  if (is_new) {
    const Acceptance acceptance = kernel(reader, record, eye);
    const auto next = static_cast<std::int32_t>(eye.acceptances.size());
    known->second = reader.same_acceptances.try_emplace(acceptance, next).first->second;
    if (known->second == next) eye.acceptances.push_back(acceptance);
  }
  eye.acceptance_of.push_back(known->second);
}

// "green;green;blue" or "#0;#0;#1".
void add_receptors(const Reader& reader, const CsvRecord& record, Eye& eye) {
  std::string_view rest = cell_text(reader, record, "receptors");
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(';'), rest.size());
    std::string_view name = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    while (name.starts_with(' ')) name.remove_prefix(1);
    while (name.ends_with(' ')) name.remove_suffix(1);
    std::size_t type = 0;
    bool good = false;
    if (name.starts_with('#')) {
      const auto [last, error] = std::from_chars(name.data() + 1, name.data() + name.size(), type);
      good = error == std::errc{} && last == name.data() + name.size() && name.size() > 1 &&
             type < eye.receptor_types.size();
    } else {
      const auto known = reader.receptor_types.find(std::string(name));
      good = known != reader.receptor_types.end();
      if (good) type = known->second;
    }
    if (!good)
      fail(reader, record, reader.found.at("receptors").cell,
           "expected receptor types of the lines \"# receptor_type ...\" ahead of the header (" +
               std::to_string(eye.receptor_types.size()) + "), found " + shown_text(name));
    eye.receptor_type.push_back(static_cast<std::int32_t>(type));
  }
  eye.first_receptor.push_back(static_cast<std::int32_t>(eye.receptor_type.size()));
}

// Lines "# receptor_type {...}" and "# kernel_table "name" {...}"; others are only comments.
void read_comments(Reader& reader, Eye& eye) {
  for (const CsvRecord& comment : reader.csv.comments) {
    std::string_view text = comment.cells.front().text;
    const bool type = text.starts_with("receptor_type "), table = text.starts_with("kernel_table ");
    if (!type && !table) continue;
    const std::string place = reader.name + ", line " + std::to_string(comment.line) + ": " +
                              (type ? "receptor_type" : "kernel_table");
    text.remove_prefix(text.find(' ') + 1);
    std::string name;
    if (table) {
      const std::size_t brace = std::min(text.find('{'), text.size());
      std::string_view given = text.substr(0, brace);
      while (given.ends_with(' ')) given.remove_suffix(1);
      if (given.size() > 1 && given.front() == '"' && given.back() == '"')
        given = given.substr(1, given.size() - 2);
      name = given;
      if (name.empty()) throw Error(place + ": expected a name and an object, found no name");
      text.remove_prefix(brace);
    }
    const json object = json::parse(text, nullptr, false);
    if (object.is_discarded()) throw Error(place + ": expected a JSON object, found other text");
    if (type) {
      eye.receptor_types.push_back(read_receptor_type(object, place));
      validate_receptor_type(eye.receptor_types.back(), place);
      reader.receptor_types.emplace(eye.receptor_types.back().name, eye.receptor_types.size() - 1);
    } else if (!reader.tables
                    .try_emplace(
                        name, std::make_shared<const SensitivityTable>(read_table(object, place)))
                    .second) {
      throw Error(place + ": the name " + shown_text(name) + " is there twice");
    }
  }
}

// Numbers where all cells are, or empty, and none is quoted; else texts.
EyeColumn extra_column(const Reader& reader, const std::string& name, std::size_t cell) {
  EyeColumn column{name, {}, {}};
  const auto& records = reader.csv.records;
  bool any = false, numbers = true;
  for (std::size_t r = 1; r < records.size() && numbers; ++r) {
    const CsvCell& value = records[r].cells[cell];
    double read = std::nan("");
    numbers = !value.quoted && (value.text.empty() || parse_decimal(value.text, 0, read));
    any = any || !value.text.empty();
    column.numbers.push_back(read);
  }
  if (numbers && any) return column;
  column.numbers.clear();
  for (std::size_t r = 1; r < records.size(); ++r)
    column.texts.push_back(records[r].cells[cell].text);
  return column;
}

}  // namespace

bool is_csv_column_known(std::string_view name) {
  if (name.starts_with(csv_extra_prefix)) return true;
  Found ignored;
  for (const CsvColumnKind& kind : csv_column_kinds) {
    try {
      if (match(kind, std::string(name), "", ignored)) return true;
    } catch (const Error&) {
      return true;
    }
  }
  return false;
}

Eye parse_eye_csv(std::string_view text, const std::string& path) {
  Eye eye;
  eye.path = path;
  Reader reader;
  reader.name = path.empty() ? "eye" : path;
  reader.csv = parse_csv(text, reader.name);
  if (reader.csv.records.empty()) throw Error(reader.name + ": expected a header, found none");
  read_header(reader);
  check_columns(reader);
  read_comments(reader, eye);
  const auto& records = reader.csv.records;
  if (records.size() == 1)
    throw Error(reader.name + ": expected at least one ommatidium, found none");
  const auto optional = [&](const CsvRecord& record, const char* column) {
    const auto value = number<float>(reader, record, column);
    if (value && *value < 0)
      fail(reader, record, reader.found.at(column).cell,
           "expected a number of at least 0, found " +
               shown_text(cell_text(reader, record, column)));
    return value.value_or(0.0f);
  };
  eye.first_receptor.push_back(0);
  for (std::size_t r = 1; r < records.size(); ++r) {
    const CsvRecord& record = records[r];
    eye.position_m.push_back(reader.has("position_x") ? to_float(vector(reader, record, "position"))
                                                      : Vec3{});
    eye.axis.push_back(axis(reader, record));
    eye.up.push_back(reader.has("up_x") ? to_float(vector(reader, record, "up")) : Vec3{});
    eye.acceptance_angle_rad.push_back(optional(record, "acceptance_angle"));
    eye.focal_offset_m.push_back(optional(record, "focal_offset"));
    eye.facet_diameter_m.push_back(optional(record, "facet_diameter"));
    eye.aperture_diameter_m.push_back(optional(record, "aperture_diameter"));
    eye.eye_id.push_back(eye_id(reader, record));
    add_kernel(reader, record, eye);
    add_receptors(reader, record, eye);
  }
  for (const auto& [name, cell] : reader.extras)
    eye.columns.push_back(extra_column(reader, name, cell));
  validate_eye(eye);
  return eye;
}

}  // namespace omma
