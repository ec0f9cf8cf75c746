"""Small files of every kind that omma reads, how each is read, and bytes of them changed at random.

A reader of a changed file gives what it gives or raises omma.Error, nothing else.
"""

from __future__ import annotations

import contextlib
import json
import shutil
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from conftest import make_eye, write_gltf
from dataset_jobs import write_job

import omma
from omma.job.results_info import describe_responses
from omma.rendering.read_back import load_responses


@dataclass(frozen=True)
class Kind:
    """A kind of file: what makes one in a folder, and all that reads it."""

    make: Callable[[Path], Path]
    read: Callable[[Path], Any]
    changed: str = ""  # another file than the one that is made and read, from its folder
    needs: tuple[str, ...] = ()  # packages


def changes(data: bytes, seed: int, count: int) -> Iterator[bytes]:
    """The bytes with something changed, ``count`` times."""
    rng = np.random.default_rng(seed)
    words = [
        *(b"", b"-1", b"0", b"nan", b"inf", b"1e999", b"99999999999999999999", b"null", b"true"),
        *(b'"', b"[", b"{", b"}", b",", b"\n", b"\r", b"\0", b"\xff", b"\x1b[31m", b"-", b"x"),
    ]
    for _ in range(count):
        made = bytearray(data)
        for _ in range(rng.integers(1, 4)):
            at = int(rng.integers(0, len(made) + 1))
            length = int(rng.choice([1, 1, 2, 4, 8, 40]))
            way = rng.integers(0, 7)
            if way == 0:  # one bit
                if at < len(made):
                    made[at] ^= 1 << int(rng.integers(0, 8))
            elif way == 1:
                made[at : at + length] = rng.integers(0, 256, length, np.uint8).tobytes()
            elif way == 2:
                del made[at : at + length]
            elif way == 3:
                made[at:at] = made[at : at + length]
            elif way == 4 and rng.random() < 0.3:
                del made[at:]
            elif way == 5:
                made[at : at + length] = rng.choice([b"\0", b"\xff", b"\x7f", b"\x80"]) * length
            else:
                made[at : at + length] = words[rng.integers(len(words))]
        yield bytes(made)


def changed_values(text: str, seed: int, count: int) -> Iterator[bytes]:
    """JSON with values changed or gone, ``count`` times."""
    rng = np.random.default_rng(seed)
    values = [
        None,
        True,
        -1,
        0,
        1 << 70,
        1e300,
        0.5,
        "",
        "x",
        "\x1b[31m",
        [],
        {},
        [1],
        [[]],
        {"a": 1},
    ]
    for _ in range(count):
        document = json.loads(text)
        places = list(_places(document))
        holder, key = places[rng.integers(len(places))]
        if rng.random() < 0.25:
            del holder[key]
        else:
            holder[key] = values[rng.integers(len(values))]
        yield json.dumps(document).encode()


def _places(value: Any) -> Iterator[tuple[Any, Any]]:
    inside = value.items() if isinstance(value, dict) else enumerate(value)
    for key, one in list(inside):
        yield value, key
        if isinstance(one, (dict, list)):
            yield from _places(one)


def _rendered(ending: str, **more: Any) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        write_gltf(folder / "scene.gltf")
        omma.save_eye(folder / "bug.csv", make_eye(5))
        (folder / "path.csv").write_text(
            "x,y,z,yaw_deg,pitch_deg,roll_deg\n0,1,0,0,0,0\n1,1,0,9,0,0\n"
        )
        path = folder / f"seen{ending}"
        omma.render_file(
            folder / "scene.gltf", path, omma.Fixed(2), eyes=folder / "bug.csv",
            path=folder / "path.csv", **more
        )  # fmt: skip
        return path

    return make


def _read_results(path: Path) -> None:
    load_responses(path)
    with contextlib.suppress(omma.Error):
        describe_responses(path)
    if path.suffix != ".csv":
        omma.job.render_like(path, path.with_name("again.npy"))


def _text(name: str, text: str) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        (folder / name).write_text(text)
        return folder / name

    return make


def _eye_file(name: str) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        omma.save_eye(folder / name, make_eye(6))
        return folder / name

    return make


def _job(folder: Path) -> Path:
    return write_job(folder / "job", count=2)


def _store(folder: Path) -> Path:
    store = folder / "made.zarr"
    omma.datasets.run(write_job(folder / "job", count=5), store)
    return store


def _read_store(store: Path) -> None:
    for read in (
        lambda: omma.datasets.describe(store),
        lambda: omma.datasets.open_views(store)[0:2],
        lambda: omma.datasets.verify(store),
        lambda: omma.datasets.run(store.parent / "job" / "job.toml", store),
    ):
        with contextlib.suppress(omma.Error):
            read()


class _CutOffError(Exception):
    pass


def _resumed(folder: Path, progress: Any = None) -> None:
    omma.render_file(
        folder / "scene.gltf", folder / "seen.npy", omma.Fixed(2), eyes=folder / "bug.csv",
        path=folder / "path.csv", noise="new_every_frame", resume=True, progress=progress
    )  # fmt: skip


def _cut_off(folder: Path) -> Path:
    write_gltf(folder / "scene.gltf")
    omma.save_eye(folder / "bug.csv", make_eye(5))
    poses = "".join(f"{k},1,0,0,0,0\n" for k in range(30))
    (folder / "path.csv").write_text("x,y,z,yaw_deg,pitch_deg,roll_deg\n" + poses)
    pieces = []

    def progress(stage: str, fraction: float | None) -> None:
        pieces.extend([stage] if stage == "Writing" else [])
        if len(pieces) == 3:
            raise _CutOffError

    with contextlib.suppress(_CutOffError):
        _resumed(folder, progress)
    shutil.copy(folder / "seen.npy.partial", folder / "kept")
    return folder / "seen.npy.resume"


def _resume(record: Path) -> None:
    folder = record.parent
    shutil.copy(folder / "kept", folder / "seen.npy.partial")
    _resumed(folder)


def _scan(folder: Path) -> Path:
    lines = ["x,y,z,anatomical_axis,approx_axis,lens_area,label"]
    rng = np.random.default_rng(3)
    for k in range(20):
        x, y, z = rng.normal(size=3) * 100
        axis = f"[{-x:.4f}, {-y:.4f}, {-z:.4f}]"
        lines.append(f'{x:.3f},{y:.3f},{z:.3f},"{axis}","{axis}",300,{k + 1}')
    return _text("ommatidial_data.csv", "\n".join(lines) + "\n")(folder)


def _points(folder: Path) -> Path:
    rng = np.random.default_rng(4)
    rows = [f"{x:.3f},{y:.3f},{z:.3f},um" for x, y, z in rng.normal(size=(14, 3)) * 100]
    return _text("lenses.csv", "Position X,Position Y,Position Z,Unit\n" + "\n".join(rows))(folder)


def _read_points(path: Path) -> None:
    from omma.eye.scan_tables import read_points

    read_points(path, "lenses", None)


_MAP = "p,q,x,y,z,side\n" + "".join(
    f"{p},{q},{0.9},{p / 9},{q / 9},{side}\n"
    for side in ("left", "right") for p in range(3) for q in range(3)
)  # fmt: skip
_JSON_MAP = json.dumps(
    {"left": [{"p": p, "q": q, "azimuth": -20 - p, "elevation": q} for p in (0, 1) for q in (0, 1)]}
)
_ANGLES = "azimuth_deg,elevation_deg,dphi_h_deg\n0,0,1\n90,0,2\n0,45,1\n90,45,2\n"
_PROFILE = "angle_deg,sensitivity\n0,1\n1,0.5\n2,0.1\n3,0\n"
_EYE = "0 0 0 0 0 1 0.1 0\n0 0 0 0 1 0 0.1 0\n"


def _image(folder: Path) -> Path:
    omma.save_png(folder / "sky.png", np.full((2, 4, 3), 90, np.uint8))
    return folder / "sky.png"


def _gltf(folder: Path) -> Path:
    return write_gltf(folder / "scene.gltf")


def _read_scene(path: Path) -> None:
    from omma.job.info import describe_file

    describe_file(path)


ALL = {
    "npy": Kind(_rendered(".npy"), _read_results, needs=("xarray",)),
    "npy.json": Kind(_rendered(".npy"), _read_results, "seen.json", needs=("xarray",)),
    "nc": Kind(_rendered(".nc"), _read_results, needs=("xarray", "h5netcdf", "h5py")),
    "csv": Kind(_rendered(".csv"), _read_results, needs=("xarray",)),
    "parquet": Kind(_rendered(".parquet"), _read_results, needs=("xarray", "pyarrow")),
    "zarr": Kind(
        _rendered(".zarr"), _read_results, "seen.zarr/zarr.json", needs=("zarr", "xarray")
    ),
    "zarr array": Kind(
        _rendered(".zarr"), _read_results, "seen.zarr/response/zarr.json", needs=("zarr", "xarray")
    ),
    "zarr chunk": Kind(
        _rendered(".zarr"), _read_results, "seen.zarr/response/c/0/0/0", needs=("zarr", "xarray")
    ),
    "job": Kind(_job, omma.datasets.load_job),
    "store": Kind(_store, _read_store, "made.zarr/zarr.json", needs=("zarr",)),
    "store record": Kind(_store, _read_store, "made.zarr/omma/done/00000000.json", needs=("zarr",)),
    "store array": Kind(_store, _read_store, "made.zarr/response/zarr.json", needs=("zarr",)),
    "store shard": Kind(_store, _read_store, "made.zarr/response/c.0.0.0", needs=("zarr",)),
    "resume": Kind(_cut_off, _resume),
    "eye": Kind(_eye_file("bug.eye"), omma.load_eye),
    "eye csv": Kind(_eye_file("bug.csv"), omma.load_eye),
    "eye gltf": Kind(_eye_file("bug.gltf"), omma.load_eye),
    "eye to convert": Kind(_text("old.eye", _EYE), omma.eye.convert_eye),
    "poses": Kind(
        _text("path.csv", "x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,1\n1,0,0,0,1,0,0\n"), omma.load_poses
    ),
    "columns csv": Kind(_text("map.csv", _MAP), omma.columns.load_columns),
    "columns json": Kind(_text("map.json", _JSON_MAP), omma.columns.load_columns),
    "angles": Kind(_text("angles.csv", _ANGLES), omma.eye.angles.load_angle_table),
    "acceptance": Kind(_text("profile.csv", _PROFILE), omma.eye.load_acceptance),
    "scan": Kind(_scan, omma.eye.scans.import_oda),
    "points": Kind(_points, _read_points),
    "panorama": Kind(_image, lambda path: omma.light.panorama(path, ultraviolet="dark")),
    "scene": Kind(_gltf, _read_scene),
}


def foreign(kind: Kind, made: Path, data: bytes) -> BaseException | None:
    """What is raised of a file of those bytes that is no omma.Error."""
    target = made.parent / kind.changed if kind.changed else made
    target.write_bytes(data)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            kind.read(made)
        except omma.Error:
            return None
        except Exception as error:
            return error
    return None
