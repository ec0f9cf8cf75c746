"""``omma eye info`` and ``omma eye plot``: what an eye is like, in numbers and in figures."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Annotated, Any, Literal

import typer
from rich.console import Console
from rich.table import Table

from omma._core import Error
from omma.base.arguments import as_named
from omma.base.figures import figure_names
from omma.base.files import check_ending, write_whole
from omma.cli.eye_files import EyesArgument
from omma.cli.numbers import finite
from omma.cli.options import EyeUnitOption
from omma.cli.parameters import argument, option, out, switch
from omma.cli.working import check_outputs, readable, say, working
from omma.eye.files import load_head
from omma.eye.measures import DIFFRACTION_LIMIT, diffraction_limit_m_rad, measure_eye
from omma.eye.report import SPREADS, direction_text, eye_summary, save_eye_table
from omma.picture.acceptance_plots import Chosen, plot_acceptance
from omma.picture.drawing import draw_eye
from omma.picture.eye_maps import plot_eye_maps
from omma.picture.poster import plot_poster, plot_species

INFO_HELP = """
Say what an eye is like: its size and visual field, the angles between its ommatidia, what they
accept and how far they look askew; and which of them look wrong.

Several files make one head. Every number is explained in docs/looking-at-eyes.md.

**Examples**

`omma eye info honeybee_worker_left.eye honeybee_worker_right.eye`

Everything about each ommatidium as a table, the summary for a program, maps as a figure:

`omma eye info bee.eye -o ommatidia.csv --json summary.json --map maps.pdf`
"""

PLOT_HELP = """
Make a figure of an eye: .pdf, .svg or .png.

--what says which: **3d**, the ommatidia seen from the direction --yaw, --pitch (0 0 is from ahead,
90 0 from its right, 0 90 from above), coloured by a property; **map**, properties over the
directions that the eye sees; **acceptance**, the angular sensitivity of chosen ommatidia and its
modulation transfer; **poster**, all of it on an A3 page.

Properties are interommatidial (the mean angle to the neighbours in direction), horizontal,
vertical, surface-angle (the mean to those whose facets touch), smaller and larger (the half axes of
the ellipse that their axes lie on), acceptance, ratio, facet, spacing, eye-parameter, sampling,
sensitivity, skew, skew-normal, neighbours, eye, and the names of the eye's own columns.

**Examples**

`omma eye plot left.eye right.eye -o bee.pdf --yaw 40 --pitch 20`

`omma eye plot bee.eye -o axes.svg --style both --property facet`

`omma eye plot bee.eye --what map -o map.pdf --property interommatidial --projection lambert`

`omma eye plot bee.eye --what acceptance -o mtf.pdf --ommatidium 120 --ommatidium 30,-10`

`omma eye plot --species honeybee_worker --what poster -o honeybee.pdf`
"""

_MOST_NAMED = 8
_FIELD_WITHIN = 0.002  # of the sphere, as `field_of_view` finds solid angles


def add_look_commands(app: typer.Typer) -> None:
    """Register ``info`` and ``plot`` with ``omma eye``."""
    app.command(help=INFO_HELP, short_help="Say what an eye is like, in numbers.")(info)
    app.command(help=PLOT_HELP, short_help="Make a figure of an eye.")(plot)


def info(
    eye: EyesArgument,
    output: Annotated[Path | None, out("Table of all ommatidia, .csv.")] = None,
    json_file: Annotated[Path | None, option("The summary as JSON.", "OUT", name="--json")] = None,
    map_file: Annotated[
        Path | None, option("Maps of Δφ, Δρ and more: .pdf, .svg or .png.", "OUT", name="--map")
    ] = None,
    unit: EyeUnitOption = "mm",
) -> None:
    """Say what an eye is like."""
    if output is not None:
        check_ending(output, ".csv")
    if json_file is not None:
        check_ending(json_file, ".json")
    check_outputs(output, json_file, map_file)
    names = figure_names([map_file]) if map_file is not None else []
    with working() as bar:
        head = load_head(eye, unit)
        bar.show("measuring", None)
        measures = measure_eye(head)
        summary = eye_summary(head, measures)
        if output is not None:
            save_eye_table(output, head, measures)
        if json_file is not None:
            text = json.dumps(summary, indent=2, ensure_ascii=False) + "\n"
            # A name that is not UTF-8 becomes JSON's own escapes.
            write_whole(json_file, text.encode(errors="backslashreplace"))
        if names:
            plot_eye_maps(names, head, measures=measures, progress=bar.show)
    _print_summary(", ".join(str(path) for path in eye), summary)
    for target in (output, json_file, map_file):
        if target is not None:
            say(f"wrote {target}")


def plot(
    output: Annotated[list[Path], out("Figure to write: .pdf, .svg, .png. May be repeated.")],
    eye: Annotated[list[Path] | None, argument("Eye file; several make one head.", "EYE")] = None,
    species: Annotated[str | None, option("An animal of omma.species instead.", "NAME")] = None,
    what: Annotated[Literal["3d", "map", "acceptance", "poster"], option("Which figure.")] = "3d",
    prop: Annotated[
        list[str] | None,
        option(
            "What colours mean; for maps, may be repeated. Default: Δφ, for "
            "maps all that are known.",
            "PROPERTY",
            name="--property",
        ),
    ] = None,
    projection: Annotated[
        Literal["mercator", "mollweide", "lambert"], option("Of maps.")
    ] = "mollweide",
    ommatidium: Annotated[
        list[str] | None,
        option(
            "For acceptance: an index, or the azimuth and elevation (degrees) of one. May be "
            "repeated. Default: those of least, median and large Δφ.",
            "INDEX|AZ,EL",
        ),
    ] = None,
    yaw: Annotated[float, option("Azimuth to look from, degrees.", "DEG", finite)] = 0.0,
    pitch: Annotated[float, option("Elevation to look from, degrees.", "DEG", finite)] = 0.0,
    style: Annotated[
        Literal["facets", "axes", "both"], option("3d: facets, lines along the axes, or both.")
    ] = "facets",
    back: Annotated[bool, switch("--back", "3d: what faces away too.")] = False,
    title: Annotated[
        str | None, option("Title. Default: the file's or the animal's name.", "TEXT")
    ] = None,
    unit: EyeUnitOption = "mm",
) -> None:
    """Make a figure of an eye."""
    names = figure_names(output)
    check_outputs(*output)
    if bool(eye) == (species is not None):
        raise Error("plot: expected either eye files or --species")
    if what == "3d" and prop is not None and len(prop) > 1:
        raise Error("--property: expected one for --what 3d, found " + str(len(prop)))
    chosen = None if ommatidium is None else [_chosen(text) for text in ommatidium]
    with working() as bar:
        animal = None
        if species is not None:
            # Only now: other commands start faster without it.
            from omma.species import make

            with as_named(name="species"):
                animal = make(species)
        head = animal.eye if animal is not None else load_head(eye or [], unit)
        bar.show("measuring and drawing", None)
        if what == "3d":
            with as_named(colour="property"):
                draw_eye(
                    names, head, yaw_deg=yaw, pitch_deg=pitch, style=style, back=back, title=title,
                    colour=prop[0] if prop else "interommatidial",
                )  # fmt: skip
        elif what == "map":
            plot_eye_maps(names, head, prop, projection=projection, title=title, progress=bar.show)
        elif what == "acceptance":
            with as_named(ommatidia="ommatidium"):
                plot_acceptance(names, head, chosen, title=title)
        elif animal is not None:
            plot_species(names, animal, progress=bar.show)
        else:
            plot_poster(names, head, title=title, progress=bar.show)
    for name in names:
        say(f"wrote {name}")


def _chosen(text: str) -> Chosen:
    try:
        if "," in text:
            azimuth, elevation = (float(word) for word in text.split(","))
            return azimuth, elevation
        return int(text)
    except ValueError:
        raise Error(
            f"--ommatidium: expected an index or azimuth,elevation, found {text!r:.60}"
        ) from None


def _print_summary(name: str, summary: dict[str, Any]) -> None:
    console = Console(highlight=False, soft_wrap=True)
    lines = [("eye", name), ("ommatidia", _ommatidia(summary))]
    size = " x ".join(f"{length:.4g}" for length in summary["size_mm"])
    kernels = ", ".join(f"{n:,} {kind}" for kind, n in summary["acceptance_kernels"].items())
    lines += [("size", f"{size} mm"), ("acceptance", kernels)]
    if summary["receptors"]:
        listed = ", ".join(f"{n:,} {kind}" for kind, n in summary["receptors"].items())
        lines.append(("receptors", listed))
    if summary["columns"]:
        lines.append(("columns", ", ".join(summary["columns"])))
    _print_lines(console, lines)
    console.print(_spreads(summary["spread"]), soft_wrap=False)
    _print_lines(console, _parameter_lines(summary) + _field_lines(summary) + _odd_lines(summary))


def _print_lines(console: Console, lines: list[tuple[str, str]]) -> None:
    for what, value in lines:
        console.print(readable(f"{what:<12} {value}"), markup=False)


def _ommatidia(summary: dict[str, Any]) -> str:
    eyes = summary["eyes"]
    each = f" ({' + '.join(f'{n:,}' for n in eyes.values())})" if len(eyes) > 1 else ""
    inner, six = summary["inner_ommatidia"], summary["inner_with_six_neighbours"]
    sixes = f"; {six / inner:.0%} of the {inner:,} inner ones have six neighbours" if inner else ""
    return f"{summary['ommatidia']:,}{each}{sixes}"


def _spreads(spread: dict[str, dict[str, Any]]) -> Table:
    from rich import box

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    for column in ("", "min", "5 %", "median", "95 %", "max", "unit"):
        table.add_column(
            column, justify="right" if column not in ("", "unit") else "left", no_wrap=True
        )
    for name, what, unit in SPREADS:
        values = spread[name]
        if values["known"] == 0:
            table.add_row(what, "", "", "–", "", "", unit)
            continue
        numbers = [_number(values[key]) for key in ("min", "p5", "median", "p95", "max")]
        table.add_row(what, *numbers, unit)
    return table


def _parameter_lines(summary: dict[str, Any]) -> list[tuple[str, str]]:
    if summary["spread"]["eye_parameter_um_rad"]["known"] == 0:
        return []
    limit = diffraction_limit_m_rad() * 1e6
    text = f"the limit is {_number(limit)} µm rad: D·Δφ = {DIFFRACTION_LIMIT} λ at λ = 500 nm"
    return [("diffraction", text)]


def _field_lines(summary: dict[str, Any]) -> list[tuple[str, str]]:
    sphere = 4 * math.pi
    lines = []
    if len(summary["eyes"]) > 1:
        lines += [
            (f"eye {which}", f"sees {sr:.3g} sr, {sr / sphere:.1%} of the sphere")
            for which, sr in summary["field_sr"].items()
        ]
    seen, both = summary["seen_sr"], summary["binocular_sr"]
    lines.append(("field", f"{seen:.3g} sr, {seen / sphere:.1%} of the sphere"))
    of_field = f", {both / seen:.1%} of the field" if seen else ""
    lines.append(("binocular", f"{both:.3g} sr{of_field}" if both else "none"))
    zones = summary["blind_zones"]
    lines += [
        (
            "blind" if k == 0 else "",
            f"{zone['solid_angle_sr']:.3g} sr; a cone of {zone['radius_deg']:.1f}° half angle fits "
            f"in, around {direction_text(zone['azimuth_deg'], zone['elevation_deg'])}",
        )
        for k, zone in enumerate(zones[:_MOST_NAMED])
    ]
    if len(zones) > _MOST_NAMED:
        lines.append(("", f"and {len(zones) - _MOST_NAMED} more blind zones"))
    rest = summary["blind_sr"] - sum(zone["solid_angle_sr"] for zone in zones)
    if rest > _FIELD_WITHIN * sphere:
        small = (
            f"{rest:.3g} sr that no ommatidium sees, in pieces smaller than an ommatidium's cell"
        )
        lines.append(("" if zones else "blind", small))
    elif not zones:
        lines.append(("blind", "nowhere"))
    return lines


def _odd_lines(summary: dict[str, Any]) -> list[tuple[str, str]]:
    odd = [f"{o['ommatidium']} ({o['differs_in']})" for o in summary["outliers"]]
    same = [f"{d['ommatidium']} (as {d['same_as']})" for d in summary["duplicates"]]
    lines = [("outliers", _listed(odd)), ("duplicates", _listed(same))]
    inward = summary["inward"]
    if inward:
        named = f": {', '.join(map(str, inward))}" if len(inward) <= _MOST_NAMED else ""
        told = f"{len(inward):,} of {summary['ommatidia']:,} axes point into the eye{named}"
        lines.append(("looks wrong", told))
    return lines


def _listed(names: list[str]) -> str:
    if not names:
        return "none"
    more = ", ..." if len(names) > _MOST_NAMED else ""
    return f"{len(names):,}: {', '.join(names[:_MOST_NAMED])}{more}"


def _number(value: float) -> str:
    if abs(value) < 5e-4:
        return "0"  # rounding of single precision, not a length or an angle
    return f"{value:.3g}" if abs(value) < 100 else f"{value:.0f}"
