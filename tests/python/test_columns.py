"""Columns: conventions, maps from files, resampling against closed forms, hexals as models take
them, and motion on them."""

import json
import warnings

import numpy as np
import pytest

import omma

SPACING = np.radians(5)


@pytest.fixture(scope="module")
def fly():
    return omma.species.drosophila().eye


@pytest.fixture(scope="module")
def lattice():
    """721 columns of the right eye, around 60° to the right."""
    return omma.columns.hexal_columns(15, SPACING, omma.eye.direction(60.0, 0.0))


def test_hexals_are_in_the_order_of_loops_over_u_and_v():
    for radius in (0, 1, 4, 15):
        expected = [
            (u, v)
            for u in range(-radius, radius + 1)
            for v in range(max(-radius, -radius - u), min(radius, radius - u) + 1)
        ]
        assert omma.columns.hexals(radius).tolist() == [list(one) for one in expected]
        assert len(expected) == 1 + 3 * radius * (radius + 1)


def test_conventions_lead_back():
    u, v = omma.columns.hexals(6).T
    for front in ("right", "left"):
        p, q = omma.columns.pq_from_uv(u, v, front)
        assert np.array_equal(omma.columns.uv_from_pq(p, q, front), (u, v))
        # Neighbours stay neighbours: steps of the lattice of p and q are steps of that of u and v.
        apart = np.maximum.reduce([np.abs(p), np.abs(q), np.abs(p - q)])
        assert (apart == np.maximum.reduce([np.abs(u), np.abs(v), np.abs(u + v)])).all()
    hex1, hex2 = omma.columns.hex_from_pq(p, q)
    assert np.array_equal(omma.columns.pq_from_hex(hex1, hex2), (p, q))
    # As reiserlab's code has it, p = hex2 - 19 and q = hex1 - 18.
    assert [one.tolist() for one in omma.columns.pq_from_hex([20], [19])] == [[0], [2]]


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("front", ["right", "left"])
def test_a_regular_lattice_looks_where_its_names_say(side, front):
    towards = omma.eye.direction(60.0 * side, 0.0)
    columns = omma.columns.hexal_columns(3, SPACING, towards, side=side, front=front)
    named = {-1: "left", 1: "right"}[side]
    assert columns == omma.columns.hexal_columns(3, SPACING, towards, side=named, front=front)
    place = {(p, q): axis for p, q, axis in zip(columns.p, columns.q, columns.axis)}
    assert place[0, 0] == pytest.approx(towards, abs=1e-12)
    # p + q is dorsal, q - p to the front, whichever way pictures show it.
    assert place[2, 2][1] > place[0, 0][1] + 0.1
    assert place[1, 0][1] > 0
    assert place[0, 1][1] > 0
    front_deg, _ = omma.eye.azimuth_elevation_deg_of(np.array([place[-1, 1], place[1, -1]]))
    assert abs(front_deg[0]) < 60 < abs(front_deg[1])
    # The six neighbours of the middle are the spacing away.
    for step in ((1, 0), (0, 1), (1, 1), (-1, 0), (0, -1), (-1, -1)):
        assert np.arccos(place[step] @ towards) == pytest.approx(SPACING, rel=1e-9)


def test_columns_of_an_eye_agree_with_its_lattice(fly):
    columns, ommatidium = omma.columns.columns_of_eye(fly)
    found = omma.eye.hexagonal_coordinates(fly)
    assert (columns.p == found.p[ommatidium]).all()
    assert (columns.axis * fly.axis[ommatidium]).sum(axis=1).min() > 1 - 1e-6
    pairs = omma.columns.column_pairs(columns, ["p"])
    # The ommatidium of the second is the neighbour of the first's in direction p, but at edges and
    # faults, where few are neighbours.
    assert (found.neighbours[ommatidium[pairs[:, 0]], 5] == ommatidium[pairs[:, 1]]).mean() > 0.9
    dorsal = omma.columns.column_pairs(columns, ["v"])
    rise = columns.axis[dorsal[:, 1], 1] - columns.axis[dorsal[:, 0], 1]
    near = np.abs(columns.axis[dorsal[:, 0], 1]) < 0.7
    assert (rise[near] > 0).mean() > 0.99


def test_columns_of_the_same_place_are_refused():
    axis = np.eye(3)
    with pytest.raises(omma.Error, match="of an eye once, found p = 1, q = 2 in rows 0 and 2"):
        omma.columns.Columns([1, 0, 1], [2, 0, 2], [1, 1, 1], axis)
    assert len(omma.columns.Columns([1, 0, 1], [2, 0, 2], [1, 1, -1], axis)) == 3
    with pytest.raises(omma.Error, match="side: expected -1"):
        omma.columns.Columns([1], [2], [0], axis[:1])
    with pytest.raises(omma.Error, match=r"axis: expected directions, found \[0"):
        omma.columns.Columns([1], [2], [1], [[0, 0, 0]])


def test_rows_sum_to_one_and_light_stays_light(fly, lattice):
    columns = lattice.chosen(omma.columns.seen_by(fly, lattice))
    assert len(columns) > 600
    for weights in ("gaussian", "nearest"):
        matrix = omma.columns.resampling_matrix(fly, columns, weights)
        assert matrix.shape == (len(columns), len(fly))
        assert np.abs(matrix.sum(axis=1) - 1).max() < 1e-12
        flat = omma.columns.resample(np.full((2, 4, len(fly), 3), 0.7, np.float32), matrix)
        assert flat.shape == (2, 4, len(columns), 3)
        assert np.abs(flat - np.float32(0.7)).max() < 1e-12
        # Of two eyes only the right one's ommatidia count.
        assert (fly.axis[np.unique(matrix.indices), 0].mean()) > 0.3
        assert set(fly.eye_id[np.unique(matrix.indices)]) == {fly.eye_id[fly.axis[:, 0].argmax()]}
    assert (matrix.data == 1).all()
    assert (np.diff(matrix.indptr) == 1).all()


def test_nearest_is_nearest(fly, lattice):
    columns = lattice.chosen(omma.columns.seen_by(fly, lattice))
    matrix = omma.columns.resampling_matrix(fly, columns, "nearest")
    right = np.flatnonzero(fly.eye_id == fly.eye_id[fly.axis[:, 0].argmax()])
    axis = fly.axis[right] / np.linalg.norm(fly.axis[right], axis=1, keepdims=True)
    assert (matrix.indices == right[(columns.axis @ axis.T).argmax(axis=1)]).all()


def test_an_eye_of_the_columns_is_not_changed(lattice):
    eye = omma.columns.eye_of_columns(lattice, np.radians(5))
    assert len(eye) == 721
    matrix = omma.columns.resampling_matrix(eye, lattice, "nearest")
    responses = np.random.default_rng(0).random((3, 721, 2)).astype(np.float32)
    assert (omma.columns.resample(responses, matrix) == responses).all()


@pytest.mark.parametrize("wavelength_deg", [12, 20, 40])
def test_a_gaussian_lowers_a_grating_by_its_transfer(wavelength_deg):
    """Ommatidia 1° apart that see single points of a sine along the horizon, onto columns as wide
    as 5°: the amplitude is exp(-π²/(4 ln 2) (width/λ)²), flat on so small a patch."""
    width, wavelength = np.radians(5), np.radians(wavelength_deg)
    grid = np.radians(np.arange(-20, 21))
    azimuth, elevation = (one.ravel() for one in np.meshgrid(grid, grid))
    axis = np.stack(
        [np.cos(elevation) * np.sin(azimuth), np.sin(elevation),
         -np.cos(elevation) * np.cos(azimuth)], axis=1,
    )  # fmt: skip
    eye = omma.Eye(np.zeros_like(axis), axis, 0.02)
    at = np.radians(np.linspace(-6, 6, 13))
    columns = omma.columns.Columns(
        np.arange(13), np.zeros(13), np.ones(13),
        np.stack([np.sin(at), 0 * at, -np.cos(at)], axis=1),
    )  # fmt: skip
    matrix = omma.columns.resampling_matrix(eye, columns, width_rad=width)
    made = omma.columns.resample(np.cos(2 * np.pi * azimuth / wavelength)[:, None], matrix)[:, 0]
    transfer = np.exp(-(np.pi**2) / (4 * np.log(2)) * (width / wavelength) ** 2)
    # Rows of the grid come nearer to each other away from the horizon, by 1.5 % at 10°.
    assert made == pytest.approx(transfer * np.cos(2 * np.pi * at / wavelength), abs=0.01)


def test_weights_are_those_of_the_pages_formula():
    """Slowly, from angles alone; an eye whose spacing changes tells the mean square of angles from
    the square of their mean."""
    eye = omma.eye.generate_eye(200)
    y = eye.axis[:, 1].astype(np.float64)
    eye = eye.replace(axis=eye.axis * np.stack([1 + 0.5 * y, np.ones_like(y), 1 + 0.3 * y], -1))
    columns = omma.columns.hexal_columns(3, np.radians(12), omma.eye.direction(75, 0))
    width = np.radians(15)
    matrix = omma.columns.resampling_matrix(eye, columns, width_rad=width, reach_rad=1.0).toarray()
    axes = eye.axis.astype(np.float64)
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    apart = np.sort(np.arccos(np.clip(axes @ axes.T, -1, 1)), axis=1)[:, 1:7]
    share = (apart**2).mean(axis=1)
    angle = np.arccos(np.clip(columns.axis @ axes.T, -1, 1))
    weights = share * np.exp(-4 * np.log(2) * (angle / width) ** 2) * (angle <= 2 * width)
    expected = weights / weights.sum(axis=1, keepdims=True)
    # Arc cosines of angles of some degrees are right to 1e-14.
    assert np.abs(matrix - expected).max() < 1e-10
    squared = apart.mean(axis=1) ** 2 / share
    assert np.ptp(squared) > 0.01


def test_columns_that_look_elsewhere_are_named(fly):
    behind = omma.columns.hexal_columns(2, SPACING, omma.eye.direction(-120.0, 0.0))
    with pytest.raises(omma.Error, match=r"columns: \d+ of 19 look further than \d+\.\d° from any"):
        omma.columns.resampling_matrix(fly, behind)
    assert not omma.columns.seen_by(fly, behind).all()
    with pytest.raises(omma.Error, match="weights: expected one of gaussian, nearest"):
        omma.columns.resampling_matrix(fly, behind, "linear")
    with pytest.raises(omma.Error, match="width_rad: expected a number above 0"):
        omma.columns.resampling_matrix(fly, behind, width_rad=0.0, reach_rad=4.0)
    matrix = omma.columns.resampling_matrix(fly, behind, reach_rad=4.0)
    with pytest.raises(omma.Error, match=r"responses: expected shape \(\.\.\., \d+, C\)"):
        omma.columns.resample(np.zeros((3, 4)), matrix)


def test_hexals_are_what_models_take(lattice):
    responses = np.random.default_rng(1).random((2, 3, 721, 4)).astype(np.float32)
    made = omma.columns.to_hexals(responses, lattice)
    assert made.shape == (2, 3, 4, 721)
    assert made.dtype == np.float32
    assert made.flags.c_contiguous
    # The lattice was made in the order of hexals.
    assert (made == responses.swapaxes(2, 3)).all()
    # In another order, moved away from the middle, of frames and of a frame.
    order = np.random.default_rng(2).permutation(721)
    mixed = lattice.chosen(order)
    moved = omma.columns.Columns(mixed.p + 5, mixed.q - 3, mixed.side, mixed.axis)
    again = omma.columns.to_hexals(responses[:, :, order], moved, middle=(5, -3))
    assert (again == made).all()
    assert (omma.columns.to_hexals(responses[0], lattice) == made[:1]).all()
    assert (omma.columns.to_hexals(responses[0, 0], lattice) == made[:1, :1]).all()
    # A smaller one is its middle.
    u, v = omma.columns.hexals(15).T
    inner = np.maximum.reduce([np.abs(u), np.abs(v), np.abs(u + v)]) <= 4
    assert (omma.columns.to_hexals(responses, lattice, 4) == made[..., inner]).all()


def test_the_front_is_where_it_is_said_to_be(lattice):
    """Light in the front half is on that side of the picture, x = v."""
    azimuth, _ = omma.eye.azimuth_elevation_deg_of(lattice.axis)
    light = (azimuth < 60).astype(float)[:, None]
    _, v = omma.columns.hexals(15).T
    for front, sign in (("right", 1), ("left", -1)):
        made = omma.columns.to_hexals(light, lattice, front=front)[0, 0, 0]
        assert (made[sign * v > 1] == 1).all()
        assert (made[sign * v < -1] == 0).all()


def test_another_word_for_a_side_is_refused():
    with pytest.raises(omma.Error, match=r"side: expected left .-1. or right .1., found 'both'"):
        omma.columns.hexal_columns(3, SPACING, (1, 0, 0), side="both")


def test_columns_are_called_as_users_find_them():
    with pytest.raises(TypeError, match=r"columns: expected omma\.columns\.Columns, found list"):
        omma.columns.flyvis_movie(np.ones((2, 3)), [1, 2, 3])


def test_light_above_white_and_none_at_all_is_told(lattice):
    light = np.linspace(0, 2, 4 * 721).reshape(4, 721)
    with pytest.warns(UserWarning, match=r"white: 50 % of the light is above 1 .* brightest is 2"):
        assert omma.columns.flyvis_movie(light, lattice).max() == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        omma.columns.flyvis_movie(light, lattice, white=1.95)  # some highlights
    with pytest.raises(omma.Error, match="light: expected numbers, found NaN in all frames"):
        omma.columns.flyvis_movie(np.nan * light, lattice, fill=0.5)


def test_hexals_without_a_column(lattice):
    few = lattice.chosen(lattice.p > -15)
    with pytest.raises(
        omma.Error, match=r"columns: \d+ of 721 hexals have none, the first p = -15"
    ):
        omma.columns.to_hexals(np.ones((len(few), 1)), few)
    made = omma.columns.to_hexals(np.ones((len(few), 1)), few, fill=0.25)
    assert (np.unique(made) == [0.25, 1]).all()
    assert (made == 1).sum() == len(few)
    both = omma.columns.Columns([0, 0], [0, 0], [-1, 1], np.eye(3)[:2])
    with pytest.raises(omma.Error, match="columns: expected those of one eye"):
        omma.columns.to_hexals(np.ones((2, 1)), both)
    with pytest.raises(omma.Error, match=r"responses: expected shape \(M, C\)"):
        omma.columns.to_hexals(np.ones(721), lattice)


def write(path, text):
    path.write_text(text)
    return path


def test_maps_of_flywire_and_of_male_cns_are_the_same(tmp_path):
    rows = [(1, -2, "left", -60.0, 10.0), (0, 0, "left", -75.0, 0.0), (1, -2, "right", 60.0, 10.0)]
    lines = [f"{p},{q},{side},{a},{e}" for p, q, side, a, e in rows]
    plain = omma.columns.load_columns(
        write(tmp_path / "a.csv", "p,q,hemisphere,azimuth,elevation\n" + "\n".join(lines))
    )
    assert plain.side.tolist() == [-1, -1, 1]
    assert plain.axis[2] == pytest.approx(omma.eye.direction(60.0, 10.0), abs=1e-12)
    assert dict(plain.taken_from)["side"] == "hemisphere"
    header = "# a map\nhex1_id,hex2_id,Eye,Azimuth (rad),Elevation (rad),type\n"
    hexes = [
        f"{q + 18},{p + 19},{side[0].upper()},{np.radians(a)},{np.radians(e)},Mi1"
        for p, q, side, a, e in rows
    ]
    male = omma.columns.load_columns(write(tmp_path / "b.csv", header + "\n".join(hexes)))
    assert (male.p == plain.p).all()
    assert (male.q == plain.q).all()
    assert male.axis == pytest.approx(plain.axis, abs=1e-12)
    assert dict(male.taken_from)["azimuth"] == "Azimuth (rad)"
    # The same as JSON in its three ways, as directions with x ahead, y left, z up.
    front_left_up = np.stack([-plain.axis[:, 2], -plain.axis[:, 0], plain.axis[:, 1]], axis=1)
    records = [
        {"P": p, "Q": q, "side": side, "x": x, "y": y, "z": z}
        for (p, q, side, *_), (x, y, z) in zip(rows, front_left_up.tolist())
    ]
    by_name = {key: [row[key] for row in records] for key in records[0]}
    sides = {"left": records[:2], "right": records[2:]}
    for number, document in enumerate(
        (records, by_name, sides, {"columns": records, "made": 2026})
    ):
        path = write(tmp_path / f"{number}.json", json.dumps(document))
        found = omma.columns.load_columns(path, xyz=("front", "left", "up"))
        assert (found.side == plain.side).all()
        assert found.axis == pytest.approx(plain.axis, abs=1e-12)
    turned = omma.columns.load_columns(tmp_path / "a.csv", azimuth_grows="left")
    assert turned.axis == pytest.approx(plain.axis * (-1, 1, 1), abs=1e-12)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("p,q,side,x,y\n1,2,left,0,1\n", "m.csv: expected columns x, y, z, or azimuth and elevat"),
        ("p,side,x,y,z\n1,left,0,1,0\n", "m.csv: expected columns p, q, or hex1 and hex2, f"),
        ("p,q,x,y,z\n1,2,0,1,0\n", "m.csv: expected a column side, hemisphere or eye, found p, q"),
        ("p,q,side,x,y,z\n1,2,up,0,1,0\n", "line 2, side: expected left or right, found 'up"),
        ("p,q,side,x,y,z\n1,2,left,0,,0\n", "m.csv, line 2, y: expected a number, found ''"),
        ("p,q,side,x,y,z\n1,2.5,left,0,1,0\n", "line 2, q: expected a whole number, found 2.5"),
        ("p,q,side,x,y,z\n1,2,left,0,1\n", "line 2: expected 6 cells as in the header, found 5"),
        ("p,q,side,x,y,z\n1,2,left,0,0,0\n", "m.csv, line 2: expected a direction, found 0, 0, 0"),
        ("p,q,side,x,y,z\n1,2,L,0,1,0\n\n1,2,L,0,1,1\n", "line 4: expected each column of an eye "
         "once, found p = 1, q = 2 in .*m.csv, line 2 too"),
        ("p,P,q,side,x,y,z\n1,1,2,left,0,1,0\n", "m.csv: expected one column for p, found p and P"),
        ("p,q,side,x,y,z\n", "m.csv: expected at least one row, found none"),
    ],
)  # fmt: skip
def test_wrong_tables_are_named(tmp_path, text, message):
    with pytest.raises(omma.Error, match=message):
        omma.columns.load_columns(write(tmp_path / "m.csv", text))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "m.json: is not JSON"),
        ("3", "m.json: expected a list of rows, found 3"),
        ("[1]", "m.json, row 0: expected names and values, found 1"),
        ('{"p": [1], "q": [1, 2]}', "m.json: expected lists of one length"),
        ('{"p": 1}', "m.json: expected one list of rows, or a list for each name, found p"),
        ('[{"p": 1, "q": 2, "side": "left", "x": true, "y": 1, "z": 0}]', "row 0, x: expected a"),
    ],
)  # fmt: skip
def test_wrong_documents_are_named(tmp_path, text, message):
    with pytest.raises(omma.Error, match=message):
        omma.columns.load_columns(write(tmp_path / "m.json", text))


def test_wrong_ways(tmp_path):
    path = write(tmp_path / "m.csv", "p,q,x,y,z\n1,2,0,1,0\n")
    assert omma.columns.load_columns(path, side="right").side.tolist() == [1]
    with pytest.raises(omma.Error, match="xyz: expected three ways at right angles"):
        omma.columns.load_columns(path, side="right", xyz=("up", "down", "front"))
    with pytest.raises(omma.Error, match="xyz: expected three of"):
        omma.columns.load_columns(path, side="right", xyz=("up", "front"))
    with pytest.raises(omma.Error, match=r"expected a name ending in \.csv or \.json"):
        omma.columns.load_columns(tmp_path / "m.xlsx", side="right")


def test_motion_on_hexals_goes_the_way_of_the_world(lattice):
    """A drum turns; the motion detector on columns sees it go to the back or to the front."""
    eye = omma.columns.eye_of_columns(lattice, SPACING)
    stripes = np.array([[[0.2, 0.2, 0.2], [0.8, 0.8, 0.8]]])
    world = omma.World(omma.scene.drum(1.0, 3.0, stripes, repeats=12))
    renderer = omma.Renderer(world, eye, omma.Fixed(8))
    pairs = omma.columns.column_pairs(lattice, ["q", "-p"])  # both to the front
    detectors = omma.motion.detector_array(eye, 0.035, 100, pairs=pairs, high_pass_tau_s=0.25)
    azimuth_deg = 120 * np.arange(60) / 100  # to the right: to the back, in the right eye
    turns = np.stack([omma.look_at((0, 0, 0), omma.eye.direction(a, 0)) for a in azimuth_deg])
    light = renderer.render(
        np.tile(np.eye(4), (60, 1, 1)), instances=["drum"], transforms=turns[:, None]
    )
    outputs = detectors.run(light[:, :, 1])
    level = np.abs(lattice.axis[pairs[:, 0], 1]) < 0.5
    assert outputs[30:, level].mean() < 0
    back = detectors.run(light[::-1, :, 1])
    assert back[30:, level].mean() > 0
