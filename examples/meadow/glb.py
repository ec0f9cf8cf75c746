"""Writes a glTF 2.0 binary (.glb) from triangle meshes: only what the meadow needs of the format.

Vertex attributes of one kind share a buffer view with a stride, colours are normalised bytes, and
indices are 8 or 16 bit, which keeps the file small. Meshes carry no normals: unlit materials need
none (the light is baked into the colours), and for others a reader must compute flat ones.
"""

import json
import struct
from dataclasses import dataclass, field, replace

import numpy as np

UBYTE, USHORT, FLOAT = 5121, 5123, 5126
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963


@dataclass
class Mesh:
    """Triangles: position (V, 3) in metres, colour (V, 3) linear, texcoord (V, 2), index (T, 3).

    colour holds the light, for unlit materials. For others part (T,) says what a triangle is of,
    and brightness (V,) how bright it is, relative to its material.
    """

    position: np.ndarray
    colour: np.ndarray
    index: np.ndarray
    texcoord: np.ndarray | None = None
    part: np.ndarray | None = None
    brightness: np.ndarray | None = None

    def moved(self, matrix=None, offset=(0, 0, 0)):
        position = self.position if matrix is None else self.position @ np.asarray(matrix).T
        return replace(self, position=position + np.asarray(offset))

    def tinted(self, factor):
        return replace(self, colour=np.clip(self.colour * factor, 0, 1))

    def of(self, part):
        """The same triangles, all of one part."""
        return replace(self, part=np.full(len(self.index), part))

    def cut(self, chosen):
        """The chosen triangles (T,) alone, with the vertices they use."""
        used, index = np.unique(self.index[chosen], return_inverse=True)
        return Mesh(
            self.position[used],
            self.colour[used],
            index.reshape(-1, 3),
            None if self.texcoord is None else self.texcoord[used],
            None if self.part is None else self.part[chosen],
            None if self.brightness is None else self.brightness[used],
        )


def join(meshes):
    """One mesh out of several (all with or all without texture coordinates)."""
    starts = np.cumsum([0] + [len(m.position) for m in meshes[:-1]])
    return Mesh(
        np.concatenate([m.position for m in meshes]),
        np.concatenate([m.colour for m in meshes]),
        np.concatenate([m.index + s for m, s in zip(meshes, starts)]),
        None if meshes[0].texcoord is None else np.concatenate([m.texcoord for m in meshes]),
        None if meshes[0].part is None else np.concatenate([m.part for m in meshes]),
    )


@dataclass
class Glb:
    """The document as it grows; `views` hold the bytes of each shared buffer view."""

    document: dict
    views: dict = field(default_factory=dict)
    images: list = field(default_factory=list)
    shared: dict = field(default_factory=dict)


VIEW_FIELDS = {
    "positions": {"byteStride": 12, "target": ARRAY_BUFFER},
    "texcoords": {"byteStride": 8, "target": ARRAY_BUFFER},
    "colours": {"byteStride": 4, "target": ARRAY_BUFFER},
    "indices16": {"target": ELEMENT_ARRAY_BUFFER},
    "indices8": {"target": ELEMENT_ARRAY_BUFFER},
}


def new_glb(generator, copyright_line, extensions):
    asset = {"version": "2.0", "generator": generator, "copyright": copyright_line}
    keys = ("accessors", "meshes", "materials", "textures", "images", "samplers", "cameras")
    document = {"asset": asset, "extensionsUsed": extensions}
    document |= {"scene": 0, "scenes": [], "nodes": []} | {key: [] for key in keys}
    return Glb(document, {name: bytearray() for name in VIEW_FIELDS})


def append(glb, key, value):
    glb.document[key].append(value)
    return len(glb.document[key]) - 1


def add_accessor(glb, view, array, component, kind, **more):
    """Appends the array to its view; the same bytes are stored only once."""
    data = np.ascontiguousarray(array).tobytes()
    known = (view, component, data)
    if known not in glb.shared:
        accessor = {"bufferView": list(VIEW_FIELDS).index(view), "byteOffset": len(glb.views[view])}
        accessor |= {"componentType": component, "count": len(array), "type": kind} | more
        glb.views[view] += data
        glb.shared[known] = append(glb, "accessors", accessor)
    return glb.shared[known]


def colour_bytes(colour):
    """Linear (V, 3) to normalised bytes (V, 4), dithered so that slow gradients do not band."""
    # The golden-ratio sequence is an even dither that needs no random state.
    dither = (np.arange(len(colour))[:, None] * [0.6180340, 0.7548777, 0.5698403]) % 1.0
    rgb = np.clip(np.floor(np.clip(colour, 0, 1) * 255 + dither), 0, 255)
    return np.concatenate([rgb, np.full((len(rgb), 1), 255)], axis=1).astype(np.uint8)


def add_mesh(glb, name, mesh, material):
    """A mesh of one unlit material (an index), with its colours; or of several lit ones: an index
    for each part, "" for a mesh without parts."""
    if isinstance(material, int):
        pieces = [(mesh, colour_bytes(mesh.colour), material)]
    elif mesh.part is None:
        pieces = [(mesh, brightness_bytes(mesh.brightness), material[""])]
    else:
        cuts = [(mesh.cut(mesh.part == part), material[part]) for part in np.unique(mesh.part)]
        pieces = [(cut, brightness_bytes(cut.brightness), index) for cut, index in cuts]
    primitives = [add_primitive(glb, name, *piece) for piece in pieces]
    return append(glb, "meshes", {"name": name, "primitives": primitives})


def brightness_bytes(brightness):
    return None if brightness is None else colour_bytes(np.repeat(brightness[:, None], 3, axis=1))


def add_primitive(glb, name, mesh, colours, material):
    position = mesh.position.astype("<f4")
    attributes = {
        "POSITION": add_accessor(
            glb,
            "positions",
            position,
            FLOAT,
            "VEC3",
            min=[float(v) for v in position.min(axis=0)],
            max=[float(v) for v in position.max(axis=0)],
        )
    }
    if colours is not None:
        attributes["COLOR_0"] = add_accessor(
            glb, "colours", colours, UBYTE, "VEC4", normalized=True
        )
    if mesh.texcoord is not None:
        texcoord = mesh.texcoord.astype("<f4")
        attributes["TEXCOORD_0"] = add_accessor(glb, "texcoords", texcoord, FLOAT, "VEC2")
    # The largest value of an index type is the restart value and not allowed.
    small = len(position) <= 255
    view, component = ("indices8", UBYTE) if small else ("indices16", USHORT)
    index = mesh.index.reshape(-1).astype("u1" if small else "<u2")
    if len(position) > 65535:
        raise ValueError(f"mesh {name}: {len(position)} vertices are too many for 16-bit indices")
    indices = add_accessor(glb, view, index, component, "SCALAR")
    return {"attributes": attributes, "indices": indices, "material": material}


def add_texture(glb, name, data, mime_type, wrap):
    sampler = {"magFilter": 9729, "minFilter": 9987, "wrapS": wrap, "wrapT": wrap}
    if sampler not in glb.document["samplers"]:
        append(glb, "samplers", sampler)
    view = len(VIEW_FIELDS) + len(glb.images)
    glb.images.append(data)
    image = append(glb, "images", {"name": name, "mimeType": mime_type, "bufferView": view})
    texture = {
        "name": name,
        "sampler": glb.document["samplers"].index(sampler),
        "source": image,
    }
    return append(glb, "textures", texture)


def add_unlit_material(glb, name, texture=None, cutout=False):
    surface = {"metallicFactor": 0, "roughnessFactor": 1}
    if texture is not None:
        surface["baseColorTexture"] = {"index": texture}
    material = {"name": name, "pbrMetallicRoughness": surface, "doubleSided": True}
    material["extensions"] = {"KHR_materials_unlit": {}}
    if cutout:
        material |= {"alphaMode": "MASK", "alphaCutoff": 0.5}
    return append(glb, "materials", material)


def glb_bytes(glb):
    """Lays out the buffer views, then the two chunks of the file."""
    blob = bytearray()
    views = [(bytes(glb.views[name]), fields) for name, fields in VIEW_FIELDS.items()]
    glb.document["bufferViews"] = []
    for data, fields in views + [(image, {}) for image in glb.images]:
        view = {"buffer": 0, "byteOffset": len(blob), "byteLength": len(data)} | fields
        append(glb, "bufferViews", view)
        blob += data + bytes(-len(data) % 4)
    glb.document["buffers"] = [{"byteLength": len(blob)}]
    text = json.dumps(glb.document, separators=(",", ":"), ensure_ascii=True).encode("ascii")
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + len(blob)
    header = struct.pack("<4sIIII", b"glTF", 2, total, len(text), 0x4E4F534A)
    return header + text + struct.pack("<II", len(blob), 0x004E4942) + bytes(blob)
