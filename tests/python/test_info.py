"""What ``omma info`` says of scenes and eyes."""

import re

import numpy as np
import pytest
from conftest import make_eye
from PIL import Image

import omma
from omma.job.extents import describe_extent, size_words
from omma.job.info import describe_file, describe_scene
from omma.job.picture_info import describe_picture
from omma.job.places import place_words


def test_info_of_a_scene(omma_command):
    code, out, err = omma_command("info", "scene.gltf")
    assert (code, err) == (0, "")
    for what, words in [
        ("nodes", "3"),
        ("triangles", "2"),
        ("meshes", "1 in 1 instances"),
        ("textures", "0"),
        ("bounds", "(-10, 0, -10) to (10, 0, 10) m"),
        ("background", "simple sky"),
        ("camera", "0 plain: perspective at (0, 1, 0) m"),
        ("camera", "1 insect: compound at (1, 2, 3) m, scale 0.5, eye bug.eye"),
    ]:
        assert re.search(f"^{what} +{re.escape(words)}", out, re.MULTILINE)


def test_info_of_an_eye(omma_command, tmp_path):
    # A row of axes each 3 degrees from -30 to 30 and from straight behind to the right.
    azimuth = np.radians(np.arange(-30, 31, 3))
    axis = np.stack([np.sin(azimuth), 0 * azimuth, -np.cos(azimuth)], axis=1)
    acceptance = np.radians(np.linspace(1, 3, 21))
    omma.save_eye(tmp_path / "row.eye", omma.Eye(axis * 1e-3, axis, acceptance))
    code, out, err = omma_command("info", tmp_path / "row.eye")
    assert (code, err) == (0, "")
    assert re.search(r"^ommatidia +21$", out, re.MULTILINE)
    assert re.search(r"^azimuth +-30\.0° to 30\.0°", out, re.MULTILINE)
    assert re.search(r"^elevation +0\.0° to 0\.0°", out, re.MULTILINE)
    assert not re.search(r"^(acceptance|interommatidial|field) ", out, re.MULTILINE)  # eye info
    assert re.search(r"^more +omma eye info \S*row.eye", out, re.MULTILINE)


def test_info_of_an_eye_with_receptors_and_columns(omma_command, tmp_path):
    eye = omma.receptors.assign_receptors(make_eye(), omma.receptors.honeybee_ommatidia())
    omma.save_eye(tmp_path / "bee.csv", eye.replace(columns={"age_days": np.zeros(60)}))
    code, out, _ = omma_command("info", tmp_path / "bee.csv")
    assert code == 0
    assert re.search(r"^receptors +[\d,]+ of .", out, re.MULTILINE)
    assert re.search(r"^columns +age_days$", out, re.MULTILINE)


def test_azimuth_range_goes_the_short_way_round():
    from omma.job.info import azimuth_range_deg

    assert azimuth_range_deg(np.array([170.0, -170, 180])) == (170, 190)
    assert azimuth_range_deg(np.array([-170.0, -100, 175])) == (-185, -100)
    assert azimuth_range_deg(np.array([])) == (0, 0)


@pytest.mark.parametrize(
    ("azimuth", "says"),
    [
        (np.arange(100, 261, 5), "100.0° to -100.0° through straight behind, right is +"),
        (np.arange(0, 360, 5), "all round"),
        (np.arange(-73, 40, 1), "-73.0° to 39.0°, right is +"),
    ],
)
def test_azimuths_are_told_from_180_to_180(azimuth, says):
    turn = np.radians(azimuth.astype(float))
    axis = np.stack([np.sin(turn), 0 * turn, -np.cos(turn)], axis=1)
    eye = omma.Eye(axis * 1e-3, axis, np.full(len(turn), 0.1))
    from omma.job.info import describe_eye

    assert dict(describe_eye(eye))["azimuth"].startswith(says)


def test_info_of_a_picture(omma_command, tmp_path):
    Image.fromarray(np.full((8, 16, 3), 7, np.uint8)).save(tmp_path / "sky.png")
    code, out, err = omma_command("info", str(tmp_path / "sky.png"))
    assert (code, err) == (0, "")
    for words in ("16 x 8 pixels", "sRGB, 7 to 7 of 255", "of the whole sphere"):
        assert words in out
    pixel = bytes([128, 128, 128, 129])  # (128 + 1/2) / 256 x 2, of an exposure of a half
    (tmp_path / "part.hdr").write_bytes(
        b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=0.5\n\n-Y 2 +X 2\n" + 4 * pixel
    )
    _, out, _ = omma_command("info", str(tmp_path / "part.hdr"))
    for words in ("2 x 2 pixels", "linear, 2.008 to 2.008", "none of the whole sphere"):
        assert words in out
    (tmp_path / "broken.png").write_bytes(b"\x89PNG")
    code, _, err = omma_command("info", str(tmp_path / "broken.png"))
    assert code != 0
    assert "broken.png" in err


def test_info_of_a_picture_of_16_bits(tmp_path):
    """PNG alone has them, in sRGB; Pillow writes greys of them."""
    codes = np.zeros((8, 16), np.uint16)
    codes[0, :3] = 1, 300, 65535
    Image.fromarray(codes).save(tmp_path / "sixteen.png")
    lines = dict(describe_picture(tmp_path / "sixteen.png"))
    assert lines["values"] == "sRGB of 16 bits, 0 to 65,535 of 65,535"
    for low in (1, 300, 2701, 40000):
        Image.fromarray(np.full((8, 16), low, np.uint16)).save(tmp_path / "sixteen.png")
        lines = dict(describe_picture(tmp_path / "sixteen.png"))
        assert lines["values"] == f"sRGB of 16 bits, {low:,} to {low:,} of 65,535"


@pytest.mark.parametrize("name", ["job.toml", "job.py", "thing", "film.mp4"])
def test_info_of_what_is_nothing_known_says_what_is(tmp_path, name):
    for data in (b'[render]\nscene = "a.glb"\n', b"\0\1\xff\xfe"):
        (tmp_path / name).write_bytes(data)
        with pytest.raises(omma.Error, match=r"expected a scene.*\.glb.*an eye.*\.png.*\.npy"):
            describe_file(tmp_path / name)
    # Eyes by any name are read.
    eye = omma.eye.generate_eye(20)
    omma.save_eye(tmp_path / "bug.eye", eye)
    (tmp_path / "bug.eye").rename(tmp_path / name)
    assert dict(describe_file(tmp_path / name))["ommatidia"] == "20"


def test_places_far_from_the_origin_keep_their_centimetres(omma_command, tmp_path):
    """As in UTM, where the fourth digit is a kilometre; near by four digits are enough."""
    (tmp_path / "plot.obj").write_text(
        "v 456789.123 5432100.5 99\nv 456799 5432100 99\nv 456799 5432110 101.25\nf 1 2 3\n"
    )
    _, told, _ = omma_command("info", str(tmp_path / "plot.obj"), "--up", "z")
    assert "(456789.12, 99, -5432110) to (456799, 101.25, -5432100) m" in " ".join(told.split())
    html = omma.load_scene(tmp_path / "plot.obj", up="z")._repr_html_()
    assert "456789.12, 99, -5432110 to 456799, 101.25, -5432100 m" in html
    assert place_words((0.123456, -12.3456, 100.0)) == "(0.1235, -12.35, 100)"


def said(omma_command, path, *options):
    """What `omma info` says of a file, by the first word of its lines."""
    code, out, err = omma_command("info", path, *options)
    assert (code, err) == (0, "")
    return dict(re.split(r"  +", line, maxsplit=1) for line in out.splitlines())


def test_info_of_a_track(omma_command, tmp_path):
    path = tmp_path / "track.csv"
    path.write_text("t_s,x_m,z_m\n0,0,0\n0.5,3,4\n0.75,nan,\n1,3,6\n")
    found = said(omma_command, path)
    assert found["track"] == str(path)
    assert found["positions"] == "3"
    assert found["duration"] == "1 s, from 0 to 1 s, a position each 0.5 s, median (0.5 to 0.5 s)"
    assert found["bounds"] == "(0, 0) to (3, 6) m, x and z"
    assert found["extent"] == "3 x 6 m"
    assert found["way"] == "7 m, 7 m/s in the mean"
    assert found["heading"] == "along the way"
    assert "left out 1 of 4 positions" in found["warning"]
    path.write_text("t_s,x_m,z_m\n1782000000.04,0,0\n1782000000.08,1,0\n1782000000.12,2,0\n")
    assert dict(describe_file(path))["duration"] == (
        "0.08 s, from 1782000000.04 to 1782000000.12 s, a position each 0.04 s, median (0.04 to "
        "0.04 s)"
    )
    path.write_text("t_s,x_m,z_m\n0,0,0\n1e-300,1,0\n")
    assert dict(describe_file(path))["duration"].startswith("1e-300 s, from 0 to 1e-300 s")
    path.write_text("x_m;z_m;heading_deg\n1,5;0;20\n")
    found = said(omma_command, path)
    assert found["duration"] == "not told: no column t_s"
    assert found["heading"] == "told, heading_deg"


def test_info_of_poses(omma_command, tmp_path):
    path = tmp_path / "poses.csv"
    path.write_text("x,y,z,yaw_deg,pitch_deg,roll_deg\n0,1,2,90,0,0\n0,1,5,90,0,0\n")
    found = said(omma_command, path)
    assert found["poses"] == str(path)
    assert found["number"] == "2"
    assert found["bounds"] == "(0, 1, 2) to (0, 1, 5) m"
    assert (found["extent"], found["way"]) == ("0 x 0 x 3 m", "3 m")
    assert found["duration"] == "not told: no column t_s"
    path.write_text("t_s,x,y,z,yaw_deg,pitch_deg,roll_deg\n1,0,1,2,90,0,0\n1.5,0,1,5,90,0,0\n")
    assert dict(describe_file(path))["duration"] == (
        "0.5 s, from 1 to 1.5 s, a pose each 0.5 s, median (0.5 to 0.5 s)"
    )
    # What is wrong in them is told as of poses.
    path.write_text("x,y,z,qx,qy,qz,qw\n0,1,2,0,0,0,0\n")
    code, _, err = omma_command("info", path)
    assert code != 0
    assert "poses.csv, line 2: the quaternion has length 0" in err


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        (
            "wl,white,red\n300,5,3\n500,70,4\n700,72,61\n",
            'per cent, as the values look; unit="as_is"',
        ),
        ("wl,white %,red %\n300,.1,.3\n500,.2,.4\n700,.2,.6\n", "per cent, as the file says"),
        ("300 0.5 0.3\n500 0.7 0.4\n700 0.72 0.6\n", "fractions, as the values look"),
        ("nm\tsun\tsky\n300\t1e14\t1\n500\t2\t3\n700\t2\t3\n", "neither fractions nor per cent"),
    ],
)
def test_info_of_spectra(omma_command, tmp_path, text, unit):
    path = tmp_path / "petals.csv"
    path.write_text(text)
    found = said(omma_command, path)
    assert found["spectra"] == str(path)
    assert found["number"].startswith("2: ")
    assert found["wavelengths"] == "300 to 700 nm, 3 of them, one each 200 nm"
    assert found["unit"].startswith(unit)


def test_info_of_tables_of_something_else(omma_command, tmp_path):
    path = tmp_path / "other.csv"
    path.write_text("a,b\n1,2\n")
    code, _, err = omma_command("info", path)
    assert code != 0
    for words in ("azimuth_deg", "x_m, z_m", "yaw_deg", "wavelengths in nm", "found 'a, b'"):
        assert words in err
    (tmp_path / "track.csv").write_text("x_m,z_m\n1,2\n")
    code, _, err = omma_command("info", tmp_path / "track.csv", "--unit", "mm")
    assert code != 0
    assert "--unit: expected none" in err


def test_sizes_are_told_in_words():
    flat = describe_extent(np.array([50_000.0, 40_000.0, 900.0]))
    assert flat.startswith("5e+04 x 4e+04 x 900 m, as of a region; if it is in millimetres, 50 m")
    said = "it is flat along z, as if +Z were up in the file (--up z; --scene-up z of a render)"
    assert flat.endswith(said)
    plot = describe_extent(np.array([4.0, 0.3, 5.0]))
    assert plot == "4 x 0.3 x 5 m, as of a tree, a room or a plot"
    # What is rounding of the largest length is 0.
    assert size_words(np.array([6, 2e-16, 7e-9])) == "6 x 0 x 7e-09 m"


@pytest.mark.parametrize("name", ["mesh.ply", "points.ply", "points.xyz"])
@pytest.mark.parametrize("flat", ["y", "z"])
@pytest.mark.parametrize("up", [None, "y", "z"])
def test_another_axis_up_is_told_but_not_the_one_that_is_read(
    omma_command, tmp_path, name, flat, up
):
    """Files that are flat along an axis, read with one up: by default +Z of text, +Y of PLY."""
    places = [(x, 0.01, z) if flat == "y" else (x, z, 0.01) for x in range(4) for z in range(4)]
    rows = [" ".join(map(str, one)) for one in places]
    if name.endswith(".ply"):
        head = ["ply", "format ascii 1.0", "element vertex 16"]
        head += [f"property float {axis}" for axis in "xyz"]
        if name == "mesh.ply":
            pytest.importorskip("trimesh")
            head += ["element face 1", "property list uchar int vertex_indices"]
            rows.append("4 0 3 15 12")
        rows = [*head, "end_header", *rows]
    (tmp_path / name).write_text("\n".join(rows) + "\n")
    found = said(omma_command, tmp_path / name, *(["--up", up] if up else []))["extent"]
    read = up or ("z" if name.endswith(".xyz") else "y")
    assert ("it is flat along z" in found) == (read != flat)
    assert (f"(--up {flat};" in found) == (read != flat)


@pytest.mark.parametrize(
    ("name", "size", "hint"),
    [
        # Meshes and points that do not say their unit, and glTF, which should be in metres.
        ("leaf.obj", 40, "if it is in millimetres, 0.04 m, as of an insect or a leaf"),
        ("leaf.obj", 20, ""),
        ("plant.xyz", 400, "if it is in millimetres, 0.4 m, as of a thing on a table"),
        ("plant.xyz", 200, ""),
        ("room.glb", 4000, "if it is in millimetres, 4 m, as of a tree, a room or a plot"),
        ("room.glb", 400, ""),
    ],
)
def test_what_may_be_in_millimetres_is_told(omma_command, tmp_path, name, size, hint):
    path = tmp_path / name
    corners = size * np.array([(0, 0, 0), (1, 0, 0), (1, 1, 1), (0, 1, 1.0)])
    if name.endswith(".obj"):
        lines = [f"v {x} {y} {z}" for x, y, z in corners]
        path.write_text("\n".join([*lines, "f 1 2 3 4"]))
        pytest.importorskip("trimesh")
    elif name.endswith(".xyz"):
        path.write_text("\n".join(f"{x} {y} {z}" for x, y, z in corners))
    else:
        omma.scene.save_scene(path, omma.scene.box((size,) * 3))
    found = said(omma_command, path)["extent"]
    assert hint in found
    assert ("in millimetres" in found) == bool(hint)
    code, out, _ = omma_command("info", path, "--unit", "mm")
    assert code == 0
    assert "in millimetres" not in out


def test_a_picture_plane_does_not_lie_on_its_side(omma_command, tmp_path):
    """Flat along z: cards of a glTF file, in which +Y is up, stand; ground with +Z up lies."""
    card = omma.scene.box((4, 3, 0.01), center_m=(0, 1, -2))
    omma.scene.save_scene(tmp_path / "card.glb", card)
    assert "flat" not in said(omma_command, tmp_path / "card.glb")["extent"]
    ground = omma.scene.box((40, 30, 3))
    omma.scene.save_scene(tmp_path / "ground.glb", ground)
    assert "flat along z" in said(omma_command, tmp_path / "ground.glb")["extent"]
    seen = ground.replace(
        cameras=[omma.scene.Camera("eye", world_from_camera=omma.look_at((0, 1, 9), (0, 1, 0)))]
    )
    omma.scene.save_scene(tmp_path / "seen.glb", seen)
    assert "flat" not in said(omma_command, tmp_path / "seen.glb")["extent"]


def cloud_of(positions, scale):
    count = len(positions)
    return omma.scene.SplatCloud(
        positions,
        np.full((count, 3), scale),
        np.tile([1.0, 0, 0, 0], (count, 1)),
        np.full(count, 0.5),
        np.zeros((count, 1, 3)),
    )


@pytest.mark.parametrize(
    ("far", "scale", "extent"),
    [
        (0.0, 0.5, "0 x 0 x 0 m, of splats their middles"),
        (1.0, 0.5, "1 x 0 x 0 m, of splats their middles"),
        (5.0, 0.5, "5 x 0 x 0 m, as of a tree, a room or a plot, of splats their middles"),
    ],
)
def test_the_extent_of_splats_is_that_of_their_middles(far, scale, extent):
    scene = omma.Scene(splats=[cloud_of([[0, 0, 0], [far, 0, 0]], scale)])
    lines = dict(describe_scene(scene))
    assert lines["extent"] == extent
    assert lines["bounds"].endswith("m, of splats their middles")
    assert "middles" not in dict(describe_scene(omma.scene.box()))["bounds"]
