// Rays that neighbours share, before any is traced: the lattice, who uses which ray with what
// weight, and where each ray starts.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sampling/shared_rays.h"
#include "sampling/sharing_groups.h"
#include "sampling/sphere_lattice.h"
#include "test_scenes.h"

namespace omma::test {
namespace {

SharedRays shared_rays(const Eye& eye, int samples, Kernel kernel = Kernel::gaussian,
                       std::uint64_t seed = 1) {
  RenderSettings settings;
  settings.kernel = kernel;
  settings.seed = seed;
  return make_shared_rays(eye, make_direction_tables(eye, settings, samples), 0);
}

double rays_each(const Eye& eye, int samples, Kernel kernel = Kernel::gaussian) {
  return static_cast<double>(shared_rays(eye, samples, kernel).rays.size()) /
         static_cast<double>(eye.size());
}

// 3 mm across, facets 8 degrees apart.
Eye round_eye(double acceptance_rad = 16 * degree) {
  Eye eye = make_eye(sphere_directions(600), acceptance_rad);
  for (std::size_t i = 0; i < eye.size(); ++i) eye.position_m[i] = eye.axis[i] * 0.0015f;
  return eye;
}

void append(Eye& eye, const Eye& more) {
  eye.position_m.insert(eye.position_m.end(), more.position_m.begin(), more.position_m.end());
  eye.axis.insert(eye.axis.end(), more.axis.begin(), more.axis.end());
  eye.acceptance_angle_rad.insert(eye.acceptance_angle_rad.end(), more.acceptance_angle_rad.begin(),
                                  more.acceptance_angle_rad.end());
  eye.focal_offset_m.insert(eye.focal_offset_m.end(), more.focal_offset_m.begin(),
                            more.focal_offset_m.end());
  eye.eye_id.insert(eye.eye_id.end(), more.eye_id.begin(), more.eye_id.end());
}

TEST(SphereLattice, PatchesHoldEachPointOnce) {
  for (const std::uint64_t count : {1u, 12u, 500u, 30011u, 1000000u}) {
    const SphereLattice lattice{count, rotation({0, 0.6, 0.8}, 1.1)};
    std::vector<int> times(count);
    const auto patches = lattice_patches(lattice, [](Vec3d, double) { return true; });
    for (const LatticePatch& patch : patches)
      for (const std::uint64_t i : points_of(patch)) ++times.at(i);
    EXPECT_EQ(std::count(times.begin(), times.end(), 1), static_cast<std::int64_t>(count));
  }
}

TEST(SphereLattice, PatchesNearADirectionHoldAllPointsThere) {
  const std::uint64_t count = 200000;
  const SphereLattice lattice{count, rotation({0.6, 0.8, 0}, 2)};
  Random random{3};
  for (const double reach : {0.01, 0.1, 1.0})
    for (int k = 0; k < 8; ++k) {
      // The poles of the lattice too.
      const Vec3d towards = k == 0   ? transform_vector(lattice.turn, {0, 0, 1})
                            : k == 1 ? transform_vector(lattice.turn, {0, 0, -1})
                                     : random.direction();
      const auto angle = [&](Vec3d d) { return std::acos(std::clamp(dot(d, towards), -1.0, 1.0)); };
      std::vector<std::uint64_t> found;
      std::size_t looked_at = 0;
      for (const LatticePatch& patch :
           lattice_patches(lattice, [&](Vec3d d, double r) { return angle(d) <= r + reach; }))
        for (const std::uint64_t i : points_of(patch)) {
          ++looked_at;
          if (angle(lattice_point(lattice, i)) <= reach) found.push_back(i);
        }
      std::sort(found.begin(), found.end());
      std::vector<std::uint64_t> expected;
      for (std::uint64_t i = 0; i < count; ++i)
        if (angle(lattice_point(lattice, i)) <= reach) expected.push_back(i);
      EXPECT_EQ(found, expected);
      // And few others: a border of patches of 128 to 256 points, 1.4 degrees wide and more.
      EXPECT_LT(looked_at, 4 * expected.size() + 4000);
    }
}

// One ring of equal areas: the points of any cap are as many as its area says, to a few.
TEST(SphereLattice, IsEven) {
  const std::uint64_t count = 20000;
  const SphereLattice lattice{count, {}};
  Random random{4};
  for (int k = 0; k < 50; ++k) {
    const Vec3d towards = random.direction();
    const double cosine = std::cos(random.uniform(0.2, 1.5));
    double inside = 0;
    for (std::uint64_t i = 0; i < count; ++i)
      inside += dot(lattice_point(lattice, i), towards) > cosine ? 1 : 0;
    const double expected = static_cast<double>(count) * (1 - cosine) / 2;
    // Random points deviate by sqrt(expected), 14 to 96 here; a lattice by much less.
    EXPECT_NEAR(inside, expected, 10);
  }
}

TEST(SharedRays, RowsSumToOneAndAreWhole) {
  Eye lone = make_eye(Vec3d{0, 0, -1}, 5 * degree);
  Eye mixed = round_eye();
  for (std::size_t i = 0; i < mixed.size(); ++i)
    mixed.acceptance_angle_rad[i] = static_cast<float>((i % 5) * 20 * degree);
  for (const Eye& eye : {round_eye(), round_eye(1 * degree), mixed, lone})
    for (const Kernel kernel : {Kernel::gaussian, Kernel::pillbox})
      for (const int samples : {1, 5, 40}) {
        const SharedRays shared = shared_rays(eye, samples, kernel);
        ASSERT_EQ(shared.first.size(), eye.size() + 1);
        ASSERT_EQ(shared.ray.size(), shared.weight.size());
        ASSERT_EQ(shared.first.back(), static_cast<std::int64_t>(shared.ray.size()));
        std::vector<bool> used(shared.rays.size());
        for (std::size_t i = 0; i < eye.size(); ++i) {
          const auto first = static_cast<std::size_t>(shared.first[i]);
          const auto end = static_cast<std::size_t>(shared.first[i + 1]);
          EXPECT_EQ((end - first) % weight_group, 0u);
          double sum = 0;
          std::size_t weights = 0;
          for (std::size_t k = first; k < end; ++k) {
            ASSERT_LT(shared.ray[k], static_cast<std::int64_t>(shared.rays.size()));
            ASSERT_GE(shared.weight[k], 0);
            sum += shared.weight[k];
            if (shared.weight[k] > 0) {
              ++weights;
              used[static_cast<std::size_t>(shared.ray[k])] = true;
            }
          }
          // Each of up to some thousand weights is rounded to 6e-8 of itself.
          EXPECT_NEAR(sum, 1, 1e-6);
          const bool single = eye.acceptance_angle_rad[i] == 0;
          EXPECT_GE(weights, static_cast<std::size_t>(single ? 1 : samples));
        }
        // None is traced for nothing.
        EXPECT_EQ(std::count(used.begin(), used.end(), true),
                  static_cast<std::int64_t>(shared.rays.size()));
      }
}

TEST(SharedRays, AreAboutAsManyAsAsked) {
  for (const int samples : {1, 2, 7, 16, 100}) {
    EXPECT_NEAR(rays_each(round_eye(), samples) / samples, 1, 0.1);
    EXPECT_NEAR(rays_each(round_eye(), samples, Kernel::pillbox) / samples, 1, 0.1);
  }
}

TEST(SharedRays, LoneOmmatidiaHaveTheirOwn) {
  EXPECT_EQ(rays_each(make_eye(Vec3d{0, 0, -1}, 5 * degree), 9), 9);
  // Facets 8 degrees apart that see 1 degree each, or 0.001: no lattice over the sphere is that
  // fine.
  for (const double acceptance : {1 * degree, 1e-3 * degree, 1e-20}) {
    const SharedRays apart = shared_rays(round_eye(acceptance), 9);
    EXPECT_EQ(apart.rays.size(), 9u * 600);
    EXPECT_EQ(std::count(apart.is_shared.begin(), apart.is_shared.end(), 0), 600);
  }
}

// Rays of its own are those that an ommatidium has when it does not share at all, of another
// pattern in each set.
TEST(SharedRays, OwnRaysAreSpreadForTheirOmmatidium) {
  const Eye eye = round_eye(4 * degree);
  const DirectionTables tables = make_direction_tables(eye, {}, 9);
  const SharedRays one = make_shared_rays(eye, tables, 0), other = make_shared_rays(eye, tables, 1);
  EXPECT_NE(one.rays.axis[0].x, other.rays.axis[0].x);
  // Their angles from the axis are those of a pattern: cosines spread over 0.001, and floats.
  for (std::size_t i = 0; i < 20; ++i) {
    std::vector<double> cosines;
    for (std::size_t k = 0; k < 9; ++k)
      cosines.push_back(dot(to_double(one.rays.axis[9 * i + k]), to_double(eye.axis[i])));
    std::sort(cosines.begin(), cosines.end());
    double nearest = 1;
    for (std::size_t pattern = 0; pattern < static_cast<std::size_t>(tables.patterns); ++pattern) {
      std::vector<float> z(tables.local.begin() + static_cast<std::ptrdiff_t>(pattern * 27 + 18),
                           tables.local.begin() + static_cast<std::ptrdiff_t>(pattern * 27 + 27));
      std::sort(z.begin(), z.end());
      double apart = 0;
      for (std::size_t k = 0; k < 9; ++k) apart = std::max(apart, std::fabs(z[k] - cosines[k]));
      nearest = std::min(nearest, apart);
    }
    EXPECT_LT(nearest, 5e-7);
  }
}

// Whoever gains from neighbours shares, whoever does not has its own: by how much of what its rays
// would do is done by others too.
TEST(SharedRays, ShareWhereItPays) {
  const auto sharing = [](const Eye& eye) {
    const SharedRays shared = shared_rays(eye, 4);
    return static_cast<double>(std::count(shared.is_shared.begin(), shared.is_shared.end(), 1)) /
           static_cast<double>(eye.size());
  };
  // The spacing of 600 axes is 8.9 degrees. Own rays are worth twice as many, and all the density
  // is even to a step, from an acceptance angle of 0.8 of it on.
  EXPECT_EQ(sharing(round_eye(12 * degree)), 1);
  EXPECT_EQ(sharing(round_eye(8.5 * degree)), 1);
  EXPECT_EQ(sharing(round_eye(5 * degree)), 0);
  // Two that look the same way gain less than a lattice costs that ends with their fields; six
  // gain.
  for (const int together : {2, 6}) {
    Eye crowd;
    for (int k = 0; k < together; ++k) append(crowd, round_eye(2 * degree));
    EXPECT_EQ(sharing(crowd), together == 6 ? 1 : 0) << together;
  }
  // Both in one eye: everybody for itself.
  Eye half = round_eye(5 * degree);
  for (std::size_t i = 0; i < half.size(); ++i)
    if (half.axis[i].x > 0) half.acceptance_angle_rad[i] = static_cast<float>(14 * degree);
  const SharedRays shared = shared_rays(half, 4);
  for (std::size_t i = 0; i < half.size(); ++i)
    if (std::fabs(half.axis[i].x) > 0.3f) {  // away from the border
      EXPECT_EQ(shared.is_shared[i] != 0, half.axis[i].x > 0) << i;
    }
}

TEST(SharedRays, WidthsAreSplitIntoFewClasses) {
  const std::vector<std::uint32_t> all = {0, 1, 2, 3, 4, 5};
  const auto classes = [&](std::vector<double> width) { return width_classes(all, width); };
  EXPECT_EQ(classes({1, 4, 2, 3, 2, 1}).size(), 1u);
  EXPECT_TRUE(classes({0, 0, 0, 0, 0, 0}).empty());
  using Classes = std::vector<std::vector<std::uint32_t>>;
  EXPECT_EQ(classes({1, 1, 1, 1, 1, 1}), Classes{all});
  EXPECT_EQ(classes({5, 60, 5, 0, 60, 5}), (Classes{{0, 2, 5}, {1, 4}}));
  EXPECT_EQ(classes({1e-4, 6, 1e-4, 1e-3, 0.1, 5}), (Classes{{0, 2}, {3}, {4}, {1, 5}}));
  for (const std::vector<std::uint32_t>& one : classes({1, 1.7, 3.1, 5.5, 9, 17}))
    EXPECT_LE(one.size(), 3u);
}

// What making rays costs: directions of lattices that are looked at, and weights. It grows with the
// rays, however different the widths and however many crowd together: (wide/narrow)^2 once.
TEST(SharedRays, CostIsBounded) {
  const auto with_widths = [](double narrow, double wide) {
    Eye eye = round_eye(narrow);
    for (std::size_t i = 0; i < eye.size(); i += 2)
      eye.acceptance_angle_rad[i] = static_cast<float>(wide);
    return eye;
  };
  Eye crowded = round_eye(12 * degree);
  for (std::size_t i = 0; i < crowded.size(); i += 2) crowded.axis[i] = {0, 0, -1};
  const std::pair<const char*, Eye> eyes[] = {
      {"2 pi beside 1e-4", with_widths(1e-4, 2 * pi)},
      {"100", with_widths(0.02, 2)},
      {"1,000", with_widths(1e-3, 1)},
      {"4", with_widths(12 * degree, 48 * degree)},
      {"all between",
       [] {
         Eye eye = round_eye();
         for (std::size_t i = 0; i < eye.size(); ++i)
           eye.acceptance_angle_rad[i] =
               static_cast<float>(1e-4 * std::pow(6e4, static_cast<double>(i * 7 % 600) / 600));
         return eye;
       }()},
      {"crowded", crowded},
  };
  for (const auto& [name, eye] : eyes) {
    const SharedRays shared = shared_rays(eye, 4);
    const double rays = static_cast<double>(shared.rays.size());
    // Fewer than twice those asked for; some 20 directions for each at most (the crowd: 12 octaves
    // of density); no more than everybody's own in everybody's field.
    EXPECT_LE(rays, 2 * 4 * 600) << name;
    EXPECT_LE(static_cast<double>(shared.directions_tried), 30 * rays) << name;
    EXPECT_LE(shared.weight.size(), 600u * 600 * 4) << name;
  }
}

TEST(SharedRays, RefusesWhatWouldTakeTooMuch) {
  const auto refusal = [](const Eye& eye, int samples) -> std::string {
    try {
      shared_rays(eye, samples);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal(make_eye(sphere_directions(33000), 1 * degree), 256),
            "sampling: Shared expects at most 8388608 rays, found 8448000 (33000 ommatidia, 256 "
            "samples): take fewer samples");
  EXPECT_EQ(
      refusal(make_eye(sphere_directions(1500), 2 * pi), 64),
      "sampling: Shared, but 1500 ommatidia whose fields overlap would count about 144000000 rays "
      "together, each for itself, more than 134217728: take fewer samples");
  EXPECT_EQ(refusal(make_eye(sphere_directions(300), 2 * pi), 4), "");
}

// A ray reads textures as wide as one of the narrowest that it counts for would: of an eye's own
// acceptances as of those that the settings name.
TEST(SharedRays, FootprintsAreThoseOfTheAcceptance) {
  Eye eye = round_eye();
  RenderSettings settings;
  settings.kernel = Kernel::pillbox;
  const auto footprints = [&] {
    const DirectionTables tables = make_direction_tables(eye, settings, 4);
    const SharedRays shared = make_shared_rays(eye, tables, 0);
    const DirectionTables of_rays = make_ray_tables(tables, shared);
    std::vector<float> all;
    for (const std::uint32_t warp : of_rays.warp_of) all.push_back(of_rays.footprint_rad[warp]);
    return all;
  };
  const std::vector<float> named = footprints();
  Acceptance pillbox;
  pillbox.kernel = Kernel::pillbox;
  pillbox.width_rad = static_cast<double>(eye.acceptance_angle_rad[0]);
  eye.acceptances = {pillbox};
  eye.acceptance_of.assign(eye.size(), 0);
  settings.kernel = {};
  EXPECT_EQ(footprints(), named);
}

TEST(SharedRays, AcceptanceZeroIsOneRayAlongTheAxis) {
  Eye eye = round_eye();
  for (std::size_t i = 0; i < eye.size(); i += 3) eye.acceptance_angle_rad[i] = 0;
  const SharedRays shared = shared_rays(eye, 4);
  for (std::size_t i = 0; i < eye.size(); i += 3) {
    const auto first = static_cast<std::size_t>(shared.first[i]);
    EXPECT_EQ(shared.weight[first], 1);
    const auto ray = static_cast<std::size_t>(shared.ray[first]);
    EXPECT_NEAR(length(to_double(shared.rays.axis[ray]) - to_double(eye.axis[i])), 0, 1e-6);
  }
}

// Two eyes 3 mm apart that look the same way, under one number and under two.
TEST(SharedRays, EyesApartDoNotShare) {
  for (const bool one_number : {true, false}) {
    Eye both, half = round_eye();
    for (const double side : {-1.0, 1.0}) {
      for (std::size_t i = 0; i < half.size(); ++i)
        half.position_m[i] = half.axis[i] * 0.0003f + to_float(Vec3d{side * 0.0015, 0, 0});
      if (!one_number) half.eye_id.assign(half.size(), side < 0 ? 0 : 1);
      append(both, half);
    }
    const SharedRays shared = shared_rays(both, 3);
    for (std::size_t i = 0; i < both.size(); ++i)
      for (auto k = shared.first[i]; k < shared.first[i + 1]; ++k) {
        const auto ray = static_cast<std::size_t>(shared.ray[static_cast<std::size_t>(k)]);
        ASSERT_EQ(shared.rays.position_m[ray].x < 0, both.position_m[i].x < 0);
      }
    // Two numbers in one place do not share either.
    if (!one_number) {
      Eye same_place = both;
      for (std::size_t i = 0; i < both.size(); ++i)
        same_place.position_m[i] = both.position_m[i % half.size()];
      const SharedRays apart = shared_rays(same_place, 3);
      for (std::size_t i = 0; i < both.size(); ++i)
        for (auto k = apart.first[i]; k < apart.first[i + 1]; ++k) {
          const auto ray = static_cast<std::size_t>(apart.ray[static_cast<std::size_t>(k)]);
          ASSERT_EQ(apart.rays.eye_id[ray], both.eye_id[i]);
        }
    }
  }
}

// A ray starts where the ommatidium nearest to its direction has its nodal point, behind the facet
// by the focal offset.
TEST(SharedRays, StartAtTheNearestOmmatidium) {
  Eye eye = round_eye();
  for (std::size_t i = 0; i < eye.size(); ++i)
    eye.focal_offset_m[i] = 1e-4f * static_cast<float>(1 + i % 4);
  const Eye rays = shared_rays(eye, 2).rays;
  for (std::size_t r = 0; r < rays.size(); ++r) {
    const Vec3d direction = to_double(rays.axis[r]);
    std::size_t nearest = 0;
    for (std::size_t i = 0; i < eye.size(); ++i)
      if (dot(to_double(eye.axis[i]), direction) > dot(to_double(eye.axis[nearest]), direction))
        nearest = i;
    const auto behind = [](const Eye& e, std::size_t i) {
      return to_double(e.position_m[i]) -
             to_double(e.axis[i]) * static_cast<double>(e.focal_offset_m[i]);
    };
    // Positions of some millimetres in floats: 1e-10 m.
    EXPECT_LT(length(behind(rays, r) - behind(eye, nearest)), 1e-9);
    EXPECT_EQ(rays.focal_offset_m[r], eye.focal_offset_m[nearest]);
  }
}

TEST(SharedRays, SeedsAndSetsDiffer) {
  const Eye eye = round_eye();
  const DirectionTables tables = make_direction_tables(eye, {}, 2);
  const SharedRays one = make_shared_rays(eye, tables, 0), again = make_shared_rays(eye, tables, 0);
  const SharedRays set = make_shared_rays(eye, tables, 1), seed = shared_rays(eye, 2, {}, 7);
  EXPECT_EQ(one.weight, again.weight);
  EXPECT_NE(one.weight, set.weight);
  EXPECT_NE(one.weight, seed.weight);
}

}  // namespace
}  // namespace omma::test
