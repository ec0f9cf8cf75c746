"""Files of points that the tests write, and what is in them."""

import numpy as np
import pytest

RNG = np.random.default_rng(4)
COUNT = 500
# As a scanner has them: z up.
PLACES = RNG.uniform(-1, 1, (COUNT, 3)).astype(np.float32)
COLOURS = RNG.integers(0, 256, (COUNT, 3))
CLASSES = RNG.integers(1, 4, COUNT)


def srgb_to_linear(value):
    """IEC 61966-2-1."""
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def write_ply(path, columns, kind="binary_little_endian", count=None, cut=0):
    """Columns by name: (type of PLY, values)."""
    types = {"float": "f4", "double": "f8", "uchar": "u1", "ushort": "u2", "int": "i4"}
    rows = len(next(iter(columns.values()))[1])
    lines = [f"property {type_} {name}" for name, (type_, _) in columns.items()]
    header = ["ply", f"format {kind} 1.0", f"element vertex {count or rows}", *lines, "end_header"]
    head = ("\n".join(header) + "\n").encode()
    if kind == "ascii":
        text = [" ".join(str(values[i]) for _, values in columns.values()) for i in range(rows)]
        body = ("\n".join(text) + "\n").encode()
    else:
        order = "<" if "little" in kind else ">"
        table = np.empty(
            rows, [(name, order + types[type_]) for name, (type_, _) in columns.items()]
        )
        for name, (_, values) in columns.items():
            table[name] = values
        body = table.tobytes()
    path.write_bytes(head + body[: len(body) - cut])
    return path


def ply_columns(places=PLACES, **more):
    return {**{axis: ("float", places[:, k]) for k, axis in enumerate("xyz")}, **more}


def colour_columns(type_="uchar", values=COLOURS):
    return {name: (type_, values[:, k]) for k, name in enumerate(("red", "green", "blue"))}


def write_las(path, places=PLACES, colours=None, classes=CLASSES, **dimensions):
    laspy = pytest.importorskip("laspy")
    if path.suffix == ".laz":
        pytest.importorskip("lazrs")
    header = laspy.LasHeader(point_format=3 if colours is not None else 0, version="1.2")
    header.scales, header.offsets = [1e-4] * 3, np.round(np.mean(places, axis=0))
    las = laspy.LasData(header)
    las.x, las.y, las.z = np.asarray(places, float).T
    las.classification = classes
    las.intensity = np.arange(len(places)) % 60_000
    if colours is not None:
        las.red, las.green, las.blue = np.asarray(colours).T
    for name, values in dimensions.items():
        las[name] = values
    las.write(path)
    return path


def turned(places):
    """z up as y up."""
    return np.stack([places[:, 0], places[:, 2], -places[:, 1]], axis=1)
