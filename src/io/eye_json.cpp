// Angular sensitivities and receptor types as JSON.
#include "io/eye_json.h"

#include <algorithm>
#include <functional>

#include "io/csv_text.h"
#include "omma/error.h"

namespace omma {

using nlohmann::json;

const std::vector<std::string> acceptance_kernel_names = {"gaussian", "pillbox",      "compoundray",
                                                          "airy",     "lens_rhabdom", "table"};
const std::vector<std::string> rhabdom_model_names = {"waveguide", "geometric", "snyder"};

namespace {

// One member of a JSON object: how it is written (null: left out) and read.
template <typename T>
struct Member {
  std::string name;
  std::function<json(const T&)> write;
  std::function<void(T&, const json&, const std::string& place)> read;
};

[[noreturn]] void fail(const std::string& place, const char* expected, const json& found) {
  throw Error(place + ": expected " + expected + ", found " +
              shown_text(found.dump(-1, ' ', true)));
}

template <typename T>
Member<T> number(const char* name, double T::*field) {
  return {name, [field](const T& t) { return t.*field == T{}.*field ? json() : json(t.*field); },
          [field](T& t, const json& value, const std::string& place) {
            if (!value.is_number()) fail(place, "a number", value);
            t.*field = value.get<double>();
          }};
}

template <typename T>
Member<T> numbers(const char* name, std::vector<double> T::*field) {
  return {name, [field](const T& t) { return (t.*field).empty() ? json() : json(t.*field); },
          [field](T& t, const json& value, const std::string& place) {
            if (!value.is_array()) fail(place, "an array of numbers", value);
            for (const json& element : value) {
              if (!element.is_number()) fail(place, "an array of numbers", element);
              (t.*field).push_back(element.get<double>());
            }
          }};
}

template <typename T>
Member<T> text(const char* name, std::string T::*field) {
  return {name, [field](const T& t) { return (t.*field).empty() ? json() : json(t.*field); },
          [field](T& t, const json& value, const std::string& place) {
            if (!value.is_string()) fail(place, "a text", value);
            t.*field = value.get<std::string>();
          }};
}

template <typename T, typename Choice>
Member<T> choice(const char* name, Choice T::*field, const std::vector<std::string>& names) {
  return {name,
          [field, &names](const T& t) {
            return t.*field == T{}.*field ? json()
                                          : json(names[static_cast<std::size_t>(t.*field)]);
          },
          [field, &names](T& t, const json& value, const std::string& place) {
            if (!value.is_string()) fail(place, "a text", value);
            t.*field = static_cast<Choice>(index_of_name(names, value.get<std::string>(), place));
          }};
}

template <typename T>
json write(const std::vector<Member<T>>& members, const T& object) {
  json written = json::object();
  for (const Member<T>& member : members) {
    json value = member.write(object);
    if (!value.is_null()) written[member.name] = std::move(value);
  }
  return written;
}

template <typename T>
T read(const std::vector<Member<T>>& members, const json& object, const std::string& place) {
  if (!object.is_object()) fail(place, "an object", object);
  T result;
  for (const auto& item : object.items()) {
    const auto member = std::find_if(members.begin(), members.end(),
                                     [&](const Member<T>& m) { return m.name == item.key(); });
    if (member == members.end()) throw Error(place + ": has no member " + shown_text(item.key()));
    member->read(result, item.value(), place + "." + item.key());
  }
  return result;
}

const std::vector<Member<SensitivityTable>>& table_members() {
  static const std::vector<Member<SensitivityTable>> members = {
      text("path", &SensitivityTable::path), numbers("right_rad", &SensitivityTable::right_rad),
      numbers("up_rad", &SensitivityTable::up_rad),
      numbers("sensitivity", &SensitivityTable::sensitivity)};
  return members;
}

const std::vector<Member<Acceptance>>& acceptance_members() {
  static const std::vector<Member<Acceptance>> members = {
      choice("kernel", &Acceptance::kernel, acceptance_kernel_names),
      number("width_rad", &Acceptance::width_rad),
      number("minor_width_rad", &Acceptance::minor_width_rad),
      number("major_angle_rad", &Acceptance::major_angle_rad),
      number("facet_diameter_m", &Acceptance::facet_diameter_m),
      number("wavelength_nm", &Acceptance::wavelength_nm),
      choice("model", &Acceptance::model, rhabdom_model_names),
      number("focal_length_m", &Acceptance::focal_length_m),
      number("rhabdom_diameter_m", &Acceptance::rhabdom_diameter_m),
      number("rhabdom_index", &Acceptance::rhabdom_index),
      number("surround_index", &Acceptance::surround_index),
      {"table", [](const Acceptance& a) { return a.table ? table_json(*a.table) : json(); },
       [](Acceptance& a, const json& value, const std::string& place) {
         a.table = std::make_shared<const SensitivityTable>(read_table(value, place));
       }}};
  return members;
}

const std::vector<Member<ReceptorType>>& receptor_members() {
  static const std::vector<Member<ReceptorType>> members = {
      text("name", &ReceptorType::name),
      number("peak_wavelength_nm", &ReceptorType::peak_wavelength_nm),
      numbers("wavelength_nm", &ReceptorType::wavelength_nm),
      numbers("sensitivity", &ReceptorType::sensitivity),
      number("microvillus_angle_rad", &ReceptorType::microvillus_angle_rad),
      number("polarisation_sensitivity", &ReceptorType::polarisation_sensitivity),
      number("absorption_per_m", &ReceptorType::absorption_per_m),
      number("length_m", &ReceptorType::length_m),
      number("right_rad", &ReceptorType::right_rad),
      number("up_rad", &ReceptorType::up_rad),
      {"acceptance",
       [](const ReceptorType& t) { return t.acceptance ? acceptance_json(*t.acceptance) : json(); },
       [](ReceptorType& t, const json& value, const std::string& place) {
         t.acceptance = read_acceptance(value, place);
       }}};
  return members;
}

}  // namespace

json table_json(const SensitivityTable& table) {
  return write(table_members(), table);
}

json acceptance_json(const Acceptance& acceptance) {
  return write(acceptance_members(), acceptance);
}

json receptor_type_json(const ReceptorType& type) {
  return write(receptor_members(), type);
}

SensitivityTable read_table(const json& object, const std::string& place) {
  return read(table_members(), object, place);
}

Acceptance read_acceptance(const json& object, const std::string& place) {
  return read(acceptance_members(), object, place);
}

ReceptorType read_receptor_type(const json& object, const std::string& place) {
  return read(receptor_members(), object, place);
}

std::size_t index_of_name(const std::vector<std::string>& names, const std::string& name,
                          const std::string& place) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  std::string all;
  for (const std::string& known : names) all += (all.empty() ? "" : ", ") + known;
  throw Error(place + ": expected one of " + all + ", found " + shown_text(name));
}

}  // namespace omma
