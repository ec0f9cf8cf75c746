"""``omma measure``: rays a scene needs, variance maps, the alias demonstration, the speed test."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import typer
from numpy.typing import ArrayLike

from omma._core import Error, Eye
from omma.base.arguments import whole
from omma.base.poses import load_poses
from omma.cli.help import App
from omma.cli.measure_inputs import (
    CameraOption,
    EyeFiles,
    MeasureOption,
    Outputs,
    PointsOption,
    PositionOption,
    SceneFile,
    SeedOption,
    SensitivityOption,
    files_to_write,
    pose_of,
    renderer_of,
    say_written,
    scene_of,
)
from omma.cli.numbers import above_zero, not_below_zero
from omma.cli.options import (
    EyeUnitOption,
    OldKernelOption,
    PathOption,
    SceneArgument,
    SceneUnitOption,
    SceneUpOption,
    SceneVoxelOption,
    ThreadsOption,
    sensitivity_of,
)
from omma.cli.parameters import option, out, switch
from omma.cli.working import say, working
from omma.eye.files import load_eye, load_head
from omma.rendering.settings import MAX_SAMPLES
from omma.study.plots import (
    save_alias_curves,
    save_minimum_samples,
    save_speed_test,
    save_variance_map,
)
from omma.study.search import Box, Cylinder, MinimumSamples, minimum_samples
from omma.study.speed_test import measure_speed
from omma.study.variance import (
    COMPOUNDRAY,
    OURS,
    Method,
    alias_curve,
    rays_per_ommatidium,
    solid_angles_sr,
    variance_map,
)

MEASURE_HELP = """
Measure scatter and speed: rays needed, variance maps, aliasing, frames/s.

**Examples**

`omma measure min-samples arena.gltf --cylinder 0 0 0 9 9 --eye honeybee.eye`

`omma measure speed meadow.glb --eye honeybee.eye --rays 1,16,256 --frames 20`
"""

MIN_SAMPLES_HELP = """
Find the rays per steradian at which responses scatter by no more than a share of full scale.

The worst position within a box, a cylinder or along a path is searched for with twelve ommatidia of
1 sr, for CompoundRay's sampling and for Omma's. Keep the box clear of the inside of objects and of
the ground: nothing else does.

**Examples**

`omma measure min-samples arena.gltf --cylinder 0 0 0 9 9 --eye honeybee.eye`

`omma measure min-samples arena.gltf --box -5 1 -5 5 8 5 --measure compoundray -o curves.png`

`omma measure min-samples meadow.glb --path flight.csv --fraction 0.02 -o curves.csv`
"""

MAP_HELP = """
Map how much the light varies over a horizontal square of a scene, seen by 1 sr ommatidia.

**Examples**

`omma measure variance-map arena.gltf --centre 0 2 0 --size 18 -o map.png -o map.csv`

`omma measure variance-map meadow.glb --centre 0 1 0 --size 20 --steps 41 --statistic mean
-o map.npy`
"""

ALIASING_HELP = """
Measure how far the responses of an eye scatter, against rays per ommatidium.

**Examples**

`omma measure aliasing meadow.glb --eye honeybee.eye --camera bee -o aliasing.png`

`omma measure aliasing arena.gltf --eye 1000.eye --position 0 2 0 --most-rays 64 -o aliasing.csv`
"""

SPEED_HELP = """
Time frames against rays per ommatidium, as CompoundRay's speed test does.

The published test has an eye of 1,000 ommatidia of 2.6°. Leave the machine alone meanwhile.

**Examples**

`omma measure speed arena.gltf --eye 1000-equidistant.eye --camera panoramic -o speed.png`

`omma measure speed meadow.glb --eye honeybee.eye --rays 1,16,256 --frames 20 -o speed.csv`
"""

measure_app = App(help=MEASURE_HELP, no_args_is_help=True)


@measure_app.command("min-samples", help=MIN_SAMPLES_HELP, short_help="Rays a scene needs.")
def min_samples_command(
    scene: SceneArgument,
    box: Annotated[
        tuple[float, float, float, float, float, float] | None,
        option("Lower and upper corner, m.", "X Y Z X Y Z"),
    ] = None,
    cylinder: Annotated[
        tuple[float, float, float, float, float] | None,
        option("Middle of the base of an upright cylinder, radius, height, m.", "X Y Z R H"),
    ] = None,
    path: PathOption = None,
    eye: Annotated[
        list[Path] | None, option("Say the rays per ommatidium for this eye too.", "EYE")
    ] = None,
    unit: EyeUnitOption = "mm",
    scene_unit: SceneUnitOption = None,
    scene_up: SceneUpOption = None,
    scene_voxel_m: SceneVoxelOption = None,
    fraction: Annotated[float, option("Standard deviation over full scale.", "SHARE")] = 0.01,
    measure: MeasureOption = "linear",
    poses: Annotated[int, option("Poses tried before refining.", "N")] = 4096,
    seed: SeedOption = 0,
    threads: ThreadsOption = 0,
    output: Outputs = None,
) -> None:
    """Find the rays per steradian that a scene needs."""
    write = files_to_write(output, ".csv", ".png")
    given = [box is not None, cylinder is not None, path is not None]
    if sum(given) != 1:
        raise Error("where: expected one of --box, --cylinder and --path")
    with working() as bar:
        where: Box | Cylinder | ArrayLike
        if box is not None:
            where = Box(box[:3], box[3:])
        elif cylinder is not None:
            where = Cylinder(cylinder[:3], *cylinder[3:])
        else:
            where = load_poses(path)  # type: ignore[arg-type]
        world = renderer_of(SceneFile(scene, scene_unit, scene_up, scene_voxel_m), threads, bar)
        eyes = [(name, load_eye(name, unit)) for name in eye or ()]
        found = [
            minimum_samples(
                world,
                where,
                fraction=fraction,
                method=method,
                measure=measure,
                poses=poses,
                seed=seed,
                threads=threads,
                progress=bar.show,
            )
            for method in (COMPOUNDRAY, OURS)
        ]
        for name in write:
            save_minimum_samples(name, found)
    for one in found:
        say(*_search_lines(one, eyes), "")
    say_written(write)


@measure_app.command("variance-map", help=MAP_HELP, short_help="Map of the variance of the light.")
def variance_map_command(
    scene: SceneArgument,
    centre: Annotated[tuple[float, float, float], option("Middle of the square, m.", "X Y Z")],
    size: Annotated[float, option("Side of the square, m.", "M", above_zero)],
    output: Annotated[list[Path], out(".npy, .csv or .png.")],
    scene_unit: SceneUnitOption = None,
    scene_up: SceneUpOption = None,
    scene_voxel_m: SceneVoxelOption = None,
    steps: Annotated[int, option("Cells along a side.", "N")] = 21,
    statistic: Annotated[Literal["max", "mean"], option("Of the twelve ommatidia.")] = "max",
    variance: Annotated[
        bool, switch("--variance", "Write variances, not standard deviations.")
    ] = False,
    measure: MeasureOption = "linear",
    angular_sensitivity: SensitivityOption = "compoundray",
    kernel: OldKernelOption = None,
    points: PointsOption = "random",
    rays: Annotated[int, typer.Option(help="Rays per estimate.", metavar="N", min=1)] = 1,
    repeats: Annotated[int, option("Estimates per ommatidium.", "N")] = 1024,
    seed: SeedOption = 0,
    threads: ThreadsOption = 0,
) -> None:
    """Map how much the light varies."""
    write = files_to_write(output, ".npy", ".csv", ".png")
    with working() as bar:
        found = variance_map(
            renderer_of(SceneFile(scene, scene_unit, scene_up, scene_voxel_m), threads, bar),
            centre,
            size,
            steps=steps,
            statistic=statistic,
            rays=rays,
            repeats=repeats,
            method=Method(sensitivity_of(angular_sensitivity, kernel), points),
            measure=measure,
            seed=seed,
            threads=threads,
            progress=bar.show,
        )
        for name in write:
            save_variance_map(
                name,
                found,
                centre,
                size,
                measure=measure,
                statistic=statistic,
                as_variance=variance,
            )
    deviations = np.sqrt(found)
    say(f"cells      {steps} x {steps}, {size / steps:.4g} m wide, at y = {centre[1]:g} m")
    say(f"deviation  {deviations.min():.4g} to {deviations.max():.4g}, {measure}")
    say_written(write)


@measure_app.command("aliasing", help=ALIASING_HELP, short_help="Scatter of an eye's responses.")
def aliasing_command(
    scene: SceneArgument,
    eye: EyeFiles,
    unit: EyeUnitOption = "mm",
    scene_unit: SceneUnitOption = None,
    scene_up: SceneUpOption = None,
    scene_voxel_m: SceneVoxelOption = None,
    camera: CameraOption = None,
    position: PositionOption = None,
    most_rays: Annotated[int, option("Largest number of rays.", "N")] = 512,
    repeats: Annotated[int, option("Estimates per response.", "N")] = 64,
    measure: MeasureOption = "linear",
    seed: SeedOption = 0,
    threads: ThreadsOption = 0,
    output: Outputs = None,
) -> None:
    """Measure how far the responses of an eye scatter."""
    write = files_to_write(output, ".csv", ".png")
    rays = [2**k for k in range(max(1, most_rays).bit_length())]
    with working() as bar:
        read = SceneFile(scene, scene_unit, scene_up, scene_voxel_m)
        world, head = renderer_of(read, threads, bar), load_head(eye, unit)
        pose = pose_of(world.scene, camera, position)
        curves = {
            method: alias_curve(
                world,
                head,
                pose,
                rays,
                repeats=repeats,
                method=method,
                measure=measure,
                seed=seed,
                threads=threads,
                progress=bar.show,
            )
            for method in (COMPOUNDRAY, OURS)
        }
        for name in write:
            save_alias_curves(name, rays, curves, measure=measure)
    say("root mean square of the standard deviation of responses")
    say(f"{'rays':>6}  {'CompoundRay':>12}  {'Omma':>12}")
    for n, theirs, ours in zip(rays, curves[COMPOUNDRAY][1], curves[OURS][1], strict=True):
        say(f"{n:>6}  {theirs:12.5g}  {ours:12.5g}")
    say_written(write)


@measure_app.command("speed", help=SPEED_HELP, short_help="Frames/s against rays.")
def speed_command(
    scene: SceneArgument,
    eye: EyeFiles,
    unit: EyeUnitOption = "mm",
    scene_unit: SceneUnitOption = None,
    scene_up: SceneUpOption = None,
    scene_voxel_m: SceneVoxelOption = None,
    camera: CameraOption = None,
    position: PositionOption = None,
    rays: Annotated[
        str, option("Rays per ommatidium, separated by commas.", "N,N,...")
    ] = "1,3,10,30,100,300,1000,3200",
    frames: Annotated[int, option("Frames timed for each.", "N")] = 100,
    warm_up: Annotated[float, option("Seconds to warm up.", "S", not_below_zero)] = 10.0,
    angular_sensitivity: SensitivityOption = "gaussian",
    kernel: OldKernelOption = None,
    points: PointsOption = "low_discrepancy",
    threads: ThreadsOption = 0,
    output: Outputs = None,
) -> None:
    """Time frames against rays per ommatidium."""
    write = files_to_write(output, ".csv", ".png")
    try:
        counts = [whole(int(part), "rays", 1, MAX_SAMPLES) for part in rays.split(",")]
    except ValueError:
        raise Error(f"rays: expected whole numbers separated by commas, found '{rays}'") from None
    with working() as bar:
        world = scene_of(SceneFile(scene, scene_unit, scene_up, scene_voxel_m), bar)
        head = load_head(eye, unit)
        found = measure_speed(
            world,
            head,
            pose_of(world, camera, position),
            counts,
            frames=frames,
            warm_up_s=warm_up,
            method=Method(sensitivity_of(angular_sensitivity, kernel), points),
            threads=threads,
            progress=bar.show,
        )
        for name in write:
            save_speed_test(name, found)
    say(f"machine    {found.machine}, {found.threads} threads, {found.backend}")
    say(f"eye        {found.ommatidia:,} ommatidia; mean of {frames} frames")
    say(f"{'rays':>6}  {'frames/s':>10}  {'in one call':>11}")
    for n, alone, batch in zip(counts, found.frames_per_s, found.batch_frames_per_s, strict=True):
        say(f"{n:>6}  {alone:>10,.1f}  {batch:>11,.1f}")
    say_written(write)


def _search_lines(found: MinimumSamples, eyes: Sequence[tuple[Path, Eye]]) -> list[str]:
    position = " ".join(f"{v:.3f}" for v in found.pose[:3, 3])
    lines = [
        ("method", found.method.name),
        ("measure", f"{found.measure}, limit {found.limit:.4g}"),
        ("needs", f"{found.rays_per_sr:,} rays/sr (± {100 * found.relative_error:.1g} %)"),
        ("worst at", f"{position} m, ommatidium {found.ommatidium}"),
        ("scatter", f"{found.spread:.4g} at {found.spread_rays} rays/sr there"),
        (
            "search",
            f"{found.poses_rendered:,} poses, {found.rays_traced:,} rays, {found.seconds:.1f} s",
        ),
    ]
    if found.script_rays_per_sr is not None:
        lines.insert(
            3, ("script", f"CompoundRay's would stop at about {found.script_rays_per_sr:,}")
        )
    for name, eye in eyes:
        count = rays_per_ommatidium(eye, found.rays_per_sr)
        widest = solid_angles_sr(eye).max()
        lines.append(("eye", f"{name}: {count:,} rays per ommatidium (widest {widest:.4g} sr)"))
    return [f"{what:<10} {value}" for what, value in lines]
