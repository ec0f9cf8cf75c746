// Inverses, and transforms from their parts and back.
#include "model/transform.h"

#include <algorithm>
#include <cmath>

namespace omma {

Mat4 inverse(const Mat4& t) {
  const double det = determinant(t);
  Mat4 inverse;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) {
      const int r1 = (c + 1) % 3, r2 = (c + 2) % 3, c1 = (r + 1) % 3, c2 = (r + 2) % 3;
      inverse.m[r][c] = (t.m[r1][c1] * t.m[r2][c2] - t.m[r1][c2] * t.m[r2][c1]) / det;
    }
  const Vec3d moved = transform_vector(inverse, {t.m[0][3], t.m[1][3], t.m[2][3]});
  inverse.m[0][3] = -moved.x, inverse.m[1][3] = -moved.y, inverse.m[2][3] = -moved.z;
  return inverse;
}

Mat4 transform_of(const std::array<double, 3>& translation_m, const std::array<double, 4>& rotation,
                  const std::array<double, 3>& scale) {
  const auto [x, y, z, w] = rotation;
  const double turned[3][3] = {
      {1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
      {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
      {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
  Mat4 t;
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) t.m[r][c] = turned[r][c] * scale[c];
    t.m[r][3] = translation_m[r];
  }
  return t;
}

// Columns made orthogonal by Gram and Schmidt; the quaternion by its largest component (Shepperd 1978,
// J Guidance and Control 1:223).
std::array<double, 4> turn_of(const Mat4& t) {
  const auto column = [&](int c) { return Vec3d{t.m[0][c], t.m[1][c], t.m[2][c]}; };
  const Vec3d x = normalize(column(0));
  const Vec3d y = normalize(column(1) - x * dot(column(1), x));
  const Vec3d z = cross(x, y);
  std::array<double, 4> q{x.x - y.y - z.z, y.y - x.x - z.z, z.z - x.x - y.y, x.x + y.y + z.z};
  const auto largest = std::max_element(q.begin(), q.end()) - q.begin();
  const double s = 2 * std::sqrt(std::max(0.0, 1 + q[static_cast<std::size_t>(largest)]));
  if (largest == 0) q = {s / 4, (x.y + y.x) / s, (z.x + x.z) / s, (y.z - z.y) / s};
  if (largest == 1) q = {(x.y + y.x) / s, s / 4, (y.z + z.y) / s, (z.x - x.z) / s};
  if (largest == 2) q = {(z.x + x.z) / s, (y.z + z.y) / s, s / 4, (x.y - y.x) / s};
  if (largest == 3) q = {(y.z - z.y) / s, (z.x - x.z) / s, (x.y - y.x) / s, s / 4};
  return q;
}

// (Shoemake 1985, doi:10.1145/325334.325242.)
std::array<double, 4> slerp(const double* from, const double* to, double part) {
  double cosine = 0;
  for (int i = 0; i < 4; ++i) cosine += from[i] * to[i];
  const double sign = cosine < 0 ? -1 : 1;
  const double angle = std::acos(std::min(std::fabs(cosine), 1.0)), sine = std::sin(angle);
  // Below, the chord is the arc to double precision.
  const bool is_close = sine < 1e-8;
  const double first = is_close ? 1 - part : std::sin((1 - part) * angle) / sine;
  const double second = sign * (is_close ? part : std::sin(part * angle) / sine);
  std::array<double, 4> between;
  for (std::size_t i = 0; i < 4; ++i) between[i] = first * from[i] + second * to[i];
  return between;
}

}  // namespace omma
