"""``omma view``: a page in the browser that shows what an animal sees, live."""

from __future__ import annotations

import threading
import time
import webbrowser
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arguments import as_named
from omma.base.poses import look_at, poses_from_angles
from omma.cli.help import App
from omma.cli.options import (
    BackgroundOption,
    LightOption,
    LookAtOption,
    SceneArgument,
    SceneUnitOption,
    SceneUpOption,
    SceneVoxelOption,
    ThreadsOption,
    UltravioletOption,
    UnitOption,
    light_and_mix,
)
from omma.cli.parameters import option
from omma.cli.working import Terminated, warn, working
from omma.eye.files import load_head
from omma.scene.backgrounds import parse_background
from omma.scene.building import READING, build_world
from omma.scene.files import read_scene
from omma.scene.light_words import parse_light, warnings_of
from omma.view.command import Sources, absolute
from omma.view.own_eye import own_eye
from omma.view.window import WindowOptions, load_viser, open_window

VIEW_HELP = """
Show what an eye sees in a scene on a page in the browser, live, until Ctrl-C.

The head can be dragged, turned and flown through the scene; its ommatidia picked; a path played and
recorded as a video. The page says the command that renders what it shows. docs/view.md says what
everything on it does. Needs viser and aiohttp: pip install 'omma[view]'.

**Examples**

`omma view meadow.glb --eye left.eye --eye right.eye`

With the eye that a camera of the scene names:

`omma view arena.gltf`

From a camera of the scene, with a path to play, without opening a browser here:

`omma view meadow.glb --eye honeybee.eye --camera bee --path flight.csv --no-browser`

In the light of the afternoon:

`omma view meadow_lit.glb --eye honeybee.eye --light 'clear_sky sun_elevation_deg=30'`

That is lighting=path: light is followed for each ray, and the page opens at once. With
lighting=baked most of it is found first, which takes minutes in a large scene, and frames are then
faster and less noisy. It is kept below ~/.cache/omma, or below the folder that the environment
variable OMMA_CACHE names, and found there the next time:

`omma view meadow_lit.glb --eye honeybee.eye
--light 'clear_sky sun_elevation_deg=30 lighting=baked'`

A scan in millimetres, whose z axis points up:

`omma view scan.stl --scene-unit mm --scene-up z --eye honeybee.eye --position 0 1 0`

A laser scan, thinned to the mean of each centimetre:

`omma view scan.xyz --scene-voxel-m 0.01 --eye honeybee.eye --position 0 1 0`

For others on the network, who need the address with its token, which is printed:

`omma view meadow.glb --eye honeybee.eye --host 0.0.0.0 --port 8100`

Behind a proxy that shows it at an address of its own:

`omma view meadow.glb --eye honeybee.eye --port 8100 --proxy https://lab.example/bees/`
"""

view_app = App()


@view_app.command(help=VIEW_HELP)
def view(
    scene: SceneArgument,
    eye: Annotated[
        list[Path] | None,
        option(
            "Eye file; several make one head. Default: the eye that the camera names, or the "
            "first camera that names one.",
            "EYE",
        ),
    ] = None,
    unit: UnitOption = None,
    scene_unit: SceneUnitOption = None,
    scene_up: SceneUpOption = None,
    scene_voxel_m: SceneVoxelOption = None,
    camera: Annotated[
        str | None,
        option(
            "Camera of the scene where the head is at first. Default: the first; without an "
            "eye file the first that names an eye.",
            "NAME|INDEX",
        ),
    ] = None,
    position: Annotated[
        tuple[float, float, float] | None, option("Where the head is at first, in metres.", "X Y Z")
    ] = None,
    look_at_point: LookAtOption = None,
    path: Annotated[Path | None, option("CSV file of poses, to be played.", "CSV")] = None,
    background: BackgroundOption = None,
    light: LightOption = None,
    ultraviolet: UltravioletOption = None,
    samples: Annotated[int, option("Rays per ommatidium while things move.", "N")] = 4,
    threads: ThreadsOption = 0,
    host: Annotated[
        str,
        option(
            "Address to listen at; 0.0.0.0 for all. Other than this machine's own, the page "
            "has a token in its address.",
            "ADDRESS",
        ),
    ] = "127.0.0.1",
    port: Annotated[
        int | None,
        option(
            "Port to listen at; 0: any that is free. Default: the first free one from 8090 on.", "N"
        ),
    ] = None,
    proxy: Annotated[
        str | None,
        option(
            "Address at which browsers find the page, where a proxy stands before it; the "
            "page then has a token in its address.",
            "URL",
        ),
    ] = None,
    browser: Annotated[bool, option("Open the page in a browser here.")] = True,
) -> None:
    """Show what an eye sees in a scene on a page in the browser, live."""
    load_viser()
    if look_at_point is not None and position is None:
        raise Error("look_at: needs a position to look from")
    if camera is not None and position is not None:
        raise Error("camera and position: only one of them can say where the head is")
    lit_by, mix = light_and_mix(light, ultraviolet)
    with working() as bar:
        bar.show(READING, None)
        with as_named(unit="scene_unit", up="scene_up", voxel_m="scene_voxel_m"):
            read = read_scene(
                scene,
                None,
                unit=scene_unit,
                up=scene_up,
                voxel_m=scene_voxel_m,
                progress=bar.fraction_of(READING),
            )
        node = None if camera is None else read.camera(camera)
        if eye:
            unit = unit or "mm"
            head = load_head(eye, unit)
            files = tuple(map(absolute, eye))
        else:
            head, node, unit = own_eye(read, camera, unit)
            files = (absolute(head.path),)
        world = build_world(
            read,
            bar.show,
            threads=threads,
            background=None if background is None else parse_background(background),
            **({} if lit_by is None else parse_light(lit_by)),
        )
        pose: NDArray[np.float64] | None = None
        if position is not None and look_at_point is not None:
            pose = look_at(position, look_at_point)
        elif position is not None:
            pose = poses_from_angles(position, (0, 0, 0))[0]
        elif node is not None:
            pose = node.world_from_camera
        bar.show("Preparing the page", None)
        file = (
            background
            if background is None or not Path(background).exists()
            else (absolute(background))
        )
        window = open_window(
            world,
            head,
            Sources(
                absolute(scene),
                files,
                unit,
                file,
                lit_by,
                scene_unit=scene_unit,
                scene_up=scene_up,
                scene_voxel_m=scene_voxel_m,
            ),
            WindowOptions(
                pose=pose,
                samples=samples,
                path=None if path is None else str(path),
                ultraviolet=mix,
                threads=threads,
                host=host,
                port=port,
                proxy=proxy,
            ),
        )
    for warning in warnings_of(read, lit_by is not None):
        warn(warning)
    print(window.url, flush=True)
    print("Ctrl-C ends it.", flush=True)
    if browser:
        # Some browsers keep whoever starts them waiting.
        threading.Thread(target=webbrowser.open, args=(window.url,), daemon=True).start()
    try:
        while True:
            time.sleep(3600)
    except Terminated:
        raise
    except KeyboardInterrupt:
        pass  # how it is meant to end
    finally:
        window.close()
