// The scenes, eyes and poses that are measured, and how time is taken. CompoundRay's scenes and
// eyes are used where that data lies beside the clone; the rest is bundled or made here.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "omma/omma.h"

namespace omma::bench {

struct Setup {
  std::string name;
  std::shared_ptr<const Scene> scene;
  Eye eye;
  std::vector<Mat4> poses;
};

// Whether CompoundRay's scenes and eyes are there; says on standard error what is left out if not.
bool have_data(const char* left_out);
std::string data_folder();

// A real honeybee's eyes, 6,374 ommatidia, or the bundled ones, 10,760, where that is missing.
Eye bee_eye();
// CompoundRay's eye of 1,000 ommatidia; needs the data.
Eye thousand_eye();
// So many axes spread evenly over the sphere (a Fibonacci spiral), 3 degrees each.
Eye even_eye(int n);
// One n-th of an eye, all ommatidia that look to the left of the middle: from the ground to the sky,
// and each with its neighbours.
Eye sector(const Eye& eye, std::size_t n);

// natural-standin-sky.gltf, just above the ground in the middle, where CompoundRay's cameras stand.
Setup meadow();
// ofstad-arena.gltf from its compound camera, at unit scale.
Setup arena();
// The bundled meadow with its bee: cut-outs, many meshes, much overlap.
Setup bundled();
// Its version for light, which is without painted shade.
Setup bundled_lit();
// The bundled one with its cut-outs opaque: what cutting out costs.
Setup bundled_opaque();
// 2 cells^2 triangles of rolling ground over a square kilometre, textured with a checkerboard.
Setup hills(int cells);
// A plane of squares 0.05 m wide, seen from 1.5 m above.
Setup checkerboard();

// Poses on a small circle around the first one of a setup, turning with it.
std::vector<Mat4> flight(const Setup& setup, std::size_t count);

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start);
// The shortest of at least three times that `work` takes, and of more until `least_s` has passed.
double best_seconds(double least_s, const std::function<void()>& work);

// Each prints a table as CSV. Quick ones take a few seconds and mean nothing.
void ceiling(bool quick);
void error(bool quick);
void frames(bool quick);
void latency(bool quick);
void threads(bool quick);
void kernels(bool quick);
void search(bool quick);
void moving(bool quick);
void closed(bool quick);
void worlds(bool quick);
void sun_map(bool quick);
void build(const std::string& name, const std::string& scene_file);
// One fixed small render on one thread, for counting instructions.
void instructions(const std::string& which);

}  // namespace omma::bench
