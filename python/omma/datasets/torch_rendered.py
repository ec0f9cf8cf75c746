"""Views that are rendered when they are asked for, as data sets of PyTorch. This module needs
PyTorch; `for_torch` imports it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch.utils.data import Dataset, IterableDataset

from omma._core import Error
from omma.base.arguments import array_of
from omma.base.poses import Matrices, as_poses
from omma.base.rows import row_of, rows_of
from omma.datasets.torch_views import shared_work, tensors
from omma.rendering.renderer import Renderer

Arrays = dict[str, NDArray[Any]]
Tensors = dict[str, torch.Tensor]


class _Seen:
    """What a renderer gives at poses, by name."""

    def __init__(self, renderer: Renderer, truth: tuple[str, ...], receptors: bool) -> None:
        self._renderer, self._truth, self._receptors = renderer, truth, receptors

    def at(self, poses: Matrices, first_pose: int) -> Arrays:
        renderer = self._renderer
        found: Arrays = {"world_from_head": poses}
        if self._receptors:
            found["response"] = renderer.render_receptors(poses, first_pose=first_pose)
        elif self._truth:
            truth = renderer.ground_truth(poses, first_pose=first_pose)
            found["response"] = truth.responses
            found |= {name: getattr(truth, name) for name in self._truth}
        else:
            found["response"] = renderer.render(poses, first_pose=first_pose)
        return found


class Renders(Dataset):  # type: ignore[misc,unused-ignore]
    """A map-style data set: a sample is what is seen at one pose."""

    def __init__(
        self,
        renderer: Renderer,
        poses: Matrices,
        truth: tuple[str, ...],
        receptors: bool,
        labels: Arrays,
    ) -> None:
        self._seen = _Seen(renderer, truth, receptors)
        self._poses, self._labels = poses, labels
        self._is_noise_new = renderer.settings.noise == "new_every_frame"

    def __len__(self) -> int:
        return len(self._poses)

    def __getitem__(self, index: int) -> Tensors:
        return self.__getitems__([row_of(index, "index", len(self))])[0]

    def __getitems__(self, indices: list[int]) -> list[Tensors]:
        """What loaders ask for a batch: rendered in one call, but where noise goes by the number of
        a pose."""
        which = rows_of(indices, "indices", len(self))
        poses = np.ascontiguousarray(self._poses[which])
        if self._is_noise_new:
            each = [self._seen.at(pose[None], int(k)) for pose, k in zip(poses, which)]
            found = {name: np.concatenate([one[name] for one in each]) for name in each[0]}
        else:
            found = self._seen.at(poses, 0)
        found |= {name: values[which] for name, values in self._labels.items()}
        batch = tensors(found)
        return [{name: values[k] for name, values in batch.items()} for k in range(len(which))]


class RenderStream(IterableDataset):  # type: ignore[misc,unused-ignore]
    """Batches of what is seen at poses that are drawn."""

    def __init__(
        self,
        renderer: Renderer,
        draw: Callable[[np.random.Generator, int], Any],
        sizes: tuple[int, int],
        truth: tuple[str, ...],
        receptors: bool,
    ) -> None:
        self._seen = _Seen(renderer, truth, receptors)
        self._draw, (self._size, self._batches) = draw, sizes
        self._taken = {"response", "world_from_head", *truth}
        self._times = 0

    def __iter__(self) -> Iterator[Tensors]:
        worker, workers, rng = shared_work(self._times)
        self._times += 1
        seed = int(rng.integers(1 << 62))
        for batch in range(worker, self._batches, workers):
            # Each batch has a generator of its own, so that workers only say who draws it.
            poses, labels = self._drawn(np.random.default_rng((seed, batch)))
            yield tensors(self._seen.at(poses, batch * self._size) | labels)

    def __len__(self) -> int:
        return self._batches

    def _drawn(self, rng: np.random.Generator) -> tuple[Matrices, Arrays]:
        drawn = self._draw(rng, self._size)
        labels: Arrays = {}
        if isinstance(drawn, tuple) and len(drawn) == 2 and isinstance(drawn[1], dict):
            drawn, given = drawn
            labels = {
                name: array_of(values, f"draw: {name!r:.40}", dtype=None)
                for name, values in given.items()
            }
        try:
            poses = as_poses(drawn)
        except Error as error:
            raise Error(f"draw: {error}") from None
        wrong = [name for name, values in labels.items() if values.shape[:1] != (self._size,)]
        if len(poses) != self._size or wrong or self._taken & labels.keys():
            raise Error(
                f"draw: expected {self._size} poses, and so many rows of labels whose names are "
                f"not {', '.join(sorted(self._taken))}; found {len(poses)} poses"
                + "".join(f", {name} {values.shape}" for name, values in labels.items())
            )
        return poses, labels
