// Scene for Python: read from a file or made of its parts, then read-only and shared with the
// worlds that use it.
#include <nanobind/nanobind.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <memory>

#include "model/scene_place.h"
#include "model/text.h"
#include "model/texture_uses.h"
#include "omma/camera.h"
#include "omma/error.h"
#include "omma/io.h"
#include "omma/rig.h"
#include "omma/scene.h"
#include "progress.h"
#include "scene_text.h"
#include "threads/parallel.h"
#include "values.h"

namespace omma::python {

namespace {

constexpr Words<ColorRule, 2> color_rules = {
    {{"gltf", ColorRule::gltf}, {"compoundray", ColorRule::compoundray}}};

// What makes an equal scene: keywords of the constructor and properties, both.
const std::vector<const char*> fields = {"meshes", "instances",  "materials",  "textures",
                                         "images", "cameras",    "hit_boxes",  "lights",
                                         "splats", "background", "color_rule", "rig"};

// A list of parts of one kind; None gives an empty one.
template <typename T>
std::vector<T> parts(nb::handle list, const char* name) {
  const std::string kind = "omma.scene." + str_of(nb::type<T>().attr("__name__"));
  const auto refuse = [&](const std::string& what, nb::handle found) {
    throw nb::type_error((what + ": expected " + kind + ", found " + type_name_of(found)).c_str());
  };
  if (nb::isinstance<T>(list) || nb::isinstance<nb::str>(list) || !nb::hasattr(list, "__iter__"))
    throw nb::type_error(
        (std::string(name) + ": expected a list of " + kind + ", found " + type_name_of(list))
            .c_str());
  std::vector<T> made;
  for (nb::handle item : nb::iter(list)) {
    if (!nb::isinstance<T>(item))
      refuse(std::string(name) + "[" + std::to_string(made.size()) + "]", item);
    made.push_back(nb::cast<const T&>(item));
  }
  return made;
}

// Of what is given by name, one of `fields` each; None is not, where there is a default that
// depends on the others.
Scene made_scene(const nb::dict& given) {
  for (const auto& [name, value] : given)
    if (std::find(fields.begin(), fields.end(), str_of(name)) == fields.end())
      throw nb::type_error(
          ("Scene() got an unexpected keyword argument '" + str_of(name) + "'").c_str());
  const auto has = [&](const char* name) {
    return given.contains(name) && !nb::object(given[name]).is_none();
  };
  const auto take_parts = [&]<typename T>(const char* name, std::vector<T>& list) {
    if (given.contains(name)) list = parts<T>(given[name], name);
  };
  Scene scene;
  take_parts("meshes", scene.meshes);
  if (has("instances"))
    take_parts("instances", scene.instances);
  else
    for (std::size_t i = 0; i < scene.meshes.size(); ++i)
      scene.instances.push_back({scene.meshes[i].name, static_cast<int>(i), {}, -1});
  take_parts("materials", scene.materials);
  take_parts("images", scene.images);
  if (has("textures"))
    take_parts("textures", scene.textures);
  else
    for (std::size_t i = 0; i < scene.images.size(); ++i)
      scene.textures.push_back({static_cast<int>(i)});
  take_parts("cameras", scene.cameras);
  take_parts("hit_boxes", scene.hit_boxes);
  take_parts("lights", scene.lights);
  take_parts("splats", scene.splats);
  if (has("background")) {
    const nb::object background = given["background"];
    if (!nb::isinstance<Background>(background))
      throw nb::type_error(
          ("background: expected omma.Background, found " + type_name_of(background)).c_str());
    scene.background = nb::cast<const Background&>(background);
  }
  if (given.contains("color_rule"))
    scene.color_rule = word_argument(color_rules, given["color_rule"], "color_rule");
  if (has("rig")) {
    const nb::object rig = given["rig"];
    if (!nb::isinstance<Rig>(rig))
      throw nb::type_error(("rig: expected omma.scene.Rig, found " + type_name_of(rig)).c_str());
    scene.rig = nb::cast<std::shared_ptr<Rig>>(rig);
  }
  validate_scene(scene);
  scene.warnings = place_warnings(scene);
  for (std::string& sentence : coordinate_warnings(scene))
    scene.warnings.push_back(std::move(sentence));
  return scene;
}

// From what __getstate__ gives: the fields by name, and where it came from.
Scene restored(const nb::tuple& state) {
  if (state.size() != 5 || !nb::isinstance<nb::dict>(state[0]))
    throw Error("state: expected that of a scene");
  Scene scene = made_scene(nb::cast<nb::dict>(state[0]));
  scene.path = path_text(state[1]);
  scene.warnings = nb::cast<std::vector<std::string>>(state[2]);
  scene.scene_names = nb::cast<std::vector<std::string>>(state[3]);
  scene.node_count = nb::cast<int>(state[4]);
  return scene;
}

// The scene's own parts, not copies: they keep the scene.
template <typename T>
nb::list own_parts(nb::handle self, std::vector<T> Scene::*list) {
  nb::list found;
  for (T& part : nb::cast<Scene&>(self).*list)
    found.append(nb::cast(&part, nb::rv_policy::reference_internal, self));
  return found;
}

nb::object corners(const Bounds& box) {
  if (box.empty) return nb::none();
  return take(std::vector<double>{box.lower.x, box.lower.y, box.lower.z, box.upper.x, box.upper.y,
                                  box.upper.z},
              {2, 3});
}

// All hit boxes of that name: a mesh in several places is several of them.
std::vector<const HitBox*> hit_boxes_called(const Scene& scene, const std::string& name) {
  std::vector<const HitBox*> found;
  std::string names;
  for (const HitBox& box : scene.hit_boxes) {
    if (box.name == name) found.push_back(&box);
    names += (names.empty() ? "'" : ", '") + box.name + "'";
  }
  if (found.empty())
    throw Error((scene.path.empty() ? "scene" : scene.path) + ": there is no hit box '" + name +
                "'; " + (names.empty() ? "the scene has none" : "there are " + names));
  return found;
}

std::vector<std::string> hit_box_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const HitBox& box : scene.hit_boxes)
    if (std::find(names.begin(), names.end(), box.name) == names.end()) names.push_back(box.name);
  return names;
}

nb::object bounds_of_hit_box(const Scene& scene, const std::string& name) {
  Bounds all;
  for (const HitBox* box : hit_boxes_called(scene, name)) {
    const Bounds one = hit_box_bounds(*box);
    if (one.empty) continue;
    if (all.empty) all = one;
    all.lower = {std::min(all.lower.x, one.lower.x), std::min(all.lower.y, one.lower.y),
                 std::min(all.lower.z, one.lower.z)};
    all.upper = {std::max(all.upper.x, one.upper.x), std::max(all.upper.y, one.upper.y),
                 std::max(all.upper.z, one.upper.z)};
  }
  return corners(all);
}

nb::object inside_hit_box(const Scene& scene, const std::string& name, nb::handle points) {
  const std::vector<const HitBox*> boxes = hit_boxes_called(scene, name);
  const auto array = double_array(points, "points_m", {-1, 3});
  const std::size_t count = array.shape(0);
  auto* inside = new bool[count];
  nb::capsule owner(inside, [](void* p) noexcept { delete[] static_cast<bool*>(p); });
  run_long_work([&] {
    parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      const double* p = array.data() + 3 * i;
      inside[i] = std::any_of(boxes.begin(), boxes.end(), [&](const HitBox* box) {
        return is_inside(*box, {p[0], p[1], p[2]});
      });
    });
  });
  return nb::cast(nb::ndarray<nb::numpy, bool>(inside, {count}, owner), nb::rv_policy::reference);
}

template <typename T>
auto size_of(std::vector<T> Scene::*list) {
  return [list](const Scene& scene) { return (scene.*list).size(); };
}

}  // namespace

void bind_scene(nb::module_& m) {
  using Self = nb::handle_t<Scene>;
  nb::class_<Scene> scene_class(
      m, "Scene",
      "A scene: meshes, instances, materials, textures, cameras, lamps, Gaussian splats and a\n"
      "background, in glTF's world frame (right-handed, +Y up, metres). Read-only.\n\n"
      "`omma.load_scene` reads one; here one is made of its parts, which are in `omma.scene`. "
      "They\n"
      "refer to each other by index: an instance to its mesh, a mesh to its material, a material\n"
      "to textures, a texture to its image. Without ``instances`` each mesh is placed once, as "
      "its\n"
      "positions say; without ``textures`` there is one for each image. ``Scene()`` is empty:\n"
      "nothing but background, black unless one is given.\n\n"
      "Raises `omma.Error`, which names the part, where an index leads nowhere, sizes do not go\n"
      "together or a number is not finite.");
  scene_class
      .def(
          "__init__",
          [](Scene* self, const nb::kwargs& given) { new (self) Scene(made_scene(given)); },
          nb::sig("def __init__(self, *, meshes: collections.abc.Iterable[Mesh] = (), instances: "
                  "collections.abc.Iterable[Instance] | None = None, materials: "
                  "collections.abc.Iterable[Material] = (), textures: "
                  "collections.abc.Iterable[Texture] | None = None, images: "
                  "collections.abc.Iterable[Image] = (), cameras: "
                  "collections.abc.Iterable[Camera] = (), hit_boxes: "
                  "collections.abc.Iterable[HitBox] = (), lights: "
                  "collections.abc.Iterable[PunctualLight] = (), splats: "
                  "collections.abc.Iterable[SplatCloud] = (), background: Background | None = "
                  "None, color_rule: str = 'gltf', rig: Rig | None = None) -> None"))
      .def_prop_ro(
          "rig", [](const Scene& s) { return std::const_pointer_cast<Rig>(s.rig); },
          nb::for_getter(nb::sig("def rig(self, /) -> Rig | None")),
          "How its things move in time; None: nothing does.")
      .def_prop_ro(
          "animations",
          [](Self self) {
            nb::list found;
            const std::shared_ptr<const Rig>& rig = nb::cast<const Scene&>(self).rig;
            if (rig == nullptr) return found;
            for (const Animation& animation : rig->animations)
              found.append(nb::cast(&animation, nb::rv_policy::reference_internal, self));
            return found;
          },
          nb::for_getter(nb::sig("def animations(self, /) -> list[Animation]")),
          "Of the file, in its order: what `World.at` can show.")
      .def_prop_ro(
          "meshes", [](Self self) { return own_parts(self, &Scene::meshes); },
          nb::for_getter(nb::sig("def meshes(self, /) -> list[Mesh]")),
          "Meshes stored, one for each glTF primitive; their arrays are the scene's own memory.")
      .def_prop_ro(
          "instances", [](const Scene& s) { return s.instances; }, "Meshes placed in the world.")
      .def_prop_ro("materials", [](const Scene& s) { return s.materials; })
      .def_prop_ro("textures", [](const Scene& s) { return s.textures; })
      .def_prop_ro(
          "images", [](Self self) { return own_parts(self, &Scene::images); },
          nb::for_getter(nb::sig("def images(self, /) -> list[Image]")))
      .def_prop_ro(
          "hit_boxes", [](Self self) { return own_parts(self, &Scene::hit_boxes); },
          nb::for_getter(nb::sig("def hit_boxes(self, /) -> list[HitBox]")),
          "Regions, which are not drawn: meshes whose extras say ``hitbox``. One in several "
          "places\n"
          "is several, of one name.")
      .def_prop_ro(
          "lights", [](const Scene& s) { return s.lights; },
          "Lamps, which shine in a world with a light.")
      .def_prop_ro(
          "splats", [](Self self) { return own_parts(self, &Scene::splats); },
          nb::for_getter(nb::sig("def splats(self, /) -> list[SplatCloud]")),
          "Clouds of Gaussian splats, which hold the light of their capture.")
      .def_prop_ro("splat_count", &splat_count, "Gaussian splats of all clouds.")
      .def_prop_ro(
          "color_rule", [](const Scene& s) { return word_of(color_rules, s.color_rule); },
          "'gltf' or 'compoundray': see `omma.load_scene`.")
      .def(
          "replace",
          [](Self self, const nb::kwargs& changes) { return replaced(self, fields, changes); },
          nb::sig("def replace(self, **changes: typing.Any) -> Scene"),
          "Another scene that differs in what is given by keyword, as for making one. It comes\n"
          "from no file: its ``path`` is ''.")
      .def(
          "__getstate__",
          [](Self self) {
            const auto& s = nb::cast<const Scene&>(self);
            return nb::make_tuple(fields_of(self, fields), path_object(s.path), s.warnings,
                                  s.scene_names, s.node_count);
          },
          nb::sig("def __getstate__(self) -> tuple[typing.Any, ...]"))
      .def(
          "__setstate__",
          [](Scene& self, const nb::tuple& state) { new (&self) Scene(restored(state)); },
          nb::sig("def __setstate__(self, state: tuple[typing.Any, ...]) -> None"))
      .def("__hash__",
           [](const Scene& s) {
             return static_cast<std::size_t>(triangle_count(s)) + s.cameras.size();
           })
      .def("_repr_html_", &scene_html)
      .def_prop_ro(
          "path", [](const Scene& s) { return path_object(s.path); },
          nb::sig("def path(self, /) -> str"), "The file it came from, '' for one made in memory.")
      .def_prop_ro(
          "cameras", [](const Scene& s) { return s.cameras; },
          "Camera nodes in the order of the file.")
      .def(
          "camera",
          [](const Scene& s, nb::handle which) {
            if (!nb::isinstance<nb::str>(which) && !PyIndex_Check(which.ptr()))
              throw nb::type_error(
                  ("name_or_index: expected a name or a whole number, found " + type_name_of(which))
                      .c_str());
            return choose_camera(s, str_of(which));
          },
          nb::arg("name_or_index"), nb::sig("def camera(self, name_or_index: str | int) -> Camera"),
          "The camera of that name, or with that index among ``cameras``; an index may also be\n"
          "text, where no camera is called so.\n\n"
          "Raises `omma.Error`, with the names and indices there are, where there is none or\n"
          "several are called so.")
      .def_prop_ro(
          "bounds", [](const Scene& s) { return corners(scene_bounds(s)); },
          nb::for_getter(
              nb::sig("def bounds(self, /) -> numpy.typing.NDArray[numpy.float64] | None")),
          "Lower and upper corner of the box around everything: (2, 3), m; None for an\n"
          "empty scene.")
      .def_prop_ro("triangle_count", &triangle_count,
                   "Triangles as seen: each instance counts those of its mesh.")
      .def_prop_ro("mesh_count", size_of(&Scene::meshes),
                   "Meshes stored: one for each glTF primitive.")
      .def_prop_ro("instance_count", size_of(&Scene::instances), "Meshes placed in the world.")
      .def_prop_ro("material_count", size_of(&Scene::materials))
      .def_prop_ro("texture_count", size_of(&Scene::textures))
      .def_prop_ro("image_count", size_of(&Scene::images))
      .def_ro("node_count", &Scene::node_count, "Nodes reached from the loaded scene.")
      .def_prop_ro(
          "scene_names", [](const Scene& s) { return s.scene_names; },
          "Names of all scenes in the file.")
      .def_prop_ro(
          "background", [](const Scene& s) { return s.background; },
          "What a ray sees that meets no surface.")
      .def_prop_ro("hit_box_names", &hit_box_names, "Names of the hit boxes, each once.")
      .def("hit_box_bounds", &bounds_of_hit_box, nb::arg("name"),
           nb::sig("def hit_box_bounds(self, name: str) -> numpy.typing.NDArray[numpy.float64] | "
                   "None"),
           "Lower and upper corner of the box around a hit box: (2, 3), m; None where it has no\n"
           "triangles.\n\nRaises `omma.Error`, with the names there are.")
      .def("is_inside", &inside_hit_box, nb::arg("name"), nb::arg("points_m"),
           nb::sig("def is_inside(self, name: str, points_m: numpy.typing.ArrayLike) -> "
                   "numpy.typing.NDArray[numpy.bool_]"),
           "Which points (N, 3), m, lie inside a hit box, taken as a closed surface: bool (N,).\n\n"
           "Raises `omma.Error`, with the names there are.")
      .def_prop_ro(
          "warnings",
          [](const Scene& s) {
            std::vector<std::string> sentences;
            for (const std::string& sentence : s.warnings)
              sentences.push_back(readable_text(sentence));
            return sentences;
          },
          "What the loader passed over, a sentence each.")
      .def("__repr__", &scene_repr);
  def_equality(scene_class);

  m.def(
      "load_scene",
      [](nb::handle path, int scene_index, nb::handle color_rule, const nb::object& progress) {
        const std::string name = path_text(path);
        SceneOptions options;
        options.scene_index = scene_index;
        options.color_rule = word_argument(color_rules, color_rule, "color_rule");
        auto scene = std::make_shared<Scene>();
        run_with_progress(progress, [&](const std::function<bool(double)>& report) {
          options.progress = report;
          *scene = load_scene(name, options);
        });
        return scene;
      },
      nb::arg("path"), nb::arg("scene_index") = -1, nb::arg("color_rule") = "gltf",
      nb::arg("progress") = nb::none(),
      nb::sig("def load_scene(path: str | os.PathLike[str], scene_index: int = -1, color_rule: str "
              "= 'gltf', progress: collections.abc.Callable[[float], object] | None = None) -> "
              "Scene"));

  m.def(
      "save_scene",
      [](nb::handle path, const Scene& scene, const nb::object& progress) {
        const std::string name = path_text(path);
        run_with_progress(progress, [&](const std::function<bool(double)>& report) {
          save_scene(name, scene, report);
        });
      },
      nb::arg("path"), nb::arg("scene"), nb::arg("progress") = nb::none(),
      nb::sig("def save_scene(path: str | os.PathLike[str], scene: Scene, progress: "
              "collections.abc.Callable[[float], object] | None = None) -> None"));
  m.def("find_animation", &find_animation, nb::arg("scene"), nb::arg("name"));
  m.def(
      "camera_at",
      [](const Scene& scene, int camera, double time_s, const std::vector<int>& animations) {
        return matrix_array(camera_at(scene, camera, time_s, animations));
      },
      nb::arg("scene"), nb::arg("camera"), nb::arg("time_s"), nb::arg("animations"),
      nb::sig("def camera_at(scene: Scene, camera: int, time_s: float, animations: "
              "collections.abc.Sequence[int]) -> numpy.typing.NDArray[numpy.float64]"));
  m.def(
      "with_path",
      [](const Scene& scene, nb::handle path, std::vector<std::string> told) {
        auto made = std::make_shared<Scene>(scene);
        made->path = path_text(path);
        made->warnings = std::move(told);
        for (std::string& sentence : place_warnings(*made, "the file has them"))
          made->warnings.push_back(std::move(sentence));
        const auto is_told = [](const std::string& one) {
          return one.starts_with(without_coordinates);
        };
        if (std::none_of(made->warnings.begin(), made->warnings.end(), is_told))
          for (std::string& sentence : coordinate_warnings(*made))
            made->warnings.push_back(std::move(sentence));
        return made;
      },
      nb::arg("scene"), nb::arg("path"), nb::arg("warnings"),
      nb::sig("def with_path(scene: Scene, path: str | os.PathLike[str], warnings: list[str]) -> "
              "Scene"),
      "The same scene, which says that it came from that file, and what of that was passed over.");
}

}  // namespace omma::python
