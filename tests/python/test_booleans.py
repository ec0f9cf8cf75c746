"""True and False are no numbers and no indices: who gives them has mistaken an argument."""

import numpy as np
import pytest

import omma

EYE = omma.eye.generate_eye(20)


@pytest.mark.parametrize(
    ("message", "call"),
    [
        # Masks and flags where indices are asked.
        ("pairs", lambda: omma.motion.detector_array(EYE, 0.03, 500, pairs=[[True, False]])),
        (r"shares\[0\]", lambda: ground_truth(shares=[True])),
        ("velocities", lambda: ground_truth(velocities={True: ((0, 0, 0), (0, 0, 0))})),
        ("image", lambda: picture_world().set_image(True, np.zeros((2, 2, 3), np.uint8))),
        # And where numbers are.
        ("wind_m_per_s", lambda: omma.scene.water("3C", wind_m_per_s=True)),
        ("count", lambda: omma.eye.generate_eye(True)),
        ("samples", lambda: omma.Fixed(True)),
        ("count", lambda: omma.light.Bands.equal(np.True_)),
        ("color", lambda: omma.Background.constant([True] * 3)),
        ("acceptance_angle_rad", lambda: omma.Eye([(0, 0, 0)], [(0, 0, -1)], True)),
        ("acceptance_angle_rad", lambda: EYE.replace(acceptance_angle_rad=True)),
        ("axis", lambda: EYE.replace(axis=np.ones((20, 3), bool))),
        ("yaw_pitch_roll_deg", lambda: omma.poses_from_angles((0, 0, 0), True)),
    ],
)
def test_they_are_refused(message, call):
    with pytest.raises((omma.Error, TypeError), match=f"^{message}: expected .*(True|bool)"):
        call()


def test_they_are_taken_where_they_mean_something():
    footprints = omma.Renderer(omma.scene.plane(), EYE, omma.Fixed(1), footprints=np.True_)
    assert footprints.settings.footprints
    assert len(EYE.take(np.arange(20) < 5)) == 5


def ground_truth(**asked):
    return omma.Renderer(omma.scene.plane(), EYE, omma.Fixed(1)).ground_truth(np.eye(4), **asked)


def picture_world():
    return omma.World(omma.scene.plane(paint=np.zeros((2, 2, 3), np.uint8)))
