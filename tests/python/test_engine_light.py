"""The engine's light: made of arrays, given back as read-only views, refused with a name."""

import gc
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from omma import Error, _core


def arguments(**changes: Any) -> dict[str, Any]:
    """Those of a sound light of two bands, with others in place of some."""
    sky = np.zeros((2, 3, 4, 3, 2), np.float32)
    sky[:, :, :, 0] = np.arange(2 * 3 * 4 * 2).reshape(2, 3, 4, 2)
    sound = {
        "wavelength_nm": [400, 500, 600],
        "weight": [[0.5, 0.5, 0], [0, 0.5, 0.5]],
        "cell_nm": [100, 100, 100],
        "unit": "photons",
        "sky": sky,
        "band_from_channel": None,
        "discs": [((0, 1, 0), 0.005, [1.0, 2.0], None), ((0, 0, -1), 0.01, [1, 1], [0.5, 1])],
        "extinction_per_m": [0.5, 0.25],
        "cloud_shadow": (np.arange(6, dtype=np.float32).reshape(2, 3), 30.0, 1000.0, (-5.0, 7.0)),
        "ultraviolet": [[0, 0, 1, 0], [0, 0, 0, 0.05]],
        "bottomless": True,
    }
    return {**sound, **changes}


def test_what_is_given_comes_back_read_only() -> None:
    given = arguments(band_from_channel=[[1, 0], [0.5, 0.5]], unit="watts")
    light = _core.Light(**given)
    sky, matrix, ultraviolet = light.sky, light.band_from_channel, light.ultraviolet
    extinction, shadow = light.extinction_per_m, light.cloud_shadow
    discs, weight, wavelength_nm = light.discs, light.weight, light.wavelength_nm
    assert light.unit == "watts"
    assert light.bottomless
    del light
    gc.collect()  # views keep what they look at
    assert sky is not None
    assert matrix is not None
    assert ultraviolet is not None
    assert extinction is not None
    assert sky.dtype == np.float32
    np.testing.assert_array_equal(sky, given["sky"])
    np.testing.assert_array_equal(matrix, given["band_from_channel"])
    np.testing.assert_array_equal(ultraviolet, given["ultraviolet"])
    np.testing.assert_array_equal(extinction, given["extinction_per_m"])
    assert shadow is not None
    np.testing.assert_array_equal(shadow[0], given["cloud_shadow"][0])
    assert shadow[1:] == given["cloud_shadow"][1:]
    np.testing.assert_array_equal(weight, given["weight"])
    np.testing.assert_array_equal(wavelength_nm, given["wavelength_nm"])
    assert [disc[0] for disc in discs] == [(0, 1, 0), (0, 0, -1)]
    assert [disc[1] for disc in discs] == [0.005, 0.01]
    np.testing.assert_array_equal(discs[0][2], [1, 2])
    assert discs[0][3] is None
    np.testing.assert_array_equal(discs[1][3], [0.5, 1])
    views = [sky, matrix, ultraviolet, extinction, shadow[0], weight, wavelength_nm, discs[0][2]]
    for array in views:
        assert not array.flags.writeable


def test_what_is_not_given_is_none() -> None:
    names = ["sky", "extinction_per_m", "cloud_shadow", "ultraviolet", "cell_nm"]
    missing = dict.fromkeys(names)
    light = _core.Light(**arguments(**missing, discs=[]))
    assert light.sky is None
    assert light.band_from_channel is None
    assert light.extinction_per_m is None
    assert light.cloud_shadow is None
    assert light.discs == ()
    assert light.ultraviolet is None


def spoilt(change: Callable[[np.ndarray], None]) -> np.ndarray:
    sky: np.ndarray = arguments()["sky"].copy()
    change(sky)
    return sky


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("wavelength_nm", {"wavelength_nm": [[400]]}),
        ("bands.wavelength_nm", {"wavelength_nm": [400, 400, 500]}),
        ("weight", {"weight": [0.5, 0.5, 0]}),
        ("bands.weight", {"weight": [[0.5, 0.4, 0], [0, 0.5, 0.5]]}),
        ("bands.cell_nm", {"cell_nm": [100, 100]}),
        ("bands.cell_nm", {"cell_nm": [100, 100, -1]}),
        ("emission_cd_m2", {"emission_cd_m2": -1}),
        ("unit", {"unit": "lumens"}),
        ("sky", {"sky": np.zeros((3, 3, 4, 1, 2))}),
        ("sky.rows", {"sky": np.zeros((2, 1, 4, 1, 2))}),
        ("sky.channels", {"sky": np.zeros((2, 3, 4, 1, 3))}),
        ("sky.radiance", {"sky": spoilt(lambda sky: sky.fill(np.nan))}),
        ("sky.radiance", {"sky": spoilt(lambda sky: sky[..., 1, :].fill(1e9))}),
        ("band_from_channel", {"band_from_channel": [[1, 0, 0], [0, 1, 0]]}),
        ("sky.band_from_channel", {"band_from_channel": [[1, 0]]}),
        ("band_from_channel", {"sky": None, "band_from_channel": [[1, 0], [0, 1]]}),
        ("discs", {"discs": [(1, 2)]}),
        ("discs: direction", {"discs": [((1, 2), 0.01, [1, 1], None)]}),
        ("discs[0].direction", {"discs": [((1, 2, 3), 0.01, [1, 1], None)]}),
        ("discs[0].angular_radius_rad", {"discs": [((0, 1, 0), 1.0, [1, 1], None)]}),
        ("discs[0].radiance", {"discs": [((0, 1, 0), 0.01, [1], None)]}),
        ("discs[0].limb_darkening", {"discs": [((0, 1, 0), 0.01, [1, 1], [2, 0])]}),
        ("extinction_per_m", {"extinction_per_m": [1.0]}),
        ("cloud_shadow", {"cloud_shadow": (np.zeros((2, 2)), 1.0)}),
        ("cloud_shadow: first_m", {"cloud_shadow": (np.zeros((2, 2)), 1.0, 9.0, (0, 0, 0))}),
        ("cloud_shadow.optical_depth", {"cloud_shadow": (np.zeros((1, 2)), 1.0, 9.0, (0, 0))}),
        ("cloud_shadow.optical_depth", {"cloud_shadow": (-np.ones((2, 2)), 1.0, 9.0, (0, 0))}),
        ("cloud_shadow.spacing_m", {"cloud_shadow": (np.zeros((2, 2)), 0.0, 9.0, (0, 0))}),
        ("cloud_shadow.height_m", {"cloud_shadow": (np.zeros((2, 2)), 1.0, 2e9, (0, 0))}),
        ("extinction_per_m", {"extinction_per_m": [1.0, -1.0]}),
        ("extinction_per_m", {"extinction_per_m": [1.0, 1001.0]}),
        ("ultraviolet", {"ultraviolet": [[0, 0, 1]]}),
        ("ultraviolet", {"ultraviolet": [[1, 1, 0, 0]]}),
    ],
)
def test_what_cannot_be_is_refused_by_name(name: str, changes: dict[str, Any]) -> None:
    with pytest.raises(Error) as caught:
        _core.Light(**arguments(**changes))
    assert str(caught.value).startswith(f"{name}: expected ")
