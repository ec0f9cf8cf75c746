"""The engine's settings from Python: read through the engine's own list of options and back."""

from __future__ import annotations

from typing import Any

import pytest

import omma
from omma import _core

FIXED = ("fixed", 16)


@pytest.mark.parametrize(
    "sampling", [("fixed", 7), ("to_error", 0.02, 4, 64, 0.05), ("shared", 3)], ids=lambda s: s[0]
)
def test_sampling_round_trip(sampling: Any) -> None:
    assert _core.RenderSettings(sampling=sampling).sampling == sampling


def test_options_round_trip() -> None:
    defaults = {
        "seed": 0,
        "kernel": "own",
        "points": "low_discrepancy",
        "threads": 0,
        "footprints": True,
        "noise": "frozen",
    }
    assert _core.RenderSettings(sampling=FIXED).options == defaults
    given = {
        "seed": 2**64 - 1,
        "kernel": "pillbox",
        "points": "random",
        "threads": 3,
        "footprints": False,
        "noise": "new_every_frame",
    }
    assert _core.RenderSettings(sampling=FIXED, **given).options == given
    for kernel in ("own", "gaussian", "compoundray"):
        assert _core.RenderSettings(sampling=FIXED, kernel=kernel).options["kernel"] == kernel


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ({"samples": 4}, "options: expected seed, kernel, .*, noise, found samples"),
        ({"seed": -1}, "seed: expected a number in its range, found -1"),
        ({"threads": "two"}, "threads: expected a number in its range, found 'two'"),
        ({"footprints": 1}, "footprints: expected True or False, found 1"),
        ({"points": "sobol"}, "points: expected one of low_discrepancy, random, found 'sobol'"),
        ({"kernel": None}, "kernel: expected one of own, gaussian, pillbox, .*, found None"),
    ],
)
def test_wrong_options(option: dict[str, Any], message: str) -> None:
    with pytest.raises(omma.Error, match=message):
        _core.RenderSettings(sampling=FIXED, **option)


@pytest.mark.parametrize(
    "sampling", [(), ("fixed",), ("fixed", 1, 2), ("fixed", "1"), ("auto", 1), (1, 2)]
)
def test_wrong_sampling(sampling: Any) -> None:
    with pytest.raises(omma.Error, match=r"sampling: expected \('fixed', samples\)"):
        _core.RenderSettings(sampling=sampling)
