"""What of responses a figure shows: one channel by a colour scale, or two or three as colours."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from omma import _core
from omma._core import Error, Eye, ReceptorType
from omma.base.arguments import array_of
from omma.base.arrays import Floats, Ints
from omma.receptors.sensitivity import ommatidium_of_receptor, spectral_sensitivity

#: A band by its number or a receptor by its name.
Channel = int | str

# What a legend calls a kind of receptor, its types, and those that stand in where one is missing.
_Types = Sequence[ReceptorType]
_Kind = tuple[str, list[int], list[int]]

# What the channels of a picture in colours are shown as, from the first on.
SHOWN_AS = {1: ("grey",), 2: ("yellow", "blue"), 3: ("red", "green", "blue")}
_COLOURS = {
    1: ((1, 1, 1),),
    2: ((1, 1, 0), (0, 0, 1)),
    3: ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
}
# Dimensions of what is not in bands of light.
_COMPONENTS = ("direction", "axis", "instance")
_WAVELENGTHS_NM = np.arange(300.0, 751.0)
_GREY = 1e-5  # single precision, and sums of it
_POLARISED = 1.001  # a polarisation sensitivity above it tells directions apart


@dataclass(frozen=True)
class Shown:
    """values: (P, N, K) of P poses, N ommatidia and K (1 to 3) channels. names: of the channels, ""
    of one that has none. quantity: what a labelled array that is not of responses calls itself."""

    values: Floats
    names: tuple[str, ...]
    quantity: str | None = None


def bands_shown(
    eye: Eye,
    responses: Any,
    channels: Sequence[Channel] | None,
    name: str,
    centers_nm: Sequence[float] | None = None,
) -> Shown:
    """Of responses (N, C) or (P, N, C) the bands to show; all three of RGB where none is chosen.
    One channel may come as (N,) or (P, N). ``centers_nm`` name bands of light."""
    array = array_of(responses, name)
    quantity, components = _labels(responses)
    is_one = array.ndim == 1 or (
        array.ndim == 2 and (components == () or len(array) != len(eye) == array.shape[1])
    )
    array = array[..., None] if is_one else array
    array = array[None] if array.ndim == 2 else array
    if array.ndim != 3 or array.shape[1] != len(eye) or 0 in array.shape:
        raise Error(
            f"{name}: expected shape ({len(eye)}, bands) or (poses, {len(eye)}, bands), or of one "
            f"channel ({len(eye)},) or (poses, {len(eye)}), found {np.shape(responses)}"
            + (_of_stokes(name) if np.shape(responses)[-3:-1] == (len(eye), 3) else "")
        )
    bands = array.shape[2]
    if channels is None:
        if bands == _core.rgb_bands and not components:
            return Shown(array, SHOWN_AS[3], quantity)
        if bands > 1:
            raise Error(_no_channels(bands, name))
        channels = (0,)
    chosen = [each for each in channels if isinstance(each, int) and 0 <= each < bands]
    for each in channels:
        if each not in chosen:
            raise Error(f"channels: expected bands from 0 to {bands - 1}, found {each!r}")
    if is_one:
        return Shown(array, ("",), quantity)
    if centers_nm is not None and len(centers_nm) != bands:
        raise Error(f"light: expected as many bands as {name}, {bands}, found {len(centers_nm)}")
    called = components or _bands_called(responses, bands, centers_nm)
    return Shown(array[..., chosen], tuple(called[each] for each in chosen), quantity)


def _bands_called(responses: Any, bands: int, centers_nm: Sequence[float] | None) -> Sequence[str]:
    """What bands are called: by the light's, by a labelled array's own names, and three of which
    nobody says more are red, green and blue."""
    if centers_nm is not None:
        return [f"band {k}, {each:.0f} nm" for k, each in enumerate(centers_nm)]
    named = getattr(responses, "coords", {}).get("band")
    if named is not None and np.shape(named) == (bands,):
        known = [str(each) for each in np.asarray(named)]
        return [
            f"band {k}, {each}" if each.endswith(" nm") else each.replace("_", " ")
            for k, each in enumerate(known)
        ]
    if bands == _core.rgb_bands and _has_no_unit(responses):
        return SHOWN_AS[3]
    return [f"band {k}" for k in range(bands)]


def _has_no_unit(responses: Any) -> bool:
    """Whether nobody says that numbers have one, as those of a lit world do, which is never RGB."""
    return bool(getattr(responses, "attrs", {}).get("units", "1") == "1")


def _no_channels(bands: int, name: str) -> str:
    text = f"channels: expected one to three of the {bands} bands, found none"
    if bands == 2:
        text += (
            f"; as of flow to the right and up, channels=[0] draws the first, "
            f"numpy.linalg.norm({name}, axis=-1) in their place the length"
        )
    return text


def _of_stokes(name: str) -> str:
    return (
        f"; of Stokes vectors {name}[..., 0, :] is the intensity, and with i, q, u = "
        f"numpy.moveaxis({name}[..., band], -1, 0) numpy.hypot(q, u) / i the degree of "
        "polarisation, numpy.degrees(numpy.arctan2(u, q)) / 2 its angle, drawn with cyclic=180 "
        "(docs/light.md)"
    )


def _labels(responses: Any) -> tuple[str | None, Sequence[str] | None]:
    """Of a labelled array that is of something else than light, as of ground truth, what it is, and
    what its components are called: none where it has none. None: nobody says."""
    dimensions = getattr(responses, "dims", None)
    if not isinstance(dimensions, tuple) or not dimensions:
        return None, None
    last = dimensions[-1]
    if last == "ommatidium":
        components: Sequence[str] | None = ()
    elif last in _COMPONENTS and last in getattr(responses, "coords", {}):
        components = [str(each) for each in np.asarray(responses.coords[last])]
    else:
        return None, None
    quantity = getattr(responses, "attrs", {}).get("long_name")
    return (quantity if isinstance(quantity, str) else None), components


def is_grey(shown: Sequence[Shown]) -> bool:
    """Whether red, green and blue are the same throughout, as of a stimulus in black and white."""
    return all(
        each.names == SHOWN_AS[3]
        and np.allclose(each.values, each.values[..., :1], rtol=_GREY, atol=0, equal_nan=True)
        for each in shown
    )


def receptors_shown(
    eye: Eye, responses: Any, channels: Sequence[Channel] | None, name: str
) -> Shown:
    """Of receptors' responses (R,) or (P, R) one to three kinds, as they are in each ommatidium.

    A kind is a peak wavelength, or one of the names in ``channels``. Receptors of one peak with
    microvilli in several directions are a kind for each, unless there are then more than three.
    Several of a kind behind a lens count with their mean. An ommatidium without one shows its own
    receptors of that peak, or else that of the nearest axis of its eye which has it.
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
    kinds = _named(eye, channels) if channels is not None else _kinds(eye, crossed_apart=True)
    if channels is None and len(kinds) > 3:
        kinds = _kinds(eye, crossed_apart=False)
    if len(kinds) > 3:
        found = list(
            dict.fromkeys(eye.receptor_types[k].name for k in np.unique(eye.receptor_type))
        )
        raise Error(
            f"channels: expected the names of one to three kinds of receptors to draw, as "
            f"channels={found[:1]}, found none; a picture shows three at most, and this eye has "
            f"{', '.join(found)}"
        )
    values = np.stack([_of_kind(eye, array, types, like) for _, types, like in kinds], axis=2)
    return Shown(values, tuple(label for label, *_ in kinds))


def as_colours(values: Floats, full_scale: float, gamma: float) -> Floats:
    """Display colours (..., 3), 0 to 1, of two or three channels (..., K)."""
    mixed = np.clip(values / full_scale, 0, 1) @ np.array(_COLOURS[values.shape[-1]], float)
    return np.asarray(np.clip(mixed, 0, 1) ** (1 / gamma))


def _kinds(eye: Eye, crossed_apart: bool) -> list[_Kind]:
    """Receptor types by peak wavelength, the longest first, and where crossed ones are to be told
    apart by the direction of their microvilli."""
    known = eye.receptor_types
    peaks: dict[int, list[int]] = {}
    for which in np.unique(eye.receptor_type).tolist():
        peaks.setdefault(_peak_nm(known[which]), []).append(which)
    kinds: list[_Kind] = []
    for peak in sorted(peaks, reverse=True):
        types = peaks[peak]
        directions = _directions_deg(known, types)
        groups = [types]
        if crossed_apart and len(directions) > 1:
            groups = [[k for k in types if _direction_deg(known[k]) == d] for d in directions]
            # Those that tell no directions apart are in every group.
            plain = [k for k in types if _direction_deg(known[k]) is None]
            groups = [sorted([*each, *plain]) for each in groups]
        kinds += [(_label(known, each, peak, len(directions) > 1), each, types) for each in groups]
    return kinds


def _named(eye: Eye, channels: Sequence[Channel]) -> list[_Kind]:
    known = eye.receptor_types
    present = np.unique(eye.receptor_type).tolist()
    kinds: list[_Kind] = []
    for each in channels:
        types = [k for k in present if known[k].name == each]
        if not types:
            names = ", ".join(dict.fromkeys(known[k].name for k in present))
            raise Error(f"channels: expected receptors of this eye ({names}), found {each!r}")
        peak = _peak_nm(known[types[0]])
        crossed = len(_directions_deg(known, types)) > 1
        kinds.append((_label(known, types, peak, crossed), types, types))
    return kinds


def _label(known: _Types, types: Sequence[int], peak: int, crossed: bool) -> str:
    """What a legend calls receptors: names, peak, and where it matters their microvilli."""
    names = list(dict.fromkeys(known[which].name for which in types))
    text = ", ".join(names) if len(names) <= 2 else f"{names[0]} to {names[-1]}"
    if not crossed:
        return f"{text} ({peak} nm)"
    degrees = [f"{d}°" for d in _directions_deg(known, types)]
    many = f"mean of {len(degrees)} directions of microvilli"
    several = f"mean of microvilli at {', '.join(degrees)}" if len(degrees) <= 3 else many
    if len(degrees) == 1:
        # Else ommatidia whose up vectors lie in a fan would seem to look for one direction.
        several = f"microvilli {degrees[0]} from each ommatidium's up"
    return f"{text} ({peak} nm, {several})"


def _direction_deg(receptor: ReceptorType) -> int | None:
    """Of a type's microvilli, 0 to 179, from up towards right; None where they tell nothing."""
    if receptor.polarisation_sensitivity <= _POLARISED:
        return None
    return round(math.degrees(receptor.microvillus_angle_rad)) % 180


def _directions_deg(known: _Types, types: Sequence[int]) -> list[int]:
    found = {_direction_deg(known[which]) for which in types}
    return sorted(each for each in found if each is not None)


def _peak_nm(receptor: ReceptorType) -> int:
    if receptor.peak_wavelength_nm:
        return round(receptor.peak_wavelength_nm)
    sensitivity = np.asarray(spectral_sensitivity(receptor, _WAVELENGTHS_NM))
    return round(float(_WAVELENGTHS_NM[sensitivity.argmax()]))


def _of_kind(eye: Eye, responses: Floats, types: list[int], like: list[int]) -> Floats:
    """The mean response (P, N) of the receptors of these types in each ommatidium; where it has
    none, of those ``like`` them."""
    owner: Ints = np.asarray(ommatidium_of_receptor(eye), dtype=np.int64)

    def of(some: list[int]) -> tuple[Floats, Ints]:
        chosen = np.isin(eye.receptor_type, some)
        behind = owner[chosen]
        number = np.bincount(behind, minlength=len(eye))
        return np.stack([np.bincount(behind, p[chosen], len(eye)) for p in responses]), number

    total, number = of(types)
    if like != types:
        others, many = of(like)
        total, number = np.where(number > 0, total, others), np.where(number > 0, number, many)
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
