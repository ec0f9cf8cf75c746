"""Ground truth beside responses: how far, where and what ommatidia see, and how it moves past; a
method of `omma.Renderer`."""

from __future__ import annotations

import weakref
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, Eye
from omma.base.arguments import array_of, checked, whole
from omma.base.arrays import Floats32
from omma.base.poses import Matrices
from omma.base.progress import Progress, share_of
from omma.base.slips import warn_of_slip
from omma.base.values import table_of_fields, value_class
from omma.rendering.call import Call, Poses, Prepared
from omma.rendering.labels import Variables, camera_variables
from omma.rendering.moves import Moves, MovesOptions, renderer_method
from omma.rendering.settings import Shared, ToError
from omma.rendering.truth_origin import Origin
from omma.scene.capture_cameras import CaptureCameras
from omma.scene.world import World
from omma.scene.world_names import check_named, index_of, names_in

if TYPE_CHECKING:
    from typing_extensions import Unpack


# As omma/truth.h has it.
_MOST_SHARES = 1 << 14
# Of a pose's numbers: as far as single precision rounds them, two poses are the same.
_ROUNDED = 2.0**-23
# Of the progress, where the nearest cameras are found after rendering.
_RENDERED = 0.9


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class GroundTruth:
    """What `Renderer.ground_truth` found, with the rays that the responses are made of.

    All are means over an ommatidium's rays, and so over its angular sensitivity, as radiance is. A
    ray counts for the first surface that it meets, also where that lets light through (BLEND,
    glass); cut-outs (MASK) are as they are seen. Among Gaussian splats it counts for the one before
    and in which half of its light is, or else for the surface behind them.
    """

    responses: Floats32
    """(P, N, C), as `Renderer.render` gives them."""
    met: Floats32
    """(P, N), share of the field in which anything was met: the rest is sky."""
    distance_m: Floats32
    """(P, N), mean over what was met, along each ray from where it starts; infinite where nothing
    was."""
    nearest_m: Floats32
    """(P, N), least of the rays; infinite where nothing was met."""
    inverse_distance_per_m: Floats32
    """(P, N), mean of 1 / distance, which is 0 where nothing was met."""
    position_m: NDArray[np.float64]
    """(P, N, 3), in the world, mean over what was met; NaN where nothing was."""
    normal: Floats32
    """(P, N, 3), in the world: the mean of the normals of triangles, each of length 1, on the side
    that is seen. The more they differ the shorter it is; NaN where nothing was met."""
    source_distance_m: Floats32 | None = None
    """(P, N), in worlds with Gaussian splats: mean over all that light comes from, weighted by how
    much does; infinite where nothing is."""
    names: tuple[str, ...] = ()
    """(K,), whose shares were asked for."""
    shares: Floats32 | None = None
    """(P, N, K), share of the field that each fills. What is left of `met` is other things."""
    flow_rotation_rad_s: Floats32 | None = None
    """(P, N, 2), right and up, where velocities are known: optic flow from the head's rotation,
    −ω × d."""
    flow_translation_rad_s: Floats32 | None = None
    """(P, N, 2): from the translation of where the ommatidium's rays start, −(t − (t·d) d) / r."""
    flow_objects_rad_s: Floats32 | None = None
    """(P, N, 2): from what moves by itself, (v − (v·d) d) / r."""
    standard_error: Floats32 | None = None
    """(P, N, C), of the responses, where asked for and with `ToError`."""
    rays: NDArray[np.int32] | None = None
    """(P, N), rays spent, with `ToError`."""
    camera_distance_m: NDArray[np.float64] | None = None
    """(P,), of a captured world: from the head to the nearest camera that it is known from."""
    camera_angle_deg: Floats32 | None = None
    """(P, N), between the directions in which an ommatidium and the nearest camera, by that angle,
    see the same point (`CaptureCameras.nearness`); NaN where no camera had it in its field."""
    world_from_head: Matrices | None = None
    """(P, 4, 4), the poses that it is of."""
    eye: Eye | None = None
    """The eye that it is of."""

    @property
    def flow_rad_s(self) -> Floats32 | None:
        """(P, N, 2), right and up: the optic flow, the sum of its three components."""
        components = (
            self.flow_rotation_rad_s,
            self.flow_translation_rad_s,
            self.flow_objects_rad_s,
        )
        if components[0] is None or components[1] is None or components[2] is None:
            return None
        return components[0] + components[1] + components[2]

    def _repr_html_(self) -> str:
        return table_of_fields(self, "omma.rendering.GroundTruth")


@checked
@renderer_method
def ground_truth(
    self: Prepared,
    poses: Poses,
    *,
    shares: Sequence[str | int] = (),
    head_velocity: tuple[ArrayLike, ArrayLike] | None = None,
    velocities: Mapping[str | int, tuple[ArrayLike, ArrayLike]] | None = None,
    capture_cameras: CaptureCameras | None = None,
    standard_error: bool = False,
    first_pose: int | None = None,
    progress: Progress | None = None,
    **moves: Unpack[MovesOptions],
) -> GroundTruth:
    """Responses, and beside them how far, where and what each ommatidium sees.

    Means over the very rays of `render`, whose bits the responses have: distances, positions,
    normals, shares of instances and optic flow; `GroundTruth` says what each is
    (docs/ground-truth.md). Not with `Shared`.

    Args:
        poses, standard_error, first_pose, progress: as in `render`. With `ToError` there
            are always standard errors.
        shares: whose shares of the field to tell: names, each of all that are called so, or
            indices in `World.instances`.
        head_velocity: the head's linear velocity, m/s, and angular velocity, rad/s, in the
            world's frame, each (3,) or (P, 3): of its origin, and right-handed about it.
            `omma.velocities_from_poses` finds them from a path. None: with ``times_s`` that
            grow, that along the path of the poses, also where nothing else moves, else none.
            There is optic flow with a velocity of either, or with such times.
        velocities: of what moves by itself, {name or index in `World.instances`: (linear,
            angular)}: of the origin of the node's frame where it is now, as ``head_velocity``.
            With ``times_s``, what ``instances`` and animations move has the velocity at which
            it does so, unless it is told here. How it grows, is stretched or is bent is in neither,
            and where an animation jumps from one key to the next it stands still.
        capture_cameras: from which a world made of photographs is known, as
            `omma.scene.load_capture_cameras` reads them: how near they were is told too.
        instances, transforms, times_s, animation, unseen, unseen_by_light: as of `render`.

    Raises:
        omma.Error: what `render` raises, no such instance or one twice, a velocity of another
            shape or above 1e9, rays that are shared; things moved by a single transform, or one
            whose times do not grow, of which no velocity is told.

    Warns:
        UserWarning: things that grow, are stretched, or are moved by bones or morph targets, as
            their flow lacks that; a head velocity that turns as no animal does, as of degrees.
    """
    sampling = self.settings.sampling
    if isinstance(sampling, Shared):
        raise Error(
            "ground_truth: expected rays of each ommatidium's own (omma.Fixed or omma.ToError), "
            f"found {sampling}"
        )
    if self.settings.impulse_response is not None:
        raise Error("ground_truth: expected a renderer without an impulse response, found one with")
    rendered = progress if capture_cameras is None else share_of(progress, 0, _RENDERED)
    call = Call.of(self, poses, moves, first_pose, rendered, tells_flow=True).numbered()
    to_error = isinstance(sampling, ToError)
    frames = call.new_frames(standard_error=standard_error or to_error, rays=to_error)
    found: dict[str, Any] = {
        name: array for name, array in vars(frames).items() if array is not None
    }
    for name in ("met", "distance_m", "nearest_m", "inverse_distance_per_m"):
        found[name] = np.empty(call.size, np.float32)
    if self.world.scene.splats:
        found["source_distance_m"] = np.empty(call.size, np.float32)
    found["position_m"] = np.empty((*call.size, 3))
    found["normal"] = np.empty((*call.size, 3), np.float32)
    asked: dict[str, Any] = {}
    names: tuple[str, ...] = ()
    if not isinstance(shares, (list, tuple)):
        raise TypeError(f"shares: expected a list of names or indices, found {shares!r:.40}")
    if len(shares) > 0:
        names, asked["share_of_instance"] = groups_of_shares(self.world, shares)
        found["shares"] = np.empty((*call.size, len(shares)), np.float32)
    is_given = head_velocity is not None
    if head_velocity is None and call.moves.is_path():
        head_velocity = call.moves.head_velocity()
    if head_velocity is not None or velocities is not None:
        for component in ("rotation", "translation", "objects"):
            found[f"flow_{component}_rad_s"] = np.empty((*call.size, 2), np.float32)
        if head_velocity is not None:
            head = _velocity(head_velocity, "head_velocity", len(call.poses))
            asked["head"] = head
            if is_given:
                turn = np.linalg.norm(head[:, 3:], axis=1)
                warn_of_slip("angular velocity", turn, "head_velocity, angular_rad_s")
        asked |= _objects(self.world, velocities or {}, call.moves, len(call.poses))
    call.render_truth(found | asked)
    if capture_cameras is not None:
        found["camera_distance_m"], found["camera_angle_deg"] = capture_cameras.nearness(
            self.eye,
            call.poses,
            distance_m=found["distance_m"],
            progress=share_of(progress, _RENDERED, 1),
        )
    truth = GroundTruth(**found, names=names, world_from_head=call.poses.copy(), eye=self.eye)
    # No fields: they are no values, and the world is not kept alive.
    object.__setattr__(truth, "_world", weakref.ref(self.world))
    object.__setattr__(truth, "_origin", Origin.of(call))
    return truth


def truth_variables(truth: GroundTruth, dimensions: tuple[str, str]) -> Variables:
    """Ground truth as labelled variables; ``dimensions``: of poses and of ommatidia."""
    direction = (*dimensions, "direction")
    axis = (*dimensions, "axis")
    flow = "optic flow in the ommatidium's right and up, "
    found: Variables = {
        "met": (dimensions, truth.met, {"units": "1", "long_name": "share in which anything is"}),
        "distance": (dimensions, truth.distance_m, {"units": "m", "long_name": "mean distance"}),
        "nearest": (dimensions, truth.nearest_m, {"units": "m", "long_name": "least distance"}),
        "inverse_distance": (
            dimensions,
            truth.inverse_distance_per_m,
            {"units": "m-1", "long_name": "mean of the inverse distance, 0 where nothing is"},
        ),
        "seen_position": (
            axis,
            truth.position_m,
            {"units": "m", "long_name": "mean position of what is seen, in the world"},
        ),
        "seen_normal": (
            axis,
            truth.normal,
            {"units": "1", "long_name": "mean normal of what is seen, in the world"},
        ),
    }
    if truth.source_distance_m is not None:
        about = {"units": "m", "long_name": "mean distance that light comes from"}
        found["source_distance"] = (dimensions, truth.source_distance_m, about)
    if truth.shares is not None:
        found["instance"] = (("instance",), np.array(truth.names, dtype=np.str_), {})
        about = {"units": "1", "long_name": "share of the field that an instance fills"}
        found["share"] = ((*dimensions, "instance"), truth.shares, about)
    if truth.camera_distance_m is not None and truth.camera_angle_deg is not None:
        about_cameras = camera_variables(dimensions[0])
        near: dict[str, NDArray[Any]] = {
            "camera_distance": truth.camera_distance_m,
            "camera_angle": truth.camera_angle_deg,
        }
        for name, one in near.items():
            found[name] = (dimensions[: one.ndim], one, about_cameras[name][2])
    for name, values, which in (
        ("flow", truth.flow_rad_s, "in all"),
        ("flow_rotation", truth.flow_rotation_rad_s, "from the head's rotation"),
        ("flow_translation", truth.flow_translation_rad_s, "from the head's translation"),
        ("flow_objects", truth.flow_objects_rad_s, "from what moves by itself"),
    ):
        if values is not None:
            found["direction"] = (("direction",), np.array(["right", "up"]), {})
            found[name] = (direction, values, {"units": "rad s-1", "long_name": flow + which})
    return found


def origin_of(truth: GroundTruth) -> Origin | None:
    """What it was made with; None where it was made by hand or pickled."""
    found: Origin | None = vars(truth).get("_origin")
    return found


def check_truth(truth: GroundTruth, poses: Matrices, renderer: Prepared) -> None:
    """omma.Error where ground truth is of other poses, another eye, another world or another number
    of bands; what was made without its poses or its eye is known by its shape alone, and so is the
    world of what was pickled or outlives it."""
    eye = renderer.eye
    size = (len(poses), len(eye), renderer.bands)
    if truth.responses.shape != size:
        raise Error(
            f"truth: expected that of {size[0]} poses, {size[1]} ommatidia and {size[2]} bands, "
            f"found {truth.responses.shape}"
        )
    if truth.world_from_head is not None:
        near = np.isclose(truth.world_from_head, poses, rtol=_ROUNDED, atol=_ROUNDED)
        other = np.flatnonzero(~near.all(axis=(1, 2)))
        if len(other) > 0:
            raise Error(
                f"truth: expected that of these poses, found that of others: pose {other[0]} is "
                f"{_at(poses[other[0]])} here, {_at(truth.world_from_head[other[0]])} there"
            )
    if truth.eye is not None and truth.eye != eye:
        raise Error(
            "truth: expected that of this renderer's eye, found that of another eye with as many "
            "ommatidia"
        )
    other_world = vars(truth).get("_world", lambda: None)()
    if other_world is not None and other_world is not renderer.world:
        for what in ("scene", "background", "light"):
            if getattr(other_world, what) != getattr(renderer.world, what):
                raise Error(
                    "truth: expected that of this renderer's world, found that of a world with "
                    f"another {what}"
                )


def _at(pose: NDArray[np.float64]) -> str:
    """Where a pose is and which way it looks, for messages."""
    place, ahead = (", ".join(f"{one:.6g}" for one in row) for row in (pose[:3, 3], -pose[:3, 2]))
    return f"at ({place}) m looking along ({ahead})"


def groups_of_shares(world: World, shares: Sequence[str | int]) -> tuple[tuple[str, ...], Any]:
    """What each share is called, and the share of each instance, -1 for none."""
    if len(shares) > _MOST_SHARES:
        raise Error(f"shares: expected at most {_MOST_SHARES}, found {len(shares)}")
    names = names_in(world)
    group = np.full(len(names), -1, np.int32)
    called = []
    for k, one in enumerate(shares):
        if isinstance(one, str):
            check_named(names, one, f"shares[{k}]")
            members = [index for index, name in enumerate(names) if name == one]
        else:
            members = [whole(one, f"shares[{k}]", 0, len(names) - 1)]
        if np.any(group[members] >= 0):
            raise Error(f"shares[{k}]: {one!r} is there twice")
        group[members] = k
        called.append(names[members[0]])
    return tuple(called), group


def _velocity(given: tuple[ArrayLike, ArrayLike], name: str, poses: int) -> NDArray[np.float64]:
    """Linear and angular velocity in one, (P, 6)."""
    if not isinstance(given, tuple) or len(given) != 2:
        raise TypeError(
            f"{name}: expected a tuple (linear_m_s, angular_rad_s), found {given!r:.40}"
        )
    velocities = []
    for velocity, what in zip(given, ("linear_m_s", "angular_rad_s"), strict=True):
        numbers = array_of(velocity, f"{name}, {what}", [(3,), (poses, 3)], finite=True)
        velocities.append(np.broadcast_to(numbers, (poses, 3)))
    return np.ascontiguousarray(np.concatenate(velocities, axis=1))


def _objects(
    world: World,
    velocities: Mapping[str | int, tuple[ArrayLike, ArrayLike]],
    moving: Moves,
    poses: int,
) -> dict[str, Any]:
    """What moves by itself and how: as the caller says, and else as it moves in this call."""
    if not isinstance(velocities, Mapping):
        raise TypeError(
            "velocities: expected a mapping {instance: (linear_m_s, angular_rad_s)}, found "
            f"{velocities!r:.40}"
        )
    count = len(world.instances)
    things = [
        index_of(world, one, "velocities")
        if isinstance(one, str)
        else whole(one, "velocities", 0, count - 1)
        for one in velocities
    ]
    if len(set(things)) < len(things):
        raise Error("velocities: an instance is there twice, by its name and by its index")
    rows = [_velocity(given, f"velocities[{one!r}]", poses) for one, given in velocities.items()]
    for thing, velocity in moving.velocities(things).items():
        things.append(thing)
        rows.append(_velocity(velocity, f"velocity of instance {thing}", poses))
    if not things:
        return {}
    return {"moving": np.array(things, np.int32), "objects": np.stack(rows, axis=1)}
