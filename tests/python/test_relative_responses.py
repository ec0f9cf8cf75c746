"""Photons of responses that are no photons: those of a world without a light are told."""

import warnings

import numpy as np
import pytest

import omma

DAY = omma.light.clear_sky(40)


@pytest.fixture(scope="module")
def bee():
    return omma.species.honeybee_worker().eye.take(range(12))


def even_light(eye, light):
    """What each receptor answers to light that is the same everywhere."""
    matrix = omma.receptors.receptor_matrix(eye, bands=light.bands)
    return (matrix @ light.radiance((0, 1, 0))[0])[eye.receptor_type]


@pytest.mark.parametrize("background", [(0.5, 0.5, 0.5), (1.0, 1.0, 1.0), (1e-4, 0.0, 0.0)])
def test_responses_of_a_world_without_a_light_are_told(bee, background):
    """Pictures and colours are 0 to 1; daylight is 1e18 photons."""
    world = omma.World(omma.Scene(), background=omma.Background.constant(background))
    seen = omma.Renderer(world, bee, omma.Fixed(1)).render_receptors(np.eye(4))
    assert 0 < seen.max() <= 1
    with pytest.warns(UserWarning, match=r"responses: up to .* has 1.26e\+18: they look relative"):
        omma.receptors.photon_catch(bee, seen, DAY, integration_time_s=0.03)


def quiet_catch(eye, seen, light):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return omma.receptors.photon_catch(eye, seen, light, integration_time_s=0.03)


@pytest.mark.parametrize(
    ("light", "share"),
    [
        (omma.light.night_sky(), 1.0),
        (omma.light.night_sky(), 1e-7),  # a black surface in the shade of a wood at night
        (DAY, 1e-14),
        (DAY, 0.0),
        (omma.light.uniform_sky(1.0), 1.0),  # dim, and all the light there is
        (omma.light.uniform_sky(0.0), 1.0),
    ],
)
def test_dark_worlds_that_are_lit_are_not(bee, light, share):
    quiet_catch(bee, share * even_light(bee, light), light)


def test_lamps_alone_say_nothing_of_how_bright_they_are(bee):
    quiet_catch(bee, np.full(len(bee.receptor_type), 0.5), omma.light.lamps())


def test_photons_for_a_response_of_1_may_be_asked_for(bee):
    assert np.all(quiet_catch(bee, np.ones(len(bee.receptor_type)), DAY) > 0)


def test_no_responses_are_no_photons(bee):
    assert quiet_catch(bee, np.zeros((0, len(bee.receptor_type))), DAY).shape[0] == 0
