"""The worked examples of acuity and light: their numbers, from the scripts' own functions."""

import math
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from conftest import load_script

import omma
from omma.species.facts import number

EXAMPLES = Path(__file__).resolve().parents[2] / "examples/python"
animal = cache(omma.species.make)


def load(name):
    return load_script(EXAMPLES / f"{name}.py")


def test_acuity_map_is_the_formula():
    acuity_map = load("acuity_map")
    eye = animal("honeybee_worker").eye.take(np.arange(0, 10_760, 7))
    for stripes in (30, 60):
        kept = acuity_map.modulation(eye, stripes)
        wanted = acuity_map.formula(eye, stripes)
        level = np.abs(eye.axis[:, 1]) < math.sin(math.radians(60))
        # 256 rays estimate a response to 0.003; that stripes fan out below 60° adds as much again.
        np.testing.assert_allclose(kept[level], wanted[level], atol=0.01)
        assert wanted[level].max() > 0.5
        assert wanted[level].min() < 0.55
    # Δρ 2.6° on the horizon at 60 stripes around, 1/6 cycle per degree.
    horizon = np.argmin(np.abs(eye.axis[:, 1]))
    assert kept[horizon] == pytest.approx(math.exp(-3.5597 * (2.6 / 6) ** 2), abs=0.01)


def test_who_sees_a_fly_at_a_metre():
    fly_at_a_metre = load("fly_at_a_metre")
    robber_fly = fly_at_a_metre.look(animal("holcocephala").eye)
    bee = fly_at_a_metre.look(animal("honeybee_worker").eye)
    assert [count for _, _, count in robber_fly] == sorted(
        (count for _, _, count in robber_fly), reverse=True
    )
    assert robber_fly[-1][0] == 1.0
    assert robber_fly[-1][2] >= 1
    assert bee[-1][2] == 0
    # A small disc in the middle of a Gaussian takes 1 - 2^-(d/Δρ)² of it, and no disc more.
    diameter = math.degrees(fly_at_a_metre.FLY_M)
    most = 1 - 2 ** -((diameter / 2.6) ** 2)
    assert 0.5 * most < bee[-1][1] <= 1.001 * most
    # 1 - 2^-(d/Δρ)² of an Airy disc's Gaussian of the same width, within a few per cent.
    width = math.degrees(1.029 * 500e-9 / 78e-6)
    assert robber_fly[-1][1] <= 1.05 * (1 - 2 ** -((diameter / width) ** 2))


def test_light_lost_against_drawn_rays():
    # The share of rays, drawn from the sensitivity itself, that meet the fly.
    fly_at_a_metre = load("fly_at_a_metre")
    eye = animal("holcocephala").eye
    lost = fly_at_a_metre.light_lost(eye, 0.2)
    for i in np.argsort(lost)[-3:]:
        rays = eye.acceptance(int(i)).sample(200_000, seed=1)  # x up, y right, z along the axis
        world = rays @ np.stack([eye.up[i], eye.right[i], eye.axis[i]])
        fly = np.array([0, 0, -0.2]) - eye.position_m[i]
        cosine = world @ (fly / np.linalg.norm(fly))
        radius = math.asin(fly_at_a_metre.FLY_M / 2 / np.linalg.norm(fly))
        met = np.mean(cosine > math.cos(radius))
        # Three standard deviations of 200,000 drawn rays, and 1 % for 300 points in the disc.
        assert lost[i] == pytest.approx(met, rel=0.01, abs=3 * math.sqrt(0.25 / 200_000))


def test_the_light_a_nocturnal_bee_gains():
    found = load("nocturnal_bee").sensitivities()
    # Somanathan et al. 2009 print 0.1 for the honeybee, 0.11 unrounded.
    assert found["honeybee"] * 1e12 == pytest.approx(0.11, rel=0.03)
    ratio = found["Megalopta"] / found["honeybee"]
    # Published as 27 times, of a sensitivity printed with one or two digits.
    assert ratio == pytest.approx(number("megalopta", "sensitivity_ratio"), rel=0.1)
    # Facets nearly twice as wide, rhabdoms 4 times: what the published ratios say.
    assert found["with wide facets"] / found["honeybee"] == pytest.approx(1.8**2, rel=1e-6)
    assert found["and wide rhabdoms"] / found["with wide facets"] == pytest.approx(4**2, rel=1e-6)


def test_pseudopupil_grows_with_the_eye_parameter():
    pseudopupil = load("pseudopupil")
    eye = animal("honeybee_worker").eye.select(1)
    shown, angle = pseudopupil.gaze(eye, omma.eye.direction(45, 0))
    # All of it: the integral of a Gaussian, Δρ²π/(4 ln 2), over a cell √3/2 Δφh Δφv of the lattice
    # with 2.4° in a row and rows 0.75° apart. A dozen facets sample that to 5 %.
    cell = 2.4 * 0.75
    assert shown.sum() == pytest.approx(2.6**2 * math.pi / (4 * math.log(2)) / cell, rel=0.05)
    assert (shown[angle > 2 * eye.acceptance_angle_rad] < 1e-4).all()
    azimuth, elevation = pseudopupil.finest(eye)
    assert 30 < azimuth < 60
    assert abs(elevation) < 5


@pytest.mark.parametrize(
    ("script", "arguments", "says"),
    [
        ("acuity_map", ["honeybee_worker"], "from the formula: median 0.00"),
        ("nocturnal_bee", None, "25.1 times"),
        ("pseudopupil", "honeybee_worker", "facets look back"),
    ],
)
def test_scripts_run(tmp_path, script, arguments, says):
    command = [sys.executable, str(EXAMPLES / f"{script}.py")]
    if isinstance(arguments, str):
        command += [str(tmp_path), arguments]
    elif arguments is not None:
        command += [*arguments, str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    assert says in done.stdout
    if arguments is not None:
        assert list(tmp_path.glob("*.png"))
