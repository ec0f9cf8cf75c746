"""Makes docs/performance-loop.png, how long turns of a closed loop take, from
bench/results/motion.csv, which `scripts/bench motion` measures (and then calls this).

    .venv/bin/python docs/make_loop_figure.py
"""

from __future__ import annotations

import sys
from pathlib import Path

from matplotlib.figure import Figure

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "bench"))

from curves import pick, read  # noqa: E402
from make_performance_figures import save, tidy  # noqa: E402


def make(results: Path, out: Path) -> None:
    """The histogram, where it was measured."""
    rows = read(results, "motion")
    bins = pick(rows, what="loop histogram µs")
    if not bins:
        return
    low = [float(row["setting"]) / 1000 for row in bins]
    counts = [int(row["value"]) for row in bins]
    figure = Figure(figsize=(7, 3), layout="constrained", dpi=130)
    axes = figure.subplots()
    widths = [low[k + 1] - low[k] for k in range(len(low) - 1)]
    axes.bar(low[:-1], counts[:-1], widths, align="edge", color="#0072B2")
    axes.set_xscale("log")
    for row in pick(rows, what="loop µs"):
        if row["setting"] in ("50 %", "99 %"):
            at = float(row["value"]) / 1000
            axes.axvline(at, color="#D55E00", lw=1.2)
            is_half = row["setting"] == "50 %"
            axes.annotate(
                f"{row['setting']}: {at:.2f} ms", (at, 0.97), (-4 if is_half else 4, 0), va="top",
                ha="right" if is_half else "left", fontsize=9, textcoords="offset points",
                xycoords=("data", "axes fraction"), color="#D55E00",
            )  # fmt: skip
    filled = [k for k, count in enumerate(counts) if count]
    axes.set_xlim(0.5 * low[filled[0]], min(low[-1], 4 * low[filled[-1]]))
    axes.set_ylim(top=1.2 * max(counts))  # room for what the lines are
    axes.set_xlabel("time of one turn: move 10 things, render 1,000 ommatidia, read, ms")
    axes.set_ylabel(f"turns of {sum(counts):,}")
    tidy(axes)
    save(figure, out / "performance-loop.png")


if __name__ == "__main__":
    make(ROOT / "bench" / "results", ROOT / "docs")
