"""That polarisation is left out is told before receptors that could tell: once a session."""

import warnings

import numpy as np
import pytest
from conftest import make_eye

import omma

BANDS = omma.light.Bands.equal(4)
CLEAR = omma.light.clear_sky(20, bands=BANDS)
TOLD = r"PS\) of up to 6.3, .* polarized=True"


def renderer_of(light, sensitivity=6.3, **how):
    """Of one receptor in twenty, as of a rim."""
    plain = omma.receptors.ReceptorType("plain", peak_wavelength_nm=345)
    rim = omma.receptors.ReceptorType(
        "rim", peak_wavelength_nm=345, polarisation_sensitivity=sensitivity
    )
    eye = omma.receptors.assign_receptors(
        make_eye(20), omma.receptors.OmmatidiumType("plain", (plain,))
    )
    eye = omma.receptors.assign_receptors(
        eye,
        omma.receptors.OmmatidiumType("rim", (rim,)),
        where=lambda azimuth, elevation: elevation == elevation.max(),
    )
    assert (np.array(eye.receptor_types)[eye.receptor_type] == rim).sum() == 1
    return omma.Renderer(omma.World(omma.Scene(), light=light, **how), eye, omma.Fixed(1))


def test_it_is_told_once():
    renderer = renderer_of(CLEAR)
    with pytest.warns(UserWarning, match=TOLD) as told:
        [renderer.render_receptors(np.eye(4)) for _ in range(2)]
    assert len(told) == 1
    assert told[0].filename == __file__


def test_labelled_responses_tell_it_too():
    pytest.importorskip("xarray")
    with pytest.warns(UserWarning, match=TOLD):
        renderer_of(CLEAR).dataset(np.eye(4), receptors=True)


def test_under_water_too():
    with pytest.warns(UserWarning, match=TOLD):
        renderer_of(omma.light.under_water(CLEAR, 2)).render_receptors(np.eye(4))


@pytest.mark.parametrize(
    ("light", "sensitivity", "polarized"),
    [
        (CLEAR, 1.0, False),
        (CLEAR, 6.3, True),
        (omma.light.overcast_sky(20, bands=BANDS), 6.3, False),
        (omma.light.lamps(bands=BANDS), 6.3, False),
        (None, 6.3, False),
    ],
)
def test_it_is_not_told_where_nothing_is_left_out(light, sensitivity, polarized):
    renderer = renderer_of(light, sensitivity, polarized=polarized)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        renderer.render_receptors(np.eye(4))
        renderer.render(np.eye(4))


def test_detection_in_a_scene_tells_it():
    plain, rim = (
        omma.receptors.ReceptorType(
            name,
            peak_wavelength_nm=500,
            polarisation_sensitivity=sensitivity,
            absorption_per_m=6700,
            length_m=2e-4,
        )
        for name, sensitivity in (("plain", 1.0), ("rim", 6.3))
    )
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], 0.05, facet_diameter_m=20e-6).replace(
        receptor_types=[plain, rim], receptors=[[0, 1]]
    )
    without = omma.scene.box((1, 1, 0.1), center_m=(0, 0, -0.1))
    target = omma.colour_vision.SceneTarget(
        omma.scene.merge_scenes([without, omma.scene.disc(0.1, (0.9, 0.9, 0.9))]),
        without,
        0.2,
        ultraviolet="dark",
    )
    few = {"sampling": omma.Fixed(4), "between_m": (1, 2)}
    counted = [omma.colour_vision.Observer(receptors=(one,)) for one in ("plain", "rim")]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", "sampling: of 8")
        omma.detect(eye, target, omma.light.overcast_sky(20, bands=BANDS), counted[1], **few)
        omma.detect(eye, target, CLEAR, counted[0], **few)
        disc = omma.colour_vision.DiscTarget(0.1, 0.5, 0.1)
        omma.detect(eye, disc, CLEAR, counted[1], **few)
    with pytest.warns(UserWarning, match=r"PS\) of up to 6.3.*omma\.detect follows no") as told:
        [omma.detect(eye, target, CLEAR, counted[1], **few) for _ in range(2)]
    assert sum("PS)" in str(one.message) for one in told) == 1
