"""Spectra from tables that spectrometers, databases and R write: a column of wavelengths, and
columns of values.

What a file leaves open, per cent or fractions, is decided by a rule and said in a warning; what
cannot be right is an error that names the line.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from omma._core import Error, Spectrum
from omma.base.arguments import checked, one_of
from omma.base.arrays import Floats
from omma.base.files import PathLike
from omma.base.warn import warn_caller
from omma.light.spectrum_tables import SpectrumTable, read_spectrum_table

SpectrumUnit = Literal["fraction", "percent", "as_is"]

_PERCENT = re.compile(r"%|per ?cent", re.IGNORECASE)

# No reflectance is larger but of gloss, and no per cents of anything but black are smaller.
_MOST_FRACTION, _LEAST_PERCENT = 1.0, 1.5
# No fractions are so large; beside such columns others may still be fractions.
_SURELY_PERCENT = 10.0
# Noise about 0: of a reflectance, and as a share of the largest of other values.
_NOISE = 0.05


@checked
def load_spectra(
    path: PathLike,
    *,
    unit: SpectrumUnit | None = None,
    columns: Sequence[str] | None = None,
    range_nm: tuple[float, float] | None = None,
) -> dict[str, Spectrum]:
    """Spectra of a text file by the names of their columns.

    Tables with a column of wavelengths in nm (called wl, wavelength, lambda or nm, or else the
    first) and one or more of values: comma, semicolon, tab or spaces between them, points or
    commas as decimal signs, with or without a line of names and one of units below it, after any
    lines of an instrument and lines that begin with #. So are CSV, tables of the R package pavo
    with or without row names, and text files of Ocean Optics (">>>>>Begin Spectral Data<<<<<") and
    Avantes, and downloads of the Floral Reflectance Database (lines of a flower's number, by which
    its spectrum is called, a wavelength and a value). Without names a spectrum is called as the
    file, or "column 2" and so on. Wavelengths that all descend are turned round; lines that are
    there twice count once.

    Args:
        unit: "percent", divided by 100; "fraction"; "as_is", whatever the numbers are, such as an
            irradiance. None: reflectances, per cent where a name or its unit says so (% or percent)
            or where any is above 1.5, fractions where none is above 1; a warning says which was
            taken.
        columns: names of those that are wanted. None: all.
        range_nm: from where to where, nm, linear between the file's wavelengths; what the file has
            beyond is not looked at, such as the noise at the ends of a spectrometer. None: all.

    Returns:
        Name to spectrum, in the file's order. Values of at least -0.05 (of other numbers: -5 % of
        the column's largest) are noise about 0 and become 0, of which a warning tells.

    Example:
        >>> with open("petals.csv", "w") as file:
        ...     _ = file.write("wl,white,red\\n300,5,3\\n500,70,4\\n700,72,61\\n")
        >>> petals = omma.light.load_spectra("petals.csv", unit="percent")
        >>> petals["red"]
        <omma.light.Spectrum of 3 values from 300 to 700 nm>

    Raises:
        omma.Error: a file that cannot be read or holds no such table, cells that are no numbers,
            wavelengths that do not ascend, are there twice or are not nanometres, a range beyond
            them, values that are negative beyond noise or neither fractions nor per cent; it names
            the file and, where there is one, the line.

    Warns:
        UserWarning: what unit was taken, values below 0 that became 0, columns in per cent beside
            which others may be fractions, names that are not those of the columns.
    """
    if unit is not None:
        one_of(unit, ("fraction", "percent", "as_is"), "unit")
    table = _in_range(_ascending(read_spectrum_table(path)), range_nm)
    if isinstance(columns, str):
        columns = [columns]
    wanted = table.names[1:] if columns is None else list(columns)
    index = [1 + table.names[1:].index(one_of(n, table.names[1:], "columns")) for n in wanted]
    missing = np.argwhere(~np.isfinite(table.numbers[:, index]))
    if len(missing):
        row, column = missing[0]
        raise Error(
            f"{table.path}, line {table.lines[row]}: expected a number, found none of "
            f"{wanted[column]!r} at {table.numbers[row, 0]:g} nm; columns= and range_nm= leave out "
            "what is not wanted"
        )
    divisor = _divisor(table, index, unit)
    least = -_NOISE * divisor if unit != "as_is" else None
    values = _without_noise(table, wanted, table.numbers[:, index], least) / divisor
    return {name: Spectrum(table.numbers[:, 0], one) for name, one in zip(wanted, values.T)}


def _ascending(table: SpectrumTable) -> SpectrumTable:
    """The table with wavelengths that ascend; omma.Error where they cannot be nanometres. Lines
    that are there twice with the same values, as where files were spliced, count once."""
    same = np.zeros(len(table.numbers), bool)
    same[1:] = [
        np.array_equal(one, other, equal_nan=True)
        for one, other in itertools.pairwise(table.numbers)
    ]
    table = replace(table, numbers=table.numbers[~same], lines=table.lines[~same])
    nm = table.numbers[:, 0]
    if len(nm) > 1 and np.all(np.diff(nm) < 0):
        table = replace(table, numbers=table.numbers[::-1], lines=table.lines[::-1])
        nm = table.numbers[:, 0]
    wrong = np.flatnonzero(~(np.diff(nm, prepend=-np.inf) > 0))
    if len(wrong):
        k = int(wrong[0])
        before = "" if k == 0 else f" after {nm[k - 1]:g}"
        if k > 0 and nm[k] == nm[k - 1]:
            what = f", with other values than in line {table.lines[k - 1]}: keep one, or their mean"
        else:
            what = ""
        raise Error(
            f"{table.path}, line {table.lines[k]}: expected wavelengths that ascend, each once, "
            f"found {nm[k]:g}{before} nm{what}"
        )
    if not (nm[0] >= 100 and nm[-1] <= 5000):
        what = ", which look like micrometres: multiply by 1000" if nm[-1] < 10 else ""
        raise Error(
            f"{table.path}: expected wavelengths of 100 to 5000 nm, found {nm[0]:g} to "
            f"{nm[-1]:g}{what}"
        )
    return table


def _in_range(table: SpectrumTable, range_nm: tuple[float, float] | None) -> SpectrumTable:
    nm = table.numbers[:, 0]
    if range_nm is None:
        if len(nm) < 2:
            raise Error(f"{table.path}: expected two wavelengths or more, found {len(nm)}")
        return table
    if np.shape(range_nm) != (2,) or not range_nm[0] < range_nm[1]:
        raise Error(f"range_nm: expected two wavelengths, low and high, found {range_nm!r:.40}")
    low, high = (float(end) for end in range_nm)
    if nm[0] > low or nm[-1] < high:
        raise Error(
            f"range_nm: expected wavelengths that {table.path} has, {nm[0]:g} to {nm[-1]:g} nm, "
            f"found {low:g} to {high:g}"
        )
    inside = (nm > low) & (nm < high)
    ends = []
    for end, near in (
        (low, np.argmin(nm < low)),
        (high, len(nm) - 1 - np.argmax(nm[::-1] <= high)),
    ):
        row = [end, *(np.interp(end, nm, one) for one in table.numbers[:, 1:].T)]
        ends.append((np.array(row), table.lines[near]))
    return replace(
        table,
        numbers=np.vstack([ends[0][0], table.numbers[inside], ends[1][0]]),
        lines=np.array([ends[0][1], *table.lines[inside], ends[1][1]]),
    )


def _divisor(table: SpectrumTable, index: list[int], unit: str | None) -> float:
    """What numbers are divided by."""
    largest = float(table.numbers[:, index].max(initial=0.0))
    if unit is None:
        if any(_PERCENT.search(f"{table.names[k]} {table.units[k]}") for k in index):
            unit = "percent"
        else:
            unit = _guessed_unit(table.path, largest)
    divisor = 100.0 if unit == "percent" else 1.0
    if unit != "as_is" and largest / divisor > _LEAST_PERCENT:
        raise Error(
            f"{table.path}: expected reflectances of at most {divisor * _LEAST_PERCENT:g}, found "
            f"{largest:g} (of {unit}); columns= and range_nm= leave out what is not "
            'wanted, unit="as_is" takes other numbers, such as irradiances, as they stand'
        )
    if unit == "percent":
        _warn_of_mixed(table, index)
    return divisor


def _warn_of_mixed(table: SpectrumTable, index: list[int]) -> None:
    """Tell of columns that look like fractions beside others in per cent."""
    most = {table.names[k]: float(table.numbers[:, k].max()) for k in index}
    small = [name for name, one in most.items() if 0 < one <= _LEAST_PERCENT]
    if small and max(most.values()) > _SURELY_PERCENT:
        up_to = max(most[name] for name in small)
        warn_caller(
            f"{table.path}: all columns are taken as per cent, up to {max(most.values()):.4g}, but "
            f"{', '.join(small):.200} (up to {up_to:.4g}) may be fractions; load these by "
            'themselves, columns= with unit="fraction"',
            UserWarning,
        )


def _guessed_unit(path: str, largest: float) -> str:
    if _MOST_FRACTION < largest <= _LEAST_PERCENT:
        raise Error(
            f"{path}: expected reflectances that are fractions, up to 1, or per cent, above 1.5, "
            f'found {largest:g} as the largest, which may be either; say unit="fraction" or '
            'unit="percent"'
        )
    unit = "percent" if largest > _LEAST_PERCENT else "fraction"
    words = "per cent" if unit == "percent" else "fractions"
    warn_caller(
        f"{path}: its values, up to {largest:.4g}, are taken as {words}; unit={unit!r} says so, "
        'unit="as_is" that they are none of reflectances, such as an irradiance',
        UserWarning,
    )
    return unit


def _without_noise(
    table: SpectrumTable, names: list[str], values: Floats, least: float | None
) -> Floats:
    """Values of at least 0, in the file's unit; omma.Error where one is below what noise may be:
    ``least``, or a share of the largest of its column."""
    share = -_NOISE * values.max(axis=0, initial=0.0)
    lowest = share if least is None else np.full(len(names), least)
    wrong = np.argwhere(values < lowest)
    if len(wrong):
        row, column = wrong[0]
        raise Error(
            f"{table.path}, line {table.lines[row]}: expected values of at least "
            f"{lowest[column]:.3g}, which is noise, found {values[row, column]:.4g} of "
            f"{names[column]!r} at {table.numbers[row, 0]:g} nm; range_nm= leaves out noisy ends"
        )
    below = values < 0
    if below.any():
        warn_caller(
            f"{table.path}: {np.count_nonzero(below)} values below 0, down to {values.min():.3g}, "
            "are taken as 0",
            UserWarning,
        )
    return np.where(values > 0, values, 0.0)  # no negative zeros
