"""A method of `omma.Renderer`: responses as an `xarray.Dataset`, with coordinates, units and what
they were made of.

Needs xarray, an optional extra, which is imported only here and only when a dataset is made.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import checked
from omma.base.optional import needs
from omma.base.progress import Progress
from omma.rendering.call import Call, Frames, Poses, Prepared, poses_of
from omma.rendering.labels import Labels, Variables, labels_of
from omma.rendering.moves import MovesOptions, Things, renderer_method
from omma.rendering.moves_told import MovesTold, Past
from omma.rendering.receptor_frames import frames_of_receptors
from omma.rendering.settings import ToError
from omma.rendering.truth import GroundTruth, check_truth, origin_of, truth_variables
from omma.rendering.truth_origin import check_origin, moves_of, times_of
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
    ``instance_index``, that in `World.instances`; with ``unseen`` ``unseen_group`` (pose), which
    group of the attribute is not seen, -1 for none; with ``past`` ``past_time_s`` (past) and
    ``past_world_from_head`` (past, 4, 4), and ``past_world_from_thing`` where it told that.
    Attributes: Omma's version, backend, settings, hashes (SHA-256) of the eye and of the
    scene's files as they are now; with noise="new_every_frame" ``first_pose``, the number of the
    first frame, with which `render` gives the same bits again. Where there are such:
    ``at_time_s`` and ``at_animation`` of the last `World.at`, ``animation``, ``unseen`` (JSON: the
    groups, each the indices of its things in `World.instances`) and ``unseen_by_light``.

    Args:
        poses, standard_error, first_pose, progress: as of `render`. With `ToError` there
            are always standard errors.
        receptors: what receptors answer, as `render_receptors` says, instead of bands.
        ultraviolet: as of `render_receptors`.
        time_s: (P,), when each pose is, s: the first dimension is then ``time``. None:
            ``times_s``, where these are given. They may stand still or run backwards, as where
            sequences follow on each other.
        truth: what `ground_truth` gave for these poses. Its responses are taken, nothing is
            rendered. Its first pose's number, times, instances, transforms, animation and what
            was unseen are kept; what is given of them here too must be the same. Each of its arrays
            is a variable, with ``axis`` (x, y, z), ``direction`` (right, up) or ``instance`` behind
            ``ommatidium``.
        instances, transforms, times_s, animation, past, unseen, unseen_by_light: as of `render`.

    Raises:
        omma.Error: what `render` and `render_receptors` raise; ``truth`` of other poses, of
            another eye, world, settings, frames, times, transforms or animation, or with other
            things unseen; ``time_s`` that are not
            finite; no xarray (``omma[data]``).
    """
    load_xarray()
    if ultraviolet is not None and not receptors:
        raise Error("ultraviolet: is for receptors=True")
    when = moves.get("times_s") if time_s is None else time_s
    if truth is None:
        call = Call.of(self, poses, moves, first_pose, progress)
        times = times_of(None, when, len(call.poses))
        if receptors:
            # Of the frames of who renders receptors' views.
            seen_by = self._receptor_views()[1]
            call = replace(replace(call, renderer=seen_by).numbered(), renderer=self)
            tell_without_polarisation(self.world, self._receptor_views()[0].most_polarisation)
            frames = frames_of_receptors(call, None, ultraviolet, standard_error)
        else:
            call = call.numbered()
            to_error = isinstance(self.settings.sampling, ToError)
            frames = call.render(
                call.new_frames(standard_error=standard_error or to_error, rays=to_error)
            )
        told = call.moves.told()
        labels = labels_of(
            self,
            call.poses,
            receptors=receptors,
            standard_error=frames.standard_error is not None,
            time_s=times,
            first_pose=call.first_frame,
            more=told.attributes,
        )
        return _labelled(labels, frames, call.moves.things(), told)
    if receptors:
        raise Error("truth: not together with receptors, which it does not have")
    if standard_error and truth.standard_error is None:
        raise Error(
            "standard_error: truth has none; ground_truth(..., standard_error=True) gives truth "
            "with them"
        )
    origin = origin_of(truth)
    if moves.get("times_s") is None and origin is not None:
        moves["times_s"] = origin.times_s
    matrices = poses_of(self, poses, moves)
    check_truth(truth, matrices, self)
    if origin is not None:
        check_origin(origin, self, first_pose)
    times = times_of(origin, when, len(matrices))
    things, told = moves_of(origin, self, matrices, moves)
    frames = Frames(truth.responses, truth.standard_error, truth.rays)
    labels = labels_of(
        self,
        matrices,
        standard_error=truth.standard_error is not None,
        time_s=times,
        first_pose=first_pose if origin is None else origin.first_pose,
        more=told.attributes,
    )
    data = _labelled(labels, frames, things, told)
    first = "pose" if times is None else "time"
    with_truth: xarray.Dataset = data.assign(truth_variables(truth, (first, "ommatidium")))
    return with_truth


def _labelled(labels: Labels, frames: Frames, things: Things, told: MovesTold) -> xarray.Dataset:
    """Frames that were rendered, as labels need poses that the engine has accepted."""
    values = {
        "response": frames.responses, "standard_error": frames.standard_error, "rays": frames.rays
    }  # fmt: skip
    data = dataset_of(labels, values)
    names, indices, matrices = things
    first = labels.variables["response"][0][0]
    if told.unseen_group is not None:
        of_pose = {"long_name": "which group of the attribute unseen is not seen, -1 for none"}
        data = data.assign({"unseen_group": ((first,), told.unseen_group, of_pose)})
    if told.past is not None:
        data = data.assign(_of_past(told.past))
    if not names:
        return data
    about = {"long_name": "where each thing that was moved is in the world; lengths in m"}
    moved: Variables = {
        "thing": (("thing",), np.array(names, dtype=np.str_), {}),
        "instance_index": (("thing",), indices, {"long_name": "of the thing among all"}),
        "world_from_thing": ((first, "thing", "row", "column"), matrices, about),
    }
    with_things: xarray.Dataset = data.assign(moved)
    return with_things


def _of_past(past: Past) -> Variables:
    matrix = ("row", "column")
    when = {"long_name": "when each pose before the first was", "units": "s"}
    head = {"long_name": "where the head was before the first pose; lengths in m"}
    variables: Variables = {
        "past_time_s": (("past",), past.times_s, when),
        "past_world_from_head": (("past", *matrix), past.poses, head),
    }
    if len(past.transforms) == len(past.times_s) and past.transforms.shape[1] > 0:
        things = {"long_name": "where each thing that was moved was before the first pose"}
        variables["past_world_from_thing"] = (("past", "thing", *matrix), past.transforms, things)
    return variables


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
