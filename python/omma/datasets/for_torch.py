"""Data sets of PyTorch: of views that are in a store, and of views that are rendered when they are
asked for; as a map from index to view, and as a stream of batches.

Whoever calls these needs PyTorch, which nothing else here does.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of, checked, one_of, whole
from omma.base.optional import needs
from omma.base.poses import as_poses
from omma.datasets.reading import Views
from omma.rendering.renderer import Renderer

_MOST = 1 << 40
# Of ground truth what a pose alone decides.
TRUTH = ("met", "distance_m", "nearest_m", "inverse_distance_per_m", "position_m", "normal")


@checked
def torch_dataset(views: Views) -> Any:
    """Views as a `torch.utils.data.Dataset`: a sample is a dictionary of arrays, one view, which
    loaders make tensors of; the views of a batch are read together.

    Workers may be made by ``fork``, ``spawn`` or ``forkserver``; each opens the store for itself.

    Raises:
        omma.Error: no PyTorch (``omma[torch]``).
    """
    return _classes("torch_views").TorchViews(views)


@checked
def torch_stream(views: Views, batch_size: int = 64, *, shuffle: bool = True) -> Any:
    """Views as a `torch.utils.data.IterableDataset` of batches, which are read whole chunks at a
    time: many times faster from disks than views one by one.

    Chunks are shuffled, and the views of eight of them at a time; each view comes once. Several
    workers share the batches, whose number is its length. The order follows from the loader's
    generator, as that of ``shuffle=True`` in loaders of other data sets does, and is another one in
    each epoch. For ``batch_size=None`` of a `torch.utils.data.DataLoader`, which with a number
    would stack whole batches, and fail at the last one, which may be smaller::

        loader = torch.utils.data.DataLoader(
            omma.datasets.torch_stream(views, 256), batch_size=None, num_workers=2
        )

    Args:
        views: of `open_views`.
        batch_size: views in a batch; the last may have fewer.
        shuffle: False: as they come in the store, by worker.

    Returns:
        Batches are dictionaries of tensors (batch, ...), by the names of the variables.

    Raises:
        omma.Error: an argument is out of its range; no PyTorch (``omma[torch]``).
    """
    size = whole(batch_size, "batch_size", 1, _MOST)
    return _classes("torch_views").ViewStream(views, size, shuffle)


@checked
def torch_renders(
    renderer: Renderer,
    poses: Any,
    *,
    truth: Sequence[str] = (),
    receptors: bool = False,
    labels: Mapping[str, Any] | None = None,
) -> Any:
    """What an eye sees from poses as a `torch.utils.data.Dataset`: rendered when it is asked for, a
    batch in one call.

    A sample is a dictionary of tensors: "response" (N, B) or, of receptors, (R,), float32;
    "world_from_head" (4, 4); and what ``truth`` and ``labels`` name. Workers made by ``fork`` use
    the renderer that is there, each on one thread; those by ``spawn`` or ``forkserver`` are sent
    the scene and build it anew, once: keep them (``persistent_workers=True``), and make the
    renderer with ``threads=1``. All give the same bits.

    Args:
        renderer: who sees.
        poses: (P, 4, 4), ``world_from_head``, m, or as `Renderer.render` takes them.
        truth: names of ground truth besides: "met", "distance_m", "nearest_m",
            "inverse_distance_per_m", "position_m", "normal", as of `Renderer.ground_truth`.
        receptors: responses of receptors (`Renderer.render_receptors`) instead of bands; not
            together with ``truth``.
        labels: arrays (P, ...) by name, of which each sample gets its row.

    Raises:
        omma.Error: labels of another number than poses, names that are taken or unknown; no PyTorch
            (``omma[torch]``).
    """
    matrices = as_poses(poses)
    wanted = _truth_names(truth, receptors)
    _expect_views(renderer, receptors)
    taken = {"response", "world_from_head", *wanted}
    rows: dict[str, NDArray[Any]] = {}
    if labels is not None and not isinstance(labels, Mapping):
        raise TypeError(f"labels: expected a mapping of names to arrays, found {labels!r:.40}")
    for name, values in (labels or {}).items():
        if not isinstance(name, str) or name in taken:
            raise Error(f"labels: expected names other than {', '.join(sorted(taken))}, found "
                        f"{name!r:.40}")  # fmt: skip
        rows[name] = array_of(values, f"labels[{name!r:.40}]", dtype=None)
        if rows[name].shape[:1] != (len(matrices),):
            raise Error(
                f"labels[{name!r:.40}]: expected one for each of {len(matrices)} poses, found "
                f"shape {rows[name].shape}"
            )
    return _classes("torch_rendered").Renders(renderer, matrices, wanted, receptors, rows)


@checked
def torch_render_stream(
    renderer: Renderer,
    draw: Callable[[np.random.Generator, int], ArrayLike],
    *,
    batch_size: int = 64,
    batches: int = 1000,
    truth: Sequence[str] = (),
    receptors: bool = False,
) -> Any:
    """What an eye sees from poses that are drawn at random, as a `torch.utils.data.IterableDataset`
    of batches: no view comes twice, and none is kept.

    Which poses are drawn follows from the loader's generator. For ``batch_size=None`` of a
    `torch.utils.data.DataLoader`; workers as of `torch_renders`, which share the batches.

    Args:
        renderer: who sees.
        draw: draw(rng, count) -> poses (count, 4, 4), m, of a `numpy.random.Generator`; or (poses,
            labels), labels a dictionary of arrays (count, ...) that come along.
        batch_size: views in a batch.
        batches: how many there are in an epoch.
        truth, receptors: as of `torch_renders`.

    Returns:
        Batches are dictionaries of tensors (batch, ...), as of `torch_renders`.

    Raises:
        omma.Error: an argument is out of its range; no PyTorch (``omma[torch]``).
    """
    size = whole(batch_size, "batch_size", 1, _MOST)
    number = whole(batches, "batches", 1, _MOST)
    wanted = _truth_names(truth, receptors)
    _expect_views(renderer, receptors)
    kind = _classes("torch_rendered").RenderStream
    return kind(renderer, draw, (size, number), wanted, receptors)


def _truth_names(truth: Sequence[str], receptors: bool) -> tuple[str, ...]:
    if isinstance(truth, str) or not isinstance(truth, Sequence):
        raise TypeError(f"truth: expected a list of names, found {truth!r:.60}")
    if truth and receptors:
        raise Error("truth: not together with receptors")
    return tuple(one_of(name, TRUTH, "truth") for name in truth)


def _expect_views(renderer: Renderer, receptors: bool) -> None:
    """omma.Error where there is nothing to be seen from a pose alone."""
    if renderer.settings.impulse_response is not None:
        raise Error(
            "renderer: expected frames that do not last, as views from single poses have no times; "
            "sequences are rendered by Renderer.dataset, which has time_s"
        )
    if receptors and len(renderer.eye.receptor_type) == 0:
        raise Error("receptors: the eye has none; omma.receptors.assign_receptors gives it some")


def _classes(name: str) -> Any:
    """The module with the classes, which imports PyTorch."""
    needs("torch", "torch", "data sets of PyTorch need it")
    import importlib

    return importlib.import_module(f"omma.datasets.{name}")
