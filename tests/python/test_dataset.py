"""Responses as xarray datasets: the same numbers, with what they are."""

import hashlib
import json

import numpy as np
import pytest

import omma

xarray = pytest.importorskip("xarray")


@pytest.fixture(scope="module")
def renderer(scene, eye):
    return omma.Renderer(scene, eye, omma.Fixed(4), seed=7)


def test_numbers_are_those_of_render(renderer, flight):
    data = renderer.dataset(flight, standard_error=True)
    responses, errors = renderer.render(flight, standard_error=True)
    assert data.response.dims == data.standard_error.dims == ("pose", "ommatidium", "band")
    assert np.array_equal(data.response.values, responses)
    assert np.array_equal(data.standard_error.values, errors)
    assert data.response.dtype == np.float32
    assert data.band.values.tolist() == ["red", "green", "blue"]
    assert "standard_error" not in renderer.dataset(flight)


def test_places(renderer, flight):
    data = renderer.dataset(flight)
    assert np.array_equal(data.position.values, flight[:, :3, 3])
    back = omma.poses_from_quaternions(data.position.values, data.quaternion.values)
    assert np.allclose(back, flight, atol=1e-12)
    eye = renderer.eye
    assert np.allclose(
        omma.eye.direction(data.azimuth.values, data.elevation.values), eye.axis, atol=1e-6
    )
    assert np.allclose(data.acceptance_angle.values, np.degrees(eye.acceptance_angle_rad))
    assert data.position.attrs["units"] == "m"
    ahead = data.sel(band="green").where(abs(data.azimuth) < 30, drop=True)
    assert 0 < ahead.sizes["ommatidium"] < len(eye)


def test_the_turn_of_a_pose_that_scales_and_mirrors(renderer, flight):
    stretched = flight @ np.diag([2.0, 2.0, 2.0, 1.0])
    assert np.allclose(
        renderer.dataset(stretched).quaternion, renderer.dataset(flight).quaternion, atol=1e-9
    )
    mirrored = flight @ np.diag([-1.0, 1.0, 1.0, 1.0])
    quaternions = renderer.dataset(mirrored).quaternion.values
    assert np.allclose(np.linalg.norm(quaternions, axis=1), 1)


@pytest.mark.parametrize("value", [np.nan, np.inf, 0.0, 1e300])
def test_poses_that_cannot_be_are_refused(renderer, value):
    pose = np.eye(4)
    pose[:3, :3] = value
    with pytest.raises(omma.Error, match=r"^poses"):
        renderer.dataset(pose)


def test_time_in_place_of_poses(renderer, flight):
    time_s = np.arange(len(flight)) / 500
    data = renderer.dataset(flight, time_s=time_s)
    assert data.response.dims == ("time", "ommatidium", "band")
    assert np.array_equal(data.sel(time=0.004).response, renderer.render(flight[2])[0])
    with pytest.raises(omma.Error, match="time_s: expected shape"):
        renderer.dataset(flight, time_s=[0.0])


def test_rays_to_an_error(scene, eye, flight):
    auto = omma.Renderer(scene, eye, omma.ToError(0.05, most=64))
    data = auto.dataset(flight)
    _, report = auto.render(flight, report=True)
    assert np.array_equal(data.rays.values, report.rays)
    assert np.array_equal(data.standard_error.values, report.standard_error)
    assert data.attrs["error"] == 0.05
    assert data.attrs["sampling"] == "ToError"


def test_receptors(scene, eye, flight):
    types = [
        omma.receptors.ReceptorType("green", peak_wavelength_nm=544),
        omma.receptors.ReceptorType("aside", peak_wavelength_nm=436, right_rad=0.1),
    ]
    eye = omma.receptors.assign_receptors(eye, omma.receptors.OmmatidiumType("both", tuple(types)))
    renderer = omma.Renderer(scene, eye, omma.Fixed(4))
    data = renderer.dataset(flight, receptors=True, standard_error=True, ultraviolet=(0, 0, 1))
    seen, errors = renderer.render_receptors(flight, standard_error=True, ultraviolet=(0, 0, 1))
    assert data.response.dims == ("pose", "receptor")
    assert np.array_equal(data.response.values, seen)
    assert np.array_equal(data.standard_error.values, errors)
    assert set(data.type.values.tolist()) == {"green", "aside"}
    green = data.where(data.type == "green", drop=True)
    assert (green.peak_wavelength == 544).all()
    assert np.array_equal(green.ommatidium, np.arange(len(eye)))
    with pytest.raises(omma.Error, match="ultraviolet: is for receptors=True"):
        renderer.dataset(flight, ultraviolet=(0, 0, 1))


def test_other_bands(scene, eye):
    world = omma.World(scene, band_from_rgb=omma.light.band_from_rgb([400, 550, 700]))
    data = omma.Renderer(world, eye, omma.Fixed(1)).dataset(np.eye(4))
    assert data.band.values.tolist() == ["band_0", "band_1"]
    assert np.array_equal(json.loads(data.attrs["band_from_rgb"]), world.band_from_rgb)


def test_attributes_say_what_it_was_made_of(renderer, flight, eye, scene):
    attributes = renderer.dataset(flight[:1]).attrs
    assert attributes["omma_version"] == omma.__version__
    assert (attributes["samples"], attributes["seed"]) == (4, 7)
    assert attributes["backend"] == renderer.backend
    with open(scene.path, "rb") as file:
        digest = hashlib.sha256(file.read()).hexdigest()
    assert json.loads(attributes["scene_sha256"])[scene.path] == digest
    again = omma.Renderer(scene, eye.replace(), omma.Fixed(1)).dataset(flight[:1]).attrs
    assert again["eye_sha256"] == attributes["eye_sha256"]
    other = eye.replace(acceptance=omma.Acceptance.gaussian(0.1))
    assert (
        omma.Renderer(scene, other, omma.Fixed(1)).dataset(flight[:1]).attrs["eye_sha256"]
        != (attributes["eye_sha256"])
    )


def test_it_is_written_and_read_back(renderer, flight, tmp_path):
    pytest.importorskip("scipy")
    data = renderer.dataset(flight, standard_error=True)
    data.to_netcdf(tmp_path / "flight.nc", engine="scipy")
    with xarray.open_dataset(tmp_path / "flight.nc", engine="scipy") as back:
        assert np.array_equal(back.response, data.response)
        assert back.attrs["eye_sha256"] == data.attrs["eye_sha256"]
