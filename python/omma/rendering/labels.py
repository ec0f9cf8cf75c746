"""What the numbers of a render mean: their dimensions, coordinates, units, and what they were made
of.

One description for all who hand responses on: `Renderer.dataset` and every format of file.
"""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Eye
from omma.base.backend_names import backend_record
from omma.base.directions import azimuth_elevation_deg_of
from omma.base.files import digests_of
from omma.base.poses import Matrices
from omma.receptors.sensitivity import ommatidium_of_receptor, receptor_axis
from omma.rendering.call import Prepared
from omma.rendering.settings import ToError, settings_as_record
from omma.scene.world import World

# name: (dimensions, values, attributes)
Variables = dict[str, tuple[tuple[str, ...], NDArray[Any], dict[str, Any]]]

RADIANCE = "radiance weighted by angular sensitivity; an even surround of radiance 1 gives 1"
CATCH = "of the receptor's sensitivity; white light of radiance 1 gives 1 over all wavelengths"


@dataclass(frozen=True)
class Labels:
    """What responses (P, N, C), or (P, R) of receptors, mean."""

    coordinates: Variables
    attributes: dict[str, Any]  # texts and numbers, which every format can hold
    variables: dict[str, tuple[tuple[str, ...], str, dict[str, Any]]]
    """Of what is rendered: dimensions, dtype and attributes of response, standard_error, rays."""
    sizes: dict[str, int]  # of each dimension

    @property
    def times_s(self) -> NDArray[np.float64] | None:
        """When each pose is (P,), where that is known."""
        return self.coordinates["time"][1] if "time" in self.coordinates else None

    def shape(self, variable: str) -> tuple[int, ...]:
        """Of one of the variables."""
        return tuple(self.sizes[dimension] for dimension in self.variables[variable][0])


# All that files of a render may hold, variables and coordinates.
WRITTEN = frozenset(
    (
        *("response", "standard_error", "rays", "camera_distance", "camera_angle"),
        *("time", "pose", "ommatidium", "receptor", "band", "wavelength", "eye", "type"),
        *("azimuth", "elevation", "acceptance_angle", "peak_wavelength"),
        *("world_from_head", "position", "quaternion", "axis", "component", "row", "column"),
    )
)
# Bands of worlds without light.
RGB = ("red", "green", "blue")
# Of spectral radiance in a lit world.
_UNITS = {"photons": "photons m-2 s-1 sr-1 nm-1", "watts": "W m-2 sr-1 nm-1"}


def labels_of(
    renderer: Prepared,
    matrices: Matrices,
    *,
    receptors: bool = False,
    standard_error: bool = False,
    with_cameras: bool = False,
    time_s: NDArray[np.float64] | None = None,
    more: dict[str, Any] | None = None,
    first_pose: int | None = None,
) -> Labels:
    """Labels of what a renderer makes of poses (P, 4, 4), ``with_cameras`` also of how near cameras
    of the capture were; ``first_pose`` is the number of the first frame, told where noise is
    new in every frame; ``more`` attributes come last."""
    first = "pose" if time_s is None else "time"
    light = renderer.world.light
    coordinates: Variables = {}
    if time_s is not None:
        coordinates["time"] = ((first,), time_s, {"units": "s"})
    dimensions: tuple[str, ...]
    if receptors:
        dimensions = (first, "receptor")
        coordinates |= _receptors(renderer.eye)
    else:
        dimensions = (first, "ommatidium", "band")
        coordinates |= _ommatidia(renderer.eye)
        coordinates["band"] = (("band",), np.array(band_names(renderer.world)), {})
        if light is not None:
            coordinates["wavelength"] = (("band",), light.bands.centers_nm, {"units": "nm"})
    coordinates |= pose_variables(matrices, first)
    unit = unit_of(renderer.world)
    about = {"units": unit, "long_name": CATCH if receptors else RADIANCE}
    variables: dict[str, tuple[tuple[str, ...], str, dict[str, Any]]] = {
        "response": (dimensions, "float32", about)
    }
    to_error = isinstance(renderer.settings.sampling, ToError)
    if standard_error or to_error:
        variables["standard_error"] = (dimensions, "float32", {"units": unit})
    if to_error:
        variables["rays"] = (dimensions[:2], "int32", {"long_name": "rays spent"})
    if with_cameras:
        variables |= camera_variables(first)
    sizes = {
        name: len(values) for name, (along, values, _) in coordinates.items() if along == (name,)
    }
    sizes[first] = len(matrices)
    attributes = _attributes(renderer)
    if first_pose is not None and not renderer.settings.is_noise_frozen:
        attributes["first_pose"] = first_pose
    return Labels(coordinates, attributes | (more or {}), variables, sizes)


def camera_variables(first: str) -> dict[str, tuple[tuple[str, ...], str, dict[str, Any]]]:
    """How near cameras of a capture were: dimensions, dtype and attributes, by variable; ``first``
    is the dimension of poses."""
    about = {
        "camera_distance": {
            "units": "m", "long_name": "from the head to the nearest camera of the capture",
        },
        "camera_angle": {
            "units": "degree",
            "long_name": "least angle to a camera of the capture at what is seen",
        },
    }  # fmt: skip
    return {
        "camera_distance": ((first,), "float64", about["camera_distance"]),
        "camera_angle": ((first, "ommatidium"), "float32", about["camera_angle"]),
    }


def quaternions_of(matrices: Matrices) -> NDArray[np.float64]:
    """Unit quaternions (P, 4), in the order x, y, z, w and with w at least 0, of poses (P, 4, 4).

    Of poses that scale or mirror, the turn that is nearest.
    """
    from scipy.spatial.transform import Rotation

    u, _, v = np.linalg.svd(matrices[:, :3, :3])
    u[..., -1] *= np.linalg.det(u @ v)[:, None]
    quaternions = Rotation.from_matrix(u @ v).as_quat()
    return np.asarray(np.where(quaternions[:, 3:] < 0, -quaternions, quaternions))


def eye_digest(eye: Eye) -> str:
    """SHA-256 of all that an eye is: of its CSV file, which keeps everything to the last bit."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "eye.csv")
        _core.save_eye(path, eye, 1.0, False)
        return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def pose_variables(matrices: Matrices, first: str) -> Variables:
    """Where the head is at each pose, and how it is turned: in full, and as position and
    rotation."""
    head = "of the head in the world"
    return {
        "world_from_head": (
            (first, "row", "column"),
            matrices,
            {"long_name": "the pose, in full: what scales or mirrors too; lengths in m"},
        ),
        "position": ((first, "axis"), matrices[:, :3, 3], {"units": "m", "long_name": head}),
        "axis": (("axis",), np.array(list("xyz")), {}),
        "quaternion": (
            (first, "component"),
            quaternions_of(matrices),
            {"long_name": "turns directions of the head into those of the world"},
        ),
        "component": (("component",), np.array(list("xyzw")), {}),
        "row": (("row",), np.arange(4), {}),
        "column": (("column",), np.arange(4), {}),
    }


def _directions(dimension: str, axis: ArrayLike) -> Variables:
    azimuth, elevation = azimuth_elevation_deg_of(axis)
    where = "in the head: 0 ahead, right positive"
    return {
        "azimuth": ((dimension,), azimuth, {"units": "degree", "long_name": where}),
        "elevation": ((dimension,), elevation, {"units": "degree", "long_name": "up positive"}),
    }


def _ommatidia(eye: Eye) -> Variables:
    return {
        "ommatidium": (("ommatidium",), np.arange(len(eye)), {}),
        "eye": (("ommatidium",), eye.eye_id, {"long_name": "which eye of the head"}),
        **_directions("ommatidium", eye.axis),
        "acceptance_angle": (
            ("ommatidium",),
            np.degrees(eye.acceptance_angle_rad.astype(np.float64)),
            {"units": "degree", "long_name": "full width at half maximum"},
        ),
    }


def _receptors(eye: Eye) -> Variables:
    known = eye.receptor_types
    types = [known[k] for k in eye.receptor_type.tolist()]
    ommatidium = ommatidium_of_receptor(eye)
    return {
        "receptor": (("receptor",), np.arange(len(types)), {}),
        "ommatidium": (("receptor",), ommatidium, {}),
        "eye": (("receptor",), eye.eye_id[ommatidium], {"long_name": "which eye of the head"}),
        "type": (("receptor",), np.array([one.name for one in types], dtype=np.str_), {}),
        "peak_wavelength": (
            ("receptor",),
            np.array([one.peak_wavelength_nm for one in types], dtype=np.float64),
            {"units": "nm"},
        ),
        **_directions("receptor", receptor_axis(eye)),
    }


def band_names(world: World) -> list[str]:
    """Names of a world's bands in files: in light the middle of each, in nm."""
    if world.light is not None:
        return [f"{nm:g} nm" for nm in np.round(world.light.bands.centers_nm, 2)]
    if world.band_from_rgb is None:
        return list(RGB)
    return [f"band_{k}" for k in range(world.bands)]


def unit_of(world: World) -> str:
    """Of responses in a world, "1" of those that are relative."""
    return "1" if world.light is None else _UNITS[world.light.unit]


def _attributes(renderer: Prepared) -> dict[str, Any]:
    """What the responses were made of, as plain texts and numbers that every format can hold."""
    scene = renderer.world.scene
    light = renderer.world.light
    of_what = "relative to radiance 1" if light is None else f"in {unit_of(renderer.world)}"
    found: dict[str, Any] = {
        "units": f"lengths m, angles degree, wavelengths nm; responses {of_what}",
        "created": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "omma_version": _core.__version__,
        **backend_record(renderer.backend),
        **settings_as_record(renderer.settings),
        "eye": renderer.eye.path,
        "eye_sha256": eye_digest(renderer.eye),
        "scene": scene.path,
    }
    if scene.path and os.path.exists(scene.path):
        found["scene_sha256"] = json.dumps(digests_of(scene.path), sort_keys=True)
    if light is not None:
        depth = renderer.world.depth
        found["light"] = repr(light)
        found["depth"] = "no limit" if depth is None else depth
        found["polarized"] = int(renderer.world.polarized)
    if renderer.world.band_from_rgb is not None:
        found["band_from_rgb"] = json.dumps(renderer.world.band_from_rgb.tolist())
    if scene.warnings:
        found["scene_warnings"] = "\n".join(scene.warnings)
    return found
