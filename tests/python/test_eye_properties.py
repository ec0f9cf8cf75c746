"""Eyes whose ommatidia differ: their properties from Python, and changed copies."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import omma

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
ELLIPSE = omma.Acceptance.gaussian(0.04, 0.01, 0.3)
LENS = omma.Acceptance.lens_rhabdom(20e-6, 50e-6, 1.9e-6, 500)
GREEN = omma.receptors.ReceptorType("green", peak_wavelength_nm=544)
ULTRAVIOLET = omma.receptors.ReceptorType(
    "uv", peak_wavelength_nm=344, polarisation_sensitivity=6.3
)


def full_eye() -> omma.Eye:
    return omma.Eye(
        [[0, 0, 0], [1e-3, 0, 0], [2e-3, 0, 0]],
        [[0, 0, -1], [1, 0, 0], [0, 1, 0]],
        0.03,
        [0, 1e-5, 2e-5],
        [0, 0, 1],
        up=[[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        facet_diameter_m=[20e-6, 25e-6, 0],
        aperture_diameter_m=2e-4,
        acceptance=[ELLIPSE, None, LENS],
        receptor_types=[GREEN, ULTRAVIOLET],
        receptors=[[0, 1], [], [1]],
        columns={"length_um": [1, 2, 3], "region": ["a", "b", "ç"]},
        path="made.csv",
    )


def same(a: omma.Eye, b: omma.Eye, but: tuple[str, ...] = ()) -> None:
    arrays = ("position_m", "axis", "acceptance_angle_rad", "focal_offset_m", "eye_id", "up",
              "facet_diameter_m", "aperture_diameter_m", "acceptance_of", "first_receptor",
              "receptor_type")  # fmt: skip
    for name in arrays:
        if name not in but:
            np.testing.assert_array_equal(getattr(a, name), getattr(b, name), err_msg=name)
    for name in ("acceptances", "receptor_types", "path"):
        if name not in but:
            assert getattr(a, name) == getattr(b, name), name
    if "columns" not in but:
        assert list(a.columns) == list(b.columns)
        for name in a.columns:
            assert list(a.columns[name]) == list(b.columns[name])


def test_all_properties_can_be_read() -> None:
    eye = full_eye()
    assert eye.acceptance_of.tolist() == [0, -1, 1]
    assert eye.acceptances == [ELLIPSE, LENS]
    assert eye.acceptance_angle_rad[0] == pytest.approx(0.02)  # sqrt(0.04 0.01)
    assert eye.acceptance_angle_rad[1] == pytest.approx(0.03)
    assert eye.acceptance_angle_rad[2] == pytest.approx(LENS.mean_width_rad)
    np.testing.assert_array_equal(eye.right[0], [0, -1, 0])  # (-z) x (+x)
    assert eye.first_receptor.tolist() == [0, 2, 2, 3]
    assert eye.receptor_type.tolist() == [0, 1, 1]
    assert eye.receptor_types == [GREEN, ULTRAVIOLET]
    assert eye.columns["length_um"].tolist() == [1, 2, 3]
    assert eye.columns["region"] == ["a", "b", "ç"]
    assert eye.acceptance(1) == omma.Acceptance.gaussian(float(np.float32(0.03)))
    assert eye.path == "made.csv"
    with pytest.raises(ValueError, match="read-only"):
        eye.up[0] = 0


def test_replacing_nothing_changes_nothing() -> None:
    same(full_eye(), full_eye().replace())


def test_what_is_replaced_changes_alone() -> None:
    eye = full_eye()
    same(eye, eye.replace(eye_id=3), but=("eye_id",))
    same(eye, eye.replace(columns={}), but=("columns",))
    narrow = eye.replace(acceptance_angle_rad=0.01)
    assert narrow.acceptance_of.tolist() == [-1, -1, -1]
    assert narrow.acceptances == []
    same(eye, narrow, but=("acceptance_angle_rad", "acceptance_of", "acceptances"))
    assert eye.replace(acceptance=LENS).acceptance_of.tolist() == [0, 0, 0]
    round_ones = eye.replace(acceptance=None)
    assert round_ones.acceptance_of.tolist() == [-1, -1, -1]
    np.testing.assert_array_equal(round_ones.acceptance_angle_rad, eye.acceptance_angle_rad)
    # None keeps the acceptance angle that was there.
    kept = eye.replace(acceptance=[None, None, LENS])
    assert kept.acceptance_angle_rad[0] == eye.acceptance_angle_rad[0]
    assert eye.replace(receptors=[1]).receptor_type.tolist() == [1, 1, 1]
    np.testing.assert_array_equal(eye.replace(up=None).up[0], [0, 1, 0])


def test_new_axes_have_the_up_of_a_new_eye() -> None:
    """Unless one has been set: it is what flow and motion are told in, right and up."""
    eye = omma.eye.generate_eye(200)
    axes = np.roll(eye.axis, 7, axis=0)
    moved = eye.replace(axis=axes)
    np.testing.assert_array_equal(moved.up, np.roll(eye.up, 7, axis=0))
    new = omma.Eye(eye.position_m, axes, eye.acceptance_angle_rad)
    np.testing.assert_array_equal(moved.up, new.up)
    # It comes back to the axes that it had, after any number of changes.
    np.testing.assert_array_equal(moved.replace(axis=eye.axis).up, eye.up)
    # A turning drum's flow is that of the new eye.
    world = omma.World(omma.scene.drum(1.0, 4.0, np.ones((4, 4, 3), np.float32)))
    flows = [
        omma.Renderer(world, one, omma.Fixed(4))
        .ground_truth(np.eye(4), head_velocity=((0, 0, 0), (0, -1, 0)))
        .flow_rad_s
        for one in (moved, new)
    ]
    np.testing.assert_array_equal(*flows)


def test_an_up_that_was_set_is_kept_across_new_axes() -> None:
    eye = omma.eye.generate_eye(50)
    tilted = eye.replace(up=eye.up + 0.1 * eye.right)
    axes = eye.axis + 0.05 * eye.right
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    for one in (tilted.replace(axis=axes), eye.replace(axis=axes, up=tilted.up)):
        across = tilted.up - np.sum(tilted.up * axes, axis=1, keepdims=True) * axes
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        np.testing.assert_allclose(one.up, across, atol=1e-6)  # single precision


def test_taking_by_index_slice_and_mask() -> None:
    eye = full_eye()
    same(eye.take(slice(None, None, 2)), eye.take([0, 2]))
    same(eye.take(slice(-1, None)), eye.take([2]))
    same(eye.take([2, 0]), eye.take([0, 2]).take([1, 0]))
    same(eye.take([True, False, True]), eye.take([0, 2]))
    assert eye.select(1).columns["region"] == ["ç"]
    with pytest.raises(omma.Error, match="expected ommatidia from 0 to 2, found 3"):
        eye.take([3])
    with pytest.raises(omma.Error, match=r"a mask: expected shape \(3,\), found \(2,\)"):
        eye.take([True, False])
    for nothing in ([], slice(3, None)):
        with pytest.raises(omma.Error, match="ommatidia: expected at least one, found none"):
            eye.take(nothing)
    with pytest.raises(omma.Error, match=r"ommatidia: .* beyond the range of int32"):
        eye.take([1 << 32])


def test_merging_keeps_all() -> None:
    eye = full_eye()
    pair = omma.eye.merge_eyes([eye, (eye, np.diag([-1.0, 1, 1, 1]))])
    same(pair.select(0), eye.replace(eye_id=0), but=("path", "acceptances", "acceptance_of"))
    assert pair.acceptance(3).major_angle_rad == -0.3
    assert pair.columns["region"] == ["a", "b", "ç"] * 2


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"up": [[0, 0, 1]] * 3}, "ommatidium 0: the up vector must not be along the axis"),
        ({"up": [[0, 1, 0]]}, r"up: expected.*\(3, 3\), found shape \(1, 3\)"),
        ({"facet_diameter_m": -1.0}, "facet diameter must be finite and not negative"),
        ({"acceptance": [ELLIPSE]}, r"as many as there are ommatidia \(3\), found 1"),
        ({"acceptance": "airy"}, "acceptance: expected an omma.Acceptance or None, found str"),
        ({"acceptance": [1, 2, 3]}, r"acceptance\[0\]: expected an omma.Acceptance"),
        (
            {"receptor_types": [1]},
            r"receptor_types\[0\]: expected an omma.receptors.ReceptorType, found int",
        ),
        ({"receptors": [2]}, "receptor_type must be from 0"),
        ({"receptors": [[0], [1]]}, r"a list for each ommatidium \(3\), found 2"),
        ({"columns": [1, 2]}, "columns: expected a dictionary"),
        ({"columns": {"a": [1, 2]}}, r"columns\['a'\]: expected.*\(3,\), found shape \(2,\)"),
        ({"columns": {"a": ["x", 2, 3]}}, r"columns\['a'\]: expected texts alone, found int"),
    ],
)
def test_what_is_wrong_is_named(changes: dict[str, object], message: str) -> None:
    with pytest.raises(omma.Error, match=message):
        full_eye().replace(**changes)


def test_unknown_properties_are_refused() -> None:
    with pytest.raises(TypeError, match="has no property 'facets'"):
        full_eye().replace(facets=3)
    with pytest.raises(omma.Error, match="acceptance_angle_rad or acceptance, found neither"):
        omma.Eye([[0, 0, 0]], [[0, 0, -1]])


def test_acceptances_know_their_parameters() -> None:
    assert (ELLIPSE.kernel, ELLIPSE.minor_width_rad, ELLIPSE.is_round) == ("gaussian", 0.01, False)
    assert (LENS.kernel, LENS.model, LENS.rhabdom_index) == ("lens_rhabdom", "waveguide", 1.363)
    assert ELLIPSE.width_rad(0.3) == pytest.approx(0.04)
    assert ELLIPSE.width_rad(0.3 + math.pi / 2) == pytest.approx(0.01)
    assert ELLIPSE != omma.Acceptance.gaussian(0.04, 0.01, 0.4)
    profile = omma.Acceptance.table([0, 0.02], [2, 0])
    assert profile == omma.Acceptance.table([0, 0.02], [2, 0])
    assert profile != omma.Acceptance.table([0, 0.02], [2, 1])
    assert profile.table_sensitivity == [1, 0]
    with pytest.raises(omma.Error, match="model: expected one of waveguide"):
        omma.Acceptance.lens_rhabdom(20e-6, 50e-6, 2e-6, 500, model="ray")
    with pytest.raises(omma.Error, match="minor_width_rad"):
        omma.Acceptance.gaussian(0.01, 0.04)


def test_acceptances_are_functions_of_arrays() -> None:
    theta = np.linspace(0, 0.05, 6)[:, None]
    azimuth = np.array([0.3, 0.3 + math.pi / 2])
    values = ELLIPSE.eval(theta, azimuth)
    assert values.shape == (6, 2)
    expected = np.exp(-4 * math.log(2) * (theta / np.array([0.04, 0.01])) ** 2)
    np.testing.assert_allclose(values, expected, rtol=1e-12)
    assert ELLIPSE.eval(0.0) == 1.0
    directions = ELLIPSE.sample(20_000, seed=1)
    assert directions.dtype == np.float32
    assert directions.shape == (20_000, 3)
    # Spread along the major axis: FWHM 0.04 is a standard deviation of 0.017, which 20,000
    # directions tell to 0.5 %; four times that.
    along = directions[:, 0] * math.cos(0.3) + directions[:, 1] * math.sin(0.3)
    assert np.std(along) == pytest.approx(0.04 / 2.35482, rel=0.02)
    across = directions[:, 1] * math.cos(0.3) - directions[:, 0] * math.sin(0.3)
    assert np.std(across) == pytest.approx(0.01 / 2.35482, rel=0.02)
    # Each direction of a Gaussian has the transfer of its own width.
    frequency = np.array([5.0, 20.0])
    np.testing.assert_allclose(
        ELLIPSE.mtf(frequency, 0.3), np.exp(-3.5597 * (0.04 * frequency) ** 2), atol=2e-3
    )


def test_receptor_types_check_themselves() -> None:
    with pytest.raises(omma.Error, match=r"'green'\): peak_wavelength_nm: expected 300 to 800 nm"):
        omma.receptors.ReceptorType("green", peak_wavelength_nm=54)
    with pytest.raises(omma.Error, match="a peak wavelength or a table of sensitivities"):
        omma.receptors.ReceptorType(
            "x", peak_wavelength_nm=540, wavelength_nm=[1, 2], sensitivity=[1, 2]
        )
    table = omma.receptors.ReceptorType("x", wavelength_nm=[400, 500, 600], sensitivity=[0, 4, 2])
    assert table.sensitivity == [0, 1, 0.5]
    assert table != ULTRAVIOLET
    assert ULTRAVIOLET.acceptance is None


def test_renders_use_each_ommatidiums_own_sensitivity() -> None:
    bright = np.zeros((64, 4096, 3), np.float32)
    bright[:, 2048 - 114 : 2048 + 114] = 1  # 20 degrees wide, ahead
    scene = omma.load_scene(EXAMPLES / "meadow.glb")
    image = omma.Background.image(bright)
    eye = omma.Eye(np.zeros((3, 3)), [[0, 0, -1]] * 3, math.radians(40),
                   acceptance=[None, omma.Acceptance.pillbox(math.radians(10)), None])  # fmt: skip
    far = np.diag([1.0, 1, 1, 1])
    far[1, 3] = 1000  # above the meadow, which fills less than the lower half
    own = omma.Renderer(scene, eye, omma.Fixed(256), background=image).render(far[None])[0, :, 0]
    plain = omma.Renderer(
        scene, eye, omma.Fixed(256), background=image, angular_sensitivity="gaussian"
    )
    assert own[1] == pytest.approx(1, abs=1e-3)
    assert own[0] < 0.9
    assert plain.render(far[None])[0, 0, 0] == pytest.approx(own[0], abs=1e-6)
    assert plain.settings.angular_sensitivity == "gaussian"
