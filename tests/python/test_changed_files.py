"""Whatever is wrong with a file that omma reads, it is omma.Error that says so; nothing in a file
is run as code."""

import ast
import json
import os
import pickle
import sys
import warnings
from importlib.metadata import version
from pathlib import Path

import changed_files
import numpy as np
import pytest
from conftest import make_eye, write_gltf

import omma
from omma.job.results_info import describe_responses
from omma.rendering.read_back import load_responses

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parents[2]
CHANGES = 40


@pytest.mark.parametrize("name", changed_files.ALL)
def test_a_changed_file_is_read_or_refused(name, tmp_path):
    kind = changed_files.ALL[name]
    for package in kind.needs:
        pytest.importorskip(package)
    made = kind.make(tmp_path)
    data = (made.parent / kind.changed if kind.changed else made).read_bytes()
    kind.read(made)
    changed = [*changed_files.changes(data, 1, CHANGES)]
    if data.startswith((b"{", b"[")):
        changed += changed_files.changed_values(data.decode(), 2, CHANGES)
    found = [(one, changed_files.foreign(kind, made, one)) for one in [b"", *changed]]
    assert [(repr(error), one[:2000]) for one, error in found if error is not None] == []


def test_a_bit_that_changed_in_responses_of_zarr_is_told(tmp_path):
    """It was read as other numbers. Some bits of a header mean nothing for what is read."""
    pytest.importorskip("xarray")
    pytest.importorskip("zarr")
    kind = changed_files.ALL["zarr chunk"]
    made = kind.make(tmp_path)
    assert kind.changed is not None
    chunk = made.parent / kind.changed
    data, expected = chunk.read_bytes(), load_responses(made).response.values
    told = 0
    for place in range(0, len(data), max(1, len(data) // 12)):
        changed = bytearray(data)
        changed[place] ^= 4
        chunk.write_bytes(changed)
        try:
            np.testing.assert_array_equal(load_responses(made).response.values, expected)
        except RuntimeError:  # of zarr, as numbers are read when they are used
            told += 1
    assert told >= 10


def test_errors_name_file_and_place(files, tmp_path):
    pytest.importorskip("xarray")
    made = changed_files.ALL["npy"].make(tmp_path)
    made.with_suffix(".json").write_text("{")
    with pytest.raises(omma.Error, match=r"seen\.json: expected the JSON that omma writes"):
        load_responses(made)
    made.write_bytes(made.read_bytes()[:40])
    with pytest.raises(omma.Error, match=r"alone\.npy: cannot be read as \.npy: "):
        describe_responses(made.rename(tmp_path / "alone.npy"))


def test_a_heap_without_end_is_refused(tmp_path):
    """HDF5 reads free space of size 0 for ever."""
    for package in ("xarray", "h5netcdf", "h5py"):
        pytest.importorskip(package)
    made = changed_files.ALL["nc"].make(tmp_path)
    data = bytearray(made.read_bytes())
    heap = at = data.index(b"GCOL")
    end = heap + int.from_bytes(data[heap + 8 : heap + 16], "little")
    at += 16
    while at + 16 <= end and data[at : at + 2] != b"\0\0":
        at += 16 + (int.from_bytes(data[at + 8 : at + 16], "little") + 7) // 8 * 8
    assert at + 16 <= end
    data[at + 8 : at + 16] = bytes(8)
    made.write_bytes(data)
    with pytest.raises(omma.Error, match=rf"seen\.nc: .* heap of texts is damaged at byte {at}"):
        load_responses(made)
    data[heap + 24 : heap + 32] = b"\xff" * 8  # of the first object
    made.write_bytes(data)
    with pytest.raises(
        omma.Error, match=rf"seen\.nc: .* heap of texts is damaged at byte {heap + 16}"
    ):
        load_responses(made)


class Code:
    """Makes a file where it is unpickled."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return os.mkdir, (str(self.path),)


def test_an_array_of_objects_is_refused(tmp_path):
    ran = tmp_path / "ran"
    np.save(tmp_path / "objects.npy", np.array([Code(ran)], object), allow_pickle=True)
    with pytest.raises(omma.Error, match=r"objects\.npy: cannot be read as \.npy: "):
        describe_responses(tmp_path / "objects.npy")
    (tmp_path / "pickle.npy").write_bytes(pickle.dumps(Code(ran)))
    with pytest.raises(omma.Error, match=r"pickle\.npy: cannot be read as \.npy: "):
        describe_responses(tmp_path / "pickle.npy")
    assert not ran.exists()


@pytest.mark.parametrize("first", [[], [{"id": "vlen-utf8"}]])
def test_a_store_of_pickles_is_refused(first, tmp_path):
    zarr = pytest.importorskip("zarr")
    pytest.importorskip("xarray")
    ran = tmp_path / "ran"
    store = tmp_path / "objects.zarr"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        group = zarr.open_group(store, mode="w", zarr_format=2)
        group.create_array("response", shape=(1,), chunks=(1,), dtype="i1").attrs[
            "_ARRAY_DIMENSIONS"
        ] = ["pose"]
    about = store / "response" / ".zarray"
    said = json.loads(about.read_text())
    said |= {
        "dtype": "|O",
        "filters": [*first, {"id": "pickle"}],
        "compressor": None,
        "fill_value": None,
    }
    about.write_text(json.dumps(said))
    (store / "response" / "0").write_bytes(pickle.dumps(Code(ran)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with pytest.raises(omma.Error, match=r"objects\.zarr: cannot be read as "):
            describe_responses(store)
    assert not ran.exists()


def test_versions_that_refuse_pickles_are_asked_for():
    """numcodecs 0.16.6 refuses to decode pickles (GHSA-jqc8-qjfv-5m6r), as 0.15.2 and 0.17.1 do."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    for extra in ("data", "datasets", "dev"):
        asked = [one for one in extras[extra] if one.startswith("numcodecs")]
        assert asked == ["numcodecs>=0.16.6,!=0.17.0"], extra
    numbers = tuple(map(int, version("numcodecs").split(".")[:3]))
    assert numbers >= (0, 16, 6)
    assert numbers != (0, 17, 0)


def test_tables_of_commands_escape_what_files_say(tmp_path, run_omma):
    name = "\x1b[31mred\x07\u202e"
    scene = write_gltf(tmp_path / "scene.gltf", cameras=[(name, None, {})])
    code, out, err = run_omma("info", scene)
    assert (code, err) == (0, "")
    assert "\\x1b[31mred\\x07" in out
    eye = make_eye(8).replace(columns={"\x1b[31m": np.arange(8.0)})
    omma.save_eye(tmp_path / "bug.csv", eye)
    outputs = [
        run_omma("info", tmp_path / "bug.csv"),
        run_omma("eye", "info", tmp_path / "bug.csv"),
    ]
    picture = ("-o", tmp_path / "seen.png", "--width", "8", "--height", "8")
    outputs.append(run_omma("render", scene, "--camera", "0", *picture))
    outputs.append(run_omma("render-cameras", scene, "-o", tmp_path / "all", *picture[2:]))
    for _, out, err in outputs:
        assert not any(ord(one) < 32 for one in (out + err).replace("\n", "")), out


def test_commands_print_by_what_escapes():
    """`say` and `readable` of cli/working.py: no command prints a line by itself."""
    for path in sorted((ROOT / "python" / "omma" / "cli").glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if not isinstance(node, ast.Call) or path.name == "working.py":
                continue
            if isinstance(node.func, ast.Name) and node.func.id == "print":
                to_stderr = any(one.arg == "file" for one in node.keywords)
                plain = all(isinstance(one, ast.Constant) for one in node.args)
                constant = path.name in ("main.py", "view.py")
                assert to_stderr or plain or constant, f"{path.name}, line {node.lineno}"


def test_notebooks_show_files_without_their_folders(files, scene, eye):
    world = omma.World(scene)
    renderer = omma.Renderer(world, eye, omma.Fixed(2))
    shown = [scene, eye, world, renderer, omma.Population(world, [eye, eye])]
    for one in [*shown, renderer.ground_truth(np.eye(4))]:
        assert str(files) not in one._repr_html_()
        assert str(files) not in repr(one)
    assert "scene.gltf" in repr(world)
    assert "scene.gltf" in scene._repr_html_()
    assert "scene.gltf" in world._repr_html_()
