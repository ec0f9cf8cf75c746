"""``omma eye mirror``, ``place``, ``scale`` and ``join``: eyes changed and put together."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from omma._core import Error
from omma.cli.eye_files import EyeArgument, OutOption, UnitOption, head_of, save
from omma.cli.numbers import above_zero, finite
from omma.cli.parameters import argument, option, switch
from omma.cli.working import working
from omma.eye.change import join_eyes, mirror_eye, place_on_head, rescale_eye
from omma.eye.files import load_eye

MIRROR_HELP = """
Mirror an eye, left for right.

**Examples**

`omma eye mirror right.csv -o left.csv`

Both, as one head:

`omma eye mirror right.csv --pair -o head.csv`
"""

PLACE_HELP = """
Put an eye on a head: turn it about its origin, by yaw (to the right), then pitch (upwards), then
roll, and move it.

**Examples**

`omma eye place eye.csv --position-mm 1.2 0.1 0 --yaw 60 -o right.csv`
"""

SCALE_HELP = """
Make an eye larger or smaller: positions, focal offsets, facets; not angles.

**Examples**

`omma eye scale honeybee.csv --factor 2 -o large.csv`

`omma eye scale 1000.eye --mean-radius-mm 0.1 -o small.eye`
"""

JOIN_HELP = """
Put several eyes into one head, in the order given. Eyes of the files are kept apart where the
format holds that, as .csv and .gltf do.

**Examples**

`omma eye join left.eye right.eye -o head.csv`
"""


def add_change_commands(eye_app: typer.Typer) -> None:
    """The commands of this file."""
    eye_app.command(help=MIRROR_HELP, short_help="Mirror an eye, left for right.")(mirror)
    eye_app.command(help=PLACE_HELP, short_help="Put an eye on a head.")(place)
    eye_app.command(help=SCALE_HELP, short_help="Make an eye larger or smaller.")(scale)
    eye_app.command(help=JOIN_HELP, short_help="Put several eyes into one head.")(join)


def mirror(
    eye: EyeArgument,
    output: OutOption,
    pair: Annotated[
        bool, switch("--pair", "Write both, the left eye first: the one that it is, and its image.")
    ] = False,
    unit: UnitOption = "mm",
) -> None:
    """Mirror an eye, left for right."""
    with working():
        given = load_eye(eye, unit)
        save(output, head_of(given) if pair else mirror_eye(given), unit)


def place(
    eye: EyeArgument,
    output: OutOption,
    position_mm: Annotated[
        tuple[float, float, float],
        option("Where its origin goes (right, up, back), in mm.", "X Y Z", finite),
    ] = (0.0, 0.0, 0.0),
    yaw: Annotated[float, option("To the right, in degrees.", "DEG", finite)] = 0.0,
    pitch: Annotated[float, option("Upwards, in degrees.", "DEG", finite)] = 0.0,
    roll: Annotated[float, option("Right side down, in degrees.", "DEG", finite)] = 0.0,
    unit: UnitOption = "mm",
) -> None:
    """Put an eye on a head."""
    with working():
        position_m = [length / 1e3 for length in position_mm]
        turned = place_on_head(
            load_eye(eye, unit), position_m, yaw_deg=yaw, pitch_deg=pitch, roll_deg=roll
        )
        save(output, turned, unit)


def scale(
    eye: EyeArgument,
    output: OutOption,
    factor: Annotated[float | None, option("Times as large.", "FACTOR", above_zero)] = None,
    mean_radius_mm: Annotated[
        float | None, option("Mean distance from the origin to come to, in mm.", "MM", above_zero)
    ] = None,
    unit: UnitOption = "mm",
) -> None:
    """Make an eye larger or smaller."""
    if (factor is None) == (mean_radius_mm is None):
        raise Error("scale: expected either --factor or --mean-radius-mm")
    with working():
        radius_m = None if mean_radius_mm is None else mean_radius_mm / 1e3
        save(output, rescale_eye(load_eye(eye, unit), factor, mean_radius_m=radius_m), unit)


def join(
    eyes: Annotated[list[Path], argument("Eye files.", "EYE")],
    output: OutOption,
    unit: UnitOption = "mm",
) -> None:
    """Put several eyes into one head."""
    with working():
        save(output, join_eyes([load_eye(path, unit) for path in eyes]), unit)
