"""``omma eye make``: a lattice of ommatidia over a surface."""

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
from omma.cli.eye_files import OutOption, UnitOption, clear_of_midline, head_of, save
from omma.cli.numbers import above_zero, angle, finite, numbers_of
from omma.cli.parameters import option, switch
from omma.cli.working import working
from omma.eye.angles import acute_angle, load_angle_table, window
from omma.eye.design import AcuteZone, acute_zones
from omma.eye.facets import acceptance_from_facets
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


def add_make_command(eye_app: typer.Typer) -> None:
    """Adds ``make`` to the commands of ``omma eye``."""
    eye_app.command(help=MAKE_HELP, short_help="Make an eye.")(make)


def make(
    output: OutOption,
    count: Annotated[
        int | None, typer.Argument(help="Number of ommatidia.", metavar="N", show_default=False)
    ] = None,
    dphi: Annotated[
        float | None, option("Angle between neighbours, in degrees.", "DEG", angle)
    ] = None,
    dphi_vertical: Annotated[
        float | None, option("The same between those above each other.", "DEG", angle)
    ] = None,
    field: Annotated[Path | None, option("CSV table of these angles.", "FILE")] = None,
    acute_zone: Annotated[
        list[str] | None,
        option(
            "Acute zone: azimuth, elevation and width in degrees, and how many times as "
            "many ommatidia look there. May be repeated.",
            "AZ,EL,WIDTH,FACTOR",
        ),
    ] = None,
    acute_band: Annotated[
        list[str] | None,
        option(
            "Acute zone all around: elevation, width and factor. May be repeated.",
            "EL,WIDTH,FACTOR",
        ),
    ] = None,
    streak: Annotated[
        str | None,
        option("As --acute-band, with smaller angles vertically only.", "EL,WIDTH,FACTOR"),
    ] = None,
    fov: Annotated[
        str | None,
        option(
            "Field of view: azimuths and elevations, in degrees; azimuths may go beyond 180. "
            "Default: all round.",
            "AZ0,AZ1,EL0,EL1",
        ),
    ] = None,
    radius_mm: Annotated[
        float | None, option("Radius of a sphere, in mm. Default: 1.", "MM", above_zero)
    ] = None,
    semi_axes_mm: Annotated[
        tuple[float, float, float] | None,
        option(
            "Of an ellipsoid: half its width (right), height and length, in mm.",
            "X Y Z",
            above_zero,
        ),
    ] = None,
    centre_mm: Annotated[
        tuple[float, float, float] | None,
        option("Where its centre is (right, up, back), in mm.", "X Y Z", finite),
    ] = None,
    mesh: Annotated[
        Path | None, option("Surface from a file: .gltf, .glb, .obj, .ply or .stl.", "FILE")
    ] = None,
    facet_um: Annotated[
        float | None, option("Lay facets this wide over the surface, in µm.", "UM", above_zero)
    ] = None,
    even_facets: Annotated[
        bool, switch("--even-facets", "Lay N facets of one size over the surface.")
    ] = False,
    skew: Annotated[
        float | None,
        option(
            "Median angle between axis and surface normal, in degrees: the surface spans "
            "less than the eye sees, around its middle direction.",
            "DEG",
            above_zero,
        ),
    ] = None,
    pair: Annotated[
        bool,
        switch(
            "--pair",
            "Add the mirror image; what is made is the right eye, or the left one where --fov or "
            "--centre-mm put it there, moved beside the midline where no --centre-mm says where "
            "it is.",
        ),
    ] = False,
    acceptance_ratio: Annotated[
        float | None,
        option("Acceptance angle over angle between neighbours. Default: 1.", "RATIO", above_zero),
    ] = None,
    airy: Annotated[
        bool, switch("--airy", "Acceptance by diffraction at the facets alone.")
    ] = False,
    rhabdom_um: Annotated[
        float | None,
        option("Acceptance by lens and rhabdom: its diameter, in µm.", "UM", above_zero),
    ] = None,
    f_number: Annotated[
        float | None, option("Of the lenses: focal length over diameter.", "F", above_zero)
    ] = None,
    wavelength_nm: Annotated[
        float, option("Wavelength for --airy and --rhabdom-um.", "NM", above_zero)
    ] = 500.0,
    seed: Annotated[int, option("Seed of the arrangement.", "N")] = 0,
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
    if count == 1:
        raise Error(
            "N: expected 2 or more, found 1; the eye of a single ommatidium is a CSV file of two "
            "lines: axis_x,axis_y,axis_z,acceptance_angle_deg and, straight ahead and 5 degrees "
            "wide, 0,0,-1,5"
        )
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
    left, right, low, high = numbers_of("--fov", text, 4)
    try:
        return window((left, right), (low, high))
    except Error as error:
        raise Error(f"--fov: {error}") from None


def _zone(option: str, text: str, count: int) -> AcuteZone:
    *azimuth, elevation, width, factor = numbers_of(option, text, count)
    if not (width > 0 and factor > 0):
        raise Error(f"{option}: expected width and factor above 0, found {text!r:.60}")
    return AcuteZone(
        math.radians(azimuth[0] if azimuth else 0.0),
        math.radians(elevation),
        math.radians(width),
        factor,
        band=not azimuth,
    )
