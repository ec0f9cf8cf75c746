"""A render from files to files as a value: each argument of `render_file` is declared here, once.

`render_file` gets its signature from the fields of `RenderJob`; ``omma render`` and
``omma render-again`` make one; renders that go on compare it, and files say it. A new argument is a
field here, a line of `JobOptions` for type checkers, and a line in the docstring of `render_file`.
"""

from __future__ import annotations

import dataclasses
import inspect
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar, get_type_hints

from numpy.typing import ArrayLike

from omma._core import Background, Error
from omma.base.arguments import one_of, positive, whole
from omma.base.files import PathLike
from omma.base.values import value_class
from omma.motion.tracks import LOST
from omma.rendering.settings import Options, Sampling, Settings, Shared

F = TypeVar("F", bound=Callable[..., Any])

# Fields that do not change responses, or that files tell otherwise.
_NO_RECORD = (
    *("scene", "outputs", "settings", "eyes", "path", "poses", "capture_cameras"),
    *("threads", "backend", "devices", "resume", "command"),
)


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class RenderJob:
    """What a render is asked for; `omma.render_file` says what each field is.

    Raises:
        omma.Error: fields that do not go together, whatever is in the files.
    """

    scene: PathLike
    outputs: PathLike | Sequence[PathLike]
    settings: Settings
    eyes: PathLike | Sequence[PathLike] = ()
    unit: str | float | None = None
    camera: str | int | None = None
    position: ArrayLike | None = None
    look_at: ArrayLike | None = None
    path: PathLike | None = None
    on_ground: float | None = None
    ground: str | Sequence[str] = ()
    lost: str = "refuse"
    poses: ArrayLike | None = None
    scene_index: int | None = None
    scene_unit: str | float | None = None
    scene_up: str | None = None
    scene_voxel_m: float | None = None
    capture_cameras: PathLike | None = None
    capture_unit: str | float | None = None
    capture_up: str | None = None
    threads: int = 0
    backend: str = ""
    devices: Sequence[int] = ()
    background: Background | str | None = None
    light: str | None = None
    standard_error: bool = False
    receptors: bool = False
    ultraviolet: ArrayLike | None = None
    projection: str | None = None
    width: int | None = None
    height: int | None = None
    gamma: float = 2.2
    side_by_side: bool = False
    resume: bool = False
    command: str | None = None

    def __post_init__(self) -> None:
        chosen = self._ways_to_be_somewhere()
        if len(chosen) > 1:
            raise Error(f"{chosen[0]} and {chosen[1]}: only one of them can say where the head is")
        if self.resume and self.path is None:
            raise Error("resume: expected a path of poses")
        if self.on_ground is not None and self.path is None:
            raise Error("on_ground: expected a path, a track on the ground")
        if self.ground and self.on_ground is None:
            raise Error("ground: goes with on_ground, the height of the head above it")
        if one_of(self.lost, LOST, "lost") != "refuse" and self.on_ground is None:
            raise Error("lost: goes with on_ground, along a track")
        positive(self.gamma, "gamma")
        for name in ("width", "height"):
            if getattr(self, name) is not None:
                whole(getattr(self, name), name, 1, 1 << 30)
        videos = [one for one in self.several_outputs if os.fsdecode(one).lower().endswith(".mp4")]
        if videos and self.projection is not None and self.projection.endswith("_ids"):
            raise Error(f"projection: a video shows responses, found {self.projection!r}")
        if self.look_at is not None and self.position is None:
            raise Error("look_at: needs a position to look from")
        if self.capture_cameras is not None:
            self._check_cameras()
        for name in ("capture_unit", "capture_up"):
            if getattr(self, name) is not None and self.capture_cameras is None:
                raise Error(f"{name}: goes with capture_cameras, a file of cameras")

    @property
    def several_outputs(self) -> list[PathLike]:
        """One output or several, as a list."""
        return _several(self.outputs)

    @property
    def eye_files(self) -> list[PathLike]:
        """One eye file or several, or none, as a list."""
        return _several(self.eyes)

    @property
    def ground_names(self) -> list[str]:
        """One instance that is ground or several, or none, as a list."""
        return [self.ground] if isinstance(self.ground, str) else list(self.ground)

    @property
    def head_is_at(self) -> str | None:
        """Which field says where the head is: camera, position, path or poses; None: none does."""
        return next(iter(self._ways_to_be_somewhere()), None)

    def _check_cameras(self) -> None:
        """omma.Error where nobody would be told how near cameras were."""
        if self.receptors:
            raise Error("capture_cameras: is for responses of ommatidia, not of receptors")
        if isinstance(self.settings.sampling, Shared):
            raise Error(
                "capture_cameras: expected rays of each ommatidium's own, found shared ones"
            )
        names = [os.fsdecode(one) for one in self.several_outputs]
        if names and all(one.lower().endswith((".png", ".mp4")) for one in names):
            raise Error(
                f"capture_cameras: expected an output that says numbers, found {', '.join(names)}"
            )

    def _ways_to_be_somewhere(self) -> list[str]:
        fields = ("camera", "position", "path", "poses")
        chosen = [name for name in fields if getattr(self, name) is not None]
        if len(chosen) == 2 and chosen[0] == "camera" and not self.eye_files:
            return chosen[1:]  # the camera says which eye, not where
        return chosen

    def recorded(self) -> dict[str, Any]:
        """The fields that change responses, beside settings and files."""
        return {name: value for name, value in vars(self).items() if name not in _NO_RECORD}

    def arguments(self) -> dict[str, Any]:
        """As `render_file` takes them."""
        own = {name: value for name, value in vars(self).items() if name != "settings"}
        return own | {"sampling": self.settings.sampling, **self.settings.options()}


class JobOptions(Options, total=False):
    """The fields of `RenderJob` after the settings, as keyword arguments, for type checkers."""

    eyes: PathLike | Sequence[PathLike]
    unit: str | float | None
    camera: str | int | None
    position: ArrayLike | None
    look_at: ArrayLike | None
    path: PathLike | None
    on_ground: float | None
    ground: str | Sequence[str]
    lost: str
    poses: ArrayLike | None
    scene_index: int | None
    scene_unit: str | float | None
    scene_up: str | None
    scene_voxel_m: float | None
    capture_cameras: PathLike | None
    capture_unit: str | float | None
    capture_up: str | None
    threads: int
    backend: str
    devices: Sequence[int]
    background: Background | str | None
    light: str | None
    standard_error: bool
    receptors: bool
    ultraviolet: ArrayLike | None
    projection: str | None
    width: int | None
    height: int | None
    gamma: float
    side_by_side: bool
    resume: bool
    command: str | None


def job_of(
    scene: PathLike,
    outputs: PathLike | Sequence[PathLike],
    sampling: Sampling,
    asked: JobOptions,
) -> RenderJob:
    """The job of the arguments of `render_file`."""
    own: dict[str, Any] = dict(asked)
    options = {name: own.pop(name) for name in Options.__annotations__ if name in own}
    return RenderJob(scene, outputs, Settings(sampling, **options), **own)


def takes_job(function: F) -> F:
    """The same function, whose signature says ``**asked`` one by one: the fields of `RenderJob`
    after the settings, before its last own parameter."""
    signature = inspect.signature(function)
    *first, last, _ = signature.parameters.values()
    fields = [
        inspect.Parameter(
            one.name, inspect.Parameter.KEYWORD_ONLY, default=one.default, annotation=one.type
        )
        for one in dataclasses.fields(RenderJob)[3:]
    ]
    function.__signature__ = signature.replace(  # type: ignore[attr-defined]
        parameters=[*first, *fields, last]
    )
    function.__annotations__ |= get_type_hints(RenderJob)
    return function


def _several(paths: PathLike | Sequence[PathLike]) -> list[PathLike]:
    return [paths] if isinstance(paths, (str, os.PathLike)) else list(paths)
