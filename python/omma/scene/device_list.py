"""What there is to trace rays with: the processor, and a graphics card where there is one."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from omma import _core
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
    """The processor, then the graphics card, or why there is none that can be used.

    Compiles nothing.
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
    _core.use_card_libraries("", kernels, str(_PACKAGED))
    name, driver, why_not = _core.card_state()
    if not driver:
        return name, driver, why_not
    # Kernels that a newer CUDA has compiled are nothing to an older driver.
    _core.use_card_libraries(find_nvrtc(int(driver.split(".")[0])), kernels, str(_PACKAGED))
    return _core.card_state()


# Why cards were left alone, by their names; "" of those that may be taken. Of this process.
_left_alone: dict[str, str] = {}


def _takes_card(name: str, why_not: str, progress: Progress | None) -> bool:
    """Whether that card is taken where nobody says what traces rays: it can be used, and sees a
    small scene as the processor does. A warning says why not, once."""
    if not name:
        return False
    if name not in _left_alone:
        # Needs much that is not needed without a card.
        from omma.scene.card_check import trouble_with_card

        _left_alone[name] = why_not or trouble_with_card(progress)
        if _left_alone[name]:
            warn_caller(
                f"{name} is left alone, the processor traces the rays: {_left_alone[name]}",
                UserWarning,
            )
    return not _left_alone[name]


def prepare_backend(backend: str, progress: Progress | None = None) -> str:
    """The backend of a world, made ready: a card's kernels are compiled where there are none.

    Args:
        backend: "" takes a card where there is one, else the fastest of the processor's.
        progress: told of nothing finished meanwhile; what it raises ends the work.

    Raises:
        omma.Error: there is no card that can be used, and one is asked for; why.

    Warns:
        UserWarning: the kernels cannot be kept, so that each process compiles them; or there is a
            card that is not taken; why.
    """
    if backend not in ("", "cuda"):
        return backend
    name, _, why_not = _find_card()
    if backend == "" and not _takes_card(name, why_not, progress):
        return ""
    note = _core.card_note(without_share(progress))
    if note:
        warn_caller(f"the card's kernels are compiled by each process: {note}", UserWarning)
    return "cuda"
