"""``omma info``: what is in a file, as `describe_file` says it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

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

`omma info flight.npy`
"""

info_app = typer.Typer(add_completion=False, rich_markup_mode="markdown")


@info_app.command(help=INFO_HELP)
def info(
    file: Annotated[
        Path,
        typer.Argument(
            help="A scene (.gltf, .glb), an eye (.eye, .csv), or responses (.zarr, .nc, .parquet, "
            ".npy, .csv).",
            metavar="FILE",
        ),
    ],
    unit: Annotated[
        str,
        typer.Option(
            help="Unit of lengths in an .eye file: mm, um, m or a number of metres.", metavar="UNIT"
        ),
    ] = "mm",
) -> None:
    """Say what is in a file."""
    with working() as bar:
        lines = describe_file(file, unit, bar.fraction_of(READING))
    for what, value in lines:
        say(f"{what:<16} {value}")
