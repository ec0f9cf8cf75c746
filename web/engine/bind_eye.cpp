// Eyes for JavaScript: read from bytes, and their arrays.
#include <emscripten/bind.h>

#include "files.h"
#include "handles.h"
#include "omma/io.h"

namespace omma::web {
namespace {

EyeHandle eye_of_bytes(const std::string& name, const val& bytes, double metres_per_unit) {
  return checked([&] {
    const MemoryFiles files(name, bytes);
    return EyeHandle{std::make_shared<const Eye>(load_eye(files.path(), metres_per_unit))};
  });
}

// The eyes of a head: runs of ommatidia with one eye_id.
val eyes_of(const Eye& eye) {
  val list = val::array();
  for (std::size_t first = 0, end = 0; first < eye.size(); first = end) {
    while (end < eye.size() && eye.eye_id[end] == eye.eye_id[first]) ++end;
    val entry = val::object();
    entry.set("name", std::to_string(eye.eye_id[first]));
    entry.set("first", first);
    entry.set("count", end - first);
    list.call<void>("push", entry);
  }
  return list;
}

val info_of(const EyeHandle& handle) {
  return checked([&] {
    val info = val::object();
    info.set("ommatidia", handle.eye->size());
    info.set("eyes", eyes_of(*handle.eye));
    std::vector<std::string> receptors;
    for (const ReceptorType& type : handle.eye->receptor_types) receptors.push_back(type.name);
    info.set("receptors", list_of(receptors));
    return info;
  });
}

// S of all angles divided by a factor; of functions of sin theta, of all sines. Lens and focal
// length are as many times smaller: a rhabdom then has the same size in the same blur disc, at the
// same f-number, and both lie as many times further apart in angle.
void scale(Acceptance& acceptance, double factor) {
  acceptance.width_rad *= factor;
  acceptance.minor_width_rad *= factor;
  acceptance.facet_diameter_m /= factor;
  acceptance.focal_length_m /= factor;
  if (!acceptance.table) return;
  SensitivityTable table = *acceptance.table;
  for (double& right : table.right_rad) right *= factor;
  for (double& up : table.up_rad) up *= factor;
  acceptance.table = std::make_shared<const SensitivityTable>(std::move(table));
}

// The same eye with all acceptance angles times a factor.
EyeHandle scaled(const EyeHandle& handle, double factor) {
  return checked([&] {
    if (!(factor >= 0.001 && factor <= 1000))
      throw Error("factor: expected a number from 0.001 to 1000, found " + std::to_string(factor));
    Eye eye = *handle.eye;
    for (std::size_t i = 0; i < eye.size(); ++i)
      // Of what has an acceptance of its own validate_eye finds the mean width.
      eye.acceptance_angle_rad[i] *=
          !eye.acceptance_of.empty() && eye.acceptance_of[i] >= 0 ? 0 : static_cast<float>(factor);
    for (Acceptance& own : eye.acceptances) scale(own, factor);
    for (ReceptorType& type : eye.receptor_types)
      if (type.acceptance) scale(*type.acceptance, factor);
    validate_eye(eye);
    return EyeHandle{std::make_shared<const Eye>(std::move(eye))};
  });
}

val axes_of(const EyeHandle& handle) {
  return array_of(handle.eye->axis);
}
val positions_of(const EyeHandle& handle) {
  return array_of(handle.eye->position_m);
}
val acceptances_of(const EyeHandle& handle) {
  return array_of(handle.eye->acceptance_angle_rad);
}

}  // namespace

void bind_eye() {
  emscripten::class_<EyeHandle>("Eye")
      .function("info", &info_of)
      .function("axes", &axes_of)
      .function("positions_m", &positions_of)
      .function("acceptance_rad", &acceptances_of)
      .function("scaled", &scaled);
  emscripten::function("load_eye", &eye_of_bytes);
}

}  // namespace omma::web
