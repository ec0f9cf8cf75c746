"""States of many environments: arrays with environments along their first axis, or dictionaries
and tuples of such. Some are chosen, and put together again."""

from __future__ import annotations

from typing import Any

import numpy as np

from omma._core import Error
from omma.base.arrays import Ints


def check_states(states: Any, count: int, name: str) -> None:
    """omma.Error where they are not of so many environments; ``name`` is the function they are
    of."""
    if isinstance(states, dict):
        for one in states.values():
            check_states(one, count, name)
    elif isinstance(states, tuple):
        for one in states:
            check_states(one, count, name)
    elif not isinstance(states, np.ndarray):
        raise Error(
            f"{name}: expected states of a batched loop as arrays, or dictionaries or tuples of "
            f"them, found {type(states).__name__} {states!r:.40}"
        )
    elif states.shape[:1] != (count,):
        raise Error(
            f"{name}: expected states of {count} environments along the first axis, found shape "
            f"{states.shape}"
        )


def choose(states: Any, which: Ints) -> Any:
    """Those of some environments."""
    if isinstance(states, dict):
        return {key: choose(one, which) for key, one in states.items()}
    if isinstance(states, tuple):
        return tuple(choose(one, which) for one in states)
    return states[which]


def merge(some: Any, where: Ints, others: Any, elsewhere: Ints) -> Any:
    """Those of all environments, from two parts and where these belong."""
    same = type(some) is type(others)
    if same and isinstance(some, dict) and some.keys() == others.keys():
        return {key: merge(one, where, others[key], elsewhere) for key, one in some.items()}
    if same and isinstance(some, tuple) and len(some) == len(others):
        return tuple(merge(one, where, other, elsewhere) for one, other in zip(some, others))
    arrays = isinstance(some, np.ndarray) and isinstance(others, np.ndarray)
    if not arrays or some.shape[1:] != others.shape[1:]:
        raise Error(
            "start, motion: expected states of one structure and shape, found "
            f"{_told(others)} and {_told(some)}"
        )
    whole = np.empty((len(where) + len(elsewhere), *some.shape[1:]), np.result_type(some, others))
    whole[where], whole[elsewhere] = some, others
    return whole


def _told(states: Any) -> str:
    if isinstance(states, np.ndarray):
        return f"{states.dtype} {states.shape}"
    keys = f" of {', '.join(map(str, states))}" if isinstance(states, dict) else ""
    return f"{type(states).__name__}{keys or f' of {len(states)}'}"
