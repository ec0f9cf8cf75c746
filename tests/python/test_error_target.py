"""Rendering to an error from Python and the command line: arguments, what is returned and said."""

import numpy as np
import pytest

import omma
from omma.job.results_info import describe_responses


@pytest.fixture(scope="module")
def auto(scene, eye):
    return omma.Renderer(scene, eye, omma.ToError(0.01, most=512))


def test_reaches_the_error(scene, eye, flight):
    renderer = omma.Renderer(scene, eye, omma.ToError(0.01))
    responses, report = renderer.render(flight, report=True)
    assert responses.shape == report.standard_error.shape == (9, 60, 3)
    assert report.rays.shape == (9, 60)
    assert report.rays.dtype == np.int32
    assert report.error == 0.01
    assert report.rays.min() == 8
    assert report.rays.max() > 8
    assert report.standard_error.max() <= np.float32(0.01)
    assert report.missed.shape == (0, 2)
    assert report.total_rays == report.rays.sum()
    assert report.mean_rays == pytest.approx(report.rays.mean())
    truth = omma.Renderer(scene, eye, omma.Fixed(8192)).render(flight)
    # Estimates are above the true error, so that its mean square over all is below the target's.
    assert np.sqrt(np.mean((responses - truth) ** 2)) < 0.01


@pytest.fixture(scope="module")
def room():
    """A room of 4 x 3 x 4 m whose only light comes in by a window of 0.3 m in front (-Z)."""
    grey, half, y = (0.4, 0.4, 0.4), 0.15, 1.8
    plane, back = omma.scene.plane, {"facing": (0, 0, 1)}
    walls = [
        plane((4, 4), grey),
        plane((4, 4), grey, center_m=(0, 3, 0), facing=(0, -1, 0)),
        plane((4, 3), grey, center_m=(-2, 1.5, 0), facing=(1, 0, 0)),
        plane((4, 3), grey, center_m=(2, 1.5, 0), facing=(-1, 0, 0)),
        plane((4, 3), grey, center_m=(0, 1.5, 2), facing=(0, 0, -1)),
        plane((4, y - half), grey, center_m=(0, (y - half) / 2, -2), **back),
        plane((4, 3 - y - half), grey, center_m=(0, (3 + y + half) / 2, -2), **back),
        plane((2 - half, 2 * half), grey, center_m=(-(2 + half) / 2, y, -2), **back),
        plane((2 - half, 2 * half), grey, center_m=((2 + half) / 2, y, -2), **back),
    ]
    light = omma.light.uniform_sky(1e17, bands=omma.light.Bands.equal(1, 400, 700))
    return omma.World(omma.scene.merge_scenes(walls), light=light)


# Blocks of ommatidia have 64 members at most: 65 would leave one alone with its luck.
@pytest.mark.parametrize("count", [1, 65, 129])
def test_none_is_dark_by_few_rays_alone(room, count):
    eye = omma.Eye([[0, 0, 0]], [[0, 0, 1]], 0.3)
    if count > 1:
        eye = omma.eye.generate_eye(count, acceptance_ratio=0.35)
    heard = min(count, 9)
    pose = omma.poses_from_angles((0.5, 1.2, 0.5), (0, 0, 0))
    for seed in range(12):
        sampling = omma.ToError(relative_error=0.1, most=256)
        renderer = omma.Renderer(room, eye, sampling, seed=seed)
        responses, report = renderer.render(pose, report=True)
        dark = responses[0, :, 0] == 0
        assert np.all(report.rays[0, dark] * heard >= 256)
        # Others of its block see light, so that it goes on to the end.
        assert count == 1 or np.all(report.rays[0, dark] == 256)


def test_what_is_black_is_left_in_time(eye):
    # Nine hear each other: 32 rays and then 512 are the first that make 4,096.
    black = omma.Background.constant((0, 0, 0))
    world = omma.World(omma.scene.plane((1, 1), (0, 0, 0)), background=black)
    renderer = omma.Renderer(world, eye, omma.ToError(relative_error=0.1))
    responses, report = renderer.render(omma.look_at((0, 1, 0), (0, 2, -1)), report=True)
    assert np.all(responses == 0)
    assert np.all(report.standard_error == 0)
    assert np.all(report.rays == 544)


RELATIVE = omma.ToError(relative_error=0.05)


@pytest.fixture(scope="module")
def dusk():
    """The lit meadow, and ommatidia all over an eye in its grass."""
    scene = omma.load_scene(omma.examples.lit_meadow())
    light = omma.light.clear_sky(2.0, sun_azimuth_deg=90.0, bands=omma.light.Bands.equal(4))
    eye = omma.species.honeybee_worker().eye.take(np.arange(0, 5380, 60))
    return omma.World(scene, light=light, ultraviolet=0.02), eye


def test_relative_errors(dusk):
    """What is dark gets the rays it needs: errors are fractions of responses, in every band."""
    world, eye = dusk
    # A tenth of four times as few rays shows what a twentieth does.
    tenth = omma.ToError(relative_error=0.1, most=1024)
    renderer = omma.Renderer(world, eye, tenth, noise="new_every_frame")
    found = [renderer.render("bee", report=True) for _ in range(8)]
    responses = np.array([one[0] for one in found])[:, 0].astype(float)
    errors = np.array([one[1].standard_error for one in found])[:, 0]
    report = found[0][1]
    assert (report.error, report.relative_error) == (0, 0.1)
    assert (report.wanted == np.float32(0.1) * np.abs(found[0][0])).all()
    assert report.rays.min() >= 32
    reached = np.array([one[1].rays for one in found])[:, 0] < 1024 - 32
    assert reached.mean() > 0.7
    assert (errors[reached] <= 0.1 * responses[reached] * (1 + 1e-6)).all()
    assert len(report.missed) == (errors[0] > report.wanted[0]).any(axis=1).sum()
    assert "of the response" in str(report)
    # How far apart renders lie, of the darkest third of ommatidia too, where they spread over more
    # than a factor of 10: estimates are mostly too large, so below what was asked for.
    of_all = reached.all(axis=0)
    mean = responses.mean(axis=0)
    spread = responses.std(axis=0, ddof=1) / mean
    dark = mean.mean(axis=1) <= np.quantile(mean.mean(axis=1), 1 / 3)
    assert mean.max() > 10 * mean.min()
    for which in (of_all, of_all & dark):
        assert np.sqrt((spread[which] ** 2).mean()) < 0.1
    # With both the larger counts.
    floor = float(np.median(mean))
    both = omma.ToError(floor, least=32, most=1024, relative_error=0.1)
    of_both = renderer.with_eye(eye, both).render("bee", report=True)[1]
    assert of_both.wanted.min() == np.float32(floor)
    assert of_both.total_rays < 0.2 * report.total_rays


def test_relative_errors_know_no_unit(scene, eye, flight):
    """In light 1,024 times as bright the same rays."""
    found = []
    for size in (1.0, 1024.0):
        light = omma.light.uniform_sky(size, bands=omma.light.Bands.equal(3))
        world = omma.World(scene, light=light, ultraviolet=0.02)
        found.append(omma.Renderer(world, eye, RELATIVE).render(flight, report=True))
    assert (found[0][1].rays == found[1][1].rays).all()
    assert found[0][1].rays.max() > 32
    assert (1024 * found[0][0] == found[1][0]).all()


def test_small_errors_start_with_more_rays(scene, eye):
    pose, black = np.eye(4), omma.Background.constant((0, 0, 0))
    pose[1, 3] = -5  # below the ground, whose back is not seen
    for error, least in ((0.1, 8), (0.0063, 8), (0.006, 16), (0.003, 32), (1e-5, 64)):
        renderer = omma.Renderer(scene, eye, omma.ToError(error), background=black)
        assert renderer.settings.sampling.limits()[0] == least
        _, report = renderer.render(pose, report=True)
        assert (report.rays == least).all()
        # Asked for, it is what was asked for, and it is never above the most.
        assert omma.ToError(error, least=4).limits() == (4, 4096)
        assert omma.ToError(error, most=20).limits() == (min(16, least), 20)
        few = renderer.with_eye(eye, omma.ToError(error, most=20))
        assert (few.render(pose, report=True)[1].rays == min(16, least)).all()
    assert omma.Renderer(scene, eye, omma.ToError(1e-5, least=4, most=7))


def test_what_is_returned_is_one_render(auto, flight):
    responses, report = auto.render(flight, report=True)
    out, error_out = np.empty_like(responses), np.empty_like(responses)
    again, errors = auto.render(flight, standard_error=True, out=out, error_out=error_out)
    assert again is out
    assert errors is error_out
    assert (out == responses).all()
    assert (error_out == report.standard_error).all()
    assert (auto.render(flight) == responses).all()
    pieces = list(auto.render_iter(flight, standard_error=True, chunk=4))
    assert (np.stack([piece[0] for piece in pieces]) == responses).all()
    assert (np.stack([piece[1] for piece in pieces]) == report.standard_error).all()
    new = auto.with_eye(auto.eye, noise="new_every_frame")
    responses, report = new.render(flight, report=True)
    part, part_report = new.render(flight[3:], report=True, first_pose=3)
    assert (part == responses[3:]).all()
    assert (part_report.rays == report.rays[3:]).all()


def test_missed_ommatidia_are_named(scene, eye, flight):
    renderer = omma.Renderer(scene, eye, omma.ToError(1e-4, least=4, most=8))
    _, report = renderer.render(flight, report=True)
    expected = [
        (pose, ommatidium)
        for pose in range(9)
        for ommatidium in range(60)
        if report.standard_error[pose, ommatidium].max() > np.float32(1e-4)
    ]
    assert expected
    assert report.missed.tolist() == [list(pair) for pair in expected]
    assert set(np.unique(report.rays)) <= {4, 8}
    pose, ommatidium = expected[0]
    text = str(report)
    missed = f"{len(expected)} of 540 responses did not reach 0.0001 (estimated): ommatidia "
    assert missed + str(ommatidium) in text
    assert f"{ommatidium} (pose {pose})" in text
    assert text.endswith(", ...") == (len(expected) > 8)


def test_the_report_in_words():
    errors = np.full((1, 1000, 3), 0.005, np.float32)
    rays = np.full((1, 1000), 8, np.int32)
    rays[0, 4] = 1024
    report = omma.rendering.SamplingReport(rays, errors, 0.01)
    assert str(report) == (
        "9,016 rays, 9.0 an ommatidium (8 to 1,024); all 1,000 responses reached 0.01 (estimated)"
    )
    errors[0, [17, 204], 1] = 0.02
    assert str(report).endswith(
        "; 2 of 1,000 responses did not reach 0.01 (estimated): ommatidia 17, 204"
    )
    errors[0, 204] = 0
    assert str(report).endswith(
        "; 1 of 1,000 responses did not reach 0.01 (estimated): ommatidium 17"
    )
    # An error that the target itself rounds to is reached.
    errors[0, 17] = 0.01
    assert len(report.missed) == 0
    nothing = omma.rendering.SamplingReport(rays[:0], errors[:0], 0.01)
    assert (nothing.total_rays, nothing.mean_rays) == (0, 0)
    assert str(nothing).startswith("0 rays")


def test_settings_can_be_read(auto, renderer):
    assert auto.settings.sampling == omma.ToError(0.01, most=512)
    assert auto.settings.sampling.limits() == (8, 512)
    assert "ToError(error=0.01, " in repr(auto)
    assert renderer.settings.sampling == omma.Fixed(8)


def test_with_eye(auto, renderer, eye, flight):
    again = auto.with_eye(eye)
    assert again.settings == auto.settings
    assert (again.render(flight) == auto.render(flight)).all()
    fixed = auto.with_eye(eye, omma.Fixed(8))
    assert fixed.settings.sampling == omma.Fixed(8)
    assert (fixed.render(flight) == renderer.render(flight)).all()
    back = renderer.with_eye(eye, omma.ToError(0.01, least=8, most=512))
    assert (back.render(flight) == auto.render(flight)).all()
    assert auto.with_eye(eye, seed=4).settings == omma.rendering.Settings(
        omma.ToError(0.01, most=512), seed=4
    )


@pytest.mark.parametrize(
    ("make", "kind", "word"),
    [
        (lambda: omma.Fixed("many"), TypeError, "^samples: expected a whole number, found str"),
        (lambda: omma.Fixed(0), omma.Error, "^samples: expected 1 to 1048576, found 0"),
        (lambda: omma.ToError(0), omma.Error, "^error: expected a number above 0, found 0"),
        (lambda: omma.ToError(-1), omma.Error, "^error: .*found -1"),
        (lambda: omma.ToError(float("nan")), omma.Error, "^error: .*found nan"),
        (lambda: omma.ToError(float("inf")), omma.Error, "^error: .*found inf"),
        (lambda: omma.ToError(0.1, least=2), omma.Error, "^least: expected 4 to 1048576, found 2"),
        (lambda: omma.ToError(0.1, 12), omma.Error, "^least: expected a power of two, found 12"),
        (lambda: omma.ToError(0.1, 8, 7), omma.Error, "^most: expected 8 to 1048576, found 7"),
        (lambda: omma.ToError(0.1, most=9.5), TypeError, "^most: expected a whole number"),
    ],
)
def test_wrong_targets(make, kind, word):
    with pytest.raises(kind, match=word):
        make()


def test_wrong_calls(auto, renderer, flight):
    with pytest.raises(omma.Error, match=r"report: is for renders to an error .*Fixed"):
        renderer.render(flight, report=True)
    with pytest.raises(omma.Error, match="report: has the standard errors"):
        auto.render(flight, report=True, standard_error=True)
    with pytest.raises(omma.Error, match=r"expected omma\.Fixed for render_rays"):
        auto.render_rays(flight)


@pytest.fixture
def omma_command(files, monkeypatch, run_omma):
    monkeypatch.chdir(files)
    return lambda *arguments: run_omma("render", "scene.gltf", *arguments)


def test_command(omma_command, scene, eye, flight, tmp_path, monkeypatch):
    monkeypatch.setattr("omma.job.pieces._PIECE_BYTES", 60 * 12 * 2)  # two poses at once
    path, out = tmp_path / "flight.csv", tmp_path / "a.npy"
    path.write_text("x,y,z,qx,qy,qz,qw\n" + "".join(f"{x},1,0,0,0,0,1\n" for x in range(5)))
    arguments = ("--eye", "bug.eye", "--path", path, "--error", 0.002)
    limits = ("--least", 4, "--most", 32)
    code, said, err = omma_command(*arguments, *limits, "--standard-error", "-o", out)
    assert (code, err) == (0, "")
    renderer = omma.Renderer(scene, eye, omma.ToError(0.002, least=4, most=32))
    responses, report = renderer.render(omma.load_poses(path), report=True)
    assert (np.load(out) == responses).all()
    assert (np.load(tmp_path / "a.error.npy") == report.standard_error).all()
    rays, missed = str(report).split("; ")
    assert f"rays       {rays}\n" in said
    assert f"error      {missed}\n" in said
    assert "did not reach 0.002" in missed


def test_command_that_reaches_it(omma_command, tmp_path):
    code, said, _ = omma_command(*("--eye", "bug.eye", "--error", 0.05, "-o", tmp_path / "a.npy"))
    assert code == 0
    assert "error      all 60 responses reached 0.05 (estimated)\n" in said
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.json", "a.npy"]


def test_footprints_can_be_left_out(omma_command, scene, eye, tmp_path):
    # White noise that is finer than the rays are apart: with footprints less of it is left.
    noise = np.random.default_rng(5).integers(0, 256, (512, 1024, 1), np.uint8)
    omma.save_png(tmp_path / "noise.png", np.repeat(noise, 3, axis=2))
    background = omma.Background.image(tmp_path / "noise.png")
    pose = omma.poses_from_angles((0, -5, 0), (0, 0, 0))
    spread = {}
    for footprints, switch in ((True, ()), (False, ("--no-footprints",))):
        out = tmp_path / "a.npy"
        place = ("--background", tmp_path / "noise.png", "--position", 0, -5, 0)
        code, _, err = omma_command("--eye", "bug.eye", *place, *switch, "-o", out)
        assert (code, err) == (0, "")
        renderer = omma.Renderer(scene, eye, background=background, footprints=footprints)
        assert (np.load(out) == renderer.render(pose)).all()
        spread[footprints] = np.load(out).std()
    # A footprint of 0.126 of 5° is 1.8 pixels wide, so that a ray is the mean of some three.
    # Spreads of 60 are known to 9 %, their ratio, 0.58, to 13 %.
    assert spread[True] < 0.8 * spread[False]


def test_a_file_tells_its_relative_error(omma_command, tmp_path):
    out = tmp_path / "a.npy"
    code, told, err = omma_command("--eye", "bug.eye", "--relative-error", 0.05, "-o", out)
    assert (code, err) == (0, "")
    assert "reached 5 % of the response (estimated)" in told
    settings = dict(describe_responses(out))["settings"]
    assert "relative_error 0.05" in settings


@pytest.mark.parametrize(
    ("arguments", "code", "word"),
    [
        (("--least", "8"), 1, "--least: goes with --error or --relative-error"),
        (("--relative-error", "0"), 1, "--relative-error: expected a number above 0"),
        (("--relative-error", "5"), 1, "--relative-error: expected a fraction of the response"),
        (("--samples", "many"), 2, "--samples"),
        (("--error", "0.01", "--samples", "8"), 1, "--samples and --error: only one of them"),
        (("--shared", "4", "--samples", "8"), 1, "--samples and --shared: only one of them"),
        (("--error", "0"), 1, "error: expected a number above 0"),
        (("--samples", "0"), 1, "samples: expected 1 to 1048576, found 0"),
        (("--camera", "plain", "--error", "1"), 1, "--error: not for a picture"),
    ],
)
def test_wrong_commands(omma_command, tmp_path, arguments, code, word):
    eye = () if "--camera" in arguments else ("--eye", "bug.eye")
    found, out, err = omma_command(*eye, *arguments, "-o", tmp_path / "a.npy")
    assert (found, out) == (code, "")
    assert err.startswith("omma: error: ")
    assert word in err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("points", ["low_discrepancy", "random"])
def test_renderers_made_of_others_have_the_bits_of_new_ones(points):
    """They take over the points of every round."""
    scene = omma.load_scene(omma.examples.meadow())
    world, pose = omma.World(scene), scene.camera("bee").world_from_camera
    grey = world.with_background(omma.Background.constant((0.2, 0.3, 0.4)))
    eye = omma.eye.generate_eye(40)
    oval = omma.eye.generate_eye(60).replace(acceptance=omma.Acceptance.gaussian(0.1, 0.05, 0.3))
    options = {"points": points, "seed": 3}
    target, other = omma.ToError(0.02), omma.ToError(0.05, most=256)
    first = omma.Renderer(world, eye, target, **options)
    for made, new in (
        (first.with_eye(oval), omma.Renderer(world, oval, target, **options)),
        (first.with_world(grey), omma.Renderer(grey, eye, target, **options)),
        (first.with_eye(eye, other), omma.Renderer(world, eye, other, **options)),
        (first.with_eye(eye, seed=9), omma.Renderer(world, eye, target, points=points, seed=9)),
    ):
        assert np.array_equal(made.render(pose), new.render(pose))
