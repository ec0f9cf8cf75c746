"""A poster of an eye: one A3 page with drawings, maps, sensitivities, and a table of its facts."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from omma._core import Eye, ReceptorType
from omma.base.arguments import checked
from omma.base.arrays import Floats
from omma.base.figures import (
    COLOURS,
    GREY,
    INK,
    MM,
    figure_names,
    figure_style,
    legend_of,
    load_matplotlib,
    plain,
    save_figure,
)
from omma.base.files import PathLike
from omma.base.progress import Stage
from omma.eye.measures import DIFFRACTION_LIMIT, EyeMeasures, diffraction_limit_m_rad, measure_eye
from omma.eye.properties import EyeProperty, eye_property, is_known
from omma.eye.report import SPREADS, direction_text, eye_summary, has_surface
from omma.picture.acceptance_plots import choose, draw_profiles, draw_transfer
from omma.picture.drawing import draw_view, view_from
from omma.picture.eye_maps import MAP_NOTE, draw_map, eye_title, make_map
from omma.receptors.sensitivity import spectral_sensitivity
from omma.species import Species

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

#: What a poster says of an animal: label, value with unit, where it is from.
PosterFact = tuple[str, str, str]

# Name, yaw and pitch from where it is seen, and whether all of the head is or the right eye alone.
_VIEWS = (
    ("from ahead", 0.0, 0.0, True),
    ("right eye, from its right", 90.0, 0.0, False),
    ("right eye, from ahead, right and above", 45.0, 30.0, False),
)
_LIGHTS = ((400, "#cc79a7"), (480, "#0072b2"), (570, "#009e73"), (700, "#d55e00"))
_SHAPE = 1.3  # of the panels with these views: width over height
_WAVELENGTHS = np.arange(300.0, 701.0, 2.0)
_SHOWN_SPREADS = (
    "interommatidial_deg", "horizontal_deg", "vertical_deg",
    "surface_angle_deg", "smaller_deg", "larger_deg", "acceptance_deg", "ratio",
    "facet_diameter_um", "eye_parameter_um_rad", "sensitivity_um2_sr", "skew_normal_deg",
)  # fmt: skip


@checked
def plot_poster(
    paths: PathLike | Sequence[PathLike],
    eye: Eye,
    *,
    title: str | None = None,
    facts: Sequence[PosterFact] = (),
    sources: Sequence[str] = (),
    measures: EyeMeasures | None = None,
    progress: Stage | None = None,
) -> None:
    """Write a poster of an eye, an A3 page (420 x 297 mm), to `.pdf`, `.svg` and `.png`.

    The head from ahead, and its right eye from two sides; maps of Δφ, of
    facet diameters (of Δρ where these are not known), and of the smaller and the larger angle
    between the axes of facets that touch; histograms; angular sensitivities with
    their modulation transfer; the receptors' spectral sensitivities where there are any; what
    `measure_eye` finds, and facts.

    Args:
        title: by default the file's or the animal's name.
        facts: of the animal, each (label, value with its unit, where it is from); any number, of
            which about 45 fit.
        sources: printed at the foot of the page.
        progress: called as progress(stage, finished fraction or None) now and then.

    Raises:
        omma.Error: another ending, Matplotlib is missing, a file cannot be written.
    """
    names = figure_names(paths)
    measures = measures or measure_eye(eye)
    names_of_maps = ["interommatidial", "facet", "smaller", "larger"]
    if not (measures.facet_diameter_m > 0).any():
        names_of_maps[1] = "acceptance"
    the_map = make_map(measures, "mollweide", progress=progress)
    tell = progress or (lambda stage, fraction: None)
    tell("measuring the field", None)
    summary = eye_summary(eye, measures)
    if not has_surface(summary):
        names_of_maps = names_of_maps[:2]
    shown = [eye_property(eye, measures, name) for name in names_of_maps]
    spacing = shown[0]
    panels = len(_VIEWS) + len(shown) + 1  # and those below
    with figure_style(8.0):
        figure: Any = load_matplotlib()(figsize=(420 * MM, 297 * MM), layout="constrained")
        figure.get_layout_engine().set(w_pad=3 * MM, h_pad=3 * MM)
        figure.suptitle(plain(title or eye_title(eye)), fontsize=17, weight="bold")
        if sources:
            lines = textwrap.wrap("Sources: " + "; ".join(sources), 330)
            figure.supxlabel("\n".join(lines), fontsize=5.5, color=INK)
        plots, text = figure.subfigures(1, 2, width_ratios=(3.0, 1.15))
        upper, lower = plots.subfigures(2, 1, height_ratios=(2.1, 1))
        views, maps = upper.subfigures(1, 2, width_ratios=(0.8, 1.45))
        right, of_right = _right_eye(eye, measures, spacing)
        for k, (name, yaw, pitch, whole) in enumerate(_VIEWS):
            panel = views.add_subplot(3, 1, k + 1)
            alone = len(right) == len(eye)
            name = name.removeprefix("right eye, ") if alone else name
            panel.set_title(f"{name}; colours as in the first map" if k == 0 else name, loc="left")
            view = view_from(math.radians(yaw), math.radians(pitch))
            seen = (eye, spacing) if whole else (right, of_right)
            tell("drawing", k / panels)
            notes = draw_view(panel, seen[0], view, seen[1], shape=_SHAPE, scale=spacing)
            panel.text(
                0, -0.02, "\n".join(notes), transform=panel.transAxes, va="top", fontsize="x-small"
            )
        for k, prop in enumerate(shown):
            tell("drawing", (len(_VIEWS) + k) / panels)
            draw_map(maps, maps.add_subplot(2, len(shown) // 2, k + 1), the_map, prop)
        maps.supxlabel(MAP_NOTE, fontsize="x-small")
        tell("drawing", (panels - 1) / panels)
        _lower(lower, eye, measures, has_surface(summary))
        _text(text.add_subplot(), _found(summary), facts)
        tell("writing the figure", None)
        save_figure(figure, names, dpi=200)


@checked
def plot_species(
    paths: PathLike | Sequence[PathLike],
    species: Species,
    *,
    measures: EyeMeasures | None = None,
    progress: Stage | None = None,
) -> None:
    """`plot_poster` of an animal of `omma.species`, with its facts, their standing and sources.

    Raises:
        omma.Error: as `plot_poster`.
    """
    facts = []
    for fact in species.facts:
        unit = {"1": "", "um": " µm", "deg": "°"}.get(
            fact.unit, f" {fact.unit}".replace("um", "µm")
        )
        facts.append(
            (
                fact.quantity.replace("_", " "),
                f"{fact.value:,.6g}{unit}",
                f"{fact.status}, {fact.source.key}",
            )
        )
    plot_poster(
        paths,
        species.eye,
        title=f"{species.name.replace('_', ' ').capitalize()}, {species.latin}",
        facts=facts,
        sources=[f"[{source.key}] {source.citation}" for source in species.sources],
        measures=measures,
        progress=progress,
    )


def _right_eye(eye: Eye, measures: EyeMeasures, prop: EyeProperty) -> tuple[Eye, EyeProperty]:
    """The eye that sits farthest to the right, and its values of the property."""
    eyes = np.unique(measures.eye_id)
    if len(eyes) == 1:
        return eye, prop
    middles = [eye.position_m[measures.eye_id == which, 0].mean() for which in eyes]
    members = measures.eye_id == eyes[int(np.argmax(middles))]
    right = eye.replace(eye_id=members.astype(np.int32)).select(1)
    return right, EyeProperty(prop.values[members], prop.label, prop.classes)


def _lower(figure: Any, eye: Eye, measures: EyeMeasures, surface: bool) -> None:
    grid = figure.add_gridspec(1, 4 if eye.receptor_types else 3)
    chosen = choose(eye, measures, None)
    _histograms(figure.add_subplot(grid[0]), eye, measures, surface)
    draw_profiles(figure.add_subplot(grid[1]), eye, chosen)
    draw_transfer(figure.add_subplot(grid[2]), eye, measures, chosen)
    if eye.receptor_types:
        _spectra(figure.add_subplot(grid[3]), eye)


def _histograms(panel: Axes, eye: Eye, measures: EyeMeasures, surface: bool) -> None:
    of_surface = ("smaller", "larger") if surface else ()
    angles = ("interommatidial", *of_surface, "acceptance")
    shown = [eye_property(eye, measures, name) for name in angles]
    shown = [prop for prop in shown if is_known(prop)]
    known = [prop.values[np.isfinite(prop.values)] for prop in shown]
    everything = np.concatenate(known)
    most = float(np.percentile(everything, 99.5)) * 1.15 or 1.0
    edges = np.linspace(0, most, 46).tolist()
    for prop, values, colour in zip(shown, known, COLOURS, strict=False):
        label = prop.label.replace(" (°)", "")
        if len(values) and np.ptp(values) <= 1e-4 * values.max():
            panel.axvline(values[0], color=colour, label=f"{label}: {values[0]:.3g}° throughout")
        else:
            panel.hist(
                np.minimum(values, edges[-2]), edges, histtype="stepfilled",
                facecolor=colour + "40", edgecolor=colour, linewidth=1.0, label=label,
            )  # fmt: skip
    panel.set(xlabel="angle (°)", ylabel="ommatidia", xlim=(0, most))
    panel.legend(frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.17), fontsize="x-small")


def _spectra(panel: Axes, eye: Eye) -> None:
    # Types that differ in something else than their spectrum are one curve.
    count = np.bincount(eye.receptor_type, minlength=len(eye.receptor_types))
    curves: list[tuple[ReceptorType, Floats, list[str], list[int]]] = []
    for receptor, many in zip(eye.receptor_types, count.tolist(), strict=True):
        values = np.asarray(spectral_sensitivity(receptor, _WAVELENGTHS))
        same = [curve for curve in curves if np.allclose(values, curve[1], atol=1e-6)]
        curve = same[0] if same else (receptor, values, [], [])
        if not same:
            curves.append(curve)
        if receptor.name not in curve[2]:
            curve[2].append(receptor.name)
        curve[3].append(many)
    colours: list[str] = []
    labels: list[str] = []
    drawn: list[Line2D] = []
    for receptor, values, names, counts in curves:
        peak = receptor.peak_wavelength_nm or float(_WAVELENGTHS[values.argmax()])
        name = ", ".join(names) if len(names) <= 3 else f"{names[0]} to {names[-1]}"
        label = f"{name}: {peak:.0f} nm"
        if sum(counts) == 0:
            label += " (in no ommatidium)"
        colours.append(_light(peak, colours))
        drawn += panel.plot(_WAVELENGTHS, values, color=colours[-1])
        labels.append(label)
    panel.set(
        xlabel="wavelength (nm)", ylabel="relative spectral sensitivity",
        xlim=(300, 700), ylim=(-0.02, 1.05),
    )  # fmt: skip
    place = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.17)}
    legend_of(panel, drawn, labels, **place, fontsize="x-small", ncol=2)


def _light(peak_nm: float, taken: list[str]) -> str:
    # About the colour of the light, out of those that everyone can tell apart; each once.
    wanted = [c for most, c in _LIGHTS if peak_nm < most]
    free = [c for c in (*wanted, *COLOURS) if c not in taken]
    return (free or list(COLOURS))[0]


def _found(summary: dict[str, Any]) -> list[PosterFact]:
    eyes = summary["eyes"].values()
    found = [("ommatidia", " + ".join(f"{n:,}" for n in eyes), "")]
    labels = {name: (label, unit) for name, label, unit in SPREADS}
    for name in _SHOWN_SPREADS:
        spread = summary["spread"][name]
        if spread["known"]:
            label, unit = labels[name]
            unit = unit if unit == "°" else f" {unit}"
            value = f"{spread['median']:.3g}{unit}"
            found.append((label, value, f"5 % {spread['p5']:.3g}, 95 % {spread['p95']:.3g}"))
    if summary["spread"]["eye_parameter_um_rad"]["known"]:
        limit = diffraction_limit_m_rad() * 1e6
        found.append(("diffraction limit of D·Δφ", f"{limit:.2g} µm rad", _LIMIT_NOTE))
    fraction = summary["seen_sr"] / (4 * math.pi)
    found.append(("field", f"{summary['seen_sr']:.3g} sr", f"{fraction:.0%} of the sphere"))
    if len(eyes) > 1:
        both = summary["binocular_sr"]
        share = summary["binocular_fraction_of_seen"]
        found.append(("binocular", f"{both:.3g} sr", f"{share:.0%} of the field" if both else ""))
    for zone in summary["blind_zones"][:2]:
        where = direction_text(zone["azimuth_deg"], zone["elevation_deg"])
        cone = f"{zone['radius_deg']:.0f}° around {where}"
        found.append(("blind", f"{zone['solid_angle_sr']:.2g} sr", cone.replace("-", "−")))
    return found


_LIMIT_NOTE = f"{DIFFRACTION_LIMIT} λ, λ = 500 nm (Snyder 1977)"


def _text(panel: Axes, found: Sequence[PosterFact], facts: Sequence[PosterFact]) -> None:
    panel.set_axis_off()
    panel.set(xlim=(0, 1), ylim=(0, 1))
    rows = len(found) + len(facts) + 4
    step = min(0.026, 0.99 / rows)
    # 270 mm high: as large as the lines allow.
    size = min(7.0, step * 270 / 0.3528 * 0.78)
    level = 1.0
    for heading, lines in (("This model (medians)", found), ("Facts it is made of", facts)):
        if not lines:
            continue
        panel.text(0, level, heading, va="top", fontsize=size * 1.15, weight="bold")
        level -= 1.3 * step
        for label, value, note in lines:
            panel.text(0, level, label, va="top", fontsize=size)
            panel.text(0.565, level, value.replace("-", "−"), va="top", ha="right", fontsize=size)
            panel.text(0.59, level, note, va="top", fontsize=size * 0.85, color=GREY)
            level -= step
        level -= 0.7 * step
