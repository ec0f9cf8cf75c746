// A Scene into trees: one over all copies, one for each mesh that is shared, one over what is
// placed.
#include "backend/portable/portable_tracer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "backend/build_tree.h"
#include "model/transform.h"
#include "omma/error.h"
#include "physics/search/traverse.h"
#include "physics/surface/surface.h"
#include "threads/parallel.h"

namespace omma {
namespace {

// A mesh put into a tree.
struct Copy {
  const Mesh* mesh = nullptr;
  const std::vector<Vec3>* positions = nullptr;  // of the mesh as it is now
  Mat4 tree_from_mesh;
  std::uint32_t placed = 0;                          // as in TriangleQuad
  std::size_t first_triangle = 0, first_vertex = 0;  // of the tree's
};

struct Copies {
  std::vector<Copy> copies;
  std::vector<Vec3> vertex_m;  // [vertex of all copies], in the tree's frame
  std::size_t triangles = 0;
  bool deforms = false;  // so that triangles that cannot be hit now may be another time

  void add(const Mesh& mesh, const std::vector<Vec3>& positions, const Mat4& tree_from_mesh,
           std::uint32_t placed) {
    copies.push_back({&mesh, &positions, tree_from_mesh, placed, triangles, 0});
    triangles += mesh.triangles.size();
  }
  const Copy& of_triangle(std::size_t triangle) const {
    return *(std::upper_bound(copies.begin(), copies.end(), triangle,
                              [](std::size_t t, const Copy& c) { return t < c.first_triangle; }) -
             1);
  }
};

void corners_of(const Copies& tree, const Copy& copy, std::size_t triangle,
                Vector3<float> (&corner)[3]) {
  const std::array<std::uint32_t, 3>& vertices = copy.mesh->triangles[triangle];
  for (std::size_t i = 0; i < 3; ++i)
    corner[i] = vector_of(tree.vertex_m[copy.first_vertex + vertices[i]]);
}

Mat4 translation(Vec3d by) {
  Mat4 t;
  t.m[0][3] = by.x, t.m[1][3] = by.y, t.m[2][3] = by.z;
  return t;
}

// Whether the triangle has an area: its normal, as the search computes it, is not zero.
bool can_be_hit(const Vector3<float> (&corner)[3]) {
  const Vector3<float> normal = triangle_normal(corner);
  const float size = std::fabs(normal.x) + std::fabs(normal.y) + std::fabs(normal.z);
  return size > 0 && size <= std::numeric_limits<float>::max();
}

std::vector<BuildBox> boxes_of(const Copies& tree) {
  constexpr std::size_t chunk = 4096;
  std::vector<BuildBox> boxes(tree.triangles);
  std::vector<std::size_t> kept((tree.triangles + chunk - 1) / chunk);
  parallel_for(std::size_t{0}, kept.size(), [&](std::size_t k) {
    std::size_t out = k * chunk;
    for (std::size_t t = k * chunk; t < std::min((k + 1) * chunk, tree.triangles); ++t) {
      const Copy& copy = tree.of_triangle(t);
      Vector3<float> corner[3];
      corners_of(tree, copy, t - copy.first_triangle, corner);
      if (!tree.deforms && !can_be_hit(corner)) continue;
      BuildBox& box = boxes[out++];
      box.index = static_cast<std::uint32_t>(t);
      for (int a = 0; a < 3; ++a) {
        box.lower[a] = std::min({corner[0][a], corner[1][a], corner[2][a]});
        box.upper[a] = std::max({corner[0][a], corner[1][a], corner[2][a]});
      }
    }
    kept[k] = out - k * chunk;
  });
  std::size_t out = 0;
  for (std::size_t k = 0; k < kept.size(); ++k)
    for (std::size_t i = 0; i < kept[k]; ++i) boxes[out++] = boxes[k * chunk + i];
  boxes.resize(out);
  return boxes;
}

void write_block(const Copies& tree, const std::uint32_t* order, TriangleQuad& block) {
  for (int k = 0; k < quad_width; ++k) {
    Vector3<float> corner[3];
    bool is_there = order[k] != none;
    if (is_there) {
      const Copy& copy = tree.of_triangle(order[k]);
      const std::size_t triangle = order[k] - copy.first_triangle;
      corners_of(tree, copy, triangle, corner);
      is_there = can_be_hit(corner);
      block.triangle[k] = static_cast<std::uint32_t>(triangle);
      block.placed[k] = copy.placed;
    } else {
      block.triangle[k] = block.placed[k] = none;
    }
    for (int i = 0; i < 3; ++i)
      for (int a = 0; a < 3; ++a)
        block.corner[i][a][k] = is_there ? corner[i][a] : std::numeric_limits<float>::quiet_NaN();
  }
}

// Builds a tree of triangles behind those that there are.
TreeRoot add_tree(PortableTracer& tracer, Copies& tree) {
  TreeRoot place;
  std::size_t vertices = 0;
  for (Copy& copy : tree.copies) {
    copy.first_vertex = vertices;
    vertices += copy.positions->size();
  }
  tree.vertex_m.resize(vertices);
  for (const Copy& copy : tree.copies)
    parallel_for(std::size_t{0}, copy.positions->size(), [&](std::size_t i) {
      tree.vertex_m[copy.first_vertex + i] =
          to_float(transform_point(copy.tree_from_mesh, to_double((*copy.positions)[i])));
    });
  std::vector<BuildBox> boxes = boxes_of(tree);
  if (boxes.empty()) return place;
  std::fill(place.lower, place.lower + 3, std::numeric_limits<float>::infinity());
  std::fill(place.upper, place.upper + 3, -std::numeric_limits<float>::infinity());
  for (const BuildBox& box : boxes)
    for (std::size_t a = 0; a < 3; ++a) {
      place.lower[a] = std::min(place.lower[a], box.lower[a]);
      place.upper[a] = std::max(place.upper[a], box.upper[a]);
    }
  BuiltTree built = build_tree(boxes, {quad_width, quad_width, most_tree_depth});
  boxes = {};
  const std::size_t first_node = tracer.nodes.size(), first_block = tracer.quads.size();
  const std::size_t blocks = built.order.size() / quad_width;
  constexpr std::size_t index_capacity = std::size_t{1} << visit_index_bits;
  if (first_node + built.nodes.size() > index_capacity || first_block + blocks > index_capacity)
    throw Error("portable: at most " + std::to_string(index_capacity) +
                " blocks of triangles are possible, found " + std::to_string(first_block + blocks));
  for (WideNode& node : built.nodes) {
    node.first_child += static_cast<std::uint32_t>(first_node);
    node.first_leaf += static_cast<std::uint32_t>(first_block);
  }
  tracer.nodes.insert(tracer.nodes.end(), built.nodes.begin(), built.nodes.end());
  tracer.quads.resize(first_block + blocks);
  parallel_for(std::size_t{0}, blocks, [&](std::size_t b) {
    write_block(tree, built.order.data() + b * quad_width, tracer.quads[first_block + b]);
  });
  place.index = static_cast<std::uint32_t>(first_node);
  place.end = static_cast<std::uint32_t>(tracer.nodes.size());
  return place;
}

// The box around a placed tree, a little wider than it is: rays go into its frame in single
// precision.
void placed_box(const TreeRoot& place, const Mat4& frame_from_tree, BuildBox& box) {
  double lower[3], upper[3], furthest = 0;
  for (int a = 0; a < 3; ++a) {
    const double(&row)[4] = frame_from_tree.m[a];
    lower[a] = upper[a] = row[3];
    double size = std::fabs(row[3]);
    for (int k = 0; k < 3; ++k) {
      const double p = row[k] * static_cast<double>(place.lower[k]);
      const double q = row[k] * static_cast<double>(place.upper[k]);
      lower[a] += std::min(p, q);
      upper[a] += std::max(p, q);
      size += std::max(std::fabs(p), std::fabs(q));
    }
    furthest = std::max(furthest, size);
  }
  for (int a = 0; a < 3; ++a) {
    box.lower[a] = static_cast<float>(lower[a] - 1e-6 * furthest);
    box.upper[a] = static_cast<float>(upper[a] + 1e-6 * furthest);
  }
}

// The tree over what is placed.
void build_top(PortableTracer& tracer) {
  std::vector<PlacedTree> trees;
  std::vector<BuildBox> boxes;
  const auto add = [&](const TreeRoot& root, const Mat4& frame_from_tree, std::uint32_t placed) {
    if (root.index == none) return;
    boxes.emplace_back().index = static_cast<std::uint32_t>(trees.size());
    placed_box(root, frame_from_tree, boxes.back());
    const Mat4 tree_from_frame = inverse(frame_from_tree);
    const std::uint32_t seen_by = placed == none ? all_seen : tracer.layout.placed[placed].seen_by;
    trees.push_back({{}, root.index, placed, seen_by});
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 4; ++c)
        trees.back().tree_from_frame[r][c] = static_cast<float>(tree_from_frame.m[r][c]);
  };
  add(tracer.copies, {}, none);
  for (std::size_t i = 0; i < tracer.layout.instances.size(); ++i) {
    const PlacedInstance& instance = tracer.layout.instances[i];
    if (instance.is_shared)
      add(tracer.of_mesh[static_cast<std::size_t>(instance.mesh)], instance.frame_from_mesh,
          static_cast<std::uint32_t>(i));
  }
  BuiltTree built = build_tree(boxes, {1, 1, most_top_depth});
  tracer.top_nodes = std::move(built.nodes);
  tracer.trees.clear();
  for (const std::uint32_t tree : built.order) tracer.trees.push_back(trees[tree]);
  tracer.frames.clear();
  for (const PlacedInstance& instance : tracer.layout.instances) {
    const Vec3d origin = tracer.layout.mesh_origin_m[static_cast<std::size_t>(instance.mesh)];
    tracer.frames.push_back({instance.frame_from_mesh, instance.is_shared ? origin : Vec3d{}});
  }
  const auto count = [](const auto& values) { return static_cast<std::int64_t>(values.size()); };
  tracer.view = {tracer.top_nodes.empty() ? nullptr : tracer.top_nodes.data(),
                 tracer.trees.data(),
                 tracer.nodes.data(),
                 tracer.quads.data(),
                 tracer.layout.placed.data(),
                 tracer.frames.data(),
                 count(tracer.top_nodes),
                 count(tracer.trees),
                 count(tracer.nodes),
                 count(tracer.quads),
                 count(tracer.layout.placed),
                 count(tracer.frames),
                 tracer.triangles_version,
                 new_version()};
}

// The corners of the k-th triangle of a quad, as they are now.
void place_corners(TriangleQuad& quad, int k, const std::vector<Vec3>& vertex_m,
                   const std::array<std::uint32_t, 3>& vertices) {
  Vector3<float> corner[3];
  for (std::size_t i = 0; i < 3; ++i) corner[i] = vector_of(vertex_m[vertices[i]]);
  const bool is_there = can_be_hit(corner);
  for (int i = 0; i < 3; ++i)
    for (int a = 0; a < 3; ++a)
      quad.corner[i][a][k] = is_there ? corner[i][a] : std::numeric_limits<float>::quiet_NaN();
}

// Gives a tree of a mesh the shape that this has now.
void refit_mesh(PortableTracer& tracer, std::size_t mesh, const Placement& placement) {
  TreeRoot& root = tracer.of_mesh[mesh];
  if (root.index == none) return;
  tracer.triangles_version = new_version();
  const Mesh& own = tracer.scene->meshes[mesh];
  const std::vector<Vec3>& positions = positions_of(*tracer.scene, placement, mesh);
  const Vec3d origin = tracer.layout.mesh_origin_m[mesh];
  std::vector<Vec3> vertex_m(own.positions.size());  // in the tree's frame
  for (std::size_t i = 0; i < vertex_m.size(); ++i)
    vertex_m[i] = to_float(to_double(positions[i]) - origin);
  const std::span<WideNode> nodes(&tracer.nodes[root.index], root.end - root.index);
  constexpr std::size_t nodes_per_task = 64;  // some hundred triangles each
  parallel_ranges(
      std::size_t{0}, nodes.size(), nodes_per_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
          const WideNode& node = nodes[n];
          for (int c = node.counts & 15; c < node.counts >> 4; ++c) {
            TriangleQuad* blocks =
                &tracer.quads[node.first_leaf + static_cast<std::size_t>(node.leaf[c] >> 4)];
            for (int t = 0; t < (node.leaf[c] & 15); ++t) {
              TriangleQuad& block = blocks[t / quad_width];
              const int k = t % quad_width;
              place_corners(block, k, vertex_m, own.triangles[block.triangle[k]]);
            }
          }
        }
      });
  const BuildBox box = refit_tree(nodes, root.index, tracer.quads.data());
  if (!(box.lower[0] <= box.upper[0])) return;  // flattened to a point: nothing of it can be met
  std::copy_n(box.lower, 3, root.lower);
  std::copy_n(box.upper, 3, root.upper);
}

bool may_ask(const SceneView& view, std::int32_t mesh) {
  const MaterialView& material = view.materials[view.meshes[mesh].material];
  return may_reject(material) || lets_rays_on(material);
}

// All trees. Each is a part of the work as large as its triangles.
void build_all(PortableTracer& tracer, const Placement& placement, WorkState* work) {
  const Scene& scene = *tracer.scene;
  tracer.layout = lay_out_scene(scene, placement);
  tracer.nodes.clear();
  tracer.quads.clear();
  tracer.of_mesh.assign(scene.meshes.size(), {});

  Copies copies;
  std::vector<Copies> shared(scene.meshes.size());
  std::size_t all_triangles = 0, built_triangles = 0;
  for (std::size_t i = 0; i < tracer.layout.instances.size(); ++i) {
    const PlacedInstance& instance = tracer.layout.instances[i];
    const auto m = static_cast<std::size_t>(instance.mesh);
    const std::uint32_t ask =
        may_ask(*tracer.scene_view, instance.mesh) ? ask_flag : std::uint32_t{0};
    const std::vector<Vec3>& positions = positions_of(scene, placement, m);
    if (!instance.is_shared) {
      copies.add(scene.meshes[m], positions, instance.frame_from_mesh,
                 static_cast<std::uint32_t>(i) | ask);
    } else if (shared[m].copies.empty()) {
      shared[m].deforms = !placement.shapes[m].positions.empty();
      shared[m].add(scene.meshes[m], positions, translation(tracer.layout.mesh_origin_m[m] * -1.0),
                    ask);
    } else {
      continue;
    }
    all_triangles += scene.meshes[m].triangles.size();
  }
  const auto build = [&](Copies& tree) {
    const TreeRoot root = add_tree(tracer, tree);
    built_triangles += tree.triangles;
    tree = {};
    if (work != nullptr)
      work->reach(static_cast<double>(built_triangles) / static_cast<double>(all_triangles));
    return root;
  };
  tracer.copies = copies.triangles > 0 ? build(copies) : TreeRoot{};
  for (std::size_t m = 0; m < shared.size(); ++m)
    if (shared[m].triangles > 0) tracer.of_mesh[m] = build(shared[m]);
  build_top(tracer);
}

}  // namespace

std::unique_ptr<PortableTracer> make_portable_tracer(const Scene& scene, const SceneView& view,
                                                     const Placement& placement, WorkState* work) {
  auto tracer = std::make_unique<PortableTracer>();
  tracer->scene = &scene;
  tracer->scene_view = &view;
  build_all(*tracer, placement, work);
  return tracer;
}

void move_instances(PortableTracer& tracer, std::span<const int> instances,
                    std::span<const int> meshes, const Placement& placement) {
  for (const int mesh : meshes) refit_mesh(tracer, static_cast<std::size_t>(mesh), placement);
  for (const int instance : instances) {
    const std::int32_t index = tracer.layout.index_of[static_cast<std::size_t>(instance)];
    if (index >= 0) place_instance(tracer.layout, static_cast<std::size_t>(index), placement);
  }
  build_top(tracer);
}

}  // namespace omma
