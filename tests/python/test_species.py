"""The animals of omma.species against their table, and the table against its sources."""

import csv
import io
import math
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from conftest import load_script
from scipy.spatial import cKDTree
from typer.testing import CliRunner

import omma
from omma.cli.main import app
from omma.eye.measures import measure_eye
from omma.species.facts import STATUSES, number

ROOT = Path(__file__).resolve().parents[2]
animal = cache(omma.species.make)


def right(name):
    return animal(name).eye.select(1)


@cache
def measures(name):
    return measure_eye(right(name))


def angles_deg(name):
    """Mean angle to the six nearest axes, right eye."""
    return np.degrees(right(name).interommatidial_angle_rad())


@cache
def along_and_up_deg(name):
    """Interommatidial angles along circles of latitude and up, each (N,), from the six neighbours
    on the surface: in a hexagonal lattice, stretched or not, the mean square of their steps either
    way is half the angle's square."""
    eye = right(name)
    azimuth, elevation = omma.eye.azimuth_elevation_deg_of(eye.axis)
    near = cKDTree(eye.position_m).query(eye.position_m, 7)[1]
    across = (azimuth[near[:, 1:]] - azimuth[:, None] + 180) % 360 - 180
    across *= np.cos(np.radians(elevation))[:, None]
    up = elevation[near[:, 1:]] - elevation[:, None]
    return tuple(np.sqrt(2 * np.mean(step**2, axis=1)) for step in (across, up))


def test_every_number_says_where_it_is_from():
    table = omma.species.facts()
    assert len({(fact.animal, fact.quantity) for fact in table}) == len(table)
    for fact in table:
        assert fact.status in STATUSES, fact
        assert math.isfinite(fact.value), fact
        assert fact.source.citation, fact
        # What nobody was read on is an assumption, and so is what is ours and not worked out.
        if fact.source.key == "recalled":
            assert fact.status == "assumed", fact
        if fact.source.key == "omma":
            assert fact.status != "measured", fact
    text = (ROOT / "python/omma/species/facts.csv").read_text()
    assert {len(row) for row in csv.reader(io.StringIO(text))} == {7}  # commas in notes are quoted
    assert {fact.source for fact in table} == set(omma.species.sources())


# Numbers as their sources print them, written down a second time: a slip in the table shows here.
@pytest.mark.parametrize(
    ("name", "quantity", "value", "status"),
    [
        ("honeybee_worker", "ommatidia", 5432, "measured"),
        ("honeybee_worker", "focal_length", 66e-6, "measured"),
        ("honeybee_worker", "largest_facet_diameter", 20e-6, "measured"),
        ("honeybee_worker", "type_2_fraction", 0.46, "measured"),
        ("honeybee_worker", "green_peak", 544, "measured"),
        ("bumblebee", "uv_peak", 353, "measured"),
        ("bumblebee", "green_integration_time", 7.9e-3, "measured"),
        ("bumblebee", "blue_integration_time", 9.8e-3, "measured"),
        ("bumblebee", "ultraviolet_integration_time", 12.3e-3, "measured"),
        ("drosophila", "ommatidia", 857, "measured"),
        ("drosophila", "rh6_peak", 508, "measured"),
        ("calliphora", "f_number", 2.2, "measured"),
        ("holcocephala", "least_interommatidial_angle", math.radians(0.28), "measured"),
        ("holcocephala", "largest_facet_diameter", 78e-6, "measured"),
        ("cataglyphis", "dorsal_rim_ommatidia", 80, "measured"),
        ("cataglyphis", "dorsal_rim_acceptance_angle", math.radians(5.4), "measured"),
        ("cataglyphis", "dorsal_rim_uv_ps", 6.3, "measured"),
        ("melophorus", "lens_blur", math.radians(2.3), "measured"),
        ("dragonfly", "least_interommatidial_angle", math.radians(0.24), "measured"),
        ("megalopta", "sensitivity_ratio", 27, "measured"),
        ("megalopta", "facet_diameter", 36e-6, "assumed"),
    ],
)
def test_the_table_holds_what_sources_print(name, quantity, value, status):
    fact = next(f for f in omma.species.facts(name) if f.quantity == quantity)
    assert fact.si == pytest.approx(value, rel=1e-12)
    assert fact.status == status


def test_numbers_worked_out_from_others():
    # Snyder's rule on Melophorus' two parts; 78 µm over 0.28°; a cap of a thousandth of the sphere;
    # 8 % lost to a disc of 0.41° in a Gaussian: 1 - 2^-(0.41/Δρ)². Each to the digits printed.
    parts = number("melophorus", "rhabdom_acceptance_angle"), number("melophorus", "lens_blur")
    assert math.hypot(*parts) == pytest.approx(number("melophorus", "acceptance_angle"), rel=0.01)
    radius = 78e-6 / math.radians(0.28)
    assert radius == pytest.approx(number("holcocephala", "front_radius_of_curvature"), rel=0.01)
    cap = math.acos(1 - 2 * 0.001)
    assert cap == pytest.approx(number("holcocephala", "fovea_half_width"), rel=0.01)
    width = 0.41 / math.sqrt(-math.log2(1 - 0.08))
    assert width == pytest.approx(
        math.degrees(number("honeybee_drone", "dorsal_acceptance_angle")), rel=0.01
    )


@pytest.mark.parametrize("name", omma.species.names())
def test_a_head_is_whole(name):
    species = animal(name)
    eye = species.eye
    assert set(np.unique(eye.eye_id)) == {0, 1}
    assert (eye.position_m[eye.eye_id == 1, 0] > 0).all()
    assert (eye.position_m[eye.eye_id == 0, 0] < 0).all()
    # Micrometres and degrees, not millimetres and radians.
    assert 5e-6 < eye.facet_diameter_m.min()
    assert eye.facet_diameter_m.max() < 100e-6
    assert np.radians(0.2) < eye.acceptance_angle_rad.min()
    assert eye.acceptance_angle_rad.max() < np.radians(7)
    assert len(eye.columns["region"]) == len(eye)
    if name != "holcocephala":
        assert (np.diff(eye.first_receptor) > 0).all()
    assert species.facts
    assert species.sources
    # As many in each eye as the table says, within 1 %.
    counts = np.bincount(eye.eye_id)
    assert counts[1] == pytest.approx(species.fact("ommatidia").value, rel=0.01)
    if name != "drosophila":
        left, mine = eye.select(0), eye.select(1)
        np.testing.assert_allclose(left.axis * [-1, 1, 1], mine.axis, atol=1e-6)


def test_honeybee_directions_are_those_of_the_example():
    make_honeybee = load_script(ROOT / "examples" / "make_honeybee.py")
    axes = []
    for count, (row, elevation) in enumerate(make_honeybee.row_elevations_deg()):
        azimuths = make_honeybee.row_azimuths_deg(row, elevation)
        axes += [(a, elevation) for a in (azimuths[::-1] if count % 2 else azimuths)]
    azimuth, elevation = np.array(axes).T
    ours = right("honeybee_worker")
    # Single precision, and the example's file rounds to a nanometre.
    np.testing.assert_allclose(ours.axis, omma.eye.direction(azimuth, elevation), atol=2e-7)
    bundled = omma.load_eye(ROOT / "examples/honeybee_worker_right.eye")
    np.testing.assert_allclose(ours.position_m, bundled.position_m, atol=2e-9)
    np.testing.assert_allclose(ours.acceptance_angle_rad, bundled.acceptance_angle_rad, rtol=1e-6)


def test_honeybee_median_angle():
    # The number and its tolerance.
    assert np.median(angles_deg("honeybee_worker")) == pytest.approx(2.25, rel=0.03)


def test_honeybee_facets_are_as_the_table_owns_up():
    facets = right("honeybee_worker").facet_diameter_m
    assert np.median(facets) == pytest.approx(
        number("honeybee_worker", "model_facet_diameter"), 0.01
    )
    # "15 to 31 µm": to the digits printed.
    assert [round(float(d) * 1e6) for d in (facets.min(), facets.max())] == [15, 31]


def test_honeybee_ommatidia_are_of_three_types():
    eye = right("honeybee_worker")
    known = omma.receptors.honeybee_ommatidia()
    assert eye.receptor_types == list(known[0].receptors[:3])
    assert [t.name for t in eye.receptor_types] == ["ultraviolet", "blue", "green"]
    kinds, counts = np.unique(eye.columns["ommatidium_type"], return_counts=True)
    # Drawn by chance: standard deviation 0.7 % of 5,380.
    fraction = dict(zip(kinds, counts / len(eye), strict=True))
    assert fraction == pytest.approx({"I": 0.44, "II": 0.46, "III": 0.10}, abs=0.02)
    assert (np.diff(eye.first_receptor) == 8).all()


def test_robber_fly_fovea():
    eye = right("holcocephala")
    angle, spacing = angles_deg("holcocephala"), omma.eye.facet_diameters_m(eye)
    # The numbers within 3 %, both of the lattice itself.
    assert angle.min() == pytest.approx(0.28, rel=0.03)
    ahead = eye.axis[:, 2] < -math.cos(math.radians(1))
    assert np.median(spacing[ahead]) == pytest.approx(78e-6, rel=0.03)
    assert eye.facet_diameter_m.max() == pytest.approx(78e-6, rel=0.03)
    assert np.median(spacing) == pytest.approx(20e-6, rel=0.03)
    # Several degrees elsewhere.
    away = eye.axis[:, 2] > -math.cos(math.radians(40))
    assert np.median(angle[away]) > 2
    # Diffraction: 1.029 λ/D.
    least = np.degrees(eye.acceptance_angle_rad.min())
    assert least == pytest.approx(math.degrees(1.029 * 500e-9 / 78e-6), rel=0.02)
    fovea = np.array(eye.columns["region"]) == "fovea"
    assert 150 < fovea.sum() < 400


def test_cataglyphis_dorsal_rim():
    eye = right("cataglyphis")
    rim = np.array(eye.columns["region"]) == "dorsal rim"
    assert rim.sum() == 80
    azimuth, elevation = omma.eye.azimuth_elevation_deg_of(eye.axis[rim])
    # Duelli's 43 to 65°, a lattice step beyond.
    assert elevation.min() > 43 - 2.7
    assert elevation.max() < 65 + 2.7
    assert azimuth.mean() == pytest.approx(45, abs=3)
    np.testing.assert_allclose(np.degrees(eye.acceptance_angle_rad[rim]), 5.4, rtol=1e-5)
    np.testing.assert_allclose(np.degrees(eye.acceptance_angle_rad[~rim]), 3.0, rtol=1e-5)
    # A lattice's 10 % at the 95th percentile, and the edge, where spacing blends to the outside.
    assert np.median(angles_deg("cataglyphis")[rim]) == pytest.approx(2.64, rel=0.1)
    types, microvilli = eye.receptor_types, omma.receptors.microvillus_direction(eye)
    turns = []
    for i in np.flatnonzero(rim):
        own = range(eye.first_receptor[i], eye.first_receptor[i + 1])
        first, second = (k for k in own if types[eye.receptor_type[k]].peak_wavelength_nm == 350)
        assert abs(microvilli[first] @ microvilli[second]) < 1e-5  # orthogonal
        for k in (first, second):
            assert types[eye.receptor_type[k]].polarisation_sensitivity == 6.3
        level = np.cross([0.0, 1.0, 0.0], eye.axis[i])
        upright = np.cross(eye.axis[i], level)
        turns.append(math.atan2(microvilli[first] @ level, microvilli[first] @ upright) % math.pi)
    # A fan: every direction of the half turn, evenly.
    assert np.diff(np.sort(turns)).max() < math.pi / 80 + 0.02
    assert np.ptp(turns) > math.pi - 0.1
    outside = eye.receptor_type[eye.first_receptor[np.flatnonzero(~rim)[0]]]
    assert types[outside].polarisation_sensitivity == 2.9


def test_regions_are_those_that_the_page_names():
    page = (Path(__file__).resolve().parents[2] / "docs" / "species.md").read_text()
    told = next(line for line in page.split("\n") if line.startswith("**Regions**"))
    for name in omma.species.names():
        found = set(animal(name).eye.columns["region"])
        if found == {"eye"}:
            assert f"`{name}`" not in told
            continue
        before = told.split(f" in `{name}`")[0]
        clause = before.split("`, are ")[-1].split("`, ")[-1]
        assert set(re.findall('"([^"]+)"', clause)) == found, name


def test_drosophila_is_as_scanned():
    eye = animal("drosophila").eye
    assert np.bincount(eye.eye_id).tolist() == [852, 857]
    angle = angles_deg("drosophila")
    # The lattice's own 3 % (median) and 10 % (percentiles).
    assert np.median(angle) == pytest.approx(4.9, rel=0.03)
    assert np.percentile(angle, [5, 95]) == pytest.approx([3.8, 9.5], rel=0.1)
    spacing = omma.eye.facet_diameters_m(eye.select(1))
    assert np.median(spacing) == pytest.approx(16.8e-6, rel=0.03)
    pale = np.mean([kind == "pale" for kind in eye.columns["ommatidium_type"]])
    # By chance: standard deviation 1.1 % of 1,709.
    assert pale == pytest.approx(0.3, abs=0.04)
    peaks = {t.name: t.peak_wavelength_nm for t in eye.receptor_types}
    assert peaks == dict.fromkeys(("R1", "R2", "R3", "R4", "R5", "R6"), 478) | {
        "R7p": 345, "R8p": 437, "R7y": 375, "R8y": 508,
    }  # fmt: skip


@cache
def looking_deg(name):
    """Where R1 to R6 look from their ommatidium's axis, (N, 6), both eyes."""
    eye = animal(name).eye
    own = eye.axis[omma.receptors.ommatidium_of_receptor(eye)]
    chord = np.linalg.norm(omma.receptors.receptor_axis(eye).astype(float) - own, axis=1)
    return np.degrees(2 * np.arcsin(chord / 2)).reshape(len(eye), 8)


@pytest.mark.parametrize("name", ["drosophila", "calliphora"])
def test_fly_receptors_look_along_neighbours_axes(name):
    eye = animal(name).eye
    apart, angle = looking_deg(name), np.degrees(eye.interommatidial_angle_rad())
    # R7 and R8 look ahead; single precision leaves 1e-5 degrees and less.
    np.testing.assert_allclose(apart[:, 6:], 0, atol=1e-4)
    # R1 to R6: one step of the local lattice, R3 being the far corner (sqrt(3) steps) and the
    # others next to R7. The lattice's own unevenness and offsets in tenths of a step: 10 %.
    ratio = np.median(apart[:, :6] / angle[:, None], axis=0)
    assert ratio == pytest.approx([1, 1, math.sqrt(3), 1, 1, 1], rel=0.1)


@pytest.mark.parametrize("name", ["drosophila", "calliphora"])
def test_fly_cartridges_pool_six(name):
    eye = animal(name).eye
    wiring = omma.eye.superposition.neural_superposition_wiring(eye)
    border = np.concatenate([measure_eye(eye.select(side)).border for side in (0, 1)])
    angle = eye.interommatidial_angle_rad().astype(float)
    up = np.abs(np.arcsin(eye.axis[:, 1].astype(float)))
    # The pattern is mirrored at the horizon: R3 reaches 1.7 steps over it.
    away, level = ~border & (up > 2 * angle), ~border & (up < 0.9 * angle)
    members = wiring.members
    # The lattice has dislocations, where its rows end as the angle grows: five or seven there.
    assert np.mean(members[away] == 6) > 0.65
    assert np.mean(np.abs(members[away] - 6) <= 1) > 0.9
    assert np.median(members[level]) in (7, 8)
    # What is pooled looks along the cartridge's axis, all within half Δφ, most within a quarter.
    target = np.repeat(np.arange(len(eye)), members)
    chord = np.linalg.norm(
        omma.receptors.receptor_axis(eye)[wiring.index].astype(float) - eye.axis[target], axis=1
    )
    beside = 2 * np.arcsin(chord / 2) / angle[target]
    inner = ~border[target]
    assert beside.max() <= 0.5
    assert np.median(beside[inner]) < 0.1
    assert np.percentile(beside[inner], 95) < 0.25


def test_left_fly_receptors_mirror_the_right():
    eye = animal("calliphora").eye
    left, right_eye = eye.select(0), eye.select(1)
    mirrored = omma.receptors.receptor_axis(left) * [-1, 1, 1]
    np.testing.assert_allclose(mirrored, omma.receptors.receptor_axis(right_eye), atol=1e-6)
    types = [[one.name for one in e.receptor_types] for e in (left, right_eye)]
    names = [np.array(known)[e.receptor_type] for known, e in zip(types, (left, right_eye))]
    assert (names[0] == names[1]).all()
    # R3 looks to the outside of the eye: a lens inverts, and R3 lies in front and above.
    third = omma.receptors.receptor_axis(right_eye)[2::8] - right_eye.axis
    middle = right_eye.axis[:, 0] > 0.8
    assert np.mean(third[middle, 2] > 0) > 0.95  # behind the axis: +Z


def test_fly_receptors_are_rendered():
    eye = right("drosophila")
    renderer = omma.Renderer(
        omma.Scene(), eye, omma.Fixed(4), background=omma.Background.constant((1, 1, 1))
    )
    seen = renderer.render_receptors(np.eye(4))
    assert seen.shape == (1, 8 * len(eye))
    wiring = omma.eye.superposition.neural_superposition_wiring(eye)
    pooled = omma.eye.superposition.pool(seen, wiring)
    assert pooled.shape == (1, len(eye))
    # All R1 to R6 have one pigment and see the same white.
    np.testing.assert_allclose(pooled[:, wiring.members > 0], seen[0, 0], rtol=1e-5)


def test_bumblebee_is_as_scanned():
    m, eye = measures("bumblebee"), right("bumblebee")
    angle = np.degrees(m.interommatidial_rad)
    found = np.nanpercentile(angle, [5, 50, 95])
    assert found == pytest.approx([0.95, 1.37, 2.78], rel=0.1)
    assert np.nanmedian(m.horizontal_rad / m.vertical_rad) == pytest.approx(1.28, rel=0.05)
    assert np.median(omma.eye.facet_diameters_m(eye)) == pytest.approx(27.3e-6, rel=0.03)
    # The ellipsoid is an assumption; that it comes out as large as the scan is not.
    assert np.ptp(eye.position_m[:, 1]) == pytest.approx(2.91e-3, rel=0.1)
    assert np.ptp(eye.position_m[:, 2]) == pytest.approx(0.85e-3, rel=0.1)


def test_bumblebee_numbers_are_the_scans():
    path = ROOT.parent / "shared/data/compound-ray/bees/BT_77967-real.eye"
    if not path.exists():
        pytest.skip("needs the eyes of CompoundRay in ../shared/data")
    head = omma.load_eye(path)
    mine = head.take(np.flatnonzero(head.position_m[:, 0] > 0))
    assert len(mine) == number("bumblebee", "ommatidia")
    m = measure_eye(mine)
    found = np.degrees(np.nanpercentile(m.interommatidial_rad, [5, 50, 95]))
    # Who counts as a neighbour at the edge of the field moves the percentiles by 2 %.
    assert found == pytest.approx([0.95, 1.37, 2.78], rel=0.03)
    assert np.nanmedian(m.horizontal_rad / m.vertical_rad) == pytest.approx(1.28, rel=0.03)


def test_drone_is_divided():
    eye = right("honeybee_drone")
    above = np.array(eye.columns["region"]) == "dorsal"
    angle = angles_deg("honeybee_drone")
    up = np.degrees(np.arcsin(eye.axis[:, 1]))
    assert np.median(angle[up > 45]) == pytest.approx(1.1, rel=0.03)
    assert np.median(angle[up < -10]) == pytest.approx(2.25, rel=0.03)
    np.testing.assert_allclose(eye.facet_diameter_m[up > 46], 35e-6, rtol=1e-5)
    np.testing.assert_allclose(eye.facet_diameter_m[up < -6], 20e-6, rtol=1e-5)
    # The surface they sit on follows roughly: a worker's facet on twice the area at most. Found are
    # 31.39 um with AVX2 and 31.53 without: where the relaxation ends depends on rounding, by about
    # half a hundredth. So 12 %, where 10 % (31.5 um) was met or not by the processor.
    spacing = omma.eye.facet_diameters_m(eye)
    assert np.median(spacing[above]) == pytest.approx(35e-6, rel=0.12)
    green = [i for i, t in enumerate(eye.receptor_types) if t.name == "green"]
    has_green = np.add.reduceat(np.isin(eye.receptor_type, green), eye.first_receptor[:-1]) > 0
    assert not has_green[above].any()
    assert has_green[~above].all()


def test_calliphora_acceptance_is_near_what_is_measured():
    eye = right("calliphora")
    at_25 = np.abs(eye.facet_diameter_m / 25e-6 - 1) < 0.03
    # Computed from lens and rhabdomere; measured 1.0 to 1.24°.
    assert 1.0 < np.degrees(np.median(eye.acceptance_angle_rad[at_25])) < 1.35
    pale = np.mean([kind == "pale" for kind in eye.columns["ommatidium_type"]])
    assert pale == pytest.approx(0.4, abs=0.03)


def test_melophorus_mean_angle_and_field():
    eye = right("melophorus")
    inner = ~measures("melophorus").border
    assert angles_deg("melophorus")[inner].mean() == pytest.approx(3.7, rel=0.03)
    azimuth = omma.eye.azimuth_elevation_deg_of(eye.axis)[0]
    # Axes end up to one interommatidial angle inside the field of about 150°.
    assert 150 - 2 * 3.7 < np.ptp(azimuth) <= 150
    np.testing.assert_allclose(np.degrees(eye.acceptance_angle_rad), 3.7, rtol=1e-5)


def test_dragonfly_dorsal_band():
    eye = right("dragonfly")
    # Half way up the side the band's breadth is level: the angle across it is the horizontal one.
    across, along = along_and_up_deg("dragonfly")
    elevation = omma.eye.azimuth_elevation_deg_of(eye.axis)[1]
    crest = (np.abs(eye.axis[:, 2]) < math.sin(math.radians(1))) & (np.abs(elevation - 45) < 15)
    assert crest.sum() > 100
    # The lattice's 3 %; its scatter of up to 10 % adds up to 1 % in a mean square.
    assert np.median(across[crest]) == pytest.approx(0.24, rel=0.04)
    assert np.median(along[crest]) > 4 * np.median(across[crest])
    # Large facets cover about a third of the surface.
    area = eye.facet_diameter_m.astype(float) ** 2
    large = eye.facet_diameter_m > 50e-6
    assert area[large].sum() / area.sum() == pytest.approx(1 / 3, abs=0.03)
    assert eye.facet_diameter_m.max() == pytest.approx(62e-6, rel=0.01)


def test_fiddler_crab_has_two_streaks():
    eye = right("fiddler_crab")
    horizontal, vertical = along_and_up_deg("fiddler_crab")
    up = np.degrees(np.arcsin(eye.axis[:, 1].astype(float)))

    def vertical_deg(low, high):
        return np.median(vertical[(up > low) & (up < high)])

    # The lattice's 3 %, and that it smooths what changes within a few rows.
    assert vertical_deg(2.5, 4.5) == pytest.approx(0.56, rel=0.06)
    assert vertical_deg(-4.5, -2.5) == pytest.approx(0.56, rel=0.06)
    assert vertical_deg(-0.5, 0.5) == pytest.approx(0.66, rel=0.06)
    assert vertical_deg(15, 20) > vertical_deg(-20, -15) > 0.7
    assert vertical_deg(30, 60) == pytest.approx(4.0, rel=0.06)
    level = np.abs(up) < 5
    assert np.median(horizontal[level]) == pytest.approx(2.2, rel=0.06)
    # Larger facets at the equator, and the lenses that far apart.
    spacing = omma.eye.facet_diameters_m(eye)
    assert np.median(spacing[level]) == pytest.approx(25e-6, rel=0.05)
    assert np.median(spacing[up > 30]) == pytest.approx(18e-6, rel=0.05)
    azimuth = omma.eye.azimuth_elevation_deg_of(eye.axis)[0]
    assert np.bincount((azimuth // 30).astype(int) + 6).min() > 800  # all round


def test_a_bright_world_is_1_for_every_kernel():
    # Airy patterns of the fovea and its surround, waveguides, Gaussians.
    for name in ("holcocephala", "calliphora"):
        renderer = omma.Renderer(
            omma.Scene(),
            right(name),
            omma.Fixed(16),
            background=omma.Background.constant((1, 1, 1)),
        )
        np.testing.assert_allclose(renderer.render(np.eye(4)), 1, rtol=1e-5)


def test_unknown_names():
    with pytest.raises(
        omma.Error, match=r"expected one of honeybee_worker.*generate_eye.*found .bee."
    ):
        omma.species.make("bee")
    with pytest.raises(omma.Error, match=r"generate_eye makes an eye of another .*found 'locust'"):
        omma.species.facts("locust")
    with pytest.raises(omma.Error, match="found 'wings'"):
        animal("honeybee_worker").fact("wings")


def test_command(tmp_path):
    run = CliRunner().invoke
    lines = run(app, ["eye", "species"]).output.splitlines()
    assert lines[:-1] == omma.species.names()
    assert lines[-1] == "megalopta (numbers only: too few are known for its eyes)"
    shown = run(app, ["eye", "species", "holcocephala"])
    assert shown.exit_code == 0
    assert "0.28°" in shown.output
    assert "assumed" in shown.output
    out, table = tmp_path / "bee.csv", tmp_path / "facts.csv"
    made = run(app, ["eye", "species", "honeybee_worker", "-o", str(out)])
    assert made.exit_code == 0, made.output
    again, ours = omma.load_eye(out), animal("honeybee_worker").eye
    assert np.array_equal(again.axis, ours.axis)
    assert np.array_equal(again.receptor_type, ours.receptor_type)
    assert again.columns["region"] == ours.columns["region"]
    assert run(app, ["eye", "species", "--facts", str(table)]).exit_code == 0
    rows = list(csv.DictReader(io.StringIO(table.read_text())))
    assert len(rows) == len(omma.species.facts())
    assert rows[0]["source"].startswith("Somanathan")
    for wrong in (["bee"], ["bee", "-o", str(out)], ["--facts", str(tmp_path / "x.txt")]):
        assert run(app, ["eye", "species", *wrong]).exit_code != 0


def test_command_takes_numbers_from_other_animals(tmp_path):
    out = tmp_path / "fly.csv"
    made = CliRunner().invoke(
        app,
        ["eye", "species", "holcocephala", "--assume", "calliphora", "--assume", "honeybee"]
        + ["-o", str(out)],
    )  # fmt: skip
    assert made.exit_code == 0, made.output
    ours = omma.species.holcocephala(assume=("calliphora", "honeybee"))
    for sentence in ours.assumed:
        assert f"assumed: {sentence}" in made.output
    lengths = {one.length_m for one in omma.load_eye(out).receptor_types}
    assert lengths == {one.length_m for one in ours.eye.receptor_types}
    assert lengths == {250e-6}  # of the first that has one


def test_the_site_has_every_number(monkeypatch):
    pytest.importorskip("PIL")
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    from site_species import species_pages

    written = (ROOT / "docs" / "species.md").read_text(encoding="utf-8")
    pages = species_pages(written)
    for name in omma.species.names():
        assert omma.species.facts_text(name) in pages[f"species/{name}.md"]
        assert f"| `{name}` | {len(omma.species.make(name).eye):,} |" in written
    assert omma.species.facts_text("megalopta") in pages["species.md"]
    for source in omma.species.sources():
        assert source.citation in pages["species.md"]
