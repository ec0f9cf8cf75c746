// Poses between keys: positions and stretches linearly, turns by slerp (Shoemake 1985, Animating
// rotation with quaternion curves).
#include "render_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "omma/error.h"

namespace omma {
namespace {

// Nodes over the time that a frame sees: some for each key, and so many at least that a turn
// between two of them is small.
constexpr std::size_t nodes_per_key = 4, least_nodes = 33, most_nodes = 257;

using Columns = std::array<Vec3d, 3>;
using Quaternion = std::array<double, 4>;  // x, y, z, w

Columns columns_of(const Mat4& m) {
  Columns columns;
  for (std::size_t c = 0; c < 3; ++c) columns[c] = {m.m[0][c], m.m[1][c], m.m[2][c]};
  return columns;
}

// The turn of a transform, by Gram and Schmidt; a mirrored one keeps its mirror in the stretch.
Columns turn_of(const Columns& m) {
  const Vec3d x = normalize(m[0]);
  const Vec3d y = normalize(m[1] - x * dot(m[1], x));
  return {x, y, cross(x, y)};
}

// (W. Kahan's choice of the largest term, as in Shepperd 1978, J Guidance and Control 1:223.)
Quaternion quaternion_of(const Columns& r) {
  const double xx = r[0].x, yy = r[1].y, zz = r[2].z;
  Quaternion q{xx - yy - zz, yy - xx - zz, zz - xx - yy, xx + yy + zz};
  const auto largest = static_cast<std::size_t>(std::max_element(q.begin(), q.end()) - q.begin());
  const double s = 2 * std::sqrt(std::max(0.0, 1 + q[largest]));
  switch (largest) {
    case 0:
      q = {s / 4, (r[0].y + r[1].x) / s, (r[2].x + r[0].z) / s, (r[1].z - r[2].y) / s};
      break;
    case 1:
      q = {(r[0].y + r[1].x) / s, s / 4, (r[1].z + r[2].y) / s, (r[2].x - r[0].z) / s};
      break;
    case 2:
      q = {(r[2].x + r[0].z) / s, (r[1].z + r[2].y) / s, s / 4, (r[0].y - r[1].x) / s};
      break;
    default:
      q = {(r[1].z - r[2].y) / s, (r[2].x - r[0].z) / s, (r[0].y - r[1].x) / s, s / 4};
  }
  return q;
}

Columns turn_of(const Quaternion& q) {
  const auto [x, y, z, w] = q;
  return {{{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
           {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
           {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)}}};
}

Quaternion slerp(const Quaternion& a, Quaternion b, double part) {
  double cosine = 0;
  for (std::size_t k = 0; k < 4; ++k) cosine += a[k] * b[k];
  if (cosine < 0) {
    for (double& x : b) x = -x;
    cosine = -cosine;
  }
  // Of turns too small for the sines a straight way is as good.
  const double angle = std::acos(std::min(1.0, cosine)), sine = std::sin(angle);
  const double of_a = sine < 1e-9 ? 1 - part : std::sin((1 - part) * angle) / sine;
  const double of_b = sine < 1e-9 ? part : std::sin(part * angle) / sine;
  Quaternion q;
  double length = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    q[k] = of_a * a[k] + of_b * b[k];
    length += q[k] * q[k];
  }
  for (double& x : q) x /= std::sqrt(length);
  return q;
}

Vec3d apply(const Columns& m, Vec3d v) {
  return m[0] * v.x + m[1] * v.y + m[2] * v.z;
}

Vec3d apply_transposed(const Columns& m, Vec3d v) {
  return {dot(m[0], v), dot(m[1], v), dot(m[2], v)};
}

Columns product(const Columns& a, const Columns& b) {
  return {apply(a, b[0]), apply(a, b[1]), apply(a, b[2])};
}

Columns inverse(const Columns& m) {
  const double det = dot(m[0], cross(m[1], m[2]));
  const Vec3d x = cross(m[1], m[2]) * (1 / det), y = cross(m[2], m[0]) * (1 / det),
              z = cross(m[0], m[1]) * (1 / det);
  return {{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}}};
}

struct Pose {
  Columns linear;
  Vec3d position;
};

Pose between(const Mat4& a, const Mat4& b, double part) {
  const Columns from = columns_of(a), to = columns_of(b);
  const Columns turn_a = turn_of(from), turn_b = turn_of(to);
  Columns stretch;
  for (std::size_t c = 0; c < 3; ++c) {
    const Vec3d p = apply_transposed(turn_a, from[c]), q = apply_transposed(turn_b, to[c]);
    stretch[c] = p + (q - p) * part;
  }
  const Columns turn = turn_of(slerp(quaternion_of(turn_a), quaternion_of(turn_b), part));
  const Vec3d p{a.m[0][3], a.m[1][3], a.m[2][3]}, q{b.m[0][3], b.m[1][3], b.m[2][3]};
  return {product(turn, stretch), p + (q - p) * part};
}

// Before the first key the head stands where it was at that.
Pose pose_at(const HeadPath& path, double time_s) {
  const auto next = static_cast<std::size_t>(
      std::upper_bound(path.times_s.begin(), path.times_s.end(), time_s) - path.times_s.begin());
  const std::size_t last = path.times_s.size() - 1;
  if (next == 0 || next > last) {
    const std::size_t key = next == 0 ? 0 : last;
    return between(path.traced_from_head[key], path.traced_from_head[key], 0);
  }
  const double from_s = path.times_s[next - 1], to_s = path.times_s[next];
  return between(path.traced_from_head[next - 1], path.traced_from_head[next],
                 (time_s - from_s) / (to_s - from_s));
}

void check_times(std::span<const double> times_s, std::size_t poses, const char* name) {
  if (times_s.size() != poses)
    throw Error(std::string(name) + ": expected " + std::to_string(poses) +
                " times, one for each pose, found " + std::to_string(times_s.size()));
  for (std::size_t p = 0; p < poses; ++p) {
    const std::string place = std::string(name) + "[" + std::to_string(p) + "]";
    if (!std::isfinite(times_s[p]))
      throw Error(place + ": expected a time in s, found " + std::to_string(times_s[p]));
    if (p > 0 && !(times_s[p] > times_s[p - 1]))
      throw Error(place + ": expected more than " + std::to_string(times_s[p - 1]) +
                  " s, the time before it, found " + std::to_string(times_s[p]));
  }
}

}  // namespace

HeadPath head_path(const RenderSettings& settings, const RenderCall& call,
                   std::vector<Mat4> traced_past, std::span<const Mat4> traced) {
  HeadPath path;
  if (settings.delays_s.empty()) {
    if (!traced_past.empty())
      throw Error("past: expected no poses before the first, as frames are instants without an "
                  "impulse response");
    return path;
  }
  check_times(call.times_s, traced.size(), "times_s");
  check_times(call.past_times_s, traced_past.size(), "past times");
  if (!traced_past.empty() && !traced.empty() && call.past_times_s.back() >= call.times_s.front())
    throw Error("past times: expected all before the first frame, at " +
                std::to_string(call.times_s.front()) + " s, found " +
                std::to_string(call.past_times_s.back()));
  path.past = traced_past.size();
  path.traced_from_head = std::move(traced_past);
  path.traced_from_head.insert(path.traced_from_head.end(), traced.begin(), traced.end());
  path.times_s.assign(call.past_times_s.begin(), call.past_times_s.end());
  path.times_s.insert(path.times_s.end(), call.times_s.begin(), call.times_s.end());
  path.longest_s = settings.delays_s.back();
  for (const double delay : settings.delays_s)
    path.delay.push_back(path.longest_s > 0 ? static_cast<float>(delay / path.longest_s) : 0.0f);
  return path;
}

const HeadMotion* motion_of(const HeadPath& path, std::size_t frame, FrameMotion& kept) {
  if (path.delay.empty() || !(path.longest_s > 0)) return nullptr;
  const std::size_t own = path.past + frame;
  const double time_s = path.times_s[own];
  const auto first = static_cast<std::size_t>(
      std::upper_bound(path.times_s.begin(), path.times_s.end(), time_s - path.longest_s) -
      path.times_s.begin());
  const std::size_t from = first == 0 ? 0 : first - 1;
  const Mat4& here = path.traced_from_head[own];
  const bool stands = std::all_of(
      path.traced_from_head.begin() + static_cast<std::ptrdiff_t>(from),
      path.traced_from_head.begin() + static_cast<std::ptrdiff_t>(own), [&](const Mat4& pose) {
        return std::equal(&pose.m[0][0], &pose.m[0][0] + 12, &here.m[0][0]);
      });
  if (stands) return nullptr;
  if (kept.frame == frame) return &kept.motion;
  const std::size_t nodes =
      std::clamp(nodes_per_key * (own - from) + 1, least_nodes, most_nodes);
  const Pose now = pose_at(path, time_s);
  const Columns back = inverse(now.linear);
  kept.node.resize(nodes * 12);
  for (std::size_t k = 0; k < nodes; ++k) {
    const double before = static_cast<double>(k) / static_cast<double>(nodes - 1);
    const Pose then = pose_at(path, time_s - path.longest_s * before);
    const Columns turn = product(then.linear, back);
    float* node = kept.node.data() + 12 * k;
    const double rows[3][4] = {{turn[0].x, turn[1].x, turn[2].x, then.position.x},
                               {turn[0].y, turn[1].y, turn[2].y, then.position.y},
                               {turn[0].z, turn[1].z, turn[2].z, then.position.z}};
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 4; ++c) node[4 * r + c] = static_cast<float>(rows[r][c]);
  }
  kept.delay.resize(path.delay.size());
  for (std::size_t k = 0; k < path.delay.size(); ++k)
    kept.delay[k] = path.delay[k] * static_cast<float>(nodes - 1);
  kept.motion.delay = kept.delay.data();
  kept.motion.delays = static_cast<int>(path.delay.size()) - 1;
  kept.motion.node = kept.node.data();
  kept.motion.nodes = static_cast<int>(nodes);
  const double centre[3] = {now.position.x, now.position.y, now.position.z};
  for (int r = 0; r < 3; ++r) kept.motion.centre[r] = static_cast<float>(centre[r]);
  kept.frame = frame;
  return &kept.motion;
}

}  // namespace omma
