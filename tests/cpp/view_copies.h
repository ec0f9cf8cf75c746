// Memory in which each copied array ends where nothing may be read, and a frame with all that it is
// rendered from, for tests of the table of arrays.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "backend/copy_arrays.h"
#include "backend/eye_arrays.h"
#include "backend/portable/portable_tracer.h"
#include "render/render_truth.h"
#include "sampling/directions.h"
#include "sampling/sampling_choice.h"
#include "test_scenes.h"
#include "threads/thread_memory.h"
#include "world/world_state.h"

namespace omma::test {

// Arrays end at a page that cannot be read: what reads behind them ends the program.
class FencedMemory {
 public:
  FencedMemory() = default;
  FencedMemory(const FencedMemory&) = delete;
  FencedMemory& operator=(const FencedMemory&) = delete;
  ~FencedMemory() {
    for (const Piece& piece : pieces_) munmap(piece.mapped, piece.mapped_bytes);
  }

  template <typename T>
  const T* read(const T* array, std::size_t count, Version) {
    return static_cast<const T*>(copy(array, count * sizeof(T)));
  }
  template <typename T>
  T* written(T* array, std::size_t count) {
    void* place = copy(array, count * sizeof(T));
    outputs_.push_back({array, place, count * sizeof(T)});
    return static_cast<T*>(place);
  }

  // What was written goes to where it was asked for.
  void bring_back() const {
    for (const Output& output : outputs_) std::memcpy(output.host, output.place, output.bytes);
  }
  bool holds(const void* array, std::size_t bytes) const {
    const auto* at = static_cast<const std::byte*>(array);
    return std::any_of(pieces_.begin(), pieces_.end(), [&](const Piece& piece) {
      return at >= piece.mapped && at + bytes <= piece.mapped + piece.mapped_bytes;
    });
  }
  std::size_t bytes() const { return bytes_; }

 private:
  struct Piece {
    std::byte* mapped;
    std::size_t mapped_bytes;
  };
  struct Output {
    void* host;
    const void* place;
    std::size_t bytes;
  };

  void* copy(const void* from, std::size_t bytes) {
    const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    const std::size_t room = (bytes + page - 1) / page * page;
    auto* mapped = static_cast<std::byte*>(
        mmap(nullptr, room + page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    if (mapped == MAP_FAILED) throw std::bad_alloc();
    mprotect(mapped + room, page, PROT_NONE);
    pieces_.push_back({mapped, room + page});
    bytes_ += bytes;
    if (bytes > 0) std::memcpy(mapped + (room - bytes), from, bytes);
    return mapped + (room - bytes);
  }

  std::vector<Piece> pieces_;
  std::vector<Output> outputs_;
  std::size_t bytes_ = 0;
};

// Overwrites all arrays of views while it lives.
class Poison {
 public:
  template <typename View, typename... More>
  void add(const View& view, const More&... more) {
    for (const ArrayList::Entry& entry : ArrayList::of(view, more...).entries)
      if (entry.bytes > 0 && !entry.is_written) arrays_.push_back(entry);
  }
  void take_effect() {
    for (const ArrayList::Entry& entry : arrays_) {
      const auto* bytes = static_cast<const std::byte*>(entry.array);
      kept_.emplace_back(bytes, bytes + entry.bytes);
    }
    for (const ArrayList::Entry& entry : arrays_)
      std::memset(const_cast<void*>(entry.array), 0xee, entry.bytes);
  }
  ~Poison() {
    for (std::size_t i = 0; i < kept_.size(); ++i)
      std::memcpy(const_cast<void*>(arrays_[i].array), kept_[i].data(), kept_[i].size());
  }

 private:
  std::vector<ArrayList::Entry> arrays_;
  std::vector<std::vector<std::byte>> kept_;
};

// What is asked of a frame.
struct Asked {
  Sampling sampling = Fixed{16};
  Points points = Points::low_discrepancy;
  bool with_error = false, with_rays = false, with_truth = false;
  bool mixes = false;  // bands into outputs
  bool moves = false;  // the head, while the frame lasts
};

// Where results go.
struct Results {
  std::vector<float> responses, errors, radiance, beside;
  std::vector<std::int32_t> rays;
  std::vector<float> distance, nearest, inverse, source, met, normal, shares, rotation, translation,
      objects;
  std::vector<double> position;

  friend bool operator==(const Results& a, const Results& b) {
    const auto same = [](const auto& x, const auto& y) {
      return x.size() == y.size() &&
             (x.empty() || std::memcmp(x.data(), y.data(), x.size() * sizeof(x[0])) == 0);
    };
    return same(a.responses, b.responses) && same(a.errors, b.errors) &&
           same(a.radiance, b.radiance) && same(a.beside, b.beside) && same(a.rays, b.rays) &&
           same(a.distance, b.distance) && same(a.nearest, b.nearest) &&
           same(a.inverse, b.inverse) && same(a.source, b.source) && same(a.met, b.met) &&
           same(a.normal, b.normal) && same(a.shares, b.shares) && same(a.rotation, b.rotation) &&
           same(a.translation, b.translation) && same(a.objects, b.objects) &&
           same(a.position, b.position);
  }
};

// A frame of a world whose backend is `portable`, and its tasks.
struct FrameSetup {
  World world;
  Eye eye;
  std::vector<DirectionTables> tables;
  std::vector<DirectionsView> directions;
  EyeArrays arrays;
  EyeView eye_view;
  std::vector<std::uint8_t> nearest;
  std::vector<float> output_from_band, delay, node;
  HeadMotion motion;
  Truth truth;
  FrameView frame;
  Results results;
  std::vector<BlockTask> tasks;

  FrameSetup(World seen, Eye its_eye, const Asked& asked)
      : world(std::move(seen)), eye(std::move(its_eye)) {
    RenderSettings settings;
    settings.points = asked.points;
    const auto* target = std::get_if<ToError>(&asked.sampling);
    const std::size_t rounds = target != nullptr ? 3 : 1;
    for (int samples = first_samples(asked.sampling); tables.size() < rounds; samples *= 2)
      tables.push_back(make_direction_tables(eye, settings, samples));
    for (const DirectionTables& one : tables) directions.push_back(omma::view(one));
    arrays = make_eye_arrays(eye, tables.front());
    eye_view = omma::view(arrays);
    frame.scene = &world.state().view;
    frame.eye = &eye_view;
    frame.directions = directions.data();
    frame.rounds = static_cast<int>(rounds);
    frame.radiance_unit = world.state().radiance_unit;
    frame.outputs = world.bands();
    if (target != nullptr) {
      nearest = nearest_in_blocks(arrays, most_per_block);
      frame.nearest = nearest.data();
      frame.error = target->error;
      frame.relative_error = target->relative_error;
      frame.most_samples = 4 * tables.back().samples;
    } else if (asked.with_error) {
      frame.scrambles = error_scrambles;
    }
    if (asked.mixes) mix_bands();
    if (asked.moves) move_head();
    ask_for(asked);
  }
  FrameSetup(const FrameSetup&) = delete;
  FrameSetup& operator=(const FrameSetup&) = delete;

  const BuiltScene& built() const { return *world.state().built; }
  const PortableTracer& tracer() const {
    return *static_cast<const PortableTracer*>(built().acceleration.tracer.get());
  }

 private:
  void mix_bands() {
    frame.outputs = 2;
    for (int k = 0; k < 2 * world.bands() * world.components(); ++k)
      output_from_band.push_back(0.25f * static_cast<float>(1 + k % 5));
    frame.output_from_band = output_from_band.data();
  }

  // A step to the side and a turn.
  void move_head() {
    delay = {0, 0.3f, 0.7f, 2};
    for (const float part : {0.0f, 0.1f, 0.25f})
      node.insert(node.end(), {1, 0, part, part, 0, 1, 0, 0, -part, 0, 1, 0});
    motion.delay = delay.data();
    motion.delays = 3;
    motion.node = node.data();
    motion.nodes = 3;
  }

  void ask_for(const Asked& asked) {
    const std::size_t size = eye.size();
    const auto outputs = static_cast<std::size_t>(frame.outputs);
    results.responses.resize(size * outputs);
    if (asked.with_error || frame.most_samples > 0) {
      results.errors.resize(size * outputs);
      results.rays.resize(size);
    }
    if (asked.with_rays) {
      results.radiance.resize(results.responses.size() *
                              static_cast<std::size_t>(directions.front().samples));
      results.beside.resize(results.responses.size() * beside_rows);
      frame.beside_moments = true;
    }
    if (asked.with_truth) ask_for_truth();
    const Vec3d origin = built().placement.origin_m;
    const int rays_each = directions.front().samples * frame.scrambles;
    const int most = std::min(most_per_block, block_capacity / frame.scrambles);
    const int each =
        frame.most_samples > 0 ? most_per_block : std::clamp(block_rays / rays_each, 1, most);
    for (int first = 0; first < static_cast<int>(size); first += each) {
      BlockTask task;
      const double along[3] = {origin.x, origin.y, origin.z};
      for (int r = 0; r < 3; ++r) {
        task.world_from_head[r][r] = 1;
        task.world_from_head[r][3] = static_cast<float>(-along[r]);
      }
      if (asked.moves) task.motion = &motion;
      task.first = first;
      task.count = std::min(each, static_cast<int>(size) - first);
      task.responses = results.responses.data();
      if (!results.errors.empty()) task.standard_error = results.errors.data();
      if (frame.most_samples > 0) task.rays = results.rays.data();
      if (!results.radiance.empty()) task.ray_radiance = results.radiance.data();
      if (!results.beside.empty()) task.beside_rays = results.beside.data();
      if (asked.with_truth) task.truth = truth.tasks.data();
      tasks.push_back(task);
    }
  }

  // All that there is, of two groups and the first thing moving.
  void ask_for_truth() {
    const std::size_t size = eye.size(), things = built().things.count();
    std::vector<std::int32_t> groups;
    for (std::size_t i = 0; i < things; ++i) groups.push_back(static_cast<std::int32_t>(i % 2));
    const std::int32_t moving[] = {0};
    const Velocity head[] = {{{1, 0, 0.5}, {0.1, 0.2, 0}}}, velocity[] = {{{0, 1, 0}, {0, 0, 2}}};
    TruthCall call;
    const auto room = [&](auto& values, std::size_t each) {
      values.resize(size * each);
      return std::span(values);
    };
    call.distance_m = room(results.distance, 1);
    call.nearest_m = room(results.nearest, 1);
    call.inverse_distance_per_m = room(results.inverse, 1);
    call.met = room(results.met, 1);
    call.source_distance_m = room(results.source, 1);
    call.position_m = room(results.position, 3);
    call.normal = room(results.normal, 3);
    call.shares = room(results.shares, 2);
    call.share_count = 2;
    call.share_of_instance = groups;
    call.flow_rotation = room(results.rotation, 2);
    call.flow_translation = room(results.translation, 2);
    call.flow_objects = room(results.objects, 2);
    call.head = head;
    call.moving = moving;
    call.objects = velocity;
    truth = checked_truth(call, built(), 1, size);
    frame.truth = &truth.view;
  }
};

}  // namespace omma::test
