"""What a store says of what made it, who may go on with it, and how its views are made again."""

import json

import numpy as np
import pytest
from dataset_jobs import AVX2, bytes_of, made_store, write_job

import omma
from omma import datasets
from omma.base import processors
from omma.datasets.records import check_worker

pytest.importorskip("zarr")
xarray = pytest.importorskip("xarray")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return made_store(tmp_path_factory.mktemp("made"))


def change_attributes(store, change):
    path = store / "zarr.json"
    said = json.loads(path.read_text())
    change(said["attributes"])
    path.write_text(json.dumps(said))


def test_another_instruction_set_is_refused(tmp_path, monkeypatch):
    """Embree's last bits differ between them: a store would be of two kinds."""
    job, store = write_job(tmp_path), tmp_path / "job.zarr"
    monkeypatch.setattr(processors, "processor_flags", lambda: AVX2)
    datasets.run(job)
    record = store / "omma" / "done" / "00000001.json"
    assert xarray.open_zarr(store).attrs["instruction_set"] == "AVX2"
    assert json.loads(record.read_text())["instruction_set"] == "AVX2"
    assert any("on AVX2, begun" in line for line in datasets.describe(store))
    record.unlink()
    monkeypatch.setattr(processors, "processor_flags", lambda: frozenset({"sse4_2", "popcnt"}))
    with pytest.raises(omma.Error, match=r"instruction_set was 'AVX2', is 'SSE4\.2'"):
        datasets.run(job)
    with pytest.raises(omma.Error, match=r"worker .*'AVX2', is 'SSE4\.2'.*portable"):
        check_worker(str(store), omma.World(omma.Scene()).backend)
    assert not record.exists()
    # One that an older version began does not say it.
    change_attributes(store, lambda said: said.pop("instruction_set"))
    assert datasets.run(job).made == 1


def test_any_instruction_set_goes_on_with_what_does_not_depend_on_it(tmp_path, monkeypatch):
    job, store = write_job(tmp_path, rendering='backend = "portable"'), tmp_path / "job.zarr"
    datasets.run(job)
    assert "instruction_set" not in xarray.open_zarr(store).attrs
    (store / "omma" / "done" / "00000001.json").unlink()
    monkeypatch.setattr(processors, "processor_flags", lambda: frozenset({"sse4_2", "popcnt"}))
    assert datasets.run(job).made == 1


def test_any_format_holds_the_attributes(made, tmp_path):
    data = xarray.open_zarr(made[1])
    some = data.isel(view=slice(0, 3))
    some.to_netcdf(tmp_path / "some.nc", engine="h5netcdf")
    assert xarray.load_dataset(tmp_path / "some.nc", engine="h5netcdf").attrs == data.attrs


def test_older_versions_wrote_objects_as_attributes(tmp_path):
    job, store = write_job(tmp_path), tmp_path / "job.zarr"
    datasets.run(job)
    before = bytes_of(store)
    is_object = ("job_plain", "inputs_sha256", "compression", "versions", "groups", "names")
    change_attributes(
        store, lambda said: said.update({name: json.loads(said[name]) for name in is_object})
    )
    assert any("conditions: " in line for line in datasets.describe(store))
    assert len(datasets.open_views(store)) == 10
    (store / "omma" / "done" / "00000001.json").unlink()
    assert datasets.run(job).made == 1
    assert bytes_of(store) == before
    change_attributes(store, lambda said: said.update(names="[]"))
    with pytest.raises(omma.Error, match="names: expected JSON of an object"):
        datasets.open_views(store)


def test_one_view_is_rendered_again(tmp_path):
    """By its number in the whole store, which is the number of its frame."""
    grey = '[[condition]]\nname = "grey"\nbackground = "0.1,0.1,0.1"\n'
    day = '[[condition]]\nname = "day"\n'
    outputs, noise = 'outputs = ["responses", "errors"]', 'noise = "new_every_frame"\nseed = 9'
    job = write_job(tmp_path, dataset=outputs, rendering=noise, more=day + grey)
    datasets.run(job)
    data = xarray.open_zarr(tmp_path / "job.zarr")
    scene, eye = omma.load_scene(tmp_path / "scene.gltf"), omma.load_eye(tmp_path / "bug.csv")
    backgrounds = (None, omma.Background.constant((0.1, 0.1, 0.1)))
    for view, condition in ((3, 0), (17, 1)):
        assert data.condition[view] == condition
        world = omma.World(scene, background=backgrounds[condition])
        renderer = omma.Renderer(world, eye, omma.Fixed(2), noise="new_every_frame", seed=9)
        poses = data.world_from_head[view].values
        responses, errors = renderer.render(poses, standard_error=True, first_pose=view)
        np.testing.assert_array_equal(responses[0], data.response[view])
        np.testing.assert_array_equal(errors[0], data.standard_error[view])
        assert (renderer.render(poses, first_pose=view - 1) != responses).any()


def test_chunks_along_views_are_made_to_agree(made):
    """As docs/datasets.md says of a store."""
    data = xarray.open_zarr(made[1]).unify_chunks()
    assert data.chunks["view"] == (2, 2, 2, 2, 2)
    np.testing.assert_array_equal(data.response[7], xarray.open_zarr(made[1]).response[7])


def test_stages_are_told_by_what_is_done(tmp_path):
    told = []
    datasets.run(write_job(tmp_path), progress=lambda stage, share: told.append((stage, share)))
    assert list(dict.fromkeys(stage for stage, _ in told)) == [
        *("Reading the eyes", "Laying out the store", "Checking inputs", "Opening the store"),
        *("Building worlds", "Rendering", "Writing"),
    ]
    assert told[-1] == ("Writing", None)
