"""``omma render-again``: a thin skin over `render_like`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from omma.cli.help import App
from omma.cli.options import ThreadsOption, command_typed
from omma.cli.parameters import argument, option, out
from omma.cli.report import say_report
from omma.cli.working import working
from omma.job.again import render_like

AGAIN_HELP = """
Render again what an earlier render wrote, to the same bits.

Poses, settings, seed, light and background are those that the file says; scene and eyes must be
what they were. The bits are the same for the same version of Omma on the same kind of processor.

**Examples**

`omma render-again flight.npy -o again.zarr`

In one thread, into two files:

`omma render-again flight.npy --threads 1 -o again.nc -o again.csv`

Where the scene and the eye have moved since, say where they are now:

`omma render-again bee.npy moved/arena.gltf --eye moved/bee.eye -o again.npy`
"""

again_app = App()


@again_app.command(help=AGAIN_HELP)
def render_again(
    file: Annotated[
        Path, argument("What a render wrote: .zarr, .nc, .parquet, or .npy with its .json.", "FILE")
    ],
    output: Annotated[
        list[str],
        out(
            "File to write, as of omma render; may be given several times. Its folder is made "
            "where it is missing."
        ),
    ],
    scene: Annotated[
        Path | None, argument("Where the scene is now. Default: where it was.", "SCENE")
    ] = None,
    eye: Annotated[
        list[Path] | None,
        option(
            "Where the eye file is now; all of them, where there are several. Default: where "
            "they were.",
            "EYE",
        ),
    ] = None,
    threads: ThreadsOption = 0,
) -> None:
    """Render again what an earlier render wrote."""
    with working() as bar:
        report = render_like(
            file,
            output,
            scene=scene,
            eyes=eye or (),
            threads=threads,
            command=command_typed(),
            progress=bar.show,
        )
    say_report(report)
