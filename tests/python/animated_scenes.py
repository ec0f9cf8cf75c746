"""Small animated glTF files, as exporters write them, and what they are made of."""

import base64
import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import omma

_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
_COMPONENTS = {"f4": 5126, "u1": 5121, "u2": 5123, "u4": 5125, "i1": 5120, "i2": 5122}


@dataclass
class Builder:
    """A glTF document that grows; accessors are given as arrays."""

    document: dict = field(
        default_factory=lambda: {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": []}],
            "nodes": [],
            "meshes": [],
            "accessors": [],
            "bufferViews": [],
        }
    )
    data: bytes = b""

    def accessor(self, values, dtype="f4", normalized=False):
        """The index of a new accessor of (N,) or (N, components) values."""
        array = np.ascontiguousarray(values, "<" + dtype)
        components = array.shape[1] if array.ndim == 2 else 1
        self.data += b"\0" * (-len(self.data) % 4)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": array.nbytes}
        self.data += array.tobytes()
        self.document["bufferViews"].append(view)
        made = {
            "bufferView": len(self.document["bufferViews"]) - 1,
            "componentType": _COMPONENTS[dtype],
            "count": len(array),
            "type": _TYPES[components],
        }
        if normalized:
            made["normalized"] = True
        self.document["accessors"].append(made)
        return len(self.document["accessors"]) - 1

    def mesh(self, positions, triangles, *, normals=None, targets=(), **attributes):
        """The index of a new mesh of one primitive; attributes are indices of accessors."""
        primitive = {
            "attributes": {"POSITION": self.accessor(positions), **attributes},
            "indices": self.accessor(np.ravel(triangles), "u4"),
        }
        if normals is not None:
            primitive["attributes"]["NORMAL"] = self.accessor(normals)
        if targets:
            primitive["targets"] = [
                {name: self.accessor(values) for name, values in one.items()} for one in targets
            ]
        self.document["meshes"].append({"primitives": [primitive]})
        return len(self.document["meshes"]) - 1

    def node(self, parent=None, **properties):
        """The index of a new node, a root where it has no parent."""
        index = len(self.document["nodes"])
        self.document["nodes"].append(properties)
        if parent is None:
            self.document["scenes"][0]["nodes"].append(index)
        else:
            self.document["nodes"][parent].setdefault("children", []).append(index)
        return index

    def animation(self, channels, name=None):
        """Channels are (node, path, times, values, interpolation)."""
        made = {"channels": [], "samplers": []}
        if name is not None:
            made["name"] = name
        for node, path, times, values, interpolation in channels:
            values = np.asarray(values, float)
            values = (
                values.reshape(-1) if path == "weights" else values.reshape(-1, values.shape[-1])
            )
            made["samplers"].append(
                {
                    "input": self.accessor(times),
                    "output": self.accessor(values),
                    "interpolation": interpolation,
                }
            )
            made["channels"].append(
                {
                    "sampler": len(made["samplers"]) - 1,
                    "target": {"node": node, "path": path},
                }
            )
        self.document.setdefault("animations", []).append(made)

    def skin(self, joints, inverse_bind=None):
        """The index of a new skin; inverse_bind (J, 4, 4)."""
        made = {"joints": list(joints)}
        if inverse_bind is not None:
            columns = np.asarray(inverse_bind).transpose(0, 2, 1).reshape(-1, 16)
            made["inverseBindMatrices"] = self.accessor(columns)
        self.document.setdefault("skins", []).append(made)
        return len(self.document["skins"]) - 1

    def write(self, path):
        """The file, whole in itself."""
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()
        buffers = [{"uri": uri, "byteLength": len(self.data)}]
        path = Path(path)
        path.write_text(json.dumps({**self.document, "buffers": buffers}))
        return path


def cube(half=0.5):
    """Positions (24, 3), normals (24, 3) and triangles (12, 3) of a cube with flat faces."""
    positions, normals, triangles = [], [], []
    for axis in range(3):
        for sign in (-1, 1):
            normal = np.zeros(3)
            normal[axis] = sign
            right = np.roll(np.abs(normal), 1)
            up = np.cross(normal, right)
            first = len(positions)
            for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                positions.append(half * (normal + u * right + v * up))
                normals.append(normal)
            triangles += [[first, first + 1, first + 2], [first, first + 2, first + 3]]
    return np.array(positions), np.array(normals), np.array(triangles)


def tube(rings=21, sides=16, length=2.0, radius=0.3):
    """A tube along +Y: positions, normals, triangles."""
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = np.stack([np.cos(angle), np.zeros(sides), np.sin(angle)], axis=1)
    heights = np.linspace(0, length, rings)
    positions = (radius * ring)[None] + heights[:, None, None] * np.array([0, 1, 0])
    normals = np.broadcast_to(ring, positions.shape)
    i, j = np.meshgrid(np.arange(rings - 1), np.arange(sides), indexing="ij")
    a, b = i * sides + j, i * sides + (j + 1) % sides
    c, d = a + sides, b + sides
    triangles = np.concatenate([np.stack([a, c, b], -1), np.stack([b, c, d], -1)])
    return positions.reshape(-1, 3), normals.reshape(-1, 3), triangles.reshape(-1, 3)


def transform(translation=(0, 0, 0), rotation=(0, 0, 0, 1), scale=(1, 1, 1)):
    """translation * rotation * scale, (4, 4)."""
    from scipy.spatial.transform import Rotation

    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat(rotation).as_matrix() * np.asarray(scale)
    matrix[:3, 3] = translation
    return matrix


def swinging_box(path):
    """A cube that an animation named "swing" moves for a second, as a scene."""
    made = Builder()
    node = made.node(mesh=made.mesh(*cube()[::2]), name="box", translation=[0, 0, -3])
    made.animation([(node, "translation", [0, 1], [[0, 0, -3], [1, 0, -3]], "LINEAR")], "swing")
    return omma.load_scene(made.write(path))


def nested(tmp_path):
    """A tower: an arm on a turning base, a box at its end; a camera on the arm, a stone beside."""
    made = Builder()
    mesh = made.mesh(*cube(0.25)[::2])
    tower = made.node(name="tower", translation=[10, 0, 0], scale=[2, 2, 2])
    base = made.node(tower, name="base", mesh=mesh)
    arm = made.node(base, name="arm", translation=[0, 1, 0])
    made.node(arm, name="box", mesh=mesh, translation=[0, 0, -3])
    made.document["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]
    made.node(arm, name="eye", camera=0, translation=[0, 0.5, 0])
    made.node(name="stone", mesh=mesh, translation=[0, 0, 5])
    turns = [[0, 0, 0, 1], [0, 1, 0, 0]]
    made.animation([(base, "rotation", [0, 2], turns, "LINEAR")], "turn")
    made.animation([(arm, "translation", [0, 1], [[0, 1, 0], [0, 3, 0]], "LINEAR")], "lift")
    return omma.load_scene(made.write(tmp_path / "nested.gltf"))
