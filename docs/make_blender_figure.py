"""Makes docs/blender.png: the script of docs/blender.md run in Blender, what Cycles shows of its
scene, and what the bee sees of it by Omma.

    scripts/blender_addon --tests
    .venv/bin/python docs/make_blender_figure.py

The first half runs in .venv-blender, where it is called with a folder.
"""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent


def in_blender(folder: Path) -> None:
    """Runs the page's script; leaves scene.npy, eye.npy there."""
    sys.path.insert(0, str(ROOT / "tests" / "python"))
    import blender_side
    import bpy

    told = json.loads(sys.argv[2])
    blender_side.install(told["package"], told["program"])
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "bed.blend"))
    os.chdir(folder)
    for text in blender_side.blocks_of(ROOT / "docs" / "blender.md"):
        exec(text, {})
    np.save(folder / "eye.npy", blender_side.picture("Omma: bee"))
    scene = bpy.context.scene
    blender_side.paint_world(scene.world, (0.35, 0.5, 0.8), 1)
    sun = bpy.data.lights.new("sun", "SUN")
    sun.energy = 3
    blender_side.add(scene, sun, "sun", rotation_euler=(0.8, 0, math.radians(-20)))
    # The eye is two millimetres long; its points are shown as a body of a hundred times that.
    bee = scene.objects["bee"]
    shown = bee.children[0]
    shown.hide_render = False
    nodes = shown.modifiers.new("as tubes", "NODES")
    nodes.node_group = tubes(bpy)
    data = bpy.data.cameras.new("beside")
    data.lens = 40
    beside = blender_side.add(scene, data, "beside", (-0.9, -0.75, 0.75))
    beside.rotation_euler = (math.radians(74), 0, math.radians(-36))
    scene.render.resolution_x, scene.render.resolution_y = 900, 330
    np.save(folder / "scene.npy", blender_side.cycles_picture(scene, beside, 24))


def tubes(bpy):
    """A geometry node tree that makes thin tubes of edges."""
    tree = bpy.data.node_groups.new("tubes", "GeometryNodeTree")
    for kind in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=kind, socket_type="NodeSocketGeometry")
    names = ("NodeGroupInput", "GeometryNodeMeshToCurve", "GeometryNodeCurveToMesh")
    first, curve, tube = (tree.nodes.new(name) for name in names)
    profile = tree.nodes.new("GeometryNodeCurvePrimitiveCircle")
    profile.inputs["Radius"].default_value = 4e-6
    profile.inputs["Resolution"].default_value = 4
    last = tree.nodes.new("NodeGroupOutput")
    tree.links.new(first.outputs[0], curve.inputs["Mesh"])
    tree.links.new(curve.outputs[0], tube.inputs["Curve"])
    tree.links.new(profile.outputs[0], tube.inputs["Profile Curve"])
    tree.links.new(tube.outputs[0], last.inputs[0])
    return tree


def draw(folder: Path) -> None:
    from matplotlib.figure import Figure

    from omma.picture.unseen import hatch

    scene, eye = np.load(folder / "scene.npy"), np.load(folder / "eye.npy")
    figure = Figure(figsize=(9, 6.4), layout="constrained", dpi=110)
    grid = figure.add_gridspec(2, 2, height_ratios=[330 / 900, 0.25])
    above = figure.add_subplot(grid[0, :])
    above.imshow(np.clip(scene, 0, 1) ** (1 / 2.2))
    above.set_title(
        "The scene in Blender (Cycles), with the bee's ommatidia, 100 times larger", fontsize=10
    )
    above.set_axis_off()
    shown = (255 * np.clip(eye[..., :3], 0, 1) ** (1 / 2.2)).astype(np.uint8)
    hatch(shown, eye[..., 3] == 0)
    for k, (name, half) in enumerate(zip(("left", "right"), np.split(shown, 2, axis=1))):
        below = figure.add_subplot(grid[1, k])
        below.imshow(half, extent=(-180, 180, -90, 90))
        below.set_title(f"What its {name} eye sees (Omma, by a clear sky)", fontsize=10)
        below.set(xticks=range(-180, 181, 90), yticks=range(-90, 91, 45))
        below.set_xlabel("azimuth (°): left – ahead – right", fontsize=8)
        below.tick_params(labelsize=8)
        if k == 0:
            below.set_ylabel("elevation (°)", fontsize=8)
    figure.savefig(ROOT / "docs" / "blender.png")


def main() -> None:
    made = subprocess.run(["scripts/blender_addon"], cwd=ROOT, check=True, capture_output=True)
    told = {"package": str(ROOT / made.stdout.decode().split()[-1]), "program": sys.executable}
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(
            [ROOT / ".venv-blender/bin/python", __file__, folder, json.dumps(told)],
            env={**os.environ, "BLENDER_USER_RESOURCES": folder},
            check=True,
        )
        draw(Path(folder))


if __name__ == "__main__":
    if len(sys.argv) > 1:
        in_blender(Path(sys.argv[1]))
        sys.stdout.flush()
        os._exit(0)  # see tests/python/blender_side.py
    main()
