"""Responses that were written, read back with what they mean: `load_responses`."""

from __future__ import annotations

import csv
import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from omma import _core
from omma._core import Error
from omma.base.arguments import checked
from omma.base.files import PathLike, check_ending, open_text, reading
from omma.base.hdf5_heaps import check_heaps
from omma.rendering.dataset import dataset_of, load_xarray
from omma.rendering.label_texts import beside, labels_from_text
from omma.rendering.labelled_files import A_DATA_SET, is_data_set, load_package
from omma.rendering.labels import RGB, camera_variables
from omma.rendering.parquet_files import METADATA, columns_of
from omma.rendering.response_files import CAMERA_COLUMNS, TIME_COLUMN, UNIT_COLUMN

if TYPE_CHECKING:
    import xarray

RESPONSE_SUFFIXES = (".zarr", ".nc", ".parquet", ".npy", ".json", ".csv")

# What `band_names` calls a band of a lit world.
_MIDDLE = re.compile(r"(\d+(?:\.\d+)?) nm")
_CSV_SITES = ("ommatidium", "eye_id", "receptor", "azimuth_deg", "elevation_deg")


@checked
def load_responses(path: PathLike) -> xarray.Dataset:
    """Responses that `omma render` or `render_file` wrote, as the dataset that
    `Renderer.dataset` would give.

    `.zarr`, `.nc` and `.npy` are read when their numbers are asked for, and any dataset that xarray
    writes is read too. An `.npy` file needs the `.json` beside it, either name does. A `.csv` file
    says where ommatidia look, the middles of bands to 0.01 nm, the unit and times, but nothing of
    where the head was and of how it was made. Bands called band_0 and on have no unit.

    Raises:
        omma.Error: another ending, a file that is missing or no such responses, a package that is
            not installed (``omma[data]``).
    """
    name = os.fsdecode(path)
    check_ending(name, *RESPONSE_SUFFIXES)
    suffix = Path(name).suffix.lower()
    if not os.path.exists(name):
        raise Error(f"{name}: there is no such file")
    if suffix in (".zarr", ".nc"):
        return _opened(name, suffix)
    load_xarray()
    if suffix == ".parquet":
        return _of_parquet(name)
    return _of_csv(name) if suffix == ".csv" else _of_npy(name)


def is_response_csv(path: PathLike) -> bool:
    """Whether a `.csv` file has responses: its first line begins with "pose,ommatidium"."""
    try:
        with open(path, "rb") as file:
            return file.readline(1000).startswith(b"pose,ommatidium,")
    except OSError:
        return False


def _opened(name: str, suffix: str) -> xarray.Dataset:
    made = load_xarray()
    load_package("zarr" if suffix == ".zarr" else "h5netcdf", name)
    how: dict[str, Any] = {"engine": "h5netcdf"}
    if suffix == ".zarr":
        how = {"engine": "zarr", "consolidated": None, "chunks": None}
    with reading(name, suffix):
        if suffix == ".nc":
            check_heaps(name)
            # What is no HDF5 file ends here: h5netcdf leaves half a file behind, which complains on
            # stderr where it is forgotten. It first looks for this attribute.
            with load_package("h5py", name).File(name, "r") as file:
                file.attrs.get("_nc3_strict")
        data = made.open_dataset(name, **how)
        if "response" not in data:
            if is_data_set(data.attrs):
                raise Error(
                    f"{name}: is {A_DATA_SET}; omma dataset info tells of its eyes, and "
                    "omma.datasets.open_views reads the views of one"
                )
            raise Error(f"{name}: expected a variable 'response', found none")
        if data.response.ndim == 0:
            raise Error(f"{name}: response: expected dimensions, found none")
        # Texts and numbers of one kind, whatever the library makes of them.
        for one, values in data.coords.items():
            if values.dtype.kind in "OTS":
                data = data.assign_coords(
                    {one: (values.dims, np.array(values.values.tolist(), np.str_))}
                )
        data.attrs = {
            key: value.item() if isinstance(value, np.generic) else value
            for key, value in data.attrs.items()
        }
    opened: xarray.Dataset = data
    return opened


def _of_npy(name: str) -> xarray.Dataset:
    about = beside(name)
    if not os.path.exists(about):
        raise Error(f"{name}: expected {about} beside it, which says what the numbers are")
    labels, files = labels_from_text(_core.read_file(about), about)
    if "response" not in labels.variables:
        raise Error(f"{about}: variables: expected one called response, found none")
    values = {}
    for variable in labels.variables:
        if variable not in files:
            raise Error(f"{about}: variables.{variable}: expected a file, found none")
        file = os.path.join(os.path.dirname(about), os.path.basename(files[variable]))
        values[variable] = read_npy(file)
        if values[variable].shape != labels.shape(variable):
            raise Error(
                f"{file}: expected shape {labels.shape(variable)}, as {about} says, found "
                f"{values[variable].shape}"
            )
    with reading(about, "the labels of responses"):
        return dataset_of(labels, values)


def read_npy(name: str) -> np.ndarray[Any, Any]:
    """An array, read when its numbers are asked for; never one of objects, which are pickles."""
    with reading(name, ".npy"):
        array: np.ndarray[Any, Any] = np.load(name, mmap_mode="r", allow_pickle=False)
        if not isinstance(array, np.ndarray):
            raise ValueError("it holds several arrays")
        return array


def _of_parquet(name: str) -> xarray.Dataset:
    parquet = load_package("pyarrow.parquet", name)
    with reading(name, ".parquet"):
        file = parquet.ParquetFile(name, thrift_string_size_limit=(1 << 31) - 1)
        text = (file.schema_arrow.metadata or {}).get(METADATA, b"")
        labels, _ = labels_from_text(text, name)
        values = {}
        for variable, columns in columns_of(labels).items():
            table = np.stack([column.to_numpy() for column in file.read(columns).columns], axis=-1)
            shape = labels.shape(variable)
            # What a pose has one of stands in each of its rows.
            table = table.reshape(shape[0], -1)[:, 0] if len(shape) == 1 else table
            values[variable] = table.reshape(shape)
            if values[variable].dtype.kind not in "biuf":
                raise Error(f"{name}: {variable}: expected numbers, found {table.dtype}")
        return dataset_of(labels, values)


def _of_csv(name: str) -> xarray.Dataset:
    if not is_response_csv(name):
        raise Error(f"{name}: expected responses: a first line that begins with pose,ommatidium")
    with reading(name, "responses in .csv"):
        return _of_table(name)


def _of_table(name: str) -> xarray.Dataset:
    rows = csv.reader(open_text(name))
    header = next(rows)
    before = [column for column in (*_CSV_SITES, TIME_COLUMN, UNIT_COLUMN) if column in header]
    for column in ("eye_id", "azimuth_deg", "elevation_deg"):
        if column not in before:
            raise Error(f"{name}: expected a column {column}, found {', '.join(header)[:120]}")
    numbered = header[1 + len(before) :]
    cameras = [one for one in CAMERA_COLUMNS.values() if one in numbered]
    bands = [one for one in numbered if not one.endswith("_error") and one not in cameras]
    if not bands:
        raise Error(f"{name}: expected columns of responses, found none")
    try:
        texts = np.array(list(rows), dtype=np.str_)
        pose = texts[:, 0].astype(np.int64)
        poses = int(pose[-1]) + 1
        each = len(texts) // poses
        if not np.array_equal(pose, np.repeat(np.arange(poses), each)):
            raise ValueError
        site = {one: texts[:each, header.index(one)] for one in before}
        cells = texts[:, 1 + len(before) :]
        numbers = np.where(cells == "", "nan", cells).astype(np.float64).reshape(poses, each, -1)
        times = {}
        if TIME_COLUMN in before:
            times_s = texts[::each, header.index(TIME_COLUMN)].astype(np.float64)
            times["time"] = ("time", times_s, {"units": "s"})
    except (ValueError, IndexError, OverflowError, ZeroDivisionError, csv.Error, MemoryError):
        raise Error(f"{name}: expected as many whole lines for each pose, in their order") from None
    along = "receptor" if "receptor" in site else "ommatidium"
    first = "time" if times else "pose"
    coordinates: dict[str, Any] = times | {
        along: np.arange(each),
        "eye": (along, site["eye_id"].astype(np.int64)),
        "azimuth": (along, site["azimuth_deg"].astype(np.float64), {"units": "degree"}),
        "elevation": (along, site["elevation_deg"].astype(np.float64), {"units": "degree"}),
    }
    dimensions: tuple[str, ...] = (first, along)
    if along == "receptor":
        coordinates |= {
            "ommatidium": (along, site["ommatidium"].astype(np.int64)),
            "type": (along, site["receptor"]),
        }
        arrays = [numbers[..., k] for k in range(numbers.shape[2])]
    else:
        dimensions = (*dimensions, "band")
        coordinates |= _band_coordinates(bands)
        whole = numbers.shape[2] - len(cameras)
        arrays = [numbers[..., k : k + len(bands)] for k in range(0, whole, len(bands))]
    found = zip(("response", "standard_error"), arrays)
    unit = str(site[UNIT_COLUMN][0]) if UNIT_COLUMN in site else "1"
    # Columns band_0 and on may be in any unit.
    about = {} if bands[0] == "band_0" else {"units": unit}
    variables: dict[str, Any] = {
        one: (dimensions, values.astype(np.float32), about) for one, values in found
    }
    for name, (of_poses, dtype, about) in camera_variables(first).items() if cameras else ():
        values = numbers[..., numbered.index(CAMERA_COLUMNS[name])]
        values = values[:, 0] if len(of_poses) == 1 else values
        variables[name] = (of_poses, values.astype(dtype), about)
    data: xarray.Dataset = load_xarray().Dataset(variables, coordinates)
    return data


def _band_coordinates(columns: list[str]) -> dict[str, Any]:
    """What the columns of responses say of bands."""
    if columns == list("rgb"):
        return {"band": list(RGB)}
    found: dict[str, Any] = {"band": columns}
    middles = [_MIDDLE.fullmatch(column) for column in columns]
    if all(middles):
        middles_nm = [float(one[1]) for one in middles if one]
        found["wavelength"] = ("band", middles_nm, {"units": "nm"})
    return found
