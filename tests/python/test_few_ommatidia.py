"""Measures of eyes of a few ommatidia, whose cells are as large as what they do not see."""

import numpy as np
import pytest

import omma
from omma.cli.eye_look import _field_lines
from omma.eye.measures import measure_eye
from omma.picture.eye_maps import make_map


def on_sphere(directions):
    """An eye of 1 mm that looks along its radii."""
    return omma.Eye(1e-3 * directions, directions, 0.02)


def three_apart():
    """Three ommatidia 117° apart, which look sideways and a little ahead."""
    around, out = np.radians([90, 210, 330]), np.radians(80)
    ahead = np.full(3, -np.cos(out))
    return on_sphere(np.column_stack([np.sin(out) * np.cos(around), np.sin(out) * np.sin(around),
                                      ahead]))  # fmt: skip


def test_what_few_ommatidia_do_not_see_is_no_gap_between_them(tmp_path, run_omma):
    """Though it is smaller than their cells: in numbers, as blind zones, and on maps."""
    eye = three_apart()
    found = measure_eye(eye)
    field = found.field
    assert field.blind_sr < np.sqrt(3) / 2 * found.interommatidial_rad.max() ** 2
    listed = sum(zone.solid_angle_sr for zone in field.blind_zones)
    assert listed == pytest.approx(field.blind_sr, rel=0.05)
    shown = make_map(found, "mollweide", 400).ommatidium
    hatched = 4 * np.pi * (shown == -1).sum() / (shown != -2).sum()
    assert hatched == pytest.approx(field.blind_sr, rel=0.02)
    omma.save_eye(tmp_path / "three.csv", eye)
    out = run_omma("eye", "info", str(tmp_path / "three.csv"))[1]
    assert f"blind        {field.blind_zones[0].solid_angle_sr:.3g} sr; a cone of" in out


@pytest.mark.parametrize("count", [3, 4, 5])
def test_ellipses_are_not_told_of_so_few_that_none_are_flat(count):
    """They had a mean angle of 118° between 14° and 98°."""
    around = 2 * np.pi * np.arange(count) / count
    axes = np.column_stack([np.cos(around), np.sin(around), np.full(count, -0.4)])
    found = measure_eye(on_sphere(axes / np.linalg.norm(axes, axis=1, keepdims=True)))
    assert (found.surface_angle_rad > np.pi / 3).all()
    for name in ("smaller_rad", "larger_rad", "horizontal_rad", "vertical_rad"):
        assert np.isnan(getattr(found, name)).all()


@pytest.mark.parametrize(
    ("blind_sr", "zones", "words"),
    [
        (0.0, [], ["nowhere"]),
        (0.02, [], ["nowhere"]),  # as near as the field is known
        (0.5, [], ["0.5 sr that no ommatidium sees, in pieces smaller than an ommatidium's cell"]),
        (0.5, [0.4], ["0.4 sr; a cone", "0.1 sr that no ommatidium sees"]),
        (0.5, [0.3, 0.2], ["0.3 sr; a cone", "0.2 sr; a cone"]),
    ],
)
def test_what_no_ommatidium_sees_is_told_in_large_and_small_pieces(blind_sr, zones, words):
    about = {"azimuth_deg": 0.0, "elevation_deg": 0.0, "radius_deg": 1.0}
    summary = {
        "eyes": {"0": 9}, "seen_sr": 12.0, "binocular_sr": 0.0, "blind_sr": blind_sr,
        "blind_zones": [{"solid_angle_sr": zone, **about} for zone in zones],
    }  # fmt: skip
    lines = _field_lines(summary)[2:]
    assert [name for name, _ in lines] == ["blind", *[""] * (len(words) - 1)]
    for (_, told), expected in zip(lines, words, strict=True):
        assert told.startswith(expected)
