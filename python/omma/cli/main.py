"""The command ``omma``: a thin skin over `render_file` and `describe_file`."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from omma._core import Error, __version__
from omma.cli.eye import eye_app
from omma.cli.measure import measure_app
from omma.cli.options import takes_settings
from omma.cli.report import camera_lines, report_lines
from omma.cli.working import (
    fail,
    interrupted,
    open_missing_streams,
    unwinding_on_signals,
    warn,
    working,
)
from omma.job.all_cameras import render_all_cameras
from omma.job.info import describe_file
from omma.job.rendering import SUFFIXES, render_file
from omma.picture.projections import PROJECTIONS
from omma.rendering.renderer import READING
from omma.rendering.settings import Settings, Shared, ToError
from omma.scene.backgrounds import NAMED_BACKGROUNDS

RENDER_HELP = """
Render what an eye sees in a scene, or a camera of the scene, and write responses or pictures.

**Examples**

What an eye sees from the scene's first camera, as a picture and as numbers:

`omma render meadow.glb --eye honeybee.eye -o view.png -o view.npy`

Two eyes, side by side in the picture, looking from one point at another:

`omma render meadow.glb --eye left.eye --eye right.eye --side-by-side --position 0 1 0
--look-at 0 1 -5 -o both.png`

A camera of the scene by name or index; a compound one with the eye file that it names:

`omma render arena.gltf --camera insect-eye -o responses.csv -o facets.png --projection facets`

`omma render arena.gltf --camera 2 --width 1920 --samples 64 -o panorama.png`

All cameras of the scene, each into a picture of its own:

`omma render arena.gltf --all-cameras -o pictures/`

As many rays as each ommatidium needs for a standard error of 0.01, at most 1,024:

`omma render meadow.glb --eye honeybee.eye --error 0.01 --most 1024
-o view.npy`

A path of many poses, with standard errors (flight.npy and flight.error.npy):

`omma render meadow.glb --eye honeybee.eye --path flight.csv --samples 64 --standard-error
-o flight.npy`

A path that takes hours; after Ctrl-C, a kill or a loss of power the same command goes on from where
it was, to the same numbers:

`omma render meadow.glb --eye honeybee.eye --path flight.csv --samples 4096 --resume
-o flight.npy`

What the receptors of an eye answer, with blue standing for ultraviolet, too:

`omma render meadow.glb --eye bee.csv --receptors --ultraviolet 0 0 1 -o receptors.csv`

The path is a CSV file with a header, x,y,z,qx,qy,qz,qw or x,y,z,yaw_deg,pitch_deg,roll_deg.
"""

INFO_HELP = """
Say what is in a scene or an eye file.

**Examples**

`omma info meadow.glb`

`omma info honeybee.eye`

`omma info eye-in-micrometres.eye --unit um`
"""

app = typer.Typer(
    name="omma",
    help="What an animal with compound eyes sees: from a scene and an eye to responses.",
    epilog="`omma render --help` and `omma info --help` show examples.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="markdown",
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.add_typer(eye_app, name="eye")
app.add_typer(measure_app, name="measure")

_DEFAULTS = Settings()

UnitOption = Annotated[
    str | None,
    typer.Option(
        help="Unit of lengths in the eye file: mm, um, m or a number of metres. "
        "Default: mm; for a camera's own eye the scene's unit.",
        metavar="UNIT",
    ),
]


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"omma {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool,
        typer.Option(
            "--version", help="Print the version.", callback=_print_version, is_eager=True
        ),
    ] = False,
) -> None:
    pass


@app.command(help=RENDER_HELP, short_help="Render what an eye or a camera sees in a scene.")
@takes_settings
def render(
    scene: Annotated[
        Path, typer.Argument(help="Scene: a glTF 2.0 file, .gltf or .glb.", metavar="SCENE")
    ],
    output: Annotated[
        list[Path],
        typer.Option(
            "-o",
            "--output",
            help="File to write: .npy, .csv (of an eye) or .png; may be given several times. "
            "With --all-cameras: a folder.",
            metavar="OUT",
        ),
    ],
    eye: Annotated[
        list[Path] | None,
        typer.Option(
            help="Eye file; several make one head. Default: none, the camera itself is rendered.",
            metavar="EYE",
        ),
    ] = None,
    unit: UnitOption = None,
    camera: Annotated[
        str | None,
        typer.Option(
            help="Camera of the scene to render, or to look from with an eye. Default: the first; "
            "without an eye the first compound one, where there is one.",
            metavar="NAME|INDEX",
        ),
    ] = None,
    all_cameras: Annotated[
        bool, typer.Option("--all-cameras", help="Render every camera of the scene.")
    ] = False,
    position: Annotated[
        tuple[float, float, float] | None,
        typer.Option(help="Where the head is, in metres.", metavar="X Y Z"),
    ] = None,
    look_at: Annotated[
        tuple[float, float, float] | None,
        typer.Option(help="Point that the head looks at. Default: along -Z.", metavar="X Y Z"),
    ] = None,
    path: Annotated[
        Path | None, typer.Option(help="CSV file of poses, one a line.", metavar="CSV")
    ] = None,
    background: Annotated[
        str | None,
        typer.Option(
            help="Instead of the scene's: linear radiance R,G,B, an equirectangular image file, "
            + " or ".join(NAMED_BACKGROUNDS)
            + ".",
            metavar="R,G,B|FILE|NAME",
        ),
    ] = None,
    standard_error: Annotated[
        bool,
        typer.Option(
            "--standard-error",
            help="Write standard errors too: 8 times the rays, but none more with --error.",
        ),
    ] = False,
    receptors: Annotated[
        bool,
        typer.Option(
            "--receptors",
            help="Write what the eye's receptors answer: .npy [pose, receptor], and .csv with a "
            "line for each pose and receptor.",
        ),
    ] = False,
    ultraviolet: Annotated[
        tuple[float, float, float] | None,
        typer.Option(
            help="With --receptors: light below 400 nm as a mix of red, green and blue. Default: "
            "none, as RGB says nothing of it.",
            metavar="R G B",
        ),
    ] = None,
    settings: Settings = _DEFAULTS,
    threads: Annotated[int, typer.Option(help="Threads; 0: all.", metavar="N")] = 0,
    backend: Annotated[
        Literal["", "embree", "portable"],
        typer.Option(
            help="What traces the rays: embree, or portable, which is Omma's own. Default: the "
            "fastest there is.",
            show_default=False,
        ),
    ] = "",
    projection: Annotated[
        str | None,
        typer.Option(
            help="How an eye is shown in a .png: " + ", ".join(PROJECTIONS) + "; with _ids added, "
            "numbers of ommatidia. Default: spherical_orientationwise; for a camera's own eye what "
            "the camera says.",
            metavar="NAME",
        ),
    ] = None,
    width: Annotated[
        int | None,
        typer.Option(
            help="Width of a picture, in pixels. Default: from its height, or 1024.", metavar="N"
        ),
    ] = None,
    height: Annotated[
        int | None,
        typer.Option(help="Height of a picture. Default: from its width.", metavar="N"),
    ] = None,
    gamma: Annotated[float, typer.Option(help="Display gamma of a .png.")] = 2.2,
    side_by_side: Annotated[
        bool, typer.Option("--side-by-side", help="Paint each eye apart in a .png.")
    ] = False,
    resume: Annotated[
        bool,
        typer.Option(
            "--resume",
            help="Of a --path: keep what is rendered when cut off (OUT.partial, OUT.resume), and "
            "go on from there where that is left of the same inputs.",
        ),
    ] = False,
) -> None:
    """Render what an eye sees in a scene, or a camera of the scene."""
    if all_cameras:
        _check_all_cameras(
            {
                "--eye": bool(eye),
                "--camera": camera is not None,
                "--position": position is not None,
                "--look-at": look_at is not None,
                "--path": path is not None,
                "--standard-error": standard_error,
                "--receptors": receptors,
                "--ultraviolet": ultraviolet is not None,
                "--error": isinstance(settings.sampling, ToError),
                "--shared": isinstance(settings.sampling, Shared),
                "--noise": settings.noise != "frozen",
                "--side-by-side": side_by_side,
                "--resume": resume,
            },
            output,
        )
        with working() as bar:
            everything = render_all_cameras(
                scene,
                output[0],
                settings.sampling,
                **settings.options(),
                unit=unit,
                threads=threads,
                backend=backend,
                background=background,
                projection=projection,
                width=width,
                height=height,
                gamma=gamma,
                progress=bar.show,
            )
        _print_warnings(everything.warnings)
        print("\n".join(camera_lines(everything)))
        return
    with working() as bar:
        report = render_file(
            scene,
            output,
            settings.sampling,
            **settings.options(),
            eyes=eye or (),
            unit=unit,
            camera=camera,
            position=position,
            look_at=look_at,
            path=path,
            threads=threads,
            backend=backend,
            background=background,
            standard_error=standard_error,
            receptors=receptors,
            ultraviolet=ultraviolet,
            projection=projection,
            width=width,
            height=height,
            gamma=gamma,
            side_by_side=side_by_side,
            resume=resume,
            progress=bar.show,
        )
    _print_warnings(report.warnings)
    print("\n".join(report_lines(report)))


@app.command(help=INFO_HELP, short_help="Say what is in a scene or an eye file.")
def info(
    file: Annotated[
        Path, typer.Argument(help="A scene (.gltf, .glb) or an eye (.eye).", metavar="FILE")
    ],
    unit: UnitOption = None,
) -> None:
    """Say what is in a scene or an eye file."""
    with working() as bar:
        lines = describe_file(file, "mm" if unit is None else unit, bar.fraction_of(READING))
    for what, value in lines:
        print(f"{what:<16} {value}")


def main() -> None:
    """Run the command line: exit code 0, 1 for an error, 2 for wrong usage, 130 for Ctrl-C, 143 and
    129 for SIGTERM and SIGHUP."""
    warnings.formatwarning = _warning_line
    open_missing_streams()
    with unwinding_on_signals():
        code = run(app)
    sys.exit(code)


def run(command: Callable[..., object]) -> int:
    """Run a typer app; every error becomes one line on stderr and an exit code."""
    try:
        code = command(standalone_mode=False)
        sys.stdout.flush()
        return code if isinstance(code, int) else 0
    except Error as error:
        return fail(_with_option(str(error), sys.argv[1:]), 1)
    except KeyboardInterrupt as error:
        return interrupted(error)
    except MemoryError:
        return fail("not enough memory", 1)
    except BrokenPipeError:
        # Whoever read the output has enough. What is still buffered has nowhere to go.
        sys.stdout = None
        return 1
    except OSError as error:
        return fail(f"{error.filename or 'system'}: {error.strerror}", 1)
    except Exception as error:
        # What typer says about wrong usage; its class has moved between typer's versions.
        message = getattr(error, "format_message", None)
        code = getattr(error, "exit_code", None)
        if message is not None and isinstance(code, int):
            return fail(_usage(error, message()), code) if message() else code
        if type(error).__name__ == "Abort":
            return interrupted(KeyboardInterrupt())
        raise


def _with_option(message: str, arguments: Sequence[str]) -> str:
    """The message, which begins with an argument of a function, as of the option that gave it."""
    name, colon, rest = message.partition(": ")
    option = "--" + name.replace("_", "-")
    command: Any = typer.main.get_command(app)
    for word in arguments:
        command = getattr(command, "commands", {}).get(word, command)
    known = {text for parameter in command.params for text in parameter.opts}
    return f"{option}{colon}{rest}" if option in known else message


def _usage(error: Exception, message: str) -> str:
    """What typer says, in words where several numbers are expected: it names a parser's trouble."""
    parameter: Any = getattr(error, "param", None)
    if parameter is None or parameter.nargs < 2 or "number" not in message:
        return message
    metavar = parameter.metavar or "numbers"
    return f"{parameter.opts[0]}: expected {parameter.nargs} numbers, {metavar}"


def _warning_line(message: Warning | str, *_: object, **__: object) -> str:
    return f"omma: warning: {message}\n"


def _print_warnings(warnings: Sequence[str]) -> None:
    for warning in warnings:
        warn(warning)


def _check_all_cameras(others: dict[str, bool], output: list[Path]) -> None:
    for name, given in others.items():
        if given:
            raise Error(f"{name}: not together with --all-cameras, which renders each as it is")
    if len(output) > 1 or output[0].suffix.lower() in SUFFIXES:
        raise Error(f"{output[-1]}: expected one folder as the output of --all-cameras")
