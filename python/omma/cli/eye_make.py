"""``omma eye make``, ``mirror``, ``place``, ``scale`` and ``join``: eyes made and put together."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arguments import as_named
from omma.base.files import check_target
from omma.cli.eye_files import EyeArgument, OutOption, UnitOption, clear_of_midline, head_of, save
from omma.cli.numbers import above_zero, angle, finite
from omma.cli.working import working
from omma.eye.angles import acute_angle, load_angle_table, window
from omma.eye.change import join_eyes, mirror_eye, place_on_head, rescale_eye
from omma.eye.design import AcuteZone, acute_zones
from omma.eye.facets import acceptance_from_facets
from omma.eye.files import load_eye
from omma.eye.lattice import Angle, lay_directions
from omma.eye.on_surface import eye_on_surface, lay_on_surface
from omma.eye.skew import squeeze_for_skew, squeezed
from omma.eye.surfaces import Surface, ellipsoid, load_surface

MAKE_HELP = """
Make an eye: a hexagonal lattice of ommatidia.

How many look where is said by N, their number, or by --dphi, the angle between neighbours, or both;
the angle may be another vertically (--dphi-vertical), come from a table (--field, a CSV file with
the columns azimuth_deg, elevation_deg, dphi_h_deg and perhaps dphi_v_deg), and be smaller in acute
zones. With N the angles are scaled to give just so many. Azimuth 0 is ahead and grows to the right.

They sit on a sphere, an ellipsoid or a mesh, where the surface's normal is the direction they look
in, or off it by --skew. Instead, --facet-um or --even-facets lays facets of one size over the
surface, which then look along its normals.

Acceptance angles are the angles between neighbours, times --acceptance-ratio; or they follow from
the optics: --airy for diffraction at the facet alone, --rhabdom-um with --f-number for a lens and a
rhabdom.

**Examples**

`omma eye make 1000 -o even.csv`

A right eye of 2° and its mirror image, acute ahead, looking askew from a tall ellipsoid:

`omma eye make --dphi 2 --fov -15,160,-80,80 --acute-zone 0,0,40,4 --semi-axes-mm 0.4 1.2 0.5
--centre-mm 1.4 0 0 --skew 20 --pair -o head.csv`

A streak along the horizon, four times as sharp vertically:

`omma eye make 5000 --streak 0,20,4 -o crab.csv`

Facets of 20 µm over a mesh, with rhabdoms of 2 µm behind lenses of F-number 2:

`omma eye make --mesh eye.stl --facet-um 20 --rhabdom-um 2 --f-number 2 -o eye.csv`
"""

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


def add_make_commands(eye_app: typer.Typer) -> None:
    """The commands of this file."""
    eye_app.command(help=MAKE_HELP, short_help="Make an eye.")(make)
    eye_app.command(help=MIRROR_HELP, short_help="Mirror an eye, left for right.")(mirror)
    eye_app.command(help=PLACE_HELP, short_help="Put an eye on a head.")(place)
    eye_app.command(help=SCALE_HELP, short_help="Make an eye larger or smaller.")(scale)
    eye_app.command(help=JOIN_HELP, short_help="Put several eyes into one head.")(join)


def make(
    output: OutOption,
    count: Annotated[
        int | None, typer.Argument(help="Number of ommatidia.", metavar="N", show_default=False)
    ] = None,
    dphi: Annotated[
        float | None,
        typer.Option(help="Angle between neighbours, in degrees.", metavar="DEG", callback=angle),
    ] = None,
    dphi_vertical: Annotated[
        float | None,
        typer.Option(
            help="The same between those above each other.", metavar="DEG", callback=angle
        ),
    ] = None,
    field: Annotated[
        Path | None, typer.Option(help="CSV table of these angles.", metavar="FILE")
    ] = None,
    acute_zone: Annotated[
        list[str] | None,
        typer.Option(
            help="Acute zone: azimuth, elevation and width in degrees, and how many times as "
            "many ommatidia look there. May be repeated.",
            metavar="AZ,EL,WIDTH,FACTOR",
        ),
    ] = None,
    acute_band: Annotated[
        list[str] | None,
        typer.Option(
            help="Acute zone all around: elevation, width and factor. May be repeated.",
            metavar="EL,WIDTH,FACTOR",
        ),
    ] = None,
    streak: Annotated[
        str | None,
        typer.Option(
            help="As --acute-band, with smaller angles vertically only.", metavar="EL,WIDTH,FACTOR"
        ),
    ] = None,
    fov: Annotated[
        str | None,
        typer.Option(
            help="Field of view: azimuths and elevations, in degrees; azimuths may go beyond 180. "
            "Default: all round.",
            metavar="AZ0,AZ1,EL0,EL1",
        ),
    ] = None,
    radius_mm: Annotated[
        float | None,
        typer.Option(
            help="Radius of a sphere, in mm. Default: 1.", metavar="MM", callback=above_zero
        ),
    ] = None,
    semi_axes_mm: Annotated[
        tuple[float, float, float] | None,
        typer.Option(
            help="Of an ellipsoid: half its width (right), height and length, in mm.",
            metavar="X Y Z",
            callback=above_zero,
        ),
    ] = None,
    centre_mm: Annotated[
        tuple[float, float, float] | None,
        typer.Option(
            help="Where its centre is (right, up, back), in mm.", metavar="X Y Z", callback=finite
        ),
    ] = None,
    mesh: Annotated[
        Path | None,
        typer.Option(help="Surface from a file: .gltf, .glb, .obj or .stl.", metavar="FILE"),
    ] = None,
    facet_um: Annotated[
        float | None,
        typer.Option(
            help="Lay facets this wide over the surface, in µm.", metavar="UM", callback=above_zero
        ),
    ] = None,
    even_facets: Annotated[
        bool, typer.Option("--even-facets", help="Lay N facets of one size over the surface.")
    ] = False,
    skew: Annotated[
        float | None,
        typer.Option(
            help="Median angle between axis and surface normal, in degrees: the surface spans "
            "less than the eye sees, around its middle direction.",
            metavar="DEG",
            callback=above_zero,
        ),
    ] = None,
    pair: Annotated[
        bool,
        typer.Option(
            "--pair",
            help="Add the mirror image; what is made is the right eye, moved to the right of the "
            "midline where no --centre-mm says where it is.",
        ),
    ] = False,
    acceptance_ratio: Annotated[
        float | None,
        typer.Option(
            help="Acceptance angle over angle between neighbours. Default: 1.",
            metavar="RATIO",
            callback=above_zero,
        ),
    ] = None,
    airy: Annotated[
        bool, typer.Option("--airy", help="Acceptance by diffraction at the facets alone.")
    ] = False,
    rhabdom_um: Annotated[
        float | None,
        typer.Option(
            help="Acceptance by lens and rhabdom: its diameter, in µm.",
            metavar="UM",
            callback=above_zero,
        ),
    ] = None,
    f_number: Annotated[
        float | None,
        typer.Option(
            help="Of the lenses: focal length over diameter.", metavar="F", callback=above_zero
        ),
    ] = None,
    wavelength_nm: Annotated[
        float,
        typer.Option(
            help="Wavelength for --airy and --rhabdom-um.", metavar="NM", callback=above_zero
        ),
    ] = 500.0,
    seed: Annotated[int, typer.Option(help="Seed of the arrangement.", metavar="N")] = 0,
    unit: UnitOption = "mm",
) -> None:
    """Make an eye."""
    check_target(str(output))
    by_facets = facet_um is not None or even_facets
    angles = [dphi, dphi_vertical, field, acute_zone, acute_band, streak, fov, skew]
    if by_facets and any(option is not None for option in angles):
        raise Error(
            "make: facets laid over the surface look along its normals: expected no --dphi, "
            "--dphi-vertical, --field, --acute-zone, --acute-band, --streak, --fov, --skew with "
            "--facet-um or --even-facets"
        )
    if (
        (count is None) == (facet_um is None)
        if by_facets
        else (count is None and dphi is None and field is None)
    ):
        raise Error("make: expected N, --dphi or --field; or N with --even-facets, or --facet-um")
    if field is not None and (dphi is not None or dphi_vertical is not None):
        raise Error("make: expected --field or --dphi, not both")
    if dphi_vertical is not None and dphi is None:
        raise Error("make: expected --dphi with --dphi-vertical")
    if sum([acceptance_ratio is not None, airy, rhabdom_um is not None]) > 1:
        raise Error("make: expected one of --acceptance-ratio, --airy and --rhabdom-um")
    if (rhabdom_um is None) != (f_number is None):
        raise Error("make: expected --rhabdom-um and --f-number together")
    zones = [_zone("--acute-zone", text, 4) for text in acute_zone or ()]
    zones += [_zone("--acute-band", text, 3) for text in acute_band or ()]
    seen = None if fov is None else _window(fov)
    with working() as bar, as_named(count="N", median_rad="skew"):
        surface = _surface(radius_mm, semi_axes_mm, centre_mm, mesh, unit)
        ratio = 1.0 if acceptance_ratio is None else acceptance_ratio
        if by_facets:
            eye = lay_on_surface(
                surface,
                1e-5 if facet_um is None else facet_um * 1e-6,
                count=count,
                acceptance_ratio=ratio,
                seed=seed,
                progress=bar.show,
            )
        else:
            across, up = _angles(dphi, dphi_vertical, field, zones, streak)
            lattice = lay_directions(
                across, up, field_of_view=seen, count=count, seed=seed, progress=bar.show
            )
            normal = None
            if skew is not None:
                middle = lattice.directions.sum(axis=0)
                factor = squeeze_for_skew(lattice.directions, surface, middle, math.radians(skew))
                normal = squeezed(middle, factor)
            eye = eye_on_surface(
                lattice.directions,
                surface,
                normal=normal,
                acceptance_ratio=ratio,
                progress=bar.show,
            )
        if airy or rhabdom_um is not None:
            eye = acceptance_from_facets(
                eye,
                wavelength_nm=wavelength_nm,
                rhabdom_diameter_m=None if rhabdom_um is None else rhabdom_um * 1e-6,
                f_number=f_number,
            )
        if pair:
            own_place = centre_mm is not None or mesh is not None
            eye = head_of(eye if own_place else clear_of_midline(eye))
        save(output, eye, unit)


def mirror(
    eye: EyeArgument,
    output: OutOption,
    pair: Annotated[
        bool, typer.Option("--pair", help="Write both: the image as the left eye, then this one.")
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
        typer.Option(
            help="Where its origin goes (right, up, back), in mm.", metavar="X Y Z", callback=finite
        ),
    ] = (0.0, 0.0, 0.0),
    yaw: Annotated[
        float, typer.Option(help="To the right, in degrees.", metavar="DEG", callback=finite)
    ] = 0.0,
    pitch: Annotated[
        float, typer.Option(help="Upwards, in degrees.", metavar="DEG", callback=finite)
    ] = 0.0,
    roll: Annotated[
        float, typer.Option(help="Right side down, in degrees.", metavar="DEG", callback=finite)
    ] = 0.0,
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
    factor: Annotated[
        float | None, typer.Option(help="Times as large.", metavar="FACTOR", callback=above_zero)
    ] = None,
    mean_radius_mm: Annotated[
        float | None,
        typer.Option(
            help="Mean distance from the origin to come to, in mm.",
            metavar="MM",
            callback=above_zero,
        ),
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
    eyes: Annotated[list[Path], typer.Argument(help="Eye files.", metavar="EYE")],
    output: OutOption,
    unit: UnitOption = "mm",
) -> None:
    """Put several eyes into one head."""
    with working():
        save(output, join_eyes([load_eye(path, unit) for path in eyes]), unit)


def _surface(
    radius_mm: float | None,
    semi_axes_mm: tuple[float, float, float] | None,
    centre_mm: tuple[float, float, float] | None,
    mesh: Path | None,
    unit: str,
) -> Surface:
    if sum(option is not None for option in (radius_mm, semi_axes_mm, mesh)) > 1:
        raise Error("make: expected one of --radius-mm, --semi-axes-mm and --mesh")
    if mesh is not None:
        if centre_mm is not None:
            raise Error("make: expected --centre-mm with a sphere or an ellipsoid, not a --mesh")
        return load_surface(mesh, unit)
    size_mm = semi_axes_mm or (1.0 if radius_mm is None else radius_mm,) * 3
    centre = [length / 1e3 for length in centre_mm or (0.0, 0.0, 0.0)]
    return ellipsoid([length / 1e3 for length in size_mm], centre)


def _angles(
    dphi: float | None,
    dphi_vertical: float | None,
    field: Path | None,
    zones: list[AcuteZone],
    streak: str | None,
) -> tuple[Angle, Angle | None]:
    # Any angle does where only N is given, as all are scaled then.
    across: Angle = math.radians(1.0 if dphi is None else dphi)
    up: Angle | None = None if dphi_vertical is None else math.radians(dphi_vertical)
    if field is not None:
        across, up = load_angle_table(field)
    if zones:
        density = acute_zones(zones)
        across = acute_angle(across, density)
        up = None if up is None else acute_angle(up, density)
    if streak is not None:
        band = _zone("--streak", streak, 3)
        up = acute_angle(across if up is None else up, band.density, one_way=True)
    return across, up


def _window(text: str) -> Callable[[NDArray[np.float64]], NDArray[np.bool_]]:
    left, right, low, high = _numbers("--fov", text, 4)
    try:
        return window((left, right), (low, high))
    except Error as error:
        raise Error(f"--fov: {error}") from None


def _zone(option: str, text: str, count: int) -> AcuteZone:
    *azimuth, elevation, width, factor = _numbers(option, text, count)
    if not (width > 0 and factor > 0):
        raise Error(f"{option}: expected width and factor above 0, found {text!r:.60}")
    return AcuteZone(
        math.radians(azimuth[0] if azimuth else 0.0),
        math.radians(elevation),
        math.radians(width),
        factor,
        band=not azimuth,
    )


def _numbers(option: str, text: str, count: int) -> list[float]:
    try:
        values = [float(word) for word in text.split(",")]
    except ValueError:
        values = []
    if len(values) != count:
        raise Error(f"{option}: expected {count} numbers with commas between, found {text!r:.60}")
    return values
