"""Makes the picture and the table of bench/notes/many-cameras.md from bench/results/cameras.csv,
which `scripts/bench cameras` measures (and then calls this for the picture).

    .venv/bin/python docs/make_many_cameras_figure.py
"""

from __future__ import annotations

import sys
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "bench" / "notes" / "many-cameras.md"
START, END = "<!-- table: made by make_many_cameras_figure.py -->", "<!-- end of the table -->"
sys.path.insert(0, str(ROOT / "bench"))

from curves import Row, pick, read  # noqa: E402
from make_performance_figures import legend, save, tidy  # noqa: E402
from report_cameras import AT_PERCENT, tables_of, times_table  # noqa: E402

# Okabe and Ito's colours; filled for Omma, open for Mitsuba.
STYLES = {
    "Omma, own rays": ("#0072B2", "o", "-"),
    "Omma, shared rays": ("#D55E00", "P", "-"),
    "Omma, cube map": ("#009E73", "s", "-"),
    "Mitsuba, rays": ("#56B4E9", "o", "--"),
    "Mitsuba, still cameras": ("#E69F00", "v", "--"),
    "Mitsuba, cameras": ("#000000", "^", "--"),
    "Mitsuba, cube map": ("#CC79A7", "s", "--"),
}


def panel(axes: Axes, rows: list[Row]) -> None:
    """Error against time of one eye in one light."""
    for way, (colour, marker, dashes) in STYLES.items():
        own = pick(rows, way=way)
        points = sorted((float(row["ms_per_frame"]), float(row["error_percent"])) for row in own)
        if not points:
            continue
        # Cube maps of several sizes are no one curve.
        line = "none" if way.endswith("cube map") else dashes
        fill = colour if way.startswith("Omma") else "white"
        axes.plot(
            *zip(*points, strict=True), color=colour, marker=marker, ls=line, ms=6, lw=1.3,
            markerfacecolor=fill, markeredgewidth=1.4, label=way, zorder=3,
        )  # fmt: skip
        if line == "none":
            for row in own:
                size, _, rays = row["setting"].split(" x ")
                at = (float(row["ms_per_frame"]), float(row["error_percent"]))
                if rays == "1" and way.startswith("Omma"):
                    axes.annotate(
                        size, at, (-5, -3), textcoords="offset points", fontsize=7, ha="right",
                        va="top", color=colour,
                    )  # fmt: skip
    axes.set_xscale("log")
    axes.set_yscale("log")
    tidy(axes)
    axes.tick_params(axis="x", labelrotation=45)
    place = max(float(row["place_percent"] or 0) for row in rows)
    axes.axhline(place, color="#009E73", lw=1, ls=":")
    axes.annotate(
        "cube maps: one place for all ommatidia", (0, place), (4, -10), ha="left", fontsize=7.5,
        xycoords=("axes fraction", "data"), textcoords="offset points", color="#555555",
    )  # fmt: skip


def make(results: Path, out: Path) -> None:
    """The picture, where it was measured."""
    rows = read(results, "cameras")
    if not rows:
        return
    tables = tables_of(rows)
    columns = len({eye for _, eye in tables})
    lines = -(-len(tables) // columns)
    figure = Figure(figsize=(5.4 * columns, 4.0 * lines + 0.8), layout="constrained")
    panels = figure.subplots(lines, columns, squeeze=False, sharex="col", sharey="row")
    for axes in panels.ravel()[len(tables) :]:
        axes.set_visible(False)
    for axes, (lighting, eye) in zip(panels.ravel(), tables, strict=False):
        own = pick(rows, lighting=lighting, eye=eye)
        panel(axes, own)
        count = int(own[0]["ommatidia"])
        axes.set_title(f"{eye.capitalize()}, {count:,} ommatidia, {lighting}", fontsize=10)
    for axes in panels[-1]:
        axes.set_xlabel("milliseconds per frame, one thread")
    for axes in panels[:, 0]:
        axes.set_ylabel("error (RMS, % of the mean response)")
    legend(figure)
    save(figure, out / "many-cameras.png")


def write_table(rows: list[Row]) -> None:
    """Into the page, between its two marks."""
    names = [
        "light",
        "eye",
        "way",
        *(f"ms to {error:g} %" for error in AT_PERCENT),
        "least error, %",
    ]
    cells = [names, ["---"] * len(names), *times_table(rows)]
    lines = ["| " + " | ".join(str(cell) for cell in line) + " |" for line in cells]
    before, rest = PAGE.read_text(encoding="utf-8").split(START)
    after = rest.split(END)[1]
    table = "\n".join(lines)
    PAGE.write_text(f"{before}{START}\n\n{table}\n\n{END}{after}", encoding="utf-8")


def main() -> None:
    """Both."""
    results = ROOT / "bench" / "results"
    make(results, ROOT / "docs")
    write_table(read(results, "cameras"))


if __name__ == "__main__":
    main()
