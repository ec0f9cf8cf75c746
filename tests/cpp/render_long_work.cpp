// Long work is watched: whatever takes long asks all along whether it is to end, on all of its
// threads; and whoever watches is told, on the thread that watches.
#include "model/long_work.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <thread>

#include "io/oces_file.h"
#include "omma/acceptance.h"
#include "omma/projection.h"
#include "omma/receptor_views.h"
#include "sampling/directions.h"
#include "sampling/shared_rays.h"
#include "test_scenes.h"
#include "threads/made_once.h"
#include "threads/parallel.h"

namespace omma::test {
namespace {

using std::chrono_literals::operator""ms;

TEST(LongWork, LoopsEndWhenTheyAreCancelled) {
  std::atomic<bool> cancelled = false;
  std::atomic<int> begun = 0;
  const TakingPart part(&cancelled);
  EXPECT_THROW(parallel_for(0, 100000,
                            [&](int) {
                              ++begun;
                              cancelled = true;
                            }),
               Cancelled);
  EXPECT_LT(begun, 1000);  // about as many as there are threads
  EXPECT_THROW(parallel_ranges(0, 10, 1, [](int, int) {}), Cancelled);
  cancelled = false;
  int sum = 0;
  parallel_ranges(0, 10, 100, [&](int from, int to) { sum += to - from; });
  EXPECT_EQ(sum, 10);
}

TEST(LongWork, ThreadsTakePartWhereverTheyHelp) {
  // Loops in loops, in an arena, on other threads: all belong to the same work, and nothing is left
  // of it on a thread afterwards.
  oneapi::tbb::task_arena arena(2);
  std::atomic<int> strangers = 0;
  run_watched([](double) { return true; },
              [&](WorkState& state) {
                run_in_arena(arena, [&] {
                  parallel_for(0, 200, [&](int) {
                    parallel_for(0, 20, [&](int) {
                      if (cancel_flag() != &state.cancelled) ++strangers;
                    });
                    if (cancel_flag() != &state.cancelled) ++strangers;
                  });
                });
              });
  EXPECT_EQ(strangers, 0);
  arena.execute([&] {
    oneapi::tbb::parallel_for(0, 2000, [&](int) {
      if (cancel_flag() != nullptr) ++strangers;
    });
  });
  EXPECT_EQ(strangers, 0);
}

TEST(LongWork, HasEndedWhateverEndsIt) {
  std::atomic<bool> at_work = false;
  const auto work = [&](WorkState&) {
    at_work = true;
    try {
      for (;;) {
        check_cancelled();
        std::this_thread::sleep_for(1ms);
      }
    } catch (const Cancelled&) {
      at_work = false;
      throw;
    }
  };
  int told = 0;
  EXPECT_THROW(run_watched([&](double) { return ++told < 3; }, work), Cancelled);
  EXPECT_EQ(told, 3);
  EXPECT_FALSE(at_work);
  EXPECT_THROW(run_watched([](double) -> bool { throw std::range_error("enough"); }, work),
               std::range_error);
  EXPECT_FALSE(at_work);
}

TEST(LongWork, IsToldOfOftenAndOnOneThread) {
  std::set<std::thread::id> where;
  int told = 0;
  // It ends when it was told of ten times: in a second.
  const auto progress = [&](double) {
    where.insert(std::this_thread::get_id());
    ++told;
    return true;
  };
  std::atomic<int> heard = 0;
  run_watched([&](double share) { return progress(share) && (heard = told, true); },
              [&](WorkState&) {
                while (heard < 10) std::this_thread::sleep_for(1ms);
              });
  EXPECT_EQ(told, 11);  // and once at the end
  EXPECT_EQ(where, std::set{std::this_thread::get_id()});
}

TEST(LongWork, WhatIsMadeOnceIsMadeAgainAfterItWasCancelled) {
  MadeOnce<int> value;
  EXPECT_THROW(value.get([]() -> int { throw Cancelled(); }), Cancelled);
  EXPECT_EQ(value.get([] { return 5; }), 5);
  EXPECT_EQ(value.get([]() -> int { throw Cancelled(); }), 5);
}

// A radial table, and a map that is not round.
Acceptance table(bool round) {
  SensitivityTable t;
  for (int i = 0; i < 20; ++i) t.right_rad.push_back(0.01 * (round ? i : i - 10));
  if (!round) t.up_rad = t.right_rad;
  t.sensitivity.assign(round ? 20 : 400, 0.5);
  t.sensitivity[round ? 0 : 210] = 1;
  Acceptance acceptance;
  acceptance.kernel = Kernel::table;
  acceptance.table = std::make_shared<const SensitivityTable>(std::move(t));
  return acceptance;
}

TEST(LongWork, EverythingLongAsksWhetherItIsToEnd) {
  Eye eye = make_eye(sphere_directions(500), 0.3);
  for (std::size_t i = 0; i < eye.size(); ++i) eye.position_m[i] = eye.axis[i] * 1e-3f;
  const DirectionTables tables = make_direction_tables(eye, {}, 16);
  const std::vector<Vec3> directions(10, Vec3{0, 0, 1});
  const std::vector<double> numbers(10, 0.1);
  std::vector<double> out(10);
  const std::vector<float> radiance(eye.size() * rgb_bands);
  const std::vector<std::int32_t> ids(10, 0);
  const Scene scene = random_scene(3);
  const Renderer renderer = make_renderer(scene, eye);
  const Renderer sharing = make_renderer(scene, eye, {.sampling = Shared{}});
  const Mat4 pose;
  std::vector<float> whole(eye.size() * rgb_bands);
  Acceptance gaussian;
  gaussian.width_rad = 0.1;

  const std::pair<const char*, std::function<void()>> works[] = {
      {"a scene", [&] { make_renderer(scene, eye); }},
      {"another eye", [&] { Renderer(renderer, eye, {.sampling = Fixed{32}}); }},
      {"direction tables", [&] { make_direction_tables(eye, {}, 16); }},
      {"shared rays", [&] { make_shared_rays(eye, tables, 1); }},
      {"a render with shared rays",
       [&] {
         sharing.render({&pose, 1}, whole);
       }},
      {"a round table", [&] { acceptance_pdf(table(true), numbers, numbers, out); }},
      {"a map", [&] { acceptance_pdf(table(false), numbers, numbers, out); }},
      {"samples", [&] { sample_acceptance(gaussian, 10, 0); }},
      {"sensitivities", [&] { eval_acceptance(gaussian, numbers, numbers, out); }},
      {"transfer of a table", [&] { acceptance_mtf(table(true), numbers, numbers, out); }},
      {"transfer of a map", [&] { acceptance_mtf(table(false), numbers, numbers, out); }},
      {"an eye",
       [&] {
         Eye copy = eye;
         validate_eye(copy);
       }},
      {"angles", [&] { interommatidial_angle_rad(eye); }},
      {"nearest", [&] { nearest_by_axis(eye, directions); }},
      {"painting", [&] { paint(ids, radiance); }},
      {"ids as colours", [&] { encode_ids(ids); }},
      {"an OCES sphere",
       [&] {
         OcesProperty diameter;
         diameter.coarse = true;
         diameter.values = {0.01};
         oces_sphere_sites({{"ommatidialCount", 500}}, {{"DIAMETER", diameter}}, "");
       }},
  };
  for (const auto& [name, work] : works) {
    EXPECT_NO_THROW(work()) << name;
    std::atomic<bool> cancelled = true;
    const TakingPart part(&cancelled);
    EXPECT_THROW(work(), Cancelled) << name;
  }
  for (const NamedProjection& named : named_projections()) {
    std::atomic<bool> cancelled = true;
    const TakingPart part(&cancelled);
    EXPECT_THROW(projection_ids(eye, named.projection, 500, 10), Cancelled) << named.name;
  }
}

}  // namespace
}  // namespace omma::test
