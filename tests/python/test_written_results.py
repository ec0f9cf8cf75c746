"""Responses in files that say what they are: written piece by piece, read back, rendered again."""

import dataclasses
import json
import os
import re
import shutil
import subprocess
import sys
import time
import tracemalloc
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
from conftest import make_eye, write_gltf
from dataset_jobs import AVX2, bytes_of, made_store

import omma
from omma.base import processors
from omma.base.directories import WholeDirectory, abandoned_directories
from omma.base.files import WholeFiles, left_behind
from omma.job import render_like
from omma.job.outputs import writers_of
from omma.job.results_info import describe_responses
from omma.rendering import load_responses
from omma.rendering.labels import labels_of
from omma.rendering.response_files import Piece

xarray = pytest.importorskip("xarray")
for package in ("zarr", "h5netcdf", "h5py", "pyarrow"):
    pytest.importorskip(package)

FOUR_RAYS = omma.Fixed(4)
LABELLED = ("out.zarr", "out.nc", "out.parquet", "out.npy")
POSES = 7


@pytest.fixture
def folder(files, tmp_path, monkeypatch):
    """scene.gltf, bug.eye and path.csv in the current directory."""
    for name in ("scene.gltf", "bug.eye"):
        shutil.copy(files / name, tmp_path)
    lines = [f"{0.1 * i:g},1,0,{3 * i},0,0" for i in range(POSES)]
    (tmp_path / "path.csv").write_text("x,y,z,yaw_deg,pitch_deg,roll_deg\n" + "\n".join(lines))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def render(*outputs, sampling=FOUR_RAYS, **settings):
    given = {"eyes": "bug.eye", "path": "path.csv", "seed": 7} | settings
    return omma.render_file("scene.gltf", outputs, sampling, **given)


def renderer_of(sampling=FOUR_RAYS):
    return omma.Renderer(omma.load_scene("scene.gltf"), omma.load_eye("bug.eye"), sampling, seed=7)


def expect_same(found, expected, but=()):
    """The same numbers of the same kind, with the same labels."""
    assert found.response.dims == expected.response.dims
    assert set(found.data_vars) == set(expected.data_vars)
    assert set(found.coords) == set(expected.coords)
    for name in expected.variables:
        assert np.array_equal(found[name].values, expected[name].values), name
        assert found[name].dtype.kind == expected[name].dtype.kind, name
        assert found[name].attrs == expected[name].attrs, name
    assert found.response.dtype == np.float32
    for key, value in expected.attrs.items():
        if key not in ("created", *but):
            assert found.attrs[key] == value, key


@pytest.mark.parametrize("name", LABELLED)
@pytest.mark.parametrize("sampling", [omma.Fixed(4), omma.ToError(0.05, most=64)])
def test_files_have_what_the_dataset_has(folder, name, sampling):
    render(name, sampling=sampling, standard_error=True)
    to_error = isinstance(sampling, omma.ToError)
    expected = renderer_of(sampling).dataset(
        omma.load_poses("path.csv"), standard_error=not to_error
    )
    found = load_responses(name)
    if to_error and name == "out.npy":  # has no place for rays
        expected = expected.drop_vars("rays")
    expect_same(found, expected)
    assert found.attrs["command"] == (
        f"omma.render_file('scene.gltf', ['{name}'], sampling={sampling!r}, eyes='bug.eye', "
        "path='path.csv', standard_error=True, seed=7)"
    )


@pytest.mark.parametrize("name", LABELLED)
def test_receptors(folder, name):
    types = [
        omma.receptors.ReceptorType("green", peak_wavelength_nm=544),
        omma.receptors.ReceptorType("aside", peak_wavelength_nm=436, right_rad=0.1),
    ]
    kind = omma.receptors.OmmatidiumType("both", tuple(types))
    eye = omma.receptors.assign_receptors(make_eye(20), kind)
    omma.save_eye("bee.csv", eye)
    given = {"receptors": True, "standard_error": True, "ultraviolet": (0, 0, 1)}
    render(name, eyes="bee.csv", **given)
    renderer = omma.Renderer(
        omma.load_scene("scene.gltf"), omma.load_eye("bee.csv"), omma.Fixed(4), seed=7
    )
    expect_same(load_responses(name), renderer.dataset(omma.load_poses("path.csv"), **given))
    render_like(name, "again.npy")
    again = load_responses("again.npy")
    assert np.array_equal(again.response, load_responses(name).response)


def test_csv_is_read_without_a_story(folder):
    render("out.csv", "out.npy", standard_error=True)
    found, expected = load_responses("out.csv"), load_responses("out.npy")
    assert np.array_equal(found.response, expected.response)
    assert np.array_equal(found.standard_error, expected.standard_error)
    assert np.allclose(found.azimuth, expected.azimuth, atol=1e-3)  # six digits
    assert found.attrs == {}
    with pytest.raises(omma.Error, match="does not say how it was made"):
        render_like("out.csv", "again.npy")


@pytest.mark.parametrize("name", LABELLED)
@pytest.mark.parametrize("sizes", [(1, 6), (3, 3, 1), (7,)])
def test_pieces_of_any_size_make_one_file(folder, name, sizes):
    renderer = renderer_of()
    poses = omma.load_poses("path.csv")
    responses = renderer.render(poses)
    labels = labels_of(renderer, poses)
    with WholeFiles() as files, ExitStack() as closed:
        writers, _ = writers_of(
            files, closed, [name], labels, renderer.eye,
            receptors=False, standard_error=False, make_paint=None,
        )  # fmt: skip
        first = 0
        for size in sizes:
            for writer in writers:
                writer.write(Piece(first, responses[first : first + size]))
            first += size
    assert np.array_equal(load_responses(name).response, responses)


@pytest.mark.parametrize("name", LABELLED)
def test_memory_does_not_grow_with_poses(folder, name):
    eye = make_eye(2000)
    renderer = omma.Renderer(omma.Scene(), eye, omma.Fixed(1))

    def peak(poses):
        matrices = np.tile(np.eye(4), (poses, 1, 1))
        piece = np.zeros((20, len(eye), 3), np.float32)
        labels = labels_of(renderer, matrices)
        tracemalloc.start()
        with WholeFiles() as files, ExitStack() as closed:
            writers, _ = writers_of(
                files, closed, [name], labels, eye,
                receptors=False, standard_error=False, make_paint=None,
            )  # fmt: skip
            for first in range(0, poses, len(piece)):
                writers[0].write(Piece(first, piece))
        found = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return found

    peak(20)  # what is imported and cached the first time
    few, many = peak(400), peak(1600)  # both are more than a chunk of .zarr and .nc
    responses = 1200 * len(eye) * 3 * 4
    # Poses themselves are in memory, as texts of some 400 bytes at most; those of 1200 are less
    # than a tenth of the 29 MB that their responses are.
    assert many - few < responses / 10


@pytest.mark.parametrize("resume", [False, True])
def test_of_what_is_written_last_no_share_is_told(folder, resume):
    """The last piece is written and files are made whole: how far that is nobody knows."""
    told = []
    render("out.npy", resume=resume, progress=lambda *one: told.append(one))
    assert told[-1] == ("Writing", None)


@pytest.mark.parametrize("name", LABELLED)
def test_what_is_cut_off_leaves_nothing(folder, name):
    render(name)
    before = load_responses(name).load()
    before.close()
    listing = sorted(os.listdir())

    class CutOffError(Exception):
        pass

    def progress(stage, fraction):
        if stage == "Writing":
            raise CutOffError

    with pytest.raises(CutOffError):
        render(name, seed=8, progress=progress)
    assert sorted(os.listdir()) == listing
    expect_same(load_responses(name), before)


def test_a_killed_run_leaves_what_the_next_one_names(folder, run_omma):
    command = [
        *(sys.executable, "-m", "omma", "render", "scene.gltf", "--eye", "bug.eye"),
        *("--path", "path.csv", "--samples", "1000000", "-o", "out.zarr"),
    ]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    try:
        # The store's own file: by then all is open, and locked.
        while not list(folder.glob(".out.zarr.*.partial/zarr.json")):
            assert process.poll() is None, process.stderr.read()
            time.sleep(0.01)
        assert abandoned_directories("out.zarr") == []
    finally:
        process.kill()
        process.communicate()
    assert not (folder / "out.zarr").exists()
    (left,) = folder.glob(".out.zarr.*.partial")
    report = render("out.zarr")
    (warning,) = [text for text in report.warnings if "killed" in text]
    assert str(left) in warning
    assert "rm -r " in warning
    shutil.rmtree(left)
    assert left_behind([], ["out.zarr"]) == []


def test_a_directory_that_is_no_store_is_not_replaced(folder):
    (folder / "out.zarr").mkdir()
    (folder / "out.zarr" / "thesis.tex").write_text("years")
    with pytest.raises(omma.Error, match=r"out.zarr: cannot be written: .* no zarr.json"):
        render("out.zarr")
    assert (folder / "out.zarr" / "thesis.tex").read_text() == "years"


@pytest.mark.parametrize("write", ["render_file", "render_like"])
def test_a_data_set_is_not_replaced(folder, write):
    """A store of many views, hours of work: also by a render that began before it was there."""
    _, store = made_store(folder / "job")
    before = bytes_of(store)
    render("out.npy")
    with pytest.raises(omma.Error, match=r"is a data set of omma dataset run; remove it first"):
        render(store) if write == "render_file" else render_like("out.npy", store)
    assert bytes_of(store) == before
    kept = store.rename(folder / "kept.zarr")

    def meanwhile(stage, share):
        if stage == "Rendering" and kept.exists():
            kept.rename(store)

    with pytest.raises(omma.Error, match="is a data set of omma dataset run"):
        render(store, progress=meanwhile)
    assert bytes_of(store) == before
    shutil.rmtree(store)
    render(store)
    render(store)
    assert load_responses(store).sizes["pose"] == POSES


def test_a_store_of_something_else_is_not_replaced(folder):
    xarray.Dataset({"height": ("x", [1.0, 2.0])}).to_zarr("out.zarr", zarr_format=3)
    with pytest.raises(omma.Error, match="is a Zarr store of something else than responses"):
        render("out.zarr")
    assert xarray.open_zarr("out.zarr").height.sum() == 3
    shutil.rmtree("out.zarr")
    # What the package made in memory is responses too.
    renderer_of().dataset(np.eye(4)).to_zarr("out.zarr", zarr_format=3)
    render("out.zarr")
    assert load_responses("out.zarr").sizes["pose"] == POSES


def test_a_link_stays(folder):
    (folder / "far").mkdir()
    (folder / "out.zarr").symlink_to(folder / "far" / "real.zarr")
    for seed in (1, 2):
        render("out.zarr", seed=seed)
        assert (folder / "out.zarr").is_symlink()
        assert load_responses("far/real.zarr").attrs["seed"] == seed
    assert os.listdir("far") == ["real.zarr"]


def test_directories_are_named_when_they_are_whole(tmp_path):
    directory = WholeDirectory(str(tmp_path / "a"), "mark")
    assert os.listdir(tmp_path) == [os.path.basename(directory.temporary)]
    (tmp_path / directory.temporary / "mark").write_text("x")
    directory.sync()
    directory.finish()
    directory.discard()
    assert os.listdir(tmp_path) == ["a"]


@pytest.mark.parametrize("name", LABELLED)
@pytest.mark.parametrize(
    ("sampling", "settings"),
    [
        (omma.Fixed(3), {"standard_error": True, "noise": "new_every_frame", "seed": 2**64 - 1}),
        (omma.ToError(0.05, most=64), {"angular_sensitivity": "gaussian", "footprints": False}),
        (omma.Shared(2), {"background": "0.1,0.25,3", "backend": "portable"}),
        # The camera's own eye, which it scales.
        (omma.Fixed(2), {"eyes": (), "path": None, "camera": "insect", "points": "random"}),
    ],
)
def test_rendered_again_to_the_same_bits(folder, name, sampling, settings):
    warnings = render(name, sampling=sampling, **settings).warnings
    first = load_responses(name).load()
    assert render_like(name, "again.zarr").warnings == warnings
    again = load_responses("again.zarr")
    told = (
        "eye_sha256",
        "scene_sha256",
        "samples",
        "seed",
        "noise",
        "angular_sensitivity",
        "backend",
    )
    assert {key: again.attrs.get(key) for key in told} == {
        key: first.attrs.get(key) for key in told
    }
    for variable in first.data_vars:
        assert np.array_equal(again[variable], first[variable])
    assert np.array_equal(again.world_from_head, first.world_from_head)


def test_again_on_the_command_line(folder, run_omma):
    given = ("scene.gltf", "--eye", "bug.eye", "--path", "path.csv", "--samples", "4")
    assert run_omma("render", *given, "-o", "out.nc")[0] == 0
    expected = "omma render scene.gltf --eye bug.eye --path path.csv --samples 4 -o out.nc"
    assert load_responses("out.nc").attrs["command"] == expected
    code, _, err = run_omma("render-again", "out.nc", "-o", "again.parquet", "--threads", "1")
    assert (code, err) == (0, "")
    again = load_responses("again.parquet")
    assert np.array_equal(again.response, load_responses("out.nc").response)
    assert again.attrs["command"] == "omma render-again out.nc -o again.parquet --threads 1"
    code, _, err = run_omma("render", "-o", "again.npy")
    assert code == 2
    assert "SCENE" in err


@pytest.mark.parametrize("like", [("--like", "out.npy"), ("--like=out.npy",)])
@pytest.mark.parametrize("scene", [(), ("moved/scene.gltf", "--eye", "moved/bug.eye")])
def test_the_old_option_for_again(folder, run_omma, like, scene):
    """It works with a warning, which no help mentions, also where a scene is said before it."""
    render("out.npy")
    if scene:
        (folder / "moved").mkdir()
        shutil.move("scene.gltf", "moved/scene.gltf")
        shutil.move("bug.eye", "moved/bug.eye")
    code, _, err = run_omma("render", *scene, "-o", "old.npy", *like, "--threads", "1")
    assert (code, err) == (
        0,
        "omma: warning: --like is the command omma render-again now; the old option works until "
        "0.2\n",
    )
    code, _, err = run_omma("render-again", "out.npy", *scene, "-o", "new.npy")
    assert (code, err) == (0, "")
    assert Path("old.npy").read_bytes() == Path("new.npy").read_bytes()
    assert "--like" not in run_omma("render", "--help")[1]


def test_inputs_that_have_changed_are_named_with_both_hashes(folder):
    render("out.zarr")
    was = load_responses("out.zarr").attrs
    (folder / "moved").mkdir()
    shutil.move("scene.gltf", "moved/scene.gltf")
    shutil.move("bug.eye", "moved/bug.eye")
    with pytest.raises(omma.Error, match=r"scene\.gltf"):
        render_like("out.zarr", "again.npy")
    render_like("out.zarr", "again.npy", scene="moved/scene.gltf", eyes="moved/bug.eye")
    assert np.array_equal(load_responses("again.npy").response, load_responses("out.zarr").response)

    omma.save_eye("other.eye", make_eye(seed=9))
    with pytest.raises(omma.Error, match=r"other\.eye: is not the eye") as caught:
        render_like("out.zarr", "x.npy", scene="moved/scene.gltf", eyes="other.eye")
    assert was["eye_sha256"] in str(caught.value)
    write_gltf("moved/scene.gltf", extras={"changed": 1})
    with pytest.raises(omma.Error, match=r"scene\.gltf: is not what") as caught:
        render_like("out.zarr", "x.npy", scene="moved/scene.gltf", eyes="moved/bug.eye")
    assert json.loads(was["scene_sha256"])["scene.gltf"] in str(caught.value)
    assert not os.path.exists("x.npy")


def test_what_was_in_memory_is_not_rendered_again(folder):
    sky = omma.Background.image(np.zeros((2, 4, 3), np.float32))
    render("out.npy", background=sky)
    with pytest.raises(omma.Error, match="background that was in memory"):
        render_like("out.npy", "again.npy")
    renderer_of().dataset(np.eye(4)).to_netcdf("own.nc", engine="h5netcdf")
    with pytest.raises(omma.Error, match=r"own.nc: has no command.*Renderer\.dataset"):
        render_like("own.nc", "again.npy")
    assert dict(describe_responses("own.nc"))["shape"].startswith("1 pose x 60 ommatidia")


def test_another_version_is_a_warning(folder):
    render("out.npy")
    text = (folder / "out.json").read_text()
    (folder / "out.json").write_text(text.replace(omma.__version__, "0.0.1"))
    (warning,) = render_like("out.npy", "again.npy").warnings
    assert "Omma 0.0.1" in warning


def test_another_instruction_set_is_a_warning(folder, run_omma, monkeypatch):
    monkeypatch.setattr(processors, "processor_flags", lambda: AVX2)
    render("out.npy")
    assert load_responses("out.npy").attrs["instruction_set"] == "AVX2"
    assert run_omma("info", "out.npy")[1].count(" on AVX2\n") == 1
    monkeypatch.setattr(processors, "processor_flags", lambda: AVX2 - {"avx2"})
    (warning,) = render_like("out.npy", "again.npy").warnings
    assert re.search("rendered with embree .* on AVX2, this is embree .* on AVX:", warning)
    render("own.npy", backend="portable")
    assert "instruction_set" not in load_responses("own.npy").attrs
    assert render_like("own.npy", "again.npy").warnings == ()


@pytest.mark.parametrize("name", [*LABELLED, "out.json"])
def test_info_tells_the_story(folder, run_omma, name):
    output = "out.npy" if name == "out.json" else name
    given = ("--eye", "bug.eye", "--path", "path.csv", "--samples", "4", "--standard-error")
    assert run_omma("render", "scene.gltf", *given, "-o", output)[0] == 0
    code, out, err = run_omma("info", name)
    assert (code, err) == (0, "")
    lines = {line[:16].strip(): line[17:] for line in out.splitlines()}
    data = load_responses(output)
    assert lines["shape"] == "7 poses x 60 ommatidia x 3 bands"
    low, high, mean = data.response.min(), data.response.max(), data.response.mean(dtype=float)
    assert lines["range"] == f"{low:.4g} to {high:.4g}, mean {mean:.4g}"
    assert lines["command"].startswith("omma render scene.gltf")
    assert lines["scene"] == "scene.gltf (unchanged)"
    assert lines["eye"] == "bug.eye (unchanged)"
    assert f"by Omma {omma.__version__}" in lines["rendered"]
    assert "samples 4, seed 0" in lines["settings"]
    omma.save_eye("bug.eye", make_eye(seed=9))
    os.remove("scene.gltf")
    _, out, _ = run_omma("info", name)
    assert "bug.eye (has changed: " in out
    assert "scene.gltf (is not there)" in out


def test_info_of_an_array_alone(folder, run_omma):
    np.save("alone.npy", np.arange(6.0).reshape(2, 3))
    code, out, _ = run_omma("info", "alone.npy")
    assert code == 0
    assert "2 x 3, float64" in out
    assert "there is no alone.json" in out


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("a.npy", None, "no such file"),
        ("a.zarr", None, "no such file"),
        ("a.json", "{}", "JSON that omma writes"),
        ("a.json", "[1", "JSON that omma writes"),
        ("a.parquet", "PAR1", "cannot be read as .parquet"),
        ("a.nc", "CDF", "cannot be read as .nc"),
        ("a.csv", "x,y\n", "pose,ommatidium"),
        ("a.csv", "pose,ommatidium,eye_id,azimuth_deg,elevation_deg,r,g,b\n0,0\n", "whole lines"),
        ("a.txt", "x", "ending in .zarr"),
    ],
)
def test_what_is_no_such_file_is_named(tmp_path, name, content, says):
    if content is not None:
        (tmp_path / name).write_text(content)
    with pytest.raises(omma.Error, match=says) as caught:
        load_responses(tmp_path / name)
    assert name in str(caught.value)


def test_a_json_of_another_array_is_refused(folder):
    render("out.npy")
    np.save("out.npy", np.zeros((2, 60, 3), np.float32))
    with pytest.raises(omma.Error, match=r"expected shape \(7, 60, 3\)"):
        load_responses("out.npy")


def test_labels_of_something_else_are_refused(folder):
    """A .json whose variable has another name, as one that a disk has changed."""
    render("out.npy")
    about = Path("out.json")
    about.write_text(about.read_text().replace('"response"', '"rasponse"'))
    with pytest.raises(omma.Error, match="expected one called response"):
        load_responses("out.npy")


def test_names_that_would_meet(folder):
    (folder / "out.json").mkdir()
    with pytest.raises(omma.Error, match=r"out\.json"):
        render("out.npy")
    with pytest.raises(omma.Error, match="is an output twice"):
        render("a.npy", "a.npy")
    with pytest.raises(omma.Error, match=r"resume: is for \.npy, \.csv and \.png"):
        render("out.zarr", resume=True)
    assert not os.path.exists("out.npy")


def test_labels_are_values(folder):
    labels = labels_of(renderer_of(), np.eye(4)[None])
    assert dataclasses.is_dataclass(labels)
    assert labels.shape("response") == (1, 60, 3)


@pytest.mark.parametrize(
    ("name", "package"), [("a.zarr", "zarr"), ("a.nc", "h5netcdf"), ("a.parquet", "pyarrow")]
)
def test_a_missing_package_is_named(folder, monkeypatch, name, package):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(omma.Error, match=rf"{name}: needs {package}.*omma\[data\]"):
        render(name)
    assert not [entry for entry in os.listdir() if name in entry]


def test_what_an_earlier_render_left_beside_an_npy_file_goes(folder):
    """A camera's picture has no `.json` and no errors, a render without errors has no errors: what
    says otherwise goes with the numbers that it was of. Files of others stay."""
    render("q.npy", standard_error=True)
    assert os.path.exists("q.error.npy")
    report = render("q.npy")
    assert not os.path.exists("q.error.npy")
    assert any("q.error.npy" in one for one in report.warnings)
    assert load_responses("q.npy").response.shape[0] == POSES
    assert render("q.npy").warnings == ()

    render("q.npy", standard_error=True)
    omma.render_file("scene.gltf", "q.npy", omma.Fixed(1), camera="plain", width=8)
    assert np.load("q.npy").shape[1] == 8
    assert not os.path.exists("q.error.npy")
    assert not os.path.exists("q.json")

    # An output of this name, however it is written; a render that fails; a file of somebody else.
    render("q.npy", standard_error=True)
    omma.render_file(
        "scene.gltf", ["q.npy", "./q.error.npy"], omma.Fixed(1), camera="plain", width=8
    )
    assert np.load("q.error.npy").shape[1] == 8
    render("q.npy", standard_error=True)
    with pytest.raises(omma.Error):
        omma.render_file("scene.gltf", "q.npy", omma.Fixed(0), camera="plain", width=8)
    assert load_responses("q.npy").standard_error.shape[0] == POSES
    shutil.copy("q.npy", "other.npy")
    shutil.copy("q.error.npy", "other.error.npy")
    shutil.copy("q.json", "other.json")
    Path("mine.json").write_text("{}")
    np.save("mine.error.npy", np.ones(3))
    for name in ("other", "mine"):
        omma.render_file("scene.gltf", f"{name}.npy", omma.Fixed(1), camera="plain", width=8)
        assert os.path.exists(f"{name}.json")
        assert os.path.exists(f"{name}.error.npy")
