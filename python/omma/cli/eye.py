"""``omma eye``: a thin skin over the eye tools and the drawings."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal

import typer

from omma._core import Error, merge_eyes
from omma.base.figures import figure_names
from omma.cli.eye_convert import add_convert_command
from omma.cli.eye_files import EyeArgument, EyesArgument, OutOption, UnitOption, eye_target, save
from omma.cli.eye_look import add_look_commands
from omma.cli.eye_make import add_make_commands
from omma.cli.eye_species import add_species_command
from omma.cli.help import App
from omma.cli.numbers import acceptance_angle, finite, not_below_zero
from omma.cli.working import check_outputs, say, working
from omma.eye.change import set_acceptance, split_eye
from omma.eye.files import load_eye
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

**Examples**

`omma eye acceptance honeybee.eye --degrees 2.6 -o even.eye`

`omma eye acceptance honeybee.eye --ratio 1.1 -o sampled.eye`
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
add_make_commands(eye_app)
add_look_commands(eye_app)
add_species_command(eye_app)
add_convert_command(eye_app)


@eye_app.command(help=SPLIT_HELP, short_help="Split an eye in two by side.")
def split(
    eye: EyeArgument,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            help="File for both eyes, left first.",
            metavar="OUT",
            callback=eye_target,
        ),
    ] = None,
    left: Annotated[
        Path | None,
        typer.Option(help="File for the left eye.", metavar="OUT", callback=eye_target),
    ] = None,
    right: Annotated[
        Path | None,
        typer.Option(help="File for the right eye.", metavar="OUT", callback=eye_target),
    ] = None,
    shift_mm: Annotated[
        float,
        typer.Option(
            help="How far each is moved to its side, in mm.", metavar="MM", callback=finite
        ),
    ] = 0.0,
    overlap_mm: Annotated[
        float,
        typer.Option(
            help="What is this near the middle goes to both, in mm.",
            metavar="MM",
            callback=not_below_zero,
        ),
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
        float | None,
        typer.Option(
            help="One angle for all, in degrees.", metavar="DEG", callback=acceptance_angle
        ),
    ] = None,
    factor: Annotated[
        float | None, typer.Option(help="Times the present angles.", metavar="FACTOR")
    ] = None,
    ratio: Annotated[
        float | None, typer.Option(help="Times the interommatidial angle.", metavar="RATIO")
    ] = None,
    non_overlapping: Annotated[
        bool, typer.Option("--non-overlapping", help="The angle to the nearest axis.")
    ] = False,
    compoundray_maximal: Annotated[
        bool, typer.Option("--compoundray-maximal", help="CompoundRay's rule.")
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
        changed = set_acceptance(
            load_eye(eye, unit),
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
    output: Annotated[
        list[Path],
        typer.Option(
            "-o",
            "--output",
            help="File to write: .pdf, .svg or .png. May be repeated.",
            metavar="OUT",
        ),
    ],
    yaw: Annotated[
        float,
        typer.Option(help="Azimuth to look from, in degrees.", metavar="DEG", callback=finite),
    ] = 0.0,
    pitch: Annotated[
        float,
        typer.Option(help="Elevation to look from, in degrees.", metavar="DEG", callback=finite),
    ] = 0.0,
    style: Annotated[
        Literal["facets", "axes", "both"],
        typer.Option(help="Facets, lines along the axes, or both."),
    ] = "facets",
    colour: Annotated[
        str,
        typer.Option(
            help="What colours mean: none, a property (as in omma eye plot) or a column.",
            metavar="PROPERTY",
        ),
    ] = "interommatidial",
    back: Annotated[bool, typer.Option("--back", help="Draw what faces away too.")] = False,
    axis_length_mm: Annotated[
        float | None,
        typer.Option(help="Length of the axes, in mm. Default: a tenth.", metavar="MM"),
    ] = None,
    size_mm: Annotated[
        float, typer.Option(help="Width of the drawing, in mm.", metavar="MM")
    ] = 150.0,
    unit: UnitOption = "mm",
) -> None:
    """Draw an eye, to SVG and PNG, with a scale bar."""
    names = figure_names(output)
    check_outputs(*output)
    with working():
        eyes = [load_eye(path, unit) for path in eye]
        head = eyes[0] if len(eyes) == 1 else merge_eyes(eyes)
        draw_eye(
            names,
            head,
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
