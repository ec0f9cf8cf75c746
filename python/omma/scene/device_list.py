"""What there is to trace rays with: the processor, and graphics cards where there are some."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from pathlib import Path

from omma import _core
from omma.base.arguments import whole
from omma.base.card_compiler import find_nvrtc
from omma.base.directories import cache_folder
from omma.base.progress import Progress, without_share
from omma.base.warn import warn_caller

# Kernels that a packager has compiled (scripts/compile_kernels); mostly it is not there.
_PACKAGED = Path(__file__).parents[1] / "kernels"


@dataclass(frozen=True)
class Device:
    """Something that rays can be traced with.

    Attributes:
        name: what it is called, "" where nothing is known of it.
        backends: what `omma.World` takes for ``backend`` to use it.
        why_not: why it cannot be used, "" where it can.
    """

    name: str
    backends: tuple[str, ...]
    why_not: str = ""


def devices() -> tuple[Device, ...]:
    """The processor, then each graphics card of the driver, or why there is none.

    Compiles nothing. A world takes the first card, or others by their ordinals,
    ``omma.World(scene, devices=[0, 1])``.
    """
    processors = tuple(name for name in _core.backends() if name != "cuda")
    return (
        Device(f"{os.cpu_count()} threads", processors),
        *(Device(name, ("cuda",), why_not) for name, _, why_not in _find_cards()),
    )


def _find_cards() -> list[tuple[str, str, str]]:
    """Of each card the name, its driver's CUDA and why it cannot be used; tells the engine of
    NVRTC."""
    kernels = str(cache_folder("kernels"))
    _core.use_card_libraries("", kernels, str(_PACKAGED))
    states = _core.card_states()
    drivers = [driver for _, driver, _ in states if driver]
    if not drivers:
        return states
    # Kernels that a newer CUDA has compiled are nothing to an older driver.
    newest = int(drivers[0].split(".")[0])
    _core.use_card_libraries(find_nvrtc(newest), kernels, str(_PACKAGED))
    return _core.card_states()


# Why cards were left alone, by their names; "" of those that may be taken. Of this process.
_left_alone: dict[str, str] = {}


def _takes_card(name: str, why_not: str, progress: Progress | None) -> bool:
    """Whether that card is taken where nobody says what traces rays: it can be used, and sees a
    small scene as the processor does. A warning says why not, once; none where there is no card."""
    if name and name not in _left_alone:
        # Needs much that is not needed without a card.
        from omma.scene.card_check import trouble_with_card

        _left_alone[name] = why_not or trouble_with_card(progress)
        if _left_alone[name]:
            warn_caller(
                f"{name} is left alone, the processor traces the rays: {_left_alone[name]}",
                UserWarning,
            )
    return _left_alone.get(name) == ""


def ordinals(devices: Iterable[int], name: str = "devices") -> tuple[int, ...]:
    """Ordinals of cards as they are given, as whole numbers; ``name`` is what messages call them.

    Raises:
        omma.Error: one is below 0.
        TypeError: they are something else.
    """
    if isinstance(devices, (str, bytes)) or not isinstance(devices, Iterable):
        raise TypeError(
            f"{name}: expected ordinals of cards such as [0, 1], found {type(devices).__name__} "
            f"{devices!r:.40}"
        )
    return tuple(whole(one, name, 0, 1 << 16) for one in devices)


def prepare_backend(
    backend: str, devices: Collection[int], progress: Progress | None = None
) -> str:
    """The backend of a world, made ready: cards' kernels are compiled where there are none.

    Args:
        backend: "" takes cards where some are named or the first one can be taken, else the fastest
            of the processor's.
        devices: ordinals of cards; none for the first one.
        progress: told of nothing finished meanwhile; what it raises ends the work.

    Raises:
        omma.Error: there is no such card that can be used, and it is asked for; why.

    Warns:
        UserWarning: the kernels cannot be kept, so that each process compiles them; or there is a
            card that is not taken; why.
    """
    if backend not in ("", "cuda"):
        return backend
    name, _, why_not = _find_cards()[0]
    if backend == "" and not devices and not _takes_card(name, why_not, progress):
        return ""
    note = _core.card_note(list(devices), without_share(progress))
    if note:
        warn_caller(f"the card's kernels are compiled by each process: {note}", UserWarning)
    return "cuda"
