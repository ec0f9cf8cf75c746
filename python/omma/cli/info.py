"""``omma info``: what is in a file, as `describe_file` says it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from omma._core import Error
from omma.base.figures import figure_names
from omma.cli.help import App
from omma.cli.options import SceneUpOption, SceneVoxelOption
from omma.cli.parameters import option, out, switch
from omma.cli.working import check_outputs, say, working
from omma.datasets.store_info import describe_store, is_store
from omma.job.info import describe_devices, describe_file
from omma.picture.capture_plots import plot_capture_cameras
from omma.scene.building import READING
from omma.scene.capture_cameras import is_capture, load_capture_cameras

INFO_HELP = """
Say what is in a file: a scene, an eye, a picture, a track, poses, spectra, or responses and how
they were made.

What an eye is like as an eye is measured by **omma eye info**.

**Examples**

`omma info meadow.glb`

`omma info honeybee.eye`

`omma info eye-in-micrometres.eye --unit um`

`omma info scan.stl --unit mm --up z`

`omma info forest.xyz`

`omma info forest.xyz --voxel-m 0.05`

`omma info garden.spz`

`omma info garden/sparse/0 -o hull.png`

`omma info flight.npy`

`omma info --devices`
"""

info_app = App()


@info_app.command(help=INFO_HELP)
def info(
    file: Annotated[
        Path | None,
        typer.Argument(
            help="A scene (.gltf, .glb, .obj, .ply, .stl), points (.las, .laz, .e57, .ply, .xyz, "
            ".pts, .asc), Gaussian splats (.ply, .spz), cameras of a capture (COLMAP's folder, "
            "transforms.json, cameras.json), an eye (.eye, .csv), a picture (.png, .jpg, "
            ".webp, .hdr, .exr), a track, poses or spectra (.csv, .txt), or responses (.zarr, .nc, "
            ".parquet, .npy, .csv).",
            metavar="FILE",
            show_default=False,
        ),
    ] = None,
    unit: Annotated[
        str | None,
        option(
            "Unit of lengths in an .eye file (default: mm), or in a file of meshes, "
            "points or splats (default: m): mm, um, m or a number of metres.",
            "UNIT",
        ),
    ] = None,
    up: SceneUpOption = None,
    voxel_m: SceneVoxelOption = None,
    output: Annotated[
        Path | None, out("Figure of the cameras of a capture to write: .pdf, .svg, .png.")
    ] = None,
    devices: Annotated[
        bool, switch("--devices", "Say what there is to trace rays with instead.")
    ] = False,
) -> None:
    """Say what is in a file."""
    if devices:
        if file is not None:
            raise Error("--devices: expected no file beside it")
        for what, value in describe_devices():
            say(f"{what:<16} {value}")
        return
    if file is None:
        raise Error("FILE: expected a file, or --devices, found neither")
    names = [] if output is None else figure_names(output)
    check_outputs(output)
    if names and not is_capture(file):
        raise Error(f"--output: is for the cameras of a capture, found {file}")
    with working() as bar:
        if is_store(file):
            lines = describe_store(file)
        else:
            lines = describe_file(file, unit, up, bar.fraction_of(READING), voxel_m=voxel_m)
        if names:
            cameras = load_capture_cameras(file, unit="m" if unit is None else unit, up=up)
            plot_capture_cameras(names, cameras)
    for what, value in lines:
        say(f"{what:<16} {value}")
    for name in names:
        say(f"wrote {name}")
