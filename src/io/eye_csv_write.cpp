// An eye as CSV text. Lengths are written with their decimal point moved, which loses nothing;
// angles in degrees where reading those gives back the same bits, else in radians.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <unordered_set>

#include "io/csv_text.h"
#include "io/decimal_chars.h"
#include "io/eye_csv.h"
#include "io/eye_json.h"

namespace omma {

const std::vector<CsvColumnKind> csv_column_kinds = {
    {"position_x", CsvQuantity::length},
    {"position_y", CsvQuantity::length},
    {"position_z", CsvQuantity::length},
    {"axis_x", CsvQuantity::plain},
    {"axis_y", CsvQuantity::plain},
    {"axis_z", CsvQuantity::plain},
    {"azimuth", CsvQuantity::angle},
    {"elevation", CsvQuantity::angle},
    {"acceptance_angle", CsvQuantity::angle},
    {"focal_offset", CsvQuantity::length},
    {"eye_id", CsvQuantity::plain},
    {"up_x", CsvQuantity::plain},
    {"up_y", CsvQuantity::plain},
    {"up_z", CsvQuantity::plain},
    {"facet_diameter", CsvQuantity::length},
    {"aperture_diameter", CsvQuantity::length},
    {"kernel", CsvQuantity::text},
    {"kernel_width", CsvQuantity::angle},
    {"kernel_minor_width", CsvQuantity::angle},
    {"kernel_major_angle", CsvQuantity::angle},
    {"kernel_facet_diameter", CsvQuantity::length},
    {"kernel_wavelength", CsvQuantity::wavelength},
    {"kernel_model", CsvQuantity::text},
    {"kernel_focal_length", CsvQuantity::length},
    {"kernel_rhabdom_diameter", CsvQuantity::length},
    {"kernel_rhabdom_index", CsvQuantity::plain},
    {"kernel_surround_index", CsvQuantity::plain},
    {"kernel_table", CsvQuantity::text},
    {"receptors", CsvQuantity::text},
};

const std::vector<CsvUnit> csv_units = {
    {"um", CsvQuantity::length, -6, false}, {"mm", CsvQuantity::length, -3, false},
    {"m", CsvQuantity::length, 0, false},   {"deg", CsvQuantity::angle, 0, true},
    {"rad", CsvQuantity::angle, 0, false},  {"nm", CsvQuantity::wavelength, 0, false},
};

const std::vector<CsvKernelColumn> csv_kernel_columns = {
    {"kernel_width", &Acceptance::width_rad},
    {"kernel_minor_width", &Acceptance::minor_width_rad},
    {"kernel_major_angle", &Acceptance::major_angle_rad},
    {"kernel_facet_diameter", &Acceptance::facet_diameter_m},
    {"kernel_wavelength", &Acceptance::wavelength_nm},
    {"kernel_focal_length", &Acceptance::focal_length_m},
    {"kernel_rhabdom_diameter", &Acceptance::rhabdom_diameter_m},
    {"kernel_rhabdom_index", &Acceptance::rhabdom_index},
    {"kernel_surround_index", &Acceptance::surround_index},
};

namespace {

using Cells = std::vector<std::string>;  // [ommatidium]

CsvQuantity quantity_of(const std::string& name) {
  return std::find_if(csv_column_kinds.begin(), csv_column_kinds.end(),
                      [&](const CsvColumnKind& kind) { return kind.name == name; })
      ->quantity;
}

// The shortest text in degrees that reads as this angle; "" where there is none.
template <typename T>
std::string degrees_text(T angle_rad) {
  for (int digits = 4; digits <= 17; ++digits) {
    std::array<char, 40> buffer{};
    const auto written =
        omma::to_chars(buffer.data(), buffer.data() + buffer.size(),
                 static_cast<double>(angle_rad) / degree, std::chars_format::general, digits);
    std::string text(buffer.data(), written.ptr);
    double read = 0;
    const T back = parse_decimal(text, 0, read) ? static_cast<T>(read * degree) : T{};
    if (back == angle_rad && std::signbit(back) == std::signbit(angle_rad)) return text;
  }
  return "";
}

struct Writer {
  std::size_t count;
  std::vector<std::string> headers;
  std::vector<Cells> columns;

  void add(const std::string& header, Cells cells) {
    headers.push_back(header);
    columns.push_back(std::move(cells));
  }

  // A column of numbers `value(i)` where `there(i)`; left out where none is there.
  template <typename Value, typename There>
  void numbers(const std::string& name, Value value, There there) {
    const CsvQuantity quantity = quantity_of(name);
    Cells cells(count);
    const auto fill = [&](auto text) {
      for (std::size_t i = 0; i < count; ++i)
        if (there(i)) {
          cells[i] = text(value(i));
          if (cells[i].empty()) return false;
        }
      return true;
    };
    std::string unit;
    if (quantity == CsvQuantity::length) {
      const bool position = name.starts_with("position");
      unit = position ? "_mm" : "_um";
      fill([&](auto v) { return decimal_text(v, position ? 3 : 6); });
    } else if (quantity == CsvQuantity::angle) {
      unit = "_deg";
      if (!fill([](auto v) { return degrees_text(v); })) {
        unit = "_rad";
        fill([](auto v) { return decimal_text(v); });
      }
    } else {
      unit = quantity == CsvQuantity::wavelength ? "_nm" : "";
      fill([](auto v) { return decimal_text(v); });
    }
    if (std::any_of(cells.begin(), cells.end(), [](const auto& cell) { return !cell.empty(); }))
      add(name + unit, std::move(cells));
  }
};

constexpr auto always = [](std::size_t) { return true; };

void add_vectors(Writer& writer, const std::string& name, const std::vector<Vec3>& vectors) {
  writer.numbers(
      name + "_x", [&](std::size_t i) { return vectors[i].x; }, always);
  writer.numbers(
      name + "_y", [&](std::size_t i) { return vectors[i].y; }, always);
  writer.numbers(
      name + "_z", [&](std::size_t i) { return vectors[i].z; }, always);
}

// Kernels with their parameters, and a comment line for each table.
void add_kernels(Writer& writer, const Eye& eye, std::string& comments) {
  if (eye.acceptances.empty()) return;
  std::map<const SensitivityTable*, std::string> table_names;
  for (const Acceptance& acceptance : eye.acceptances) {
    if (!acceptance.table) continue;
    const auto [found, is_new] = table_names.try_emplace(acceptance.table.get());
    if (!is_new) continue;
    found->second = "table-" + std::to_string(table_names.size());
    comments += "# kernel_table " + csv_cell(found->second, true) + " " +
                table_json(*acceptance.table).dump() + "\n";
  }
  const auto kernel = [&](std::size_t i) {
    const std::int32_t which = eye.acceptance_of[i];
    return which < 0 ? nullptr : &eye.acceptances[static_cast<std::size_t>(which)];
  };
  const auto texts = [&](const char* name, auto text) {
    Cells cells(eye.size());
    for (std::size_t i = 0; i < eye.size(); ++i)
      if (kernel(i)) cells[i] = text(*kernel(i));
    if (std::any_of(cells.begin(), cells.end(), [](const auto& cell) { return !cell.empty(); }))
      writer.add(name, std::move(cells));
  };
  texts("kernel", [](const Acceptance& a) {
    return acceptance_kernel_names[static_cast<std::size_t>(a.kernel)];
  });
  for (const CsvKernelColumn& column : csv_kernel_columns) {
    // A width is always written: where it is left out the acceptance angle takes its place, as the
    // facet diameter does that of the kernel.
    const bool width = column.field == &Acceptance::width_rad,
               facet = column.field == &Acceptance::facet_diameter_m;
    writer.numbers(
        column.name, [&](std::size_t i) { return kernel(i)->*column.field; },
        [&](std::size_t i) {
          const Acceptance* a = kernel(i);
          return a && (width || facet || a->*column.field != Acceptance{}.*column.field);
        });
  }
  texts("kernel_model", [](const Acceptance& a) {
    return a.model == Acceptance{}.model ? ""
                                         : rhabdom_model_names[static_cast<std::size_t>(a.model)];
  });
  texts("kernel_table", [&](const Acceptance& a) {
    return a.table ? csv_cell(table_names[a.table.get()]) : std::string();
  });
}

// Types by name where names tell them apart, else by number: "#0".
void add_receptors(Writer& writer, const Eye& eye, std::string& comments) {
  std::vector<std::string> names;
  std::unordered_set<std::string> distinct;
  bool by_name = true;
  for (const ReceptorType& type : eye.receptor_types) {
    comments += "# receptor_type " + receptor_type_json(type).dump() + "\n";
    by_name = by_name && !type.name.empty() && type.name.front() != '#' &&
              type.name.find_first_of("; \t\r\n") == std::string::npos &&
              distinct.insert(type.name).second;
    names.push_back(type.name);
  }
  if (eye.receptor_type.empty()) return;
  Cells cells(eye.size());
  for (std::size_t i = 0; i < eye.size(); ++i) {
    std::string receptors;
    for (std::int32_t r = eye.first_receptor[i]; r < eye.first_receptor[i + 1]; ++r) {
      const auto type = static_cast<std::size_t>(eye.receptor_type[static_cast<std::size_t>(r)]);
      if (!receptors.empty()) receptors += ';';
      if (!by_name) receptors += '#';
      receptors += by_name ? names[type] : std::to_string(type);
    }
    if (!receptors.empty()) cells[i] = csv_cell(receptors);
  }
  writer.add("receptors", std::move(cells));
}

void add_extra_columns(Writer& writer, const Eye& eye) {
  for (const EyeColumn& column : eye.columns) {
    Cells cells(eye.size());
    for (std::size_t i = 0; i < eye.size(); ++i)
      cells[i] =
          column.texts.empty() ? decimal_text(column.numbers[i]) : csv_cell(column.texts[i], true);
    const bool known = is_csv_column_known(column.name);
    writer.add(csv_cell((known ? std::string(csv_extra_prefix) : "") + column.name),
               std::move(cells));
  }
}

}  // namespace

std::string eye_csv_text(const Eye& given) {
  Eye eye = given;
  validate_eye(eye);
  std::string text =
      "# Omma eye: a line for each ommatidium, in the head's frame: x right, y up, looking along "
      "-z\n";
  Writer writer{eye.size(), {}, {}};
  const auto not_zero = [&](const std::vector<float>& values) {
    return [&](std::size_t i) { return values[i] != 0 || std::signbit(values[i]); };
  };
  const auto value_of = [](const std::vector<float>& values) {
    return [&](std::size_t i) { return values[i]; };
  };
  add_vectors(writer, "position", eye.position_m);
  add_vectors(writer, "axis", eye.axis);
  writer.numbers("acceptance_angle", value_of(eye.acceptance_angle_rad), always);
  writer.numbers("focal_offset", value_of(eye.focal_offset_m), not_zero(eye.focal_offset_m));
  writer.numbers(
      "eye_id", [&](std::size_t i) { return static_cast<double>(eye.eye_id[i]); }, always);
  bool plain_up = true;
  for (std::size_t i = 0; i < eye.size() && plain_up; ++i) {
    const Vec3 up = default_up(eye.axis[i]);
    plain_up = up.x == eye.up[i].x && up.y == eye.up[i].y && up.z == eye.up[i].z;
  }
  if (!plain_up) add_vectors(writer, "up", eye.up);
  writer.numbers("facet_diameter", value_of(eye.facet_diameter_m), not_zero(eye.facet_diameter_m));
  writer.numbers("aperture_diameter", value_of(eye.aperture_diameter_m),
                 not_zero(eye.aperture_diameter_m));
  add_kernels(writer, eye, text);
  add_receptors(writer, eye, text);
  add_extra_columns(writer, eye);

  const auto line = [&](auto cell) {
    for (std::size_t c = 0; c < writer.columns.size(); ++c)
      text.append(c == 0 ? "" : ",").append(cell(c));
    text += '\n';
  };
  line([&](std::size_t c) -> const std::string& { return writer.headers[c]; });
  for (std::size_t i = 0; i < eye.size(); ++i)
    line([&](std::size_t c) -> const std::string& { return writer.columns[c][i]; });
  return text;
}

}  // namespace omma
