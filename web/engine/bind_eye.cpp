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

// The same eye with all acceptance angles times a factor.
EyeHandle scaled(const EyeHandle& handle, double factor) {
  return checked([&] {
    if (!(factor >= 0 && factor <= 1000))
      throw Error("factor: expected a number from 0 to 1000, found " + std::to_string(factor));
    Eye eye = *handle.eye;
    for (float& angle : eye.acceptance_angle_rad) angle *= static_cast<float>(factor);
    for (Acceptance& own : eye.acceptances) {
      if (own.width_rad == 0)
        throw Error(
            "factor: expected an eye whose acceptances have widths, found lenses or tables, which "
            "have none that could be scaled");
      own.width_rad *= factor;
      own.minor_width_rad *= factor;
    }
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
