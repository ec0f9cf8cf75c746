"""A camera of the scene that is no eye, rendered into files."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from omma._core import Camera, Error
from omma.base.files import WholeFiles, check_target, left_behind, make_parents
from omma.job.animated import told_at_rest
from omma.job.begun import Begun
from omma.job.outputs import earlier_files, remove_earlier
from omma.job.reports import RenderReport
from omma.picture.band_colours import colours_of
from omma.picture.cameras import display, picture_size, render_camera
from omma.picture.files import write_png
from omma.rendering.settings import Settings, fixed_samples, options_of
from omma.scene.light_words import warnings_of


def render_picture(begun: Begun, camera: Camera) -> RenderReport:
    """Render a camera into the files of a job."""
    job, names = begun.job, begun.names
    _check_arguments(begun, camera)
    width, height = picture_size(camera, job.width, job.height)
    samples = fixed_samples(job.settings.sampling, "a picture")
    world = begun.world()
    folders = make_parents(names)
    for name in names:
        check_target(name)
    built = time.perf_counter()
    picture = render_camera(
        world,
        camera,
        width=width,
        height=height,
        samples=samples,
        seed=job.settings.seed,
        progress=lambda done: begun.tell("Rendering", done),
    )
    seconds = time.perf_counter() - built
    begun.tell("Writing", None)
    with WholeFiles() as files:
        for name in names:
            if Path(name).suffix.lower() == ".npy":
                np.lib.format.write_array(files.open(name), picture)
            else:
                write_png(files, name, display(colours_of(world, picture), job.gamma))
        earlier = earlier_files(names)
    removed = remove_earlier(earlier)
    return RenderReport(
        ommatidia=0,
        poses=1,
        rays=width * height * samples,
        seconds=seconds,
        build_seconds=built - begun.started,
        writing_seconds=time.perf_counter() - built - seconds,
        frames_per_s=1 / max(seconds, 1e-9),
        backend=world.backend,
        threads=world.threads,
        view=f"camera {camera.name}, {camera.type}",
        eyes=(),
        outputs=tuple(names),
        warnings=(
            *warnings_of(world.scene, world.light is not None),
            *told_at_rest(world.scene, "a camera's picture has no time"),
            *removed,
            *left_behind(names),
        ),
        folders=folders,
        picture=(width, height),
    )


def _check_arguments(begun: Begun, camera: Camera) -> None:
    """omma.Error where what is for eyes is asked for."""
    job = begun.job
    of_eyes = {
        "standard_error": job.standard_error,
        "receptors": job.receptors,
        "projection": job.projection is not None,
        "side_by_side": job.side_by_side,
        "resume": job.resume,
        **{
            one.name: getattr(job.settings, one.name) != one.default
            for one in options_of(Settings)
            if one.name != "seed"
        },
    }
    for name, is_given in of_eyes.items():
        if is_given:
            raise Error(
                f"{name}: is for eyes; camera '{camera.name}' is {camera.type}, and no eye is given"
            )
    for name in begun.names:
        if Path(name).suffix.lower() not in (".npy", ".png"):
            raise Error(
                f"{name}: expected .npy or .png for the picture of camera '{camera.name}', which "
                f"is {camera.type}"
            )
