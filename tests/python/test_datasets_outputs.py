"""Data sets: conditions of light and what is put out beside responses: receptors, truth, flow."""

import re

import numpy as np
import pytest
from conftest import svg_texts
from dataset_jobs import write_job

import omma
from omma import datasets

zarr = pytest.importorskip("zarr")
xarray = pytest.importorskip("xarray")


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
    assert any("from left to right" in words for words in said)
    assert not any("Grey" in words for words in said), "the eye looks all round"
    assert any(re.fullmatch(r"view \d: ground, noon", words) for words in said), said


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
    with pytest.raises(omma.Error, match=r"rendering\.shared: expected samples where a condition"):
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


@pytest.mark.parametrize("of_first", [False, True])
def test_receptors_of_an_eye_that_has_none(tmp_path, of_first, monkeypatch):
    """Also where another eye of the job has some; before anything else is read."""
    monkeypatch.setattr("omma.datasets.running.digests_of_inputs", None)
    job = write_job(
        tmp_path,
        dataset='outputs = ["responses", "receptors"]',
        more='[[eye]]\nname = "other"\nfiles = "other.csv"',
    )
    bare = omma.load_eye(tmp_path / "bug.csv")
    full = omma.receptors.assign_receptors(bare, omma.receptors.honeybee_ommatidia())
    omma.save_eye(tmp_path / "bug.csv", full if of_first else bare)
    omma.save_eye(tmp_path / "other.csv", bare)
    words = r"job\.toml, eye\[{}\]: .* receptors, as they are among dataset\.outputs, found none"
    with pytest.raises(omma.Error, match=words.format(int(of_first))):
        datasets.run(job)
    assert not (tmp_path / "job.zarr").exists()


def test_baked_light_as_the_job_says(tmp_path, monkeypatch):
    monkeypatch.setenv("OMMA_CACHE", str(tmp_path / "cache"))
    job = write_job(
        tmp_path,
        count=1,
        rendering="bands = 4",
        more="[[condition]]\nname = 'day'\nlight = {sky = 'uniform_sky'}\nultraviolet = 'dark'\n"
        "lighting = 'baked'\nbake = {paths = 16, cell_m = 2.0, seed = 3}\n",
    )
    told = []
    datasets.run(job, progress=lambda stage, share: told.append((stage, share)))
    stages = list(dict.fromkeys(stage for stage, _ in told))
    begun = [stage for stage in stages if stage.startswith("Baking light of 'day' (")]
    assert len(begun) == 1, stages
    assert stages.index("Building worlds") < stages.index(begun[0]) < stages.index("Rendering")
    shares = [share for stage, share in told if stage == begun[0] and share is not None]
    assert shares == sorted(shares)
    assert shares[-1] == 1
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
