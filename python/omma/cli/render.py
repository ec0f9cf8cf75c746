"""``omma render``: a thin skin over `render_file`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from omma._core import Error
from omma.cli.help import App
from omma.cli.options import (
    BackendOption,
    BackgroundOption,
    CaptureCamerasOption,
    CaptureUnitOption,
    CaptureUpOption,
    DeviceOption,
    GammaOption,
    GroundOption,
    HeightOption,
    LightOption,
    LookAtOption,
    LostOption,
    OnGroundOption,
    PathOption,
    SceneArgument,
    SceneUnitOption,
    SceneUpOption,
    SceneVoxelOption,
    ThreadsOption,
    UltravioletOption,
    UnitOption,
    WidthOption,
    command_typed,
    light_and_mix,
    takes_settings,
)
from omma.cli.parameters import option, out, switch
from omma.cli.render_before import RenderCommand
from omma.cli.report import say_report
from omma.cli.working import working
from omma.job.render_job import RenderJob
from omma.job.rendering import run_job
from omma.picture.projections import PROJECTIONS
from omma.rendering.settings import Settings

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

As many rays as each ommatidium needs for a standard error of 0.01, at most 1,024:

`omma render meadow.glb --eye honeybee.eye --error 0.01 --most 1024
-o view.npy`

A path of many poses, with standard errors (flight.npy, flight.error.npy; flight.json says what
they are):

`omma render meadow.glb --eye honeybee.eye --path flight.csv --samples 64 --standard-error
-o flight.npy`

The path as a video, 30 poses a second (pip install 'omma[video]'):

`omma render meadow.glb --eye left.eye --eye right.eye --path flight.csv -o flight.mp4`

An ant's track on the ground, its head 3 mm above it:

`omma render meadow.glb --eye ant.eye --path track.csv --on-ground 0.003 --ground land
-o walk.npy`

A laser scan, thinned to the mean of each centimetre:

`omma render scan.xyz --scene-voxel-m 0.01 --eye honeybee.eye --position 0 1 0
-o place.png`

Beside each response how near a camera was, of a place known from photographs:

`omma render garden.spz --capture-cameras garden/sparse/0 --eye honeybee.eye --path flight.csv
-o near.nc -o near.csv`

A path that takes hours; after Ctrl-C, a kill or a loss of power the same command goes on from where
it was, to the same numbers:

`omma render meadow.glb --eye honeybee.eye --path flight.csv --samples 4096 --resume
-o flight.npy`

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

And what those of a dorsal rim answer to the sky's polarisation, which is followed where the light
says so:

`omma render meadow_lit.glb --eye rim.csv --receptors
--light 'clear_sky sun_elevation_deg=20 polarized=True' -o rim_receptors.csv`

The path is a CSV file with a header, x,y,z,qx,qy,qz,qw or x,y,z,yaw_deg,pitch_deg,roll_deg; with
--on-ground x_m,z_m or x_m,z_m,heading_deg. Each may have times, t_s, which the files then say and
videos have the rate of; the scene's animations move it by them. Without times it is rendered at
rest, and videos show 30 poses a second.

**omma render-again** renders again what an earlier render wrote; **omma render-cameras** renders
every camera of a scene.
"""

render_app = App()

_DEFAULTS = Settings()


@render_app.command(help=RENDER_HELP, cls=RenderCommand)
@takes_settings()
def render(
    scene: SceneArgument,
    output: Annotated[
        list[str],
        out(
            "File to write: .png, or of an eye .zarr, .nc, .parquet, .npy (a .json beside "
            "it), .csv or .mp4; may be given several times. Its folder is made where it is missing."
        ),
    ],
    eye: Annotated[
        list[Path] | None,
        option(
            "Eye file; several make one head. Default: none, the camera itself is rendered.", "EYE"
        ),
    ] = None,
    unit: UnitOption = None,
    scene_unit: SceneUnitOption = None,
    scene_up: SceneUpOption = None,
    scene_voxel_m: SceneVoxelOption = None,
    capture_cameras: CaptureCamerasOption = None,
    capture_unit: CaptureUnitOption = None,
    capture_up: CaptureUpOption = None,
    camera: Annotated[
        str | None,
        option(
            "Camera of the scene to render, or to look from with an eye. Default: the first; "
            "without an eye the first compound one, where there is one.",
            "NAME|INDEX",
        ),
    ] = None,
    position: Annotated[
        tuple[float, float, float] | None, option("Where the head is, in metres.", "X Y Z")
    ] = None,
    look_at: LookAtOption = None,
    path: PathOption = None,
    on_ground: OnGroundOption = None,
    ground: GroundOption = None,
    lost: LostOption = "refuse",
    background: BackgroundOption = None,
    light: LightOption = None,
    standard_error: Annotated[
        bool,
        switch(
            "--standard-error",
            "Write standard errors too: 8 times the rays, but none more with --error.",
        ),
    ] = False,
    receptors: Annotated[
        bool,
        switch(
            "--receptors",
            "Write what the eye's receptors answer: .npy [pose, receptor], and .csv with a "
            "line for each pose and receptor.",
        ),
    ] = False,
    ultraviolet: UltravioletOption = None,
    settings: Settings = _DEFAULTS,
    threads: ThreadsOption = 0,
    backend: BackendOption = "",
    device: DeviceOption = None,
    projection: Annotated[
        str | None,
        option(
            "How an eye is shown in a .png: " + ", ".join(PROJECTIONS) + "; with _ids added, "
            "numbers of ommatidia. Default: azimuth and elevation in a frame with degrees, hatched "
            "where no ommatidium looks, with eyes whose fields overlap apart; for a camera's own "
            "eye what the camera says.",
            "NAME",
        ),
    ] = None,
    width: WidthOption = None,
    height: HeightOption = None,
    gamma: GammaOption = 2.2,
    side_by_side: Annotated[
        bool, switch("--side-by-side", "Paint each eye apart in a .png, always.")
    ] = False,
    resume: Annotated[
        bool,
        switch(
            "--resume",
            "Of a --path: keep what is rendered when cut off (OUT.partial, OUT.resume), and "
            "go on from there where that is left of the same inputs.",
        ),
    ] = False,
) -> None:
    """Render what an eye sees in a scene, or a camera of the scene."""
    lit_by, mix = light_and_mix(light, ultraviolet)
    if mix is not None and not receptors:
        raise Error("ultraviolet: goes with --light or --receptors, found neither")
    job = RenderJob(
        scene,
        output,
        settings,
        eyes=eye or (),
        unit=unit,
        camera=camera,
        position=position,
        look_at=look_at,
        path=path,
        on_ground=on_ground,
        ground=tuple(ground or ()),
        lost=lost,
        scene_unit=scene_unit,
        scene_up=scene_up,
        scene_voxel_m=scene_voxel_m,
        capture_cameras=capture_cameras,
        capture_unit=capture_unit,
        capture_up=capture_up,
        threads=threads,
        backend=backend,
        devices=tuple(device or ()),
        background=background,
        light=lit_by,
        standard_error=standard_error,
        receptors=receptors,
        ultraviolet=mix,
        projection=projection,
        width=width,
        height=height,
        gamma=gamma,
        side_by_side=side_by_side,
        resume=resume,
        command=command_typed(),
    )
    with working() as bar:
        report = run_job(job, bar.show)
    say_report(report)
