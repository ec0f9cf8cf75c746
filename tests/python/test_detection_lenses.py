"""Detection near the head, where lenses lie beside its middle: against sums over the disc of
Gaussians that look from where each lens is."""

import math

import numpy as np
import pytest
from detection_cases import LIGHT, WIDTH_RAD, bee, catches, root

import omma
from omma.colour_vision import DiscTarget, Observer

GREEN = Observer(by="achromatic", receptors=("green",), ommatidia=1)


def placed(axes, position_m):
    """Ommatidia of a honeybee's receptors whose lenses are beside the head's middle."""
    return bee(axes).replace(position_m=np.broadcast_to(position_m, (len(axes), 3)))


def fan(yaws_deg):
    yaw = np.radians(np.asarray(yaws_deg, float))
    return np.stack([np.sin(yaw), 0 * yaw, -np.cos(yaw)], axis=1)


def shares(eye, radius_m, distance_m):
    """Of the Gaussian of each ommatidium on a disc straight ahead of the head, by a grid of it."""
    r, turn = np.meshgrid((np.arange(60) + 0.5) / 60 * radius_m, np.radians(np.arange(0, 360, 3)))
    points = np.stack([r * np.cos(turn), r * np.sin(turn), np.full_like(r, -distance_m)], axis=-1)
    area = r * radius_m / 60 * math.radians(3)
    found = []
    for axis, lens, width in zip(
        eye.axis.astype(float), eye.position_m.astype(float), eye.acceptance_angle_rad, strict=True
    ):
        ray = points - lens
        length = np.linalg.norm(ray, axis=-1)
        off = np.arccos(np.clip(ray @ axis / length, -1, 1))
        solid = area * -ray[..., 2] / length**3
        whole = omma.receptors.solid_angle_sr(float(width))
        found.append(float(np.sum(solid * np.exp(-4 * math.log(2) * (off / width) ** 2)) / whole))
    return np.array(found)


def looks_nearest(eye, count, distance_m):
    towards = np.array([0, 0, -distance_m]) - eye.position_m
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    return np.argsort(-np.sum(eye.axis * towards, axis=1), kind="stable")[:count]


def expected_m(eye, count, radius_m, greys, light):
    """From where the green receptors of those that look nearest just tell the disc."""
    green, of = eye.receptor_type == 2, omma.receptors.ommatidium_of_receptor(eye)
    ground, disc = (
        np.bincount(of[green], catches(eye, one, 0.03, light)[green], minlength=len(eye))
        for one in greys
    )

    def excess(distance_m):
        which = looks_nearest(eye, count, distance_m)
        share = shares(eye.take(which), radius_m, distance_m)
        all_of = ground[which].sum()
        more = np.sum((disc - ground)[which] * share)
        apart = omma.colour_vision.achromatic_distance(
            all_of + more, all_of, 0.1, photon_noise=True
        )
        return float(apart) - 1

    return root(excess, 0.02, 1)


def agrees(found, distance_m):
    """Within four standard errors, and what the grid leaves."""
    assert 0 < found.standard_error_m < 0.02 * distance_m
    assert found.distance_m == pytest.approx(
        distance_m, abs=4 * found.standard_error_m + 1e-3 * distance_m
    )


@pytest.mark.parametrize("diameter_m", [0.001, 0.002, 0.004])
def test_the_ommatidium_that_looks_nearest_is_found_at_each_distance(diameter_m):
    # From 2 mm to the right of the middle a target 3 cm ahead is 4 degrees to the left.
    eye = placed(fan(np.arange(-14, 15, 1.0)), (0.002, 0.0, 0.0))
    found = omma.detect(eye, DiscTarget(diameter_m, 0.1, 0.3), LIGHT, GREEN)
    agrees(found, expected_m(eye, 1, diameter_m / 2, (0.3, 0.1), LIGHT))


def test_small_targets_near_a_honeybee():
    """They were told as never seen, as the seven that look ahead from the head's middle look past
    them."""
    eye, light = omma.species.honeybee_worker().eye, omma.light.uniform_sky(1e20)
    eye = eye.take(np.flatnonzero(eye.axis[:, 2] < -0.94))  # that are within 20° of ahead
    by = Observer(by="achromatic", receptors=("green",))
    found = omma.detect(eye, DiscTarget(0.002, 0.2, 0.3), light, by, sampling=omma.Fixed(256))
    agrees(found, expected_m(eye, 7, 0.001, (0.3, 0.2), light))


@pytest.mark.parametrize(("by", "criterion"), [("photons", 2.0), ("achromatic", 0.5)])
def test_a_target_that_is_told_farther_off_than_the_nearest_distance(by, criterion):
    # Both eyes look straight ahead, past what is between them.
    axes = [(0.0, 0.0, -1.0)] * 2
    eye = placed(axes, np.array([(0.002, 0.0, 0.0), (-0.002, 0.0, 0.0)]))
    observer = Observer(by=by, receptors=("green",), ommatidia=2, criterion=criterion)
    found = omma.detect(eye, DiscTarget(0.002, 0.02, 0.5), LIGHT, observer)
    assert shares(eye, 0.001, 0.01).max() < 1e-6
    green = catches(eye, 1.0, 0.03)[eye.receptor_type == 2].sum()

    def excess(distance_m):
        more = (0.02 - 0.5) * green * shares(eye, 0.001, distance_m)[0]
        ground = 0.5 * green
        if by == "photons":
            return abs(more) / math.sqrt(ground + more / 2) - criterion
        apart = omma.colour_vision.achromatic_distance(
            ground + more, ground, 0.1, photon_noise=True
        )
        return apart - criterion

    assert excess(0.01) < 0 < excess(0.06)
    agrees(found, root(excess, 0.06, 10))


def test_an_ommatidium_of_one_ray_keeps_no_other_from_being_asked():
    eye = placed(fan([0.0, 90.0]), (0.0, 0.0, 0.0)).replace(acceptance_angle_rad=[WIDTH_RAD, 0.0])
    found = omma.detect(eye, DiscTarget(0.004, 0.02, 0.5), LIGHT, GREEN)
    assert found == omma.detect(eye.take([0]), DiscTarget(0.004, 0.02, 0.5), LIGHT, GREEN)


def test_receptors_that_only_far_ones_have_are_no_error_near_the_head():
    axes = fan([0.0, -12.0])
    eye = placed(axes, (0.002, 0.0, 0.0)).replace(receptors=[[0, 1, 2], [0, 1]])
    found = omma.detect(eye, DiscTarget(0.004, 0.02, 0.5), LIGHT, GREEN)
    assert found.distance_m > 0.02
    assert WIDTH_RAD < math.atan(0.002 / 0.01)
    backward = eye.replace(receptors=[[0, 1], [0, 1, 2]])
    with pytest.raises(omma.Error, match="expected some with the receptor green, found none"):
        omma.detect(backward, DiscTarget(0.004, 0.02, 0.5), LIGHT, GREEN)
