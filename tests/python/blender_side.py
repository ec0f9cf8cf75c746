"""What test_blender_addon.py has done inside of Blender, as a module (bpy).

    python blender_side.py FUNCTION FOLDER '{"argument": ...}'

runs one function of FUNCTIONS in FOLDER, with the add-on installed from its zip, and writes what it
returns to FOLDER/answer.json. Nothing here imports omma, which Blender's Python has not.
"""

import json
import math
import os
import sys
import tempfile
import time
import types
from pathlib import Path

import bpy
import numpy as np

ADDON = "bl_ext.user_default.omma_blender"


def install(package: str, program: str) -> None:
    bpy.ops.extensions.package_install_files(
        filepath=package, repo="user_default", enable_on_install=True
    )
    bpy.context.preferences.addons[ADDON].preferences.program = program


def empty() -> bpy.types.Scene:
    """No objects and a black world."""
    for one in list(bpy.data.objects):
        bpy.data.objects.remove(one)
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("dark")
    paint_world(scene.world, (0, 0, 0))
    return scene


def _use_nodes(owner: bpy.types.ID) -> None:
    if bpy.app.version < (5, 0):  # from then on all have nodes
        owner.use_nodes = True


def paint_world(world: bpy.types.World, color: tuple[float, float, float], strength=1.0) -> None:
    _use_nodes(world)
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (*color, 1)
    background.inputs["Strength"].default_value = strength


def material(name: str, color: tuple[float, float, float], **inputs: float) -> bpy.types.Material:
    made = bpy.data.materials.new(name)
    _use_nodes(made)
    surface = made.node_tree.nodes["Principled BSDF"]
    surface.inputs["Base Color"].default_value = (*color, 1)
    surface.inputs["Roughness"].default_value = 1
    surface.inputs["Specular IOR Level"].default_value = 0
    for key, value in inputs.items():
        surface.inputs[key].default_value = value
    return made


def add(
    scene: bpy.types.Scene, one: object, name: str, at: tuple = (0, 0, 0), **properties: object
) -> bpy.types.Object:
    thing = bpy.data.objects.new(name, one)
    thing.location = at
    for key, value in properties.items():
        setattr(thing, key, value)
    scene.collection.objects.link(thing)
    return thing


def box(name: str, size: tuple[float, float, float], made: bpy.types.Material) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new(name)
    x, y, z = (side / 2 for side in size)
    corners = [(i * x, j * y, k * z) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    mesh.from_pydata(corners, [], faces)
    mesh.materials.append(made)
    mesh.update()
    return mesh


def compound_camera(**properties: object) -> bpy.types.Object:
    assert bpy.ops.omma.add_compound_camera(**properties) == {"FINISHED"}
    return bpy.context.object


def meadow(eye: str) -> bpy.types.Scene:
    """Ground, flowers left and right and above, lamps, a world, and a bee that flies, turns, beats
    its wing, bends its abdomen and carries a compound eye."""
    scene = empty()
    paint_world(scene.world, (0.3, 0.5, 0.9), 0.8)
    scene.frame_start, scene.frame_end = 1, 25
    scene.render.fps = 25
    green = material("grass", (0.1, 0.4, 0.05))
    green["omma"] = {
        "reflectance": {"wavelength_nm": [300, 500, 550, 700], "value": [0.05, 0.1, 0.3, 0.1]},
        "spectral_luminance": 0.3,
    }
    add(scene, box("ground", (20, 20, 0.1), green), "ground", (0, 0, -0.05))
    glow = material("glow", (0, 0, 0))
    surface = glow.node_tree.nodes["Principled BSDF"]
    surface.inputs["Emission Color"].default_value = (0.9, 0.8, 0.1, 1)
    surface.inputs["Emission Strength"].default_value = 2
    add(scene, box("left", (1, 1, 2), material("red", (0.8, 0.1, 0.1))), "left", (-3, 4, 1))
    add(scene, box("right", (1, 1, 1), material("blue", (0.1, 0.1, 0.8))), "right", (3, 4, 0.5))
    row = add(scene, box("lamp", (0.5, 0.5, 0.5), glow), "high", (0, 6, 4))
    array = row.modifiers.new("row", "ARRAY")
    array.count = 3
    sun = bpy.data.lights.new("sun", "SUN")
    sun.energy = 3
    add(scene, sun, "sun", rotation_euler=(0.5, 0.2, 0))
    bulb = bpy.data.lights.new("bulb", "POINT")
    bulb.energy = 100
    add(scene, bulb, "bulb", (2, 2, 3))
    dark = material("bee", (0.1, 0.08, 0.02))
    bee = add(scene, box("body", (0.2, 0.5, 0.2), dark), "bee", (0, -2, 1))
    bee.rotation_mode = "XYZ"
    for frame, x, turn in ((1, -1, 0.4), (13, 0, -0.3), (25, 1, 0.6)):
        bee.location = (x, -2 + 0.05 * frame, 1 + 0.3 * math.sin(frame))
        bee.rotation_euler = (0.1 * turn, 0.2 * turn, turn)
        bee.keyframe_insert("location", frame=frame)
        bee.keyframe_insert("rotation_euler", frame=frame)
    wing = add(scene, box("wing", (0.6, 0.2, 0.01), dark), "wing", (0.4, 0, 0.1), parent=bee)
    for frame in range(1, 26, 3):
        wing.rotation_euler = (0, 0.6 * (-1) ** frame, 0)
        wing.keyframe_insert("rotation_euler", frame=frame)
    tail = box("tail", (0.1, 0.4, 0.1), dark)
    abdomen = add(scene, tail, "abdomen", (0, -0.4, 0), parent=bee)
    abdomen.shape_key_add(name="Basis")
    bent = abdomen.shape_key_add(name="bent")
    for point in bent.data:
        point.co.z += 0.2 if point.co.y < 0 else 0
    for frame, value in ((1, 0), (25, 1)):
        bent.value = value
        bent.keyframe_insert("value", frame=frame)
    scene.cursor.location = (0, 0, 0)
    camera = compound_camera(eye_file=eye)
    camera.name = "bee eye"
    camera.data.name = "bee eye"
    camera.location = (0, 0.3, 0.05)
    camera.parent = bee
    camera.data.omma_eye.samples = 8
    scene.camera = camera
    scene.frame_set(1)
    return scene


def matrices(scene: bpy.types.Scene, names: list[str], frames: list[int]) -> dict:
    """Where Blender has things at frames, (frames, 4, 4) each."""
    found = {name: [] for name in names}
    for frame in frames:
        scene.frame_set(frame)
        graph = bpy.context.evaluated_depsgraph_get()
        for name in names:
            world = scene.objects[name].evaluated_get(graph).matrix_world
            found[name].append([list(row) for row in world])
    return found


def picture(name: str) -> np.ndarray:
    """An image of Blender's, (height, width, 4), row 0 at the top."""
    image = bpy.data.images[name]
    pixels = np.empty(image.size[0] * image.size[1] * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(image.size[1], image.size[0], 4)[::-1]


# What the tests ask for.


def registers() -> dict:
    """Registers and unregisters several times; what is left then."""
    module = sys.modules[ADDON]
    kept = lambda: [  # noqa: E731
        one
        for kind in ("Operator", "Panel", "PropertyGroup", "AddonPreferences")
        for one in dir(bpy.types)
        if "omma" in one.lower() and kind
    ]
    menus = ("VIEW3D_MT_camera_add", "TOPBAR_MT_file_import", "TOPBAR_MT_file_export")
    drawn = lambda: [  # noqa: E731
        len(getattr(getattr(bpy.types, menu).draw, "_draw_funcs", []))
        for menu in (*menus, "TOPBAR_MT_render")
    ]
    first = len(kept()), drawn()
    states = []
    for _ in range(2):
        module.unregister()
        states.append((kept(), hasattr(bpy.types.Camera, "omma_eye"), drawn()))
        module.register()
        states.append((len(kept()), hasattr(bpy.types.Camera, "omma_eye"), drawn()))
    return {"first": first, "states": states}


def renders(folder: Path, eye: str, light: str = "none") -> dict:
    scene = meadow(eye)
    scene.omma_render.numbers = str(folder)
    scene.omma_render.light = light
    scene.omma_render.width = 128
    sides = compound_camera(eye_file=eye)  # a second one, that turns its back
    sides.name = "back"
    sides.rotation_euler[2] = math.pi
    sides.data.omma_eye.projection = "mollweide"
    sides.data.omma_eye.samples = 4
    around = bpy.data.cameras.new("around")
    around.type = "PANO"
    add(scene, around, "around", (0, 0, 1))
    before = sorted((one.name, getattr(one.data, "type", "")) for one in bpy.data.objects)
    for name in ("bee eye", "back"):
        bpy.context.view_layer.objects.active = scene.objects[name]
        assert bpy.ops.omma.render("EXEC_DEFAULT") == {"FINISHED"}
        np.save(folder / f"{name}.picture.npy", picture(f"Omma: {name}"))
    assert bpy.ops.omma.export_scene(filepath=str(folder / "whole.glb")) == {"FINISHED"}
    assert bpy.ops.omma.export_scene(filepath=str(folder / "parts.gltf")) == {"FINISHED"}
    after = sorted((one.name, getattr(one.data, "type", "")) for one in bpy.data.objects)
    return {"before": before, "after": after, "frame": scene.frame_current}


def animates(folder: Path, eye: str) -> dict:
    scene = meadow(eye)
    assert bpy.ops.omma.export_scene(filepath=str(folder / "flight.glb")) == {"FINISHED"}
    frames = [1, 2, 7, 13, 20, 25]
    moving = ["bee", "wing", "abdomen", "bee eye"]
    return {"frames": frames, "fps": scene.render.fps, **matrices(scene, moving, frames)}


def imports(eye: str) -> dict:
    """The vertices, edges and attributes of an eye that is imported."""
    empty()
    assert bpy.ops.omma.import_eye(filepath=eye) == {"FINISHED"}
    cloud = bpy.context.object
    points = np.array([v.co for v in cloud.data.vertices])
    return {
        "points": points.tolist(),
        "edges": [list(edge.vertices) for edge in cloud.data.edges],
        "acceptance": [one.value for one in cloud.data.attributes["acceptance_angle_rad"].data],
        "axis": [list(one.vector) for one in cloud.data.attributes["axis"].data],
        "ahead": list(cloud.matrix_world.to_3x3() @ __import__("mathutils").Vector((0, 0, -1))),
        "hidden": cloud.hide_render,
    }


def cycles_picture(scene: bpy.types.Scene, camera: bpy.types.Object, samples: int) -> np.ndarray:
    """What Blender's own Cycles makes of it: linear, (height, width, 3), row 0 at the top."""
    scene.camera = camera
    scene.render.engine = "CYCLES"
    scene.cycles.samples = samples
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type = "BOX"
    scene.render.threads_mode, scene.render.threads = "FIXED", 2
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR", "32"
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder, "cycles.exr"))
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        pixels = np.empty(image.size[0] * image.size[1] * image.channels, np.float32)
        image.pixels.foreach_get(pixels)
        pixels = pixels.reshape(image.size[1], image.size[0], image.channels)[::-1, :, :3].copy()
        bpy.data.images.remove(image)
    return pixels


def omma_picture(scene: bpy.types.Scene, camera: bpy.types.Object, samples: int) -> np.ndarray:
    scene.omma_render.width = scene.render.resolution_x
    scene.omma_render.camera_samples = samples
    bpy.context.view_layer.objects.active = camera
    assert bpy.ops.omma.render("EXEC_DEFAULT") == {"FINISHED"}
    return picture(f"Omma: {camera.name}")[..., :3]


def save_both(
    folder: Path, name: str, scene: bpy.types.Scene, camera: bpy.types.Object, samples: int
) -> None:
    np.save(folder / f"{name}.omma.npy", omma_picture(scene, camera, samples))
    np.save(folder / f"{name}.cycles.npy", cycles_picture(scene, camera, samples))


def glowing(name: str, color: tuple[float, float, float]) -> bpy.types.Material:
    made = material(name, (0, 0, 0))
    surface = made.node_tree.nodes["Principled BSDF"]
    surface.inputs["Emission Color"].default_value = (*color, 1)
    surface.inputs["Emission Strength"].default_value = 1
    return made


def silhouettes(folder: Path) -> dict:
    """Things of pure red, green and blue, of no symmetry, before a perspective and an orthographic
    camera that are turned, and before one with other ways of saying its field."""
    scene = empty()
    scene.render.resolution_x, scene.render.resolution_y = 480, 320
    scene.render.resolution_percentage = 100
    red, green, blue = (glowing(str(i), tuple(np.eye(3)[i])) for i in range(3))
    for i, (size, at) in enumerate(
        [
            ((0.4, 0.3, 2), (-1, 0, 0)),
            ((1, 0.3, 0.4), (-0.5, 0, 0.8)),
            ((0.7, 0.3, 0.3), (-0.6, 0, 0)),
        ]
    ):
        add(scene, box(f"F{i}", size, red), f"F{i}", at)
    cone = add(scene, box("roof", (1, 0.2, 0.6), green), "roof", (1.2, 1, 0.6))
    cone.rotation_euler, cone.scale = (0.4, 0.7, 0.2), (0.7, 1, 1.6)
    bpy.ops.mesh.primitive_torus_add(location=(0.9, -0.3, -0.7), rotation=(1, 0.3, 0))
    ring = bpy.context.object
    ring.scale = (0.5, 0.5, 0.5)
    ring.data.materials.append(blue)
    data = bpy.data.cameras.new("pinhole")
    pinhole = add(scene, data, "pinhole", (0.8, -6, 1.5), rotation_euler=(1.35, 0.15, 0.1))
    save_both(folder, "perspective", scene, pinhole, 16)
    data.sensor_fit, data.lens = "VERTICAL", 40
    scene.render.resolution_x, scene.render.resolution_y = 320, 400
    save_both(folder, "tall", scene, pinhole, 16)
    data.type, data.ortho_scale = "ORTHO", 5
    scene.render.resolution_x, scene.render.resolution_y = 480, 320
    data.sensor_fit = "AUTO"
    save_both(folder, "orthographic", scene, pinhole, 16)
    return {}


def worlds(folder: Path) -> dict:
    """An environment picture, turned or not, in floats and in 8 bits, as both show it."""
    scene = empty()
    scene.render.resolution_x, scene.render.resolution_y = 96, 64
    data = bpy.data.cameras.new("looks")
    data.lens = 14
    camera = add(scene, data, "looks", rotation_euler=(1.4, 0, 0.5))
    height, width = 256, 512
    longitude = np.linspace(0, 2 * np.pi, width, endpoint=False) + np.pi / width
    latitude = np.linspace(-0.5, 0.5, height)[:, None] * np.pi
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., 0] = 0.5 + 0.4 * np.cos(longitude - 0.3)
    rgba[..., 1] = 0.5 + 0.4 * np.sin(latitude + 0 * longitude)
    rgba[..., 2] = 0.5 + 0.4 * np.sin(2 * longitude) * np.cos(latitude)
    nodes, links = scene.world.node_tree.nodes, scene.world.node_tree.links
    texture = nodes.new("ShaderNodeTexEnvironment")
    mapping = nodes.new("ShaderNodeMapping")
    coordinates = nodes.new("ShaderNodeTexCoord")
    links.new(texture.outputs["Color"], nodes["Background"].inputs["Color"])
    for name, is_float, turn, strength in (
        ("floats", True, None, 1.0),
        ("turned", True, 0.7, 2.5),
        ("bytes", False, None, 1.0),
    ):
        image = bpy.data.images.new(name, width, height, float_buffer=is_float)
        image.pixels.foreach_set(rgba.ravel())
        texture.image = image
        if turn is not None:
            mapping.inputs["Rotation"].default_value = (0, 0, turn)
            links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
            links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
        elif texture.inputs["Vector"].is_linked:
            links.remove(texture.inputs["Vector"].links[0])
        nodes["Background"].inputs["Strength"].default_value = strength
        save_both(folder, name, scene, camera, 16)
    return {}


def lit(folder: Path) -> dict:
    """Rough ground and a ball in the light of a lamp, of a sun, of a world, of a glowing panel."""
    scene = empty()
    scene.omma_render.light = "world"
    scene.render.resolution_x, scene.render.resolution_y = 36, 24
    add(scene, box("ground", (40, 40, 0.1), material("grey", (0.5, 0.5, 0.5))), "ground")
    add(scene, box("block", (1, 1, 1), material("red", (0.7, 0.2, 0.1))), "block", (1, 1, 0.5))
    data = bpy.data.cameras.new("above")
    camera = add(scene, data, "above", (0, -6, 4), rotation_euler=(1.0, 0, 0))
    bulb = bpy.data.lights.new("bulb", "POINT")
    bulb.energy, bulb.shadow_soft_size = 300, 0.01
    lamp = add(scene, bulb, "bulb", (-1, -1, 3))
    save_both(folder, "lamp", scene, camera, 64)
    bpy.data.objects.remove(lamp)
    sun = bpy.data.lights.new("sun", "SUN")
    sun.energy, sun.angle, sun.color = 3, 0.001, (1, 0.8, 0.5)
    star = add(scene, sun, "sun", rotation_euler=(0.6, 0.2, 0))
    save_both(folder, "sun", scene, camera, 64)
    bpy.data.objects.remove(star)
    paint_world(scene.world, (0.3, 0.4, 0.8), 1.5)
    save_both(folder, "world", scene, camera, 64)
    paint_world(scene.world, (0, 0, 0))
    panel = glowing("panel", (1, 1, 1))
    panel.node_tree.nodes["Principled BSDF"].inputs["Emission Strength"].default_value = 20
    add(scene, box("panel", (2, 2, 0.1), panel), "panel", (0, 0, 4))
    save_both(folder, "panel", scene, camera, 128)
    return {}


def fails(folder: Path, eye: str) -> dict:
    """What is said where something is wrong, and that a render goes well afterwards."""
    said = {}

    def attempt(name: str, operator: object, /, **arguments: object) -> None:
        try:
            said[name] = [sorted(operator(**arguments)), ""]
        except RuntimeError as error:
            said[name] = ["", str(error)]

    scene = empty()
    preferences = bpy.context.preferences.addons[ADDON].preferences
    program = preferences.program
    attempt("no camera", bpy.ops.omma.render)
    lamp = bpy.data.lights.new("lamp", "AREA")
    add(scene, lamp, "panel of light")
    attempt("unknown camera", bpy.ops.omma.render, camera="nobody")
    preferences.program = str(folder / "nowhere")
    attempt("no such program", bpy.ops.omma.add_compound_camera)
    preferences.program = sys.executable  # Blender's own, which has no omma
    attempt("no package", bpy.ops.omma.check_package)
    attempt("no package to import", bpy.ops.omma.import_eye, filepath=eye)
    preferences.program = program
    attempt("missing eye", bpy.ops.omma.import_eye, filepath=str(folder / "missing.eye"))
    (folder / "empty.eye").write_text("# nothing\n")
    attempt("empty eye", bpy.ops.omma.import_eye, filepath=str(folder / "empty.eye"))
    (folder / "broken.eye").write_text("1 2 3\n")
    attempt("broken eye", bpy.ops.omma.add_compound_camera, eye_file=str(folder / "broken.eye"))
    attempt("unknown species", bpy.ops.omma.add_compound_camera, species="unicorn")
    said["left over"] = [one.name for one in bpy.data.objects]
    camera = compound_camera(eye_file=eye)
    camera.data.omma_eye.eye_file = str(folder / "gone.eye")
    attempt("eye gone", bpy.ops.omma.render)
    camera.data.omma_eye.eye_file = ""
    camera.data.omma_eye.species = ""
    attempt("no eye", bpy.ops.omma.render)
    camera.data.omma_eye.eye_file = eye
    (folder / "file").write_text("no folder")
    attempt("no folder", bpy.ops.omma.export_scene, filepath=str(folder / "file" / "a.glb"))
    attempt("other ending", bpy.ops.omma.export_scene, filepath=str(folder / "a.obj"))
    scene.omma_render.numbers = str(folder / "file")
    attempt("no folder for numbers", bpy.ops.omma.render)
    scene.omma_render.numbers = "//seen"
    attempt("not saved", bpy.ops.omma.render)
    scene.omma_render.numbers = ""
    hidden = [one for one in scene.objects if not one.hide_render]
    for one in hidden:
        one.hide_render = True
    attempt("all hidden", bpy.ops.omma.export_scene, filepath=str(folder / "a.glb"))
    for one in hidden:
        one.hide_render = False
    glow = material("wrong spectrum", (1, 1, 1))
    glow["omma"] = {"reflectance": {"wavelength_nm": [500], "value": [2]}}
    thing = add(scene, box("box", (1, 1, 1), glow), "box", (0, 5, 0))
    bpy.context.view_layer.objects.active = camera
    attempt("wrong spectrum", bpy.ops.omma.render)
    bpy.context.view_layer.objects.active = thing
    (folder / "spectrum.csv").write_text("nm,value\n400,1\n300,1\n")
    attempt(
        "wrong spectrum file",
        bpy.ops.omma.spectrum_from_file,
        filepath=str(folder / "spectrum.csv"),
    )
    attempt("unknown material", bpy.ops.omma.natural_material, name="plastic")
    bpy.data.objects.remove(thing)
    bpy.context.view_layer.objects.active = camera
    sky = scene.world.node_tree.nodes.new("ShaderNodeTexSky")
    background = scene.world.node_tree.nodes["Background"]
    scene.world.node_tree.links.new(sky.outputs["Color"], background.inputs["Color"])
    attempt("sky", bpy.ops.omma.render)
    said["files"] = sorted(one.name for one in folder.iterdir())
    return said


def stops(folder: Path, eye: str) -> dict:
    """A render that is stopped in the middle, as Esc does; what is left of it."""
    scene = meadow(eye)
    scene.omma_render.numbers = str(folder)
    scene.camera.data.omma_eye.samples = 1 << 18
    render = sys.modules[f"{ADDON}.render"].Render(bpy.context, scene.camera)
    stages = []
    while (stage := render.progress)[0] != "Rendering" or not stage[1]:
        stages.append(stage)
        assert not render.poll()
        time.sleep(0.02)
    process = render._work._process
    start = time.monotonic()
    render.stop()
    return {
        "ended": process.returncode,
        "seconds": time.monotonic() - start,
        "stages": sorted({name for name, _ in stages}),
        "files": sorted(one.name for one in folder.iterdir()),
    }


def blocks_of(page: Path) -> list[str]:
    """What docs/blender.md says to run in Blender."""
    parts = page.read_text(encoding="utf-8").split("```python blender\n")[1:]
    return [part.split("\n```")[0] for part in parts]


def runs_the_page(folder: Path, page: str) -> dict:
    """The page's scripts, in the home folder of a saved file, with few rays."""
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "bed.blend"))
    os.chdir(folder)
    for text in blocks_of(Path(page)):
        exec(text.replace("samples = 64", "samples = 1"), {})
    seen = picture("Omma: bee")
    return {
        "numbers": str(folder / "seen" / "Scene-bee.npy"),
        "shown": float(seen[..., :3][seen[..., 3] > 0].mean()),
        "leaf": bpy.data.materials["leaf"]["omma"].to_dict(),
    }


class Layout:
    """What panels draw into, in place of Blender's, which is only there with a window."""

    def __init__(self) -> None:
        self.drawn: list[str] = []

    def prop(self, owner: object, name: str, **options: object) -> None:
        assert name in owner.bl_rna.properties, name
        self.drawn.append(name)

    def operator(self, name: str, **options: object) -> None:
        room, own = name.split(".")
        assert hasattr(getattr(bpy.ops, room), own)
        getattr(getattr(bpy.ops, room), own).get_rna_type()  # KeyError where there is none
        self.drawn.append(name)

    def label(self, text: str, **options: object) -> None:
        self.drawn.append(text)

    def row(self) -> "Layout":
        return self

    column = row

    def separator(self) -> None:
        pass


def draws_and_waits(eye: str) -> dict:
    """Panels and menus drawn, and the render as it goes while Blender is used: polled by a timer to
    its end, and ended by Esc."""
    scene = meadow(eye)
    module = sys.modules[ADDON]
    layout = Layout()
    green = bpy.data.materials["grass"]
    shown = types.SimpleNamespace(
        camera=scene.camera.data, scene=scene, material=green, light=bpy.data.lights["sun"]
    )
    scene.omma_render.light = "sky"
    for panel in module.panels.CLASSES:
        assert getattr(panel, "poll", lambda context: True)(shown)
        drawing = types.SimpleNamespace(layout=layout)
        if hasattr(panel, "draw_header"):
            panel.draw_header(drawing, shown)
        panel.draw(drawing, shown)
    preferences = bpy.context.preferences.addons[ADDON].preferences
    own = types.SimpleNamespace(layout=layout, program=preferences.program)
    own.bl_rna = preferences.bl_rna
    module.preferences.OmmaPreferences.draw(own, shown)
    for draw in (
        module.eye_objects._draw_add,
        module.eye_objects._draw_import,
        module.export._draw_export,
        module.render._draw_render,
    ):
        draw(types.SimpleNamespace(layout=layout), shown)
    scene.omma_render.light = "none"

    told: list[str] = []
    statuses: list[str] = []
    context = types.SimpleNamespace(
        scene=scene,
        view_layer=bpy.context.view_layer,
        window=None,
        workspace=types.SimpleNamespace(status_text_set=statuses.append),
        window_manager=types.SimpleNamespace(
            event_timer_add=lambda step, window: "timer",
            event_timer_remove=lambda timer: told.append(f"removed {timer}"),
            modal_handler_add=lambda operator: None,
            progress_begin=lambda first, last: None,
            progress_update=lambda value: None,
            progress_end=lambda: None,
        ),
    )
    kind = module.render.OMMA_OT_render
    ends = []
    for key in ("TIMER", "ESC"):
        operator = types.SimpleNamespace(
            camera="bee eye", report=lambda level, message: told.append(message)
        )
        for name in ("_start", "_finish", "_end_modal"):
            setattr(operator, name, getattr(kind, name).__get__(operator))
        event = types.SimpleNamespace(type=key, value="PRESS")
        result = kind.invoke(operator, context, event)
        moved = kind.modal(operator, context, types.SimpleNamespace(type="MOUSEMOVE", value=""))
        assert moved == {"PASS_THROUGH"}
        while result <= {"RUNNING_MODAL", "PASS_THROUGH"}:
            result = kind.modal(operator, context, event)
            time.sleep(0.01)
        ends.append(sorted(result))
    return {"drawn": layout.drawn, "told": told, "statuses": statuses, "ends": ends}


FUNCTIONS = {
    one.__name__: one
    for one in (
        *(registers, renders, animates, imports, silhouettes, worlds, lit, fails, stops),
        *(runs_the_page, draws_and_waits),
    )
}

if __name__ == "__main__":
    name, folder, told = sys.argv[1], Path(sys.argv[2]), json.loads(sys.argv[3])
    install(told.pop("package"), told.pop("program"))
    function = FUNCTIONS[name]
    if "folder" in function.__code__.co_varnames[: function.__code__.co_argcount]:
        told["folder"] = folder
    (folder / "answer.json").write_text(json.dumps(function(**told)), encoding="utf-8")
    sys.stdout.flush()
    os._exit(0)  # Blender 4.2 as a module falls over when Python ends with an add-on's classes
