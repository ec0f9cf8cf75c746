"""Responses as an `xarray.Dataset`: with their places, their units and what they were made of.

Needs xarray, an optional extra, which is imported only here and only when a dataset is made.
"""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Error, Eye
from omma.base.arguments import array_of
from omma.base.directions import azimuth_elevation_deg_of
from omma.base.files import digests_of
from omma.base.poses import Matrices
from omma.receptors.sensitivity import ommatidium_of_receptor, receptor_axis
from omma.rendering.settings import ToError, settings_as_record

if TYPE_CHECKING:
    import xarray

    from omma.rendering.renderer import Poses, Progress, Renderer

Variables = dict[str, tuple[Any, ...]]  # name: (dimensions, values, attributes)

RADIANCE = "radiance weighted by angular sensitivity; an even surround of radiance 1 gives 1"
CATCH = "of the receptor's sensitivity; white light of radiance 1 gives 1 over all wavelengths"


def make_dataset(
    renderer: Renderer,
    poses: Poses,
    *,
    receptors: bool,
    ultraviolet: ArrayLike | None,
    standard_error: bool,
    time_s: ArrayLike | None,
    first_pose: int | None,
    progress: Progress | None,
) -> xarray.Dataset:
    """What `Renderer.dataset` does, whose arguments these are."""
    made = load_xarray()
    if ultraviolet is not None and not receptors:
        raise Error("ultraviolet: is for receptors=True")
    matrices = renderer._matrices(poses)
    first = "pose" if time_s is None else "time"
    coordinates: Variables = {}
    if time_s is not None:
        times = array_of(time_s, "time_s", (len(matrices),))
        coordinates["time"] = (first, times, {"units": "s"})

    options: dict[str, Any] = {"first_pose": first_pose, "progress": progress}
    rays = errors = None
    if receptors:
        dimensions: tuple[str, ...] = (first, "receptor")
        coordinates |= _receptors(renderer.eye)
        options |= {"ultraviolet": ultraviolet, "standard_error": standard_error}
        found: Any = renderer.render_receptors(matrices, **options)
    else:
        dimensions = (first, "ommatidium", "band")
        coordinates |= _ommatidia(renderer.eye)
        coordinates["band"] = ("band", _band_names(renderer), {})
        auto = isinstance(renderer.settings.sampling, ToError)
        options |= {"report": True} if auto else {"standard_error": standard_error}
        found = renderer.render(matrices, **options)
        if auto:
            found, rays, errors = found[0], found[1].rays, found[1].standard_error
    if isinstance(found, tuple):
        found, errors = found
    coordinates |= _places(matrices, first)  # now that the engine has accepted the poses

    about = {"units": "1", "long_name": CATCH if receptors else RADIANCE}
    variables: Variables = {"response": (dimensions, found, about)}
    if errors is not None:
        variables["standard_error"] = (dimensions, errors, {"units": "1"})
    if rays is not None:
        variables["rays"] = (dimensions[:2], rays, {"long_name": "rays spent"})
    data: xarray.Dataset = made.Dataset(variables, coordinates, _attributes(renderer))
    return data


def load_xarray() -> Any:
    """The package xarray; omma.Error where it is not installed."""
    try:
        import xarray
    except ImportError:
        raise Error(
            "datasets need xarray, which is not installed: pip install 'omma[data]'"
        ) from None
    return xarray


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


def _places(matrices: Matrices, first: str) -> Variables:
    """Where the head is at each pose, and how it is turned."""
    head = "of the head in the world"
    return {
        "position": ((first, "axis"), matrices[:, :3, 3], {"units": "m", "long_name": head}),
        "axis": ("axis", list("xyz"), {}),
        "quaternion": (
            (first, "component"),
            quaternions_of(matrices),
            {"long_name": "turns directions of the head into those of the world"},
        ),
        "component": ("component", list("xyzw"), {}),
    }


def _directions(dimension: str, axis: ArrayLike) -> Variables:
    azimuth, elevation = azimuth_elevation_deg_of(axis)
    where = "in the head: 0 ahead, right positive"
    return {
        "azimuth": (dimension, azimuth, {"units": "degree", "long_name": where}),
        "elevation": (dimension, elevation, {"units": "degree", "long_name": "up positive"}),
    }


def _ommatidia(eye: Eye) -> Variables:
    return {
        "ommatidium": ("ommatidium", np.arange(len(eye)), {}),
        "eye": ("ommatidium", eye.eye_id, {"long_name": "which eye of the head"}),
        **_directions("ommatidium", eye.axis),
        "acceptance_angle": (
            "ommatidium",
            np.degrees(eye.acceptance_angle_rad.astype(np.float64)),
            {"units": "degree", "long_name": "full width at half maximum"},
        ),
    }


def _receptors(eye: Eye) -> Variables:
    types = [eye.receptor_types[k] for k in eye.receptor_type.tolist()]
    ommatidium = ommatidium_of_receptor(eye)
    return {
        "receptor": ("receptor", np.arange(len(types)), {}),
        "ommatidium": ("receptor", ommatidium, {}),
        "eye": ("receptor", eye.eye_id[ommatidium], {"long_name": "which eye of the head"}),
        "type": ("receptor", [one.name for one in types], {}),
        "peak_wavelength": (
            "receptor",
            [one.peak_wavelength_nm for one in types],
            {"units": "nm"},
        ),
        **_directions("receptor", receptor_axis(eye)),
    }


def _band_names(renderer: Renderer) -> list[str]:
    if renderer.world.band_from_rgb is None:
        return ["red", "green", "blue"]
    return [f"band_{k}" for k in range(renderer.bands)]


def _attributes(renderer: Renderer) -> dict[str, Any]:
    """What the responses were made of, as plain texts and numbers that every format can hold."""
    scene = renderer.world.scene
    found: dict[str, Any] = {
        "omma_version": _core.__version__,
        "backend": renderer.backend,
        **settings_as_record(renderer.settings),
        "eye": renderer.eye.path,
        "eye_sha256": eye_digest(renderer.eye),
        "scene": scene.path,
    }
    if scene.path and os.path.exists(scene.path):
        found["scene_sha256"] = json.dumps(digests_of(scene.path), sort_keys=True)
    if renderer.world.band_from_rgb is not None:
        found["band_from_rgb"] = json.dumps(renderer.world.band_from_rgb.tolist())
    return found
