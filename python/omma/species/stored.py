"""The grown eyes of the animals as data of the package, so that nobody waits for them to grow.

Growing a lattice takes up to a minute. `omma.species.build` does it; scripts/make_species.py
writes what comes out into data/, a file for each animal, and here it is read, to the same bits.
"""

from __future__ import annotations

import hashlib
import io
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Acceptance, Error, Eye, ReceptorType
from omma.base.files import PathLike, write_whole
from omma.species.facts import LATIN, facts
from omma.species.species import Species
from omma.species.stored_files import open_stored

Arrays = dict[str, NDArray[Any]]

# The numbers that an Acceptance and a ReceptorType are made of again.
_OPTICS = (
    "width_parameter_rad",
    "minor_width_rad",
    "major_angle_rad",
    "facet_diameter_m",
    "focal_length_m",
    "rhabdom_diameter_m",
    "wavelength_nm",
    "rhabdom_index",
    "surround_index",
)
_RECEPTOR = (
    "peak_wavelength_nm",
    "microvillus_angle_rad",
    "polarisation_sensitivity",
    "absorption_per_m",
    "length_m",
    "right_rad",
    "up_rad",
)


def stored(name: str) -> Species:
    """The animal whose eyes are kept in the package."""
    with open_stored(name) as z:
        return Species(name, LATIN[name], _eye(dict(z)), facts(name))


@cache
def stored_axes(name: str) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Axes (N, 3) and eyes (N,) of the animal's ommatidia alone, in a tenth of the time."""
    with open_stored(name) as z:
        axis = z["axis"]
        if z["mirrored"]:
            axis = np.concatenate([_mirrored(axis), axis])
        return axis, z["eye_id"].astype(np.int32)


def stored_numbers(name: str) -> str:
    """What `numbers_digest` was when the animal's eyes were made."""
    with open_stored(name) as z:
        return str(z["numbers"])


def numbers_digest() -> str:
    """A digest of all numbers of facts.csv but times, which no eye is grown from: it changes when
    the eyes must be made anew."""
    text = "\n".join(
        f"{f.animal},{f.quantity},{f.value!r},{f.unit}" for f in facts() if f.unit != "ms"
    )
    return hashlib.sha256(text.encode()).hexdigest()


def store(path: PathLike, head: Eye) -> None:
    """Writes a head as `stored` reads it."""
    compressed = io.BytesIO()
    np.savez_compressed(compressed, **_arrays(head))  # type: ignore[arg-type]
    write_whole(path, compressed.getvalue())


def _arrays(head: Eye) -> Arrays:
    if (
        (head.acceptance_of < 0).any()
        or head.focal_offset_m.any()
        or head.aperture_diameter_m.any()
    ):
        raise Error("head: expected an Acceptance for all, no focal offset and no aperture")
    geometry: Arrays = {
        "position_m": head.position_m,
        "axis": head.axis,
        "facet_diameter_m": head.facet_diameter_m,
        "acceptance_of": head.acceptance_of.astype(np.uint8),
    }
    if not np.array_equal(head.replace(up=None).up, head.up):
        geometry["up"] = head.up
    # Of a left eye that is the mirror image only the right one is kept.
    left, right = (np.flatnonzero(head.eye_id == side) for side in (0, 1))
    pairs = {name: (values[left], values[right]) for name, values in geometry.items()}
    mirrored = all(np.array_equal(_mirrored(one), other) for one, other in pairs.values())
    if mirrored:
        geometry = {name: other for name, (_, other) in pairs.items()}
    texts: Arrays = {}
    for name, values in head.columns.items():
        kinds, index = np.unique(values, return_inverse=True)
        texts |= {f"kinds_{name}": kinds, f"kind_of_{name}": index.astype(np.uint8)}
    types = head.receptor_types
    return {
        "numbers": np.array(numbers_digest()),
        "mirrored": np.array(mirrored),
        "eye_id": head.eye_id.astype(np.uint8),
        "kernel": np.array([one.kernel for one in head.acceptances]),
        "optics": np.array([[getattr(one, name) for name in _OPTICS] for one in head.acceptances]),
        "receptor_name": np.array([one.name for one in types], np.str_),
        "receptor": np.array([[getattr(one, name) for name in _RECEPTOR] for one in types]),
        "receptor_type": head.receptor_type.astype(np.uint16),
        "receptor_count": np.diff(head.first_receptor).astype(np.uint8),
        "columns": np.array(list(head.columns)),
        **geometry,
        **texts,
    }


def _mirrored(values: NDArray[Any]) -> NDArray[Any]:
    # Vectors (N, 3) with x turned round; numbers (N,) as they are.
    return values * np.array([-1, 1, 1], values.dtype) if values.ndim == 2 else values


def _eye(z: Arrays) -> Eye:
    geometry: dict[str, Any] = {
        name: np.concatenate([_mirrored(z[name]), z[name]]) if z["mirrored"] else z[name]
        for name in ("position_m", "axis", "facet_diameter_m", "acceptance_of", "up")
        if name in z
    }
    acceptances = [
        _acceptance(kernel, dict(zip(_OPTICS, numbers)))
        for kernel, numbers in zip(z["kernel"].tolist(), z["optics"].tolist())
    ]
    types = [
        ReceptorType(name, **dict(zip(_RECEPTOR, numbers)))
        for name, numbers in zip(z["receptor_name"].tolist(), z["receptor"].tolist())
    ]
    # As rows of arrays, which the engine takes ten times as fast as lists.
    of_all, counts = z["receptor_type"].astype(np.int32), z["receptor_count"]
    receptors: Any = None
    if len(of_all) and (counts == counts[0]).all():
        receptors = of_all.reshape(len(counts), -1)
    elif len(of_all):
        receptors = np.split(of_all, np.cumsum(counts, dtype=np.int64)[:-1])
    columns = {
        name: z[f"kinds_{name}"][z[f"kind_of_{name}"]].tolist() for name in z["columns"].tolist()
    }
    which = geometry.pop("acceptance_of").tolist()
    return Eye(
        geometry.pop("position_m"),
        geometry.pop("axis"),
        acceptance=[acceptances[k] for k in which],
        eye_id=z["eye_id"].astype(np.int32),
        receptor_types=types,
        receptors=receptors,
        columns=columns,
        **geometry,
    )


def _acceptance(kernel: str, numbers: dict[str, float]) -> Acceptance:
    if kernel == "gaussian":
        width, minor = numbers["width_parameter_rad"], numbers["minor_width_rad"]
        return Acceptance.gaussian(width, minor or None, numbers["major_angle_rad"])
    if kernel == "airy":
        return Acceptance.airy(numbers["facet_diameter_m"], numbers["wavelength_nm"])
    return Acceptance.lens_rhabdom(
        numbers["facet_diameter_m"],
        numbers["focal_length_m"],
        numbers["rhabdom_diameter_m"],
        numbers["wavelength_nm"],
        numbers["rhabdom_index"],
        numbers["surround_index"],
    )
