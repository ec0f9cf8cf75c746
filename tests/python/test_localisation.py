"""The localisation experiment of examples/localisation: its network, its views, and a tiny run of
all of it from files to plot.
"""

import csv
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA, load_script

import omma

pytest.importorskip("matplotlib", reason="the experiment draws its curves with matplotlib")

SCRIPT = Path(__file__).resolve().parents[2] / "examples" / "localisation" / "localise.py"
SCENE = DATA / "compound-ray" / "scenes" / "env_2.gltf"
EYES = [DATA / "compound-ray" / "bees" / f"AM_60185-{v}.eye" for v in ("real", "single", "split")]
needs_data = pytest.mark.skipif(not SCENE.is_file(), reason=f"needs {SCENE}, which is not here")


localise = load_script(SCRIPT)


def some_views(ommatidia=60, views=40):
    """Random views in which a few ommatidia are dark, none in every third; white is not small."""
    rng = np.random.default_rng(3)
    counts = np.where(np.arange(views) % 3 == 0, 0, rng.integers(1, 9, views))
    return localise.Views(
        ommatidia=ommatidia,
        start=np.concatenate([[0], np.cumsum(counts)]),
        which=np.concatenate([rng.choice(ommatidia, n, replace=False) for n in counts]),
        dark=rng.uniform(-5, -1, counts.sum()).astype(np.float32),
        white=0.4,
        target=rng.uniform(-1.7, 1.7, (views, 3)).astype(np.float32),
        training=views,
    )


def test_network_is_the_dense_one(monkeypatch):
    """Same outputs and steps as a dense network written down plainly, in double precision."""
    rate = 0.3  # so large that five steps change the outputs by much more than rounding
    monkeypatch.setattr(localise, "LEARNING_RATE", rate)
    views = some_views()
    network = localise.Network(views, seed=1)
    w1 = network.v.astype(float)
    b1 = network.base - views.white * w1.sum(axis=0)
    w2, b2, w3, b3 = (a.astype(float) for a in (network.w2, network.b2, network.w3, network.b3))

    def forward(x):
        first = np.maximum(x @ w1 + b1, 0)
        second = np.maximum(first @ w2 + b2, 0)
        return first, second, second @ w3 + b3

    everything = np.arange(len(views.target))
    whole = views.dense(everything).astype(float)
    before = forward(whole)[2]
    for batch in (everything[:16], everything[10:30], everything[25:], everything[:7], everything):
        x = whole[batch]
        first, second, answer = forward(x)
        error = answer - views.target[batch]
        d3 = np.sign(error) / error.size
        d2 = d3 @ w3.T * (second > 0)
        d1 = d2 @ w2.T * (first > 0)
        w3, b3 = w3 - rate * second.T @ d3, b3 - rate * d3.sum(axis=0)
        w2, b2 = w2 - rate * first.T @ d2, b2 - rate * d2.sum(axis=0)
        w1, b1 = w1 - rate * x.T @ d1, b1 - rate * d1.sum(axis=0)
        assert network.step(batch) == pytest.approx(np.abs(error).mean(), abs=1e-5)
    after = forward(whole)[2]
    assert np.abs(after - before).max() > 0.1
    # float32 against float64: sums of a thousand terms of about 1, each good to 6e-8.
    np.testing.assert_allclose(network.forward(everything)[2], after, atol=1e-5)
    expected = np.abs(after - views.target).mean()
    assert network.loss(range(len(everything))) == pytest.approx(expected, abs=1e-5)


def test_views_are_normalised_over_the_training_set(tmp_path):
    rng = np.random.default_rng(5)
    responses = np.where(rng.random((localise.PART, 30)) < 0.1, rng.random(30), 1.0)
    responses = responses.astype(np.float32)
    places = rng.uniform(-25, 25, (localise.PART, 3))
    np.savez_compressed(tmp_path / "00000.npz", responses=responses, position_mm=places)
    views = localise.load_views(tmp_path, 400)
    assert views.training == 320
    training = responses[:320].astype(float)
    expected = (responses[:400] - training.mean()) / training.std()
    np.testing.assert_allclose(views.dense(np.arange(400)), expected, atol=1e-5)  # float32
    np.testing.assert_allclose(views.target * 14.5, places[:400], rtol=1e-6)


def test_lowest_loss_is_a_guess_where_nothing_is_seen():
    views = some_views()
    views.training = 20
    unseen = np.arange(20, 40) % 3 == 0  # those without a dark ommatidium
    places = views.target[20:][unseen].astype(float)
    # Of all constant answers none beats the median; a grid of answers finds no better one either.
    grid = np.linspace(-2, 2, 401)
    best = np.abs(places[None] - grid[:, None, None]).mean(axis=1).min(axis=0).mean()
    seen, lowest = localise.lowest_loss(views)
    assert seen == pytest.approx(1 - unseen.mean())
    # The grid is 0.01 wide, so that its best answer is 0.005 off at most.
    assert lowest == pytest.approx(best * unseen.mean(), abs=0.005)


@needs_data
def test_ommatidia_that_look_at_the_sphere_are_the_dark_ones(tmp_path):
    """The whole way of a view, frames and units, against the geometry of a sphere and a point."""
    # The real eye, 3.8 mm wide: in another unit its ommatidia would see the sphere from elsewhere.
    eye = omma.load_eye(EYES[0], unit="m")
    localise.render_views(SCENE, EYES[0], tmp_path, 100, 16, "gaussian", 0, lambda: None)
    with np.load(tmp_path / "00000.npz") as file:
        responses, places = file["responses"], file["position_mm"]
    acceptance = eye.acceptance_angle_rad[0]
    inside = outside = 0
    for response, place in zip(responses, places):
        origin = place + eye.position_m - eye.axis * eye.focal_offset_m[:, None]
        distance = np.linalg.norm(origin, axis=1)
        angle = np.arccos(np.clip((-origin * eye.axis).sum(axis=1) / distance, -1, 1))
        # The sphere is made of 1,280 triangles with their corners on radius 1; the middles of
        # them lie up to 2 % deeper.
        smaller, larger = np.arcsin(0.98 / distance), np.arcsin(1 / distance)
        # 1 - exp(-4 ln2 0.75²) = 79 % of the Gaussian lies within 0.75 acceptance angles of the
        # axis, so that the other side of the sphere's edge gets 21 % at most, here of 16 rays.
        hit, miss = angle < smaller - 0.75 * acceptance, angle > larger + 0.75 * acceptance
        assert (response[hit] < 0.5).all()
        assert (response[miss] > 0.5).all()
        # A ray in 2^36 goes three acceptance angles off the axis. Texels of 1, weighted, are 1
        # within the rounding of a float32.
        assert (response[angle > larger + 3 * acceptance] > 1 - 1e-6).all()
        inside, outside = inside + hit.sum(), outside + miss.sum()
    assert inside > 200
    assert outside > 3_000_000


@pytest.fixture(scope="module")
def tiny(tmp_path_factory):
    """The experiment with every eighth ommatidium of the three eyes; (arguments, folder)."""
    folder = tmp_path_factory.mktemp("localisation")
    eyes = []
    for eye in EYES:
        lines = eye.read_text().splitlines()
        eyes.append(folder / eye.name)
        eyes[-1].write_text("\n".join(lines[::8]) + "\n")
    options = ["--scene", SCENE, "--frames", "1500", "--epochs", "30"]
    arguments = [sys.executable, SCRIPT, *eyes, *options, "--out", folder / "out"]
    subprocess.run(arguments, check=True, capture_output=True)
    return arguments, folder / "out"


@needs_data
def test_tiny_experiment_learns_where_the_sphere_is(tiny):
    _, out = tiny
    with (out / "curves.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["eye"] for row in rows[::30]] == [eye.stem for eye in EYES]
    assert [int(row["epoch"]) for row in rows] == 3 * list(range(1, 31))
    places = np.concatenate([localise.positions_mm(part, 0) for part in range(3)])
    validation = places[1200:] / 14.5
    # No constant answer can be better on these very views than their own median.
    constant = np.abs(validation - np.median(validation, axis=0)).mean()
    for last in rows[29::30]:
        # What is below comes from what the eye saw: 0.02 to 0.03 with other seeds of the network.
        assert float(last["validation_l1"]) < constant - 0.01
    assert (out / "curves.png").stat().st_size > 10_000


@needs_data
def test_a_stopped_experiment_goes_on_and_ends_the_same(tiny):
    arguments, out = tiny
    before = (out / "curves.csv").read_text().splitlines()
    files = sorted(out.glob("views/AM_60185-split*/*.npz"))
    assert len(files) == 3
    kept = [file.stat().st_mtime_ns for file in files]
    files[1].unlink()  # as if stopped before the second part
    subprocess.run([*arguments[:2], arguments[4], *arguments[5:]], check=True, capture_output=True)
    after = (out / "curves.csv").read_text().splitlines()
    assert len(after) == 31
    assert after[1:] == before[-30:]  # the last of the three eyes, alone
    assert [file.stat().st_mtime_ns == time for file, time in zip(files, kept)] == [1, 0, 1]


@needs_data
def test_draws_have_places_of_their_own(tiny):
    """The second draw is what another seed gives, for every eye; the first is as without draws."""
    arguments, out = tiny
    short = ["--frames", "500", "--epochs", "2"]
    start, scene = arguments[:2], arguments[5:7]

    def curves(eyes, folder, *more):
        where = ["--out", out.parent / folder]
        command = [*start, *eyes, *scene, *short, *where, *more]
        subprocess.run(command, check=True, capture_output=True)
        with (out.parent / folder / "curves.csv").open() as file:
            return [(row["eye"], row["draw"], row["validation_l1"]) for row in csv.DictReader(file)]

    both = curves(arguments[2:4], "draws", "--draws", "2")
    assert [row[:2] for row in both[::2]] == [
        (eye.stem, draw) for eye in EYES[:2] for draw in ("0", "1")
    ]
    seeded = curves(arguments[2:3], "seeded", "--seed", "1")
    assert [row[2] for row in both[2:4]] == [row[2] for row in seeded]
    assert both[0][2] != both[2][2]


def test_what_several_draws_say():
    finals = {
        "real": np.array([[0.40, 0.42], [0.44, 0.46], [0.42, 0.42]]),  # means .41 .45 .42
        "single": np.array([[0.41, 0.43], [0.44, 0.46], [0.45, 0.45]]),  # .42 .45 .45
    }
    lowest = {"real": np.array([0.36, 0.40, 0.37]), "single": np.array([0.36, 0.40, 0.37])}
    real, single = localise.compare(finals, lowest).values()
    # Above the lowest: 0.05 each time, and 0.06, 0.05, 0.08.
    assert (real.above, real.less_first, real.less_first_error) == pytest.approx((0.05, 0, 0))
    assert single.final == pytest.approx(0.44)
    assert single.final_scatter == pytest.approx(np.sqrt(3e-4))
    assert single.less_first == pytest.approx(0.04 / 3)
    scatter = np.std([0.01, 0.0, 0.03], ddof=1)
    assert single.less_first_error == pytest.approx(scatter / np.sqrt(3))
    assert single.anew == pytest.approx(scatter)  # real scatters by nothing
    lone = localise.compare({"real": finals["real"][:1]}, {"real": lowest["real"][:1]})["real"]
    assert np.isnan(lone.final_scatter)


def test_help_has_examples_and_a_missing_file_is_named():
    shown = subprocess.run([sys.executable, SCRIPT, "--help"], capture_output=True, text=True)
    assert shown.returncode == 0
    assert "--frames 100000" in shown.stdout
    wrong = [sys.executable, SCRIPT, "no.eye", "--scene", "no.gltf", "-o", "out"]
    failed = subprocess.run(wrong, capture_output=True, text=True)
    assert failed.returncode == 2
    assert "no.gltf: no such file" in failed.stderr
