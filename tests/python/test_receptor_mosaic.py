"""Ommatidia of several types mixed over an eye, and the dorsal rim's fan of microvilli."""

import numpy as np
import pytest

import omma
from omma.receptors.mosaic import region_mask


def round_eye(count=4000, seed=5):
    axis = np.random.default_rng(seed).normal(size=(count, 3))
    return omma.Eye(1e-3 * axis, axis, 0.05, columns={"area": np.arange(count)})


def fractions(eye, names):
    kinds = np.array(eye.columns["ommatidium_type"])
    return np.array([np.mean(kinds == name) for name in names])


def test_honeybee_ommatidia_are_mixed_as_they_are_in_bees():
    types = omma.receptors.honeybee_ommatidia()
    eye = omma.receptors.assign_receptors(round_eye(), types, seed=3)
    expected = np.array([0.44, 0.46, 0.10])
    # Each draws by itself: binomial, here within four standard deviations.
    found = fractions(eye, ["I", "II", "III"])
    assert np.all(np.abs(found - expected) < 4 * np.sqrt(expected * (1 - expected) / len(eye)))
    assert [len(kind.receptors) for kind in types] == [8, 8, 8]
    kinds = {kind.name: [r.name for r in kind.receptors] for kind in types}
    assert kinds["I"].count("ultraviolet") == 1
    assert kinds["II"].count("ultraviolet") == 2
    assert kinds["III"].count("blue") == 2
    names = [receptor.name for receptor in eye.receptor_types]
    assert names == ["ultraviolet", "blue", "green"]  # listed once, in the order given
    for i in (0, 1, 2, 100, 3999):
        own = eye.receptor_type[eye.first_receptor[i] : eye.first_receptor[i + 1]]
        assert [names[t] for t in own] == kinds[eye.columns["ommatidium_type"][i]]
    assert np.array_equal(eye.columns["area"], np.arange(len(eye)))


def test_shares_are_relative():
    green = omma.receptors.ReceptorType("green", peak_wavelength_nm=544)
    types = [
        omma.receptors.OmmatidiumType(name, (green,), count)
        for name, count in (("a", 60), ("b", 20))
    ]
    found = fractions(omma.receptors.assign_receptors(round_eye(), types), ["a", "b"])
    # Binomial, within four standard deviations.
    assert np.allclose(found, [0.75, 0.25], atol=4 * np.sqrt(0.1875 / 4000))


def test_the_draw_is_by_chance_but_known():
    types = omma.receptors.honeybee_ommatidia()
    eye = round_eye(800)
    once, again = (omma.receptors.assign_receptors(eye, types, seed=1) for _ in range(2))
    other = omma.receptors.assign_receptors(eye, types, seed=2)
    kinds = [e.columns["ommatidium_type"] for e in (once, again, other)]
    assert kinds[0] == kinds[1]
    agree = np.mean(np.array(kinds[0]) == np.array(kinds[2]))
    # Two draws agree by 0.44² + 0.46² + 0.1² = 0.415; four standard deviations of 800.
    assert abs(agree - 0.415) < 4 * np.sqrt(0.415 * 0.585 / 800)
    # Neighbours in the list are independent, too.
    first = np.array(kinds[0]) == "I"
    assert abs(np.corrcoef(first[:-1], first[1:])[0, 1]) < 4 / np.sqrt(800)


def test_a_part_of_an_eye_keeps_its_draw_and_the_rest_what_it_had():
    types = omma.receptors.honeybee_ommatidia()
    green = types[0].receptors[-1]
    eye = omma.receptors.assign_receptors(
        round_eye(500), omma.receptors.OmmatidiumType("all green", (green,))
    )
    upper = eye.axis[:, 1] > 0.5
    by_mask = omma.receptors.assign_receptors(eye, types, where=upper, seed=4)
    by_function = omma.receptors.assign_receptors(
        eye, types, where=lambda azimuth, elevation: elevation > np.arcsin(0.5), seed=4
    )
    whole = omma.receptors.assign_receptors(eye, types, seed=4)
    kinds = np.array(by_mask.columns["ommatidium_type"])
    assert np.all(kinds[~upper] == "all green")
    assert np.array_equal(kinds[upper], np.array(whole.columns["ommatidium_type"])[upper])
    assert np.array_equal(kinds, by_function.columns["ommatidium_type"])
    assert np.array_equal(np.diff(by_mask.first_receptor), np.where(upper, 8, 1))
    # What is kept comes first, then the others in the order given.
    assert [r.name for r in by_mask.receptor_types] == ["green", "ultraviolet", "blue"]


def test_regions_are_in_azimuth_and_elevation():
    axis = np.array([[0, 0, -1], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [1, 1, 0]])
    eye = omma.Eye(axis, axis, 0.05)
    seen = {}

    def look(azimuth, elevation):
        seen["angles"] = np.degrees([azimuth, elevation])
        return elevation > 0.1

    assert region_mask(eye, look).tolist() == [False, False, False, True, True]
    assert np.allclose(seen["angles"][0, :3], [0, 90, -90])
    assert np.allclose(seen["angles"][1], [0, 0, 0, 90, 45])


def test_a_dorsal_rim_has_orthogonal_channels_in_a_fan():
    """Two receptors at 0 and 90 degrees; up vectors that point to the pole of the rim."""
    eye = round_eye()
    rim = omma.receptors.OmmatidiumType(
        "dorsal rim",
        tuple(
            omma.receptors.ReceptorType(
                name, peak_wavelength_nm=350, microvillus_angle_rad=angle,
                polarisation_sensitivity=6.6,
            )
            for name, angle in (("along", 0.0), ("across", np.pi / 2))
        ),
    )  # fmt: skip
    green = omma.receptors.ReceptorType("green", peak_wavelength_nm=544)

    def dorsal(azimuth, elevation):
        return elevation > np.radians(60)

    pole = np.array([0.1, 0.9, 0.1])
    eye = omma.receptors.assign_receptors(eye, omma.receptors.OmmatidiumType("main", (green,)))
    eye = omma.receptors.up_towards(
        omma.receptors.assign_receptors(eye, rim, where=dorsal), pole, where=dorsal
    )
    mask = region_mask(eye, dorsal)
    assert 0 < mask.sum() < len(eye)
    where = omma.receptors.ommatidium_of_receptor(eye)
    microvilli = omma.receptors.microvillus_direction(eye)
    along, across = microvilli[mask[where]].reshape(-1, 2, 3).transpose(1, 0, 2)
    assert np.allclose(np.sum(along * across, axis=1), 0, atol=1e-6)
    # A fan: one lies in the plane of the axis and the pole, the other across it.
    normal = np.cross(eye.axis[mask], pole / np.linalg.norm(pole))
    assert np.allclose(np.sum(along * normal, axis=1), 0, atol=1e-6)
    assert np.all(along @ pole > 0)
    assert np.allclose(np.sum(across * pole, axis=1), 0, atol=1e-6)
    # It turns once around the pole: all orientations are there.
    directions = np.histogram(np.arctan2(along[:, 0], along[:, 2]), np.linspace(-np.pi, np.pi, 9))
    assert np.all(directions[0] > 0)
    # Elsewhere up is what it was.
    assert np.array_equal(eye.up[~mask], round_eye().up[~mask])


@pytest.mark.parametrize(
    ("types", "message"),
    [
        ((), "at least one OmmatidiumType"),
        ((omma.receptors.OmmatidiumType("a", (), 0),), "not all 0"),
    ],
)
def test_wrong_types_are_named(types, message):
    with pytest.raises(omma.Error, match=message):
        omma.receptors.assign_receptors(round_eye(5), types)


GREEN = omma.receptors.ReceptorType("g", peak_wavelength_nm=500)


@pytest.mark.parametrize(
    ("receptors", "abundance", "message"),
    [
        ((), -1, "abundance: expected a number of at least 0, found -1"),
        ((GREEN,), np.nan, "abundance: expected"),
        ((GREEN,), "half", "abundance: expected"),
        (GREEN, 1, "receptors: expected a tuple of"),
        ((GREEN, "uv"), 1, "receptors: expected a tuple of"),
        ("uv", 1, "receptors: expected a tuple of"),
        (None, 1, "receptors: expected a tuple of"),
    ],
)
def test_a_type_that_is_none_is_refused_where_it_is_made(receptors, abundance, message):
    with pytest.raises(omma.Error, match=message):
        omma.receptors.OmmatidiumType("a", receptors, abundance)
    assert omma.receptors.OmmatidiumType("a", [GREEN]).receptors == (GREEN,)


def test_wrong_arguments_are_named():
    eye = round_eye(5)
    one = omma.receptors.OmmatidiumType(
        "a", (omma.receptors.ReceptorType("g", peak_wavelength_nm=500),)
    )
    with pytest.raises(omma.Error, match="seed: expected at least 0, found -1"):
        omma.receptors.assign_receptors(eye, one, seed=-1)
    for where in (np.ones(4, bool), np.ones(5), lambda azimuth, elevation: True):
        with pytest.raises(omma.Error, match="where: expected a mask of 5 truth values"):
            omma.receptors.assign_receptors(eye, one, where=where)
    ragged = [[True], [True, False]]
    for where in (ragged, lambda azimuth, elevation: ragged):
        with pytest.raises(omma.Error, match="where: expected a mask of 5 truth values"):
            omma.receptors.up_towards(eye, (0, 1, 0), where=where)
    for direction in ((0, 0, 0), (0, 1), (0, np.nan, 1)):
        with pytest.raises(omma.Error, match="direction: expected three numbers"):
            omma.receptors.up_towards(eye, direction)
    up = omma.receptors.up_towards(eye, (0, 1, 0))
    for length in (1e-200, 1e-320, 1e308):
        assert np.array_equal(omma.receptors.up_towards(eye, (0, length, 0)).up, up.up)
    with pytest.raises(omma.Error, match="up vector must not be along the axis"):
        omma.receptors.up_towards(eye, eye.axis[3])
