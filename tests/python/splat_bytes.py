"""Small files of Gaussian splats, written number by number as their specifications say."""

import gzip
import struct

import numpy as np

DEGREES = {1: 0, 4: 1, 9: 2, 16: 3}
PLY_TYPES = {"float": "f4", "double": "f8", "uchar": "u1", "uint": "u4", "int": "i4"}


def raw_splats(count, terms, seed=1):
    """Columns as 3DGS trains them, by the names of its PLY files."""
    rng = np.random.default_rng(seed)
    columns = {name: rng.normal(size=count) for name in ("x", "y", "z", "nx", "ny", "nz")}
    columns.update({f"f_dc_{k}": rng.uniform(-1, 1, count) for k in range(3)})
    columns.update({f"f_rest_{k}": rng.uniform(-0.9, 0.9, count) for k in range(3 * terms - 3)})
    columns["opacity"] = rng.normal(size=count) * 2
    columns.update({f"scale_{k}": rng.normal(size=count) - 3 for k in range(3)})
    columns.update({f"rot_{k}": rng.normal(size=count) * 3 for k in range(4)})
    return {name: values.astype(np.float32) for name, values in columns.items()}


def ply(elements, kind="binary_little_endian", cut=0):
    """The bytes of a PLY file; elements by name: columns by name, each (type of PLY, values)."""
    lines = ["ply", f"format {kind} 1.0", "comment made"]
    order, body = "<" if "little" in kind else ">", b""
    for element, columns in elements.items():
        rows = len(next(iter(columns.values()))[1])
        lines.append(f"element {element} {rows}")
        lines += [f"property {type_} {name}" for name, (type_, _) in columns.items()]
        if kind == "ascii":
            for row in zip(*(values for _, values in columns.values())):
                body += " ".join(f"{float(one)!r}" for one in row).encode() + b"\n"
        else:
            types = [(name, order + PLY_TYPES[type_]) for name, (type_, _) in columns.items()]
            table = np.empty(rows, types)
            for name, (_, values) in columns.items():
                table[name] = values
            body += table.tobytes()
    head = "\n".join([*lines, "end_header"]) + "\n"
    return head.encode() + body[: len(body) - cut]


def floats(columns, type_="float"):
    return {name: (type_, values) for name, values in columns.items()}


def spz_attributes(columns, version, bits=12):
    """The bytes of each attribute, splat after splat (nianticlabs/spz, README.md)."""
    count = len(columns["x"])
    terms = 1 + sum(name.startswith("f_rest") for name in columns) // 3
    position, alpha, colour, scale, rotation, harmonics = (bytearray() for _ in range(6))
    for i in range(count):
        value = {name: float(values[i]) for name, values in columns.items()}
        for axis in "xyz":
            whole = round(value[axis] * 2**bits)
            position += (whole & 0xFFFFFF).to_bytes(3, "little")
        alpha.append(clamped(255 / (1 + np.exp(-value["opacity"]))))
        colour += bytes(clamped(value[f"f_dc_{k}"] * 0.15 * 255 + 127.5) for k in range(3))
        scale += bytes(clamped((value[f"scale_{k}"] + 10) * 16) for k in range(3))
        wxyz = np.array([value[f"rot_{k}"] for k in range(4)])
        xyzw = wxyz[[1, 2, 3, 0]] / np.linalg.norm(wxyz)
        rotation += first_three(xyzw) if version == 2 else smallest_three(xyzw)
        for k in range(terms - 1):
            for c in range(3):
                coefficient = value[f"f_rest_{c * (terms - 1) + k}"]
                harmonics.append(clamped(coefficient * 128 + 128))
    return [bytes(one) for one in (position, alpha, colour, scale, rotation, harmonics)]


def clamped(value):
    return int(min(max(np.round(value), 0), 255))


def first_three(xyzw):
    positive = xyzw * (-1 if xyzw[3] < 0 else 1)
    return bytes(clamped(one * 127.5 + 127.5) for one in positive[:3])


def smallest_three(xyzw):
    largest = int(np.argmax(np.abs(xyzw)))
    negate = xyzw[largest] < 0
    packed = largest
    for k in range(4):
        if k != largest:
            magnitude = int(511 * abs(xyzw[k]) / np.sqrt(0.5) + 0.5)
            packed = packed << 10 | int((xyzw[k] < 0) != negate) << 9 | magnitude
    return struct.pack("<I", packed)


def spz(columns, version=3, bits=12, **more):
    """The bytes of an .spz file; ``more`` changes what its head says."""
    attributes = spz_attributes(columns, version, bits)
    terms = 1 + sum(name.startswith("f_rest") for name in columns) // 3
    head = {"count": len(columns["x"]), "degree": DEGREES[terms], "flags": 0, **more}
    tail = head.get("tail", b"")
    numbers = (head.get("magic", 0x5053474E), head.get("says", version), head["count"])
    small = (head["degree"], head.get("says_bits", bits), head["flags"])
    if version < 4:
        start = struct.pack("<IIIBBBB", *numbers, *small, 0)
        return gzip.compress(start + b"".join(attributes) + tail, mtime=0)
    import zstandard

    attributes = [one for one in attributes if one]
    packed = [zstandard.compress(one) for one in attributes]
    start = struct.pack("<IIIBBBBI12x", *numbers, *small, len(packed), 32 + len(tail))
    table = b"".join(
        struct.pack("<QQ", len(small), len(large)) for small, large in zip(packed, attributes)
    )
    return start + tail + table + b"".join(packed)


def packed_ply(columns, has_colours=True):
    """The bytes of a PLY file as PlayCanvas packs them, chunks of 256 splats."""
    count = len(columns["x"])
    terms = 1 + sum(name.startswith("f_rest") for name in columns) // 3
    rgb = {c: 0.5 + columns[f"f_dc_{k}"] * 0.28209479177387814 for k, c in enumerate("rgb")}
    ranged = {axis: columns[axis] for axis in "xyz"}
    ranged.update({f"scale_{axis}": columns[f"scale_{k}"] for k, axis in enumerate("xyz")})
    ranged.update(rgb if has_colours else {})
    groups = [slice(start, start + 256) for start in range(0, count, 256)]
    chunk, share = {}, {name: values.astype(float) for name, values in rgb.items()}
    for name, values in ranged.items():
        low = np.array([values[group].min() for group in groups], np.float32)
        high = np.array([values[group].max() for group in groups], np.float32)
        chunk[f"min_{name}"], chunk[f"max_{name}"] = ("float", low), ("float", high)
        ends = [np.repeat(one.astype(float), 256)[:count] for one in (low, high)]
        share[name] = (values - ends[0]) / np.maximum(ends[1] - ends[0], 1e-12)
    alpha = 1 / (1 + np.exp(-columns["opacity"].astype(float)))
    whole = {name: np.clip(values, 0, 1) for name, values in (*share.items(), ("alpha", alpha))}

    def fixed(name, bits):
        return np.round(whole[name] * ((1 << bits) - 1)).astype(np.uint32)

    def three(before):
        x, y, z = (fixed(before + axis, bits) for axis, bits in zip("xyz", (11, 10, 11)))
        return x << 21 | y << 11 | z

    colour = sum(fixed(c, 8) << shift for c, shift in (("r", 24), ("g", 16), ("b", 8)))
    wxyz = np.stack([columns[f"rot_{k}"] for k in range(4)], axis=1).astype(float)
    wxyz /= np.linalg.norm(wxyz, axis=1, keepdims=True)
    rotation = np.zeros(count, np.uint32)
    for i, quaternion in enumerate(wxyz):
        largest = int(np.argmax(np.abs(quaternion)))
        turned = np.delete(quaternion * np.sign(quaternion[largest]), largest)
        a, b, c = (round((one / np.sqrt(2) + 0.5) * 1023) for one in turned)
        rotation[i] = largest << 30 | a << 20 | b << 10 | c
    vertex = {
        "packed_position": ("uint", three("")),
        "packed_rotation": ("uint", rotation),
        "packed_scale": ("uint", three("scale_")),
        "packed_color": ("uint", colour | fixed("alpha", 8)),
    }
    elements = {"chunk": chunk, "vertex": vertex}
    if terms > 1:
        rest = {name: values for name, values in columns.items() if name.startswith("f_rest")}
        elements["sh"] = {
            name: ("uchar", np.clip(np.floor((values / 8 + 0.5) * 256), 0, 255).astype(np.uint8))
            for name, values in rest.items()
        }
    return elements
