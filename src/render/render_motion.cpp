// Poses between keys: positions and stretches linearly, turns by slerp.
#include "render/render_motion.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string>

#include "model/transform.h"
#include "omma/error.h"

namespace omma {
namespace {

// Nodes of the head's path over the time that a frame sees: some for each key, and at least so many
// that rotations between nodes are small.
constexpr std::size_t nodes_per_key = 4, least_nodes = 33, most_nodes = 257;

// Time intervals into which a frame is divided while things move, each with a few rays, as each
// costs a move of all things.
constexpr int most_parts = 32, least_parts = 8, rays_of_part = 4;
// Intervals are equal in this mixture of probability and length; the weight of probability.
constexpr double by_probability = 0.75;

HeadKey key_of(const Mat4& traced_from_head, double time_s) {
  HeadKey key{time_s, traced_from_head, turn_of(traced_from_head), {}};
  key.stretch = inverse(transform_of({0, 0, 0}, key.turn, {1, 1, 1})) * traced_from_head;
  for (int r = 0; r < 3; ++r) key.stretch.m[r][3] = 0;
  return key;
}

Mat4 between(const HeadKey& a, const HeadKey& b, double part) {
  std::array<double, 3> position;
  Mat4 stretch;
  for (std::size_t r = 0; r < 3; ++r) {
    const double from = a.traced_from_head.m[r][3], to = b.traced_from_head.m[r][3];
    position[r] = from + (to - from) * part;
    for (std::size_t c = 0; c < 3; ++c)
      stretch.m[r][c] = a.stretch.m[r][c] + (b.stretch.m[r][c] - a.stretch.m[r][c]) * part;
  }
  return transform_of(position, slerp(a.turn.data(), b.turn.data(), part), {1, 1, 1}) * stretch;
}

// The first of the keys that is later.
std::size_t key_after(const HeadPath& path, double time_s) {
  const auto is_before = [](double time, const HeadKey& key) { return time < key.time_s; };
  return static_cast<std::size_t>(
      std::upper_bound(path.keys.begin(), path.keys.end(), time_s, is_before) - path.keys.begin());
}

// Before the first key the head stands where it was at that.
Mat4 pose_at(const HeadPath& path, double time_s) {
  const std::size_t next = key_after(path, time_s);
  if (next == 0) return path.keys.front().traced_from_head;
  if (next == path.keys.size()) return path.keys.back().traced_from_head;
  const HeadKey &a = path.keys[next - 1], &b = path.keys[next];
  return between(a, b, (time_s - a.time_s) / (b.time_s - a.time_s));
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
                   std::span<const Mat4> traced_past, std::span<const Mat4> traced) {
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
  for (std::size_t k = 0; k < path.past; ++k)
    path.keys.push_back(key_of(traced_past[k], call.past_times_s[k]));
  for (std::size_t p = 0; p < traced.size(); ++p)
    path.keys.push_back(key_of(traced[p], call.times_s[p]));
  for (std::size_t k = 1; k < path.keys.size(); ++k)
    if ((determinant(path.keys[k].traced_from_head) < 0) !=
        (determinant(path.keys[k - 1].traced_from_head) < 0))
      throw Error("poses: expected all of them mirrored or none, as the head goes from one to the "
                  "next, found one of each at " +
                  std::to_string(path.keys[k - 1].time_s) + " and " +
                  std::to_string(path.keys[k].time_s) + " s");
  path.longest_s = settings.delays_s.back();
  for (const double delay : settings.delays_s)
    path.delay.push_back(path.longest_s > 0 ? static_cast<float>(delay / path.longest_s) : 0.0f);
  return path;
}

Mat4 transform_between(const Mat4& from, const Mat4& to, double part) {
  return from == to ? from : between(key_of(from, 0), key_of(to, 1), part);
}

int parts_for(int samples) {
  const int least = std::min(samples, least_parts);
  const int wanted = std::min(most_parts, std::max(samples / rays_of_part, least));
  int parts = 1;
  while (2 * parts <= wanted) parts *= 2;
  return parts;
}

int samples_in(const TimePart& part, int samples) {
  return (samples - part.index + part.count - 1) / part.count;
}

TimePart time_part(int index, int count, std::span<const double> delays_s) {
  const std::size_t last = delays_s.size() - 1;
  const double range_s = delays_s[last] - delays_s[0];
  const auto reached = [&](std::size_t k) {
    const double probability = static_cast<double>(k) / static_cast<double>(last);
    if (!(range_s > 0)) return probability;
    return by_probability * probability +
           (1 - by_probability) * (delays_s[k] - delays_s[0]) / range_s;
  };
  const auto quantile_of = [&](int part) {
    const double wanted = static_cast<double>(part) / count;
    std::size_t before = 0, after = last;
    while (after - before > 1) {
      const std::size_t middle = (before + after) / 2;
      (reached(middle) <= wanted ? before : after) = middle;
    }
    const double from = reached(before), to = reached(after);
    return (static_cast<double>(before) + (wanted - from) / (to - from)) / static_cast<double>(last);
  };
  const double first = quantile_of(index);
  return {index, count, first, quantile_of(index + 1) - first};
}

double delay_of(const TimePart& part, std::span<const double> delays_s) {
  const double at =
      (part.first + 0.5 * part.size) * static_cast<double>(delays_s.size() - 1);
  const auto before = std::min(static_cast<std::size_t>(at), delays_s.size() - 2);
  return delays_s[before] +
         (delays_s[before + 1] - delays_s[before]) * (at - static_cast<double>(before));
}

void set_motion(const HeadPath& path, std::size_t frame, const TimePart& part, FrameMotion& made) {
  made.stands = true;
  if (path.delay.empty() || !(path.longest_s > 0)) return;
  const std::size_t own = path.past + frame;
  const double time_s = path.keys[own].time_s;
  const std::size_t first = key_after(path, time_s - path.longest_s);
  const std::size_t from = first == 0 ? 0 : first - 1;
  const Mat4& now = path.keys[own].traced_from_head;
  made.stands = std::all_of(path.keys.begin() + static_cast<std::ptrdiff_t>(from),
                            path.keys.begin() + static_cast<std::ptrdiff_t>(own),
                            [&](const HeadKey& key) { return key.traced_from_head == now; });
  if (made.stands) return;
  const std::size_t nodes = std::clamp(nodes_per_key * (own - from) + 1, least_nodes, most_nodes);
  const Mat4 head_from_traced = inverse(now);
  made.node.resize(nodes * 12);
  for (std::size_t k = 0; k < nodes; ++k) {
    const double before = static_cast<double>(k) / static_cast<double>(nodes - 1);
    const Mat4 then = pose_at(path, time_s - path.longest_s * before);
    const Mat4 turn = then * head_from_traced;
    float* node = made.node.data() + 12 * k;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 4; ++c)
        node[4 * r + c] = static_cast<float>(c < 3 ? turn.m[r][c] : then.m[r][3]);
  }
  made.delay.resize(path.delay.size());
  for (std::size_t k = 0; k < path.delay.size(); ++k)
    made.delay[k] = path.delay[k] * static_cast<float>(nodes - 1);
  made.motion.delay = made.delay.data();
  made.motion.delays = static_cast<int>(path.delay.size()) - 1;
  made.motion.node = made.node.data();
  made.motion.nodes = static_cast<int>(nodes);
  for (int r = 0; r < 3; ++r) made.motion.centre[r] = static_cast<float>(now.m[r][3]);
  made.motion.first = static_cast<float>(part.first);
  made.motion.size = static_cast<float>(part.size);
  made.motion.shift = std::countr_zero(static_cast<unsigned>(part.count));
}

}  // namespace omma
