// Takes the arguments of omma.Eye: numbers for all ommatidia or arrays, lists of sensitivities and
// receptors, dictionaries of columns.
#include "eye_arguments.h"

#include <nanobind/stl/string.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_map>
#include <vector>

#include "arrays.h"
#include "omma/error.h"
#include "optics/acceptance_hash.h"
#include "progress.h"

namespace omma::python {
namespace {

constexpr const char* known_names[] = {"position_m",
                                       "axis",
                                       "acceptance_angle_rad",
                                       "focal_offset_m",
                                       "eye_id",
                                       "up",
                                       "facet_diameter_m",
                                       "aperture_diameter_m",
                                       "acceptance",
                                       "receptor_types",
                                       "receptors",
                                       "columns",
                                       "path"};

// A number for all ommatidia, or an array [ommatidium].
std::vector<float> per_ommatidium(nb::handle values, const char* name, std::int64_t count) {
  if (is_truth(values))
    throw Error(std::string(name) + ": expected a number or numbers, found bool");
  if (nb::isinstance<nb::float_>(values) || nb::isinstance<nb::int_>(values))
    return std::vector<float>(static_cast<std::size_t>(count), nb::cast<float>(values));
  const auto array = float_array(values, name, {count});
  return {array.data(), array.data() + count};
}

std::vector<Vec3> vectors(const InputArray<float>& array) {
  std::vector<Vec3> result(array.shape(0));
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] = {array.data()[3 * i], array.data()[3 * i + 1], array.data()[3 * i + 2]};
  return result;
}

bool is_list(nb::handle value) {
  return nb::isinstance<nb::sequence>(value) && !nb::isinstance<nb::str>(value);
}

// One Acceptance for all, or a list of as many as there are ommatidia; None stands for a round
// Gaussian of the ommatidium's acceptance angle.
void set_acceptances(Eye& eye, nb::handle value, bool angles_given) {
  eye.acceptances.clear();
  eye.acceptance_of.assign(eye.size(), -1);
  eye.acceptance_angle_rad.resize(eye.size(), 0.0f);
  if (value.is_none()) return;
  const auto set = [&](std::size_t i, std::int32_t which) {
    eye.acceptance_of[i] = which;
    eye.acceptance_angle_rad[i] = 0;  // found when the eye is checked
  };
  const auto refuse = [](const std::string& where, nb::handle found) {
    throw Error("acceptance" + where + ": expected an omma.Acceptance or None, found " +
                type_name_of(found));
  };
  if (nb::isinstance<Acceptance>(value)) {
    eye.acceptances.push_back(nb::cast<const Acceptance&>(value));
    for (std::size_t i = 0; i < eye.size(); ++i) set(i, 0);
    return;
  }
  if (!is_list(value)) refuse("", value);
  if (nb::len(value) != eye.size())
    throw Error("acceptance: expected one for all, or as many as there are ommatidia (" +
                std::to_string(eye.size()) + "), found " + std::to_string(nb::len(value)));
  std::unordered_map<Acceptance, std::int32_t, AcceptanceHash> seen;
  std::size_t i = 0;
  for (nb::handle item : nb::iter(value)) {
    if (item.is_none()) {
      if (!angles_given && eye.acceptance_angle_rad[i] == 0)
        throw Error("acceptance[" + std::to_string(i) +
                    "]: None needs an acceptance_angle_rad, found neither");
    } else {
      if (!nb::isinstance<Acceptance>(item)) refuse("[" + std::to_string(i) + "]", item);
      const auto& acceptance = nb::cast<const Acceptance&>(item);
      const auto next = static_cast<std::int32_t>(eye.acceptances.size());
      const auto [place, is_new] = seen.try_emplace(acceptance, next);
      if (is_new) eye.acceptances.push_back(acceptance);
      set(i, place->second);
    }
    ++i;
  }
}

std::vector<ReceptorType> receptor_types(nb::handle value) {
  std::vector<ReceptorType> types;
  if (value.is_none()) return types;
  if (!is_list(value))
    throw Error("receptor_types: expected a list of omma.receptors.ReceptorType, found " +
                type_name_of(value));
  for (nb::handle item : nb::iter(value)) {
    if (!nb::isinstance<ReceptorType>(item))
      throw Error("receptor_types[" + std::to_string(types.size()) +
                  "]: expected an omma.receptors.ReceptorType, found " + type_name_of(item));
    types.push_back(nb::cast<const ReceptorType&>(item));
  }
  return types;
}

// Indices of types: one list for all ommatidia, or a list of lists.
void set_receptors(Eye& eye, nb::handle value) {
  eye.first_receptor.assign(1, 0);
  eye.receptor_type.clear();
  if (value.is_none()) {
    eye.first_receptor.clear();
    return;
  }
  const auto types_of = [](nb::handle list, const std::string& name) -> std::vector<std::int32_t> {
    // NumPy makes floats of an empty list.
    if (nb::hasattr(list, "__len__") && nb::len(list) == 0) return {};
    const auto array = int_array(list, name.c_str(), {-1});
    return {array.data(), array.data() + array.shape(0)};
  };
  const auto add = [&](const std::vector<std::int32_t>& types) {
    eye.receptor_type.insert(eye.receptor_type.end(), types.begin(), types.end());
    eye.first_receptor.push_back(static_cast<std::int32_t>(eye.receptor_type.size()));
  };
  if (!nb::isinstance<nb::sequence>(value))
    throw Error(
        "receptors: expected a list of indices into receptor_types, or one such list for "
        "each ommatidium, found " +
        type_name_of(value));
  const bool lists = nb::len(value) > 0 && nb::hasattr(value[0], "__len__");
  if (!lists) {
    const auto types = types_of(value, "receptors");
    for (std::size_t i = 0; i < eye.size(); ++i) add(types);
    return;
  }
  if (nb::len(value) != eye.size())
    throw Error("receptors: expected a list for each ommatidium (" + std::to_string(eye.size()) +
                "), found " + std::to_string(nb::len(value)));
  std::size_t i = 0;
  for (nb::handle item : nb::iter(value))
    add(types_of(item, "receptors[" + std::to_string(i++) + "]"));
}

std::vector<EyeColumn> columns(nb::handle value, std::int64_t count) {
  std::vector<EyeColumn> all;
  if (value.is_none()) return all;
  if (!nb::isinstance<nb::dict>(value))
    throw Error("columns: expected a dictionary from names to values, found " +
                type_name_of(value));
  for (const auto& [key, values] : nb::cast<nb::dict>(value)) {
    EyeColumn column{str_of(key), {}, {}};
    // NumPy's arrays of texts come apart into texts too.
    const bool text = nb::isinstance<nb::sequence>(values) && nb::len(values) > 0 &&
                      nb::isinstance<nb::str>(nb::object(values[0]));
    const std::string name = "columns['" + column.name + "']";
    if (text) {
      for (nb::handle item : nb::iter(values)) {
        if (!nb::isinstance<nb::str>(item))
          throw Error(name + ": expected texts alone, found " + type_name_of(item));
        column.texts.push_back(str_of(item));
      }
    } else {
      const auto array = double_array(values, name.c_str(), {count});
      column.numbers.assign(array.data(), array.data() + count);
    }
    all.push_back(std::move(column));
  }
  return all;
}

// Whether no up vector has been set: all are what an eye with these axes has by itself.
bool has_default_up(const Eye& eye) {
  constexpr float rounding = 1e-6f;  // of unit vectors in single precision, that files keep too
  for (std::size_t i = 0; i < eye.size(); ++i) {
    const Vec3 up = eye.up[i], expected = default_up(eye.axis[i]);
    if (std::fabs(up.x - expected.x) > rounding || std::fabs(up.y - expected.y) > rounding ||
        std::fabs(up.z - expected.z) > rounding)
      return false;
  }
  return true;
}

}  // namespace

void change_eye(Eye& eye, const nb::kwargs& changes) {
  for (const auto& [key, value] : changes) {
    const std::string name = str_of(key);
    if (std::none_of(std::begin(known_names), std::end(known_names),
                     [&](const char* known) { return name == known; }))
      throw nb::type_error(("omma.Eye has no property '" + name + "'").c_str());
  }
  const auto given = [&](const char* name) { return changes.contains(name); };
  if (given("axis")) {
    std::vector<Vec3> axis = vectors(float_array(changes["axis"], "axis", {-1, 3}));
    if (!eye.axis.empty() && axis.size() != eye.size())
      throw Error("axis: expected shape (" + std::to_string(eye.size()) + ", 3), found (" +
                  std::to_string(axis.size()) + ", 3)");
    const bool follows = has_default_up(eye);
    eye.axis = std::move(axis);
    if (follows) eye.up.clear();  // made anew when the eye is validated
  }
  const auto count = static_cast<std::int64_t>(eye.size());
  if (given("position_m") && changes["position_m"].is_none())
    throw Error("position_m: expected numbers of shape (" + std::to_string(count) +
                ", 3), in metres, found None; zeros where all ommatidia look from one place");
  if (given("position_m"))
    eye.position_m = vectors(float_array(changes["position_m"], "position_m", {count, 3}));
  if (given("acceptance_angle_rad")) {
    eye.acceptance_angle_rad =
        per_ommatidium(changes["acceptance_angle_rad"], "acceptance_angle_rad", count);
    eye.acceptances.clear();
    eye.acceptance_of.clear();
  }
  if (given("acceptance"))
    set_acceptances(eye, changes["acceptance"], given("acceptance_angle_rad"));
  const auto set_lengths = [&](const char* name, std::vector<float>& values) {
    if (given(name)) values = per_ommatidium(changes[name], name, count);
  };
  set_lengths("focal_offset_m", eye.focal_offset_m);
  set_lengths("facet_diameter_m", eye.facet_diameter_m);
  set_lengths("aperture_diameter_m", eye.aperture_diameter_m);
  if (given("eye_id")) {
    if (nb::isinstance<nb::int_>(changes["eye_id"])) {
      eye.eye_id.assign(eye.size(), nb::cast<std::int32_t>(changes["eye_id"]));
    } else {
      const auto ids = int_array(changes["eye_id"], "eye_id", {count});
      eye.eye_id.assign(ids.data(), ids.data() + count);
    }
  }
  if (given("up")) {
    eye.up.clear();
    if (!changes["up"].is_none()) eye.up = vectors(float_array(changes["up"], "up", {count, 3}));
  }
  if (given("receptor_types")) eye.receptor_types = receptor_types(changes["receptor_types"]);
  if (given("receptors")) set_receptors(eye, changes["receptors"]);
  if (given("columns")) eye.columns = columns(changes["columns"], count);
  if (given("path")) eye.path = path_text(changes["path"]);
  run_long_work([&] { validate_eye(eye); });
}

}  // namespace omma::python
