"""Lines of OBJ files that are no numbers, or numbers written in unusual ways."""

import pytest

import omma


@pytest.mark.parametrize(
    "vertex",
    [
        "nan 0 0",
        "inf 0 0",
        "-nan(ind) 0 0",
        "a b c",
        "1x 0 0",
        "1,5 0,25 0",
        "1 0",
        "1 2 3e",
        "0x1 1 1",
    ],
)
def test_an_obj_vertex_that_is_no_number_is_told(tmp_path, vertex):
    """tinyobjloader takes it for 0, or cuts it off where it no longer is one."""
    path = tmp_path / "a.obj"
    path.write_text(f"# made\nv 0 0 0\nv {vertex}\nv 1 1 0\nf 1 2 3\n")
    with pytest.raises(omma.Error, match=r"a\.obj: line 3: expected v and three finite numbers"):
        omma.load_scene(path)


def test_numbers_as_obj_files_write_them(tmp_path):
    path = tmp_path / "a.obj"
    path.write_text("v 1e1 -.5 2. # x\r\n v\t+1 2  3 .1 .2 .3 \r\nv 1 1 0 1\nvn nan 0 0\nf 1 2 3\n")
    with pytest.warns(UserWarning, match="1 normals are no numbers; normals of OBJ files do not"):
        found = omma.load_scene(path).meshes[0].positions_m
    assert found.tolist() == [[10, -0.5, 2], [1, 2, 3], [1, 1, 0]]
    path.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 nan\nvt 1 0\nf 1/1 2/2 3/1\n")
    with pytest.warns(UserWarning, match="1 texture coordinates are no numbers"):
        omma.load_scene(path)


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        ("f 1 2 x", "line 5: expected f and corners as 1, 1/2, .*found 'f 1 2 x'"),
        ("f 1/x 2 3", "line 5: expected f and corners"),
        ("f 1 2 0", "line 5: expected f and corners"),
        ("f 1 2 3.5", "line 5: expected f and corners"),
        ("f 1 2 \\\n 3\nf 1 2 x", "line 7: expected f and corners"),
        ("f 1 2 3\nf 1 2 9", "line 6: expected faces of the 3 vertices .*found one of number 9"),
        ("f 3 2 1\nf 1/ 2/7 3", "line 6: expected faces of the 0 texture .*of number 7"),
        ("f 1 2 -9", "line 5: expected a face of vertices that stand before it"),
    ],
)
def test_an_obj_face_that_is_none_is_told(tmp_path, lines, told):
    """With its line, in words that are not those of the library that reads it."""
    path = tmp_path / "a.obj"
    path.write_text(f"# made\nv 0 0 0\nv 1 0 0\nv 1 1 0\n{lines}\n")
    with pytest.raises(omma.Error, match=rf"a\.obj: {told}"):
        omma.load_scene(path)


@pytest.mark.parametrize(
    "face", ["f 1 2 3 # of three", "f -3 -2 -1 #", "f 1 \\\r\n2 \\\n 3", "f\t1//1 2 +3 "]
)
def test_faces_as_obj_files_write_them(tmp_path, face):
    path = tmp_path / "a.obj"
    path.write_text(f"v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\n{face}\n")
    assert omma.load_scene(path).triangle_count == 1


@pytest.mark.parametrize("slashes", [("/", "//", ""), ("/", "/", "/"), ("//", "//", "//")])
def test_slashes_with_nothing_behind_them(tmp_path, slashes):
    """They say that there is no texture coordinate: the library that reads took the number of the
    next corner for it."""
    path = tmp_path / "a.obj"
    corners = " ".join(f"{k + 1}{one}" for k, one in enumerate(slashes))
    for given in ("", "vt .1 .2\nvt .3 .4\nvt .5 .6\n"):
        path.write_text(f"v 0 0 0\nv 1 0 0\nv 1 1 0\n{given}f {corners}")
        scene = omma.load_scene(path)
        assert scene.meshes[0].texture_coordinates is None
        assert scene.meshes[0].triangles.tolist() == [[0, 1, 2]]
