"""``omma eye``: a thin skin over the eye tools and the drawings."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal

from omma._core import Error
from omma.base.figures import figure_names
from omma.cli.eye_change import add_change_commands
from omma.cli.eye_convert import add_convert_command
from omma.cli.eye_files import EyeArgument, EyesArgument, OutOption, UnitOption, eye_target, save
from omma.cli.eye_look import add_look_commands
from omma.cli.eye_make import add_make_command
from omma.cli.eye_species import add_species_command
from omma.cli.help import App
from omma.cli.numbers import acceptance_angle, finite, not_below_zero
from omma.cli.parameters import option, out, switch
from omma.cli.working import check_outputs, say, working
from omma.eye.change import set_acceptance, split_eye
from omma.eye.files import load_eye, load_head, load_without_acceptance
from omma.picture.drawing import draw_eye

EYE_HELP = """
Make, change, convert, check and draw eyes.

**Examples**

`omma eye species holcocephala -o robber_fly.csv`

`omma eye make 1000 -o even.csv`

`omma eye info honeybee.eye`

`omma eye convert honeybee.eye -o honeybee.csv`
"""

SPLIT_HELP = """
Split an eye in two by the side on which its ommatidia sit, left where x is below 0.

An .eye file does not say which eye an ommatidium belongs to: write two files to keep them apart.

**Examples**

`omma eye split head.eye --left left.eye --right right.eye`

`omma eye split 1000.eye --shift-mm 1.5 --overlap-mm 0.02 -o both.eye`
"""

ACCEPTANCE_HELP = """
Set the acceptance angles of an eye by one of these rules.

--degrees: one angle for all. --factor: the present angles times this. --ratio: this times the
local interommatidial angle (the mean angle to the six nearest axes). --non-overlapping: the angle
to the nearest axis, so that cones of that width touch at most. --compoundray-maximal: the rule of
CompoundRay's adjuster, 2 (d - e/2) with d the angle to the nearest axis and e from that one to its
own nearest; cones may then overlap.

A .csv file may lack acceptance angles, as of a scan's positions and axes: all but --factor set
them.

**Examples**

`omma eye acceptance honeybee.eye --degrees 2.6 -o even.eye`

`omma eye acceptance honeybee.eye --ratio 1.1 -o sampled.eye`

`omma eye acceptance positions_and_axes.csv --ratio 1 -o eye.csv`
"""

DRAW_HELP = """
Draw an eye, to SVG and PNG, with a scale bar.

It is seen from the direction --yaw, --pitch: 0 0 is from ahead (the animal's right is then on the
left), 90 0 from its right, 0 90 from above. What faces away is left out unless --back is given.

**Examples**

`omma eye draw honeybee.eye -o bee.svg -o bee.png`

`omma eye draw honeybee.eye --yaw 60 --pitch 20 --colour acceptance -o bee.png`

`omma eye draw 1000.eye --style axes --colour none --back -o axes.svg`
"""

eye_app = App(name="eye", help=EYE_HELP, no_args_is_help=True)
add_make_command(eye_app)
add_change_commands(eye_app)
add_look_commands(eye_app)
add_species_command(eye_app)
add_convert_command(eye_app)


@eye_app.command(help=SPLIT_HELP, short_help="Split an eye in two by side.")
def split(
    eye: EyeArgument,
    output: Annotated[
        Path | None, out("File for both eyes, left first.", callback=eye_target)
    ] = None,
    left: Annotated[Path | None, option("File for the left eye.", "OUT", eye_target)] = None,
    right: Annotated[Path | None, option("File for the right eye.", "OUT", eye_target)] = None,
    shift_mm: Annotated[
        float, option("How far each is moved to its side, in mm.", "MM", finite)
    ] = 0.0,
    overlap_mm: Annotated[
        float, option("What is this near the middle goes to both, in mm.", "MM", not_below_zero)
    ] = 0.0,
    unit: UnitOption = "mm",
) -> None:
    """Split an eye in two by the side on which its ommatidia sit."""
    targets = [(output, None), (left, 0), (right, 1)]
    if all(target is None for target, _ in targets):
        raise Error("split: expected -o, --left or --right")
    with working():
        both = split_eye(load_eye(eye, unit), shift_mm / 1e3, overlap_mm / 1e3)
        for target, which in targets:
            if target is not None:
                save(target, both if which is None else both.select(which), unit)


@eye_app.command(help=ACCEPTANCE_HELP, short_help="Set acceptance angles.")
def acceptance(
    eye: EyeArgument,
    output: OutOption,
    degrees: Annotated[
        float | None, option("One angle for all, in degrees.", "DEG", acceptance_angle)
    ] = None,
    factor: Annotated[float | None, option("Times the present angles.", "FACTOR")] = None,
    ratio: Annotated[float | None, option("Times the interommatidial angle.", "RATIO")] = None,
    non_overlapping: Annotated[
        bool, switch("--non-overlapping", "The angle to the nearest axis.")
    ] = False,
    compoundray_maximal: Annotated[
        bool, switch("--compoundray-maximal", "CompoundRay's rule.")
    ] = False,
    unit: UnitOption = "mm",
) -> None:
    """Set the acceptance angles of an eye."""
    rules = [degrees is not None, factor is not None, ratio is not None]
    if sum([*rules, non_overlapping, compoundray_maximal]) != 1:
        raise Error(
            "acceptance: expected exactly one of --degrees, --factor, --ratio, --non-overlapping, "
            "--compoundray-maximal"
        )
    with working():
        load = load_without_acceptance if factor is None else load_eye
        changed = set_acceptance(
            load(eye, unit),
            angle_rad=None if degrees is None else math.radians(degrees),
            factor=factor,
            ratio=ratio,
            non_overlapping=non_overlapping,
            compoundray_maximal=compoundray_maximal,
        )
        save(output, changed, unit)


@eye_app.command(help=DRAW_HELP, short_help="Draw an eye, to SVG and PNG.")
def draw(
    eye: EyesArgument,
    output: Annotated[list[Path], out("File to write: .pdf, .svg or .png. May be repeated.")],
    yaw: Annotated[float, option("Azimuth to look from, in degrees.", "DEG", finite)] = 0.0,
    pitch: Annotated[float, option("Elevation to look from, in degrees.", "DEG", finite)] = 0.0,
    style: Annotated[
        Literal["facets", "axes", "both"], option("Facets, lines along the axes, or both.")
    ] = "facets",
    colour: Annotated[
        str,
        option(
            "What colours mean: none, a property (as in omma eye plot) or a column.", "PROPERTY"
        ),
    ] = "interommatidial",
    back: Annotated[bool, switch("--back", "Draw what faces away too.")] = False,
    axis_length_mm: Annotated[
        float | None, option("Length of the axes, in mm. Default: a tenth.", "MM")
    ] = None,
    size_mm: Annotated[float, option("Width of the drawing, in mm.", "MM")] = 150.0,
    unit: UnitOption = "mm",
) -> None:
    """Draw an eye, to SVG and PNG, with a scale bar."""
    names = figure_names(output)
    check_outputs(*output)
    with working():
        draw_eye(
            names,
            load_head(eye, unit),
            yaw_deg=yaw,
            pitch_deg=pitch,
            style=style,
            colour=colour,
            back=back,
            axis_length_mm=axis_length_mm,
            size_mm=size_mm,
        )
    for name in names:
        say(f"wrote {name}")
