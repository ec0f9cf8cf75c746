"""The engine in WebAssembly gives the bits of the backend `portable`, and its messages.

In Node.js, by the modules that `scripts/web_engine` has built.
"""

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from conftest import write_gltf

import omma

ROOT = Path(__file__).resolve().parents[2]
ENGINE = ROOT / "build" / "web" / "engine"
EYE = ROOT / "examples" / "honeybee_worker_left.eye"
MODULES = ("omma", "omma_plain")  # that with threads is tested where they are, in browsers


def run(module, scene, eye, poses, out, first_frame=0, widths=None, **options):
    """What the module answers, and its responses."""
    if shutil.which("node") is None or not (ENGINE / f"{module}.js").is_file():
        pytest.skip(f"Node.js or build/web/engine/{module}.js is not there: scripts/web_engine")
    request = {
        "module": str(ENGINE / f"{module}.js"),
        "scene": str(scene),
        "eye": str(eye),
        "widths": widths,
        "options": options,
        "poses": [pose.ravel().tolist() for pose in poses],
        "first_frame": first_frame,
        "responses": str(out),
    }
    command = ["node", ROOT / "web" / "engine" / "run.mjs"]
    done = subprocess.run(command, input=json.dumps(request), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    answer = json.loads(done.stdout)
    return answer, None if "error" in answer else np.fromfile(out, np.float32)


def native(scene, eye, poses, first_frame=0, rays=16, error=False, kernel="own", **options):
    renderer = omma.Renderer(
        omma.load_scene(scene),
        omma.load_eye(eye),
        omma.Fixed(rays),
        backend="portable",
        angular_sensitivity=kernel,
        **options,
    )
    frames = renderer.render(poses, first_pose=first_frame, standard_error=error)
    return np.ravel(np.stack(frames, axis=1) if error else frames)


@pytest.fixture(scope="module")
def flight():
    return np.asarray(omma.load_poses(omma.examples.flight()))[[0, 55]]


@pytest.fixture(scope="module")
def few(tmp_path_factory):
    """A tenth of a honeybee's eye."""
    path = tmp_path_factory.mktemp("eyes") / "few.csv"
    omma.save_eye(path, omma.load_eye(EYE).take(np.arange(0, 5380, 10)))
    return path


@pytest.mark.parametrize("module", MODULES)
def test_bits_in_the_meadow(module, flight, few, tmp_path):
    # Textures, cut-outs, instances, a sky.
    options = {"rays": 5, "seed": 3, "noise": "new_every_frame"}
    scene = omma.examples.meadow()
    answer, found = run(module, scene, few, flight, tmp_path / "out", 7, **options)
    assert answer["build"] == {"simd": module == "omma", "threads": False}
    assert answer["info"]["rays_per_frame"] == 5 * 538
    assert answer["info"]["threads"] == 1
    expected = native(scene, few, flight, 7, **options)
    assert np.array_equal(found.view(np.uint32), expected.view(np.uint32))


@pytest.mark.parametrize(
    "options",
    [
        {"rays": 4, "error": True},
        {"rays": 4, "kernel": "pillbox", "footprints": False},
        {"rays": 4, "kernel": "compoundray"},
        {"rays": 4, "points": "random"},
    ],
    ids=["error", "pillbox", "compoundray", "random"],
)
def test_bits_of_an_arena(options, few, tmp_path):
    scene = write_gltf(tmp_path / "arena.gltf")
    pose = omma.look_at((1, 2, 3), (0, 0, 0))[None]
    _, found = run("omma", scene, few, pose, tmp_path / "out", **options)
    expected = native(scene, few, pose, **options)
    assert found.max() > 0
    assert np.array_equal(found.view(np.uint32), expected.view(np.uint32))


def test_acceptances_of_lenses(tmp_path):
    # Their tables are made with Bessel functions and powers, which C libraries round differently,
    # in the last digit of a double. A direction in single precision may then be its neighbour, and
    # a ray that grazes an edge meet its other side: one ray of 64 in an ommatidium, no more than
    # one ommatidium in fifty. On the day this was written no bit differed.
    acceptance = omma.Acceptance.lens_rhabdom(
        facet_diameter_m=25e-6, wavelength_nm=500, focal_length_m=66e-6, rhabdom_diameter_m=2e-6
    )
    axes = omma.load_eye(EYE).axis[::50]
    eye = omma.Eye(position_m=np.zeros_like(axes), axis=axes, acceptance=acceptance)
    omma.save_eye(tmp_path / "lens.csv", eye)
    scene = write_gltf(tmp_path / "arena.gltf")
    pose = omma.look_at((1, 2, 3), (0, 0, 0))[None]
    _, found = run("omma", scene, tmp_path / "lens.csv", pose, tmp_path / "out", rays=64)
    expected = native(scene, tmp_path / "lens.csv", pose, rays=64)
    far = np.abs(found - expected) > 1e-6
    assert np.count_nonzero(far) <= len(expected) // 50
    assert np.abs(found - expected).max() <= 1 / 64 + 1e-6


def test_receptors_by_type(tmp_path):
    # The engine mixes red, green and blue before they are rounded to single precision, Python may
    # do so afterwards: three roundings and that of the sum, each of 2^-24.
    eye = omma.load_eye(EYE).take(np.arange(0, 5380, 50))
    green = omma.receptors.ReceptorType("green", peak_wavelength_nm=540)
    blue = omma.receptors.ReceptorType("blue", peak_wavelength_nm=440)
    kinds = [[0, 1], [0]] * (len(eye.axis) // 2)
    eye = eye.replace(receptor_types=[green, blue], receptors=kinds)
    omma.save_eye(tmp_path / "eye.csv", eye)
    scene = write_gltf(tmp_path / "arena.gltf")
    pose = omma.look_at((1, 2, 3), (0, 0, 0))[None]
    answer, found = run(
        "omma", scene, tmp_path / "eye.csv", pose, tmp_path / "out", rays=4, receptors=True
    )
    assert answer["info"]["labels"] == ["green", "blue"]
    renderer = omma.Renderer(
        omma.load_scene(scene), omma.load_eye(tmp_path / "eye.csv"), omma.Fixed(4),
        backend="portable",
    )  # fmt: skip
    expected = np.ravel(renderer.render_receptors(pose))
    responses = found.reshape(-1, 2)
    assert np.array_equal(np.isnan(responses), [[False, len(kind) == 1] for kind in kinds])
    assert np.allclose(found[~np.isnan(found)], expected, rtol=4 * 2**-24, atol=0)


def test_receptors_beside_the_axis(tmp_path):
    # As above; each receptor looks by rays of its own.
    ahead = omma.receptors.ReceptorType("R8", peak_wavelength_nm=540)
    beside = omma.receptors.ReceptorType("R1", peak_wavelength_nm=478, right_rad=0.1, up_rad=-0.05)
    wide = omma.receptors.ReceptorType(
        "R7", peak_wavelength_nm=440, acceptance=omma.Acceptance.gaussian(0.2)
    )
    eye = omma.load_eye(EYE).take(np.arange(0, 5380, 100))
    kinds = [[0, 1], [1, 2]] * (len(eye.axis) // 2)
    eye = eye.replace(receptor_types=[ahead, beside, wide], receptors=kinds)
    path = tmp_path / "eye.csv"
    omma.save_eye(path, eye)
    scene = write_gltf(tmp_path / "arena.gltf")
    pose = omma.look_at((1, 2, 3), (0, 0, 0))[None]
    answer, found = run("omma", scene, path, pose, tmp_path / "out", rays=4, receptors=True)
    renderer = omma.Renderer(
        omma.load_scene(scene), omma.load_eye(path), omma.Fixed(4), backend="portable"
    )
    expected = np.ravel(renderer.render_receptors(pose))
    assert answer["info"]["labels"] == ["R8", "R1", "R7"]
    assert np.isnan(found.reshape(-1, 3)).tolist() == [
        [t not in k for t in range(3)] for k in kinds
    ]
    assert np.allclose(found[~np.isnan(found)], expected, rtol=4 * 2**-24, atol=0)
    assert np.count_nonzero(expected) > len(expected) // 4


@pytest.mark.parametrize("kind", ["lens_rhabdom", "airy", "table", "gaussian"])
def test_acceptances_of_every_kind_are_scaled(kind, tmp_path):
    made = {
        "lens_rhabdom": lambda k: omma.Acceptance.lens_rhabdom(
            facet_diameter_m=25e-6 / k, wavelength_nm=500, focal_length_m=66e-6 / k,
            rhabdom_diameter_m=2e-6,
        ),
        "airy": lambda k: omma.Acceptance.airy(facet_diameter_m=25e-6 / k, wavelength_nm=500),
        "table": lambda k: omma.Acceptance.table([0, 0.02 * k, 0.05 * k], [1, 0.4, 0]),
        "gaussian": lambda k: omma.Acceptance.gaussian(
            0.05 * k, minor_width_rad=0.03 * k, major_angle_rad=1
        ),
    }[kind]  # fmt: skip
    axes = omma.load_eye(EYE).axis[::100]
    paths = [tmp_path / "one.csv", tmp_path / "two.csv"]
    for k, path in zip((1, 2), paths, strict=True):
        eye = omma.Eye(position_m=np.zeros_like(axes), axis=axes, acceptance=made(k))
        omma.save_eye(path, eye)
    scene = write_gltf(tmp_path / "arena.gltf")
    pose = omma.look_at((1, 2, 3), (0, 0, 0))[None]
    scaled, found = run("omma", scene, paths[0], pose, tmp_path / "out", widths=2, rays=4)
    _, wanted = run("omma", scene, paths[1], pose, tmp_path / "out", rays=4)
    assert np.array_equal(found.view(np.uint32), wanted.view(np.uint32))
    # Lenses scale in the sine, the others in the angle. Widths are found to 1e-6 of themselves.
    half = omma.load_eye(paths[0]).acceptance_angle_rad[0] / 2
    is_lens = kind in ("lens_rhabdom", "airy")
    width = 2 * np.arcsin(2 * np.sin(half)) if is_lens else 4 * half
    assert scaled["acceptance_rad"] == pytest.approx(width, rel=1e-5)


@pytest.mark.parametrize("broken", ["scene", "eye"])
def test_messages_of_broken_files(broken, tmp_path):
    scene, eye = write_gltf(tmp_path / "arena.gltf"), tmp_path / "eye.eye"
    eye.write_text("0 0 0 0 0 1 0.02 0\n")
    if broken == "scene":
        scene = tmp_path / "cut.glb"
        scene.write_bytes(omma.examples.meadow().read_bytes()[:1000])
    else:
        eye.write_text("0 0 0 0 0 1 wide 0\n")
    answer, _ = run("omma", scene, eye, np.eye(4)[None], tmp_path / "out")
    with pytest.raises(omma.Error) as error:
        omma.load_scene(scene)
        omma.load_eye(eye)
    assert answer["error"] == str(error.value).replace(f"{tmp_path}/", "")


def test_memory_is_steady(few, tmp_path):
    poses = [omma.look_at((1, 2, 3), (0, 0, 0))] * 50
    scene = write_gltf(tmp_path / "arena.gltf")
    answer, _ = run("omma", scene, few, poses, tmp_path / "out", rays=4)
    # What the first frame asks for lies within what there is; the others ask for the same.
    assert answer["memory_bytes"][0] == answer["memory_bytes"][1]


def test_options_that_are_wrong(few, tmp_path):
    scene = write_gltf(tmp_path / "arena.gltf")
    for options, message in [
        ({"ray": 4}, "options: expected rays, receptors, error, seed, kernel, points, threads, "
                     "footprints, noise, found ray"),
        ({"rays": 1.5}, "rays: expected a whole number in its range, found 1.5"),
        ({"kernel": "round"}, "kernel: expected one of own, gaussian, pillbox, compoundray, found "
                              "round"),
        ({"receptors": True}, "receptors: expected an eye with receptors, found none"),
    ]:  # fmt: skip
        answer, _ = run("omma", scene, few, np.eye(4)[None], tmp_path / "out", **options)
        assert answer["error"] == message
