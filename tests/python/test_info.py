"""What ``omma info`` says of scenes and eyes."""

import re

import numpy as np
import pytest
from conftest import make_eye

import omma


def test_info_of_a_scene(omma_command):
    code, out, err = omma_command("info", "scene.gltf")
    assert (code, err) == (0, "")
    for what, words in [
        ("nodes", "3"),
        ("triangles", "2"),
        ("meshes", "1 in 1 instances"),
        ("textures", "0"),
        ("bounds", "(-10, 0, -10) to (10, 0, 10) m"),
        ("background", "simple sky"),
        ("camera", "0 plain: perspective at (0, 1, 0) m"),
        ("camera", "1 insect: compound at (1, 2, 3) m, scale 0.5, eye bug.eye"),
    ]:
        assert re.search(f"^{what} +{re.escape(words)}", out, re.MULTILINE)


def test_info_of_an_eye(omma_command, tmp_path):
    # A row of axes each 3 degrees from -30 to 30 and from straight behind to the right.
    azimuth = np.radians(np.arange(-30, 31, 3))
    axis = np.stack([np.sin(azimuth), 0 * azimuth, -np.cos(azimuth)], axis=1)
    acceptance = np.radians(np.linspace(1, 3, 21))
    omma.save_eye(tmp_path / "row.eye", omma.Eye(axis * 1e-3, axis, acceptance))
    code, out, err = omma_command("info", tmp_path / "row.eye")
    assert (code, err) == (0, "")
    assert re.search(r"^ommatidia +21$", out, re.MULTILINE)
    assert re.search(r"^azimuth +-30\.0° to 30\.0°", out, re.MULTILINE)
    assert re.search(r"^elevation +0\.0° to 0\.0°", out, re.MULTILINE)
    assert not re.search(r"^(acceptance|interommatidial|field) ", out, re.MULTILINE)  # eye info
    assert re.search(r"^more +omma eye info \S*row.eye", out, re.MULTILINE)


def test_info_of_an_eye_with_receptors_and_columns(omma_command, tmp_path):
    eye = omma.receptors.assign_receptors(make_eye(), omma.receptors.honeybee_ommatidia())
    omma.save_eye(tmp_path / "bee.csv", eye.replace(columns={"age_days": np.zeros(60)}))
    code, out, _ = omma_command("info", tmp_path / "bee.csv")
    assert code == 0
    assert re.search(r"^receptors +[\d,]+ of .", out, re.MULTILINE)
    assert re.search(r"^columns +age_days$", out, re.MULTILINE)


def test_azimuth_range_goes_the_short_way_round():
    from omma.job.info import azimuth_range_deg

    assert azimuth_range_deg(np.array([170.0, -170, 180])) == (170, 190)
    assert azimuth_range_deg(np.array([-170.0, -100, 175])) == (-185, -100)
    assert azimuth_range_deg(np.array([])) == (0, 0)


@pytest.mark.parametrize(
    ("azimuth", "says"),
    [
        (np.arange(100, 261, 5), "100.0° to -100.0° through straight behind, right is +"),
        (np.arange(0, 360, 5), "all round"),
        (np.arange(-73, 40, 1), "-73.0° to 39.0°, right is +"),
    ],
)
def test_azimuths_are_told_from_180_to_180(azimuth, says):
    turn = np.radians(azimuth.astype(float))
    axis = np.stack([np.sin(turn), 0 * turn, -np.cos(turn)], axis=1)
    eye = omma.Eye(axis * 1e-3, axis, np.full(len(turn), 0.1))
    from omma.job.info import describe_eye

    assert dict(describe_eye(eye))["azimuth"].startswith(says)
