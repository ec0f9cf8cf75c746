"""Functions that are told of the progress of long work."""

from __future__ import annotations

from collections.abc import Callable, Sequence

Progress = Callable[[float], object]
"""Called with the finished share, 0 to 1; what it raises ends the work."""

Stage = Callable[[str, float | None], object]
"""Called with what is being done and its finished share, None where that is not known."""


def without_share(progress: Progress | None) -> Progress | None:
    """A progress function for work before the first share: ``progress`` is told of 0 alone."""
    return share_of(progress, 0.0, 0.0)


def share_of(progress: Progress | None, first: float, last: float) -> Progress | None:
    """A progress function for one stage, which takes ``progress`` from ``first`` to ``last``."""
    if progress is None:
        return None
    whole_work = progress
    return lambda done: whole_work(first + (last - first) * done)


def ends_of_steps(work: Sequence[float]) -> list[float]:
    """The finished share before each of several steps (K,) that take so much work, and after the
    last: K + 1 numbers from 0 to 1."""
    whole_work = sum(work)
    return [sum(work[:k]) / whole_work for k in range(len(work))] + [1.0]
