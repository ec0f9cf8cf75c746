// Poses checked: finite, invertible, and no stretch that single precision cannot follow.
#include "model/pose_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace omma {
namespace {

// Axes are made unit vectors after a pose has stretched them: the squares of these are floats.
constexpr double least_stretch = 1e-15, greatest_stretch = 1e15;
// Axis and up vector must stay apart in single precision: they come as near as the stretches
// differ.
constexpr double most_anisotropy = 1e5;

std::string text(double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.3g", value);
  return digits;
}

}  // namespace

double most_stretch(const Mat4& pose) {
  double largest = 0, squares = 0;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) largest = std::max(largest, std::fabs(pose.m[r][c]));
  for (int r = 0; r < 3 && largest > 0; ++r)
    for (int c = 0; c < 3; ++c) squares += (pose.m[r][c] / largest) * (pose.m[r][c] / largest);
  return largest * std::sqrt(squares);
}

std::string pose_fault(const Mat4& pose) {
  constexpr const char* expected =
      "expected a finite, invertible 4x4 transform with last row 0 0 0 1";
  bool good = pose.m[3][0] == 0 && pose.m[3][1] == 0 && pose.m[3][2] == 0 && pose.m[3][3] == 1;
  for (const auto& row : pose.m)
    for (const double value : row) good = good && std::isfinite(value);
  if (!good) {
    std::string found = ", found rows";
    for (const auto& row : pose.m) {
      found += found.back() == 's' ? " " : ", ";
      for (const double value : row) found += (&value == row ? "" : " ") + text(value);
    }
    return expected + found;
  }
  // Singular values lie between 1 / |inverse| and |transform| (Frobenius norms), of the transform
  // scaled to 1 so that nothing overflows.
  const double most = most_stretch(pose);
  if (!(most > 0)) return std::string(expected) + ", found a scale of 0";
  Vec3d column[3];
  for (int c = 0; c < 3; ++c)
    column[c] = {pose.m[0][c] / most, pose.m[1][c] / most, pose.m[2][c] / most};
  double cofactors = 0;
  for (int c = 0; c < 3; ++c) {
    const Vec3d v = cross(column[(c + 1) % 3], column[(c + 2) % 3]);
    cofactors += dot(v, v);
  }
  const double volume = std::fabs(dot(column[0], cross(column[1], column[2])));
  const double least = cofactors > 0 ? volume / std::sqrt(cofactors) : 0;  // of `most`
  if (!(least >= 1 / most_anisotropy))
    return std::string(expected) + " that stretches at most " + text(most_anisotropy) +
           " times as much in one direction as in another, found " +
           (least > 0 ? text(1 / least) : std::string("one without an inverse"));
  if (most > greatest_stretch || least * most < least_stretch)
    return std::string(expected) + " that stretches by " + text(least_stretch) + " to " +
           text(greatest_stretch) + ", found " + text(least * most) + " to " + text(most);
  return "";
}

}  // namespace omma
