"""Views as a PyTorch data set. This module needs PyTorch; `torch_dataset` imports it."""

from __future__ import annotations

from typing import Any, Protocol

from numpy.typing import NDArray
from torch.utils.data import Dataset

Batch = dict[str, NDArray[Any]]


class Views(Protocol):
    """What a data set needs of `omma.datasets.Views`, whose module imports this one."""

    def __len__(self) -> int: ...
    def __getitem__(self, index: int | list[int]) -> Batch: ...


class TorchViews(Dataset):  # type: ignore[misc,unused-ignore]
    """A map-style data set; a sample is a dictionary of arrays, which loaders make tensors of."""

    def __init__(self, views: Views) -> None:
        self.views = views

    def __len__(self) -> int:
        return len(self.views)

    def __getitem__(self, index: int) -> Batch:
        return self.views[index]

    def __getitems__(self, indices: list[int]) -> list[Batch]:
        """What loaders ask for a batch."""
        found = self.views[indices]
        return [{name: values[k] for name, values in found.items()} for k in range(len(indices))]
