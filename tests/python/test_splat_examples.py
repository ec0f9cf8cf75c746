"""The worked example of Gaussian splats: its renderer against a slow one, training, comparison."""

import importlib
import math
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import omma
from omma.base.srgb import linear_of_srgb

pytest.importorskip("matplotlib", reason="the examples draw figures")
EXAMPLES = Path(__file__).resolve().parents[2] / "examples/python"


@pytest.fixture
def example(monkeypatch):
    """Imports a script of the examples, which import each other as they do when they are run."""
    monkeypatch.syspath_prepend(EXAMPLES)

    def load(name):
        if name != "compare_splats":
            pytest.importorskip("torch", reason="splats are trained by PyTorch: pip install torch")
        return importlib.import_module(name)

    return load


def random_view(pictures, torch, random):
    """A picture without content, turned at random, before a sky of noise."""
    frame, _ = np.linalg.qr(random.normal(size=(3, 3)))
    pixels = pictures.WIDTH * pictures.HEIGHT
    light = torch.from_numpy(random.random((2, pixels, 3)).astype("f4"))
    points = random.normal(size=(pixels, 3))
    as_float = torch.tensor(frame, dtype=torch.float32)
    return pictures.View(torch.zeros(3), as_float, light[0], light[1], points, np.ones(pixels))


def slow_light(values, sky, ray):
    """Linear RGB (3,) along one ray: all Gaussians, in double precision, as published."""
    met = []
    for position, scale, turn, opacity, color, slope in zip(*values):
        w, x, y, z = turn / np.linalg.norm(turn)
        vector = np.array([x, y, z])
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        rotation = (w * w - vector @ vector) * np.eye(3) + 2 * np.outer(vector, vector)
        rotation += 2 * w * cross
        inverse = np.linalg.inv(rotation @ np.diag(scale**2) @ rotation.T)
        t = ray @ inverse @ position / (ray @ inverse @ ray)
        off = t * ray - position
        alpha = min(0.99, opacity * math.exp(-0.5 * off @ inverse @ off))
        if alpha < 1 / 255 or t <= 0:
            continue
        x, y, z = position / np.linalg.norm(position)
        harmonics = math.sqrt(3 / (4 * math.pi)) * np.array([-y, z, -x])
        color = 0.5 + color / math.sqrt(4 * math.pi) + harmonics @ slope
        met.append((t, alpha, np.maximum(color, 0)))
    light, left = np.zeros(3), 1.0
    for _, alpha, color in sorted(met, key=lambda one: one[0]):
        light += left * alpha * color
        left *= 1 - alpha
    own = linear_of_srgb(light / (1 - left)) if left < 1 else light
    return (1 - left) * own + left * sky


def test_pictures_of_splats_are_those_of_a_slow_renderer(example):
    train, pictures = example("train_splats"), example("splat_pictures")
    torch, random = train.torch, np.random.default_rng(2)
    view = random_view(pictures, torch, random)
    splats = train.Splats([view], 60)
    with torch.no_grad():
        # Some around the camera, some larger than their distance, all of them long and turned.
        splats.start.copy_(torch.from_numpy(random.normal(size=(60, 3)) * 2))
        sizes = np.exp(random.normal(size=(60, 3)) - 1)
        for name, value in {
            "log_scale": np.log(sizes), "turn": random.normal(size=(60, 4)),
            "logit": random.normal(size=60) * 2, "color": random.normal(size=(60, 3)),
            "slope": 0.3 * random.normal(size=(60, 3, 3)),
        }.items():  # fmt: skip
            splats.trained[name].copy_(torch.from_numpy(value))
        names = ("turn", "logit", "color", "slope")
        turn, logit, color, slope = (splats.trained[name].double().numpy() for name in names)
        place = splats.positions().double().numpy()
        values = (place, sizes, turn, 1 / (1 + np.exp(-logit)), color, slope)
        for grid in (pictures.Grid(), pictures.Grid(2, 1, 0)):
            found = pictures.decode(train.render(splats, view, grid)).numpy()
            for i in range(5, len(grid.rays), len(grid.rays) // 40):
                ray = (grid.rays[i] @ view.frame).double().numpy()
                wanted = slow_light(values, view.sky[grid.pixels[i]].double().numpy(), ray)
                # Single precision; where little light is left, 1e-4 of it is not followed.
                np.testing.assert_allclose(found[i], wanted, atol=1e-3)


def test_curve_of_srgb(example):
    pictures = example("splat_pictures")
    value = pictures.torch.linspace(0, 1.5, 400)
    np.testing.assert_allclose(pictures.decode(value), linear_of_srgb(value.numpy()), rtol=1e-5)
    np.testing.assert_allclose(pictures.encode(pictures.decode(value)), value, atol=1e-5)


def test_rays_go_where_the_pictures_look(example):
    pictures = example("splat_pictures")
    scene = omma.load_scene(omma.examples.meadow())
    poses = [*pictures.poses_around(scene, 2, seed=4), scene.camera("bee").world_from_camera]
    for pose, view in zip(poses, pictures.take_pictures(scene, poses, samples=16)):
        rays = (pictures.Grid().rays @ view.frame).numpy()
        met = np.isfinite(view.points[:, 0])
        towards = view.points[met] - pose[:3, 3]
        # Positions are single precision, and some things are near the camera.
        towards /= np.linalg.norm(towards, axis=1, keepdims=True)
        np.testing.assert_allclose(towards, rays[met], atol=1e-4)
        eye = omma.Eye(np.zeros_like(rays), rays, pictures.PIXEL_RAD)
        place = np.eye(4)
        place[:3, 3] = pose[:3, 3]
        seen = omma.Renderer(scene, eye, omma.Fixed(16)).render(place)[0]
        picture = pictures.decode(view.picture).numpy()
        # Turned over or mirrored, pictures of grass are not alike at all; pixels are not round.
        assert np.corrcoef(seen[:, 1], picture[:, 1])[0, 1] > 0.7
        blank = ~met & (np.abs(picture - view.sky.numpy()).max(axis=1) < 0.01)
        assert blank.sum() >= 0.8 * (~met).sum()
    assert blank.any()


@pytest.fixture
def trained(example, tmp_path):
    example("train_splats")
    path = tmp_path / "splats.ply"
    command = [sys.executable, str(EXAMPLES / "train_splats.py"), "--quick", "-o", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    return path, done.stdout


def test_training_writes_files_of_splats(trained):
    path, said = trained
    before = float(re.search(r"before: held-out views at ([\d.]+) dB", said)[1])
    after = float(re.search(r"held-out views: 1, PSNR ([\d.]+) dB", said)[1])
    assert after > before + 1
    assert path.with_suffix(".png").is_file()
    head, _, body = path.read_bytes().partition(b"end_header\n")
    names = [line.split()[2] for line in head.decode().splitlines() if line[:8] == "property"]
    values = dict(zip(names, np.frombuffer(body, "<f4").reshape(-1, len(names)).T))
    arrays = np.load(path.with_suffix(".npz"))
    assert len(arrays["position_m"]) == len(values["x"]) == 400
    np.testing.assert_allclose(arrays["position_m"][:, 1], values["y"])
    np.testing.assert_allclose(arrays["scale_m"][:, 2], np.exp(values["scale_2"]), rtol=1e-6)
    np.testing.assert_allclose(arrays["opacity"], 1 / (1 + np.exp(-values["opacity"])), rtol=1e-5)
    np.testing.assert_allclose(arrays["quaternion_wxyz"][:, 0], values["rot_0"])
    # Harmonics 1 to 3 of red, then of green, then of blue.
    np.testing.assert_allclose(arrays["harmonics"][:, 2, 1], values["f_rest_4"])
    np.testing.assert_allclose(arrays["harmonics"][:, 0, 2], values["f_dc_2"])
    turn = np.stack([values[f"rot_{i}"] for i in range(4)])
    np.testing.assert_allclose(np.linalg.norm(turn, axis=0), 1, atol=1e-5)


def test_agreement_of_two_worlds(example, tmp_path):
    compare = example("compare_splats")
    scene = omma.load_scene(omma.examples.meadow())
    eye = omma.species.make("honeybee_worker").eye.take(np.arange(0, 10_760, 20))
    meadow = omma.Renderer(scene, eye, omma.Fixed(4))
    pose = scene.camera("bee").world_from_camera
    found, errors, where = compare.compare(meadow, meadow, eye, pose)
    relative, correlation, ratio = compare.agreement(*found)
    np.testing.assert_array_equal(relative, 0)
    np.testing.assert_allclose(correlation, 1, rtol=1e-5)
    np.testing.assert_array_equal(ratio, 1)
    # A tenth brighter everywhere.
    relative, correlation, ratio = compare.agreement(found[0], 1.1 * found[0])
    np.testing.assert_allclose(relative, 0.1, rtol=1e-4)
    np.testing.assert_allclose(correlation, 1, rtol=1e-5)
    np.testing.assert_allclose(ratio, 1.1, rtol=1e-4)
    up, down = where["above the horizon"], where["below the horizon"]
    assert (up ^ down).all()
    assert (where["  sky alone"] <= up).all()
    assert all(100 < one.sum() for one in (up, down))
    rows = compare.table(found, where, errors)
    assert len(rows) == len(where) + 1
    assert "0.0 %    0.0 %    0.0 %" in rows[1]
    compare.draw(tmp_path / "figure.png", eye, found, "twice the meadow")
    assert (tmp_path / "figure.png").stat().st_size > 10_000


def test_comparison_runs(trained, tmp_path):
    command = [sys.executable, str(EXAMPLES / "compare_splats.py"), str(trained[0])]
    command += ["-o", str(tmp_path / "bee.png"), "--samples", "1"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    assert "the nearest training camera was" in done.stdout
    assert (tmp_path / "bee.png").is_file()
