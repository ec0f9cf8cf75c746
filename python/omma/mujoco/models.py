"""What is asked of MuJoCo's models and data before anything is made of them: what they are, names,
data that belong to their model and know where things are.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.optional import needs

# What mj_version() says of 3.3.3, the first in which lights have types and textures colour spaces;
# from 3.10 on it is in millions.
OLDEST = 333

# mjtGeom
PLANE, HEIGHT_FIELD, SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX, MESH, SDF = range(9)

KINDS = (
    "plane", "height field", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "sdf"
)  # fmt: skip

# Kinds whose shape is one of the model's: what it is called there, and how many there are.
SHAPES_IN_MODEL = {
    HEIGHT_FIELD: ("hfield", "nhfield"), MESH: ("mesh", "nmesh"), SDF: ("mesh", "nmesh")
}  # fmt: skip


def mujoco_module() -> ModuleType:
    """MuJoCo's package; omma.Error where it is not installed, or older than what is read here."""
    mujoco: ModuleType = needs("mujoco", "mujoco", "models of MuJoCo need mujoco")
    if mujoco.mj_version() < OLDEST:
        raise Error(
            f"models of MuJoCo need mujoco 3.3.3 or newer, found {mujoco.__version__}: pip install "
            "--upgrade 'omma[mujoco]'"
        )
    return mujoco


def checked_model(model: Any) -> Any:
    """The model, where it is one."""
    if not isinstance(model, mujoco_module().MjModel):
        raise Error(f"model: expected a mujoco.MjModel, found {type(model).__name__}")
    return model


def checked_data(data: Any, model: Any = None) -> Any:
    """The data, where they are some, of that model, and know where things are.

    Args:
        model: whose they must be. None: whosever.
    """
    if not isinstance(data, mujoco_module().MjData):
        raise Error(f"data: expected a mujoco.MjData, found {type(data).__name__}")
    if model is not None and data.model is not model:
        ours, theirs = sizes(model), sizes(data.model)
        if ours != theirs or bytes(model.names) != bytes(data.model.names):
            raise Error(f"data: expected those of the model ({ours}), found another's ({theirs})")
    check_transforms(data.geom_xpos, data.geom_xmat)
    return data


def sizes(model: Any) -> str:
    """A model in a few words, for messages."""
    return f"{model.nbody} bodies, {model.ngeom} geoms, {model.nmesh} meshes"


def check_transforms(position: NDArray[np.float64], matrix: NDArray[np.float64]) -> None:
    """omma.Error where nothing has been computed, or a simulation has diverged."""
    if not (np.isfinite(position).all() and np.isfinite(matrix).all()):
        raise Error("data: expected finite positions, found some that are not: it has diverged")
    if len(matrix) and not np.abs(matrix).reshape(len(matrix), -1).max(axis=1).all():
        raise Error("data: expected positions of geoms, found none: call mujoco.mj_forward first")


def data_at_start(model: Any) -> Any:
    """Data of a model in its reference configuration: where its bodies, cameras and lights are."""
    mujoco = mujoco_module()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_camlight(model, data)
    return data


def names_of(model: Any, kind: str, count: int) -> list[str]:
    """Names of all geoms, cameras, ..., in their order: "geom 12" where the model gives none.

    Args:
        kind: as in the model's ``name_geomadr``.
    """
    text = bytes(model.names)
    addresses = getattr(model, f"name_{_ADDRESS.get(kind, kind)}adr")
    given = [text[at : text.index(b"\0", at)].decode(errors="replace") for at in addresses[:count]]
    names = [name or f"{kind} {index}" for index, name in enumerate(given)]
    twice = {name for name in names if names.count(name) > 1} if len(set(names)) < count else set()
    if twice:
        raise Error(
            f"model: expected names that are not those of unnamed ones, found {kind} "
            f"{min(twice)!r} twice"
        )
    return names


def shape_names(model: Any) -> list[str]:
    """The shape of every geom in words, as "box 0.1 x 0.1 x 0.2": what its meshes are called, by
    which geoms of another model are told."""
    files = {
        kind: names_of(model, what, getattr(model, count))
        for kind, (what, count) in SHAPES_IN_MODEL.items()
    }
    found = []
    for geom in range(model.ngeom):
        kind, index = int(model.geom_type[geom]), int(model.geom_dataid[geom])
        what = KINDS[kind] if 0 <= kind < len(KINDS) else f"type {kind}"
        if kind in files and 0 <= index < len(files[kind]):
            found.append(f"{what} {files[kind][index]}")
        else:
            found.append(f"{what} " + " x ".join(f"{size:.9g}" for size in model.geom_size[geom]))
    return found


def skin_names(model: Any) -> list[str]:
    """Names of instances and meshes of all skins."""
    given = names_of(model, "skin", model.nskin)
    return [name if name == f"skin {k}" else f"skin {name}" for k, name in enumerate(given)]


_ADDRESS = {"camera": "cam", "texture": "tex", "material": "mat"}


def transforms(position: NDArray[np.float64], matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """``world_from_...`` (K, 4, 4) of positions (K, 3) and rotations (K, 9)."""
    found = np.zeros((len(position), 4, 4))
    found[:, :3, :3] = matrix.reshape(-1, 3, 3)
    found[:, :3, 3] = position
    found[:, 3, 3] = 1
    return found
