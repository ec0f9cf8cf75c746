// Rows that several warps have in common are stored once. Those with fewer intervals than others
// get more: a piece of a cubic is the same cubic.
#include "sampling/polar_tables.h"

#include <algorithm>
#include <map>

namespace omma {
namespace {

void append_row(std::vector<float>& polar, const double* theta, const double* dtheta, int intervals,
                int wanted) {
  const int pieces = wanted / intervals;
  for (int i = 0; i <= wanted; ++i) {
    const int k = std::min(i / pieces, intervals - 1);
    const double t = static_cast<double>(i - k * pieces) / pieces;
    const double slope = 6 * t * (t - 1) * (theta[k] - theta[k + 1]) +
                         (3 * t * t - 4 * t + 1) * dtheta[k] + (3 * t * t - 2 * t) * dtheta[k + 1];
    polar.push_back(
        static_cast<float>(hermite(theta[k], dtheta[k], theta[k + 1], dtheta[k + 1], t)));
    polar.push_back(static_cast<float>(slope / pieces));
  }
}

}  // namespace

PolarTables make_polar_tables(std::span<const AcceptanceWarp> warps) {
  PolarTables tables;
  tables.intervals = 1;
  bool round = true;
  for (const AcceptanceWarp& warp : warps) {
    if (warp.rows != nullptr) tables.intervals = std::max(tables.intervals, warp.rows->intervals);
    round = round && warp.azimuth.empty();
  }
  const std::size_t stride = 2 * (static_cast<std::size_t>(tables.intervals) + 1);
  if (!round)  // the azimuths of all round ones: as they are, from the first row
    for (int i = 0; i <= AcceptanceWarpView::azimuths; ++i) {
      tables.azimuth.push_back(static_cast<float>(2 * pi * i / AcceptanceWarpView::azimuths));
      tables.azimuth.push_back(0.0f);
    }
  std::map<const WarpRows*, std::int32_t> known;
  for (const AcceptanceWarp& warp : warps) {
    const auto row = static_cast<std::int32_t>(tables.polar.size() / stride);
    const auto [place, is_new] = known.try_emplace(round ? nullptr : warp.rows.get(), row);
    if (!round) {
      tables.first_row.push_back(place->second);
      tables.azimuth_begin.push_back(
          warp.azimuth.empty() ? 0 : static_cast<std::int32_t>(tables.azimuth.size()));
      for (const double x : warp.azimuth) tables.azimuth.push_back(static_cast<float>(x));
      if (!is_new) continue;
    }
    if (warp.rows == nullptr) {
      tables.polar.resize(tables.polar.size() + stride, 0.0f);
      continue;
    }
    const WarpRows& rows = *warp.rows;
    const std::size_t knots = static_cast<std::size_t>(rows.intervals) + 1;
    for (std::size_t begin = 0; begin < rows.theta.size(); begin += knots)
      append_row(tables.polar, rows.theta.data() + begin, rows.dtheta.data() + begin,
                 rows.intervals, tables.intervals);
  }
  // A second row is read behind the last.
  if (!round) tables.polar.resize(tables.polar.size() + stride, 0.0f);
  return tables;
}

PolarTablesView view(const PolarTables& tables) {
  const std::size_t row = 2 * (static_cast<std::size_t>(tables.intervals) + 1);
  constexpr std::size_t part = 2 * (std::size_t{AcceptanceWarpView::azimuths} + 1);
  return {tables.intervals,
          tables.polar.data(),
          tables.azimuth.empty() ? nullptr : tables.azimuth.data(),
          tables.azimuth_begin.data(),
          tables.first_row.data(),
          static_cast<int>(tables.polar.size() / row),
          static_cast<int>(tables.azimuth.size() / part),
          static_cast<int>(tables.first_row.size())};
}

}  // namespace omma
