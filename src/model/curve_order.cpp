// The unit sphere unfolded into a square (octahedral map: Meyer et al. 2010, "On floating-point
// normal vectors"), walked along a Hilbert curve.
#include "model/curve_order.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace omma {
namespace {

constexpr std::uint32_t grid = 1u << 15;

// Index along the Hilbert curve through a grid x grid square (Hilbert 1891), one quadrant a step.
std::uint32_t hilbert_index(std::uint32_t x, std::uint32_t y) {
  std::uint32_t index = 0;
  for (std::uint32_t s = grid / 2; s > 0; s /= 2) {
    const bool right = (x & s) != 0, upper = (y & s) != 0;
    index = 4 * index + (upper ? (right ? 2u : 1u) : (right ? 3u : 0u));
    if (!upper) {
      if (right) {
        x = grid - 1 - x;
        y = grid - 1 - y;
      }
      std::swap(x, y);
    }
  }
  return index;
}

std::uint32_t curve_index(Vec3 axis) {
  const float norm = std::fabs(axis.x) + std::fabs(axis.y) + std::fabs(axis.z);
  float u = axis.x / norm, v = axis.z / norm;
  if (axis.y < 0) {
    const float folded_u = (1 - std::fabs(v)) * (u < 0 ? -1.0f : 1.0f);
    v = (1 - std::fabs(u)) * (v < 0 ? -1.0f : 1.0f);
    u = folded_u;
  }
  const auto cell = [](float t) {
    return static_cast<std::uint32_t>(std::clamp(0.5f * (t + 1), 0.0f, 1.0f) * (grid - 1));
  };
  return hilbert_index(cell(u), cell(v));
}

}  // namespace

std::vector<std::uint32_t> order_along_curve(const Eye& eye) {
  std::vector<std::uint32_t> index(eye.size());
  for (std::size_t i = 0; i < eye.size(); ++i) index[i] = curve_index(eye.axis[i]);
  std::vector<std::uint32_t> order(eye.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::tuple(eye.eye_id[a], index[a], a) < std::tuple(eye.eye_id[b], index[b], b);
  });
  return order;
}

}  // namespace omma
