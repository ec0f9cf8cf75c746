"""The scene as the page draws it: binary glTF, with meshes of many instances stored once."""

from __future__ import annotations

import json
import struct
import tempfile
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Camera, Image, Instance, Material, Mesh, Scene, Texture
from omma.base.arrays import Floats
from omma.picture.band_colours import colours_of
from omma.picture.cameras import display, render_camera
from omma.scene.files import save_scene
from omma.scene.world import World

# What a browser draws without effort; the largest things are kept.
MOST_TRIANGLES = 1_500_000
# Fewer copies are not worth an accessor of their own.
_LEAST_COPIES = 4
_JSON, _BIN = 0x4E4F534A, 0x004E4942
_SKY_WIDTH = 512


@dataclass(frozen=True)
class DrawnScene:
    """still: all that does not move, as glTF; moving: (index in `World.instances`, glTF in the
    frame of its node without its scale); note: what is left out, in words."""

    still: bytes | None
    moving: tuple[tuple[int, bytes], ...]
    note: str


def drawn_scene(world: World) -> DrawnScene:
    """What the page draws of a world, as it stands now."""
    scene = world.scene.replace(splats=())  # splat_scene.py has them
    placed = scene.instances  # a new list each time it is asked for
    if world.light is None:
        scene = _unlit(scene)
    groups = _groups(scene)
    of_world = world.instances
    # Where the file has what has been moved since.
    before = dict(world._moved)
    animated = set(world._engine.animated) | set(before)
    notes = []
    if len(groups) != len(of_world):
        animated = set()
        notes.append("what moves is drawn where the file has it")
    kept = _largest(scene, MOST_TRIANGLES)
    if not kept.all():
        notes.append(f"the largest {np.count_nonzero(kept):,} of {len(kept):,} things are drawn")
    still: list[Instance] = []
    moving: list[tuple[int, bytes]] = []
    for k, group in enumerate(groups):
        instances = [placed[i] for i in group if kept[i]]
        if not instances:
            continue
        if k not in animated:
            still += instances
            continue
        node = np.linalg.inv(without_scale(before.get(k, of_world[k].world_from_node)))
        own = [Instance(one.mesh, node @ one.world_from_mesh, name=one.name) for one in instances]
        moving.append((k, _glb(scene.replace(instances=own, rig=None))))
    drawn = _instanced(_glb(scene.replace(instances=still, rig=None))) if still else None
    if scene.animations:
        notes.append("bones and morph targets are drawn as the file has them")
    return DrawnScene(drawn, tuple(moving), "; ".join(notes))


def _unlit(scene: Scene) -> Scene:
    """With materials that show what they are; meshes without one get one, or they would be lit."""
    materials = [_as_seen_unlit(one) for one in scene.materials]
    meshes = [
        one if one.material is not None else one.replace(material=len(materials))
        for one in scene.meshes
    ]
    return scene.replace(meshes=meshes, materials=[*materials, Material(unlit=True)])


def _as_seen_unlit(material: Material) -> Material:
    """One that shows base colour and emission as they are. glTF's unlit materials have no emission
    beside their colour; of two where one is a picture the brighter is shown."""
    shine = np.array(material.emissive)
    color = np.array(material.base_color)
    plain = {"unlit": True, "emissive": (0, 0, 0), "emissive_texture": None}
    if material.unlit or not shine.any():
        return material.replace(**plain)
    if material.base_color_texture is None and material.emissive_texture is None:
        color[:3] = np.minimum(color[:3] + shine, 1)
        return material.replace(**plain, base_color=color)
    if material.alpha_mode == "opaque" and shine.sum() > color[:3].sum():
        color[:3] = np.minimum(shine, 1)
        return material.replace(
            **plain, base_color=color, base_color_texture=material.emissive_texture
        )
    return material.replace(**plain)


def without_scale(matrix: Floats) -> Floats:
    """A transform (4, 4) with its rotation and translation alone."""
    left, _, right = np.linalg.svd(matrix[:3, :3])
    turn = left @ np.diag([1, 1, np.linalg.det(left @ right)]) @ right
    rigid = np.eye(4)
    rigid[:3, :3], rigid[:3, 3] = turn, matrix[:3, 3]
    return rigid


def sky_dome(world: World, radius_m: float) -> bytes:
    """What is behind all things, on a sphere around them, as glTF."""
    if world.light is None:
        empty = World(Scene(), background=world.background, threads=1)
    else:
        empty = World(Scene(), light=world.light, lighting="path", threads=1)
    camera = Camera(type="panoramic")
    picture = render_camera(empty, camera, width=_SKY_WIDTH, height=_SKY_WIDTH // 2, samples=4)
    rgb = colours_of(world, picture)
    if rgb.shape[-1] != 3:
        rgb = np.repeat(rgb[..., :1], 3, axis=2)
    pixels = display(np.ascontiguousarray(rgb))
    rows, columns = 24, 48
    v, u = np.meshgrid(np.linspace(0, 1, rows + 1), np.linspace(0, 1, columns + 1), indexing="ij")
    azimuth, elevation = 2 * np.pi * (u - 0.5), np.pi * (0.5 - v)
    across = np.cos(elevation)
    out = np.stack([np.sin(azimuth) * across, np.sin(elevation), -np.cos(azimuth) * across], axis=2)
    first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    below = first + columns + 1
    quads = [[first, below, first + 1], [first + 1, below, below + 1]]
    triangles = np.concatenate([np.stack(three, axis=1) for three in quads])
    mesh = Mesh(
        radius_m * out.reshape(-1, 3),
        triangles,
        texture_coordinates=np.stack([u.ravel(), v.ravel()], axis=1),
        material=0,
    )
    material = Material("sky", base_color_texture=0, unlit=True, double_sided=True)
    texture = Texture(0, wrap_v="clamp_to_edge")
    return _glb(
        Scene(meshes=[mesh], materials=[material], images=[Image(pixels)], textures=[texture])
    )


def _groups(scene: Scene) -> list[list[int]]:
    """Indices of instances by the node that places them, in the order of the file."""
    found: dict[Any, list[int]] = {}
    for i, one in enumerate(scene.instances):
        found.setdefault(("alone", i) if one.node is None else one.node, []).append(i)
    return list(found.values())


def _largest(scene: Scene, most: int) -> NDArray[np.bool_]:
    """Which instances are kept so that they have ``most`` triangles at most: the largest."""
    meshes = scene.meshes
    size = [
        float(np.linalg.norm(np.ptp(m.positions_m, axis=0))) if len(m.positions_m) else 0.0
        for m in meshes
    ]
    count = np.array([len(meshes[one.mesh].triangles) for one in scene.instances], np.int64)
    if count.sum() <= most:
        return np.ones(len(count), bool)
    scale = [
        size[one.mesh] * abs(np.linalg.det(one.world_from_mesh[:3, :3])) ** (1 / 3)
        for one in scene.instances
    ]
    order = np.argsort(-np.array(scale), kind="stable")
    kept = np.zeros(len(count), bool)
    kept[order[np.cumsum(count[order]) <= most]] = True
    return kept


def _glb(scene: Scene) -> bytes:
    with tempfile.TemporaryDirectory(prefix="omma-view-") as folder:
        path = Path(folder) / "scene.glb"
        save_scene(path, scene)
        return path.read_bytes()


def _instanced(glb: bytes) -> bytes:
    """The same file, in which nodes that place one mesh are one, with all its transforms
    (EXT_mesh_gpu_instancing), so that a browser draws them at once."""
    document, data = _parts(glb)
    nodes = document["nodes"]
    roots = document["scenes"][document.get("scene", 0)]["nodes"]
    transforms_of: dict[int, list[tuple[int, Floats]]] = defaultdict(list)
    for k in roots:
        matrix = _matrix(nodes[k])
        if "mesh" in nodes[k] and not nodes[k].get("children") and _is_trs(matrix):
            transforms_of[nodes[k]["mesh"]].append((k, matrix))
    gone: set[int] = set()
    made: list[dict[str, Any]] = []
    for mesh, found in transforms_of.items():
        if len(found) < _LEAST_COPIES:
            continue
        factors = [_trs(matrix) for _, matrix in found]
        attributes = {}
        for name, kind, column in (
            ("TRANSLATION", "VEC3", 0),
            ("ROTATION", "VEC4", 1),
            ("SCALE", "VEC3", 2),
        ):
            values = np.array([one[column] for one in factors], "<f4")
            data += b"\0" * (-len(data) % 4)
            view = {"buffer": 0, "byteOffset": len(data), "byteLength": values.nbytes}
            data += values.tobytes()
            document["bufferViews"].append(view)
            document["accessors"].append(
                {
                    "bufferView": len(document["bufferViews"]) - 1,
                    "componentType": 5126,
                    "count": len(values),
                    "type": kind,
                }
            )
            attributes[name] = len(document["accessors"]) - 1
        extension = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
        made.append({"mesh": mesh, "extensions": extension})
        gone.update(k for k, _ in found)
    if not made:
        return glb
    kept = [k for k in roots if k not in gone]
    scene = document["scenes"][document.get("scene", 0)]
    scene["nodes"] = [*kept, *range(len(nodes), len(nodes) + len(made))]
    nodes += made
    # Nodes that nothing places any more stay in the list as empty ones: indices are kept.
    for k in gone:
        nodes[k] = {}
    for name in ("extensionsUsed", "extensionsRequired"):
        document[name] = [*document.get(name, []), "EXT_mesh_gpu_instancing"]
    return _whole(document, data)


def _parts(glb: bytes) -> tuple[dict[str, Any], bytes]:
    length = struct.unpack_from("<I", glb, 12)[0]
    document = json.loads(glb[20 : 20 + length])
    start = 20 + length + 8
    return document, glb[start:] if start <= len(glb) else b""


def _whole(document: dict[str, Any], data: bytes) -> bytes:
    data += b"\0" * (-len(data) % 4)
    document["buffers"] = [{"byteLength": len(data)}]
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), _JSON) + text + struct.pack("<II", len(data), _BIN)
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks) + len(data)) + chunks + data


def _matrix(node: dict[str, Any]) -> Floats:
    if "matrix" in node:
        return np.asarray(np.array(node["matrix"], np.float64).reshape(4, 4).T)
    from scipy.spatial.transform import Rotation

    matrix = np.eye(4)
    turn = Rotation.from_quat(node.get("rotation", [0, 0, 0, 1])).as_matrix()
    matrix[:3, :3] = turn * np.array(node.get("scale", [1, 1, 1]))
    matrix[:3, 3] = node.get("translation", [0, 0, 0])
    return matrix


def _trs(matrix: Floats) -> tuple[Floats, Floats, Floats]:
    """Translation, quaternion (x, y, z, w) and scale of a transform without shear."""
    from scipy.spatial.transform import Rotation

    scale = np.linalg.norm(matrix[:3, :3], axis=0)
    if np.linalg.det(matrix[:3, :3]) < 0:
        scale[0] = -scale[0]
    turn = Rotation.from_matrix(matrix[:3, :3] / scale).as_quat()
    return matrix[:3, 3], turn, scale


def _is_trs(matrix: Floats) -> bool:
    columns = matrix[:3, :3]
    length = np.linalg.norm(columns, axis=0)
    if not (length > 0).all():
        return False
    axes = columns / length
    return bool(np.allclose(axes.T @ axes, np.eye(3), atol=1e-4))
