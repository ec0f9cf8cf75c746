// The world: a scene ready to be seen, before a background, with things in it that can be moved
// between two frames. Made once and seen by any number of renderers.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "omma/bake.h"
#include "omma/error.h"
#include "omma/light.h"
#include "omma/scene.h"
#include "omma/vec.h"

namespace omma {

// How a world is lit: by paths of light, from the eye to what shines; or by light that was baked
// (bake_light), and by paths to discs and lamps and along gloss.
struct Lighting {
  Light light;
  int depth = 0;           // most scatterings on a path, at most most_depth; 0: as many as it takes
  bool polarized = false;  // radiance is then a Stokes vector, I, Q and U
  std::shared_ptr<const BakedLight> baked;  // in this light; null: all by paths
  // With baked light: how much of the sun surfaces see is looked up in a shadow map of things as they
  // lie when the world is lit. For worlds with one disc and no surface that light goes straight
  // through.
  bool sun_map = false;
};
inline constexpr int most_depth = 1000;

struct WorldSettings {
  int threads = 0;                                      // that build it and take pictures; 0: all
  std::optional<Background> background = std::nullopt;  // instead of the scene's own
  // What traces the rays: "embree", "portable", or "" for the fastest that is built in.
  std::string backend = "";
  // Ordinals of the graphics cards that share the work, each once; empty: the first one. Only with
  // the backend "cuda".
  std::vector<int> devices = {};
  // What linear RGB, as textures, colours and backgrounds have it, is in each band: [band][3], 1 to
  // most_bands rows. Empty: the bands are RGB itself. Not where the world is lit, whose light has
  // bands.
  std::vector<double> band_from_rgb = {};
  // None: surfaces show their base colour and emission, as they are. A lit world has its light's sky
  // instead of a background.
  std::optional<Lighting> lighting = std::nullopt;
};

// Something that can be moved: a node of the file with all its primitives, or an instance of a
// scene made in memory that belongs to no node.
struct WorldInstance {
  std::string name;      // of the node; need not be the only one of that name
  Mat4 world_from_node;  // where it is now, m
};

// Seconds spent when the world was made.
struct WorldBuildTimes {
  double scene_s = 0;         // shading data
  double acceleration_s = 0;  // acceleration structure
};

// A handle: copies are the same world, and so are those in renderers. What is moved through one has
// moved for all.
class World {
 public:
  struct State;  // src/world/world_state.h

  // Builds the acceleration structure; throws omma::Error. The scene must stay as it is: its arrays
  // are read from where they are. `progress` is told of the finished part (0 to 1) several times a
  // second; false throws omma::Cancelled. In a process forked from one that had used threads
  // omma::Error is thrown: Embree cannot build there.
  explicit World(std::shared_ptr<const Scene> scene, WorldSettings settings = {},
                 const std::function<bool(double)>& progress = {});

  // The same world, whose things are where they are in this one and move with them, seen before
  // another background.
  World with_background(const Background& background) const;

  // The same world in another light.
  World with_lighting(Lighting lighting) const;

  // As it was given: where things are now, instances() says.
  const Scene& scene() const;
  // [instance], in the order of the scene's instances.
  std::vector<WorldInstance> instances() const;
  // Index into instances(); throws omma::Error where none has that name, with those that are nearly
  // called so, or where several have, with their indices.
  int find_instance(const std::string& name) const;

  // Moves things: instances()[instances[i]] to world_from_node[i], for all renderers. A mirrored
  // transform is as good as any, a flattened one is not. What was never moved stays as it was
  // built; moving something for the first time builds that part again, without it, which
  // `progress` is told of and can end. From then on only the boxes around things are touched.
  //
  // Not while anything of this world is being rendered: then, and where an index is out of range or
  // given twice, a transform cannot be used (one that is not finite or not invertible, stretches by
  // less than 1e-15, more than 1e15 or 1e5 times as much one way as another, or takes a surface
  // over 1e12 m away), or in a process forked from one that had used threads, omma::Error is
  // thrown. Whatever is thrown, all is where it was.
  void set_transforms(std::span<const int> instances, std::span<const Mat4> world_from_node,
                      const std::function<bool(double)>& progress = {});

  // Gives a mesh of the scene another shape, for all its instances and all renderers; the scene
  // keeps its own. `positions`: of each of its vertices, m; `normals` likewise: none given, a mesh
  // that has normals gets those of its triangles. The first time costs what moving something for
  // the first time does, and its instances count as moved.
  //
  // Errors as of set_transforms, and where sizes are not the mesh's or a number is not finite.
  void set_vertices(int mesh, std::span<const Vec3> positions, std::span<const Vec3> normals = {},
                    const std::function<bool(double)>& progress = {});

  // Moves all that the scene's animations move to where it is at a time, s, and gives meshes their
  // shape then: in those animations (indices; none: all), and before the first key as at the first,
  // after the last as at the last. What other animations of the scene move is as the file has it.
  //
  // Errors as of set_transforms, and where there is no such animation or two of them move the same.
  void set_time(double time_s, std::span<const int> animations = {},
                const std::function<bool(double)>& progress = {});

  // Gives an image of the scene another content of the same size, as of a screen, or a material
  // another colour and light of its own, for all renderers; the scene keeps its own. An image whose
  // alpha cuts out or lets light through stays as it is, and so does the alpha of a colour. Only in
  // worlds that were never lit, whose light goes by the colours it was made for.
  //
  // Errors as of set_transforms, and where there is no such image or material, a size is another or
  // a number is not finite or below 0.
  void set_image(int image, Image picture);
  void set_color(int material, Vec3 base_color, Vec3 emissive);

  // Indices into instances() of what set_time moves.
  std::vector<int> animated() const;
  // Where they are at a time (their world_from_node, in that order); moves nothing.
  std::vector<Mat4> animated_at(double time_s, std::span<const int> animations = {}) const;
  // Indices of the scene's meshes that have another shape than the scene says; and the vertices of a
  // mesh as it is now: positions, m, and normals, where it has any.
  std::vector<int> reshaped() const;
  std::vector<Vec3> positions(int mesh) const;
  std::vector<Vec3> normals(int mesh) const;

  // As Renderer::precision_warning, of the things where they are now.
  std::string precision_warning(std::span<const Mat4> world_from_head) const;
  // What of these poses nobody means: one that mirrors or stretches the head and is no camera's, or
  // one far outside of the scene that would be inside in millimetres. "" where all can be meant.
  std::string pose_slip(std::span<const Mat4> world_from_head) const;

  const WorldSettings& settings() const;
  const WorldBuildTimes& build_times() const;
  int bands() const;            // numbers that radiance has, of each component
  int components() const;       // of radiance: 1, or 3 where it is a Stokes vector
  int threads() const;          // that it uses
  std::string backend() const;  // e.g. "embree 3.13.5"
  // Ordinals of the graphics cards that trace its rays; none where a processor does.
  std::vector<int> cards() const;

  const State& state() const { return *state_; }

 private:
  World() = default;

  std::shared_ptr<const State> state_;
};

}  // namespace omma
