"""Options that several commands have. Those of `Settings` have names, help and ranges from
there."""

from __future__ import annotations

import functools
import inspect
import shlex
import sys
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar, cast, get_args

import typer

from omma._core import Error
from omma.base.arguments import one_of
from omma.cli.parameters import argument, option
from omma.cli.working import warn
from omma.rendering.settings import (
    AngularSensitivityName,
    Fixed,
    Sampling,
    Settings,
    Shared,
    ToError,
    option_types,
    options_of,
)
from omma.scene.backgrounds import NAMED_BACKGROUNDS
from omma.scene.lighting import checked_rule

F = TypeVar("F", bound=Callable[..., Any])

SceneArgument = Annotated[
    Path,
    argument(
        "Scene: .gltf or .glb, .obj, .ply or .stl; points: .las, .laz, .e57, .ply, .xyz, .pts, "
        ".asc; Gaussian splats: .ply, .spz.",
        "SCENE",
    ),
]
SceneUnitOption = Annotated[
    str | None,
    option(
        "Unit of lengths in the scene's file: mm, um, m (the default) or a number of metres.",
        "UNIT",
    ),
]
SceneUpOption = Annotated[
    str | None,
    option(
        "Axis that is up in the scene's file: y, z, or -y where y points down. Default: y, in "
        "files of points but .ply z, in .ply files of Gaussian splats -y.",
        "AXIS",
    ),
]
SceneVoxelOption = Annotated[
    float | None,
    option(
        "Of points of a scan: side of the cells of a grid, in metres, in each of which their "
        "mean is one disc. Default: each point is one.",
        "METRES",
    ),
]
CaptureCamerasOption = Annotated[
    Path | None,
    option(
        "Where the photographs were taken from of which the scene was made: a folder of "
        "COLMAP, transforms.json, cameras.json. Responses come with how near the nearest was: "
        "camera_distance and camera_angle.",
        "FILE",
    ),
]
CaptureUnitOption = Annotated[
    str | None, option("Unit of lengths in --capture-cameras. Default: as --scene-unit.", "UNIT")
]
CaptureUpOption = Annotated[
    str | None,
    option(
        "Axis that is up in --capture-cameras: y, z or -y. Default: as --scene-up; without "
        "it, z in transforms.json, else -y.",
        "AXIS",
    ),
]

EyeUnitOption = Annotated[
    str, option("Unit of lengths in eye files: mm, um, m or a number of metres.", "UNIT")
]

LookAtOption = Annotated[
    tuple[float, float, float] | None,
    option(
        "Point that the head looks at; straight below, its upper side is towards -Z. Default: "
        "along -Z.",
        "X Y Z",
        name="--look-at",
    ),
]
PathOption = Annotated[Path | None, option("CSV file of poses, one a line.", "CSV")]
OnGroundOption = Annotated[
    float | None,
    option(
        "Height of the head above the ground, in metres: --path is then a track, a CSV file "
        "with columns [t_s,]x_m,z_m[,heading_deg], and the body pitches and rolls with the ground.",
        "HEIGHT",
        name="--on-ground",
    ),
]
GroundOption = Annotated[
    list[str] | None,
    option(
        "With --on-ground: a thing of the scene that is ground; may be given several times. "
        "Default: everything is.",
        "NAME",
    ),
]
LostOption = Annotated[
    str,
    option(
        "With --on-ground: what becomes of lines of the track in which a number is missing, "
        "as trackers write where they lost the animal: refuse or leave_out.",
        "WORD",
    ),
]
ThreadsOption = Annotated[int, option("Threads; 0: all.", "N")]

BackgroundOption = Annotated[
    str | None,
    option(
        "Instead of the scene's: linear radiance R,G,B, an equirectangular image file, "
        + " or ".join(NAMED_BACKGROUNDS)
        + ".",
        "R,G,B|FILE|NAME",
    ),
]
LightOption = Annotated[
    str | None,
    option(
        "What lights the scene: a sky and its arguments, such as 'clear_sky "
        "sun_elevation_deg=30 sun_azimuth_deg=135 ultraviolet=dark' (docs/light.md); "
        "lighting=path (the default) follows it for each ray, lighting=baked finds most of it once "
        "and keeps it; polarized=True follows its polarisation, which receptors with microvilli "
        "see. Default: no light, surfaces show the colours of the file.",
        "WORDS",
    ),
]
UnitOption = Annotated[
    str | None,
    option(
        "Unit of lengths in the eye file: mm, um, m or a number of metres. "
        "Default: mm; for a camera's own eye the scene's unit.",
        "UNIT",
    ),
]
BackendOption = Annotated[
    Literal["", "embree", "portable", "cuda"],
    typer.Option(
        help="What traces the rays: embree, portable, which is Omma's own, or cuda, a graphics "
        "card (omma info --devices). Default: a card where there is one, else embree.",
        metavar="embree|portable|cuda",
        show_default=False,
    ),
]
DeviceOption = Annotated[
    list[int] | None,
    typer.Option(
        help="Ordinal of a graphics card, which then traces the rays; several share the poses. "
        "Default: 0, the first one.",
        metavar="N",
        min=0,
    ),
]
WidthOption = Annotated[
    int | None,
    option(
        "Width of a picture, in pixels; of a panel without its frame. Default: from its "
        "height, or 1024.",
        "N",
    ),
]
HeightOption = Annotated[int | None, option("Height of a picture. Default: from its width.", "N")]
GammaOption = Annotated[float, option("Display gamma of a .png.", "GAMMA")]

UltravioletOption = Annotated[
    str | None,
    option(
        "What there is below 400 nm, where RGB says nothing: dark, nothing; as_blue, as much "
        "as blue; with --light, what surfaces reflect there, from 0 to 1; without it, for "
        "receptors, a mix R,G,B. Default: dark for receptors; with --light it must be said where "
        "it matters.",
        "dark|as_blue|NUMBER|R,G,B",
    ),
]

# Options of the command line by the class they belong to; where their name is not the field's.
_NAMES: dict[tuple[type, str], str] = {(Shared, "samples"): "shared"}

OldKernelOption = Annotated[
    str | None, typer.Option("--kernel", hidden=True, help="The old name of --angular-sensitivity.")
]


def sensitivity_of(angular_sensitivity: str, kernel: str | None) -> Any:
    """What --angular-sensitivity says, or with a warning --kernel, its old name."""
    if kernel is None:
        return angular_sensitivity
    warn("--kernel is called --angular-sensitivity now; the old name works until 0.2")
    return one_of(kernel, get_args(AngularSensitivityName), "--kernel")


def light_and_mix(
    light: str | None, ultraviolet: str | None
) -> tuple[str | None, str | list[float] | None]:
    """What --light and --ultraviolet say, as `render_file` takes it: the words of the light, with
    what surfaces reflect below 400 nm, and what receptors without a light get there."""
    if ultraviolet is None:
        return light, None
    if light is None:
        try:
            return None, [float(number) for number in ultraviolet.split(",")]
        except ValueError:
            return None, ultraviolet
    if "ultraviolet=" in light:
        raise Error("ultraviolet: not together with the word ultraviolet= of --light")
    try:
        checked_rule(float(ultraviolet))
    except ValueError:
        checked_rule(ultraviolet)
    return f"{light} ultraviolet={ultraviolet}", None


def command_typed() -> str:
    """The command that runs, for what says of files how they were made."""
    return shlex.join(["omma", *sys.argv[1:]])


def help_of(name: str) -> str:
    """What an option of `Settings` says of itself."""
    return next(str(one.metadata["help"]) for one in options_of(Settings) if one.name == name)


def takes_settings(
    ways: Collection[type] = get_args(Sampling), without: Collection[str] = ()
) -> Callable[[F], F]:
    """A decorator: the same command, whose parameter ``settings`` has become an option for each
    field.

    Args:
        ways: of `Sampling`, those that can be chosen.
        without: options that keep their default.
    """

    def decorate(command: F) -> F:
        signature = inspect.signature(command, eval_str=True)
        options = _parameters(ways, without)
        parameters: list[inspect.Parameter] = []
        for one in signature.parameters.values():
            parameters += options if one.name == "settings" else [one]

        @functools.wraps(command)
        def with_settings(**given: Any) -> Any:
            values = {one.name: given.pop(one.name) for one in options}
            values["angular_sensitivity"] = sensitivity_of(
                values["angular_sensitivity"], values.pop("kernel")
            )
            return command(settings=_settings(values), **given)

        with_settings.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
        with_settings.__annotations__ = {one.name: one.annotation for one in parameters}
        return cast(F, with_settings)

    return decorate


def _parameters(ways: Collection[type], without: Collection[str]) -> list[inspect.Parameter]:
    """A parameter as typer reads it for each option. Those of the ways of sampling are None where
    not given, so that one can tell which was meant."""
    found = []
    either = inspect.Parameter.POSITIONAL_OR_KEYWORD
    for kind in (*ways, Settings):
        for one in options_of(kind):
            if one.name in without:
                continue
            name = _NAMES.get((kind, one.name), one.name)
            of_sampling = kind is not Settings
            declared = option_types(kind)[one.name]
            is_number = of_sampling or declared is int
            shown = option(
                one.metadata["help"] + _default(kind),
                one.metadata["metavar"] if is_number else None,
            )
            kept: Any = Annotated[declared, shown]
            if of_sampling:
                kept = Annotated[declared | None, shown]
            default = None if of_sampling else one.default
            found.append(inspect.Parameter(name, either, default=default, annotation=kept))
    found.append(inspect.Parameter("kernel", either, default=None, annotation=OldKernelOption))
    return found


def _default(kind: type) -> str:
    return f" [default: {Fixed().samples}]" if kind is Fixed else ""


def _settings(given: dict[str, Any]) -> Settings:
    """Settings from the values of all options."""
    values = {name: value for name, value in given.items() if value is not None}
    ways: dict[str, Sampling] = {}
    if "samples" in values:
        ways["--samples"] = Fixed(values["samples"])
    if "shared" in values:
        ways["--shared"] = Shared(values["shared"])
    errors = [name for name in ("error", "relative_error") if name in values]
    if errors:
        ways[f"--{errors[0].replace('_', '-')}"] = ToError(
            **{one.name: values.get(one.name) for one in options_of(ToError)}
        )
    else:
        for name in ("least", "most"):
            if name in values:
                raise Error(
                    f"{name}: goes with --error or --relative-error, found --{name} {values[name]}"
                )
    if len(ways) > 1:
        raise Error(f"{' and '.join(ways)}: only one of them can say how many rays there are")
    return Settings(
        next(iter(ways.values()), Settings.sampling),
        **{one.name: values[one.name] for one in options_of(Settings) if one.name in values},
    )
