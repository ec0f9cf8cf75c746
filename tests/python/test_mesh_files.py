"""OBJ and PLY files as other programs write them: faces of many corners, materials, far places."""

import itertools
import random
import resource
import struct
import warnings

import numpy as np
import pytest

import omma
from omma.scene import load_scene

pytest.importorskip("tinyobjloader")
pytest.importorskip("mapbox_earcut")

CONCAVE = [(1, 0, 0), (0.2, 0.2, 0), (0, 1, 0), (0, 0, 0)]
# A square of 16 whose outline goes along an edge to a hole of 4, around it and back.
HOLED = [
    (0, 0, 0), (1, 1, 0), (1, 3, 0), (3, 3, 0), (3, 1, 0), (1, 1, 0),
    (0, 0, 0), (4, 0, 0), (4, 4, 0), (0, 4, 0),
]  # fmt: skip
# Two squares that touch in a corner.
TOUCHING = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (2, 1, 0), (2, 2, 0), (1, 2, 0), (1, 1, 0), (0, 1, 0)]
SPIRAL = [
    (0, 0, 0), (5, 0, 0), (5, 5, 0), (1, 5, 0), (1, 2, 0), (3, 2, 0), (3, 3, 0), (2, 3, 0),
    (2, 4, 0), (4, 4, 0), (4, 1, 0), (0, 1, 0),
]  # fmt: skip
TURNS = {
    "flat": np.eye(3),
    "tilted": np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0],
    "backwards": np.diag([-1.0, 1, 1]),
}


def write_obj(path, corners):
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(corners, float).tolist()]
    path.write_text("\n".join([*lines, "f " + " ".join(map(str, range(1, len(corners) + 1)))]))


def write_ply(path, corners, kind):
    header = (
        f"ply\nformat {kind} 1.0\nelement vertex {len(corners)}\nproperty double x\n"
        "property double y\nproperty double z\nelement face 2\n"
        "property list uchar int vertex_indices\nproperty uchar flags\nend_header\n"
    )
    faces = [range(len(corners)), (0, 0, 0)]  # of two lengths: triangles and polygons
    if kind == "ascii":
        text = [" ".join(repr(float(x)) for x in corner) for corner in corners]
        text += [" ".join(map(str, (len(face), *face, 7))) for face in faces]
        path.write_text(header + "\n".join(text))
        return
    order = "<" if "little" in kind else ">"
    data = np.asarray(corners, order + "f8").tobytes()
    for face in faces:
        data += struct.pack(f"{order}B{len(face)}iB", len(face), *face, 7)
    path.write_bytes(header.encode() + data)


def area_of(scene):
    total = np.zeros(3)
    size = 0.0
    for mesh in scene.meshes:
        p = mesh.positions_m.astype(float)[mesh.triangles]
        across = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]) / 2
        total += across.sum(axis=0)
        size += np.linalg.norm(across, axis=1).sum()
    return size, total


@pytest.mark.parametrize("kind", ["obj", "ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize(
    ("outline", "area"), [(CONCAVE, 0.2), (HOLED, 12), (TOUCHING, 2), (SPIRAL, 15)]
)
def test_faces_of_any_outline_are_filled_within_it(tmp_path, outline, area, turn, kind):
    """From any corner on: fans of concave faces are wrong for some only."""
    for first in range(len(outline)):
        corners = np.roll(outline, first, axis=0) @ TURNS[turn].T
        path = tmp_path / ("face.obj" if kind == "obj" else "face.ply")
        write_obj(path, corners) if kind == "obj" else write_ply(path, corners, kind)
        size, total = area_of(load_scene(path))
        assert size == pytest.approx(area, rel=1e-6)
        # None of it overlaps, and all of it is seen from the side that the outline says.
        normal = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0) / 2
        assert total == pytest.approx(normal, abs=1e-5)


def test_the_notch_is_empty(tmp_path):
    for name in ("concave.obj", "concave.ply"):
        path = tmp_path / name
        write_obj(path, CONCAVE) if name.endswith("obj") else write_ply(path, CONCAVE, "ascii")
        poses = np.tile(np.eye(4), (3, 1, 1))
        poses[:, :3, 3] = (0.35, 0.35, 1), (0.1, 0.1, 1), (0.1, 0.6, 1)
        eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], [0.0])
        seen = omma.Renderer(load_scene(path), eye, omma.Fixed(1)).render(poses)
        assert seen[:, 0, 0].tolist() == [0, 1, 1]


def test_faces_that_cross_themselves_are_told(tmp_path):
    star = [(np.cos(a), np.sin(a), 0) for a in np.arange(5) * 4 * np.pi / 5]
    for outline in (star, [(0, 0, 0), (1, 1, 0), (1, 0, 0), (0, 1, 0)]):
        write_obj(tmp_path / "star.obj", [*outline, (0, 0, 5), (1, 0, 5), (0, 1, 5)])
        text = (tmp_path / "star.obj").read_text().rsplit("f ", 1)[0]
        n = len(outline)
        faces = f"f {' '.join(map(str, range(1, n + 1)))}\nf {n + 1} {n + 2} {n + 3}\n"
        (tmp_path / "star.obj").write_text(text + faces)
        with pytest.warns(UserWarning, match="1 of 2 faces cross themselves"):
            load_scene(tmp_path / "star.obj")


def test_a_surface_for_an_eye_is_cut_alike(tmp_path):
    write_obj(tmp_path / "face.obj", SPIRAL)
    mesh = omma.eye.surfaces.load_surface(tmp_path / "face.obj", unit="m")
    p = mesh.vertices[mesh.triangles]
    across = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    assert np.linalg.norm(across, axis=1).sum() / 2 == pytest.approx(15)


@pytest.fixture
def pictures(tmp_path):
    """A card of which the upper half is a leaf: its colours, its opacity, both in one."""
    pillow = pytest.importorskip("PIL.Image")
    card = np.zeros((8, 8, 4), np.uint8)
    card[..., 1] = 255
    card[:4, :, 3] = 255
    pillow.fromarray(card).save(tmp_path / "card.png")
    pillow.fromarray(card[..., 3]).save(tmp_path / "card alpha.png")
    pillow.fromarray(card[..., :3]).save(tmp_path / "card_rgb.png")
    pillow.fromarray(card[..., :3]).save(tmp_path / "card_rgb.bmp")
    pillow.fromarray((card[..., 3] // 2).astype(np.uint8)).save(tmp_path / "half.png")
    halves = np.zeros((8, 8, 3), np.uint8)
    halves[:, :4, 0] = halves[:4, :, 2] = 255  # left red, upper blue
    pillow.fromarray(halves).save(tmp_path / "halves.png")
    return tmp_path


def seen(folder, material, places, obj_lines=""):
    """What rays meet at these places of a square of 2 m, before magenta; warnings."""
    (folder / "t.mtl").write_text("newmtl a\n" + material)
    (folder / "t.obj").write_text(
        "mtllib t.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
        f"{obj_lines}usemtl a\nf 1/1 2/2 3/3 4/4\n"
    )
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        scene = load_scene(folder / "t.obj")
    scene = scene.replace(background=omma.Background.constant((1, 0, 1)))
    poses = np.tile(np.eye(4), (len(places), 1, 1))
    poses[:, :3, 3] = [(x, y, 1) for x, y in places]
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], [0.0])
    found = omma.Renderer(scene, eye, omma.Fixed(1)).render(poses)[:, 0]
    return found.round(3).tolist(), [str(one.message) for one in told]


HIGH, LOW = (0.1, 0.5), (0.1, -0.5)


@pytest.mark.parametrize(
    ("material", "high", "low"),
    [
        ("Kd 0 1 0\nd 0.5\n", [0.5, 0.5, 0.5], [0.5, 0.5, 0.5]),
        ("Kd 0 1 0\nTr 0.5\n", [0.5, 0.5, 0.5], [0.5, 0.5, 0.5]),
        ("Kd 0 1 0\nd -halo 0.5\n", [0.5, 0.5, 0.5], [0.5, 0.5, 0.5]),
        # Some write Tr as if it were d, beside it.
        ("Kd 0 1 0\nd 1\nTr 1\n", [0, 1, 0], [0, 1, 0]),
        ("Kd 1 1 1\nmap_Kd card_rgb.png\nmap_d card alpha.png\n", [0, 1, 0], [1, 0, 1]),
        ("Kd 1 1 1\nmap_Kd card.png\nmap_d card.png\n", [0, 1, 0], [1, 0, 1]),
        ("Kd 0 1 0\nmap_d card alpha.png\n", [0, 1, 0], [1, 0, 1]),
        ("Kd 0 1 0\nmap_d half.png\n", [0.502, 0.498, 0.502], [1, 0, 1]),
        ("Kd 0 0 0\nKe 0.5 0 0\n", [0.5, 0, 0], [0.5, 0, 0]),
        ("Kd 0 0 0\nKe 1 1 1\nmap_Ke card_rgb.png\n", [0, 1, 0], [0, 1, 0]),
        ("Kd 1 1 1\nmap_Kd -s 2 2 1 card_rgb.png\n", [0, 1, 0], [0, 1, 0]),
        ("Kd 1 1 1\nmap_Kd .\\card_rgb.png\n", [0, 1, 0], [0, 1, 0]),
        ("Kd 1 1 1\n  map_Kd\tcard_rgb.bmp\n", [0, 1, 0], [0, 1, 0]),
        ("Kd 0.2\n", [0.2, 0.2, 0.2], [0.2, 0.2, 0.2]),
    ],
)
def test_what_materials_say_is_seen(pictures, material, high, low):
    found, told = seen(pictures, material, [HIGH, LOW])
    assert np.array(found) == pytest.approx(np.array([high, low]), abs=1e-3)
    assert told == []


def test_pictures_are_laid_as_their_options_say(pictures):
    """At u v, OBJ's picture is read at u v times -s, plus -o; v upwards."""
    places = list(itertools.product((-0.85, -0.35, 0.25, 0.65), repeat=2))
    for options, (scale, offset) in {
        "": ((1, 1), (0, 0)),
        "-s 2 1 1": ((2, 1), (0, 0)),
        "-s 1 2": ((1, 2), (0, 0)),
        "-o 0.5 0.25 0": ((1, 1), (0.5, 0.25)),
        "-clamp off -s 3 2 1 -o 0.1 0.3": ((3, 2), (0.1, 0.3)),
    }.items():
        found, told = seen(pictures, f"Kd 1 1 1\nmap_Kd {options} halves.png\n", places)
        assert told == []
        for (x, y), color in zip(places, found):
            u, v = ((c + 1) / 2 * s + o for c, s, o in zip((x, y), scale, offset))
            # Half a pixel of eight beside an edge, colours mix.
            if min(abs((2 * c + 0.5) % 1 - 0.5) for c in (u, v)) > 1 / 8:
                assert color == [float(u % 1 < 0.5), 0, float(v % 1 > 0.5)], (options, x, y)


@pytest.mark.parametrize(
    ("material", "words"),
    [
        ("Kd 0.2 0.2 0.2\nmap_Kd nowhere.png\n", "nowhere.png is missing"),
        ("Kd 1 1 1\nmap_Kd card.png\n", "card.png has transparent parts, which no map_d asks"),
        ("Kd 1 1 1\nmap_Bump card.png\n", "map_bump is not read"),
        ("Kd 1 1 1\nmap_Kd -mm 0 0.5 card_rgb.png\n", "map_kd -mm is not read"),
        ("Kd 1 1 1\nTf 0.5 1 1\n", "Tf is not read"),
        ("Kd 1 1 1\nd 0\n", 'material "a" is wholly transparent'),
        ("Kd 1 x 1\n", '"Kd 1 x 1" holds no numbers'),
        ("Kd spectral file.rfl\n", "Kd spectral is not read"),
        ("Kd 1 1 1\nmap_Kd t.obj\n", "a picture is passed over: "),
    ],
)
def test_what_is_passed_over_is_told(pictures, material, words):
    _, told = seen(pictures, material, [HIGH])
    assert len(told) == 1
    assert words in told[0]


def test_missing_materials_are_told(pictures):
    (pictures / "n.obj").write_text(
        "mtllib nowhere.mtl\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nusemtl a\nf 1 2 3\n"
    )
    with pytest.warns(UserWarning, match=r"nowhere\.mtl is missing") as told:
        load_scene(pictures / "n.obj")
    assert len(told) == 1
    (pictures / "t.mtl").write_text("newmtl other\n")
    (pictures / "n.obj").write_text(
        "mtllib t.mtl\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nusemtl a\nf 1 2 3\nl 1 2\n"
    )
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        load_scene(pictures / "n.obj")
    assert any('material "a" is in no .mtl file' in str(one.message) for one in told)
    assert any("points and lines are not shown" in str(one.message) for one in told)


def test_lines_and_names_as_other_programs_write_them(tmp_path):
    """Names with spaces, several libraries, lines that go on, indices from the end."""
    (tmp_path / "a b.mtl").write_text("newmtl light green\nKd 0 1 0\n")
    (tmp_path / "c.mtl").write_bytes("newmtl grün\nKd 0 0.5 0\n".encode())
    text = (
        "mtllib a b.mtl\r\nmtllib c.mtl\r\nv 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nv 0 1 0\r\n"
        "usemtl light green\r\nf -4 \\\r\n -3 -2\r\nusemtl grün\r\nf 1//1 3//1 4//1\r\n"
    )
    (tmp_path / "names.obj").write_bytes(text.replace("//1", "").encode())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene = load_scene(tmp_path / "names.obj")
    assert [one.name for one in scene.materials] == ["light green", "grün"]
    assert [one.base_color[1] for one in scene.materials] == [1, 0.5]
    assert scene.triangle_count == 2


def test_colours_of_vertices_are_read(tmp_path):
    (tmp_path / "c.obj").write_text("v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 0.5 0.5 0.5\nf 1 2 3\n")
    colors = load_scene(tmp_path / "c.obj").meshes[0].colors
    assert colors[0].tolist() == [1, 0, 0, 1]
    assert colors[2, 0] == pytest.approx(0.214, abs=1e-3)  # sRGB
    for kind, values, unit in (("uchar", "255 0 0", 1), ("float", "1 0 0", 1)):
        (tmp_path / "c.ply").write_text(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
            "property float z\nelement face 1\nproperty list uchar int vertex_index\n"
            f"property {kind} red\nproperty {kind} green\nproperty {kind} blue\nend_header\n"
            f"0 0 0\n1 0 0\n0 1 0\n3 0 1 2 {values}\n"
        )
        assert load_scene(tmp_path / "c.ply").meshes[0].colors.tolist() == [[unit, 0, 0, 1]] * 3


@pytest.mark.parametrize("name", ["far.obj", "far.ply", "far-binary.ply", "far.stl"])
@pytest.mark.parametrize("offset", [(431234.567, 5412345.678, 250.0), (4e6, 1e6, -4.8e6)])
def test_far_from_the_origin_centimetres_are_kept(tmp_path, name, offset):
    """A ball of 5 cm in UTM and in coordinates of the earth."""
    trimesh = pytest.importorskip("trimesh")
    ball = trimesh.creation.icosphere(3, 0.05)
    path, v = tmp_path / name, ball.vertices + offset
    corners = [f"{x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in v.tolist()]
    faces = ball.faces.tolist()
    if name == "far.obj":
        lines = [f"v {corner}" for corner in corners]
        path.write_text("".join(lines + [f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces]))
    elif name == "far.stl":
        lines = ["solid far\n"]
        for face in faces:
            outline = "".join(f"vertex {corners[i]}" for i in face)
            lines.append(f"facet normal 0 0 0\nouter loop\n{outline}endloop\nendfacet\n")
        path.write_text("".join([*lines, "endsolid far\n"]))
    else:
        kind = "ascii" if name == "far.ply" else "binary_little_endian"
        header = (
            f"ply\nformat {kind} 1.0\nelement vertex {len(v)}\nproperty double x\n"
            f"property double y\nproperty double z\nelement face {len(faces)}\n"
            "property list uchar int vertex_indices\nend_header\n"
        )
        if kind == "ascii":
            lines = [f"3 {a} {b} {c}\n" for a, b, c in faces]
            path.write_text("".join([header, *corners, *lines]))
        else:
            data = v.astype("<f8").tobytes() + b"".join(struct.pack("<B3i", 3, *f) for f in faces)
            path.write_bytes(header.encode() + data)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene = load_scene(path)
    instance, mesh = scene.instances[0], scene.meshes[0]
    placed = mesh.positions_m.astype(float) @ instance.world_from_mesh[:3, :3].T
    placed += instance.world_from_mesh[:3, 3]
    radius = np.linalg.norm(placed - offset, axis=1)
    # The files have micrometres, a double at 5e6 m has steps of a nanometre.
    assert radius.min() == pytest.approx(0.05, abs=2e-6)
    assert radius.max() == pytest.approx(0.05, abs=2e-6)
    pose = np.eye(4)
    pose[:3, 3] = np.array(offset) + [0.03, 0, 1]
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], [0.0])
    distance = omma.Renderer(scene, eye, omma.Fixed(1)).ground_truth(pose).distance_m
    # Of a chord of the ball's 1,280 triangles.
    assert distance.item() == pytest.approx(0.96, abs=5e-4)
    # In the file's own coordinates, and in a glTF file too.
    omma.scene.save_scene(tmp_path / "far.glb", scene)
    again = load_scene(tmp_path / "far.glb")
    assert again.bounds == pytest.approx(scene.bounds, abs=1e-8)


def test_the_warning_names_who_rounds(tmp_path):
    """A file in single precision has rounded before Omma saw it; arrays are rounded by Omma."""
    offset = (431234.567, 5412345.678, 250.0)
    v = (np.array([(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0)]) + offset).astype("<f4")
    header = (
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n"
        "property float y\nproperty float z\nelement face 1\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    face = struct.pack("<B3i", 3, 0, 1, 2)
    (tmp_path / "far.ply").write_bytes(header.encode() + v.tobytes() + face)
    with pytest.warns(UserWarning, match="single precision, in which the file has them"):
        load_scene(tmp_path / "far.ply")
    mesh = omma.scene.Mesh(np.array(v, float), [[0, 1, 2]])
    (told,) = omma.Scene(meshes=[mesh]).warnings
    assert "single precision, in which meshes are kept" in told


def changed(data, r, tokens):
    made = bytearray(data)
    for _ in range(r.randint(1, 5)):
        at = r.randrange(len(made))
        how = r.randrange(4)
        if how == 0:
            made[at] = r.randrange(256)
        elif how == 1:
            made[at:at] = r.choice(tokens)
        elif how == 2:
            del made[at : at + r.randint(1, 8)]
        else:
            other = r.randrange(len(made))
            made[at:at] = made[other : other + r.randint(1, 30)]
    return bytes(made)


def test_changed_files_end_in_errors_that_name_them(pictures):
    """However they are changed: a scene or omma.Error, in less memory than a gigabyte more."""
    tokens = [
        b"-1", b"0", b"99999999999", b"1e999", b"nan", b"2147483648", b"/", b"\\\n", b"f ", b"v ",
        b"\0", b"usemtl ", b"mtllib ", b" ", b"\n", b"l 1 2\n", b"list uchar ", b"property ",
        b"element ", b"\xff\xff\xff\xff", b"-s ", b"-o 1e38 ", b"map_d ", b"3000000000",
    ]  # fmt: skip
    obj = (
        b"mtllib t.mtl\no thing one\nv 431234.5 5412345.6 250 1 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
        b"vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\nusemtl a\nf 1/1/1 2/2/1 3/3/1 4/1/1\ng b\n"
        b"usemtl b c\nf -4 -3 -2\nusemtl missing\nf 1 2 3 \\\n4\n"
    )
    mtl = (
        b"newmtl a\nKd 0 1 0\nKe 0.5 0 0\nd 0.5\nmap_Kd -s 2 2 1 -o 0.5 0 .\\card_rgb.png\n"
        b"map_d half.png\nmap_Ke halves.png\nnewmtl b c\nKd 0.2 0.2 0.2\nTr 0.25\nTf 1 1 1\n"
    )
    write_ply(pictures / "a.ply", SPIRAL, "ascii")
    write_ply(pictures / "b.ply", SPIRAL, "binary_big_endian")
    plys = [(pictures / name).read_bytes() for name in ("a.ply", "b.ply")]
    png = (pictures / "half.png").read_bytes()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    kinds = {"read": 0, "refused": 0}
    for seed in range(1500):
        r = random.Random(seed)
        path = pictures / ("x.obj" if seed % 2 else "x.ply")
        if seed % 2:
            path.write_bytes(changed(obj, r, tokens) if seed % 3 else obj)
            (pictures / "t.mtl").write_bytes(changed(mtl, r, tokens))
            (pictures / "half.png").write_bytes(changed(png, r, tokens) if seed % 5 else png)
        else:
            path.write_bytes(changed(plys[seed // 2 % 2], r, tokens))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            said = path.name
            try:
                load_scene(path)
                kinds["read"] += 1
            except omma.Error as error:
                said = str(error)
                kinds["refused"] += 1
            assert path.name in said
    assert min(kinds.values()) > 300
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 1 << 20


@pytest.mark.parametrize("kind", ["stl", "stl_ascii"])
def test_stl_files_that_are_cut_off_are_told(tmp_path, kind):
    trimesh = pytest.importorskip("trimesh")
    path = tmp_path / "cut.stl"
    trimesh.creation.icosphere(2).export(path, file_type=kind)
    whole = path.read_bytes()
    if kind == "stl_ascii":
        whole = whole.rstrip() + b" of facets\n"
        path.write_bytes(whole)
    assert omma.load_scene(path).triangle_count == 320
    path.write_bytes(whole[: len(whole) // 2])
    told = {"stl": "expected 320 triangles, as its head says, found 159$", "stl_ascii": "endsolid"}
    with pytest.raises(omma.Error, match=told[kind]):
        omma.load_scene(path)


@pytest.mark.parametrize("kind", ["of vertices", "of corners"])
def test_pictures_of_ply_files_are_seen(tmp_path, kind):
    """A wall ahead with a picture of four colours: its upper left is red."""
    colours = np.float32([[[1, 0, 0], [0, 1, 0]], [[0, 0, 1], [1, 1, 1]]])  # rows from the top
    pixels = np.repeat(np.repeat(colours, 8, 0), 8, 1)
    omma.save_png(tmp_path / "p.png", (pixels * 255).astype(np.uint8))
    corners, at = [(-1, -1), (1, -1), (1, 1), (-1, 1)], [(0, 0), (1, 0), (1, 1), (0, 1)]
    head = ["ply", "format ascii 1.0", "comment TextureFile p.png", "element vertex 4"]
    head += [f"property float {name}" for name in "xyz"]
    if kind == "of vertices":
        head += ["property float s", "property float t"]
    head += ["element face 2", "property list uchar int vertex_indices"]
    if kind == "of corners":
        head += ["property list uchar float texcoord"]
    lines = []
    for (x, y), (s, t) in zip(corners, at, strict=True):
        lines.append(f"{x} {y} -2" + (f" {s} {t}" if kind == "of vertices" else ""))
    for face in ((0, 1, 2), (0, 2, 3)):
        coordinates = " ".join(f"{s} {t}" for s, t in (at[k] for k in face))
        lines.append("3 " + " ".join(map(str, face)))
        lines[-1] += f" 6 {coordinates}" if kind == "of corners" else ""
    path = tmp_path / "wall.ply"
    path.write_text("\n".join([*head, "end_header", *lines, ""]))
    axes = [(x, y, -2) for y in (0.5, -0.5) for x in (-0.5, 0.5)]
    eye = omma.Eye(np.zeros((4, 3)), np.array(axes) / np.linalg.norm(axes, axis=1)[:, None], 0.01)
    seen = omma.Renderer(load_scene(path), eye, omma.Fixed(4)).render(np.eye(4))[0]
    np.testing.assert_allclose(seen, colours.reshape(4, 3), atol=0.01)
