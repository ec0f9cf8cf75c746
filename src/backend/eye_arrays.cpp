// Lays out an Eye for the hot loops.
#include "backend/eye_arrays.h"

#include "model/curve_order.h"

namespace omma {

EyeArrays make_eye_arrays(const Eye& eye, const DirectionTables& directions) {
  EyeArrays a;
  a.has_scales = !directions.scale_of.empty();
  for (const std::uint32_t i : order_along_curve(eye)) {
    const Vec3d axis = to_double(eye.axis[i]);
    const Vec3d origin =
        to_double(eye.position_m[i]) - axis * static_cast<double>(eye.focal_offset_m[i]);
    const auto push = [](Vec3 v, auto& x, auto& y, auto& z) {
      x.push_back(v.x);
      y.push_back(v.y);
      z.push_back(v.z);
    };
    push(to_float(origin), a.origin_x, a.origin_y, a.origin_z);
    push(to_float(axis), a.axis_x, a.axis_y, a.axis_z);
    push(eye.up[i], a.up_x, a.up_y, a.up_z);
    a.focal_offset_m.push_back(eye.focal_offset_m[i]);
    a.aperture_radius_m.push_back(0.5f * eye.aperture_diameter_m[i]);
    a.scale.push_back(directions.scale_of.empty() ? 1.0f : directions.scale_of[i]);
    a.has_apertures = a.has_apertures || eye.aperture_diameter_m[i] > 0;
    a.warp.push_back(static_cast<std::int32_t>(directions.warp_of[i]));
    a.ommatidium.push_back(static_cast<std::int32_t>(i));
  }
  for (std::vector<float>* values :
       {&a.origin_x, &a.origin_y, &a.origin_z, &a.axis_x, &a.axis_y, &a.axis_z, &a.up_x, &a.up_y,
        &a.up_z, &a.focal_offset_m, &a.aperture_radius_m, &a.scale})
    values->resize(values->size() + 16, 0.0f);
  a.warp.resize(a.warp.size() + 16, 0);
  a.ommatidium.resize(a.ommatidium.size() + 16, 0);
  return a;
}

}  // namespace omma
