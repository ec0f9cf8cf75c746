// Lays out an Eye for the hot loops.
#include "backend/eye_arrays.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "model/curve_order.h"
#include "physics/rays/replicates.h"

namespace omma {

namespace {

// Along the curve, in each eye of a population by itself.
std::vector<std::uint32_t> order_of(const Eye& eye, const std::vector<std::int32_t>& number) {
  std::vector<std::uint32_t> order = order_along_curve(eye);
  std::vector<std::uint32_t> first(eye.size());  // where the eye of an ommatidium begins
  std::uint32_t start = 0;
  for (std::uint32_t i = 0; i < first.size(); ++i) {
    if (number[i] == 0) start = i;
    first[i] = start;
  }
  std::vector<std::uint32_t> next = first, sorted(order.size());
  for (const std::uint32_t i : order) sorted[next[first[i]]++] = i;
  return sorted;
}

}  // namespace

EyeArrays make_eye_arrays(const Eye& eye, const DirectionTables& directions,
                          const std::vector<std::int32_t>& eye_sizes) {
  EyeArrays a;
  a.has_scales = !directions.scale_of.empty();
  const std::vector<std::int32_t> number = numbers_in_eyes(eye.size(), eye_sizes);
  for (const std::uint32_t i : order_of(eye, number)) {
    const Vec3d axis = to_double(eye.axis[i]);
    const Vec3d origin =
        to_double(eye.position_m[i]) - axis * static_cast<double>(eye.focal_offset_m[i]);
    const auto push = [](Vec3 v, auto& x, auto& y, auto& z) {
      x.push_back(v.x);
      y.push_back(v.y);
      z.push_back(v.z);
    };
    const double along[3] = {origin.x, origin.y, origin.z};
    for (int k = 0; k < 3; ++k)
      a.most_origin_m[k] = std::max(a.most_origin_m[k], std::fabs(along[k]));
    a.most_offset_m = std::max({a.most_offset_m, static_cast<double>(eye.focal_offset_m[i]),
                                0.5 * static_cast<double>(eye.aperture_diameter_m[i])});
    push(to_float(origin), a.origin_x, a.origin_y, a.origin_z);
    push(to_float(axis), a.axis_x, a.axis_y, a.axis_z);
    push(eye.up[i], a.up_x, a.up_y, a.up_z);
    a.focal_offset_m.push_back(eye.focal_offset_m[i]);
    a.aperture_radius_m.push_back(0.5f * eye.aperture_diameter_m[i]);
    a.scale.push_back(directions.scale_of.empty() ? 1.0f : directions.scale_of[i]);
    a.has_apertures = a.has_apertures || eye.aperture_diameter_m[i] > 0;
    a.warp.push_back(static_cast<std::int32_t>(directions.warp_of[i]));
    a.ommatidium.push_back(static_cast<std::int32_t>(i));
    a.number.push_back(number[i]);
  }
  for (std::vector<float>* values :
       {&a.origin_x, &a.origin_y, &a.origin_z, &a.axis_x, &a.axis_y, &a.axis_z, &a.up_x, &a.up_y,
        &a.up_z, &a.focal_offset_m, &a.aperture_radius_m, &a.scale})
    values->resize(values->size() + zeros_behind, 0.0f);
  a.warp.resize(a.warp.size() + zeros_behind, 0);
  a.ommatidium.resize(a.ommatidium.size() + zeros_behind, 0);
  a.number.resize(a.number.size() + zeros_behind, 0);
  return a;
}

EyeView view(const EyeArrays& a) {
  return {{a.origin_x.data(), a.origin_y.data(), a.origin_z.data()},
          {a.axis_x.data(), a.axis_y.data(), a.axis_z.data()},
          {a.up_x.data(), a.up_y.data(), a.up_z.data()},
          a.focal_offset_m.data(),
          a.aperture_radius_m.data(),
          a.scale.data(),
          a.warp.data(),
          a.ommatidium.data(),
          a.number.data(),
          a.has_apertures,
          a.has_scales,
          static_cast<std::int32_t>(a.size()),
          a.version};
}

int ommatidia_that_hear(std::size_t ommatidia) {
  const auto last_of = [&](int block) {
    const std::size_t left = ommatidia % static_cast<std::size_t>(block);
    return left == 0 ? static_cast<std::size_t>(block) : left;
  };
  int best = most_per_block;
  for (int block = most_per_block; block >= most_per_block / 2; --block)
    if (last_of(block) > last_of(best)) best = block;
  return best;
}

std::vector<std::uint8_t> nearest_in_blocks(const EyeArrays& eye, int block) {
  const std::size_t size = eye.size();
  std::vector<std::uint8_t> nearest;
  nearest.reserve(size * listened_to);
  std::vector<std::pair<float, std::uint8_t>> others;  // minus the cosine of the angle, place
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t first = i - i % static_cast<std::size_t>(block);
    const std::size_t count = std::min(static_cast<std::size_t>(block), size - first);
    others.clear();
    for (std::size_t k = first; k < first + count; ++k) {
      const float cosine = eye.axis_x[i] * eye.axis_x[k] + eye.axis_y[i] * eye.axis_y[k] +
                           eye.axis_z[i] * eye.axis_z[k];
      if (k != i) others.emplace_back(-cosine, static_cast<std::uint8_t>(k - first));
    }
    const std::size_t heard = std::min(others.size(), std::size_t{listened_to});
    std::partial_sort(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(heard),
                      others.end());
    for (std::size_t k = 0; k < listened_to; ++k)
      nearest.push_back(k < heard ? others[k].second : static_cast<std::uint8_t>(i - first));
  }
  return nearest;
}

}  // namespace omma
