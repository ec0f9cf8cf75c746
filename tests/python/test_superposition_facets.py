"""The facets of optical superposition eyes: which an aperture takes, and what pooling tells."""

import numpy as np
import pytest

import omma


def flat_eye(**others):
    """Facets 20 µm apart on a plane, all looking ahead."""
    x, y = np.mgrid[-5:6, -5:6].reshape(2, -1) * 20e-6
    position = np.stack([x, y, 0 * x], axis=1)
    return omma.Eye(position, np.tile([0, 0, -1], (len(x), 1)), 0.02, **others)


def test_facets_of_an_aperture_are_those_within_it():
    eye = flat_eye(facet_diameter_m=20e-6)
    views, wiring = omma.eye.superposition.superposition_facets(eye, 85e-6)
    middle = len(eye) // 2
    pooled = wiring.index[wiring.first[middle] : wiring.first[middle + 1]]
    # Within 2.125 spacings: 13 points of a square lattice.
    assert len(pooled) == 13
    away = views.position_m[pooled] - eye.position_m[middle]
    assert np.all(np.hypot(away[:, 0], away[:, 1]) < 42.5e-6)
    assert np.all(views.aperture_diameter_m == 0)
    assert len(views.receptor_type) == 0
    assert np.all(wiring.members >= 6)  # at the corners
    # How far in front or behind a facet lies does not count.
    position = eye.position_m.copy()
    position[middle + 1, 2] += 60e-6
    moved = omma.eye.superposition.superposition_facets(eye.replace(position_m=position), 85e-6)[1]
    assert moved.members[middle] == 13
    # A facet of twice the diameter counts four times.
    large = np.full(len(eye), 20e-6)
    large[middle + 1] = 40e-6
    views, wiring = omma.eye.superposition.superposition_facets(
        eye.replace(facet_diameter_m=large, aperture_diameter_m=85e-6)
    )
    weight = wiring.weight[wiring.first[middle] : wiring.first[middle + 1]]
    assert np.sort(weight / weight.min()) == pytest.approx([1] * 12 + [4], rel=1e-5)


def test_facets_turned_away_or_of_the_other_eye_do_not_count():
    eye = flat_eye()
    axis, number = eye.axis.copy(), np.zeros(len(eye), int)
    middle = len(eye) // 2
    axis[middle + 1] = (0, 0, 1)
    number[middle + 11] = 1
    views, wiring = omma.eye.superposition.superposition_facets(
        eye.replace(axis=axis, eye_id=number), 85e-6
    )
    assert wiring.members[middle] == 11
    assert wiring.members[middle + 11] == 1  # alone in its eye
    assert np.all(views.eye_id == np.repeat(number, wiring.members))
    with pytest.raises(omma.Error, match="aperture_diameter_m: ommatidium 0 has none"):
        omma.eye.superposition.superposition_facets(eye)


def test_facets_pooled_see_what_the_aperture_sees(scene):
    """Facets 0.2 m apart above the edge of the coloured ground, so that parallax counts."""
    scale = 1e4
    facets = flat_eye()
    eye = facets.replace(position_m=facets.position_m * scale, aperture_diameter_m=85e-6 * scale)
    pose = omma.look_at((0, 3, 0), (14, 0, -3))
    renderer = omma.Renderer(scene, eye, omma.Fixed(4096), threads=2)
    views, wiring = omma.eye.superposition.superposition_facets(eye)
    middle = wiring.members == 13
    assert middle.sum() == 49
    disc = renderer.render(pose)[:, middle]
    pooled = omma.eye.superposition.pool(
        renderer.with_eye(views, omma.Fixed(512)).render(pose), wiring, axis=1
    )
    alone = renderer.with_eye(eye.replace(aperture_diameter_m=0.0)).render(pose)

    def difference(responses):
        return np.sqrt(np.mean((responses[:, middle] - disc) ** 2))

    # Thirteen points have the disc's mean place and, to 5 %, its mean square; what is left are
    # edges that pass between them.
    assert difference(alone) > 0.01
    assert difference(pooled) < 0.2 * difference(alone)


def moth():
    """Facets of two sizes on a plane, each with two receptors of which catches are known."""
    green, blue = (
        omma.receptors.ReceptorType(
            name, peak_wavelength_nm=peak, absorption_per_m=6700, length_m=2e-4
        )
        for name, peak in (("green", 520), ("blue", 440))
    )
    eye = flat_eye(facet_diameter_m=np.where(np.arange(121) % 2, 16e-6, 20e-6))
    eye = eye.replace(aperture_diameter_m=85e-6, acceptance_angle_rad=0.05)
    kinds = [
        omma.receptors.OmmatidiumType("both", (green, blue), abundance=0.5),
        omma.receptors.OmmatidiumType("one", (green,), abundance=0.5),
    ]
    return omma.receptors.assign_receptors(eye, kinds, seed=1)


def test_views_of_facets_have_their_ommatidiums_receptors():
    eye = moth()
    assert set(np.diff(eye.first_receptor)) == {1, 2}
    views, wiring = omma.eye.superposition.superposition_facets(eye)
    of_receptors = omma.eye.superposition.receptor_wiring(views, wiring)
    assert len(of_receptors) == len(eye.receptor_type)
    owner = omma.receptors.ommatidium_of_receptor(eye)
    assert np.array_equal(of_receptors.members, wiring.members[owner])
    names = np.array([one.name for one in views.receptor_types])[views.receptor_type]
    wanted = np.array([one.name for one in eye.receptor_types])[eye.receptor_type]
    assert np.array_equal(names[of_receptors.index], np.repeat(wanted, of_receptors.members))
    # The ommatidium of what is pooled, slowly.
    of_view = np.repeat(np.arange(len(eye)), wiring.members)
    view = omma.receptors.ommatidium_of_receptor(views)[of_receptors.index]
    assert np.array_equal(of_view[view], np.repeat(owner, of_receptors.members))
    assert np.array_equal(of_receptors.weight, wiring.weight[view])


def test_receptors_pooled_answer_as_rgb_pooled_does(scene):
    eye = moth()
    views, wiring = omma.eye.superposition.superposition_facets(eye)
    renderer = omma.Renderer(scene, views, omma.Fixed(16), threads=2)
    pose = omma.look_at((0, 3, 0), (14, 0, -3))
    matrix = np.array([[0, 1, 0], [0, 0, 1]])[: len(views.receptor_types)]
    pooled = omma.eye.superposition.pool(
        renderer.render_receptors(pose, matrix=matrix),
        omma.eye.superposition.receptor_wiring(views, wiring),
    )
    rgb = omma.eye.superposition.pool(renderer.render(pose), wiring, axis=1)
    owner = omma.receptors.ommatidium_of_receptor(eye)
    expected = np.einsum("prc,rc->pr", rgb[:, owner], matrix[eye.receptor_type])
    assert np.ptp(expected) > 0.05
    # Both are sums in single precision.
    np.testing.assert_allclose(pooled, expected, atol=1e-6)


def test_catches_of_facets_add_up_to_the_apertures_by_area():
    """Σ D_f² / A² of an aperture's, in even light."""
    eye, light = moth(), omma.light.uniform_sky(1e15)
    views, wiring = omma.eye.superposition.superposition_facets(eye)

    def caught(one):
        ones = np.ones(len(one.receptor_type))
        return omma.receptors.photon_catch(one, ones, light, integration_time_s=0.01)

    of_receptors = omma.eye.superposition.receptor_wiring(views, wiring)
    summed = np.add.reduceat(caught(views)[of_receptors.index], of_receptors.first[:-1])
    areas = np.add.reduceat(wiring.weight, wiring.first[:-1]) / 85e-6**2
    owner = omma.receptors.ommatidium_of_receptor(eye)
    # Diameters are in single precision.
    np.testing.assert_allclose(summed, areas[owner] * caught(eye), rtol=1e-5)


def test_an_aperture_that_only_the_views_know_counts_no_photons():
    """As pages say: one facet's, by area (16 or 20 µm of 85)."""
    eye, light = moth(), omma.light.uniform_sky(1e15)
    told = eye.replace(aperture_diameter_m=0.0)
    _, wiring = omma.eye.superposition.superposition_facets(told, 85e-6)
    assert np.array_equal(wiring.first, omma.eye.superposition.superposition_facets(eye)[1].first)
    ones = np.ones(len(eye.receptor_type))
    by_facet, by_aperture = (
        omma.receptors.photon_catch(one, ones, light, integration_time_s=0.01)
        for one in (told, eye)
    )
    owner = omma.receptors.ommatidium_of_receptor(eye)
    share = (eye.facet_diameter_m.astype(np.float64) / eye.aperture_diameter_m)[owner] ** 2
    # Diameters are in single precision.
    np.testing.assert_allclose(by_facet, share * by_aperture, rtol=1e-5)


def test_receptor_wiring_says_what_lacks():
    views, wiring = omma.eye.superposition.superposition_facets(flat_eye(), 85e-6)
    with pytest.raises(omma.Error, match="views: expected receptors, found none; give them"):
        omma.eye.superposition.receptor_wiring(views, wiring)
    views, wiring = omma.eye.superposition.superposition_facets(moth())
    with pytest.raises(omma.Error, match=f"views: expected {len(views)}, .*found 3"):
        omma.eye.superposition.receptor_wiring(views.take([0, 1, 2]), wiring)
    count = len(views)
    mixed = omma.eye.superposition.Wiring([0, count], np.arange(count), np.ones(count))
    with pytest.raises(omma.Error, match="views: expected as many receptors in all of target 0"):
        omma.eye.superposition.receptor_wiring(views, mixed)
