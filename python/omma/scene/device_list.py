"""What there is to trace rays with: the processor, and a graphics card where there is one."""

from __future__ import annotations

import os
from dataclasses import dataclass

from omma import _core
from omma.base.card_compiler import find_nvrtc
from omma.base.directories import cache_folder
from omma.base.warn import warn_caller


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
    """The processor, then the graphics card, or why there is none that can be used.

    Compiles nothing. A card is used by its backend's name alone, ``omma.World(scene,
    backend="cuda")``.
    """
    processors = tuple(name for name in _core.backends() if name != "cuda")
    name, _, why_not = _find_card()
    return (
        Device(f"{os.cpu_count()} threads", processors),
        Device(name, ("cuda",), why_not),
    )


def _find_card() -> tuple[str, str, str]:
    """The card's name, its driver's CUDA and why it cannot be used; tells the engine of NVRTC."""
    kernels = str(cache_folder("kernels"))
    _core.use_card_libraries("", kernels)
    name, driver, why_not = _core.card_state()
    if not driver:
        return name, driver, why_not
    # Kernels that a newer CUDA has compiled are nothing to an older driver.
    _core.use_card_libraries(find_nvrtc(int(driver.split(".")[0])), kernels)
    return _core.card_state()


def prepare_backend(backend: str) -> None:
    """Make a backend ready for a world: a card's kernels are compiled where they are not kept.

    Raises:
        omma.Error: there is no card that can be used; why.

    Warns:
        UserWarning: the kernels cannot be kept, so that each process compiles them.
    """
    if backend != "cuda":
        return
    _find_card()
    note = _core.card_note()
    if note:
        warn_caller(f"the card's kernels are compiled by each process: {note}", UserWarning)
