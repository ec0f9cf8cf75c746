// Rig and Animation for Python: how things of a scene move in time, read from a file. Opaque but for
// what animations there are.
#include <nanobind/nanobind.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include <cstdio>

#include "omma/rig.h"
#include "scene_parts.h"
#include "struct_values.h"

namespace omma::python {

namespace {

std::string seconds(double time_s) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g s", time_s);
  return text;
}

}  // namespace

void bind_rig(nb::module_& m) {
  nb::class_<Animation> animation(m, "Animation", "An animation of a scene's file.");
  animation.def_ro("name", &Animation::name, "As the file has it; '' where it has none.")
      .def_ro("duration_s", &Animation::duration_s, "When its last key is, s.")
      .def("__repr__", [](const Animation& one) {
        return named("Animation", one.name) + ", " + seconds(one.duration_s) + ">";
      });
  def_struct_value(
      animation, [](const Animation&) {},
      [](const Animation& one) { return hash_of(one.name, one.channels.size()); });

  nb::class_<Rig> rig(
      m, "Rig",
      "How things of a scene move and change their shape: nodes, bones, morph targets and\n"
      "animations, as its file says. It goes with the scene's meshes, nodes and cameras:\n"
      "`Scene.replace` keeps it.");
  rig.def(nb::init<>(), "One in which nothing moves.");
  rig.def("__repr__", [](const Rig& one) {
    return "<omma.scene.Rig of " + counted(one.animations.size(), "animations, ") +
           counted(one.nodes.size(), "nodes, ") +
           counted(one.deformations.size(), "meshes that change their shape>");
  });
  def_struct_value(
      rig, [](const Rig&) {},
      [](const Rig& one) { return one.nodes.size() ^ one.deformations.size() << 8; });

  m.def(
      "placed_rig",
      [](const Rig& one, nb::handle world_from_scene) {
        return placed_rig(one, mat4(world_from_scene, "world_from_scene"));
      },
      nb::arg("rig"), nb::arg("world_from_scene"),
      nb::sig("def placed_rig(rig: Rig, world_from_scene: numpy.typing.ArrayLike) -> Rig"));
  m.def("with_scaled_cameras", &with_scaled_cameras, nb::arg("rig"), nb::arg("factor"),
        "The same rig with cameras, and so eyes, that are larger by a factor.");
  m.def(
      "joined_rig",
      [](const Rig& one, const Rig& other, int meshes, int cameras, int nodes) {
        Rig joined = one;
        append_rig(joined, other, {meshes, cameras, nodes});
        return joined;
      },
      nb::arg("rig"), nb::arg("other"), nb::arg("meshes"), nb::arg("cameras"), nb::arg("nodes"),
      "The rig of two scenes, where so many meshes, cameras and nodes come before the second's.");
}

}  // namespace omma::python
