// Splats of clouds, placed in the traced frame and whitened; boxes around what of them counts, in a
// tree.
#include "backend/splat_data.h"

#include <algorithm>
#include <cmath>

#include "backend/build_tree.h"
#include "model/new_version.h"
#include "model/scene_place.h"
#include "model/transform.h"
#include "omma/error.h"
#include "physics/search/traverse.h"
#include "threads/parallel.h"

namespace omma {
namespace {

// Standard deviations below this fraction of a splat's largest count as that: flat splats stay
// flat, while single precision still knows on which side of one a ray is.
constexpr double least_thickness = 1e-4;

static_assert(splat_channels_kept == most_splat_channels);

// A splat in the traced frame.
struct Placed {
  Mat4 frame_from_splat;  // of its own axes, as long as its standard deviations, about its middle
  double most_square;     // see TracedSplat; below 0 where it never counts
};

Placed placed_splat(const SplatCloud& cloud, std::size_t i, const Mat4& frame_from_cloud) {
  const Vec3d at = to_double(cloud.positions[i]), s = to_double(cloud.scales[i]);
  const double least = least_thickness * std::max({s.x, s.y, s.z});
  const Vec4 q = cloud.rotations[i];
  const Mat4 cloud_from_splat =
      transform_of({at.x, at.y, at.z},
                   {static_cast<double>(q.x), static_cast<double>(q.y), static_cast<double>(q.z),
                    static_cast<double>(q.w)},
                   {std::max(s.x, least), std::max(s.y, least), std::max(s.z, least)});
  const double opacity = static_cast<double>(cloud.opacities[i]);
  const double most_square = 2 * std::log(opacity / static_cast<double>(least_splat_alpha));
  return {frame_from_cloud * cloud_from_splat, opacity > 0 ? most_square : -1};
}

// The box around where a splat counts.
BuildBox box_of(const Placed& splat, std::uint32_t index) {
  BuildBox box;
  box.index = index;
  const double radius = std::sqrt(splat.most_square);
  for (int a = 0; a < 3; ++a) {
    const auto& row = splat.frame_from_splat.m[a];
    const double half = radius * std::hypot(row[0], row[1], row[2]);
    box.lower[a] = static_cast<float>(row[3] - half);
    box.upper[a] = static_cast<float>(row[3] + half);
  }
  return box;
}

TracedSplat traced(const Placed& splat, float opacity, std::uint32_t cloud, std::uint32_t index) {
  TracedSplat made = {};
  const Mat4 whitening = inverse(splat.frame_from_splat);
  for (int r = 0; r < 3; ++r) {
    made.center[r] = static_cast<float>(splat.frame_from_splat.m[r][3]);
    for (int c = 0; c < 3; ++c) made.whitening[r][c] = static_cast<float>(whitening.m[r][c]);
  }
  made.opacity = opacity;
  made.most_square = static_cast<float>(splat.most_square);
  made.cloud = cloud;
  made.splat = index;
  return made;
}

// Which cloud a splat is of, counted over all, and its index there.
struct Numbered {
  std::vector<std::size_t> first;  // [cloud + 1]

  std::pair<std::size_t, std::size_t> at(std::size_t index) const {
    const auto cloud = static_cast<std::size_t>(
        std::upper_bound(first.begin(), first.end(), index) - first.begin() - 1);
    return {cloud, index - first[cloud]};
  }
};

}  // namespace

std::unique_ptr<SplatData> make_splat_data(const Scene& scene, Vec3d origin_m,
                                           const float* first_origin_now_m, WorkState* work) {
  Numbered numbers{{0}};
  std::vector<Mat4> frame_from_cloud;
  for (const SplatCloud& cloud : scene.splats) {
    numbers.first.push_back(numbers.first.back() + cloud.positions.size());
    Mat4 m = cloud.world_from_splats;
    m.m[0][3] -= origin_m.x, m.m[1][3] -= origin_m.y, m.m[2][3] -= origin_m.z;
    frame_from_cloud.push_back(m);
  }
  const std::size_t count = numbers.first.back();
  const auto place = [&](std::size_t index) {
    const auto [cloud, splat] = numbers.at(index);
    return placed_splat(scene.splats[cloud], splat, frame_from_cloud[cloud]);
  };

  std::vector<BuildBox> boxes(count);
  std::vector<char> counts(count);
  parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    const Placed splat = place(i);
    counts[i] = splat.most_square >= 0;
    if (counts[i]) boxes[i] = box_of(splat, static_cast<std::uint32_t>(i));
  });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; ++i)
    if (counts[i]) boxes[kept++] = boxes[i];
  boxes.resize(kept);
  if (kept == 0) return nullptr;
  if (work != nullptr) work->reach(0.1);

  auto data = std::make_unique<SplatData>();
  BuiltTree built = build_tree(boxes, {splats_per_leaf, splats_per_block, most_tree_depth});
  boxes = {};
  if (built.order.size() / splats_per_block >= std::size_t{1} << visit_index_bits)
    throw Error("splats: at most " + std::to_string(std::size_t{1} << visit_index_bits) +
                " pairs are possible, found " + std::to_string(count) + " splats");
  if (work != nullptr) work->reach(0.4);
  data->nodes = std::move(built.nodes);
  data->splats.resize(built.order.size());
  parallel_for(std::size_t{0}, built.order.size(), [&](std::size_t i) {
    const std::uint32_t index = built.order[i];
    if (index == none) {
      data->splats[i] = {};
      data->splats[i].most_square = -1;
      return;
    }
    const auto [cloud, splat] = numbers.at(index);
    data->splats[i] = traced(place(index), scene.splats[cloud].opacities[splat],
                             static_cast<std::uint32_t>(cloud), static_cast<std::uint32_t>(splat));
  });

  for (std::size_t i = 0; i < scene.splats.size(); ++i) {
    const SplatCloud& cloud = scene.splats[i];
    SplatCloudView view;
    const Mat4 cloud_from_frame = inverse(frame_from_cloud[i]);
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        view.cloud_from_frame[r][c] = static_cast<float>(cloud_from_frame.m[r][c]);
    view.harmonics = cloud.harmonics.data();
    view.splat_count = static_cast<std::int32_t>(cloud.positions.size());
    view.terms = cloud.terms;
    view.channels = static_cast<std::int32_t>(channels_of(cloud));
    view.by_ray = cloud.direction == SplatDirection::ray;
    data->clouds.push_back(view);
    data->box =
        box_around(data->box, placed_box(vertex_bounds(cloud.positions), cloud.world_from_splats));
  }
  data->view = {data->nodes.data(),
                data->splats.data(),
                data->clouds.data(),
                first_origin_now_m,
                scene.splats.front().color_space == SplatColor::srgb,
                {},
                static_cast<std::int32_t>(channels_of(scene.splats.front())),
                static_cast<std::int64_t>(data->nodes.size()),
                static_cast<std::int64_t>(data->splats.size()),
                static_cast<std::int32_t>(data->clouds.size()),
                new_version()};
  const std::vector<float>& white = scene.splats.front().white;
  std::copy(white.begin(), white.end(), data->view.white);
  return data;
}

}  // namespace omma
