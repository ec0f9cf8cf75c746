"""``omma render``: a thin skin over `render_file`, `render_like` and `render_all_cameras`."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from omma._core import Error
from omma.cli.help import App
from omma.cli.options import (
    LookAtOption,
    PathOption,
    SceneUnitOption,
    SceneUpOption,
    ThreadsOption,
    UltravioletOption,
    light_and_mix,
    takes_settings,
)
from omma.cli.report import camera_lines, report_lines
from omma.cli.working import say, warn, working
from omma.job.again import render_like
from omma.job.all_cameras import render_all_cameras
from omma.job.outputs import SUFFIXES
from omma.job.render_job import RenderJob
from omma.job.rendering import run_job
from omma.picture.projections import PROJECTIONS
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

A path of many poses, with standard errors (flight.npy, flight.error.npy; flight.json says what
they are):

`omma render meadow.glb --eye honeybee.eye --path flight.csv --samples 64 --standard-error
-o flight.npy`

The path as a video, 30 poses a second (pip install 'omma[video]'):

`omma render meadow.glb --eye left.eye --eye right.eye --path flight.csv -o flight.mp4`

A path that takes hours; after Ctrl-C, a kill or a loss of power the same command goes on from where
it was, to the same numbers:

`omma render meadow.glb --eye honeybee.eye --path flight.csv --samples 4096 --resume
-o flight.npy`

What an earlier render wrote, rendered again to the same bits:

`omma render --like flight.npy -o again.zarr`

In the light of a clear morning, in 16 bands of wavelengths, as photons; the picture in colours as
people see them:

`omma render meadow_lit.glb --eye bee.csv --light 'clear_sky sun_elevation_deg=30'
-o view.npy -o view.png`

That is lighting=path: light is followed for each ray, and rendering begins at once. For long paths
through a scene that stands still, lighting=baked finds most of the light once and looks it up. The
first time that takes minutes in a large scene; what was baked is kept below ~/.cache/omma, or below
the folder that the environment variable OMMA_CACHE names, and found there the next time:

`omma render meadow_lit.glb --eye bee.csv --path flight.csv
--light 'clear_sky sun_elevation_deg=30 lighting=baked' -o flight.npy`

What the receptors of an eye answer, with as much ultraviolet as there is blue:

`omma render meadow.glb --eye bee.csv --receptors --ultraviolet as_blue -o receptors.csv`

The path is a CSV file with a header, x,y,z,qx,qy,qz,qw or x,y,z,yaw_deg,pitch_deg,roll_deg.
"""

render_app = App()

_DEFAULTS = Settings()

# Options that may go with --like.
_WITH_LIKE = ("like", "output", "scene", "eye", "threads")

BackgroundOption = Annotated[
    str | None,
    typer.Option(
        help="Instead of the scene's: linear radiance R,G,B, an equirectangular image file, "
        + " or ".join(NAMED_BACKGROUNDS)
        + ".",
        metavar="R,G,B|FILE|NAME",
    ),
]
LightOption = Annotated[
    str | None,
    typer.Option(
        help="What lights the scene: a sky and its arguments, such as 'clear_sky "
        "sun_elevation_deg=30 sun_azimuth_deg=135 ultraviolet=dark' (docs/light.md); "
        "lighting=path (the default) follows it for each ray, lighting=baked finds most of it once "
        "and keeps it. Default: no light, surfaces show the colours of the file.",
        metavar="WORDS",
    ),
]
UnitOption = Annotated[
    str | None,
    typer.Option(
        help="Unit of lengths in the eye file: mm, um, m or a number of metres. "
        "Default: mm; for a camera's own eye the scene's unit.",
        metavar="UNIT",
    ),
]


@render_app.command(help=RENDER_HELP)
@takes_settings
def render(
    context: typer.Context,
    output: Annotated[
        list[str],
        typer.Option(
            "-o",
            "--output",
            help="File to write: .png, or of an eye .zarr, .nc, .parquet, .npy (a .json beside "
            "it), .csv or .mp4; may be given several times. With --all-cameras: a folder.",
            metavar="OUT",
        ),
    ],
    scene: Annotated[
        Path | None,
        typer.Argument(help="Scene: .gltf or .glb, .obj, .ply or .stl.", metavar="SCENE"),
    ] = None,
    like: Annotated[
        Path | None,
        typer.Option(
            help="What a render wrote (.zarr, .nc, .parquet, .npy): render it again, to the same "
            "bits. Only -o, --threads, and where SCENE and --eye are now, may be given with it.",
            metavar="FILE",
        ),
    ] = None,
    eye: Annotated[
        list[Path] | None,
        typer.Option(
            help="Eye file; several make one head. Default: none, the camera itself is rendered.",
            metavar="EYE",
        ),
    ] = None,
    unit: UnitOption = None,
    scene_unit: SceneUnitOption = None,
    scene_up: SceneUpOption = None,
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
    look_at: LookAtOption = None,
    path: PathOption = None,
    background: BackgroundOption = None,
    light: LightOption = None,
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
    ultraviolet: UltravioletOption = None,
    settings: Settings = _DEFAULTS,
    threads: ThreadsOption = 0,
    backend: Annotated[
        Literal["", "embree", "portable"],
        typer.Option(
            help="What traces the rays: embree, or portable, which is Omma's own. Default: the "
            "fastest there is.",
            metavar="embree|portable",
            show_default=False,
        ),
    ] = "",
    projection: Annotated[
        str | None,
        typer.Option(
            help="How an eye is shown in a .png: " + ", ".join(PROJECTIONS) + "; with _ids added, "
            "numbers of ommatidia. Default: azimuth and elevation in a frame with degrees, hatched "
            "where no ommatidium looks, with eyes whose fields overlap apart; for a camera's own "
            "eye what the camera says.",
            metavar="NAME",
        ),
    ] = None,
    width: Annotated[
        int | None,
        typer.Option(
            help="Width of a picture, in pixels; of a panel without its frame. Default: from its "
            "height, or 1024.",
            metavar="N",
        ),
    ] = None,
    height: Annotated[
        int | None,
        typer.Option(help="Height of a picture. Default: from its width.", metavar="N"),
    ] = None,
    gamma: Annotated[float, typer.Option(help="Display gamma of a .png.", metavar="GAMMA")] = 2.2,
    side_by_side: Annotated[
        bool, typer.Option("--side-by-side", help="Paint each eye apart in a .png, always.")
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
    command = shlex.join(["omma", *sys.argv[1:]])
    if like is not None:
        _check_like(context)
        with working() as bar:
            report = render_like(
                like,
                output,
                scene=scene,
                eyes=eye or (),
                threads=threads,
                command=command,
                progress=bar.show,
            )
        _print_warnings(report.warnings)
        say(*report_lines(report))
        return
    lit_by, mix = light_and_mix(light, ultraviolet)
    if mix is not None and not receptors:
        raise Error("ultraviolet: goes with --light or --receptors, found neither")
    if scene is None:
        raise typer.BadParameter("expected a scene to render, found none", param_hint="SCENE")
    options: dict[str, Any] = {
        "unit": unit,
        "threads": threads,
        "backend": backend,
        "background": background,
        "light": lit_by,
        "projection": projection,
        "width": width,
        "height": height,
        "gamma": gamma,
    }
    if all_cameras:
        _check_all_cameras(
            {
                "--eye": bool(eye),
                "--camera": camera is not None,
                "--position": position is not None,
                "--look-at": look_at is not None,
                "--path": path is not None,
                "--scene-unit": scene_unit is not None,
                "--scene-up": scene_up is not None,
                "--standard-error": standard_error,
                "--receptors": receptors,
                "--ultraviolet": mix is not None,
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
                **options,
                **settings.options(),
                progress=bar.show,
            )
        _print_warnings(everything.warnings)
        say(*camera_lines(everything))
        return
    job = RenderJob(
        scene,
        output,
        settings,
        **options,
        eyes=eye or (),
        camera=camera,
        position=position,
        look_at=look_at,
        path=path,
        scene_unit=scene_unit,
        scene_up=scene_up,
        standard_error=standard_error,
        receptors=receptors,
        ultraviolet=mix,
        side_by_side=side_by_side,
        resume=resume,
        command=command,
    )
    with working() as bar:
        report = run_job(job, bar.show)
    _print_warnings(report.warnings)
    say(*report_lines(report))


def _print_warnings(warnings: Sequence[str]) -> None:
    for warning in warnings:
        warn(warning)


def _check_like(context: typer.Context) -> None:
    for parameter in context.command.params:
        name = parameter.name or ""
        given = context.get_parameter_source(name)
        if name not in _WITH_LIKE and given is not None and given.name == "COMMANDLINE":
            raise Error(f"{parameter.opts[0]}: not together with --like, which says it")


def _check_all_cameras(others: dict[str, bool], output: list[str]) -> None:
    for name, given in others.items():
        if given:
            raise Error(f"{name}: not together with --all-cameras, which renders each as it is")
    if len(output) > 1 or Path(output[0]).suffix.lower() in SUFFIXES:
        raise Error(f"{output[-1]}: expected one folder as the output of --all-cameras")
