"""Small OCES files for tests, made by hand as the standard says, and the standard's schemas."""

import base64
import json
import struct
import zlib

import numpy as np
from conftest import DATA

SCHEMAS = DATA / "oces"


class OcesFile:
    """A glTF document with one buffer; heads, eyes and properties are added to it."""

    def __init__(self):
        self.binary = b""
        self.oces = {"version": "0.3.0", "ommatidialProperties": [], "eyes": []}
        self.document = {
            "asset": {"version": "2.0"},
            "extensionsUsed": ["OCES_eyes"],
            "extensions": {"OCES_eyes": self.oces},
            "nodes": [],
            "accessors": [],
            "bufferViews": [],
        }

    def view(self, data):
        self.binary += b"\0" * (-len(self.binary) % 4)
        self.document["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)}
        )
        self.binary += data
        return len(self.document["bufferViews"]) - 1

    def accessor(self, values, dtype="<f4"):
        array = np.asarray(values, dtype=dtype)
        width = array.shape[1] if array.ndim == 2 else 1
        kind = {"<f4": 5126, "<u2": 5123, "u1": 5121}[dtype]
        self.document["accessors"].append(
            {
                "bufferView": self.view(array.tobytes()),
                "componentType": kind,
                "count": len(array),
                "type": "SCALAR" if width == 1 else f"VEC{width}",
            }
        )
        return len(self.document["accessors"]) - 1

    def texture(self, texels, **sampler):
        """8-bit PNG, (height, width) grey or (height, width, 3)."""
        texels = np.asarray(texels, dtype=np.uint8)
        height, width = texels.shape[:2]
        rows = b"".join(b"\0" + row.tobytes() for row in texels)
        colour = 0 if texels.ndim == 2 else 2

        def chunk(name, data):
            crc = struct.pack(">I", zlib.crc32(name + data))
            return struct.pack(">I", len(data)) + name + data + crc

        png = b"\x89PNG\r\n\x1a\n"
        png += chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, colour, 0, 0, 0))
        png += chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
        for name in ("images", "textures", "samplers"):
            self.document.setdefault(name, [])
        self.document["images"].append({"bufferView": self.view(png), "mimeType": "image/png"})
        self.document["samplers"].append(sampler)
        index = len(self.document["images"]) - 1
        self.document["textures"].append({"source": index, "sampler": index})
        return len(self.document["textures"]) - 1

    def property(self, type_, value, **rest):
        self.oces["ommatidialProperties"].append({"type": type_, "value": value, **rest})
        return len(self.oces["ommatidialProperties"]) - 1

    def values(self, values, **rest):
        return self.property("ACCESSOR", self.accessor(values), **rest)

    def coarse(self, value):
        return self.property("COARSE", value)

    def eye(self, type_="POINT_OMMATIDIAL", properties=None, **rest):
        self.oces["eyes"].append({"type": type_, "ommatidialProperties": properties or {}, **rest})
        return len(self.oces["eyes"]) - 1

    def node(self, extension=None, **rest):
        node = dict(rest)
        if extension is not None:
            node["extensions"] = {"OCES_eyes": extension}
        self.document["nodes"].append(node)
        return len(self.document["nodes"]) - 1

    def simple_eye(self, **rest):
        """One ommatidium 2 mm ahead and 1 mm to the left and 0.5 mm up, looking ahead."""
        return self.eye(
            properties={
                "POSITION": self.coarse([0.001, 0.0005, 0.002]),
                "ORIENTATION": self.coarse([0, 0, 1]),
                "DIAMETER": self.coarse(2e-5),
                "FOCAL_OFFSET": self.coarse(-1e-4),
            },
            **rest,
        )

    def text(self):
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.binary).decode()
        document = dict(self.document)
        for name in ("accessors", "bufferViews"):
            if not document[name]:
                del document[name]
        if not self.oces["ommatidialProperties"]:
            del self.oces["ommatidialProperties"]
        if self.binary:
            document["buffers"] = [{"byteLength": len(self.binary), "uri": uri}]
        return json.dumps(document)

    def write(self, path):
        path.write_text(self.text())
        return path


def validator():
    """What checks a document's extension against the standard's schemas.

    Khronos' own schemas are not among them: stand-ins say what is needed. Two schemas are no strict
    JSON Schema: texts stand as comments in lists of schemas, and are left out here; "type" holds a
    schema, which is moved.
    """
    from jsonschema import Draft202012Validator
    from referencing import Registry, Resource

    def strict(value):
        if isinstance(value, list):
            return [strict(v) for v in value]
        if not isinstance(value, dict):
            return value
        made = {}
        for key, inner in value.items():
            if key in ("allOf", "oneOf", "anyOf") and isinstance(inner, list):
                inner = [v for v in inner if not isinstance(v, str)]
            if key == "type" and isinstance(inner, dict) and set(inner) == {"anyOf"}:
                made |= strict(inner)
            elif key == "$comment" and not isinstance(inner, str):
                continue
            else:
                made[key] = strict(inner)
        return made

    def in_comment(text, line, instead):
        assert line in text
        return text.replace(line, instead)

    resources = []
    for path in SCHEMAS.glob("*.json"):
        text = path.read_text()
        if path.name == "eye.schema.json":
            text = in_comment(
                text,
                '"$comment": "Include the properties that are specific to each eye type, '
                'allowing for only one."',
                '"Include"',
            )
        if path.name == "eye.shared.schema.json":
            for line in (
                '"$comment": "All eyes are defined as the child of a root property:",',
                '"$comment": "All eyes must define their type:",',
            ):
                text = in_comment(text, line, "")
        if path.name == "ommatidialProperty.schema.json":
            line = '"$comment": "Each eye property type has subtle differences in its schema, so'
            text = in_comment(text, line + ' each is defined individually here:",', "")
        if path.name == "node.OCES_eyes.schema.json":
            # "head" and "eye" stand in a list, as if in an object.
            a, b = text.index('"oneOf": ['), text.index('"extensions": {}')
            inner = text[text.index('"head"', a) : text.rindex("]", a, b)]
            text = text[:a] + inner.rstrip() + ",\n" + text[b:]
        schema = strict(json.loads(text))
        schema.pop("$id", None)
        resources.append((path.name, Resource.from_contents(schema)))
    meta = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    stubs = {
        "glTFid.schema.json": {"type": "integer", "minimum": 0},
        "glTFProperty.schema.json": {"type": "object"},
        "glTFChildOfRootProperty.schema.json": {"type": "object"},
    }
    for name, stub in stubs.items():
        resources.append((name, Resource.from_contents(meta | stub)))
    registry = Registry().with_resources(resources)

    def check(name, instance):
        schema = registry.contents(name)
        Draft202012Validator.check_schema(schema)
        Draft202012Validator(schema, registry=registry).validate(instance)

    return check
