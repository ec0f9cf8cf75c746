"""Data sets of PyTorch: of stores and of renderers, as maps and as streams, by workers of every
start method; pinned memory where there is a card; tensors in and out."""

import sys

import numpy as np
import pytest
from dataset_jobs import write_job

import omma
from omma import datasets

torch = pytest.importorskip("torch", reason="needs PyTorch: pip install 'omma[torch]'")
pytest.importorskip("zarr")
from torch.utils.data import DataLoader  # noqa: E402

START = ["fork", "spawn", "forkserver"]


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """40 views, two in a chunk; one shard of the middle is missing."""
    job = write_job(tmp_path_factory.mktemp("torch") / "job", count=40)
    datasets.run(job)
    made = job.parent / "job.zarr"
    (made / "omma" / "done" / "00000004.json").unlink()
    return made


@pytest.fixture(scope="module")
def views(store):
    with pytest.warns(UserWarning, match="36 of 40 views are there"):
        return datasets.open_views(store, ["response", "pose", "position"])


@pytest.fixture(scope="module")
def walker():
    picture = np.random.default_rng(2).random((8, 40, 3)).astype(np.float32)
    world = omma.World(omma.scene.drum(2.0, 4.0, picture))
    return omma.Renderer(world, omma.eye.generate_eye(30), omma.Fixed(4), threads=1)


def poses_of(places):
    poses = np.tile(np.eye(4), (len(places), 1, 1))
    poses[:, :3, 3] = places
    return poses


POSES = poses_of(np.random.default_rng(5).uniform(-1, 1, (17, 3)))


def draw(rng, count):
    """At module level, for workers that are spawned."""
    places = rng.uniform(-1, 1, (count, 3))
    return poses_of(places), {"place": places.astype(np.float32)}


def worker_options(start):
    if start is None:
        return {}
    # A worker that hangs is an error after that.
    return {"num_workers": 2, "multiprocessing_context": start, "timeout": 120}


def together(batches):
    return {name: torch.cat([one[name] for one in batches]).numpy() for name in batches[0]}


@pytest.mark.parametrize("start", [None, *START])
def test_views_in_order_by_any_workers(views, start):
    """Also by forked ones, of a parent that has read by Zarr's threads before."""
    expected = views[:]
    assert len(expected["pose"]) == 36
    loader = DataLoader(datasets.torch_dataset(views), batch_size=5, **worker_options(start))
    found = together(list(loader))
    assert found.keys() == expected.keys()
    for name, values in found.items():
        np.testing.assert_array_equal(values, expected[name])


@pytest.mark.parametrize("start", [None, "fork", "spawn"])
def test_a_stream_has_each_view_once(views, start):
    expected = views[:]
    stream = datasets.torch_stream(views, 5)
    loader = DataLoader(
        stream, batch_size=None, generator=torch.Generator().manual_seed(1), **worker_options(start)
    )
    batches = list(loader)
    assert all(isinstance(values, torch.Tensor) for one in batches for values in one.values())
    assert len(stream) == len(loader) == len(batches) == 8
    assert sorted(len(one["pose"]) for one in batches) == [1, *[5] * 7]
    found = together(batches)
    assert sorted(found["pose"]) == sorted(expected["pose"])
    assert (found["pose"] != expected["pose"]).any()
    row = {pose: k for k, pose in enumerate(expected["pose"].tolist())}
    order = [row[pose] for pose in found["pose"].tolist()]
    np.testing.assert_array_equal(found["response"], expected["response"][order])


def orders(stream, seed, epochs=2, **options):
    loader = DataLoader(
        stream, batch_size=None, generator=torch.Generator().manual_seed(seed), **options
    )
    return [together(list(loader))["pose"].tolist() for _ in range(epochs)]


@pytest.mark.parametrize("kept", [False, True])
def test_the_loaders_seed_says_the_order(views, kept):
    options = worker_options("fork") | {"persistent_workers": kept}
    first, second = orders(datasets.torch_stream(views, 5), 3, **options)
    assert first != second  # another epoch
    assert sorted(first) == sorted(second)
    again, _ = orders(datasets.torch_stream(views, 5), 3, **options)
    assert again == first
    other, _ = orders(datasets.torch_stream(views, 5), 4, **options)
    assert other != first


def test_the_seed_of_torch_says_the_order_without_workers(views):
    torch.manual_seed(5)
    first, second = orders(datasets.torch_stream(views, 5), 0)
    torch.manual_seed(5)
    again, _ = orders(datasets.torch_stream(views, 5), 0)
    assert first == again != second


def test_a_stream_without_shuffling(views):
    found = together(list(datasets.torch_stream(views, 7, shuffle=False)))
    np.testing.assert_array_equal(found["pose"], views[:]["pose"])


def test_a_stream_of_nothing(views):
    nothing = datasets.Views(views.store, views.eye, views.variables, views.numbers[:0])
    assert list(datasets.torch_stream(nothing)) == []
    assert len(datasets.torch_stream(nothing)) == 0


@pytest.mark.parametrize("workers", [3, 5])
def test_more_workers_than_batches_give_the_same_batches(views, workers):
    stream = datasets.torch_stream(views, 10, shuffle=False)
    loader = DataLoader(stream, batch_size=None, num_workers=workers, timeout=120)
    found = sorted(one["pose"].tolist() for one in loader)
    assert found == [one["pose"].tolist() for one in stream]


@pytest.mark.parametrize("start", [None, "fork", "spawn"])
def test_renders_by_any_workers_have_the_same_bits(walker, start):
    expected = walker.ground_truth(POSES)
    labels = {"food": np.arange(17) % 3, "scent": np.ones((17, 2), np.float32)}
    data = datasets.torch_renders(walker, POSES, truth=["distance_m", "normal"], labels=labels)
    assert len(data) == 17
    loader = DataLoader(data, batch_size=4, shuffle=False, **worker_options(start))
    found = together(list(loader))
    assert found["response"].dtype == np.float32
    np.testing.assert_array_equal(found["response"], expected.responses)
    np.testing.assert_array_equal(found["distance_m"], expected.distance_m)
    np.testing.assert_array_equal(found["normal"], expected.normal)
    np.testing.assert_array_equal(found["world_from_head"], POSES)
    np.testing.assert_array_equal(found["food"], labels["food"])
    assert found["scent"].shape == (17, 2)


def test_a_batch_is_one_render(walker, monkeypatch):
    calls = []
    render = omma.Renderer.render

    def counted(self, poses, **options):
        calls.append(len(poses))
        return render(self, poses, **options)

    monkeypatch.setattr(omma.Renderer, "render", counted)
    list(DataLoader(datasets.torch_renders(walker, POSES), batch_size=8))
    assert calls == [8, 8, 1]


def test_one_render_by_its_index(walker):
    data = datasets.torch_renders(walker, POSES)
    expected = walker.render(POSES)
    for index in (0, 5, -1):
        np.testing.assert_array_equal(data[index]["response"].numpy(), expected[index])
    with pytest.raises(IndexError, match="expected -17 to 16, found 17"):
        data[17]
    for wrong in (1.7, True, "response"):
        with pytest.raises(TypeError, match=r"index: expected .* a mask \(17,\)"):
            data[wrong]


def test_new_noise_goes_by_the_number_of_a_pose(walker):
    noisy = walker.with_eye(walker.eye, noise="new_every_frame")
    expected = noisy.render(POSES, first_pose=0)
    loader = DataLoader(
        datasets.torch_renders(noisy, POSES), batch_size=4, shuffle=True,
        generator=torch.Generator().manual_seed(0),
    )  # fmt: skip
    found = together(list(loader))
    row = {pose.tobytes(): k for k, pose in enumerate(POSES)}
    order = [row[pose.tobytes()] for pose in found["world_from_head"]]
    assert order != list(range(17))
    np.testing.assert_array_equal(found["response"], expected[order])


def test_receptors(walker):
    bee = omma.receptors.assign_receptors(walker.eye, omma.receptors.honeybee_ommatidia())
    renderer = walker.with_eye(bee)
    data = datasets.torch_renders(renderer, POSES, receptors=True)
    found = together(list(DataLoader(data, batch_size=9)))
    np.testing.assert_array_equal(found["response"], renderer.render_receptors(POSES))


@pytest.mark.parametrize("start", [None, "fork", "spawn"])
def test_a_stream_of_renders(walker, start):
    stream = datasets.torch_render_stream(walker, draw, batch_size=3, batches=7, truth=["met"])
    assert len(stream) == 7
    loader = DataLoader(
        stream, batch_size=None, generator=torch.Generator().manual_seed(2), **worker_options(start)
    )
    batches = list(loader)
    assert len(batches) == 7
    found = together(batches)
    assert len(np.unique(found["place"], axis=0)) == 21
    np.testing.assert_array_equal(
        found["place"], found["world_from_head"][:, :3, 3].astype(np.float32)
    )
    expected = walker.render(found["world_from_head"])
    np.testing.assert_array_equal(found["response"], expected)
    assert found["met"].shape == (21, 30)
    if start is not None:
        again = together(list(DataLoader(
            stream, batch_size=None, generator=torch.Generator().manual_seed(2),
            **worker_options(start),
        )))  # fmt: skip
        np.testing.assert_array_equal(again["place"], found["place"])


def test_pinned_memory(views, walker):
    """What goes to a card without a copy in between."""
    if not torch.cuda.is_available():
        pytest.skip("needs a graphics card that PyTorch knows")
    streams = [
        datasets.torch_stream(views, 5),
        datasets.torch_render_stream(walker, draw, batch_size=3, batches=2),
    ]
    loaders = [DataLoader(one, batch_size=None, pin_memory=True, num_workers=1) for one in streams]
    for data in (datasets.torch_dataset(views), datasets.torch_renders(walker, POSES)):
        loaders.append(DataLoader(data, batch_size=4, pin_memory=True))
    for loader in loaders:
        for batch in loader:
            assert all(values.is_pinned() for values in batch.values())
            on_card = batch["response"].to("cuda", non_blocking=True)
            assert (on_card.cpu() == batch["response"]).all()


def test_a_network_learns_where_it_is(walker):
    """From world to gradient: a linear layer finds the height of its head from what is rendered."""
    torch.manual_seed(0)
    loader = DataLoader(
        datasets.torch_render_stream(walker, draw, batch_size=64, batches=60), batch_size=None
    )
    layer = torch.nn.Linear(30 * 3, 1)
    adam = torch.optim.Adam(layer.parameters(), 0.02)
    losses = []
    for batch in loader:
        loss = (layer(batch["response"].flatten(1)) - batch["place"][:, 1:2]).square().mean()
        adam.zero_grad()
        loss.backward()
        adam.step()
        losses.append(loss.item())
    # A guess of the mean has the variance of heights, 1/3.
    assert np.mean(losses[-10:]) < 0.15
    assert np.mean(losses[:3]) > 0.25


def test_tensors_go_in_as_they_lie(walker):
    """Whatever takes an array takes tensors; poses of double precision and `out` are not copied."""
    tensor = torch.from_numpy(POSES.copy())
    expected = walker.render(POSES)
    np.testing.assert_array_equal(walker.render(tensor), expected)
    single = walker.render(tensor.float())
    np.testing.assert_array_equal(single, walker.render(POSES.astype(np.float32)))
    turned = tensor.mT.contiguous().mT  # lies the other way round
    np.testing.assert_array_equal(walker.render(turned), expected)
    out = torch.full((17, 30, 3), -1.0)
    back = walker.render(tensor, out=out)
    assert back.ctypes.data == out.data_ptr()
    np.testing.assert_array_equal(out.numpy(), expected)
    seen = torch.from_dlpack(walker.render(tensor))
    assert seen.dtype == torch.float32
    data = datasets.torch_renders(walker, tensor)
    np.testing.assert_array_equal(data[3]["response"].numpy(), expected[3])
    sensor = omma.photoreceptors.EventSensor(0.1, dark=0.1)
    times = torch.arange(17, dtype=torch.float64)
    assert (sensor.run(seen, times) == sensor.run(expected, times.numpy())).all()


def test_tensors_that_do_not_do(walker):
    needs_gradient = torch.eye(4, dtype=torch.float64, requires_grad=True)
    with pytest.raises(omma.Error, match="poses: expected an array that DLPack can hand over"):
        walker.render(needs_gradient)
    with pytest.raises(TypeError, match="out: expected a float32 array"):
        walker.render(np.eye(4), out=torch.zeros((1, 30, 3), dtype=torch.float64))
    with pytest.raises(omma.Error, match="poses: expected"):
        datasets.torch_renders(walker, torch.zeros(3))


BAD = [
    (lambda w: datasets.torch_renders(w, POSES, truth=["flow"]), omma.Error, "truth: expected one"),
    (lambda w: datasets.torch_renders(w, POSES, truth="met"), TypeError, "truth: expected a list"),
    (lambda w: datasets.torch_renders(
        w.with_eye(w.eye, impulse_response=omma.photoreceptors.ImpulseResponse.box(0.01)), POSES),
     omma.Error, "renderer: expected frames that do not last"),
    (lambda w: datasets.torch_renders(
        w.with_eye(w.eye.replace(receptor_types=None, receptors=None)), POSES, receptors=True),
     omma.Error, "receptors: the eye has none"),
    (lambda w: datasets.torch_renders(w, POSES, truth=["met"], receptors=True), omma.Error,
     "truth: not together with receptors"),
    (lambda w: datasets.torch_renders(w, POSES, labels={"a": [1, 2]}), omma.Error,
     "labels.*: expected one for each of 17 poses"),
    (lambda w: datasets.torch_renders(w, POSES, labels={"response": POSES}), omma.Error,
     "labels: expected names other than response"),
    (lambda w: datasets.torch_render_stream(w, draw, batch_size=0), omma.Error, "batch_size: exp"),
    (lambda w: datasets.torch_render_stream(w, 3), TypeError, "draw: expected a function"),
    (lambda w: next(iter(datasets.torch_render_stream(w, lambda rng, count: POSES))), omma.Error,
     "draw: expected 64 poses.* found 17 poses"),
    (lambda w: next(iter(datasets.torch_render_stream(w, lambda rng, count: 3))), omma.Error,
     "draw: poses: expected"),
    (lambda w: datasets.torch_renders(3, POSES), TypeError, r"renderer: expected omma\.Renderer"),
    (lambda w: datasets.torch_stream(w), TypeError, r"views: expected omma\.datasets\.Views"),
]  # fmt: skip


@pytest.mark.parametrize(("call", "kind", "message"), BAD)
def test_bad_input(walker, call, kind, message):
    with pytest.raises(kind, match=message):
        call(walker)


def test_without_pytorch(walker, views, monkeypatch):
    for name in list(sys.modules):
        if name == "torch" or name.startswith("omma.datasets.torch_"):
            monkeypatch.setitem(sys.modules, name, None)
    for call in (
        lambda: datasets.torch_dataset(views),
        lambda: datasets.torch_stream(views),
        lambda: datasets.torch_renders(walker, POSES),
        lambda: datasets.torch_render_stream(walker, draw),
    ):
        with pytest.raises(omma.Error, match=r"pip install 'omma\[torch\]'"):
            call()
