"""Views of data sets: by number, mask and batch, as files of tar, as tensors."""

import io
import json
import shutil
import tarfile
import warnings

import numpy as np
import pytest
from dataset_jobs import made_store, write_job

import omma
from omma import datasets

xarray = pytest.importorskip("xarray")
pytest.importorskip("zarr")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return made_store(tmp_path_factory.mktemp("made"))


def test_views_in_any_order(made):
    data = xarray.open_zarr(made[1]).response.values
    views = datasets.open_views(made[1], ["response", "pose"])
    assert len(views) == 10
    assert views[3]["pose"] == 3
    np.testing.assert_array_equal(views[3]["response"], data[3])
    np.testing.assert_array_equal(views[[7, 2, 7]]["response"], data[[7, 2, 7]])
    np.testing.assert_array_equal(views[2:5]["response"], data[2:5])
    np.testing.assert_array_equal(views[[]]["response"], data[:0])
    with pytest.raises(IndexError):
        views[10]
    with pytest.raises(omma.Error, match=r"variables: expected one of .*'respose'"):
        datasets.open_views(made[1], ["respose"])


def test_views_by_a_mask(made):
    data = xarray.open_zarr(made[1])
    views = datasets.open_views(made[1], ["response", "pose"])
    mask = data.pose.values % 3 == 1
    for one in (mask, mask.tolist()):
        np.testing.assert_array_equal(views[one]["pose"], data.pose[mask])
        np.testing.assert_array_equal(views[one]["response"], data.response[mask])
    assert views[~(mask | ~mask)]["response"].shape == (0, *data.response.shape[1:])
    np.testing.assert_array_equal(views[[-1, 0]]["pose"], [9, 0])
    assert views[np.array(4)]["pose"] == 4


@pytest.mark.parametrize(
    ("index", "kind", "said"),
    [
        ([True, False], omma.Error, r"index, a mask: expected shape \(10,\), found \(2,\)"),
        ([1.7], omma.Error, "index: expected whole numbers, found"),
        ([[1], [2, 3]], omma.Error, "index: expected numbers, found rows of different lengths"),
        ([[1, 2]], omma.Error, r"index: expected shape \(N,\), found \(1, 2\)"),
        (["response"], omma.Error, "index: expected numbers, found"),
        (1.7, TypeError, "index: expected a whole number, indices or a mask .*, found float 1.7"),
        (True, TypeError, "found bool True"),
        (np.array(True), TypeError, "found ndarray"),
        (None, TypeError, "found NoneType"),
        ("response", TypeError, "found str 'response'"),
        ([0, -11], IndexError, "index: expected -10 to 9, found -11"),
    ],
)
def test_what_is_no_index_of_views(made, index, kind, said):
    views = datasets.open_views(made[1], ["pose"])
    with pytest.raises(kind, match=said):
        views[index]


def test_batches_have_each_view_once(made):
    views = datasets.open_views(made[1], ["pose"])
    orders = [
        np.concatenate([one["pose"] for one in datasets.batches(views, 4, epoch=epoch, ahead=1)])
        for epoch in (0, 0, 1)
    ]
    assert sorted(orders[0]) == list(range(10))
    np.testing.assert_array_equal(orders[0], orders[1])
    assert (orders[0] != orders[2]).any()
    of_torch = next(datasets.batches(views, 10, seed=(1 << 64) - 1))  # torch.initial_seed()
    assert sorted(of_torch["pose"]) == list(range(10))
    with pytest.raises(omma.Error, match="seed: expected 0 to 18446744073709551615"):
        next(datasets.batches(views, seed=1 << 64))
    straight = next(datasets.batches(views, 4, shuffle=False))
    assert straight["pose"].tolist() == [0, 1, 2, 3]


def test_views_of_what_is_there(tmp_path):
    job = write_job(tmp_path)
    datasets.run(job)
    (tmp_path / "job.zarr" / "omma" / "done" / "00000001.json").unlink()
    with pytest.warns(UserWarning, match="6 of 10 views are there; a run of its job makes"):
        views = datasets.open_views(tmp_path / "job.zarr", ["pose"])
    assert views.numbers.tolist() == [0, 1, 2, 3, 8, 9]
    assert views[4]["pose"] == 8
    assert "6 of 10 views are there, 2 of 3 shards" in datasets.describe(tmp_path / "job.zarr")[0]


def test_a_bit_that_changed_is_told_with_its_file(tmp_path):
    """It was read as other numbers: of views, and of what is known of them."""
    job = write_job(tmp_path)
    store = tmp_path / "job.zarr"
    datasets.run(job)
    names = ["response", "position", "pose"]
    views = datasets.open_views(store, names)
    for name in ("response/c.1.0.0", "position/c.1.0", "pose/c/0"):
        data = (store / name).read_bytes()
        for k, place in enumerate(range(0, len(data), max(1, len(data) // 12))):
            changed = bytearray(data)
            changed[place] ^= 1 << (k % 8)
            (store / name).write_bytes(changed)
            with pytest.raises(omma.Error) as told:
                views[:]
            if name != "pose/c/0":  # which all shards share
                assert f"{name} has other bytes than were written" in str(told.value)
                assert "shard 1 is damaged" in str(told.value)
                assert f"omma dataset verify --forget {store}" in str(told.value)
        (store / name).write_bytes(data)
    assert len(views[:]["pose"]) == 10


def test_files_that_are_missing_or_cut_off_are_views_that_are_not_there(tmp_path):
    """They were read as views without light."""
    job = write_job(tmp_path)
    store = tmp_path / "job.zarr"
    datasets.run(job)
    (store / "response" / "c.1.0.0").unlink()
    with pytest.warns(UserWarning, match="6 of 10 views are there"):
        assert datasets.open_views(store).numbers.tolist() == [0, 1, 2, 3, 8, 9]
    (store / "response" / "c.0.0.0").write_bytes(b"")
    with pytest.warns(UserWarning, match="2 of 10 views are there"):
        assert datasets.open_views(store).numbers.tolist() == [8, 9]


def test_stores_of_older_versions_have_no_checksums(tmp_path):
    """They are read and gone on with as they were begun."""
    job = write_job(tmp_path)
    datasets.run(job)
    expected = datasets.open_views(tmp_path / "job.zarr")[:]["response"]
    old = tmp_path / "old.zarr"
    shutil.copytree(tmp_path / "job.zarr", old)
    for path in [old / "zarr.json", *old.glob("*/zarr.json")]:
        path.write_text(json.dumps(without_checksums(json.loads(path.read_text()))))
    shutil.rmtree(old / "omma" / "done")
    (old / "omma" / "done").mkdir()
    assert datasets.run(job, old).made == 3
    np.testing.assert_array_equal(datasets.open_views(old)[:]["response"], expected)
    assert (old / "response" / "c.0.0.0").stat().st_size == (
        tmp_path / "job.zarr" / "response" / "c.0.0.0"
    ).stat().st_size - 2 * 4  # of two chunks


def without_checksums(said):
    """Metadata of a store or an array as older versions wrote them."""
    if isinstance(said, list):
        return [without_checksums(one) for one in said if one != {"name": "crc32c"}]
    if isinstance(said, dict):
        return {
            name: one if name == "index_codecs" else without_checksums(one)
            for name, one in said.items()
            if name != "checksum"
        }
    return said


def test_a_store_that_is_not_whole_says_what_is_missing(made, tmp_path):
    more = '[[condition]]\nname = "noon"\n[[condition]]\nname = "dusk"\n'
    datasets.run(write_job(tmp_path, count=4, more=more))
    store = tmp_path / "job.zarr"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert repr(datasets.open_views(store)).startswith("Views(8 of 8 views of 'bug' in")
    (store / "omma" / "done" / "00000001.json").unlink()
    with pytest.warns(UserWarning, match="are there") as told:
        views = datasets.open_views(store)
    assert [str(one.message) for one in told] == [
        f"{store}: 4 of 8 views are there, none of condition 'dusk'; a run of its job makes the "
        "others"
    ]
    assert told[0].filename == __file__
    assert repr(views).startswith("Views(4 of 8 views of 'bug' in")
    (store / "omma" / "done" / "00000000.json").unlink()
    with pytest.warns(UserWarning, match="0 of 8 views are there; a run"):
        assert len(datasets.open_views(store)) == 0


def test_tar_files(made, tmp_path):
    names = datasets.to_webdataset(made[1], tmp_path / "tars", views_per_file=6)
    data = xarray.open_zarr(made[1])
    assert [name.rsplit("/", 1)[1] for name in names] == ["views-000000.tar", "views-000001.tar"]
    with tarfile.open(names[1]) as tar:
        assert tar.getnames()[:2] == ["00000006.response.npy", "00000006.json"]
        found = np.load(io.BytesIO(tar.extractfile("00000007.response.npy").read()))
        said = json.load(tar.extractfile("00000007.json"))
    np.testing.assert_array_equal(found, data.response[7])
    assert said["scene"] == "ground"
    assert said["pose"] == 7
    np.testing.assert_array_equal(said["world_from_head"], data.world_from_head[7])


def test_pytorch(made):
    torch = pytest.importorskip("torch", reason="needs PyTorch: pip install 'omma[torch]'")
    views = datasets.open_views(made[1])
    loader = torch.utils.data.DataLoader(
        datasets.torch_dataset(views), batch_size=4, num_workers=1,
        multiprocessing_context="spawn",
    )  # fmt: skip
    found = torch.concatenate([one["response"] for one in loader]).numpy()
    np.testing.assert_array_equal(found, xarray.open_zarr(made[1]).response)


def test_pytorch_in_any_order(made):
    """Several variables, shuffled: each view once, and all of one view together."""
    torch = pytest.importorskip("torch", reason="needs PyTorch: pip install 'omma[torch]'")
    views = datasets.open_views(made[1], ["response", "pose"])
    data = xarray.open_zarr(made[1]).response.values
    loader = torch.utils.data.DataLoader(
        datasets.torch_dataset(views), batch_size=3, shuffle=True,
        generator=torch.Generator().manual_seed(1),
    )  # fmt: skip
    batches = list(loader)
    order = torch.concatenate([one["pose"] for one in batches]).numpy()
    assert sorted(order) == list(range(10))
    assert (order != np.arange(10)).any()
    for one in batches:
        assert one["response"].dtype == torch.float32
        np.testing.assert_array_equal(one["response"].numpy(), data[one["pose"].numpy()])
