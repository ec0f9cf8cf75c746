"""Data sets: what is in a store, that runs go on where others ended, and what is refused."""

import contextlib
import importlib
import json
import os
import subprocess
import sys
import warnings

import numpy as np
import pytest
from conftest import svg_texts
from dataset_jobs import bytes_of, made_store, rendered, write_job

import omma
from omma import datasets

running = importlib.import_module("omma.datasets.running")
zarr = pytest.importorskip("zarr")
xarray = pytest.importorskip("xarray")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return made_store(tmp_path_factory.mktemp("made"))


def test_a_store_opens_with_xarray_and_has_what_render_gives(made):
    job, store = made
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        data = xarray.open_zarr(store)
    assert dict(data.sizes) | {"view": 10, "ommatidium": 30, "band": 3} == dict(data.sizes)
    assert data.response.dtype == np.float32
    assert data.position.attrs["units"] == "m"
    assert data.azimuth.attrs["units"] == "degree"
    np.testing.assert_array_equal(data.response, rendered(job, data.world_from_head))
    assert {"scene", "condition", "pose_set", "pose"} <= set(data.response.coords)
    assert data.scene.attrs["flag_meanings"] == "ground"
    assert data.attrs["job"] == job.read_text()
    assert set(json.loads(data.attrs["inputs_sha256"])) == {"scene.gltf", "bug.csv"}
    assert {"omma_version", "backend", "machine", "created", "versions"} <= set(data.attrs)


def test_poses_lie_where_the_job_says(made):
    place = xarray.open_zarr(made[1]).position.values
    assert (place >= [-5, 1, -5]).all()
    assert (place <= [5, 3, 5]).all()
    assert np.ptp(place, axis=0).min() > 1
    assert len(np.unique(place, axis=0)) == 10


def test_again_makes_nothing_and_what_is_missing(made, tmp_path):
    job, store = made
    before = bytes_of(store)
    assert datasets.run(job, store).made == 0
    (store / "omma" / "done" / "00000001.json").unlink()
    (store / "response" / "c.1.0.0").unlink()
    assert np.isnan(xarray.open_zarr(store).response[4:8]).all()  # what is not there is no number
    report = datasets.run(job, store)
    assert (report.made, report.views_made) == (1, 4)
    assert bytes_of(store) == before


def test_the_same_bits_for_any_threads_and_shards(made, tmp_path):
    job, store = made
    datasets.run(job, tmp_path / "one.zarr", threads=1)
    assert bytes_of(tmp_path / "one.zarr") == bytes_of(store)
    text = job.read_text().replace("views_per_shard = 4", "views_per_shard = 8")
    job.with_name("other.toml").write_text(text)
    datasets.run(job.with_name("other.toml"), tmp_path / "other.zarr")
    for name in ("response", "world_from_head", "quaternion"):
        one, other = (xarray.open_zarr(at)[name] for at in (store, tmp_path / "other.zarr"))
        np.testing.assert_array_equal(one, other)


def test_verify_finds_each_kind_of_damage(tmp_path):
    job = write_job(tmp_path)
    store = tmp_path / "job.zarr"
    datasets.run(job)
    before = bytes_of(store)
    assert datasets.verify(store).is_whole
    changed = store / "response" / "c.0.0.0"
    data = bytearray(changed.read_bytes())
    data[10] ^= 1
    changed.write_bytes(data)
    (store / "response" / "c.1.0.0").write_bytes(b"")
    (store / "position" / "c.2.0").unlink()
    report = datasets.verify(store)
    assert not report.is_whole
    assert len(report.damaged) == 3
    for sentence, words in zip(report.damaged, ("other bytes", "0 bytes", "missing"), strict=True):
        assert words in sentence
    # What a run sees without reading all: the two that are not as large as they were.
    assert datasets.run(job).made == 2
    datasets.verify(store, forget=True)
    assert datasets.run(job).made == 1
    assert bytes_of(store) == before


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda job: (job.parent / "scene.gltf").write_text(
            (job.parent / "scene.gltf").read_text() + " "), "scene.gltf has changed"),
        (lambda job: omma.save_eye(job.parent / "bug.csv", omma.eye.generate_eye(30)),
         "bug.csv has changed"),
        (lambda job: write_job(job.parent, count=11), r"job.poses\[0\].count was 10, is 11"),
    ],
)  # fmt: skip
def test_other_inputs_are_refused_and_what_is_done_is_kept(tmp_path, change, words):
    job = write_job(tmp_path)
    datasets.run(job)
    before = bytes_of(tmp_path / "job.zarr")
    change(job)
    with pytest.raises(omma.Error, match=words):
        datasets.run(job)
    assert bytes_of(tmp_path / "job.zarr") == before


def test_inputs_that_change_while_it_runs_are_refused(tmp_path):
    """A world is built of what the data set was begun with, or not at all."""
    job = datasets.load_job(write_job(tmp_path))
    from omma.datasets.records import digests_of_inputs
    from omma.datasets.worlds import Workshop

    digests = digests_of_inputs(job)
    omma.save_eye(tmp_path / "bug.csv", omma.eye.generate_eye(31))
    with pytest.raises(omma.Error, match=r"bug.csv: has changed since"):
        Workshop(job, digests)


@pytest.mark.parametrize(
    ("part", "key", "words"),
    [
        ("compression", "clevel", "compression.clevel was 'another', is 5"),
        ("versions", "zarr", "versions.zarr was 'another', is"),
        ("versions", "numcodecs", "versions.numcodecs was 'another', is"),
    ],
)
def test_other_compression_than_at_the_start(tmp_path, part, key, words):
    job = write_job(tmp_path)
    datasets.run(job)
    path = tmp_path / "job.zarr" / "zarr.json"
    said = json.loads(path.read_text())
    changed = json.loads(said["attributes"][part]) | {key: "another"}
    said["attributes"][part] = json.dumps(changed)
    path.write_text(json.dumps(said))
    (tmp_path / "job.zarr" / "omma" / "done" / "00000001.json").unlink()
    before = bytes_of(tmp_path / "job.zarr")
    with pytest.raises(omma.Error, match=words):
        datasets.run(job)
    assert bytes_of(tmp_path / "job.zarr") == before


@pytest.mark.parametrize("key", ["format", "omma_version"])
def test_a_store_of_another_version(made, tmp_path, key):
    job = write_job(tmp_path)
    datasets.run(job)
    path = tmp_path / "job.zarr" / "zarr.json"
    said = json.loads(path.read_text())
    said["attributes"][key] = "another"
    path.write_text(json.dumps(said))
    with pytest.raises(omma.Error, match="another"):
        datasets.run(job)


def test_what_is_no_data_set(tmp_path):
    job = write_job(tmp_path)
    (tmp_path / "job.zarr").mkdir()
    for call in (lambda: datasets.run(job), lambda: datasets.open_views(tmp_path / "job.zarr")):
        with pytest.raises(omma.Error, match="expected a data set"):
            call()
    zarr.open_group(tmp_path / "other.zarr", mode="w")
    with pytest.raises(omma.Error, match="another Zarr store"):
        datasets.verify(tmp_path / "other.zarr")


def test_two_runs_at_once(made):
    from omma.datasets.records import writing

    job, store = made
    told = pytest.raises(omma.Error, match="written by another run")
    with lacking_a_shard(store), writing(str(store)), told:
        datasets.run(job, store)


def test_where_nothing_is_missing_nothing_is_written(made, monkeypatch):
    """As in a folder that is read-only: whose lock cannot be opened."""
    job, store = made
    monkeypatch.setattr(running, "writing", lambda path: pytest.fail("is written"))
    report = datasets.run(job, store)
    assert (report.views, report.shards, report.made, report.views_made) == (10, 3, 0, 0)
    other = write_job(job.parent / "other", count=11)
    with pytest.raises(omma.Error, match="begun from something else"):
        datasets.run(other, store)


@contextlib.contextmanager
def lacking_a_shard(store):
    """A store that is not whole meanwhile."""
    record = store / "omma" / "done" / "00000001.json"
    said = record.read_bytes()
    record.unlink()
    yield
    record.write_bytes(said)


@pytest.mark.parametrize(
    ("count", "words"), [(10, "written by another run"), (11, "begun from something else")]
)
def test_of_two_runs_that_begin_the_first_one_wins(tmp_path, monkeypatch, count, words):
    """The other run comes after this one found no store, and writes on while this one names its."""
    from omma.datasets.records import writing

    store = tmp_path / "made.zarr"
    other = write_job(tmp_path / "other")
    job = write_job(tmp_path / "job", count=count)
    create = running.create_store
    with contextlib.ExitStack() as still_going_on:

        def create_late(*arguments):
            monkeypatch.setattr(running, "create_store", create)
            assert datasets.run(other, store).made == 3
            (store / "omma" / "done" / "00000001.json").unlink()
            still_going_on.enter_context(writing(str(store)))
            create(*arguments)

        monkeypatch.setattr(running, "create_store", create_late)
        with pytest.raises(omma.Error, match=words):
            datasets.run(job, store)
    assert datasets.run(other, store).made == 1
    assert datasets.verify(store).is_whole
    assert sorted(path.name for path in tmp_path.iterdir()) == ["job", "made.zarr", "other"]


def test_where_nothing_can_be_written_is_told_before_inputs_are_read(made, tmp_path, monkeypatch):
    from omma.datasets.records import writing

    job, store = made
    monkeypatch.setattr(running, "load_eyes", lambda job: pytest.fail("eyes are read"))
    (tmp_path / "file").write_text("")
    with pytest.raises(omma.Error, match=r"file is not a directory"):
        datasets.run(job, tmp_path / "file" / "further" / "job.zarr")
    told = pytest.raises(omma.Error, match="written by another run")
    with lacking_a_shard(store), writing(str(store)), told:
        datasets.run(job, store)
    access = os.access
    monkeypatch.setattr(os, "access", lambda path, mode: path != tmp_path and access(path, mode))
    with pytest.raises(omma.Error, match="nothing may be made in"):
        datasets.run(job, tmp_path / "further" / "job.zarr")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_what_is_said_of_eyes_is_found_once(made, monkeypatch):
    layout = importlib.import_module("omma.datasets.layout")
    calls = []
    labels_of = layout.labels_of
    monkeypatch.setattr(
        layout, "labels_of", lambda *of, **more: calls.append(of) or labels_of(*of, **more)
    )
    assert datasets.run(*made).made == 0
    assert len(calls) == 1


def test_keys_of_rendering_are_offered_once(tmp_path):
    with pytest.raises(omma.Error, match="did you mean 'noise'") as error:
        datasets.load_job(write_job(tmp_path, rendering="noises = 1"))
    offered = str(error.value).partition("expected one of ")[2].partition(", found")[0].split(", ")
    assert sorted(offered) == [
        "angular_sensitivity", "backend", "bands", "devices", "error", "footprints", "least",
        "most", "noise", "points", "relative_error", "samples", "seed", "shared",
    ]  # fmt: skip


def test_a_full_disk(tmp_path):
    """Files that may not grow: as a full disk, the system refuses to write on."""
    job = write_job(tmp_path, count=8)
    datasets.run(job)
    store = tmp_path / "job.zarr"
    before = bytes_of(store)
    responses = store / "response" / "c.1.0.0"
    assert responses.stat().st_size > 600  # else nothing would be refused
    (store / "omma" / "done" / "00000001.json").unlink()
    responses.unlink()
    code = (
        "import resource, signal, sys, omma\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "def limit(stage, share):\n"
        "    if stage == 'Building worlds':\n"
        "        resource.setrlimit(resource.RLIMIT_FSIZE, (600, 600))\n"
        "omma.datasets.run(sys.argv[1], progress=limit)\n"
    )
    done = subprocess.run([sys.executable, "-c", code, job], capture_output=True, text=True)
    assert "cannot be written" in done.stderr
    assert "c.1.0.0" in done.stderr
    assert not responses.exists()
    assert (store / "omma" / "done" / "00000000.json").exists()
    assert datasets.run(job).made == 1
    assert bytes_of(store) == before


def test_eyes_of_different_sizes_have_groups(tmp_path):
    more = '[[eye]]\nname = "fly"\nspecies = "drosophila"'
    job = write_job(tmp_path, count=3, more=more)
    datasets.run(job)
    store = tmp_path / "job.zarr"
    bug, fly = (xarray.open_zarr(store, group=name) for name in ("bug", "fly"))
    assert bug.sizes["ommatidium"] == 30
    assert fly.sizes["ommatidium"] > 1000
    np.testing.assert_array_equal(bug.position, fly.position)
    np.testing.assert_array_equal(bug.response, rendered(job, bug.world_from_head))
    with pytest.raises(omma.Error, match="eye: expected one of bug, fly"):
        datasets.open_views(store)
    assert len(datasets.open_views(store, ["response"], eye="fly")) == 3


def test_a_contact_sheet_speaks_of_grey_where_there_is_some(tmp_path):
    half = tmp_path / "half"
    half.mkdir()
    job = write_job(half, count=2)
    all_round = omma.load_eye(half / "bug.csv")
    ahead = np.flatnonzero(all_round.axis[:, 2] < 0)
    omma.save_eye(half / "bug.csv", all_round.take(ahead))
    datasets.run(job)
    datasets.contact_sheet(tmp_path / "sheet.svg", half / "job.zarr", 2)
    said = svg_texts(tmp_path / "sheet.svg")
    assert any("Grey: no ommatidium looks there" in words for words in said)


def test_a_contact_sheet_has_each_eye_in_a_border():
    contact_sheet = importlib.import_module("omma.datasets.contact_sheet")
    across = contact_sheet._PIXELS
    picture = np.arange(2 * across * 3 * 100, dtype=np.uint8).reshape(100, 2 * across, 3)
    shown = contact_sheet._bordered(picture)
    assert shown.shape == (100, 2 * across + contact_sheet._GAP, 3)
    left, gap, right = shown[:, :across], shown[:, across:-across], shown[:, -across:]
    assert (gap == 255).all()
    for panel, whole in ((left, picture[:, :across]), (right, picture[:, across:])):
        assert (panel[2:-2, 2:-2] == whole[2:-2, 2:-2]).all()
        assert (panel[:2] == 34).all()
        assert (panel[:, -2:] == 34).all()


def test_the_old_name_of_angular_sensitivity(tmp_path):
    job = write_job(tmp_path, rendering='kernel = "pillbox"')
    with pytest.warns(DeprecationWarning, match="kernel: is called angular_sensitivity now"):
        old = datasets.load_job(job)
    new = datasets.load_job(write_job(tmp_path, rendering='angular_sensitivity = "pillbox"'))
    assert old.settings == new.settings
    assert new.settings.angular_sensitivity == "pillbox"


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("count = 10", "", r"poses\[0\].count: expected a value"),
        ("count = 10", "count = 0", r"poses\[0\].count: expected 1"),
        ("count = 10", "count = 10\nsize = 2", r"poses\[0\]: expected one of .*'size'"),
        ("uniform", "uniformly", "sampler: expected one of .*did you mean 'uniform'"),
        ("low_m = [-5, 1, -5]", "low_m = [-5, 4, -5]", "high_m: expected at least low_m"),
        ("samples = 2", "samples = 0", "rendering: samples: expected 1"),
        ("samples = 2", "samples = 2\nerror = 0.1", "samples and error: only one of them"),
        ("samples = 2", "samples = 2\nleast = 8", "samples and least: only one of them"),
        ("samples = 2", 'sampling = "Fixed"', "rendering: expected one of .*'sampling'"),
        ('"scene.gltf"', '"none.gltf"', r"scene\[0\].file: expected a file"),
        ("[[scene]]", "[[scenes]]", "scene: expected a value"),
        ("seed = 5", 'outputs = ["reponses"]', "did you mean 'responses'"),
        ("views_per_shard = 4", "views_per_shard = 5", "a multiple of views_per_chunk"),
        ("[dataset]", "[dataset", "expected TOML"),
        ('name = "bug"', 'name = "a/b"', "expected a name of letters"),
    ],
)
def test_wrong_jobs(tmp_path, old, new, words):
    job = write_job(tmp_path)
    job.write_text(job.read_text().replace(old, new, 1))
    with pytest.raises(omma.Error, match=words):
        datasets.run(job)
    assert not (tmp_path / "job.zarr").exists()


def test_poses_that_stand_alone_have_no_walk(made, tmp_path):
    assert not {"walk", "time"} & set(xarray.open_zarr(made[1]).variables)
    (tmp_path / "path.csv").write_text("x,y,z,yaw_deg,pitch_deg,roll_deg\n0,2,0,0,0,0\n0,3,0,0,0,0")
    poses = (
        '[[poses]]\nsampler = "path"\nfile = "path.csv"\n'
        '[[poses]]\nsampler = "uniform"\nlow_m = [-1, 1, -1]\nhigh_m = [1, 2, 1]\ncount = 2\n'
        '[[poses]]\nname = "timed"\nsampler = "path"\nfile = "path.csv"\nstep_s = 0.25\n'
    )
    datasets.run(write_job(tmp_path, poses=poses))
    data = xarray.open_zarr(tmp_path / "job.zarr")
    assert data.walk.values.tolist() == [0, 0, -1, -1, 0, 0]
    np.testing.assert_array_equal(data.time, [np.nan] * 4 + [0, 0.25])


def test_more_views_than_fit_are_refused(tmp_path):
    path = write_job(tmp_path, count=10**9)
    with pytest.raises(omma.Error, match=r"at most 50,000,000 views .* found 1,000,000,000"):
        datasets.run(path)
