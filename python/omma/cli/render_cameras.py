"""``omma render-cameras``: a thin skin over `render_all_cameras`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from omma._core import Error
from omma.cli.help import App
from omma.cli.options import (
    BackendOption,
    BackgroundOption,
    DeviceOption,
    GammaOption,
    HeightOption,
    LightOption,
    ThreadsOption,
    WidthOption,
    light_and_mix,
    takes_settings,
)
from omma.cli.parameters import argument, option, out
from omma.cli.report import say_cameras
from omma.cli.working import working
from omma.job.all_cameras import render_all_cameras
from omma.job.outputs import SUFFIXES
from omma.picture.projections import PROJECTIONS
from omma.rendering.settings import Fixed, Settings

CAMERAS_HELP = """
Render every camera of a scene, each into a picture of its own, named after the camera.

Cameras are compound, perspective, orthographic or panoramic; a compound one is shown through the
eye file that it names.

**Examples**

`omma render-cameras arena.gltf -o pictures/`

Small ones, all eyes in one projection:

`omma render-cameras arena.gltf --width 64 --samples 4 --projection lambert -o small`

In the light of a clear morning:

`omma render-cameras arena.gltf --light 'clear_sky sun_elevation_deg=30' --ultraviolet dark
--width 64 -o morning`
"""

cameras_app = App()

_DEFAULTS = Settings()


@cameras_app.command(help=CAMERAS_HELP)
@takes_settings(ways=(Fixed,), without=("noise",))  # pictures take no others
def render_cameras(
    scene: Annotated[Path, argument("Scene: .gltf or .glb.", "SCENE")],
    output: Annotated[list[str], out("Folder to write; made where it is missing.", "FOLDER")],
    unit: Annotated[
        str | None,
        option(
            "Unit of lengths in the cameras' eye files: mm, um, m or a number of metres. "
            "Default: the scene's unit.",
            "UNIT",
        ),
    ] = None,
    background: BackgroundOption = None,
    light: LightOption = None,
    ultraviolet: Annotated[
        str | None,
        option(
            "With --light: what surfaces reflect below 400 nm, where RGB says nothing: dark, "
            "nothing; as_blue, as much as blue; or a number from 0 to 1.",
            "dark|as_blue|NUMBER",
        ),
    ] = None,
    settings: Settings = _DEFAULTS,
    threads: ThreadsOption = 0,
    backend: BackendOption = "",
    device: DeviceOption = None,
    projection: Annotated[
        str | None,
        option(
            "How eyes are shown: " + ", ".join(PROJECTIONS) + "; with _ids added, numbers of "
            "ommatidia. Default: what each camera says.",
            "NAME",
        ),
    ] = None,
    width: WidthOption = None,
    height: HeightOption = None,
    gamma: GammaOption = 2.2,
) -> None:
    """Render every camera of a scene."""
    lit_by, mix = light_and_mix(light, ultraviolet)
    if mix is not None:
        raise Error("ultraviolet: goes with --light, found none")
    if len(output) > 1 or Path(output[0]).suffix.lower() in SUFFIXES:
        raise Error(f"{output[-1]}: expected one folder as the output")
    with working() as bar:
        report = render_all_cameras(
            scene,
            output[0],
            settings.sampling,
            unit=unit,
            threads=threads,
            backend=backend,
            devices=tuple(device or ()),
            background=background,
            light=lit_by,
            projection=projection,
            width=width,
            height=height,
            gamma=gamma,
            progress=bar.show,
            **settings.options(),
        )
    say_cameras(report)
