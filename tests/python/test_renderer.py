"""The renderer from Python: shapes, memory, arguments, determinism, iteration."""

import threading
import time

import numpy as np
import pytest
from conftest import make_eye
from hypothesis import given, settings
from hypothesis import strategies as st

import omma


@pytest.mark.parametrize("angular_sensitivity", ["gaussian", "pillbox", "compoundray"])
@pytest.mark.parametrize("sampling", ["low_discrepancy", "random"])
@pytest.mark.parametrize("samples", [1, 7, 16])
def test_even_surround_gives_one(angular_sensitivity, sampling, samples):
    rng = np.random.default_rng(0)
    eye = omma.Eye(
        rng.normal(size=(50, 3)), rng.normal(size=(50, 3)), rng.uniform(0.001, 6, 50), 0.01
    )
    renderer = omma.Renderer(
        omma.Scene(),
        eye,
        omma.Fixed(samples),
        angular_sensitivity=angular_sensitivity,
        points=sampling,
        background=omma.Background.constant((1, 1, 1)),
    )
    responses, errors = renderer.render(np.eye(4), standard_error=True)
    assert np.abs(responses - 1).max() <= 1e-6
    assert errors.max() <= 1e-6


def test_shapes(renderer, flight):
    assert renderer.render(flight).shape == (9, 60, 3)
    assert renderer.render(flight[0]).shape == (1, 60, 3)
    assert renderer.render(flight[:0]).shape == (0, 60, 3)
    assert renderer.render(flight.tolist()).dtype == np.float32
    responses, errors = renderer.render(flight, standard_error=True)
    assert responses.shape == errors.shape == (9, 60, 3)
    assert (errors >= 0).all()
    assert errors.max() > 0


def test_forms_of_poses(renderer, scene):
    turn = np.array([0.1, -0.2, 0.3, 0.9])
    positions = np.array([[0, 1, 0], [1, 2, 3.0]])
    matrices = omma.poses_from_quaternions(positions, np.stack([turn, turn]))
    expected = renderer.render(matrices)
    assert (renderer.render((positions, np.stack([turn, turn]))) == expected).all()
    # A pair of matrices is no pair of positions and quaternions.
    assert (renderer.render((matrices[0], matrices[1])) == expected).all()
    named = renderer.render("insect")
    assert (named == renderer.render(scene.camera("insect").world_from_camera)).all()


def test_scale_of_a_pose_applies_to_the_eye(scene):
    # Straight down onto the coloured ground, from x = 4 at half scale and from x = 2.
    def seen(x, scale):
        eye = omma.Eye([[x, 0, 0]], [[0, -1, 0]], np.radians(0.01))
        pose = np.diag([scale, scale, scale, 1])
        pose[1, 3] = 1
        return omma.Renderer(scene, eye).render(pose)[0, 0]

    # The spot on the ground is 0.2 mm wide, and colours change by 1 over 20 m.
    assert seen(4, 0.5) == pytest.approx(seen(2, 1), abs=1e-4)
    assert seen(4, 1) != pytest.approx(seen(2, 1), abs=0.01)


def test_out_is_written_to_and_returned(renderer, flight):
    out = np.full((9, 60, 3), np.nan, np.float32)
    error_out = np.full((9, 60, 3), np.nan, np.float32)
    assert renderer.render(flight, out=out) is out
    assert (out == renderer.render(flight)).all()
    responses, errors = renderer.render(flight, standard_error=True, out=out, error_out=error_out)
    assert responses is out
    assert errors is error_out
    assert np.isfinite(error_out).all()


def test_wrong_out(renderer, flight):
    right = (9, 60, 3)
    readonly = np.zeros(right, np.float32)
    readonly.flags.writeable = False
    for out, kind, word in [
        (np.zeros(right), TypeError, "float64"),
        ([1, 2], TypeError, "list"),
        (np.zeros((9, 60), np.float32), omma.Error, r"\(9, 60, 3\), found \(9, 60\)"),
        (np.zeros((3, 60, 9), np.float32).T, omma.Error, "C-contiguous array, found strides"),
        (readonly, omma.Error, "can be written to, found one that is read-only"),
    ]:
        with pytest.raises(kind, match=word):
            renderer.render(flight, out=out)
    good = np.zeros(right, np.float32)
    with pytest.raises(omma.Error, match="error_out"):
        renderer.render(flight, error_out=good)
    with pytest.raises(omma.Error, match="shares memory"):
        renderer.render(flight, standard_error=True, out=good, error_out=good)


@pytest.mark.parametrize(
    ("poses", "word"),
    [
        (np.zeros((3, 3)), r"\(P, 4, 4\) or \(4, 4\).*found shape \(3, 3\)"),
        (np.zeros((2, 4, 3)), r"found shape \(2, 4, 3\)"),
        (np.full((4, 4), np.nan), "pose 0"),
        (omma.look_at((1, 2, 3), (0, 0, 0)).T, "last row.*translation belongs"),
        (np.full((4, 4), np.nan), "^poses: pose 0 is not finite, its last row is"),
        (np.diag([0.0, 1, 1, 1]), "invertible"),
        (np.diag([np.inf, 1, 1, 1]), "finite"),
        ("nobody", "nobody"),
        (([[0, 0, 0]], [[0, 0, 0, 0]]), "length 0"),
        (([[0, 0, 0]] * 2, [[0, 0, 0, 1]] * 3), "as many rows"),
        (([[0, 0, np.nan]], [[0, 0, 0, 1]]), "positions_m.*finite"),
        (([[0, 0, 0]], [[0, 0, 1]]), r"quaternions: expected shape \(P, 4\)"),
        (None, "poses"),
        ([[1, 2], [3]], "poses"),
    ],
)
def test_wrong_poses(renderer, poses, word):
    with pytest.raises(omma.Error, match=word):
        renderer.render(poses)


@pytest.mark.parametrize(
    ("changes", "kind", "word"),
    [
        ({"sampling": 16}, TypeError, "sampling: expected omma.Fixed, omma.ToError or omma.Shared"),
        ({"samples": 16}, TypeError, "samples"),
        ({"footprints": 1}, TypeError, "footprints: expected True or False"),
        ({"seed": -1}, omma.Error, "seed"),
        ({"seed": 1 << 64}, omma.Error, "seed"),
        ({"threads": -1}, omma.Error, "threads"),
        (
            {"angular_sensitivity": "box"},
            omma.Error,
            "angular_sensitivity: expected one of own, gaussian, pillbox, compoundray",
        ),
        ({"points": "sobol"}, omma.Error, "points: expected one of low_discrepancy, random"),
        ({"background": (1, 1, 1)}, TypeError, "background: expected omma.Background"),
        ({"eye": "bee.eye"}, TypeError, "eye: expected omma.Eye.*found str.*omma.load_eye"),
        ({"eye": []}, omma.Error, "at least one eye"),
        ({"scene": "meadow.glb"}, TypeError, "scene: expected omma.Scene or omma.World, found str"),
    ],
)
def test_wrong_arguments(scene, eye, changes, kind, word):
    arguments = {"scene": scene, "eye": eye} | changes
    with pytest.raises(kind, match=word):
        omma.Renderer(**arguments)


def test_footprints_read_fine_textures_without_noise(eye):
    rng = np.random.default_rng(5)
    picture = np.repeat(rng.uniform(size=(1024, 2048, 1)), 3, axis=2)
    background = omma.Background.image(picture.astype(np.float32))
    renderer = omma.Renderer(omma.Scene(), eye, background=background, noise="new_every_frame")
    assert renderer.settings.footprints
    point_by_point = renderer.with_eye(eye, footprints=False)
    assert not point_by_point.settings.footprints
    assert not point_by_point.with_eye(eye).settings.footprints
    poses = np.broadcast_to(np.eye(4), (200, 4, 4))
    noise = renderer.render(poses).std(axis=0).mean()
    # Pixels of 0.18 degrees; the footprints of the eye's ommatidia hold several.
    assert noise < 0.8 * point_by_point.render(poses).std(axis=0).mean()


def test_settings_can_be_read(scene, eye):
    renderer = omma.Renderer(
        scene,
        [eye, eye],
        omma.Fixed(4),
        seed=9,
        angular_sensitivity="pillbox",
        points="random",
        threads=2,
    )
    assert renderer.settings == omma.rendering.Settings(
        omma.Fixed(4), seed=9, angular_sensitivity="pillbox", points="random"
    )
    assert renderer.threads == 2
    assert renderer.scene is scene
    assert len(renderer.eye) == 120
    assert renderer.backend.startswith("embree")
    assert set(renderer.build_times) == {"scene_s", "acceleration_s", "directions_s"}
    assert "120 ommatidia" in repr(renderer)


def test_renderer_outlives_what_it_was_made_from(flight, files):
    renderer = omma.Renderer(omma.load_scene(files / "scene.gltf"), make_eye())
    axis = renderer.eye.axis
    expected = axis.copy()
    assert np.isfinite(renderer.render(flight)).all()
    del renderer
    assert (axis == expected).all()


def test_same_bits_for_any_number_of_threads(scene, eye, flight):
    results = [omma.Renderer(scene, eye, threads=n).render(flight) for n in (1, 2, 7)]
    assert (results[0] == results[1]).all()
    assert (results[0] == results[2]).all()
    assert (omma.Renderer(scene, eye, seed=1).render(flight) != results[0]).any()


@settings(max_examples=20, deadline=None)
@given(st.integers(1, 12), st.booleans(), st.sampled_from([np.asarray, iter, list, tuple]))
def test_render_iter_equals_render(renderer, flight, chunk, standard_error, form):
    renderer = renderer.with_eye(renderer.eye, noise="new_every_frame")
    whole = renderer.render(flight, standard_error=standard_error, first_pose=5)
    pieces = list(
        renderer.render_iter(form(flight), chunk=chunk, standard_error=standard_error, first_pose=5)
    )
    assert len(pieces) == 9
    if standard_error:
        assert (np.array([piece[0] for piece in pieces]) == whole[0]).all()
        assert (np.array([piece[1] for piece in pieces]) == whole[1]).all()
    else:
        assert (np.array(pieces) == whole).all()


def test_render_iter_takes_poses_as_it_needs_them(renderer, flight):
    taken = 0

    def endless():
        nonlocal taken
        while True:
            taken += 1
            yield flight[0]

    responses = renderer.render_iter(endless(), chunk=4)
    assert next(responses).shape == (60, 3)
    assert taken == 4
    positions, turns = np.zeros((3, 3)), np.array([[0, 0, 0, 1.0]] * 3)
    assert len(list(renderer.render_iter((positions, turns)))) == 3
    assert len(list(renderer.render_iter("plain"))) == 1


def test_render_iter_names_the_pose_that_is_wrong(renderer, flight):
    wrong = flight.copy()
    wrong[7, 3, 0] = 1
    with pytest.raises(omma.Error, match="pose 7"):
        list(renderer.render_iter(iter(wrong), chunk=2))
    with pytest.raises(TypeError, match="found int"):
        list(renderer.render_iter(5))
    with pytest.raises(omma.Error, match="chunk"):
        renderer.render_iter(flight, chunk=0)


@pytest.fixture(scope="module")
def slow(scene):
    """A renderer that needs seconds for 200 poses on any machine."""
    return omma.Renderer(scene, make_eye(2000), omma.Fixed(4096), threads=2)


def test_progress_and_what_it_raises(slow, flight):
    seen = []

    def watch(fraction):
        seen.append(fraction)
        if len(seen) == 3:
            raise ZeroDivisionError("enough")

    poses = np.concatenate([flight] * 40)
    with pytest.raises(ZeroDivisionError, match="enough"):
        slow.render(poses, progress=watch)
    assert len(seen) == 3
    assert seen == sorted(seen)
    assert 0 <= seen[0] <= seen[-1] < 1
    with pytest.raises(TypeError):
        slow.render(poses, progress="not callable")


def test_other_python_threads_run_meanwhile(slow, flight):
    begun, over = threading.Event(), threading.Event()
    latest = []

    def stop_soon(fraction):
        begun.set()
        if time.perf_counter() - start > 0.6:
            raise TimeoutError

    def count():
        begun.wait()
        while not over.is_set():
            latest.append(time.perf_counter())
            time.sleep(0.01)

    counter = threading.Thread(target=count)
    counter.start()
    start = time.perf_counter()
    try:
        with pytest.raises(TimeoutError):
            slow.render(np.concatenate([flight] * 40), progress=stop_soon)
    finally:
        begun.set()
        over.set()
        counter.join()
    # With the GIL held the other thread would get a turn only in the few progress calls.
    assert len(latest) > 15


def test_renders_from_several_threads(renderer, flight):
    expected = renderer.render(flight)
    results = [None] * 4

    def work(i):
        results[i] = renderer.render(flight)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all((result == expected).all() for result in results)


@pytest.mark.parametrize("backend", ["embree", "portable"])
def test_cut_outs_look_alike_at_any_number_of_rays(backend):
    """White stripes on a white sky, interpolated towards the black that alpha hides. With few rays
    they were as white as the sky, as averages of texels left out what is between them."""
    pixels = np.zeros((256, 256, 4), np.uint8)
    pixels[:, np.arange(256) // 2 % 2 == 0] = 255
    corners = [[-9, -9, -3], [9, -9, -3], [9, 9, -3], [-9, 9, -3]]
    wall = omma.scene.Mesh(
        corners,
        [[0, 1, 2], [0, 2, 3]],
        texture_coordinates=[[0, 9], [9, 9], [9, 0], [0, 0]],
        material=0,
    )
    scene = omma.Scene(
        meshes=[wall],
        materials=[omma.scene.Material(base_color_texture=0, alpha_mode="mask")],
        images=[omma.scene.Image(pixels)],
        background=omma.Background.constant((1, 1, 1)),
    )
    eye = omma.eye.generate_eye(300)
    ahead = eye.take(np.flatnonzero(-eye.axis[:, 2] > 0.8))
    few, some, many = (
        omma.Renderer(omma.World(scene, backend=backend), ahead, omma.Fixed(n)).render(
            np.eye(4), standard_error=True
        )
        for n in (16, 128, 1024)
    )
    # A stripe of two texels, of which an eighth of one is black at either side, is half of all. The
    # mean of some 30 ommatidia.
    for seen, error in (few, some, many):
        spread = float(np.sqrt(np.mean(np.square(error, dtype=float)) / len(ahead)))
        assert abs(seen.mean() - (1 - 0.125 / 2)) < 4 * spread
