"""Properties of ommatidia by name, with their units, for figures and tables."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from omma._core import Eye
from omma.base.arguments import one_of
from omma.base.arrays import Flags, Floats
from omma.eye.measures import EyeMeasures

_DEGREE = 180 / np.pi


@dataclass(frozen=True)
class EyeProperty:
    """A number for each ommatidium, (N,), NaN where it is not known; or a class for each.

    label: what it is, with its unit. classes: the names of what whole ``values`` stand for, empty
    where they are numbers.
    """

    values: Floats
    label: str
    classes: tuple[str, ...] = ()


# What it is, its unit, and its values in that unit.
_KNOWN: dict[str, tuple[str, str, Callable[[EyeMeasures], Floats]]] = {
    "interommatidial": ("interommatidial angle Δφ", "°", lambda m: m.interommatidial_rad * _DEGREE),
    "horizontal": ("horizontal Δφ", "°", lambda m: m.horizontal_rad * _DEGREE),
    "vertical": ("vertical Δφ", "°", lambda m: m.vertical_rad * _DEGREE),
    "surface-angle": (
        "angle of touching facets, mean",
        "°",
        lambda m: m.surface_angle_rad * _DEGREE,
    ),
    "smaller": ("angle of touching facets, smaller", "°", lambda m: m.smaller_rad * _DEGREE),
    "larger": ("angle of touching facets, larger", "°", lambda m: m.larger_rad * _DEGREE),
    "acceptance": ("acceptance angle Δρ", "°", lambda m: m.acceptance_rad * _DEGREE),
    "ratio": ("Δρ/Δφ", "", lambda m: m.ratio),
    "facet": ("facet diameter D", "µm", lambda m: m.facet_diameter_m * 1e6),
    "spacing": ("facet spacing", "µm", lambda m: m.facet_spacing_m * 1e6),
    "eye-parameter": ("eye parameter D·Δφ", "µm rad", lambda m: m.eye_parameter_m_rad * 1e6),
    "sampling": ("sampling frequency 1/(2Δφ)", "cycles/°", lambda m: m.sampling_per_rad / _DEGREE),
    "sensitivity": ("optical sensitivity S", "µm² sr", lambda m: m.sensitivity_m2_sr * 1e12),
    "skew": ("axis to direction from the head's centre", "°", lambda m: m.skew_head_rad * _DEGREE),
    "skew-normal": (
        "axis to surface normal",
        "°",
        lambda m: m.skew_normal_rad * _DEGREE,
    ),
    "neighbours": ("neighbours", "", lambda m: m.neighbours.astype(np.float64)),
}

# Of neighbours on the surface, and of those in direction: at the rim, where the ring of neighbours
# is open, these are numbers about the rest of the ring, not about the eye.
_OF_NEIGHBOURS: dict[str, Callable[[EyeMeasures], Flags]] = {
    **dict.fromkeys(("surface-angle", "smaller", "larger", "spacing"), lambda m: m.surface_border),
    **dict.fromkeys(
        ("interommatidial", "horizontal", "vertical", "ratio", "eye-parameter", "sampling"),
        lambda m: m.border,
    ),
    "skew-normal": lambda m: m.surface_border,
}

#: The properties that every eye has; besides, the names of its columns.
PROPERTIES: tuple[str, ...] = (*_KNOWN, "eye")


def expect_property(eye: Eye, name: str, argument: str = "property") -> None:
    """omma.Error where an eye has no such property: before it is measured, which may take long."""
    one_of(name, [*PROPERTIES, *eye.columns], argument)


def eye_property(
    eye: Eye, measures: EyeMeasures, name: str, argument: str = "property"
) -> EyeProperty:
    """A property of an eye: one of `PROPERTIES`, or one of its columns; ``argument`` is what errors
    call it. At the rim of an eye there are no values of what depends on neighbours, unless nowhere
    in that eye there would be one.

    Raises:
        omma.Error: there is no such property.
    """
    expect_property(eye, name, argument)
    if name in _KNOWN:
        what, unit, values = _KNOWN[name]
        found = values(measures)
        if name in _OF_NEIGHBOURS:
            found = _without_rim(found, measures.eye_id, _OF_NEIGHBOURS[name](measures))
        return EyeProperty(found, f"{what} ({unit})" if unit else what)
    if name == "eye":
        eyes = np.unique(measures.eye_id)
        return EyeProperty(
            np.searchsorted(eyes, measures.eye_id).astype(np.float64),
            "eye",
            tuple(f"eye {which}" for which in eyes),
        )
    column = eye.columns[name]
    if isinstance(column, np.ndarray):
        return EyeProperty(column.astype(np.float64), name)
    classes, which = np.unique(np.array(column), return_inverse=True)
    return EyeProperty(which.astype(np.float64), name, tuple(classes.tolist()))


def _without_rim(values: Floats, eye_id: NDArray[np.int32], rim: Flags) -> Floats:
    """``values`` with NaN at the rims of eyes that are more than a rim."""
    inner = np.where(rim, np.nan, values)
    for which in np.unique(eye_id):
        members = eye_id == which
        if not np.isfinite(inner[members]).any():
            inner[members] = values[members]
    return inner


def is_known(prop: EyeProperty) -> bool:
    """Whether any ommatidium has a value."""
    return bool(np.isfinite(prop.values).any())
