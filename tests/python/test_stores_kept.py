"""What is in a store beside responses is not lost where a render is to replace the store."""

import shutil

import numpy as np
import pytest
from conftest import make_eye

import omma
from omma.rendering import load_responses
from omma.rendering.labelled_files import other_than_responses
from omma.rendering.labels import WRITTEN, labels_of

pytest.importorskip("xarray")
zarr = pytest.importorskip("zarr")

POSES = "x,y,z,yaw_deg,pitch_deg,roll_deg\n0,1,0,0,0,0\n0.1,1,0,3,0,0"


@pytest.fixture
def folder(files, tmp_path, monkeypatch):
    """scene.gltf, bug.eye, path.csv and responses, out.zarr, in the current directory."""
    for name in ("scene.gltf", "bug.eye"):
        shutil.copy(files / name, tmp_path)
    (tmp_path / "path.csv").write_text(POSES)
    monkeypatch.chdir(tmp_path)
    render("out.zarr")
    return tmp_path


TWO_RAYS = omma.Fixed(2)


def render(*outputs, sampling=TWO_RAYS, **settings):
    return omma.render_file(
        "scene.gltf", outputs, sampling, eyes="bug.eye", path="path.csv", **settings
    )


def write_beside(folder):
    render("out.zarr/y.npy")


def write_into_an_array(folder):
    (folder / "out.zarr" / "response" / "notes.txt").write_text("years")


def link_to_another(folder):
    (folder / "far").mkdir()
    (folder / "out.zarr" / "far").symlink_to(folder / "far")


def add_an_array(folder):
    zarr.open_group("out.zarr", mode="a").create_array("album", data=np.ones(2))


def add_a_group(folder):
    group = zarr.open_group("out.zarr", mode="a").create_group("mine")
    group.create_array("response", data=np.ones(2))


@pytest.mark.parametrize(
    ("add", "named"),
    [
        (write_beside, "y.json, y.npy"),
        (write_into_an_array, "response/notes.txt"),
        (link_to_another, "far"),
        (add_an_array, "album"),
        (add_a_group, "mine"),
    ],
)
def test_what_no_render_wrote_is_kept_and_named(folder, add, named):
    add(folder)
    before = sorted(path for path in (folder / "out.zarr").rglob("*"))
    with pytest.raises(omma.Error) as error:
        render("out.zarr", seed=3)
    assert f"also holds what no render wrote: {named}" in str(error.value)
    assert sorted(path for path in (folder / "out.zarr").rglob("*")) == before


def test_what_came_while_it_was_rendered_is_kept(folder):
    notes = folder / "out.zarr" / "notes.txt"

    def meanwhile(stage, share):
        if stage == "Rendering":
            notes.write_text("years")

    with pytest.raises(omma.Error, match=r"what no render wrote: notes\.txt"):
        render("out.zarr", progress=meanwhile)
    assert notes.read_text() == "years"


def test_at_an_address_too(folder):
    pytest.importorskip("fsspec")
    import fsspec

    memory = fsspec.filesystem("memory")
    try:
        for seed in (1, 2):
            render("memory://kept/out.zarr", seed=seed)
        memory.pipe("/kept/out.zarr/notes.txt", b"years")
        with pytest.raises(omma.Error, match=r"what no render wrote: notes\.txt"):
            render("memory://kept/out.zarr", seed=3)
        assert memory.cat("/kept/out.zarr/notes.txt") == b"years"
    finally:
        memory.rm("/kept", recursive=True)


def test_many_are_counted():
    files = [f"{k}.txt" for k in range(8)]
    assert other_than_responses(b'{"attributes": {"omma_version": "1"}}', files).endswith(
        "0.txt, 1.txt, 2.txt and 5 more"
    )


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"standard_error": True},
        {"sampling": omma.ToError(0.1, most=64)},
        {"light": "clear_sky sun_elevation_deg=30 bands=visible"},
    ],
)
def test_what_renders_write_is_replaced(folder, settings):
    """Also where a file browser has left its file there."""
    render("out.zarr", **settings)
    (folder / "out.zarr" / ".DS_Store").write_bytes(b"\0")
    render("out.zarr", **settings, seed=5)
    assert load_responses("out.zarr").attrs["seed"] == 5


@pytest.mark.parametrize("receptors", [False, True])
def test_all_that_labels_name_is_known(folder, receptors):
    eye = make_eye(3)
    if receptors:
        green = omma.receptors.ReceptorType("green", peak_wavelength_nm=544)
        kind = omma.receptors.OmmatidiumType("green", (green,))
        eye = omma.receptors.assign_receptors(eye, kind)
    world = omma.load_scene("scene.gltf")
    labels = labels_of(
        omma.Renderer(world, eye, omma.ToError(0.1)),
        np.eye(4)[None],
        receptors=receptors,
        with_cameras=True,
        time_s=np.zeros(1),
    )
    assert WRITTEN >= {*labels.variables, *labels.coordinates}
