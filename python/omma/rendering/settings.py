"""How a renderer is asked for rays: the arguments of `omma.Renderer`, checked, for the engine."""

from __future__ import annotations

from typing import Any, Literal

from omma import _core
from omma._core import Error, RenderSettings
from omma.base.arguments import positive, whole

Samples = int | Literal["auto"]

MAX_SAMPLES = 4096


def least_samples(error: float, most: int) -> int:
    """Rays that an ommatidium gets at least where nobody says: 8, and from an error of
    0.00625 down the power of two below 0.1 / error, up to 64.

    What few rays and those of all neighbours miss nothing tells of, and it is the more errors the
    smaller these are. In the arena 32 instead of 8 rays take the worst of 50,000 from 28 times an
    error of 0.003 to 4 times, for 7 % more rays (docs/error-target.md).
    """
    least = 8
    while least < 64 and 2 * least * error <= 0.1 and 2 * least <= most:
        least *= 2
    return least


def render_settings(
    *,
    samples: Samples,
    error: float | None,
    min_samples: int | None,
    max_samples: int | None,
    **others: Any,
) -> RenderSettings:
    """Settings from the arguments of `omma.Renderer`; omma.Error or TypeError names one."""
    options = {name: others[name] for name in ("kernel", "footprints", "noise")}
    options["points"] = others["sampling"]
    options["seed"] = whole(others["seed"], "seed", 0, (1 << 64) - 1)
    options["threads"] = whole(others["threads"], "threads", 0, 1 << 16)
    chosen: tuple[str, int] | tuple[str, float, int, int]
    if isinstance(samples, str):
        if samples != "auto":
            raise Error(f"samples: expected a whole number or 'auto', found {samples!r:.40}")
        if error is None:
            raise Error("error: expected the standard error that samples='auto' is to reach")
        target = positive(error, "error")
        ceiling = whole(_or(max_samples, MAX_SAMPLES), "max_samples", 4, 1 << 20)
        least = whole(_or(min_samples, least_samples(target, ceiling)), "min_samples", 4, 1 << 20)
        if least & (least - 1):
            raise Error(f"min_samples: expected a power of two, found {least}")
        most = whole(_or(max_samples, max(MAX_SAMPLES, least)), "max_samples", least, 1 << 20)
        if others["share_rays"]:
            raise Error("share_rays: not where rays go to reach an error")
        chosen = ("to_error", target, least, most)
    else:
        given = {"error": error, "min_samples": min_samples, "max_samples": max_samples}
        for name, value in given.items():
            if value is not None:
                raise Error(f"{name}: is for samples='auto', found samples={samples!r:.40}")
        kind = "shared" if others["share_rays"] else "fixed"
        chosen = (kind, whole(samples, "samples", 1, 1 << 20))
    return _core.RenderSettings(sampling=chosen, **options)


def check_picture_settings(
    samples: int,
    seed: int,
    threads: int,
    kernel: str = "own",
    sampling: str = "low_discrepancy",
) -> None:
    """Raises what a renderer with these settings would, before a world is made for them."""
    render_settings(
        samples=samples,
        error=None,
        min_samples=None,
        max_samples=None,
        seed=seed,
        kernel=kernel,
        sampling=sampling,
        threads=threads,
        footprints=True,
        share_rays=False,
        noise="frozen",
    )


def fixed_samples(samples: Samples, what: str) -> int:
    """``samples`` where it is a number; omma.Error says that ``what`` needs one."""
    if isinstance(samples, str):
        raise Error(f"samples: expected a number for {what}, found {samples!r}")
    return samples


def frame_number(first_pose: int | None) -> int | None:
    """``first_pose`` of a render, checked."""
    return None if first_pose is None else whole(first_pose, "first_pose", 0, (1 << 63) - 1)


def _or(value: int | None, default: int) -> int:
    return default if value is None else value
