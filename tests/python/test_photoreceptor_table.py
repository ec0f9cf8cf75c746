"""R1-6, R7 and R8 by column: cartridges against the geometric wiring, tables against closed forms
and receptors rendered one by one, hexals of flyvis in its order and units."""

import numpy as np
import pytest

import omma
from omma.eye.superposition import fly_receptors, neural_superposition_wiring
from omma.eye.trapezoid import TRAPEZOID

SKY = (0.2, 0.4, 0.8)


@pytest.fixture(scope="module")
def columns():
    return omma.columns.fly_columns()


@pytest.fixture(scope="module")
def fly():
    return omma.species.measured_drosophila().eye


def plain_sky(rgb=SKY):
    return omma.Scene(background=omma.Background.constant(rgb))


@pytest.mark.parametrize("side", [-1, 1])
def test_cartridges_are_those_that_axes_give(side):
    """On a regular lattice, where who looks where can be found from the axes."""
    spacing = np.radians(4)
    towards = omma.eye.direction(80.0 * side, 0.0)
    lattice = omma.columns.hexal_columns(12, spacing, towards, side=side)
    eye = omma.columns.eye_of_columns(lattice, spacing)
    dorsal = lattice.p + lattice.q >= 0
    receptors = fly_receptors(eye, dorsal=dorsal)
    found = neural_superposition_wiring(receptors)
    owner = omma.receptors.ommatidium_of_receptor(receptors)
    types = [receptors.receptor_types[t].name for t in receptors.receptor_type]
    wiring, names = omma.columns.cartridge_wiring(lattice)
    u, v = omma.columns.uv_from_pq(lattice.p, lattice.q)
    inner = np.flatnonzero(np.maximum.reduce([np.abs(u), np.abs(v), np.abs(u + v)]) < 9)
    for target in inner:
        by_axes = found.index[found.first[target] : found.first[target + 1]]
        mine = slice(wiring.first[target], wiring.first[target + 1])
        assert sorted(zip(owner[by_axes].tolist(), (types[r] for r in by_axes))) == sorted(
            zip(wiring.index[mine].tolist(), names[mine])
        )


def test_six_meet_but_at_the_rim_and_the_equator(columns):
    wiring, names = omma.columns.cartridge_wiring(columns)
    row = columns.p + columns.q
    keys = set(zip(columns.side.tolist(), columns.p.tolist(), columns.q.tolist()))
    # Two steps to all sides: the cartridge's facets are all there.
    whole = np.array(
        [
            all((s, p + a, q + b) in keys for a in (-2, -1, 0, 1, 2) for b in (-2, -1, 0, 1, 2)
                if abs(a - b) <= 2)
            for s, p, q in zip(columns.side.tolist(), columns.p.tolist(), columns.q.tolist())
        ]
    )  # fmt: skip
    assert whole.sum() > 1200
    members = wiring.members
    # In six rows along the equator seven or eight (Wernet and Desplan, Cell 162:20, 2015).
    for r, count in {-4: 6, -3: 7, -2: 8, -1: 8, 0: 8, 1: 8, 2: 7, 3: 6}.items():
        inside = members[whole & (row == r)]
        common = np.bincount(inside).argmax()
        assert common == count, (r, np.bincount(inside))
    far = whole & (np.abs(row + 0.5) > 4)
    assert (members[far] == 6).all()
    for target in np.flatnonzero(far):
        mine = slice(wiring.first[target], wiring.first[target + 1])
        assert sorted(names[mine]) == list(TRAPEZOID)
        assert len(set(wiring.index[mine].tolist())) == 6
        assert (columns.side[wiring.index[mine]] == columns.side[target]).all()
    assert members.min() >= 1
    # Every receptor goes to one cartridge at most.
    pairs = list(zip(wiring.index.tolist(), names))
    assert len(set(pairs)) == len(pairs)


@pytest.mark.parametrize("ultraviolet", ["dark", "as_blue"])
def test_an_even_sky_gives_what_the_pigments_take_of_it(fly, ultraviolet):
    table = omma.columns.photoreceptor_table(
        plain_sky(), np.eye(4), sampling=omma.Fixed(1), ultraviolet=ultraviolet
    )
    names = [t.name for t in fly.receptor_types]
    takes = dict(zip(names, omma.receptors.receptor_matrix(fly, ultraviolet) @ SKY))
    assert table.r1_6 == pytest.approx(np.full((1, len(fly)), takes["R1-6"]), abs=1e-6)
    inner = {"pale": "p", "yellow": "y", "yellow, dorsal": "y", "dorsal rim": "d"}
    assert table.r7[:, table.kind == "pale"].shape[1] == np.sum(table.kind == "pale") > 0
    for k, kind in enumerate(table.kind):
        r7 = "R7y, dorsal" if kind == "yellow, dorsal" else "R7" + inner[kind]
        assert table.r7[0, k] == pytest.approx(takes[r7], abs=1e-6)
        assert table.r8[0, k] == pytest.approx(takes["R8" + inner[kind]], abs=1e-6)


def test_a_cartridge_is_the_mean_of_its_receptors(fly, columns):
    """A near wall of stripes, as wide as a facet: R1 to R6 see it from where their facets are."""
    stripes = np.array([[[0.1] * 3, [0.9] * 3]], np.float32)
    scene = omma.scene.drum(0.8e-3, 0.02, stripes, repeats=24)
    renderer = omma.columns.ColumnRenderer(scene, sampling=omma.Fixed(64))
    table = renderer.render(np.eye(4))
    wiring, _ = omma.columns.cartridge_wiring(columns)
    # Of one column of each eye: its receptors one by one, as eyes of their own.
    for name in ("ME_R_col_18_19", "ME_L_col_24_20"):
        (k,) = omma.columns.find_columns(columns, [name])
        facets = wiring.index[wiring.first[k] : wiring.first[k + 1]]
        alone = omma.Eye(
            fly.position_m[facets], np.tile(fly.axis[k], (len(facets), 1)),
            acceptance=omma.Acceptance.gaussian(np.radians(5.0)),
        )  # fmt: skip
        seen = omma.Renderer(scene, alone, omma.Fixed(4096)).render(np.eye(4))[0]
        rh1 = next(t for t in fly.receptor_types if t.name == "R1-6")
        each = seen @ omma.receptors.receptor_matrix(rh1)[0]
        assert np.ptp(each) > 0.02  # the stripes are fine enough to differ from facet to facet
        # 64 rays of each of six and more, beside 4096.
        assert table.r1_6[0, k] == pytest.approx(each.mean(), abs=0.01)
        assert table.of([name]).r1_6 == table.r1_6[:, k : k + 1]


def test_left_and_right_see_their_own_side(columns):
    """White on the right half of the sky alone."""
    image = np.zeros((2, 64, 3), np.float32)
    image[:, 32:] = 1  # azimuth 0 is in the middle, the right on the right
    scene = omma.Scene(background=omma.Background.image(image))
    table = omma.columns.photoreceptor_table(
        scene, np.eye(4), sampling=omma.Fixed(64), ultraviolet="as_blue"
    )
    azimuth, elevation = omma.eye.azimuth_elevation_deg_of(columns.axis)
    level = np.abs(elevation) < 45
    for answers in (table.r1_6, table.r7, table.r8):
        right = answers[0, level & (azimuth > 50) & (azimuth < 130)]
        left = answers[0, level & (azimuth < -50) & (azimuth > -130)]
        assert left.max() < 1e-3 < 0.1 < right.min()


def test_the_table_is_a_dataset_too(columns):
    pytest.importorskip("xarray")
    poses = np.stack([np.eye(4)] * 2)
    table = omma.columns.photoreceptor_table(plain_sky(), poses, sampling=omma.Fixed(1))
    data = table.dataset()
    assert dict(data.sizes) == {"pose": 2, "column": len(columns)}
    one = data.sel(column="ME_R_col_20_15")
    assert (int(one.p), int(one.q), int(one.hex1), int(one.hex2)) == (-4, 2, 20, 15)
    assert str(one.side.item()) == "right"
    k = omma.columns.find_columns(columns, ["ME_R_col_20_15"])[0]
    assert (one.R1_6.values == table.r1_6[:, k]).all()
    azimuth, _ = omma.eye.azimuth_elevation_deg_of(columns.axis[k : k + 1])
    assert float(one.azimuth) == pytest.approx(float(azimuth[0]))


def test_another_fly_by_columns_of_its_own():
    """The modelled fly, whose lattice is found from its lenses."""
    eye = omma.species.drosophila().eye
    own, which = omma.columns.columns_of_eye(eye)
    renderer = omma.columns.ColumnRenderer(
        plain_sky((1, 1, 1)), eye.take(which), own, sampling=omma.Fixed(1)
    )
    table = renderer.render(np.eye(4))
    there = table.in_cartridge > 0
    assert there.mean() > 0.95
    assert np.isnan(table.r1_6[0, ~there]).all()
    assert np.ptp(table.r1_6[0, there]) < 1e-6


def test_columns_without_a_cartridge_have_no_r1_6(fly, columns):
    """Two neighbours, of which some receptor sees for the other, and two far from each other."""
    two = omma.columns.find_columns(columns, [("right", 5, 5), ("right", 6, 5)])
    table = omma.columns.photoreceptor_table(
        plain_sky(), np.eye(4), fly=fly.take(two), columns=columns.chosen(two)
    )
    members = omma.columns.cartridge_wiring(columns.chosen(two))[0].members
    assert (np.isnan(table.r1_6[0]) == (members == 0)).all()
    far = omma.columns.find_columns(columns, [("right", 5, 5), ("right", 5, -9)])
    table = omma.columns.photoreceptor_table(
        plain_sky(), np.eye(4), fly=fly.take(far), columns=columns.chosen(far)
    )
    assert np.isnan(table.r1_6).all()
    assert (table.r8 > 0).all()


def test_columns_without_facets_are_refused(fly, columns):
    with pytest.raises(omma.Error, match="columns: expected one for each of 1696 ommatidia, found"):
        omma.columns.ColumnRenderer(plain_sky(), fly, columns.chosen(np.arange(10)))
    bare = fly.replace(receptor_types=None, receptors=None)
    with pytest.raises(omma.Error, match="expected receptors R1-6, R7 and R8 in each ommatidium"):
        omma.columns.ColumnRenderer(plain_sky(), bare, columns)
    with pytest.raises(TypeError, match="fly: expected"):
        omma.columns.ColumnRenderer(plain_sky(), "fly", columns)


def test_hexals_of_the_measured_fly_in_flyvis_order(columns):
    """As flyvis' BoxEye goes: u from -15 to 15, v from max(-15, -15 - u) to min(15, 15 - u)."""
    right = columns.chosen(columns.side > 0)
    # A number for each column that says which it is.
    told = 100.0 * right.p + right.q
    movie = omma.columns.to_hexals(told[:, None], right, fill=np.nan)[0, 0, 0]
    order = [(u, v) for u in range(-15, 16) for v in range(max(-15, -15 - u), min(15, 15 - u) + 1)]
    known = dict(zip(zip(right.p.tolist(), right.q.tolist()), told))
    for (u, v), found in zip(order, movie.tolist()):
        p, q = omma.columns.pq_from_uv([u], [v])
        wanted = known.get((int(p[0]), int(q[0])), np.nan)
        assert found == wanted or (np.isnan(found) and np.isnan(wanted))
    # x = v grows to the front, y = -(u + v / 2) is up, as flyvis draws them.
    u, v = np.array(order).T
    there = ~np.isnan(movie)
    assert there.sum() == 711
    axis = omma.columns.to_hexals(right.axis, right, fill=np.nan)[0, 0]
    azimuth, elevation = omma.eye.azimuth_elevation_deg_of(axis.T[there])
    level = np.abs(elevation) < 40
    assert np.corrcoef(v[there][level], azimuth[level])[0, 1] < -0.95
    assert np.corrcoef(-(u + v / 2)[there], elevation)[0, 1] > 0.97


def test_flyvis_has_the_same_order():
    hex_utils = pytest.importorskip("flyvis.utils.hex_utils")
    for extent in (0, 3, 15):
        assert (np.stack(hex_utils.get_hex_coords(extent), 1) == omma.columns.hexals(extent)).all()


def test_flyvis_eye_looks_where_hexals_lie():
    """Where its box eye takes pixels of a picture: v columns to the right, u + v/2 rows down."""
    box_eye = pytest.importorskip("flyvis.datasets.rendering").BoxEye(extent=15, kernel_size=13)
    u, v = omma.columns.hexals(15).T
    expected = np.stack([np.trunc(13 * (u + v / 2)), 13 * v], axis=1)
    assert (box_eye.receptor_centers.numpy() == expected).all()


def test_movies_for_flyvis_are_grey_levels(columns):
    right = columns.chosen(columns.side > 0)
    light = np.linspace(0, 2, 3 * len(right)).reshape(3, -1)
    movie = omma.columns.flyvis_movie(light, right, fill=0.5, white=2)
    assert movie.shape == (1, 3, 1, 721)
    assert movie.dtype == np.float32
    assert movie.flags.c_contiguous
    p, q = omma.columns.pq_from_uv(*omma.columns.hexals(15).T)
    row = {key: k for k, key in enumerate(zip(right.p.tolist(), right.q.tolist()))}
    for hexal, key in enumerate(zip(p.tolist(), q.tolist())):
        if key not in row:
            assert (movie[0, :, 0, hexal] == 0.5).all()
            continue
        linear = light[:, row[key]] / 2
        # The curve of sRGB, IEC 61966-2-1.
        wanted = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
        assert movie[0, :, 0, hexal] == pytest.approx(wanted, abs=1e-6)
    with pytest.warns(UserWarning, match="white: 94 % of the light is above 1"):
        assert omma.columns.flyvis_movie(light * 9, right, fill=0).max() == 1
    with pytest.raises(omma.Error, match="of 721 hexals have none"):
        omma.columns.flyvis_movie(light / 2, right)
    with pytest.raises(omma.Error, match="fill: expected 0 to 1"):
        omma.columns.flyvis_movie(light, right, fill=2)
    with pytest.raises(omma.Error, match=r"light: expected shape \(T, M\)"):
        omma.columns.flyvis_movie(light[:, :5], right, fill=0)
    whole = omma.columns.hexal_columns(2, 0.1, (1, 0, 0))
    dark = np.full((1, len(whole)), np.nan)
    with pytest.raises(omma.Error, match="light: expected numbers, found NaN"):
        omma.columns.flyvis_movie(dark, whole, radius=2)
    dark[0, 0] = 0.0  # of one column it is known
    filled = omma.columns.flyvis_movie(dark, whole, radius=2, fill=0.25)
    assert np.sum(filled == 0.25) == len(whole) - 1
