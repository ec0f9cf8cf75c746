// Inverses, and transforms from their parts.
#include "model/transform.h"

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

}  // namespace omma
