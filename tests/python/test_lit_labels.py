"""What labelled results say of light: bands by their wavelengths, absolute units, which light."""

import numpy as np
import pytest

import omma

pytest.importorskip("xarray")

POSE = omma.look_at((0, 1, 0), (0, 0, -1))


def renderer_of(unit, polarized=False):
    light = omma.light.uniform_sky(2.0, bands=omma.light.Bands.equal(4), unit=unit)
    world = omma.World(
        omma.scene.plane((4, 4)), light=light, ultraviolet=0.5, depth=2, polarized=polarized
    )
    return omma.Renderer(world, omma.eye.generate_eye(20), omma.Fixed(4))


def test_bands_have_wavelengths_and_responses_units():
    found = renderer_of("photons").dataset(POSE, standard_error=True)
    assert found.band.values.tolist() == ["350 nm", "450 nm", "550 nm", "650 nm"]
    assert found.wavelength.values.tolist() == pytest.approx([350, 450, 550, 650])
    assert found.wavelength.attrs["units"] == "nm"
    assert found.response.attrs["units"] == "photons m-2 s-1 sr-1 nm-1"
    assert found.standard_error.attrs["units"] == "photons m-2 s-1 sr-1 nm-1"
    assert found.attrs["light"].startswith("Light(uniform_sky(")
    assert (found.attrs["depth"], found.attrs["polarized"]) == (2, 0)


def test_watts_and_polarisation_are_told():
    found = renderer_of("watts", polarized=True).dataset(POSE)
    assert found.response.attrs["units"] == "W m-2 sr-1 nm-1"
    assert found.response.shape == (1, 20, 4)  # I alone
    assert found.attrs["polarized"] == 1


def test_they_survive_a_file(tmp_path):
    pytest.importorskip("h5netcdf")
    found = renderer_of("photons").dataset(POSE)
    found.to_netcdf(tmp_path / "lit.nc", engine="h5netcdf")
    again = omma.rendering.load_responses(tmp_path / "lit.nc")
    assert np.array_equal(again.response.values, found.response.values)
    assert again.response.attrs["units"] == "photons m-2 s-1 sr-1 nm-1"
    assert again.wavelength.values.tolist() == found.wavelength.values.tolist()
