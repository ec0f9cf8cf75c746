"""Data sets: what is in a store, that runs go on where others ended, and what is refused."""

import json
import re
import subprocess
import sys
import warnings

import numpy as np
import pytest
from conftest import svg_texts
from dataset_jobs import bytes_of, made_store, rendered, write_job

import omma
from omma import datasets

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
    assert set(data.attrs["inputs_sha256"]) == {"scene.gltf", "bug.csv"}
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
    said["attributes"][part][key] = "another"
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
    with writing(str(store)), pytest.raises(omma.Error, match="written by another run"):
        datasets.run(job, store)


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


def test_conditions_and_all_outputs(tmp_path):
    job = write_job(
        tmp_path,
        count=3,
        dataset='outputs = ["responses", "errors", "truth", "receptors", "pictures"]',
        more='[[condition]]\nname = "red"\nbackground = "1,0,0"\n'
        '[[condition]]\nname = "crate"\nobject = [{file = "crate.glb", position_m = [0, 5, 0]}]\n'
        "[pictures]\nwidth = 16",
    )
    omma.scene.save_scene(tmp_path / "crate.glb", omma.scene.box((8, 1, 8)))
    eye = omma.receptors.assign_receptors(
        omma.load_eye(tmp_path / "bug.csv"), omma.receptors.honeybee_ommatidia()
    )
    omma.save_eye(tmp_path / "bug.csv", eye)
    datasets.run(job)
    data = xarray.open_zarr(tmp_path / "job.zarr")
    assert data.sizes["view"] == 6
    assert data.condition.values.tolist() == [0, 0, 0, 1, 1, 1]
    np.testing.assert_array_equal(data.position[:3], data.position[3:])
    scene = omma.load_scene(tmp_path / "scene.gltf")
    red = omma.Renderer(scene, eye, omma.Fixed(2), background=omma.Background.constant((1, 0, 0)))
    poses = data.world_from_head.values[:3]
    truth = red.ground_truth(poses, standard_error=True)
    np.testing.assert_array_equal(data.response[:3], truth.responses)
    np.testing.assert_array_equal(data.standard_error[:3], truth.standard_error)
    np.testing.assert_array_equal(data.distance[:3], truth.distance_m)
    np.testing.assert_array_equal(data.receptor_response[:3], red.render_receptors(poses))
    assert (data.met[3:].values.sum() > data.met[:3].values.sum()).all()  # the crate is seen
    assert data.picture.shape[1:] == (8, 16, 3)
    assert data.picture.dtype == np.uint8
    # Pixels for programs: nothing is drawn where no ommatidium looks.
    ids = omma.picture.projection_ids(eye, width=16)
    np.testing.assert_array_equal(data.picture[0], omma.picture.paint(ids, truth.responses[0]))


def test_a_lit_world_by_the_time_of_day(tmp_path):
    sky = "light = {{sky = 'clear_sky', sun_elevation_deg = {}}}\nultraviolet = 'dark'\n"
    job = write_job(
        tmp_path,
        count=2,
        rendering="bands = 4",
        more="[[condition]]\nname = 'low'\n" + sky.format(3)
        + "[[condition]]\nname = 'noon'\n" + sky.format(60),
    )  # fmt: skip
    datasets.run(job)
    data = xarray.open_zarr(tmp_path / "job.zarr")
    assert data.response.attrs["units"] == "photons m-2 s-1 sr-1 nm-1"
    assert data.sizes["band"] == 4
    assert data.wavelength.attrs["units"] == "nm"
    low, noon = (float(some.mean()) for some in (data.response[:2], data.response[2:]))
    assert noon > 2 * low > 0
    datasets.contact_sheet(tmp_path / "sheet.svg", tmp_path / "job.zarr", 3)
    said = svg_texts(tmp_path / "sheet.svg")
    assert any("Hatched: no ommatidium looks there" in words for words in said)
    assert any(re.fullmatch(r"view \d: ground, noon", words) for words in said), said


def test_a_contact_sheet_has_each_eye_in_a_border():
    import importlib

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
        ("samples = 2", "samples = 2\nerror = 0.1", "only one of them"),
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


@pytest.mark.parametrize(
    ("dataset", "more", "poses", "words"),
    [
        ('outputs = ["shares"]', "", "", "expected instances, .* found no instances"),
        ('instances = ["crate"]', "", "", "found no output shares"),
        ('outputs = ["shares"]\ninstances = ["crat"]', "", "", "instances: expected .*'crat'"),
        ('outputs = ["flow"]', "", "", "poses 'high': expected speed_m_s or turn_deg_s"),
        ("", "[[condition]]\nname = 'a'\nlight = {sky = 'uniform_sky'}\nbake = {path = 16}",
         "", r"condition\[0\].bake: expected one of .* did you mean 'paths'"),
        ("", "[[condition]]\nname = 'a'\nlight = {sky = 'uniform_sky'}\nbake = {paths = 17}",
         "", r"condition\[0\].bake: paths: expected a multiple of 16"),
        ("", "[[condition]]\nname = 'a'\nbake = {paths = 16}", "", "bake: goes with a light"),
        ("", "[[condition]]\nname = 'a'\nlight = {sky = 'uniform_sky'}\nbake = {paths = 16}",
         "", r'condition\[0\].bake: goes with lighting = "baked"'),
        ("", "[[condition]]\nname = 'a'\nlight = {sky = 'uniform_sky'}\npolarized = 'yes'",
         "", r"condition\[0\].polarized: expected true or false, found yes"),
    ],
)  # fmt: skip
def test_outputs_and_light_that_cannot_be(tmp_path, dataset, more, poses, words):
    job = write_job(tmp_path, dataset=dataset, more=more)
    with pytest.raises(omma.Error, match=words):
        datasets.run(job)
    assert not (tmp_path / "job.zarr").exists()


def test_shared_rays_in_a_polarised_world_are_told_when_the_job_is_read(tmp_path):
    lit = "[[condition]]\nname = 'a'\nlight = {sky = 'uniform_sky'}\npolarized = true"
    job = write_job(tmp_path, more=lit)
    assert datasets.load_job(job).conditions[0].world_options["polarized"]
    job.write_text(job.read_text().replace("samples = 2", "shared = 2"))
    with pytest.raises(omma.Error, match="rendering.shared: expected samples where a condition"):
        datasets.load_job(job)


def test_flow_and_shares_are_those_of_ground_truth(tmp_path):
    """Of heads that fly ahead and turn; what stands in one condition alone has no share in the
    other."""
    job = write_job(
        tmp_path,
        count=3,
        dataset='outputs = ["responses", "flow", "shares"]\ninstances = ["crate"]',
        more='[[condition]]\nname = "plain"\n'
        '[[condition]]\nname = "crate"\nobject = [{file = "crate.glb", position_m = [0, 5, 0]}]',
    )
    job.write_text(job.read_text() + "speed_m_s = [0.5, 1]\nturn_deg_s = [-100, -50]\n")
    omma.scene.save_scene(tmp_path / "crate.glb", omma.scene.box((8, 1, 8), name="crate"))
    datasets.run(job)
    data = xarray.open_zarr(tmp_path / "job.zarr")
    assert "distance" not in data  # truth was not asked for
    poses = data.world_from_head.values
    ahead, up = -poses[:, :3, 2], poses[:, :3, 1]
    speed = (data.head_velocity.values * ahead).sum(axis=1)
    assert ((speed > 0.5) & (speed < 1)).all()
    np.testing.assert_allclose(data.head_velocity, speed[:, None] * ahead, atol=1e-12)
    # To the left: right-handed about the head's up.
    turn = np.degrees((data.head_turn.values * up).sum(axis=1))
    assert ((turn > 50) & (turn < 100)).all()
    assert data.head_turn.attrs["units"] == data.flow.attrs["units"] == "rad s-1"
    assert data.direction.values.tolist() == ["right", "up"]
    assert data.instance.values.tolist() == ["crate"]
    scene = omma.load_scene(tmp_path / "scene.gltf")
    placed = omma.scene.place_scene(
        omma.load_scene(tmp_path / "crate.glb"), omma.poses_from_angles((0, 5, 0), (0, 0, 0))[0]
    )
    eye = omma.load_eye(tmp_path / "bug.csv")
    both = omma.Renderer(omma.scene.merge_scenes([scene, placed]), eye, omma.Fixed(2))
    truth = both.ground_truth(
        poses[3:],
        shares=["crate"],
        head_velocity=(data.head_velocity.values[3:], data.head_turn.values[3:]),
    )
    np.testing.assert_array_equal(data.flow[3:], truth.flow_rad_s)
    np.testing.assert_array_equal(data.flow_rotation[3:], truth.flow_rotation_rad_s)
    np.testing.assert_array_equal(data.share[3:], truth.shares)
    assert (data.share[3:].values.sum(axis=(1, 2)) > 0).all()
    assert (data.share[:3] == 0).all()


def test_flow_along_walks_and_paths(tmp_path):
    """Heads move as their poses follow one another, whatever shard they are in."""
    lines = [f"0,{2 + 0.1 * k},0,{10 * k},0,0" for k in range(6)]
    (tmp_path / "path.csv").write_text("\n".join(["x,y,z,yaw_deg,pitch_deg,roll_deg", *lines]))
    poses = (
        '[[poses]]\nname = "walks"\nsampler = "walk"\nlow_m = [-5, 1, -5]\nhigh_m = [5, 3, 5]\n'
        "walks = 2\nsteps = 5\nstep_s = 0.02\nspeed_m_s = 0.5\n"
        '[[poses]]\nname = "path"\nsampler = "path"\nfile = "path.csv"\nstep_s = 0.5\n'
    )
    job = write_job(tmp_path, dataset='outputs = ["flow"]', poses=poses)
    datasets.run(job)
    data = xarray.open_zarr(tmp_path / "job.zarr")
    made = data.world_from_head.values
    for some, step_s in ((slice(0, 5), 0.02), (slice(5, 10), 0.02), (slice(10, 16), 0.5)):
        times_s = np.arange(len(made[some])) * step_s
        linear, angular = omma.velocities_from_poses(made[some], times_s)
        np.testing.assert_allclose(data.head_velocity[some], linear, atol=1e-9)
        np.testing.assert_allclose(data.head_turn[some], angular, atol=1e-9)
    np.testing.assert_allclose(data.head_velocity[10:], [[0, 0.2, 0]] * 6, atol=1e-9)
    # Which pose comes after which, and when.
    assert data.walk.values.tolist() == [0] * 5 + [1] * 5 + [0] * 6
    expected = [*np.arange(5) * 0.02] * 2 + [*np.arange(6) * 0.5]
    np.testing.assert_array_equal(data.time, expected)
    assert data.time.attrs["units"] == "s"
    views = datasets.open_views(tmp_path / "job.zarr", ["walk", "time"])
    second = views[views[:]["walk"] == 1]
    np.testing.assert_array_equal(second["time"], np.arange(5) * 0.02)
    # 20 degrees a second to the right.
    np.testing.assert_allclose(np.degrees(data.head_turn[10:]), [[0, -20, 0]] * 6, atol=1e-6)


@pytest.mark.parametrize("climb", ["10", "[-20, -5]"])
def test_walks_that_only_climb_are_refused(tmp_path, climb):
    poses = (
        '[[poses]]\nname = "walks"\nsampler = "walk"\nlow_m = [-5, 1, -5]\nhigh_m = [5, 3, 5]\n'
        f"walks = 2\nsteps = 5\nspeed_m_s = 0.5\nclimb_deg = {climb}\n"
    )
    with pytest.raises(omma.Error, match=r"climb_deg: expected a range .* with level ways in it"):
        datasets.run(write_job(tmp_path, poses=poses))


def test_baked_light_as_the_job_says(tmp_path, monkeypatch):
    monkeypatch.setenv("OMMA_CACHE", str(tmp_path / "cache"))
    job = write_job(
        tmp_path,
        count=1,
        rendering="bands = 4",
        more="[[condition]]\nname = 'day'\nlight = {sky = 'uniform_sky'}\nultraviolet = 'dark'\n"
        "lighting = 'baked'\nbake = {paths = 16, cell_m = 2.0, seed = 3}\n",
    )
    datasets.run(job)
    bake = omma.scene.Bake(paths=16, cell_m=2.0, seed=3)
    light = omma.light.uniform_sky(bands=omma.light.Bands.equal(4))
    scene = omma.load_scene(tmp_path / "scene.gltf")
    world = omma.World(scene, light=light, lighting="baked", ultraviolet="dark", bake=bake)
    assert (world.baked.paths, world.baked.from_cache) == (16, True)  # the job's own
    eye = omma.load_eye(tmp_path / "bug.csv")
    data = xarray.open_zarr(tmp_path / "job.zarr")
    seen = omma.Renderer(world, eye, omma.Fixed(2)).render(data.world_from_head.values)
    np.testing.assert_array_equal(data.response, seen)


def test_receptors_see_polarised_light_where_the_job_says_so(tmp_path):
    job = write_job(
        tmp_path,
        count=2,
        dataset='outputs = ["receptors"]',
        rendering="bands = 4",
        more="[[condition]]\nname = 'dusk'\nultraviolet = 'dark'\npolarized = true\n"
        "light = {sky = 'clear_sky', sun_elevation_deg = 5}\n",
    )
    eye = omma.load_eye(tmp_path / "bug.csv")
    across = omma.receptors.ReceptorType(
        "rim", peak_wavelength_nm=345, polarisation_sensitivity=6.3
    )
    kind = omma.receptors.OmmatidiumType("rim", (across,))
    omma.save_eye(tmp_path / "bug.csv", omma.receptors.assign_receptors(eye, kind))
    datasets.run(job)
    data = xarray.open_zarr(tmp_path / "job.zarr")
    world = omma.World(
        omma.load_scene(tmp_path / "scene.gltf"),
        light=omma.light.clear_sky(5, bands=omma.light.Bands.equal(4)),
        ultraviolet="dark",
        polarized=True,
    )
    seen = omma.Renderer(world, omma.load_eye(tmp_path / "bug.csv"), omma.Fixed(2))
    np.testing.assert_array_equal(
        data.receptor_response, seen.render_receptors(data.world_from_head.values)
    )


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
