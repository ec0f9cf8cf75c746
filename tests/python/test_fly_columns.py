"""The measured fly: its axes beside the published ones, its columns by their names, what is read
from files of the published form, and what is refused."""

import csv
from collections import Counter

import numpy as np
import pytest

import omma

STEPS = [(1, 0), (0, 1), (1, 1), (-1, 0), (0, -1), (-1, -1)]
# Rows of left.csv and right.csv of github.com/artxz/eyemap-archive, eyemap_mcns_f20240701, typed
# off by hand: side, p, q, x, y, z, theta, phi.
PUBLISHED = [
    (1, 0, 0, 0.53428, -0.837063, 0.117773, 83.2364, 57.4507),
    (1, -18, -12, 0.404185, 0.002281, -0.914675, 156.1595, -0.3233),
    (1, 19, 12, -0.425072, -0.033085, 0.904555, 25.2366, 175.5494),
    (1, 12, -5, -0.87296, -0.468167, 0.136967, 82.1276, 151.7954),
    (1, 4, 16, 0.737916, 0.06754, 0.671504, 47.8167, -5.2296),
    (-1, 0, 0, 0.551189, 0.827891, 0.103861, 84.0385, -56.3453),
    (-1, -14, -16, 0.140781, 0.230085, -0.962934, 164.3514, -58.5389),
    (-1, 18, 16, -0.070883, -0.036041, 0.996833, 4.561, 153.0488),
    (-1, 13, -4, -0.863723, 0.471843, 0.177049, 79.8021, -151.3527),
    (-1, -3, 13, 0.955175, -0.088578, 0.282478, 73.5918, 5.2982),
]
# Half of the last digits printed, and the turn from degrees.
XYZ_ROUNDING, ANGLE_ROUNDING_DEG = 0.5e-6, 0.5e-4


@pytest.fixture(scope="module")
def columns():
    return omma.columns.fly_columns()


def keys_of(columns):
    return list(zip(columns.side.tolist(), columns.p.tolist(), columns.q.tolist()))


def neighbour_table(columns):
    """(M, 6), -1 where there is none."""
    row = {key: k for k, key in enumerate(keys_of(columns))}
    return np.array(
        [[row.get((side, p + a, q + b), -1) for a, b in STEPS] for side, p, q in keys_of(columns)]
    )


def angles_deg(one, other):
    return np.degrees(2 * np.arcsin(np.linalg.norm(one - other, axis=-1) / 2))


def test_every_column_is_there_once(columns):
    assert Counter(columns.side.tolist()) == {-1: 850, 1: 846}
    assert len(set(keys_of(columns))) == len(columns)
    names = omma.columns.malecns_names(columns)
    assert len(set(names)) == len(names)
    assert omma.species.measured_drosophila().eye.columns["medulla_column"] == names


@pytest.mark.parametrize(("side", "p", "q", "x", "y", "z", "theta", "phi"), PUBLISHED)
def test_axes_are_the_published_ones(columns, side, p, q, x, y, z, theta, phi):
    k = keys_of(columns).index((side, p, q))
    right, up, back = columns.axis[k]
    # As printed, but for the length, which rounding moves by as much.
    assert (-back, -right, up) == pytest.approx((x, y, z), abs=2 * XYZ_ROUNDING)
    assert np.degrees(np.arccos(up)) == pytest.approx(
        theta, abs=ANGLE_ROUNDING_DEG + np.degrees(2 * XYZ_ROUNDING / np.hypot(x, y))
    )
    assert np.degrees(np.arctan2(right, -back)) == pytest.approx(
        phi, abs=ANGLE_ROUNDING_DEG + np.degrees(2 * XYZ_ROUNDING / np.hypot(x, y))
    )
    # The eye holds them in single precision.
    eye = omma.species.measured_drosophila().eye
    assert eye.axis[k] == pytest.approx(columns.axis[k], abs=6e-8)


def test_neighbours_are_neighbours(columns):
    table = neighbour_table(columns)
    inner = (table >= 0).all(axis=1)
    assert inner.sum() == 741 + 745
    # Six, but at the rim: whoever has fewer can be reached from outside along columns that are
    # not there, so the lattice has no holes.
    for side in (-1, 1):
        there = {(p, q) for s, p, q in keys_of(columns) if s == side}
        outside, queue = {(-25, -25)}, [(-25, -25)]
        while queue:
            p, q = queue.pop()
            for a, b in STEPS:
                one = (p + a, q + b)
                if max(map(abs, one)) <= 25 and one not in there and one not in outside:
                    outside.add(one)
                    queue.append(one)
        assert len(outside) == 51 * 51 - len(there)
    # Neighbours look 2 to 12 degrees apart; those two steps away, on a line, look further.
    apart = angles_deg(columns.axis[table[inner]], columns.axis[inner][:, None])
    assert 1.5 < apart.min() < apart.max() < 12
    for a, b in ((0, 3), (1, 4), (2, 5)):
        across = angles_deg(columns.axis[table[inner][:, a]], columns.axis[table[inner][:, b]])
        assert (across > 1.2 * np.maximum(apart[:, a], apart[:, b])).all()


def test_rows_lead_where_their_names_say(columns):
    """p + q up, q - p to the front: in both eyes, and on every row of the eye's middle."""
    azimuth, elevation = omma.eye.azimuth_elevation_deg_of(columns.axis)
    for side in (-1, 1):
        mine = columns.side == side
        up, front = (columns.p + columns.q)[mine], (columns.q - columns.p)[mine]
        assert np.corrcoef(up, elevation[mine])[0, 1] > 0.97
        level = np.abs(elevation[mine]) < 40
        assert np.corrcoef(front[level], side * azimuth[mine][level])[0, 1] < -0.97
    # The equator of the lattice is that of the head, to the row that is in doubt.
    row = columns.p + columns.q
    assert abs(elevation[(row == 0) | (row == -1)].mean()) < 4


def test_the_field_is_that_of_the_paper(columns):
    """Zhao et al. 2025: to below 10° into the other half in front and about 155° behind, along the
    equator, from straight up to -70°; least between facets in front, near the equator."""
    azimuth, elevation = omma.eye.azimuth_elevation_deg_of(columns.axis)
    level, lateral = np.abs(elevation) < 30, azimuth * columns.side
    for side in (-1, 1):
        mine = columns.side == side
        assert -10 < lateral[mine & level].min() < -5
        # The map lacks the outermost columns, 3° a row.
        assert lateral[mine & level].max() == pytest.approx(155, abs=5)
        assert elevation[mine].max() > 86
        assert elevation[mine].min() == pytest.approx(-70, abs=5)
    table = neighbour_table(columns)
    inner = (table >= 0).all(axis=1)
    mean = angles_deg(columns.axis[table[inner]], columns.axis[inner][:, None]).mean(axis=1)
    # Computed from the same scan before (facts.csv): 4.9° in the median, 3.8° the 5th percentile.
    assert np.median(mean) == pytest.approx(4.9, abs=0.1)
    assert np.percentile(mean, 5) == pytest.approx(3.8, abs=0.1)
    ahead = (np.abs(azimuth) < 40) & (np.abs(elevation) < 20)
    assert np.median(mean[ahead[inner]]) < np.median(mean) - 0.5


def test_kinds_of_ommatidia(columns):
    fly = omma.species.measured_drosophila()
    kinds = np.array(fly.eye.columns["ommatidium_type"])
    elevation = omma.eye.azimuth_elevation_deg_of(columns.axis)[1]
    # Of 42 and 41 columns with R7d or R8d in MaleCNS, 31 and 40 have an axis in the map.
    assert Counter(columns.side[kinds == "dorsal rim"].tolist()) == {1: 31, -1: 40}
    assert elevation[kinds == "dorsal rim"].min() > 10
    assert np.isin(
        (neighbour_table(columns)[kinds == "dorsal rim"] < 0).sum(axis=1), (0, 1, 2, 3)
    ).all()
    drawn = kinds != "dorsal rim"
    # Three binomial standard deviations of 1625 draws.
    assert (kinds[drawn] == "pale").mean() == pytest.approx(
        0.3, abs=3 * (0.21 / drawn.sum()) ** 0.5
    )
    assert elevation[kinds == "yellow, dorsal"].min() > 0
    names = [t.name for t in fly.eye.receptor_types]
    inner = {
        kind: {
            tuple(names[t] for t in fly.eye.receptor_type[3 * k + 1 : 3 * k + 3])
            for k in np.flatnonzero(kinds == kind)
        }
        for kind in np.unique(kinds)
    }
    assert inner == {
        "pale": {("R7p", "R8p")}, "yellow": {("R7y", "R8y")},
        "yellow, dorsal": {("R7y, dorsal", "R8y")}, "dorsal rim": {("R7d", "R8d")},
    }  # fmt: skip
    # Half Rh3 and half Rh4: the mean of both templates, with a peak of 1.
    mixed = next(t for t in fly.eye.receptor_types if t.name == "R7y, dorsal")
    nm = np.array([320.0, 345, 375, 420])
    both = sum(omma.receptors.govardovskii(peak, nm) for peak in (345, 375))
    found = omma.receptors.spectral_sensitivity(mixed, nm)
    assert found / found[1] == pytest.approx(both / both[1], rel=2e-3)  # of steps of 2 nm
    assert omma.species.measured_drosophila(seed=1).eye.columns != fly.eye.columns


def archive_file(path, columns, *, hexes, change=None):
    """A file of the archive's form of some columns of one eye."""
    rows = []
    for p, q, (right, up, back) in zip(columns.p.tolist(), columns.q.tolist(), columns.axis):
        theta, phi = np.degrees(np.arccos(up)), np.degrees(np.arctan2(right, -back))
        row = [p, q, f"{-back:.6f}", f"{-right:.6f}", f"{up:.6f}", f"{theta:.4f}", f"{phi:.4f}"]
        rows.append(row + ([q + 18, p + 19] if hexes else [720575940655096481]))
    header = ["p", "q", "x", "y", "z", "theta", "phi"]
    header += ["hex1", "hex2"] if hexes else ["rootid"]
    if change:
        change(header, rows)
    with open(path, "w", newline="") as file:
        csv.writer(file).writerows([header, *rows])
    return path


def test_files_of_the_archive_are_read(columns, tmp_path):
    left = columns.chosen(np.flatnonzero(columns.side < 0)[::40])
    right = columns.chosen(np.flatnonzero(columns.side > 0)[::40])
    found = omma.columns.load_eye_map(
        archive_file(tmp_path / "left.csv", left, hexes=True),
        archive_file(tmp_path / "right.csv", right, hexes=False),
    )
    assert keys_of(found) == keys_of(left) + keys_of(right)
    wanted = np.concatenate([left.axis, right.axis])
    assert np.abs(found.axis - wanted).max() < 2 * XYZ_ROUNDING
    only = omma.columns.load_eye_map(right=tmp_path / "right.csv")
    assert (only.side == 1).all()
    # The package's own table goes through the reader of maps, too.
    with pytest.raises(omma.Error, match="expected at least one file, found none"):
        omma.columns.load_eye_map()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda head, rows: rows[1].__setitem__(5, "40.0"),
            "line 3: expected theta and phi of the",
        ),
        (lambda head, rows: rows[1].__setitem__(7, 5), "line 3: expected hex1 = q . 18 and hex2"),
        (lambda head, rows: head.__setitem__(5, "elevation"), "expected the columns p, q, x, y, z"),
        (lambda head, rows: rows[1].__setitem__(0, "1.5"), "line 3, p: expected a whole number"),
        (lambda head, rows: rows.append(rows[0]), "expected each column of an eye once"),
    ],
)
def test_files_that_contradict_themselves_are_refused(columns, tmp_path, change, message):
    few = columns.chosen(np.flatnonzero(columns.side > 0)[::100])
    path = archive_file(tmp_path / "right.csv", few, hexes=True, change=change)
    with pytest.raises(omma.Error, match=message):
        omma.columns.load_eye_map(right=path)


def test_names_lead_to_their_columns(columns):
    names = omma.columns.malecns_names(columns)
    shuffled = np.random.default_rng(0).permutation(len(names))
    wanted = [names[k] for k in shuffled.tolist()]
    assert (omma.columns.find_columns(columns, wanted) == shuffled).all()
    pairs = omma.columns.flywire_names(columns)
    assert (omma.columns.find_columns(columns, pairs) == np.arange(len(pairs))).all()
    at = omma.columns.find_columns(columns, ["ME_R_col_18_19", "LOP_R_col_18_19", ("left", 1, -2)])
    assert [keys_of(columns)[k] for k in at] == [(1, 0, 0), (1, 0, 0), (-1, 1, -2)]
    # As tables and JSON have them.
    listed = [list(pair) for pair in pairs]
    assert (omma.columns.find_columns(columns, listed) == np.arange(len(pairs))).all()
    # hex1 before hex2: one more of hex1 is one more of q.
    assert omma.columns.malecns_names(columns.chosen(at[2:])) == ["ME_L_col_16_20"]


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["ME_R_col_14_32"], "is none of these 1696 columns; those at the rim of a lobe have no"),
        ([("right", 40, 0)], "p = 40, q = 0 of the right eye, which is none of these"),
        ([720575940655096481], "found 720575940655096481; a root id is a neuron of FlyWire"),
        (["720575940655096481"], "a root id is a neuron of FlyWire"),
        (["ME(R)_col_18_19"], "expected names of columns, as 'ME_R_col_18_19'"),
        ([("R", 0, 0)], "expected names of columns"),
        ([("right", 0.5, 0)], "expected whole numbers"),
        ("ME_R_col_18_19", "names: expected a list of names"),
        (("right", 0, 0), "names: expected a list of names"),
    ],
)
def test_names_of_another_release_are_refused(columns, names, message):
    with pytest.raises((omma.Error, TypeError), match=message):
        omma.columns.find_columns(columns, names)


def test_types_by_column(columns, tmp_path):
    path = tmp_path / "types.csv"
    path.write_text(
        "hex1_id,hex2_id,column_type\n18,19,pale\n19,19,yellow\n20,35,DRA\n22,22,unclear\n"
    )
    types = omma.columns.load_column_types(path, side="right")
    assert types == {
        "ME_R_col_18_19": "pale", "ME_R_col_19_19": "yellow", "ME_R_col_20_35": "dorsal rim",
    }  # fmt: skip
    at = omma.columns.find_columns(columns, ["ME_R_col_18_19", "ME_R_col_19_19"])
    for seed in range(3):
        fly = omma.species.measured_drosophila(
            {"ME_R_col_18_19": "pale", "ME_R_col_19_19": "yellow"}, seed=seed
        )
        kinds = fly.eye.columns["ommatidium_type"]
        assert [kinds[k] for k in at] == ["pale", "yellow"]
    named = tmp_path / "named.csv"
    named.write_text("column,column_type\nME_L_col_18_19,Yellow\n")
    assert omma.columns.load_column_types(named) == {"ME_L_col_18_19": "yellow"}
    with pytest.raises(omma.Error, match="side: expected one of left, right, found None"):
        omma.columns.load_column_types(path)
    path.write_text("hex1_id,hex2_id,kind\n18,19,pale\n")
    with pytest.raises(omma.Error, match="expected a column column_type, found hex1_id"):
        omma.columns.load_column_types(path, side="right")
    path.write_text("hex1,hex2,column_type\n18,19,pale\n18,19,pale\n")
    with pytest.raises(omma.Error, match="expected each column once, found ME_R_col_18_19 twice"):
        omma.columns.load_column_types(path, side="right")
    with pytest.raises(omma.Error, match="expected names of columns that have an axis"):
        omma.species.measured_drosophila({"ME_R_col_14_32": "pale"})
    with pytest.raises(omma.Error, match="expected pale, yellow or dorsal rim of ME_R_col_18_19"):
        omma.species.measured_drosophila({"ME_R_col_18_19": "blue"})
    with pytest.raises(omma.Error, match="pale_fraction: expected 0 to 1"):
        omma.species.measured_drosophila(pale_fraction=1.5)
