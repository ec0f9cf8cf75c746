"""``omma eye``: a thin skin over the eye tools, the drawings and the generator."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import typer

from omma._core import Error, Eye, merge_eyes
from omma.cli_eye_look import add_look_commands
from omma.cli_working import working
from omma.eye_design import AcuteZone, acute_zones, generate_eye
from omma.eye_drawing import draw_eye
from omma.eye_tools import convert_eye, rescale_eye, set_acceptance, split_eye
from omma.figure_files import figure_names
from omma.files import check_target, load_eye, save_eye

RESCALE_HELP = """
Make an eye larger or smaller: positions and focal offsets, not angles.

**Examples**

`omma eye rescale honeybee.eye --factor 2 -o large.eye`

`omma eye rescale 1000.eye --mean-radius-mm 0.1 -o small.eye`
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

CONVERT_HELP = """
Convert an old eye file of 7 or 9 columns to today's 8.

What is assumed and what is lost is printed: 7 columns have no focal offset, which becomes 0; of 9
the first 8 are kept, as CompoundRay reads them, and the ninth is dropped.

**Examples**

`omma eye convert old.eye -o new.eye`

`omma eye convert old-in-degrees.eye --degrees -o new.eye`
"""

GENERATE_HELP = """
Make an eye of N ommatidia spread evenly over a sphere or an ellipsoid, or with acute zones.

An acute zone has FACTOR times as many ommatidia per steradian at its centre as there would be
without it, and falls off as a Gaussian of full width at half maximum WIDTH. Azimuth 0 is ahead and
grows to the right. Several zones multiply. Axes are normal to the surface.

**Examples**

`omma eye generate 1000 -o even.eye`

`omma eye generate 3000 --semi-axes-mm 0.8 1.4 0.9 --acceptance-ratio 1.2 -o oval.eye`

`omma eye generate 2000 --acute-zone 0,20,40,6 -o acute.eye`

`omma eye generate 2000 --acute-band 0,20,4 -o horizon.eye`
"""

eye_app = typer.Typer(
    name="eye",
    help="Rescale, split, draw, convert and make eyes.",
    no_args_is_help=True,
    rich_markup_mode="markdown",
)
add_look_commands(eye_app)

EyeArgument = Annotated[Path, typer.Argument(help="Eye file.", metavar="EYE")]
OutOption = Annotated[
    Path, typer.Option("-o", "--output", help="Eye file to write.", metavar="OUT")
]
UnitOption = Annotated[
    str,
    typer.Option(
        help="Unit of lengths in eye files: mm, um, m or a number of metres.", metavar="UNIT"
    ),
]


@eye_app.command(help=RESCALE_HELP, short_help="Make an eye larger or smaller.")
def rescale(
    eye: EyeArgument,
    output: OutOption,
    factor: Annotated[float | None, typer.Option(help="Times as large.", metavar="FACTOR")] = None,
    mean_radius_mm: Annotated[
        float | None,
        typer.Option(help="Mean distance from the origin to come to, in mm.", metavar="MM"),
    ] = None,
    unit: UnitOption = "mm",
) -> None:
    """Make an eye larger or smaller."""
    if (factor is None) == (mean_radius_mm is None):
        raise Error("rescale: expected either --factor or --mean-radius-mm")
    with working():
        radius_m = None if mean_radius_mm is None else mean_radius_mm / 1e3
        _save(output, rescale_eye(load_eye(eye, unit), factor, mean_radius_m=radius_m), unit)


@eye_app.command(help=SPLIT_HELP, short_help="Split an eye in two by side.")
def split(
    eye: EyeArgument,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="File for both eyes, left first.", metavar="OUT"),
    ] = None,
    left: Annotated[Path | None, typer.Option(help="File for the left eye.", metavar="OUT")] = None,
    right: Annotated[
        Path | None, typer.Option(help="File for the right eye.", metavar="OUT")
    ] = None,
    shift_mm: Annotated[
        float, typer.Option(help="How far each is moved to its side, in mm.", metavar="MM")
    ] = 0.0,
    overlap_mm: Annotated[
        float,
        typer.Option(help="What is this near the middle goes to both, in mm.", metavar="MM"),
    ] = 0.0,
    unit: UnitOption = "mm",
) -> None:
    """Split an eye in two by the side on which its ommatidia sit."""
    targets = [(output, None), (left, 0), (right, 1)]
    if all(target is None for target, _ in targets):
        raise Error("split: expected -o, --left or --right")
    for target, _ in targets:
        if target is not None:
            check_target(str(target))
    with working():
        both = split_eye(load_eye(eye, unit), shift_mm / 1e3, overlap_mm / 1e3)
        for target, which in targets:
            if target is not None:
                _save(target, both if which is None else both.select(which), unit)


@eye_app.command(help=ACCEPTANCE_HELP, short_help="Set acceptance angles.")
def acceptance(
    eye: EyeArgument,
    output: OutOption,
    degrees: Annotated[
        float | None, typer.Option(help="One angle for all, in degrees.", metavar="DEG")
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
        _save(output, changed, unit)


@eye_app.command(help=DRAW_HELP, short_help="Draw an eye, to SVG and PNG.")
def draw(
    eye: Annotated[
        list[Path],
        typer.Argument(help="Eye file; several make one head.", metavar="EYE..."),
    ],
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
        float, typer.Option(help="Azimuth to look from, in degrees.", metavar="DEG")
    ] = 0.0,
    pitch: Annotated[
        float, typer.Option(help="Elevation to look from, in degrees.", metavar="DEG")
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
        print(f"wrote {name}")


@eye_app.command(help=CONVERT_HELP, short_help="Convert an old eye file.")
def convert(
    eye: EyeArgument,
    output: OutOption,
    degrees: Annotated[
        bool, typer.Option("--degrees", help="The file's acceptance angles are degrees.")
    ] = False,
    unit: UnitOption = "mm",
) -> None:
    """Convert an old eye file to today's columns."""
    with working():
        converted = convert_eye(eye, unit, degrees=degrees)
        _save(output, converted.eye, unit)
    for note in converted.notes:
        print(f"omma: warning: {eye}: {note}", file=sys.stderr)


@eye_app.command(help=GENERATE_HELP, short_help="Make an eye.")
def generate(
    count: Annotated[int, typer.Argument(help="Number of ommatidia.", metavar="N")],
    output: OutOption,
    radius_mm: Annotated[
        float | None, typer.Option(help="Radius of a sphere, in mm. Default: 1.", metavar="MM")
    ] = None,
    semi_axes_mm: Annotated[
        tuple[float, float, float] | None,
        typer.Option(
            help="Of an ellipsoid: half its width (right), height and length, in mm.",
            metavar="X Y Z",
        ),
    ] = None,
    acute_zone: Annotated[
        list[str] | None,
        typer.Option(
            help="Acute zone: azimuth, elevation and width in degrees, and factor. "
            "May be repeated.",
            metavar="AZ,EL,WIDTH,FACTOR",
        ),
    ] = None,
    acute_band: Annotated[
        list[str] | None,
        typer.Option(
            help="Acute zone all around: elevation and width in degrees, and factor. "
            "May be repeated.",
            metavar="EL,WIDTH,FACTOR",
        ),
    ] = None,
    acceptance_ratio: Annotated[
        float,
        typer.Option(help="Acceptance angle over interommatidial angle.", metavar="RATIO"),
    ] = 1.0,
    seed: Annotated[int, typer.Option(help="Seed of the arrangement.", metavar="N")] = 0,
    unit: UnitOption = "mm",
) -> None:
    """Make an eye of N ommatidia."""
    if radius_mm is not None and semi_axes_mm is not None:
        raise Error("generate: expected --radius-mm or --semi-axes-mm, not both")
    check_target(str(output))
    zones = [_zone("--acute-zone", text, 4) for text in acute_zone or ()]
    zones += [_zone("--acute-band", text, 3) for text in acute_band or ()]
    size_mm = semi_axes_mm or (1.0 if radius_mm is None else radius_mm,) * 3
    with working() as bar:
        eye = generate_eye(
            count,
            radius_m=[length / 1e3 for length in size_mm],
            density=acute_zones(zones) if zones else None,
            acceptance_ratio=acceptance_ratio,
            seed=seed,
            progress=bar.show,
        )
        _save(output, eye, unit)


def _zone(option: str, text: str, count: int) -> AcuteZone:
    try:
        values = [float(word) for word in text.split(",")]
    except ValueError:
        values = []
    if len(values) != count:
        raise Error(f"{option}: expected {count} numbers with commas between, found {text!r:.60}")
    *azimuth, elevation, width, factor = values
    if not (width > 0 and factor > 0):
        raise Error(f"{option}: expected width and factor above 0, found {text!r:.60}")
    return AcuteZone(
        math.radians(azimuth[0] if azimuth else 0.0),
        math.radians(elevation),
        math.radians(width),
        factor,
        band=not azimuth,
    )


def _save(path: Path, eye: Eye, unit: str) -> None:
    save_eye(path, eye, unit)
    # What the file's next user wants to know, so that a wrong unit is seen at once.
    radius_mm = 1e3 * float(np.linalg.norm(eye.position_m.astype(np.float64), axis=1).mean())
    degrees = np.degrees(eye.acceptance_angle_rad.astype(np.float64))
    low, high = f"{degrees.min():.4g}", f"{degrees.max():.4g}"
    print(
        f"wrote {path}: {len(eye):,} ommatidia, mean radius {radius_mm:.4g} mm, acceptance "
        + (f"{low}°" if low == high else f"{low} to {high}°")
    )
