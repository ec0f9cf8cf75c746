"""Scatter of responses: closed forms, brute force, the search for the worst place, the files."""

import csv
import itertools
import sys

import numpy as np
import pytest

import omma
from omma.study.search import _positions, _spread_points, _turned, _uniform_quaternions
from omma.study.variance import COMPOUNDRAY, OURS

RANDOM = omma.study.Method("pillbox", "random")
FORWARD = np.eye(4)


@pytest.fixture(scope="module")
def horizon():
    """White above the horizon, black below: a renderer of nothing else."""
    # So many rows that the one between black and white is under a thousandth of any field here.
    image = np.zeros((4096, 2, 3), np.float32)
    image[:2048] = 1
    background = omma.Background.image(image)
    return omma.Renderer(omma.Scene(), omma.study.icosahedral_eye(), background=background)


@pytest.fixture(scope="module")
def even():
    """The same light everywhere."""
    background = omma.Background.constant((0.3, 0.5, 0.7))
    return omma.Renderer(omma.Scene(), omma.study.icosahedral_eye(), background=background)


def level_eye(count=1, acceptance_deg=20):
    """Ommatidia that all look along the horizon: half of what each sees is white."""
    angle = np.arange(count) * 0.7
    axis = np.stack([np.sin(angle), np.zeros(count), -np.cos(angle)], axis=1)
    return omma.Eye(np.zeros((count, 3)), axis, np.radians(acceptance_deg))


def variances(renderer, eye, rays, repeats, **settings):
    return omma.study.response_variances(
        renderer, eye, FORWARD, rays=rays, repeats=repeats, **settings
    )


def test_icosahedral_eye_is_a_dozen_steradians_evenly_spread():
    eye = omma.study.icosahedral_eye()
    assert omma.study.solid_angles_sr(eye) == pytest.approx(np.ones(12), rel=1e-6)  # float32 angles
    cosine = np.sort(eye.axis @ eye.axis.T, axis=1)[:, ::-1]
    # An icosahedron's corner has five neighbours at arctan 2, five at its supplement, one opposite.
    expected = [1] + 5 * [5**-0.5] + 5 * [-(5**-0.5)] + [-1]
    assert cosine == pytest.approx(np.tile(expected, (12, 1)), abs=1e-6)


def test_rays_per_ommatidium_go_by_the_widest():
    cone = 2 * np.pi * (1 - np.cos(np.radians(2.6) / 2))
    eye = omma.Eye(np.zeros((2, 3)), np.eye(3)[:2], np.radians([2.6, 1.0]))
    # float32 acceptance angles
    assert omma.study.solid_angles_sr(eye)[0] == pytest.approx(cone, rel=1e-6)
    assert omma.study.rays_per_ommatidium(eye, 1065) == 2  # 1.72
    assert omma.study.rays_per_ommatidium(eye, 1e6) == int(
        np.ceil(1e6 * omma.study.solid_angles_sr(eye)[0])
    )
    assert omma.study.rays_per_ommatidium(eye, 1) == 1
    assert omma.study.rays_per_ommatidium(omma.study.icosahedral_eye(), 1065) in (1065, 1066)


@pytest.mark.parametrize("rays", [1, 4, 25])
def test_random_rays_scatter_as_one_over_their_root(horizon, rays):
    """Half white, half black: the variance of one ray is 1/4, of the mean of N 1/(4 N)."""
    found = variances(horizon, level_eye(8), rays, 4096, method=RANDOM, seed=rays)
    # The relative standard error of a variance of 4096 values is at most sqrt(2/4095) (less for
    # few rays); eight ommatidia within 5 of it.
    assert found[0] == pytest.approx(np.full(8, 0.25 / rays), rel=5 * (2 / 4095) ** 0.5)


def test_one_evenly_spread_ray_scatters_as_a_random_one(horizon):
    found = variances(horizon, level_eye(8), 1, 4096, method=OURS)
    # As above; one ray has nothing to be spread evenly with.
    assert found[0] == pytest.approx(np.full(8, 0.25), rel=5 * (2 / 4095) ** 0.5)


def test_seeds_share_the_repeats(horizon):
    one = variances(horizon, level_eye(), 4, 64, method=OURS)
    several = variances(horizon, level_eye(), 4, 64, method=OURS, seeds=8)
    assert several != one
    again = variances(horizon, level_eye(), 4, 64, method=OURS, seeds=8)
    assert several == again
    # More seeds than repeats: one repeat each.
    assert variances(horizon, level_eye(), 4, 3, seeds=100).shape == (1, 1)


def test_display_measure_of_single_rays_is_exact(horizon):
    """A ray is (0, 0, 0) or (255, 255, 255): its squared distance from the mean 3 · 255² p(1-p)."""
    settings = {"method": RANDOM, "measure": "compoundray"}
    found = variances(horizon, level_eye(), 1, 1 << 16, **settings)[0, 0]
    # p(1-p) of 65,536 rays is within 5 standard deviations of p, squared, of 1/4; rays that meet
    # the grey row between are under 0.1 %.
    assert found == pytest.approx(3 * 255**2 / 4, rel=2e-3)


def test_display_measure_of_means_follows_the_gamma_curve(horizon):
    """d(255 m^(1/2.2)) = 255/2.2 m^(1/2.2 - 1) dm, in three equal channels, at m = 1/2."""
    rays = 1024
    settings = {"method": RANDOM, "measure": "compoundray"}
    found = variances(horizon, level_eye(4), rays, 4096, seed=9, **settings)[0]
    slope = 255 / 2.2 * 0.5 ** (1 / 2.2 - 1)
    # Truncation to whole numbers adds 1/12 in each channel.
    expected = 3 * (slope**2 * 0.25 / rays + 1 / 12)
    # 5 standard errors of a variance of 4096 values; what is left out of the series is of the
    # order of 1/rays.
    assert found == pytest.approx(np.full(4, expected), rel=5 * (2 / 4095) ** 0.5)


def test_low_discrepancy_scatters_less(horizon):
    random = variances(horizon, level_eye(4), 64, 512, method=COMPOUNDRAY)
    ours = variances(horizon, level_eye(4), 64, 512, method=OURS)
    # Across a straight edge N points in a square err as N^(-3/4) instead of N^(-1/2): 8 in variance
    # at 64 rays, of which half is asked for.
    assert (4 * ours < random).all()


@pytest.mark.parametrize(
    ("method", "measure"), list(itertools.product((OURS, COMPOUNDRAY), ("linear", "compoundray")))
)
def test_even_light_needs_one_ray(even, method, measure):
    box = omma.study.Box((0, 0, 0), (1, 1, 1))
    found = omma.study.minimum_samples(even, box, method=method, measure=measure, poses=16)
    assert found.rays_per_sr == 1
    # The mean of equal float32 values may be a last bit from them.
    assert found.spread == pytest.approx(0, abs=1e-6)


def test_half_white_needs_what_the_binomial_says(horizon):
    """Some turn puts the horizon through the middle of a field: σ = 1/2, N = (σ/share)² = 100."""
    box = omma.study.Box((0, 0, 0), (1, 1, 1))
    found = omma.study.minimum_samples(horizon, box, fraction=0.05, method=COMPOUNDRAY, poses=128)
    # σ is at most 1/2, times 8192/8191 in the variance; p from 0.42 to 0.58 gives 97 and more.
    assert 97 <= found.rays_per_sr <= 101
    assert found.limit == 0.05
    assert found.script_rays_per_sr is None
    assert found.standard_deviations == pytest.approx(found.spread / np.sqrt(found.rays))
    ours = omma.study.minimum_samples(horizon, box, fraction=0.05, method=OURS, poses=64)
    # Across a straight edge about (1/2) N^(-3/4): 22 rays; twice that is far from 100 still.
    assert ours.rays_per_sr < 50
    # Brute force at the place found.
    tried = omma.study.response_variances(
        horizon, omma.study.icosahedral_eye(), found.pose, rays=found.rays_per_sr, repeats=4096,
        method=COMPOUNDRAY, seed=77,
    )[0, found.ommatidium] ** 0.5  # fmt: skip
    # 5 standard errors of a standard deviation of 4096 values, and rounding up to whole rays.
    assert tried == pytest.approx(0.05, rel=5 * (2 * 4095) ** -0.5 + 0.01)


def test_display_measure_counts_frames_as_the_script(horizon):
    box = omma.study.Box((0, 0, 0), (1, 1, 1))
    settings = {"fraction": 0.05, "poses": 64, "measure": "compoundray"}
    theirs = omma.study.minimum_samples(horizon, box, method=COMPOUNDRAY, **settings)
    assert theirs.limit == pytest.approx(0.05 * 3**0.5 * 255)
    # Brute force at the place found, with other samples.
    tried = omma.study.response_variances(
        horizon, omma.study.icosahedral_eye(), theirs.pose, rays=theirs.rays_per_sr, repeats=8192,
        method=COMPOUNDRAY, measure="compoundray", seed=77,
    ).max() ** 0.5  # fmt: skip
    # 5 standard errors of a standard deviation of 8192 values, and of the number of rays, of which
    # it goes as the root.
    tolerance = 5 * (2 * 8191) ** -0.5 + 5 / 2 * theirs.relative_error
    assert tried == pytest.approx(theirs.limit, rel=tolerance)
    assert theirs.script_rays_per_sr <= theirs.rays_per_sr
    ours = omma.study.minimum_samples(horizon, box, method=OURS, **settings)
    assert ours.rays_per_sr < theirs.rays_per_sr
    assert ours.script_rays_per_sr is None
    assert (np.diff(ours.rays) > 0).all()
    assert ours.standard_deviations[0] > ours.limit > ours.standard_deviations[-1]


def test_search_finds_no_less_than_many_tries(scene):
    box = omma.study.Box((-12, 0.1, -12), (12, 3, 12))
    found = omma.study.minimum_samples(scene, box, fraction=0.1, method=COMPOUNDRAY, poses=512)
    rng = np.random.default_rng(5)
    positions, turns = rng.uniform(box.low_m, box.high_m, (400, 3)), rng.normal(size=(400, 4))
    poses = omma.poses_from_quaternions(positions, turns)
    tried = omma.study.response_variances(
        scene, omma.study.icosahedral_eye(), poses, rays=1, repeats=2048, method=COMPOUNDRAY
    )
    assert found.spread**2 > tried.max()
    assert (found.pose[:3, 3] >= box.low_m).all()
    assert (found.pose[:3, 3] <= box.high_m).all()
    assert found.poses_rendered > 512
    assert found.rays_traced > found.poses_rendered * 12


def test_search_is_repeatable_and_follows_its_seed(scene):
    place = omma.study.Cylinder((0, 0.1, 0), 5, 2)
    settings = {"fraction": 0.1, "method": COMPOUNDRAY, "poses": 64}
    first, again = (omma.study.minimum_samples(scene, place, **settings) for _ in range(2))
    other = omma.study.minimum_samples(scene, place, seed=2**64 - 1, **settings)
    assert (first.pose == again.pose).all()
    assert (first.pose != other.pose).any()
    assert first.spread == again.spread


def test_places_to_search():
    units = _spread_points(4000)[:, :3]
    # Evenly: each eighth of the cube has an eighth of the points; such points miss by a handful.
    eighths = np.bincount((units >= 0.5) @ [1, 2, 4], minlength=8)
    assert abs(eighths - 500).max() < 20
    box = _positions(omma.study.Box((-1, 2, 3), (1, 4, 3)), units)
    assert box.min(axis=0) == pytest.approx([-1, 2, 3], abs=0.01)
    assert box.max(axis=0) == pytest.approx([1, 4, 3], abs=0.01)
    tube = _positions(omma.study.Cylinder((1, 2, 3), 4, 5), units) - [1, 2, 3]
    radius = np.hypot(tube[:, 0], tube[:, 2])
    assert radius.max() == pytest.approx(4, abs=0.01)
    # A quarter of the area is within half the radius.
    assert (radius < 2).mean() == pytest.approx(0.25, abs=0.01)
    assert (tube[:, 1].min(), tube[:, 1].max()) == pytest.approx((0, 5), abs=0.01)
    path = np.tile(np.eye(4), (3, 1, 1))
    path[:, 0, 3] = 5, 6, 7
    assert np.unique(_positions(path, units)[:, 0], return_counts=True)[1] == pytest.approx(
        4000 / 3, abs=20
    )
    assert (_positions(path, np.ones((1, 3))) == [7, 0, 0]).all()


def test_orientations_are_spread_and_turned():
    turns = _uniform_quaternions(_spread_points(4000)[:, 3:])
    ahead = omma.poses_from_quaternions(np.zeros(3), turns)[:, :3, 2]
    # The mean of 4000 directions that miss evenness by a handful.
    assert abs(ahead.mean(axis=0)).max() < 0.02
    assert (ahead.T @ ahead / 4000) == pytest.approx(np.eye(3) / 3, abs=0.01)
    # A quarter turn to the left about +Y takes -Z to -X.
    turned = _turned(np.array([[0.0, 0, 0, 1]]), np.array([[0, np.pi / 2, 0]]))
    view = omma.poses_from_quaternions(np.zeros(3), turned)[0, :3, :3] @ [0, 0, -1]
    assert view == pytest.approx([-1, 0, 0], abs=1e-12)


def test_map_has_x_along_columns_and_z_along_rows(scene):
    """East of the ground's edge at x = 10 there is nothing below, over it colours."""
    settings = {"rays": 1, "repeats": 1024, "method": RANDOM}
    found = omma.study.variance_map(scene, (10, 0.5, 3), 8, steps=4, **settings)
    assert found.shape == (4, 4)
    poses = np.tile(np.eye(4), (2, 1, 1))
    poses[:, :3, 3] = (13, 0.5, 0), (7, 0.5, 6)  # row 0, column 3; row 3, column 0
    expected = omma.study.response_variances(
        scene, omma.study.icosahedral_eye(), poses, **settings
    ).max(axis=1)
    # 5 standard errors of the difference of two such variances.
    assert [found[0, 3], found[3, 0]] == pytest.approx(expected, rel=5 * 2 * (1 / 1023) ** 0.5)
    assert abs(found[0, 3] - found[3, 0]) > 0.4 * found.max()
    mean = omma.study.variance_map(scene, (10, 0.5, 3), 8, steps=4, statistic="mean", **settings)
    assert (mean < found).all()


def test_alias_curve_is_the_closed_form(horizon):
    eye = omma.Eye(np.zeros((2, 3)), [[0, 0, -1], [1, 0, 0]], np.radians([10, 20]))
    per_sr, rms = omma.study.alias_curve(
        horizon, eye, FORWARD, [1, 16], method=RANDOM, repeats=4096
    )
    expected = 0.5 * (1 / omma.study.solid_angles_sr(eye)).mean() / np.array([1, 4])
    # Relative standard error of a standard deviation of 4096 values: 1/sqrt(2 · 4095).
    tolerance = 5 * (2 * 4095) ** -0.5
    assert per_sr == pytest.approx(expected, rel=tolerance)
    assert rms == pytest.approx([0.5, 0.125], rel=tolerance)


def test_alias_curve_tells_shares_of_all_rays(horizon):
    """Of 1 + 4 + 15: half of the rays, not of the numbers, is far within the last."""
    eye = omma.Eye(np.zeros((2, 3)), [[0, 0, -1], [1, 0, 0]], np.radians([10, 20]))
    told: dict[str, list[float]] = {}
    omma.study.alias_curve(
        horizon, eye, FORWARD, [1, 4, 15], repeats=8,
        progress=lambda stage, share: told.setdefault(stage, []).append(share),
    )  # fmt: skip
    assert list(told) == ["1 rays", "4 rays", "15 rays"]
    ends = [max(shares) for shares in told.values()]
    assert ends == pytest.approx([1 / 20, 5 / 20, 1])
    assert min(told["15 rays"]) < 1


BOX = omma.study.Box((0, 0, 0), (1, 1, 1))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda s: omma.study.minimum_samples(s, BOX, fraction=0), "fraction: expected over 0"),
        (lambda s: omma.study.minimum_samples(s, BOX, measure="x"), "measure: expected linear or"),
        (lambda s: omma.study.minimum_samples(s, BOX, poses=0), "poses: expected 1"),
        (lambda s: omma.study.minimum_samples(s, BOX, seed=-1), "seed: expected 0"),
        (
            lambda s: omma.study.minimum_samples(s, omma.study.Box((0, 0, 1), (1, 1, 0))),
            "lower corner first",
        ),
        (
            lambda s: omma.study.minimum_samples(s, omma.study.Cylinder((0, 0, 0), -1, 1)),
            "cylinder: expected",
        ),
        (lambda s: omma.study.minimum_samples(s, np.zeros((0, 4, 4))), "at least one pose"),
        (
            lambda s: omma.study.minimum_samples(
                s, BOX, fraction=1e-9, measure="compoundray", poses=2
            ),
            "fraction: the standard deviation is .* for 65536",
        ),
        (lambda s: omma.study.variance_map(s, (0, 1, 0), 0), "size_m: expected over 0"),
        (
            lambda s: omma.study.variance_map(s, (0, 1, 0), 1, statistic="min"),
            "statistic: expected max",
        ),
        (lambda s: omma.study.variance_map(s, (0, 1, 0), 1, repeats=1), "repeats: expected 2"),
        (
            lambda s: omma.study.alias_curve(
                s, omma.Eye(np.zeros((1, 3)), [[0, 0, 1]], 0.0), FORWARD, [1]
            ),
            "acceptance angles over 0",
        ),
        (
            lambda s: omma.study.alias_curve(s, omma.eye.generate_eye(9), [np.eye(4)] * 2, [1]),
            r"pose: expected one pose \(4, 4\), found 2",
        ),
    ],
)
def test_wrong_arguments_are_named(horizon, call, message):
    with pytest.raises(omma.Error, match=message):
        call(horizon)


def read_csv(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def check_png(path):
    """A PNG of a fair size with something drawn on it."""
    from matplotlib.image import imread

    pixels = imread(path)[..., :3]
    assert min(pixels.shape[:2]) > 400
    assert len(np.unique(pixels.reshape(-1, 3), axis=0)) > 50


def search_result(method, deviations):
    return omma.study.MinimumSamples(
        method=method, measure="linear", limit=0.1, rays_per_sr=3, relative_error=0.02,
        script_rays_per_sr=None, pose=np.eye(4), ommatidium=0, spread=0.5, spread_rays=1,
        rays=np.array([1, 2, 4]), standard_deviations=np.array(deviations), poses_rendered=1,
        rays_traced=1, seconds=1.0,
    )  # fmt: skip


def test_search_files(tmp_path):
    found = [search_result(COMPOUNDRAY, [0.3, 0.2, 0.1]), search_result(OURS, [0.3, 0.1, 0.05])]
    omma.study.save_minimum_samples(tmp_path / "x.csv", found)
    omma.study.save_minimum_samples(tmp_path / "x.png", found)
    rows = read_csv(tmp_path / "x.csv")
    assert list(rows[4].values()) == ["gaussian", "low_discrepancy", "linear", "2", "0.1"]
    assert len(rows) == 6
    check_png(tmp_path / "x.png")
    with pytest.raises(omma.Error, match=r"ending in \.csv or \.png"):
        omma.study.save_minimum_samples(tmp_path / "x.npy", found)
    with pytest.raises(omma.Error, match="found: expected searches"):
        omma.study.save_minimum_samples(tmp_path / "x.csv", [])


def test_map_files(tmp_path):
    variance = np.arange(9.0).reshape(3, 3) ** 2
    for suffix in ("npy", "csv", "png"):
        omma.study.save_variance_map(tmp_path / f"x.{suffix}", variance, (10, 1, 20), 6)
    assert (np.load(tmp_path / "x.npy") == np.sqrt(variance)).all()
    rows = read_csv(tmp_path / "x.csv")
    assert [list(map(float, row.values())) for row in rows[:4]] == [
        [8, 18, 0], [10, 18, 1], [12, 18, 2], [8, 20, 3],
    ]  # fmt: skip
    check_png(tmp_path / "x.png")
    omma.study.save_variance_map(tmp_path / "v.csv", variance, (10, 1, 20), 6, as_variance=True)
    assert float(read_csv(tmp_path / "v.csv")[3]["variance"]) == 9
    with pytest.raises(omma.Error, match="variance: expected shape"):
        omma.study.save_variance_map(tmp_path / "x.npy", variance[:2], (0, 0, 0), 1)


def test_alias_files(tmp_path):
    curves = {OURS: ([4.0, 1.0], [0.4, 0.1]), COMPOUNDRAY: ([4.0, 2.0], [0.4, 0.2])}
    omma.study.save_alias_curves(tmp_path / "x.csv", [1, 4], curves)
    omma.study.save_alias_curves(tmp_path / "x.png", [1, 4], curves)
    assert list(read_csv(tmp_path / "x.csv")[1].values()) == [
        "gaussian", "low_discrepancy", "4", "1", "0.1",
    ]  # fmt: skip
    check_png(tmp_path / "x.png")


def test_plots_say_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(omma.Error, match=r"pip install 'omma\[plots\]'"):
        omma.study.save_variance_map(tmp_path / "x.png", np.ones((2, 2)), (0, 0, 0), 1)
    assert not list(tmp_path.iterdir())


def test_min_samples_command(omma_command, tmp_path):
    outputs = tmp_path / "x.csv", tmp_path / "x.png"
    code, out, err = omma_command(
        "measure", "min-samples", "scene.gltf", "--box", -5, 0.5, -5, 5, 2, 5, "--fraction", 0.1,
        "--poses", 32, "--eye", "bug.eye", "-o", outputs[0], "-o", outputs[1],
    )  # fmt: skip
    assert (code, err) == (0, "")
    for words in (
        "rays/sr",
        "compoundray sensitivity",
        "gaussian sensitivity",
        "bug.eye:",
        "worst at",
        "s\n",
    ):
        assert words in out
    assert all(f"wrote      {path}" in out and path.stat().st_size for path in outputs)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "expected one of --box, --cylinder and --path"),
        (("--cylinder", 0, 0, 0, 1, 1, "--box", 0, 0, 0, 1, 1, 1), "expected one of --box"),
        (("--path", "none.csv"), "none.csv: there is no such file"),
        (("--cylinder", 0, 0, 0, 1, 1, "-o", "x.txt"), "x.txt: expected a name ending in .csv"),
        (("--cylinder", 0, 0, 0, 1, 1, "-o", "no/x.csv"), "there is no directory no"),
    ],
)
def test_min_samples_command_says_what_is_wrong(omma_command, arguments, message):
    code, out, err = omma_command("measure", "min-samples", "scene.gltf", *arguments)
    assert (code, out) == (1, "")
    assert message in err


def test_variance_map_command(omma_command, tmp_path):
    path = tmp_path / "x.npy"
    code, out, err = omma_command(
        "measure", "variance-map", "scene.gltf", "--centre", 0, 1, 0, "--size", 10, "--steps", 3,
        "--repeats", 32, "-o", path,
    )  # fmt: skip
    assert (code, err) == (0, "")
    assert "3 x 3, 3.333 m wide" in out
    assert np.load(path).shape == (3, 3)


def test_aliasing_command(omma_command, tmp_path):
    path = tmp_path / "x.csv"
    code, out, err = omma_command(
        "measure", "aliasing", "scene.gltf", "--eye", "bug.eye", "--camera", "insect",
        "--most-rays", 9, "--repeats", 8, "-o", path,
    )  # fmt: skip
    assert (code, err) == (0, "")
    assert "CompoundRay" in out
    rows = read_csv(path)
    assert [row["rays_per_ommatidium"] for row in rows] == 2 * ["1", "2", "4", "8"]
