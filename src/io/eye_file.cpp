// Eyes from and to files: which format a name stands for, and `.eye` files: one ommatidium a line,
// eight columns. Lengths are in the file's unit and its frame is x right, y up, z forward; ours
// looks along -Z, so the z of positions and axes turns round both ways.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>
#include <system_error>

#include "io/atomic_file.h"
#include "io/decimal_chars.h"
#include "io/eye_csv.h"
#include "io/oces.h"
#include "model/text.h"
#include "model/unit_axis.h"
#include "omma/error.h"
#include "omma/io.h"
#include "system/files.h"

namespace omma {
namespace {

constexpr std::array<const char*, 8> column_names = {
    "position x", "position y", "position z",       "axis x",
    "axis y",     "axis z",     "acceptance angle", "focal offset"};

constexpr const char* old_file_hint =
    " (an old file? \"omma eye convert\" rewrites those of 7 and 9 columns)";

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

// For a message: the text in quotes, short, and without characters that would garble a terminal.
std::string quoted(std::string_view text) {
  constexpr std::size_t most = 24;
  std::string shown = "\"";
  for (const char c : text.substr(0, most)) {
    const bool plain = static_cast<unsigned char>(c) >= 0x20 && c != 0x7f;
    shown += plain ? c : '?';
  }
  return shown + (text.size() > most ? "...\"" : "\"");
}

std::string ending_of(const std::string& path) {
  std::string ending = system::text_of(system::path_of(path).extension());
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return ending;
}

class LineReader {
 public:
  LineReader(const std::string& path, std::size_t line_number, std::string_view line)
      : path_(path), line_number_(line_number), rest_(line) {}

  // The numbers of the line into `values`; false where it is blank or all comment.
  bool read(std::array<double, 8>& values) {
    rest_ = rest_.substr(0, rest_.find('#'));
    skip_blanks();
    if (rest_.empty()) return false;
    for (std::size_t column = 0; column < values.size(); ++column) {
      if (rest_.empty())
        fail(column, "missing: a line has 8 columns, this one " + std::to_string(column) +
                         (column == 7 ? old_file_hint : ""));
      values[column] = read_number(column);
      skip_separator(column);
    }
    if (!rest_.empty())
      fail_at_line("column 9: a line has 8 columns, found more: " + quoted(rest_) + old_file_hint);
    return true;
  }

  [[noreturn]] void fail(std::size_t column, const std::string& what) const {
    fail_at_line("column " + std::to_string(column + 1) + " (" + column_names[column] +
                 "): " + what);
  }

 private:
  [[noreturn]] void fail_at_line(const std::string& what) const {
    throw Error(
        path_ + ", line " + std::to_string(line_number_) + ", " + what +
        (ending_of(path_) == ".eye"
             ? ""
             : "; by its ending it was read as .eye, other formats end in .csv, .gltf or .glb"));
  }

  void skip_blanks() {
    std::size_t n = 0;
    while (n < rest_.size() && is_blank(rest_[n])) ++n;
    rest_.remove_prefix(n);
  }

  // Blanks with at most one comma among them. A comma promises another column.
  void skip_separator(std::size_t column) {
    skip_blanks();
    if (rest_.empty() || rest_.front() != ',') return;
    rest_.remove_prefix(1);
    skip_blanks();
    if (rest_.empty()) {
      if (column + 1 == column_names.size())
        fail_at_line("column 9: a line has 8 columns, found a comma after the last");
      fail(column + 1, "empty, a comma ends the line");
    }
  }

  double read_number(std::size_t column) {
    if (rest_.front() == ',') fail(column, "empty, expected a number");
    std::size_t length = 0;
    while (length < rest_.size() && !is_blank(rest_[length]) && rest_[length] != ',') ++length;
    const std::string_view word = rest_.substr(0, length);
    rest_.remove_prefix(length);
    // from_chars knows no plus sign; two signs stay an error.
    const bool plus = word.front() == '+' && word.size() > 1 && word[1] != '-';
    double value = 0;
    const auto [end, error] =
        omma::from_chars(word.data() + (plus ? 1 : 0), word.data() + word.size(), value);
    if (error == std::errc::result_out_of_range && end == word.data() + word.size())
      fail(column, "the number is out of range: " + quoted(word));
    if (error != std::errc{} || end != word.data() + word.size())
      fail(column, "expected a number, found " + quoted(word));
    if (!std::isfinite(value)) fail(column, "expected a finite number, found " + quoted(word));
    return value;
  }

  const std::string& path_;
  std::size_t line_number_;
  std::string_view rest_;
};

// A length in metres as float, or an error where it leaves float's range.
float metres(const LineReader& line, std::size_t column, double value, double metres_per_unit) {
  const double length_m = value * metres_per_unit;
  if (!(std::fabs(length_m) <= std::numeric_limits<float>::max()))
    line.fail(column, "the length is out of range");
  return static_cast<float>(length_m);
}

void append(Eye& eye, const LineReader& line, const std::array<double, 8>& value,
            double metres_per_unit) {
  const Vec3 position{metres(line, 0, value[0], metres_per_unit),
                      metres(line, 1, value[1], metres_per_unit),
                      metres(line, 2, -value[2], metres_per_unit)};
  const Vec3 axis = unit_axis({value[3], value[4], -value[5]});
  if (!(dot(axis, axis) > 0)) line.fail(3, "the axis (columns 4 to 6) must not be zero");
  // Compared as floats, in which 2 pi is a little more than 2 pi.
  const auto acceptance_rad = static_cast<float>(value[6]);
  if (value[6] < 0 || acceptance_rad > static_cast<float>(2 * pi))
    line.fail(6, "expected an angle from 0 to 2 pi rad, found " + short_text(value[6]));
  if (value[7] < 0) line.fail(7, "expected an offset of at least 0, found " + short_text(value[7]));
  eye.position_m.push_back(position);
  eye.axis.push_back(axis);
  eye.acceptance_angle_rad.push_back(acceptance_rad);
  eye.focal_offset_m.push_back(metres(line, 7, value[7], metres_per_unit));
  eye.eye_id.push_back(0);
}

void check_unit(double metres_per_unit) {
  if (!(metres_per_unit > 0) || !std::isfinite(metres_per_unit))
    throw Error("metres_per_unit must be positive and finite, is " +
                std::to_string(metres_per_unit));
}

}  // namespace

Eye parse_eye(const std::string& text, const std::string& path, double metres_per_unit) {
  check_unit(metres_per_unit);
  Eye eye;
  eye.path = path;
  std::string_view rest = text;
  constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
  if (rest.substr(0, 3) == byte_order_mark) rest.remove_prefix(3);
  // A line of eight numbers has at least 15 characters, so this bounds what a file of newlines
  // asks.
  const auto lines = static_cast<std::size_t>(std::count(rest.begin(), rest.end(), '\n')) + 1;
  const std::size_t most = std::min(lines, rest.size() / 15 + 1);
  eye.position_m.reserve(most);
  eye.axis.reserve(most);
  eye.acceptance_angle_rad.reserve(most);
  eye.focal_offset_m.reserve(most);
  eye.eye_id.reserve(most);

  const std::string& name = path.empty() ? std::string("eye") : path;
  std::array<double, 8> values{};
  for (std::size_t line_number = 1; !rest.empty(); ++line_number) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    LineReader line(name, line_number, rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (line.read(values)) append(eye, line, values, metres_per_unit);
  }
  if (eye.size() == 0) throw Error(name + ": expected at least one ommatidium, found none");
  validate_eye(eye);
  return eye;
}

namespace {

enum class EyeFormat { eye, csv, gltf, glb };

// Of a file that is read: eyes of CompoundRay are called anything.
EyeFormat format_of(const std::string& path) {
  const std::string ending = ending_of(path);
  return ending == ".csv"    ? EyeFormat::csv
         : ending == ".gltf" ? EyeFormat::gltf
         : ending == ".glb"  ? EyeFormat::glb
                             : EyeFormat::eye;
}

std::string eye_file_text(const Eye& eye, double metres_per_unit) {
  std::string text;
  text.reserve(eye.size() * 100);
  for (std::size_t i = 0; i < eye.size(); ++i) {
    const Vec3 position = eye.position_m[i];
    const Vec3 axis = eye.axis[i];
    const std::array<double, 8> values = {position.x / metres_per_unit,
                                          position.y / metres_per_unit,
                                          -position.z / metres_per_unit,
                                          axis.x,
                                          axis.y,
                                          -axis.z,
                                          eye.acceptance_angle_rad[i],
                                          eye.focal_offset_m[i] / metres_per_unit};
    for (std::size_t column = 0; column < values.size(); ++column) {
      // Nine significant digits tell every float from its neighbours. Adding 0 makes -0 plain 0.
      std::array<char, 32> buffer{};
      const auto written = omma::to_chars(buffer.data(), buffer.data() + buffer.size(),
                                    values[column] + 0.0, std::chars_format::general, 9);
      text.append(buffer.data(), written.ptr);
      text += column + 1 < values.size() ? ' ' : '\n';
    }
  }
  return text;
}

// "12 of 60 ommatidia: facet diameters"
template <typename Differs>
void note_loss(std::vector<std::string>& losses, const Eye& eye, const char* what,
               Differs differs) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < eye.size(); ++i) count += differs(i) ? 1 : 0;
  if (count > 0)
    losses.push_back(std::string(what) + " (" + std::to_string(count) + " of " +
                     std::to_string(eye.size()) + " ommatidia)");
}

}  // namespace

std::vector<std::string> eye_file_losses(const std::string& path, const Eye& given) {
  std::vector<std::string> losses;
  if (format_of(path) != EyeFormat::eye) return losses;
  Eye eye = given;
  validate_eye(eye);
  note_loss(losses, eye, "which eye an ommatidium belongs to",
            [&](std::size_t i) { return eye.eye_id[i] != eye.eye_id[0]; });
  note_loss(losses, eye, "up vectors", [&](std::size_t i) {
    const Vec3 up = default_up(eye.axis[i]);
    return up.x != eye.up[i].x || up.y != eye.up[i].y || up.z != eye.up[i].z;
  });
  note_loss(losses, eye, "facet diameters",
            [&](std::size_t i) { return eye.facet_diameter_m[i] != 0; });
  note_loss(losses, eye, "aperture diameters",
            [&](std::size_t i) { return eye.aperture_diameter_m[i] != 0; });
  note_loss(losses, eye,
            "angular sensitivities that are not a round Gaussian of the acceptance angle",
            [&](std::size_t i) {
              Acceptance round;
              round.width_rad = eye.acceptance_angle_rad[i];
              return acceptance_at(eye, i) != round;
            });
  note_loss(losses, eye, "receptors",
            [&](std::size_t i) { return eye.first_receptor[i] != eye.first_receptor[i + 1]; });
  if (!eye.receptor_types.empty() && eye.receptor_type.empty())
    losses.push_back("receptor types (" + std::to_string(eye.receptor_types.size()) + ")");
  for (const EyeColumn& column : eye.columns) losses.push_back("the column '" + column.name + "'");
  return losses;
}

Eye load_eye(const std::string& path, double metres_per_unit) {
  switch (format_of(path)) {
    case EyeFormat::csv:
      check_unit(metres_per_unit);
      return parse_eye_csv(read_file(path), path);
    case EyeFormat::gltf:
    case EyeFormat::glb:
      check_unit(metres_per_unit);
      return parse_oces(read_file(path), path);
    case EyeFormat::eye:
      break;
  }
  return parse_eye(read_file(path), path, metres_per_unit);
}

Eye load_eye_of_head(const std::string& path, const std::string& head) {
  return parse_oces(read_file(path), path, head);
}

std::vector<std::string> eye_file_heads(const std::string& path) {
  return parse_oces_heads(read_file(path), path);
}

void save_eye(const std::string& path, const Eye& eye, double metres_per_unit, bool lossy) {
  check_unit(metres_per_unit);
  if (format_of(path) == EyeFormat::eye && ending_of(path) != ".eye")
    throw Error(path + ": expected a name ending in .csv, .gltf, .glb or .eye");
  Eye checked = eye;
  validate_eye(checked);
  std::string bytes;
  switch (format_of(path)) {
    case EyeFormat::csv:
      bytes = eye_csv_text(checked);
      break;
    case EyeFormat::gltf:
    case EyeFormat::glb:
      try {
        bytes = oces_bytes(checked, format_of(path) == EyeFormat::glb);
      } catch (const Error& error) {
        throw Error(path + ": " + error.what());
      }
      break;
    case EyeFormat::eye:
      if (!lossy) {
        std::string all;
        for (const std::string& loss : eye_file_losses(path, checked))
          all += (all.empty() ? "" : "; ") + loss;
        if (!all.empty())
          throw Error(path + ": an .eye file has no place for " + all +
                      ". Write a .csv, .gltf or .glb file, which keep everything, or say that it "
                      "may be lost (lossy)");
      }
      bytes = eye_file_text(checked, metres_per_unit);
      break;
  }
  write_file_atomically(path, bytes);
}

}  // namespace omma
