"""E57 files: scanners, poses and normals."""

import numpy as np
import pytest
from point_clouds import COLOURS, COUNT, PLACES, RNG, srgb_to_linear, turned

from omma.scene import load_points


def test_e57_has_scanners_and_poses(tmp_path):
    pye57 = pytest.importorskip("pye57")
    data = {f"cartesian{axis}": PLACES[:, k].astype(float) for k, axis in enumerate("XYZ")}
    for k, name in enumerate(("Red", "Green", "Blue")):
        data[f"color{name}"] = COLOURS[:, k].astype(np.uint8)
    data["cartesianInvalidState"] = (np.arange(COUNT) % 10 == 0).astype(np.int8)
    path = tmp_path / "a.e57"
    quarter = np.array([np.cos(np.pi / 4), 0, 0, np.sin(np.pi / 4)])  # about +Z
    with pye57.E57(str(path), mode="w") as file:
        file.write_scan_raw(data, rotation=quarter, translation=np.array([10.0, 20.0, 30.0]))
    with pytest.warns(UserWarning, match="50 points are left out: invalid"):
        cloud = load_points(path)
    kept = np.arange(COUNT) % 10 != 0
    expected = np.stack([-PLACES[:, 1], PLACES[:, 0], PLACES[:, 2]], axis=1) + (10, 20, 30)
    found = cloud.positions_m + cloud.offset_m
    assert found == pytest.approx(turned(expected[kept]), abs=1e-5)
    assert cloud.colors == pytest.approx(srgb_to_linear(COLOURS[kept] / 255), abs=1e-6)
    assert cloud.scanners_m + cloud.offset_m == pytest.approx(np.array([[10, 30, -20]]))


SURFACE_NORMALS = "http://www.libe57.org/E57_EXT_surface_normals.txt"


def write_e57(path, scans, prefix="nor", steps=0):
    """Scans of doubles by name, each with its rotation (w, x, y, z) and translation; what has a
    prefix is of an extension, and with ``steps`` a whole number of so many to 1."""
    pye57 = pytest.importorskip("pye57")
    e57 = pye57.libe57
    with pye57.E57(str(path), mode="w") as file:
        image = file.image_file

        def structure(values):
            made = e57.StructureNode(image)
            for name, value in values.items():
                made.set(name, value)
            return made

        def numbers(names, values):
            return structure(
                {name: e57.FloatNode(image, float(value)) for name, value in zip(names, values)}
            )

        def like(name):
            if steps and ":" in name:
                return e57.ScaledIntegerNode(image, 0, -steps, steps, 1 / steps, 0.0)
            return e57.FloatNode(image, 0.0, e57.E57_DOUBLE)

        image.extensionsAdd(prefix, SURFACE_NORMALS)
        for columns, rotation, translation in scans:
            pose = structure(
                {"rotation": numbers("wxyz", rotation), "translation": numbers("xyz", translation)}
            )
            rows = structure({name: like(name) for name in columns})
            points = e57.CompressedVectorNode(image, rows, e57.VectorNode(image, True))
            file.data3d.append(structure({"pose": pose, "points": points}))
            kept = {name: np.array(values, float) for name, values in columns.items()}
            buffers = e57.VectorSourceDestBuffer()
            for name, values in kept.items():
                buffers.append(e57.SourceDestBuffer(image, name, values, len(values), True, True))
            writer = points.writer(buffers)
            writer.write(len(values))
            writer.close()
    return path


def e57_columns(places, normals, before="nor:normal"):
    found = {f"cartesian{axis}": places[:, k] for k, axis in enumerate("XYZ")}
    names = "XYZ" if before.endswith("normal") else "xyz"
    return {**found, **{f"{before}{axis}": normals[:, k] for k, axis in enumerate(names)}}


QUARTER = (np.sqrt(0.5), 0, 0, np.sqrt(0.5))  # a turn about +Z
NORMALS = RNG.normal(size=(COUNT, 3))
NORMALS /= np.linalg.norm(NORMALS, axis=1, keepdims=True)


@pytest.mark.parametrize(
    ("prefix", "before", "steps"),
    [("nor", "nor:normal", 0), ("nor", "nor:normal", 32767), ("n", "n:normal", 0),
     ("nor", "nor:n", 0)],
)  # fmt: skip
def test_e57_has_normals(tmp_path, prefix, before, steps):
    turns = [(QUARTER, (10.0, 20.0, 30.0)), ((1, 0, 0, 0), (0, 0, 0))]
    scans = [(e57_columns(PLACES, NORMALS, before), *one) for one in turns]
    cloud = load_points(write_e57(tmp_path / "a.e57", scans, prefix, steps))
    about_z = np.stack([-NORMALS[:, 1], NORMALS[:, 0], NORMALS[:, 2]], axis=1)
    # Half a step of the whole numbers, or single precision; a turn mixes two of them.
    off = 0.75 / steps if steps else 1e-6
    assert cloud.normals == pytest.approx(turned(np.concatenate([about_z, NORMALS])), abs=off)


def test_e57_whose_scans_have_not_all_normals(tmp_path):
    plain = {f"cartesian{axis}": PLACES[:, k] for k, axis in enumerate("XYZ")}
    pose = ((1, 0, 0, 0), (0, 0, 0))
    two = [(e57_columns(PLACES, NORMALS), *pose), (plain, *pose)]
    assert load_points(write_e57(tmp_path / "a.e57", two)).normals is None
    half = {
        name: values for name, values in e57_columns(PLACES, NORMALS).items() if "Y" not in name
    }
    half["cartesianY"] = PLACES[:, 1]
    assert load_points(write_e57(tmp_path / "b.e57", [(half, *pose)])).normals is None
