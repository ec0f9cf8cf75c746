"""A method of `omma.Renderer`: responses as an `xarray.Dataset`, with coordinates, units and what
they were made of.

Needs xarray, an optional extra, which is imported only here and only when a dataset is made.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of, checked
from omma.base.optional import needs
from omma.base.poses import Matrices
from omma.base.progress import Progress
from omma.rendering.call import Call, Frames, Poses, Prepared, poses_of
from omma.rendering.labels import Labels, Variables, labels_of
from omma.rendering.moves import Moves, MovesOptions, renderer_method
from omma.rendering.receptor_frames import frames_of_receptors
from omma.rendering.settings import ToError
from omma.rendering.truth import GroundTruth, check_truth, truth_variables
from omma.rendering.without_polarisation import tell_without_polarisation

if TYPE_CHECKING:
    import xarray
    from typing_extensions import Unpack


@checked
@renderer_method
def dataset(
    self: Prepared,
    poses: Poses,
    *,
    receptors: bool = False,
    ultraviolet: ArrayLike | None = None,
    standard_error: bool = False,
    time_s: ArrayLike | None = None,
    truth: GroundTruth | None = None,
    first_pose: int | None = None,
    progress: Progress | None = None,
    **moves: Unpack[MovesOptions],
) -> xarray.Dataset:
    """Responses as an `xarray.Dataset`, which says what its numbers are.

    Dimensions: ``pose`` (or ``time``), then ``ommatidium`` and ``band``, or ``receptor``.
    Coordinates: position (m) and quaternion (x, y, z, w) of the head, azimuth and elevation
    (degrees, in the head), acceptance angle, eye; of receptors also type, peak wavelength (nm)
    and ommatidium.
    Variables: ``response``, ``standard_error`` where asked for, ``rays`` with `ToError`;
    ``world_from_thing`` (pose, thing, 4, 4) of what ``transforms`` move, by name, with
    ``instance_index``, that in `World.instances`.
    Attributes: Omma's version, backend, settings, hashes (SHA-256) of the eye and of the
    scene's files as they are now.

    Args:
        poses, standard_error, first_pose, progress: as of `render`. With `ToError` there
            are always standard errors.
        receptors: what receptors answer, as `render_receptors` says, instead of bands.
        ultraviolet: as of `render_receptors`.
        time_s: (P,), when each pose is, s: the first dimension is then ``time``. None:
            ``times_s``, where these are given.
        truth: what `ground_truth` gave for these poses. Its responses are taken, nothing is
            rendered; each of its arrays is a variable, with ``axis`` (x, y, z), ``direction``
            (right, up) or ``instance`` behind ``ommatidium``.
        instances, transforms, times_s, animation: as of `render`.

    Raises:
        omma.Error: what `render` and `render_receptors` raise; ``truth`` of other poses, of
            another eye or of another world; no xarray (``omma[data]``).
    """
    load_xarray()
    if ultraviolet is not None and not receptors:
        raise Error("ultraviolet: is for receptors=True")
    when = moves.get("times_s") if time_s is None else time_s
    if truth is None:
        call = Call.of(self, poses, moves, first_pose, progress)
        times = _times(when, call.poses)
        if receptors:
            tell_without_polarisation(self.world, self._receptor_views()[0].most_polarisation)
            frames = frames_of_receptors(call, None, ultraviolet, standard_error)
        else:
            to_error = isinstance(self.settings.sampling, ToError)
            frames = call.render(
                call.new_frames(standard_error=standard_error or to_error, rays=to_error)
            )
        return _labelled(self, call.poses, times, frames, call.moves, receptors)
    if receptors or standard_error:
        raise Error("truth: not together with receptors or standard_error")
    matrices = poses_of(self, poses)
    times = _times(when, matrices)
    check_truth(truth, matrices, self)
    frames = Frames(truth.responses, truth.standard_error, truth.rays)
    moving: MovesOptions = {
        "instances": moves.get("instances"), "transforms": moves.get("transforms")
    }  # fmt: skip
    data = _labelled(self, matrices, times, frames, Moves(self.world, matrices, moving, None))
    first = "pose" if times is None else "time"
    with_truth: xarray.Dataset = data.assign(truth_variables(truth, (first, "ommatidium")))
    return with_truth


def _times(time_s: ArrayLike | None, matrices: Matrices) -> NDArray[np.float64] | None:
    return None if time_s is None else array_of(time_s, "time_s", (len(matrices),))


def _labelled(
    renderer: Prepared,
    matrices: Matrices,
    times: NDArray[np.float64] | None,
    frames: Frames,
    moves: Moves,
    receptors: bool = False,
) -> xarray.Dataset:
    """Frames that were rendered, as labels need poses that the engine has accepted."""
    labels = labels_of(
        renderer,
        matrices,
        receptors=receptors,
        standard_error=frames.standard_error is not None,
        time_s=times,
    )
    values = {
        "response": frames.responses, "standard_error": frames.standard_error, "rays": frames.rays
    }  # fmt: skip
    data = dataset_of(labels, values)
    things = _things(moves, "pose" if times is None else "time")
    with_things: xarray.Dataset = data.assign(things) if things else data
    return with_things


def _things(moves: Moves, first: str) -> Variables:
    """Where things were that transforms have moved; nothing where none have."""
    names, indices, matrices = moves.things()
    if not names:
        return {}
    about = {"long_name": "where each thing that was moved is in the world; lengths in m"}
    return {
        "thing": (("thing",), np.array(names, dtype=np.str_), {}),
        "instance_index": (("thing",), indices, {"long_name": "of the thing among all"}),
        "world_from_thing": ((first, "thing", "row", "column"), matrices, about),
    }


def dataset_of(labels: Labels, values: dict[str, Any]) -> xarray.Dataset:
    """The dataset of labels and the values of their variables."""
    variables = {
        name: (dimensions, values[name], attributes)
        for name, (dimensions, _, attributes) in labels.variables.items()
    }
    data: xarray.Dataset = load_xarray().Dataset(variables, labels.coordinates, labels.attributes)
    return data


def load_xarray() -> Any:
    """The package xarray; omma.Error where it is not installed."""
    return needs("xarray", "data", "datasets need xarray")
