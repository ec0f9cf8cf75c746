"""Neural superposition in flies, and pooling."""

import numpy as np
import pytest

import omma
from omma.eye.neighbours import direction_lattice
from omma.eye.trapezoid import TRAPEZOID

SPACING = np.radians(4.5)


def fly_eye(*, side=1, rows_along_meridian=True, steps=12, stretch=1.0):
    """A hexagonal lattice of axes around the right (side 1) or the left, and where each axis is in
    steps of the lattice: right (backwards on a right eye) and up."""
    a, b = np.mgrid[-2 * steps : 2 * steps + 1, -2 * steps : 2 * steps + 1].reshape(2, -1)
    place = np.stack([a * np.sqrt(3) / 2, b + a / 2], axis=1)
    if not rows_along_meridian:
        place = place[:, ::-1]
    place = place[np.all(np.abs(place) < steps + 0.01, axis=1)] * [1, stretch]
    angle = np.hypot(*place.T) * SPACING
    shrink = np.sinc(angle / np.pi) * SPACING
    axis = np.stack(
        [side * np.cos(angle), shrink * place[:, 1], side * shrink * place[:, 0]], axis=1
    )
    return omma.Eye(1e-3 * axis, axis, np.radians(5)), place


def inner(place, margin=4, steps=12, stretch=1.0):
    return np.all(np.abs(place / [1, stretch]) < steps - margin, axis=1)


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("rows_along_meridian", [True, False])
@pytest.mark.parametrize("stretch", [1.0, 1.3])
def test_six_of_six_facets_meet_in_a_cartridge(side, rows_along_meridian, stretch):
    eye, place = fly_eye(side=side, rows_along_meridian=rows_along_meridian, stretch=stretch)
    fly = omma.eye.superposition.fly_receptors(eye)
    wiring = omma.eye.superposition.neural_superposition_wiring(fly)
    far = inner(place, stretch=stretch) & (np.abs(place[:, 1]) > 2.5 * stretch)
    assert far.sum() > 100
    assert np.all(wiring.members[far] == 6)
    owner, names = omma.receptors.ommatidium_of_receptor(fly), [t.name for t in fly.receptor_types]
    looking = omma.receptors.receptor_axis(fly)
    for target in np.flatnonzero(far):
        pooled = wiring.index[wiring.first[target] : wiring.first[target + 1]]
        assert len(set(owner[pooled])) == 6
        assert sorted(names[fly.receptor_type[r]] for r in pooled) == list(TRAPEZOID)
        angle = np.arccos(np.clip(looking[pooled] @ eye.axis[target], -1, 1))
        # Offsets are rounded to a tenth of the spacing, at most 0.07 off; the sphere's curvature
        # and steps of the lattice that change across it add as much.
        assert np.all(angle < 0.16 * SPACING * stretch)


def test_seven_or_eight_meet_along_the_equator():
    """In six rows of cartridges (Wernet and Desplan, Cell 162:20, 2015, figure 1E)."""
    eye, place = fly_eye()
    wiring = omma.eye.superposition.neural_superposition_wiring(
        omma.eye.superposition.fly_receptors(eye)
    )
    middle = inner(place)
    heights = np.unique(np.round(place[middle, 1], 3))
    rows = [
        set(wiring.members[middle & (np.abs(place[:, 1] - height) < 0.1)].tolist())
        for height in heights
    ]
    assert all(len(row) == 1 for row in rows)
    members = [row.pop() for row in rows]
    assert set(members) == {6, 7, 8}
    more = [height for height, count in zip(heights, members, strict=True) if count > 6]
    assert len(more) == 6
    assert np.ptp(more) == pytest.approx(2.5)  # half a step apart, in a row
    assert members[0] == 6
    assert members[-1] == 6


def test_the_pattern_is_mirrored_across_the_equator_and_between_eyes():
    offsets = {}
    for side in (1, -1):
        eye, place = fly_eye(side=side)
        fly = omma.eye.superposition.fly_receptors(eye)
        types = fly.receptor_types
        for half in (1, -1):
            one = np.argmin(np.hypot(place[:, 0], place[:, 1] - 4 * half))
            own = fly.receptor_type[fly.first_receptor[one] : fly.first_receptor[one + 1]]
            offsets[side, half] = {
                types[t].name: np.array([types[t].right_rad, types[t].up_rad]) / SPACING
                for t in own
                if types[t].name in TRAPEZOID
            }
    tolerance = 0.12  # twice the rounding
    for name in TRAPEZOID:
        right_dorsal = offsets[1, 1][name]
        assert np.allclose(offsets[1, -1][name], right_dorsal * [1, -1], atol=tolerance)
        assert np.allclose(offsets[-1, 1][name], right_dorsal * [-1, 1], atol=tolerance)
    # On the right eye R3 is the dorsal tip, anterior: it looks down and back (right).
    assert np.allclose(offsets[1, 1]["R3"], [np.sqrt(3) / 2, -1.5], atol=tolerance)
    assert np.allclose(offsets[1, 1]["R4"], [0, -1], atol=tolerance)
    distances = {name: np.hypot(*offset) for name, offset in offsets[1, 1].items()}
    assert max(distances, key=distances.get) == "R3"
    # R1, R2, R3 lie in a row.
    r1, r2, r3 = (offsets[1, 1][name] for name in ("R1", "R2", "R3"))
    assert np.allclose(r2 - r1, r3 - r2, atol=tolerance)


def test_up_vectors_may_be_any():
    """Offsets are told in the eye's own frame: where receptors look does not depend on it."""
    eye, _ = fly_eye(steps=5)
    turned = eye.replace(up=np.cross(eye.axis, [0.3, 0.5, 1]))
    first, second = (
        omma.receptors.receptor_axis(omma.eye.superposition.fly_receptors(e)) for e in (eye, turned)
    )
    # Each rounded by up to a tenth by the square root of 2, over 2.
    assert np.allclose(first, second, atol=2 * 0.071 * SPACING)


def test_pale_and_yellow_ommatidia_are_mixed():
    eye, _ = fly_eye()
    fly = omma.eye.superposition.fly_receptors(eye, seed=2)
    pale = np.array(fly.columns["ommatidium_type"]) == "pale"
    assert abs(pale.mean() - 0.3) < 4 * np.sqrt(0.21 / len(eye))
    peaks = {t.name: t.peak_wavelength_nm for t in fly.receptor_types}
    expected = {"R7p": 345, "R7y": 375, "R8p": 437, "R8y": 508}
    assert peaks == expected | dict.fromkeys(TRAPEZOID, 478)
    for i in range(0, len(eye), 40):
        own = fly.receptor_type[fly.first_receptor[i] : fly.first_receptor[i + 1]]
        names = [fly.receptor_types[t].name for t in own]
        assert names == [*TRAPEZOID, *(["R7p", "R8p"] if pale[i] else ["R7y", "R8y"])]


def test_flies_may_have_other_receptors():
    eye, _ = fly_eye(steps=3)
    outer = omma.receptors.ReceptorType(
        "outer",
        peak_wavelength_nm=490,
        absorption_per_m=5000,
        length_m=250e-6,
        microvillus_angle_rad=0.5,
        polarisation_sensitivity=2,
        acceptance=omma.Acceptance.gaussian(0.03),
    )
    inner_pale = omma.receptors.ReceptorType(
        "x", wavelength_nm=[300, 340, 400], sensitivity=[0.2, 1, 0]
    )
    types = {"R1-6": outer, "R7p": inner_pale}
    fly = omma.eye.superposition.fly_receptors(eye, pale_fraction=1, types=types)
    by_name = {t.name: t for t in fly.receptor_types}
    assert sorted(by_name) == [*TRAPEZOID, "R7p", "R8p"]
    for name in TRAPEZOID:
        one = by_name[name]
        assert one.peak_wavelength_nm == 490
        assert (one.absorption_per_m, one.length_m) == (5000, 250e-6)
        assert (one.microvillus_angle_rad, one.polarisation_sensitivity) == (0.5, 2)
        assert one.acceptance == outer.acceptance
        assert np.hypot(one.right_rad, one.up_rad) > 0.8 * SPACING
    assert by_name["R7p"].sensitivity == [0.2, 1, 0]
    assert by_name["R8p"].peak_wavelength_nm == 437


def test_a_mirrored_fly_is_the_fly_of_the_other_side():
    """As merging mirrors what receptors look at: the left eye from the right one."""
    right, _ = fly_eye(steps=5)
    mirror = np.diag([-1.0, 1, 1, 1])
    mirrored = omma.eye.merge_eyes([(omma.eye.superposition.fly_receptors(right), mirror)])
    made = omma.eye.superposition.fly_receptors(omma.eye.merge_eyes([(right, mirror)]))
    first, second = (omma.receptors.receptor_axis(fly) for fly in (mirrored, made))
    # Rounded offsets, on either side of a half.
    assert np.allclose(first, second, atol=0.101 * SPACING)
    assert np.mean(np.abs(first - second)) < 0.01 * SPACING
    wirings = [
        omma.eye.superposition.neural_superposition_wiring(fly).members for fly in (mirrored, made)
    ]
    assert np.array_equal(*wirings)


def test_two_eyes_are_wired_apart():
    right, _ = fly_eye(steps=6)
    left, _ = fly_eye(steps=6, side=-1)
    turn = np.eye(4)  # so that it looks where the right eye looks
    turn[0, 0] = turn[2, 2] = -1
    head = omma.eye.merge_eyes([(left, turn), right])
    both = omma.eye.superposition.neural_superposition_wiring(
        omma.eye.superposition.fly_receptors(head)
    )
    alone = omma.eye.superposition.neural_superposition_wiring(
        omma.eye.superposition.fly_receptors(omma.eye.merge_eyes([(left, turn)]))
    )
    assert np.array_equal(both.members[: len(left)], alone.members)
    fly = omma.eye.superposition.fly_receptors(head)
    target = np.repeat(np.arange(len(head)), both.members)
    owner = omma.receptors.ommatidium_of_receptor(fly)[both.index]
    assert np.array_equal(head.eye_id[target], head.eye_id[owner])


def test_pooling_sees_a_distant_scene_as_one_ommatidium_with_less_noise(scene):
    eye, place = fly_eye(steps=9)
    fly = omma.eye.superposition.fly_receptors(eye)
    background = omma.Background.test_pattern()
    renderer = omma.Renderer(
        scene, fly, omma.Fixed(4), background=background, threads=2, noise="new_every_frame"
    )
    high = omma.poses_from_angles(np.tile([0, 1e4, 0], (40, 1)), np.zeros((40, 3)))
    matrix = np.tile([0.2, 0.3, 0.5], (len(fly.receptor_types), 1))  # all alike, R7 too
    responses = renderer.render_receptors(high, matrix=matrix)
    wiring = omma.eye.superposition.neural_superposition_wiring(fly)
    pooled = omma.eye.superposition.pool(responses, wiring)
    names = np.array([t.name[:2] for t in fly.receptor_types])[fly.receptor_type]
    central = responses[:, names == "R7"]
    ahead = inner(place, steps=9) & (np.abs(place[:, 1]) > 2.5)
    assert ahead.sum() > 20
    exact = renderer.with_eye(eye, omma.Fixed(4096)).render(high[0])[0] @ matrix[0]
    noise_of_one = central[:, ahead].std(axis=0)
    noise = pooled[:, ahead].std(axis=0)
    # Samples of six views are independent: the noise drops by the square root of 6. Forty poses
    # know each deviation to 11 %; their mean over 20 and more ommatidia to 3 %.
    ratio = np.sqrt(np.mean(noise_of_one**2) / np.mean(noise**2))
    assert ratio == pytest.approx(np.sqrt(6), rel=0.1)
    # The mean of the six is what the ommatidium sees, but for their being 0.16 of a spacing off at
    # most: the pattern's colours change by 1 over half a turn.
    assert np.allclose(pooled[:, ahead].mean(axis=0), exact[ahead], atol=0.01)


def test_pooling_is_a_weighted_mean():
    wiring = omma.eye.superposition.Wiring(
        np.array([0, 2, 2, 5]), np.array([3, 0, 1, 1, 2]), np.array([1.0, 3, 1, 1, 2])
    )
    responses = np.array([[4.0, 8, 2, 0], [0, 1, 0, 4]])
    pooled = omma.eye.superposition.pool(responses, wiring)
    assert pooled.dtype == np.float32
    assert np.array_equal(pooled, [[3, np.nan, 5], [1, np.nan, 0.5]], equal_nan=True)
    assert np.array_equal(
        omma.eye.superposition.pool(responses[0], wiring), pooled[0], equal_nan=True
    )
    colours = np.repeat(responses[:, :, None], 3, axis=2) * [1, 2, 3]
    assert np.array_equal(
        omma.eye.superposition.pool(colours, wiring, axis=1),
        pooled[..., None] * [1, 2, 3],
        equal_nan=True,
    )
    assert wiring.histogram() == {0: 1, 2: 1, 3: 1}
    assert len(wiring) == 3
    with pytest.raises(omma.Error, match="expected at least 4 along axis -1, found 3"):
        omma.eye.superposition.pool(responses[:, :3], wiring)


def test_responses_of_another_eye_are_not_pooled():
    eye, _ = fly_eye(steps=5)
    fly = omma.eye.superposition.fly_receptors(eye)
    count = len(fly.receptor_type)
    wiring = omma.eye.superposition.neural_superposition_wiring(fly)
    assert wiring.responses == count
    assert omma.eye.superposition.pool(np.ones(count), wiring).shape == (len(eye),)
    for other in (count + 8, count - 1):
        with pytest.raises(omma.Error, match=f"expected {count} along axis -1.*found {other}"):
            omma.eye.superposition.pool(np.ones(other), wiring)
    with pytest.raises(omma.Error, match="responses: expected at least 3, as index says, found 2"):
        omma.eye.superposition.Wiring([0, 1], [2], [1.0], 2)


def test_receptors_to_pool_are_chosen_by_name_and_reach():
    eye, _ = fly_eye(steps=6)
    fly = omma.eye.superposition.fly_receptors(eye)
    central = omma.eye.superposition.neural_superposition_wiring(fly, receptors=["R7p", "R7y"])
    assert np.all(central.members == 1)  # each its own
    assert np.array_equal(
        omma.receptors.ommatidium_of_receptor(fly)[central.index], np.arange(len(eye))
    )
    tight = omma.eye.superposition.neural_superposition_wiring(fly, reach=1e-4)
    assert (
        tight.members.sum()
        < 0.2 * omma.eye.superposition.neural_superposition_wiring(fly).members.sum()
    )
    with pytest.raises(omma.Error, match="expected receptors called R9, found none"):
        omma.eye.superposition.neural_superposition_wiring(fly, receptors=["R9"])
    plain = eye.replace(
        receptor_types=[omma.receptors.ReceptorType("g", peak_wavelength_nm=500)], receptors=[0]
    )
    with pytest.raises(omma.Error, match="expected receptors beside the axis, found none"):
        omma.eye.superposition.neural_superposition_wiring(plain)
    with pytest.raises(omma.Error, match="reach"):
        omma.eye.superposition.neural_superposition_wiring(fly, reach=0)


def test_faults_of_the_modelled_flys_lattice():
    """As docs/receptors.md has it; on lattices without faults there are at most eight."""
    fly = omma.species.drosophila().eye
    members = omma.eye.superposition.neural_superposition_wiring(fly).members
    more = members > 8
    assert (len(fly), more.sum(), members.max()) == (1709, 10, 10)
    assert (np.abs(fly.axis[more, 1]) < np.sin(np.radians(8))).sum() == 9
    neighbours = direction_lattice(fly.axis.astype(np.float64), fly.eye_id)
    count = np.bincount(neighbours.pairs.ravel(), minlength=len(fly))
    beside = [np.append(neighbours.pairs[(neighbours.pairs == i).any(axis=1)], i)
              for i in range(len(fly))]  # fmt: skip
    within_two = [np.unique(np.concatenate([beside[j] for j in beside[i]]))
                  for i in np.flatnonzero(more)]  # fmt: skip
    assert sum(bool((count[near] != 6).any()) for near in within_two) == 9


def test_wrong_flies_are_named():
    eye, _ = fly_eye(steps=2)
    with pytest.raises(omma.Error, match="pale_fraction: expected 0 to 1, found 2"):
        omma.eye.superposition.fly_receptors(eye, pale_fraction=2)
    with pytest.raises(omma.Error, match=r"types: expected names from R1-6, .* found R9"):
        omma.eye.superposition.fly_receptors(
            eye, types={"R9": omma.receptors.ReceptorType("R9", peak_wavelength_nm=500)}
        )
    with pytest.raises(omma.Error, match="at least four ommatidia, found 1"):
        omma.eye.superposition.fly_receptors(eye.take([0]))
