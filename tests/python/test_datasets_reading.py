"""Views of data sets: by number, mask and batch, as files of tar, as tensors."""

import io
import json
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
