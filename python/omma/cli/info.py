"""``omma info``: what is in a file, as `describe_file` says it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from omma.cli.help import App
from omma.cli.options import SceneUpOption
from omma.cli.working import say, working
from omma.job.info import describe_file
from omma.scene.building import READING

INFO_HELP = """
Say what is in a file: a scene, an eye, or responses and how they were made.

What an eye is like as an eye is measured by **omma eye info**.

**Examples**

`omma info meadow.glb`

`omma info honeybee.eye`

`omma info eye-in-micrometres.eye --unit um`

`omma info scan.stl --unit mm --up z`

`omma info flight.npy`
"""

info_app = App()


@info_app.command(help=INFO_HELP)
def info(
    file: Annotated[
        Path,
        typer.Argument(
            help="A scene (.gltf, .glb, .obj, .ply, .stl), an eye (.eye, .csv), or responses "
            "(.zarr, .nc, .parquet, .npy, .csv).",
            metavar="FILE",
        ),
    ],
    unit: Annotated[
        str | None,
        typer.Option(
            help="Unit of lengths in an .eye file (default: mm), or in an .obj, .ply or .stl file "
            "(default: m): mm, um, m or a number of metres.",
            metavar="UNIT",
        ),
    ] = None,
    up: SceneUpOption = None,
) -> None:
    """Say what is in a file."""
    with working() as bar:
        lines = describe_file(file, unit, up, bar.fraction_of(READING))
    for what, value in lines:
        say(f"{what:<16} {value}")
