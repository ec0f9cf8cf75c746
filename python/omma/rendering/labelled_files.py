"""Responses into files that say what their numbers are: `.zarr` (Zarr 3) and `.nc` (netCDF-4).

Both have the variables, coordinates and attributes of `Renderer.dataset`. The files are made in
full size at once and filled piece by piece, so that poses need no memory.
"""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma.base.files import WholeFiles, named_in_errors
from omma.base.optional import needs
from omma.rendering.hdf5_file import opened
from omma.rendering.labels import WRITTEN, Labels
from omma.rendering.response_files import Piece

# A few MB: large enough for a disk or a network, small enough to read one pose of many.
_CHUNK_BYTES = 4 << 20

# The file that every Zarr 3 store has.
ZARR_MARKER = "zarr.json"
# How the attribute ``format`` of a data set's store begins.
DATA_SET = "omma dataset"
# What messages call it.
A_DATA_SET = "a data set of omma dataset run"
# An array's file: what the array is, or a chunk of it.
_FILE_OF_ARRAY = re.compile(rf"([^/]+)/({re.escape(ZARR_MARKER)}|c([/.]\d+)*)")
# Files that systems leave in folders that are looked at.
_OF_SYSTEMS = (".DS_Store", "Thumbs.db", "desktop.ini")
_NAMED = 3


def write_coordinate(
    group: Any,
    name: str,
    dimensions: tuple[str, ...],
    values: NDArray[Any],
    attributes: Mapping[str, Any],
) -> None:
    """Write a coordinate, numbers or texts, into a group of a Zarr store, as one chunk."""
    group.create_array(
        name,
        shape=values.shape,
        dtype=str if values.dtype.kind == "U" else values.dtype,
        chunks=tuple(max(1, size) for size in values.shape),
        dimension_names=dimensions,
        attributes=attributes,
        compressors=_compressors(),
    )[...] = values


def is_data_set(attributes: Mapping[str, Any]) -> bool:
    """Whether a store with these attributes is one of a data set, of whatever version."""
    return str(attributes.get("format", "")).startswith(DATA_SET)


def other_than_responses(marker: bytes, files: Iterable[str]) -> str | None:
    """What a store with this ``zarr.json`` and these files is, which responses do not replace; None
    where it holds responses itself, and nothing else."""
    try:
        attributes = dict(json.loads(marker)["attributes"])
    except (ValueError, TypeError, KeyError, RecursionError):
        attributes = {}
    if is_data_set(attributes):
        return A_DATA_SET
    if "omma_version" not in attributes:
        return "a Zarr store of something else than responses"
    others = sorted(set(filter(None, map(_not_of_a_render, files))))
    if not others:
        return None
    more = f" and {len(others) - _NAMED} more" if len(others) > _NAMED else ""
    return f"a store that also holds what no render wrote: {', '.join(others[:_NAMED])}{more}"


def _not_of_a_render(file: str) -> str | None:
    """What a file in a store is, or is of, where no render wrote it."""
    if file == ZARR_MARKER or file.rpartition("/")[2] in _OF_SYSTEMS:
        return None
    found = _FILE_OF_ARRAY.fullmatch(file)
    if found is None:
        return file
    return None if found[1] in WRITTEN else found[1]


class ZarrWriter:
    """A Zarr 3 store, a directory."""

    def __init__(self, files: WholeFiles, name: str, labels: Labels) -> None:
        zarr = load_package("zarr", name)
        path = files.open_directory(name, ZARR_MARKER, other_than_responses)
        self._name = name
        self._arrays: dict[str, Any] = {}
        with warnings.catch_warnings(), named_in_errors(name):
            # Zarr warns that texts and the index of a store are newer than its standard; any
            # reader of Zarr 3 in Python, and xarray, reads both.
            warnings.simplefilter("ignore")
            # Not "w", which would make the directory anew, and lose the lock that is on it.
            group = zarr.open_group(path, mode="a", zarr_format=3)
            group.attrs.update(labels.attributes)
            for variable, coordinate in labels.coordinates.items():
                write_coordinate(group, variable, *coordinate)
            for variable, (dimensions, dtype, attributes) in labels.variables.items():
                self._arrays[variable] = group.create_array(
                    variable,
                    shape=labels.shape(variable),
                    dtype=dtype,
                    chunks=_chunks(labels, variable),
                    dimension_names=dimensions,
                    attributes=attributes | {"coordinates": _coordinates(labels, dimensions)},
                    compressors=_compressors(),
                )
            zarr.consolidate_metadata(path)

    def write(self, piece: Piece) -> None:
        with named_in_errors(self._name):
            for variable, values in piece.variables.items():
                if variable in self._arrays:
                    self._arrays[variable][piece.poses] = values


class NetcdfWriter:
    """A netCDF-4 file."""

    def __init__(self, files: WholeFiles, name: str, labels: Labels) -> None:
        self._h5netcdf = load_package("h5netcdf", name)
        h5py = load_package("h5py", name)
        self._name, self._path = name, files.path_of(name)
        self._variables = list(labels.variables)
        with named_in_errors(name), opened(self._h5netcdf, self._path, "w") as file:
            file.attrs.update(labels.attributes)
            file.dimensions = labels.sizes
            for variable, (dimensions, values, attributes) in labels.coordinates.items():
                text = values.dtype.kind == "U"
                dtype = h5py.string_dtype() if text else values.dtype
                made = file.create_variable(variable, dimensions, dtype)
                made[...] = values.astype(object) if text else values
                made.attrs.update(attributes)
            for variable, (dimensions, dtype, attributes) in labels.variables.items():
                made = file.create_variable(
                    variable, dimensions, dtype, chunks=_chunks(labels, variable)
                )
                made.attrs.update(attributes | {"coordinates": _coordinates(labels, dimensions)})

    def write(self, piece: Piece) -> None:
        # Opened for each piece, so that nothing is open where the work is cut off.
        appending = opened(self._h5netcdf, self._path, "a")
        with named_in_errors(self._name), appending as file:
            for variable, values in piece.variables.items():
                if variable in self._variables:
                    file.variables[variable][piece.poses] = values


def load_package(package: str, name: str) -> Any:
    """A package of the extra omma[data] that a file of that name needs."""
    return needs(package, "data", f"{name}: needs {package}")


def _compressors() -> Any:
    """Zarr's own, with checksums: changed bits are an error when they are read."""
    return load_package("zarr", "zarr").codecs.ZstdCodec(checksum=True)


def _chunks(labels: Labels, variable: str) -> tuple[int, ...]:
    first, *others = labels.shape(variable)
    pose_bytes = 4 * max(1, int(np.prod(others)))
    return (max(1, min(first, _CHUNK_BYTES // pose_bytes)), *(max(1, size) for size in others))


def _coordinates(labels: Labels, dimensions: tuple[str, ...]) -> str:
    """Names of those that are along a variable's dimensions but no dimension themselves (CF
    conventions, 5)."""
    return " ".join(
        name
        for name, (along, _, _) in labels.coordinates.items()
        if along != (name,) and along[0] in dimensions
    )
