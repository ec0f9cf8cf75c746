"""What of responses a figure shows: one channel by a colour scale, or two or three as colours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from omma import _core
from omma._core import Error, Eye
from omma.base.arguments import array_of
from omma.eye.neighbours import Floats, Ints
from omma.receptors.sensitivity import ommatidium_of_receptor, spectral_sensitivity

#: A band by its number or a receptor by its name.
Channel = int | str

# What the channels of a picture in colours are shown as, from the first on.
SHOWN_AS = {1: ("",), 2: ("yellow", "blue"), 3: ("red", "green", "blue")}
_COLOURS = {2: ((1, 1, 0), (0, 0, 1)), 3: ((1, 0, 0), (0, 1, 0), (0, 0, 1))}
_WAVELENGTHS_NM = np.arange(300.0, 751.0)


@dataclass(frozen=True)
class Shown:
    """values: (P, N, K) of P poses, N ommatidia and K (1 to 3) channels. names: of the channels."""

    values: Floats
    names: tuple[str, ...]


def bands_shown(eye: Eye, responses: Any, channels: Sequence[Channel] | None, name: str) -> Shown:
    """Of responses (N, C) or (P, N, C) the bands to show; all three of RGB where none is chosen."""
    array = array_of(responses, name)
    array = array[None] if array.ndim == 2 else array
    if array.ndim != 3 or array.shape[1] != len(eye) or 0 in array.shape:
        raise Error(
            f"{name}: expected shape ({len(eye)}, bands) or (poses, {len(eye)}, bands), found "
            f"{np.shape(responses)}"
        )
    bands = array.shape[2]
    if channels is None:
        if bands == _core.rgb_bands:
            return Shown(array, SHOWN_AS[3])
        if bands > 1:
            raise Error(f"channels: expected one to three of the {bands} bands, found none")
        channels = (0,)
    chosen = [each for each in channels if isinstance(each, int) and 0 <= each < bands]
    for each in channels:
        if each not in chosen:
            raise Error(f"channels: expected bands from 0 to {bands - 1}, found {each!r}")
    return Shown(array[..., chosen], tuple(f"band {each}" for each in chosen))


def receptors_shown(
    eye: Eye, responses: Any, channels: Sequence[Channel] | None, name: str
) -> Shown:
    """Of receptors' responses (R,) or (P, R) one to three kinds, as they are in each ommatidium.

    A kind is a peak wavelength, or one of the names in ``channels``. Several of a kind behind a
    lens count with their mean; an ommatidium without one shows that of the nearest axis of its eye
    which has it.
    """
    array = array_of(responses, name)
    array = array[None] if array.ndim == 1 else array
    count = len(eye.receptor_type)
    if count == 0:
        raise Error("receptors: the eye has none")
    if array.ndim != 2 or array.shape[1] != count or len(array) == 0:
        raise Error(
            f"{name}: expected shape ({count},) or (poses, {count}), one for each receptor, found "
            f"{np.shape(responses)}"
        )
    kinds = _kinds(eye) if channels is None else _named(eye, channels)
    if len(kinds) > 3:
        found = ", ".join(sorted({each.name for each in eye.receptor_types}))
        raise Error(f"channels: expected one to three of the receptors {found}, found none")
    values = np.stack([_of_kind(eye, array, types) for _, types in kinds], axis=2)
    return Shown(values, tuple(label for label, _ in kinds))


def as_colours(values: Floats, full_scale: float, gamma: float) -> Floats:
    """Display colours (..., 3), 0 to 1, of two or three channels (..., K)."""
    mixed = np.clip(values / full_scale, 0, 1) @ np.array(_COLOURS[values.shape[-1]], float)
    return np.asarray(np.clip(mixed, 0, 1) ** (1 / gamma))


def _kinds(eye: Eye) -> list[tuple[str, list[int]]]:
    """Receptor types by peak wavelength, the longest first, with what a legend calls them."""
    peaks: dict[int, list[int]] = {}
    for which in np.unique(eye.receptor_type).tolist():
        peaks.setdefault(_peak_nm(eye, which), []).append(which)
    kinds = []
    for peak in sorted(peaks, reverse=True):
        names = list(dict.fromkeys(eye.receptor_types[which].name for which in peaks[peak]))
        text = ", ".join(names) if len(names) <= 2 else f"{names[0]} to {names[-1]}"
        kinds.append((f"{text} ({peak} nm)", peaks[peak]))
    return kinds


def _named(eye: Eye, channels: Sequence[Channel]) -> list[tuple[str, list[int]]]:
    present = set(np.unique(eye.receptor_type).tolist())
    known = [(k, t.name) for k, t in enumerate(eye.receptor_types) if k in present]
    kinds = []
    for each in channels:
        types = [k for k, name in known if name == each]
        if not types:
            names = ", ".join(dict.fromkeys(name for _, name in known))
            raise Error(f"channels: expected receptors of this eye ({names}), found {each!r}")
        kinds.append((f"{each} ({_peak_nm(eye, types[0])} nm)", types))
    return kinds


def _peak_nm(eye: Eye, which: int) -> int:
    receptor = eye.receptor_types[which]
    if receptor.peak_wavelength_nm:
        return round(receptor.peak_wavelength_nm)
    sensitivity = np.asarray(spectral_sensitivity(receptor, _WAVELENGTHS_NM))
    return round(float(_WAVELENGTHS_NM[sensitivity.argmax()]))


def _of_kind(eye: Eye, responses: Floats, types: list[int]) -> Floats:
    """The mean response (P, N) of the receptors of these types in each ommatidium."""
    chosen = np.isin(eye.receptor_type, types)
    behind: Ints = np.asarray(ommatidium_of_receptor(eye), dtype=np.int64)[chosen]
    number = np.bincount(behind, minlength=len(eye))
    total = np.stack([np.bincount(behind, pose[chosen], len(eye)) for pose in responses])
    source = _nearest_with(eye, number > 0)
    return np.asarray(total[:, source] / number[source])


def _nearest_with(eye: Eye, has: np.ndarray[Any, np.dtype[np.bool_]]) -> Ints:
    """Of each ommatidium itself where it ``has`` something, else the nearest of its eye that has;
    of an eye where none has, the nearest of the head."""
    from scipy.spatial import cKDTree

    found = np.arange(len(eye))
    for which in np.unique(eye.eye_id[~has]).tolist():
        mine = eye.eye_id == which
        there = np.flatnonzero(mine & has)
        there = there if len(there) else np.flatnonzero(has)
        without = np.flatnonzero(mine & ~has)
        found[without] = there[cKDTree(eye.axis[there]).query(eye.axis[without])[1]]
    return found
