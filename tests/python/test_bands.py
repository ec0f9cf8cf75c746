"""Worlds of any number of bands, and of both backends."""

from pathlib import Path

import numpy as np
import pytest

import omma

EXAMPLES = Path(__file__).parents[2] / "examples"
EDGES_NM = np.linspace(300, 700, 17)


@pytest.fixture(scope="module")
def scene():
    return omma.load_scene(EXAMPLES / "meadow.glb")


@pytest.fixture(scope="module")
def eye():
    eye = omma.load_eye(EXAMPLES / "honeybee_worker_left.eye").take(np.arange(0, 5000, 40))
    return omma.receptors.assign_receptors(eye, omma.receptors.honeybee_ommatidia())


POSE = omma.look_at((0, 1, 0), (0, 1, -5))


def test_white_is_one_in_every_band_that_we_see():
    lift = omma.light.band_from_rgb(EDGES_NM)
    assert lift.shape == (16, 3)
    # 4 bands of ultraviolet; the spectra add up to 1 above 400 nm.
    assert lift[:4].sum(axis=1) == pytest.approx(0, abs=1e-12)
    assert lift[4:].sum(axis=1) == pytest.approx(1, abs=1e-9)


@pytest.mark.parametrize("bands", [1, 3, 4, 8, 16])
def test_responses_are_the_lift_of_rgb(scene, eye, bands):
    lift = omma.light.band_from_rgb(np.linspace(400, 700, bands + 1))
    rgb = omma.Renderer(scene, eye).render(POSE)
    world = omma.World(scene, band_from_rgb=lift)
    renderer = omma.Renderer(world, eye)
    assert (world.bands, renderer.bands) == (bands, bands)
    found = renderer.render(POSE)
    assert found.shape == (1, len(eye), bands)
    # Single precision: products of numbers up to about 1, summed in another order.
    assert found == pytest.approx(np.einsum("bc,pnc->pnb", lift, rgb), abs=2e-6)
    assert renderer.render_rays(POSE).shape == (1, len(eye), 16, bands)


def test_receptors_of_fine_bands_are_those_of_rgb(scene, eye):
    """What 4 nm apart changes of spectra that change over tens of nm is under 1e-3."""
    edges = np.linspace(300, 700, 101)
    lift, matrix = (
        omma.light.band_from_rgb(edges),
        omma.receptors.receptor_matrix(eye, edges_nm=edges),
    )
    assert matrix @ lift == pytest.approx(omma.receptors.receptor_matrix(eye), abs=1e-3)
    renderer = omma.Renderer(omma.World(scene, band_from_rgb=lift), eye)
    found = renderer.render_receptors(POSE, matrix=matrix)
    assert found == pytest.approx(omma.Renderer(scene, eye).render_receptors(POSE), abs=2e-3)
    with pytest.raises(omma.Error, match="bands are not RGB"):
        renderer.render_receptors(POSE)
    with pytest.raises(omma.Error, match=r"\[type, band\] of shape \(3, 100\)"):
        renderer.render_receptors(POSE, matrix=matrix[:, :3])


def test_errors_of_receptors_are_their_own(scene, eye):
    """From the spread of eight scrambles, which single rays tell too: those of one matrix row."""
    renderer = omma.Renderer(scene, eye, omma.Fixed(4))
    matrix = omma.receptors.receptor_matrix(eye)
    responses, errors = renderer.render_receptors(POSE, standard_error=True)
    _, of_bands = renderer.render(POSE, standard_error=True)
    bound = np.einsum("tb,pnb->pnt", np.abs(matrix), of_bands)
    at = omma.receptors.ommatidium_of_receptor(eye), eye.receptor_type
    assert np.all(errors <= bound[:, at[0], at[1]] * 1.0001 + 1e-6)
    # Where the matrix takes the difference of bands that go together nothing is left of the error.
    opposed = np.array([[1.0, -1.0, 0.0]] * len(matrix))
    _, errors = renderer.render_receptors(POSE, matrix=opposed, standard_error=True)
    together = of_bands[..., 0] + of_bands[..., 1]
    assert np.median(errors / np.maximum(together[:, at[0]], 1e-9)) < 0.5
    assert responses.shape == errors.shape == (1, len(eye.receptor_type))


def test_pictures_have_the_bands_of_their_world():
    scene = omma.load_scene(EXAMPLES / "meadow.glb")
    if not scene.cameras:
        pytest.skip("no camera")
    world = omma.World(scene, band_from_rgb=omma.light.band_from_rgb([400, 500, 600, 700, 750]))
    picture = omma.render_camera(world, scene.cameras[0], width=32, samples=1)
    assert picture.shape[2] == 4


def test_files_have_a_column_for_each_band(tmp_path, scene, eye):
    renderer = omma.Renderer(omma.World(scene, band_from_rgb=np.eye(3)[:2]), eye)
    omma.save_responses(tmp_path / "two.csv", renderer.render(POSE), eye, world=renderer.world)
    head = (tmp_path / "two.csv").read_text().splitlines()[0]
    assert head.endswith(",elevation_deg,band_0,band_1")
    with pytest.raises(omma.Error, match="red, green, blue"):
        omma.picture.equirectangular(eye, renderer.render(POSE))


@pytest.mark.parametrize(
    "weights", [np.zeros((0, 3)), np.ones((129, 3)), np.ones((2, 2)), [[1, 0, np.nan]], "rgb"]
)
def test_bands_that_cannot_be(scene, weights):
    with pytest.raises(omma.Error, match="band_from_rgb"):
        omma.World(scene, band_from_rgb=weights)


@pytest.mark.parametrize("edges", [[400], [500, 400], [400, np.nan], np.arange(200)])
def test_edges_that_cannot_be(edges):
    with pytest.raises(omma.Error, match="edges_nm"):
        omma.light.band_from_rgb(edges)


def test_backends_agree(scene, eye):
    """Hits differ at edges that a ray grazes, in the last bits elsewhere (docs/performance.md)."""
    found = {}
    for backend in ("embree", "portable"):
        renderer = omma.Renderer(scene, eye, backend=backend)
        assert renderer.backend.startswith(backend)
        found[backend] = renderer.render(POSE)
    difference = np.abs(found["embree"] - found["portable"])
    # One ray of 16 of an ommatidium may see past an edge.
    assert difference.max() <= 2 / 16
    assert difference.mean() <= 1e-4


def test_no_such_backend(scene, eye):
    with pytest.raises(omma.Error, match="embree, portable"):
        omma.Renderer(scene, eye, backend="optix")
    with pytest.raises(omma.Error, match="its own"):
        omma.Renderer(omma.World(scene), eye, backend="portable")


def test_reports_say_which_it_was(tmp_path):
    report = omma.render_file(
        EXAMPLES / "meadow.glb",
        tmp_path / "bee.npy",
        omma.Fixed(1),
        eyes=EXAMPLES / "honeybee_worker_left.eye",
        position=(0, 1, 0),
        backend="portable",
    )
    assert report.backend == "portable"
