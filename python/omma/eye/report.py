"""What the measures of an eye come to: a summary for people and programs, a table of ommatidia."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from omma._core import Eye
from omma.base.arguments import checked
from omma.base.arrays import Flags, Floats
from omma.base.directions import azimuth_elevation_deg_of
from omma.base.files import PathLike, check_ending, write_whole
from omma.base.tables import csv_text
from omma.eye.measures import EyeMeasures

_DEGREE = 180 / np.pi
#: What spreads are told of, in this order: name, what it is, its unit.
SPREADS: tuple[tuple[str, str, str], ...] = (
    ("interommatidial_deg", "interommatidial Δφ", "°"),
    ("horizontal_deg", "horizontal Δφ", "°"),
    ("vertical_deg", "vertical Δφ", "°"),
    ("surface_angle_deg", "touching facets, mean", "°"),
    ("smaller_deg", "touching facets, smaller", "°"),
    ("larger_deg", "touching facets, larger", "°"),
    ("acceptance_deg", "acceptance Δρ", "°"),
    ("ratio", "Δρ/Δφ", ""),
    ("facet_diameter_um", "facet diameter D", "µm"),
    ("facet_spacing_um", "facet spacing", "µm"),
    ("eye_parameter_um_rad", "eye parameter D·Δφ", "µm rad"),
    ("sampling_cycles_per_deg", "sampling 1/(2Δφ)", "cycles/°"),
    ("hexagonal_sampling_cycles_per_deg", "hexagonal 1/(√3Δφ)", "cycles/°"),
    ("skew_head_deg", "skew from head's centre", "°"),
    ("skew_eye_deg", "skew from eye's centre", "°"),
    ("skew_normal_deg", "skew from surface normal", "°"),
    ("sensitivity_um2_sr", "optical sensitivity S", "µm² sr"),
)


@checked
def eye_table(eye: Eye, measures: EyeMeasures) -> dict[str, np.ndarray[Any, Any]]:
    """What is known of each ommatidium: name with unit to (N,) values, NaN where not known."""
    azimuth, elevation = azimuth_elevation_deg_of(eye.axis)
    # Where all of an eye's positions are one, no facets touch; where that is a place and not left
    # out, which is 0, all look through one lens, whose diameter says nothing of their sampling.
    apart = ~_at_one_point(eye, measures)
    lens = ~apart & eye.position_m.any(axis=1)
    return {
        "ommatidium": np.arange(len(eye)),
        "eye": measures.eye_id,
        "azimuth_deg": azimuth,
        "elevation_deg": elevation,
        "interommatidial_deg": measures.interommatidial_rad * _DEGREE,
        "smaller_deg": np.where(apart, measures.smaller_rad * _DEGREE, np.nan),
        "larger_deg": np.where(apart, measures.larger_rad * _DEGREE, np.nan),
        "horizontal_deg": measures.horizontal_rad * _DEGREE,
        "vertical_deg": measures.vertical_rad * _DEGREE,
        "surface_angle_deg": np.where(apart, measures.surface_angle_rad * _DEGREE, np.nan),
        "acceptance_deg": measures.acceptance_rad * _DEGREE,
        "ratio": measures.ratio,
        "facet_diameter_um": measures.facet_diameter_m * 1e6,
        "facet_spacing_um": measures.facet_spacing_m * 1e6,
        "eye_parameter_um_rad": np.where(lens, np.nan, measures.eye_parameter_m_rad * 1e6),
        "sampling_cycles_per_deg": measures.sampling_per_rad / _DEGREE,
        "hexagonal_sampling_cycles_per_deg": measures.hexagonal_sampling_per_rad / _DEGREE,
        "skew_head_deg": measures.skew_head_rad * _DEGREE,
        "skew_eye_deg": measures.skew_eye_rad * _DEGREE,
        "skew_normal_deg": measures.skew_normal_rad * _DEGREE,
        "sensitivity_um2_sr": measures.sensitivity_m2_sr * 1e12,
        "neighbours": measures.neighbours,
        "border": measures.border.astype(np.int64),
        "duplicate_of": measures.duplicate_of,
        "outlier": measures.outlier,
    }


def _at_one_point(eye: Eye, measures: EyeMeasures) -> Flags:
    """Of which ommatidia the eye has all its positions, which are several, in one: (N,)."""
    found = np.zeros(len(eye), bool)
    for which in np.unique(measures.eye_id):
        members = measures.eye_id == which
        found[members] = members.sum() > 1 and not np.ptp(eye.position_m[members], axis=0).any()
    return found


@checked
def save_eye_table(path: PathLike, eye: Eye, measures: EyeMeasures) -> None:
    """Write `eye_table` as CSV: a header, a line an ommatidium, nothing where a value is not known.

    Raises:
        omma.Error: another ending than `.csv`; the file cannot be written.
    """
    check_ending(path, ".csv")
    table = eye_table(eye, measures)
    rows = zip(*map(_texts, table.values()), strict=True)
    write_whole(path, csv_text(table, rows).encode())


@checked
def eye_summary(eye: Eye, measures: EyeMeasures) -> dict[str, Any]:
    """The whole eye in plain numbers, texts, lists and dicts, ready for JSON.

    ``spread`` has min, p5, median, p95 and max of each of `SPREADS`, and how many are known; angles
    in degrees, solid angles in sr, indices from 0. ``inward`` has the ommatidia whose axes point
    into the eye, towards the half that the centre of the sphere lies in that fits its positions.
    """
    table = eye_table(eye, measures)
    inner = ~measures.border
    field = measures.field
    names = [one.name or f"type {k}" for k, one in enumerate(eye.receptor_types)]
    receptors = Counter(names[k] for k in eye.receptor_type.tolist())
    copies = np.flatnonzero(measures.duplicate_of >= 0)
    odd = np.flatnonzero(measures.outlier != "")
    # The test of scans' lenses and cones: against the centre of the sphere that fits the eye.
    inward = measures.skew_eye_rad > np.pi / 2
    return {
        "file": eye.path or None,
        "ommatidia": len(eye),
        "eyes": {str(k): int(n) for k, n in _counted(measures.eye_id)},
        "acceptance_kernels": dict(Counter(_kernels(eye))),
        "receptors": dict(receptors),
        "columns": list(eye.columns),
        "size_mm": [float(v) for v in np.ptp(eye.position_m.astype(np.float64), axis=0) * 1e3],
        "spread": {
            name: _spread(np.asarray(table[name], dtype=np.float64)) for name, _, _ in SPREADS
        },
        "inner_ommatidia": int(inner.sum()),
        "inner_with_six_neighbours": int((measures.neighbours[inner] == 6).sum()),
        "field_sr": {str(k): v for k, v in field.eyes_sr.items()},
        "seen_sr": field.seen_sr,
        "binocular_sr": field.binocular_sr,
        "binocular_fraction_of_seen": field.binocular_sr / field.seen_sr if field.seen_sr else None,
        "blind_sr": field.blind_sr,
        "blind_zones": [
            {
                "solid_angle_sr": zone.solid_angle_sr,
                "azimuth_deg": zone.azimuth_deg,
                "elevation_deg": zone.elevation_deg,
                "radius_deg": zone.radius_deg,
            }
            for zone in field.blind_zones
        ],
        "outliers": [{"ommatidium": int(i), "differs_in": str(measures.outlier[i])} for i in odd],
        "inward": [int(i) for i in np.flatnonzero(inward)],
        "duplicates": [
            {"ommatidium": int(i), "same_as": int(measures.duplicate_of[i])} for i in copies
        ],
    }


def has_surface(summary: dict[str, Any]) -> bool:
    """Whether a summary knows angles of facets that touch."""
    return bool(summary["spread"]["smaller_deg"]["known"])


def direction_text(azimuth_deg: float, elevation_deg: float) -> str:
    """A direction in whole degrees, in words."""
    azimuth, elevation = (round(angle) for angle in (azimuth_deg, elevation_deg))
    return f"azimuth {azimuth}°, elevation {elevation}°"


def _kernels(eye: Eye) -> list[str]:
    names = [acceptance.kernel for acceptance in eye.acceptances]
    return [names[k] if k >= 0 else "gaussian" for k in eye.acceptance_of.tolist()]


def _counted(values: np.ndarray[Any, Any]) -> list[tuple[Any, int]]:
    names, counts = np.unique(values, return_counts=True)
    return list(zip(names.tolist(), counts.tolist(), strict=True))


def _spread(values: Floats) -> dict[str, float | int | None]:
    known = values[np.isfinite(values)]
    names = ("min", "p5", "median", "p95", "max")
    if len(known) == 0:
        return {**dict.fromkeys(names), "known": 0}
    spread = np.percentile(known, [0, 5, 50, 95, 100])
    return {**dict(zip(names, map(float, spread), strict=True)), "known": len(known)}


def _texts(values: np.ndarray[Any, Any]) -> list[str]:
    if values.dtype.kind == "f":
        return [f"{value:.7g}" if np.isfinite(value) else "" for value in values.tolist()]
    return [str(value) for value in values.tolist()]
