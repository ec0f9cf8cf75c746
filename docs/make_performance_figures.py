"""Makes the pictures of docs/performance.md, docs/performance-*.png, from the tables of a bench
run. `scripts/bench` does so at its end.

    .venv/bin/python docs/make_performance_figures.py [--results bench/results] [--out docs]
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "bench"))

from curves import Row, pick, random_error, read  # noqa: E402
from report import FOUR_SCENES  # noqa: E402
from report_speed import BEE_FRAMES_PER_S, BEE_RAYS, equal_error, published  # noqa: E402

# Okabe and Ito's colours, which colour-blind people tell apart; each with a marker of its own.
STYLES = {
    "random": ("#000000", "o", "-", "random, as CompoundRay"),
    "no footprints": ("#E69F00", "s", "-", "Omma without footprints"),
    "footprints": ("#0072B2", "D", "-", "Omma"),
    "shared rays": ("#D55E00", "P", "-", "Omma, neighbours share rays"),
    "target from 4": ("#CC79A7", "^", "--", "Omma, error target, from 4 rays"),
    "target from 8": ("#009E73", "v", "--", "Omma, error target, from 8 rays"),
}
TITLES = {
    "meadow": "Meadow (natural-standin-sky)",
    "arena": "Arena (ofstad-arena)",
    "checkerboard": "Checkerboard ground",
    "grass": "Grass (bundled meadow)",
}


def plain(value: float, _: int) -> str:
    """A number as people write it."""
    return f"{value:,g}"


def tidy(axes: Axes) -> None:
    """A faint grid, plain numbers, no box."""
    axes.grid(True, which="major", color="#dddddd", linewidth=0.7)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    for axis, scale in ((axes.xaxis, axes.get_xscale()), (axes.yaxis, axes.get_yscale())):
        if scale == "log":
            axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axis.set_major_formatter(FuncFormatter(plain))
        axis.set_minor_formatter(NullFormatter())


def save(figure: Figure, path: Path) -> None:
    """As PNG, whole or not at all."""
    partial = path.with_suffix(".partial")
    figure.savefig(partial, format="png", dpi=130, facecolor="white")
    partial.replace(path)


def legend(figure: Figure) -> None:
    """One for all panels, below."""
    found = {}
    for axes in figure.axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    figure.legend(found.values(), found.keys(), loc="outside lower center", ncols=3)


def ceiling(rows: list[Row], path: Path) -> None:
    """Million rays/s of tracing alone and of the whole render."""
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    figure = Figure(figsize=(3.9 * len(scenes), 4.2), layout="constrained")
    for axes, scene in zip(figure.subplots(1, len(scenes), squeeze=False)[0], scenes, strict=True):
        own = pick(rows, scene=scene)
        rays = [int(row["rays"]) for row in own]
        top = [float(row["ceiling_mrays_per_s"]) for row in own]
        whole = [float(row["render_mrays_per_s"]) for row in own]
        axes.plot(rays, top, color="#000000", marker="o", label="tracing alone: the ceiling")
        axes.plot(rays, whole, color="#0072B2", marker="D", label="whole render")
        for x, y, fraction in zip(rays, whole, (w / t for w, t in zip(whole, top))):
            axes.annotate(f"{100 * fraction:.0f} %", (x, y), (0, -15), textcoords="offset points",
                          ha="center", fontsize=8, color="#0072B2")  # fmt: skip
        tidy(axes)
        axes.set_xscale("log", base=2)
        axes.set_xticks(rays, [str(n) for n in rays])
        axes.set_ylim(0, 1.08 * max(top + whole))
        axes.margins(x=0.09)
        axes.set_title(f"{scene}\n{int(own[0]['triangles']):,} triangles", fontsize=10)
        axes.set_xlabel("rays per ommatidium")
    figure.axes[0].set_ylabel("million rays per second")
    legend(figure)
    save(figure, path)


def errors(rows: list[Row], across: str, label: str, path: Path) -> None:
    """Error of all methods against rays or against time, a panel a scene."""
    scenes = [scene for scene in FOUR_SCENES if pick(rows, scene=scene)]
    columns = min(2, len(scenes))
    lines = (len(scenes) + 1) // 2
    figure = Figure(figsize=(5.2 * columns, 3.9 * lines + 0.6), layout="constrained")
    panels = figure.subplots(lines, columns, squeeze=False).ravel()
    for axes in panels[len(scenes) :]:
        axes.set_visible(False)
    for axes, scene in zip(panels, scenes, strict=False):
        own = pick(rows, scene=scene)
        for method, (colour, marker, dashes, name) in STYLES.items():
            by_rays = sorted(pick(own, method=method), key=lambda row: float(row["rays"]))
            points = [(float(row[across]), float(row["rms"])) for row in by_rays]
            if points:
                axes.plot(*zip(*points, strict=True), color=colour, marker=marker, ls=dashes,
                          ms=4.5, lw=1.4, label=name)  # fmt: skip
        e100 = random_error(own, 100)
        axes.axhline(e100, color="#777777", lw=1, ls=":")
        axes.annotate("error of 100 random rays", (1, e100), (-2, 3), ha="right", fontsize=8,
                      xycoords=("axes fraction", "data"), textcoords="offset points",
                      color="#555555")  # fmt: skip
        axes.set_xscale("log")
        axes.set_yscale("log")
        tidy(axes)
        axes.set_title(f"{TITLES[scene]}, {int(own[0]['ommatidia']):,} ommatidia", fontsize=10)
        axes.set_xlabel(label)
        axes.set_ylabel("error (RMS; full scale 1)")
    legend(figure)
    save(figure, path)


def frames(rows: list[Row], error_rows: list[Row], path: Path) -> None:
    """Frames/s by rays, ours beside CompoundRay's, and at equal error."""
    eyes = sorted({int(row["ommatidia"]) for row in rows})
    figure = Figure(figsize=(5.2 * len(eyes), 4.6), layout="constrained")
    equal = equal_error(error_rows)
    theirs = published()
    by_eye = (theirs, {BEE_RAYS: BEE_FRAMES_PER_S})
    panels = figure.subplots(1, len(eyes), sharey=True, squeeze=False)[0]
    for axes, eye, table in zip(panels, eyes, by_eye, strict=False):
        own = sorted((int(r["rays"]), float(r["frames_per_s"])) for r in pick(rows, ommatidia=eye))
        reached = [(rays, 1e3 / way.ms) for n, rays, _, _, way in equal if int(n) == eye]
        # A ring, so that it shows around a mark in the same place.
        axes.plot(*zip(*table.items(), strict=True), color="#000000", marker="o", ms=10, mfc="none",
                  label="CompoundRay on an RTX 2080 Ti, published")  # fmt: skip
        axes.plot(*zip(*own, strict=True), color="#E69F00", marker="s", ls="--",
                  label="Omma, as many rays")  # fmt: skip
        if reached:
            axes.plot(*zip(*reached, strict=True), color="#0072B2", marker="D",
                      label="Omma, as small an error")  # fmt: skip
        axes.set_xscale("log")
        axes.set_yscale("log")
        tidy(axes)
        axes.set_xticks(list(theirs))
        axes.set_xlabel("CompoundRay's random rays per ommatidium")
        of = "1,000" if table is theirs else "about 6,000"
        axes.set_title(f"{eye:,} ommatidia (published: {of})", fontsize=10)
    panels[0].set_ylabel("frames per second")
    legend(figure)
    save(figure, path)


def make(results: Path, out: Path) -> None:
    """All pictures for which there are tables."""
    mpl.rcParams["font.size"] = 9
    error_rows = read(results, "error")
    if rows := read(results, "ceiling"):
        ceiling(rows, out / "performance-ceiling.png")
    if error_rows:
        errors(error_rows, "rays", "rays per ommatidium (mean)", out / "performance-error.png")
        label = "milliseconds per frame"
        errors(error_rows, "ms_per_frame", label, out / "performance-time.png")
    if rows := read(results, "frames"):
        frames(rows, error_rows, out / "performance-frames.png")


def main() -> None:
    """Read, draw, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--results", type=Path, default=ROOT / "bench" / "results")
    parser.add_argument("--out", type=Path, default=ROOT / "docs")
    given = parser.parse_args()
    make(given.results, given.out)


if __name__ == "__main__":
    main()
