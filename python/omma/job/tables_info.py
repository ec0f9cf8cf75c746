"""What there is to say of a table: where a head is, where an animal walked, or a spectrum."""

from __future__ import annotations

import os
import re
import warnings
from itertools import islice
from pathlib import Path

import numpy as np

from omma._core import Error
from omma.base.arrays import Floats
from omma.base.files import PathLike, open_text
from omma.base.poses import ANGLE_COLUMNS, QUATERNION_COLUMNS, load_timed_poses
from omma.job.extents import size_words
from omma.job.places import place_words
from omma.job.results_info import Lines
from omma.light.spectrum_files import load_spectra
from omma.light.spectrum_tables import is_wavelength_name
from omma.motion.tracks import load_track

# Lines in which a header is looked for, and spectra that are named.
_LINES, _NAMED = 1000, 8


def describe_table(path: PathLike) -> Lines | None:
    """Of a track, poses or spectra what they are; None: it is none of these.

    Raises:
        omma.Error: it is one of these and wrong, or a `.csv` that is neither these nor an eye.
    """
    name = os.fsdecode(path)
    if not Path(name).is_file() or Path(name).suffix.lower() == ".eye":
        return None
    header = _header(path)
    columns = set(header)
    if {"x_m", "z_m"} <= columns and not {"axis_x", "elevation_deg"} & columns:
        return _track(name)
    if {"axis_x", "azimuth_deg"} & columns:
        return None
    if {"x", "y", "z"} <= columns and columns & {*QUATERNION_COLUMNS[3:], *ANGLE_COLUMNS[3:]}:
        return _poses(name)
    if any(is_wavelength_name(one) for one in header[:2]):
        return _spectra(name)
    try:
        return _spectra(name)
    except Error:
        pass
    if Path(name).suffix.lower() != ".csv" or not any(re.search("[a-z]", one) for one in header):
        return None
    raise Error(
        f"{name}: expected a table that says of an eye azimuth_deg, elevation_deg or axis_x, "
        "axis_y, axis_z, of a track x_m, z_m, of poses x, y, z and yaw_deg, pitch_deg, roll_deg or "
        "qx, qy, qz, qw, of spectra wavelengths in nm, or responses that Omma wrote, found "
        f"'{', '.join(header)[:60]}'"
    )


def _header(path: PathLike) -> list[str]:
    """The cells of the first line that says anything, in small letters; none where the file is no
    text in UTF-8."""
    try:
        lines = open_text(path)
    except Error:
        return []
    for full in islice(lines, _LINES):
        line = full.split("#", 1)[0].strip()
        if line:
            return [cell.strip(' "').lower() for cell in re.split("[,;\t]", line)]
    return []


def _track(name: str) -> Lines:
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        track = load_track(name, lost="leave_out")
    xz_m = track.xz_m
    size = np.ptp(xz_m, axis=0)
    low, high = (place_words(corner) for corner in (xz_m.min(axis=0), xz_m.max(axis=0)))
    way_m = float(np.hypot(*np.diff(xz_m, axis=0).T).sum())
    if track.times_s is None:
        duration, speed = "not told: no column t_s", ""
    else:
        duration = _times(track.times_s, "a position")
        seconds = float(np.ptp(track.times_s))
        speed = f", {way_m / seconds:.4g} m/s in the mean" if seconds > 0 else ""
    heading = "along the way" if track.heading_deg is None else "told, heading_deg"
    return [
        ("track", name),
        ("positions", f"{len(xz_m):,}"),
        ("duration", duration),
        ("bounds", f"{low} to {high} m, x and z"),
        ("extent", size_words(size)),
        ("way", f"{way_m:.4g} m{speed}"),
        ("heading", heading),
        *(("warning", str(one.message)) for one in told),
        ("more", f"omma render SCENE --eye EYE --path {name} --on-ground HEIGHT"),
    ]


def _times(times_s: Floats, each: str) -> str:
    first, last = (f"{one:.15g}" for one in times_s[[0, -1]])
    if len(times_s) == 1:
        return f"at {first} s"
    # Double precision holds no digit below; of times since 1970 that is 0.2 microseconds.
    digits = min(-int(np.floor(np.log10(np.spacing(np.abs(times_s).max())))) - 1, 300)
    steps = np.round(np.diff(times_s), digits)
    return (
        f"{np.round(np.ptp(times_s), digits):.6g} s, from {first} to {last} s, {each} each "
        f"{np.median(steps):.4g} s, median ({steps.min():.4g} to {steps.max():.4g} s)"
    )


def _poses(name: str) -> Lines:
    poses, times_s = load_timed_poses(name)
    position_m = poses[:, :3, 3]
    low, high = position_m.min(axis=0), position_m.max(axis=0)
    way_m = float(np.linalg.norm(np.diff(position_m, axis=0), axis=1).sum())
    return [
        ("poses", name),
        ("number", f"{len(poses):,}"),
        (
            "duration",
            "not told: no column t_s" if times_s is None else _times(times_s, "a pose"),
        ),
        ("bounds", f"{place_words(low)} to {place_words(high)} m"),
        ("extent", size_words(high - low)),
        ("way", f"{way_m:.4g} m"),
        ("more", f"omma render SCENE --eye EYE --path {name}"),
    ]


def _spectra(name: str) -> Lines:
    spectra = load_spectra(name, unit="as_is")
    wavelengths = next(iter(spectra.values())).wavelength_nm
    steps = np.diff(wavelengths)
    every = f"{steps[0]:.4g} nm" if np.ptp(steps) < 1e-6 else f"{steps.mean():.4g} nm in the mean"
    values = np.array([one.value for one in spectra.values()])
    names = list(spectra)
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return [
        ("spectra", name),
        ("number", f"{len(names):,}: {', '.join(names[:_NAMED])}{more}"),
        (
            "wavelengths",
            f"{wavelengths[0]:.6g} to {wavelengths[-1]:.6g} nm, {len(wavelengths):,} of them, one "
            f"each {every}",
        ),
        ("values", f"{values.min():.4g} to {values.max():.4g}"),
        ("unit", _unit(name, float(values.max()))),
        ("more", "omma.light.load_spectra"),
    ]


def _unit(name: str, largest: float) -> str:
    """What numbers are taken as where nobody says it, and why."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            taken = max(float(one.value.max()) for one in load_spectra(name).values())
        except Error:
            return (
                'neither fractions nor per cent for certain: unit="percent", "fraction", or '
                '"as_is" for other numbers, such as an irradiance'
            )
    if any("are taken as" in str(one.message) for one in told):
        said = 'as the values look; unit="as_is" if they are an irradiance or the like'
    else:
        said = "as the file says"
    return f"{'per cent' if largest > 2 * taken else 'fractions'}, {said}"
