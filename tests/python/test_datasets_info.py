"""What ``omma info`` and ``omma render-again`` say of data sets of ``omma dataset run``."""

import shutil

import numpy as np
import pytest
from dataset_jobs import made_store, write_job

import omma
from omma.datasets.store_info import describe_store
from omma.job.places import place_words
from omma.rendering import load_responses

pytest.importorskip("zarr")
pytest.importorskip("xarray")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return made_store(tmp_path_factory.mktemp("made"))


def cut_off(store, copy):
    """The store as it is where only its first shard was made."""
    shutil.copytree(store, copy)
    for shard in (1, 2):
        (copy / "omma" / "done" / f"{shard:08}.json").unlink()
    for name in ("position", "response"):
        for chunk in (copy / name).glob("c.[12].*"):
            chunk.unlink()
    return copy


def test_how_much_is_there_is_told(made, tmp_path):
    lines = dict(describe_store(made[1]))
    assert lines["views"] == "10 of 10 are there"
    assert lines["more"] == f"omma dataset info {made[1]}"
    part = cut_off(made[1], tmp_path / "part.zarr")
    lines = dict(describe_store(part))
    assert lines["views"] == "4 of 10 are there"
    places = load_responses(part).position.values
    assert np.isnan(places[4:]).all()
    low, high = places[:4].min(axis=0), places[:4].max(axis=0)
    assert lines["positions"] == f"{place_words(low)} to {place_words(high)} m"


def test_several_eyes_are_named(tmp_path, run_omma, monkeypatch):
    monkeypatch.chdir(tmp_path)
    job = write_job(tmp_path, more='[[eye]]\nname = "fly"\nfiles = "bug.csv"')
    omma.datasets.run(job, "two.zarr")
    assert describe_store("two.zarr") == [
        ("data set", "two.zarr"),
        ("eyes", "bug, fly"),
        ("views", "10 of 10 are there"),
        ("more", "omma dataset info two.zarr"),
    ]
    code, _, err = run_omma("render-again", "two.zarr", "-o", "again.npy")
    assert code == 1
    assert "two.zarr: is a data set of omma dataset run; omma dataset info" in err
