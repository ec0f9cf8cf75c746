"""Tables and plots of what the measuring tools found: `.csv`, `.npy` and `.png`.

Plots need Matplotlib, which is imported only here and only when a plot is made.
"""

from __future__ import annotations

import io
import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of, checked
from omma.base.figures import load_matplotlib
from omma.base.files import PathLike, WholeFiles, check_ending, write_whole
from omma.base.renamed import renamed_arguments
from omma.base.tables import csv_text
from omma.study.search import MinimumSamples
from omma.study.speed_test import PUBLISHED_FRAMES_PER_S, PUBLISHED_RAYS, SpeedTest
from omma.study.variance import COMPOUNDRAY, OURS, Measure, Method, cell_middles

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Told apart by colour-blind eyes too (Okabe and Ito 2008).
_COLOURS = {OURS: "#0072B2", COMPOUNDRAY: "#D55E00"}
_OTHER, _GREY = "#009E73", "0.45"
_SCATTER = {
    "linear": "standard deviation of the response (1 = full scale)",
    "compoundray": "standard deviation, 8-bit RGB distance (of 441.7)",
}


@checked
def save_minimum_samples(path: PathLike, found: Sequence[MinimumSamples]) -> None:
    """Write the curves of several searches to `.csv` or a log-log plot `.png`.

    `.csv`: angular_sensitivity, points, measure, rays_per_sr, standard_deviation, a line a point.

    Raises:
        omma.Error: another ending, no Matplotlib, searches of different measures, no such folder.
    """
    if not found or len({(one.measure, one.limit) for one in found}) != 1:
        raise Error("found: expected searches, all of one measure and fraction")
    if _suffix(path, ".csv", ".png") == ".csv":
        rows = [
            (*_names(one.method), one.measure, n, sd)
            for one in found
            for n, sd in zip(one.rays.tolist(), one.standard_deviations.tolist(), strict=True)
        ]
        header = ("angular_sensitivity", "points", "measure", "rays_per_sr", "standard_deviation")
        _save_csv(path, header, rows)
        return
    figure, axes = _figure("rays per steradian", _SCATTER[found[0].measure])
    axes.axhline(found[0].limit, color=_GREY, linestyle="--", label=f"limit {found[0].limit:.3g}")
    for one in found:
        colour = _COLOURS.get(one.method, _OTHER)
        label = f"{one.method.name}: {one.rays_per_sr:,} rays/sr"
        axes.loglog(one.rays, one.standard_deviations, "o-", ms=4, color=colour, label=label)
        axes.axvline(one.rays_per_sr, linestyle=":", linewidth=1, color=colour)
    axes.set_title("Scatter at the worst position found, 1 sr ommatidia")
    _finish(axes)
    _save_png(path, figure)


@renamed_arguments(centre_m="center_m")
@checked
def save_variance_map(
    path: PathLike,
    variance: ArrayLike,
    center_m: ArrayLike,
    size_m: float,
    *,
    measure: Measure = "linear",
    statistic: str = "max",
    as_variance: bool = False,
) -> None:
    """Write a `variance_map` (n, n) as standard deviation to `.npy`, `.csv` or a picture `.png`.

    `.csv`: x_m, z_m and the value, a line a cell. ``as_variance`` writes the variance itself.
    ``measure`` and ``statistic`` are those of the map. The colours of the picture span all but the
    highest and the lowest percent of the cells, as the inside of an object would darken the rest.

    Raises:
        omma.Error: another ending, no Matplotlib, another shape, no such folder.
    """
    values = array_of(variance, "variance")
    if values.ndim != 2 or values.shape[0] != values.shape[1]:
        raise Error(f"variance: expected shape (n, n), found {values.shape}")
    values = values if as_variance else np.sqrt(values)
    x, z = cell_middles(center_m, size_m, len(values))
    suffix = _suffix(path, ".npy", ".csv", ".png")
    if suffix == ".npy":
        with WholeFiles() as files:
            np.save(files.open(os.fsdecode(path)), values)
    elif suffix == ".csv":
        cells = zip(np.tile(x, len(z)), np.repeat(z, len(x)), values.ravel(), strict=True)
        name = "variance" if as_variance else "standard_deviation"
        _save_csv(path, ("x_m", "z_m", name), [tuple(map(float, cell)) for cell in cells])
    else:
        quantity = _SCATTER[measure]
        if as_variance:
            quantity = quantity.replace("standard deviation", "variance").replace("441.7", "441.7²")
        _save_png(path, _map_figure(values, x, z, size_m / len(x) / 2, quantity, statistic))


@checked
def save_alias_curves(
    path: PathLike,
    rays: Sequence[int],
    curves: Mapping[Method, tuple[ArrayLike, ArrayLike]],
    *,
    measure: Measure = "linear",
) -> None:
    """Write what `alias_curve` gave for each method to `.csv` or a log-log plot `.png`.

    `.csv`: angular_sensitivity, points, rays_per_ommatidium, mean_sd_per_sr, rms_sd, a line a
    point.

    Raises:
        omma.Error: another ending, no Matplotlib, no such folder.
    """
    if not isinstance(curves, Mapping):
        raise TypeError(f"curves: expected a mapping of methods, found {type(curves).__name__}")
    counts = array_of(rays, "rays", (None,), np.int64)
    both = {
        method: [array_of(curve, f"curves, {method.name}", counts.shape) for curve in pair]
        for method, pair in curves.items()
    }
    if _suffix(path, ".csv", ".png") == ".csv":
        rows = [
            (*_names(method), int(n), float(a), float(b))
            for method, (per_sr, rms) in both.items()
            for n, a, b in zip(counts, per_sr, rms, strict=True)
        ]
        header = (
            "angular_sensitivity",
            "points",
            "rays_per_ommatidium",
            "mean_sd_per_sr",
            "rms_sd",
        )
        _save_csv(path, header, rows)
        return
    figure, axes = _figure("rays per ommatidium", "mean of standard deviation / solid angle (1/sr)")
    for method, (per_sr, _) in both.items():
        colour = _COLOURS.get(method, _OTHER)
        axes.loglog(counts, per_sr, "o-", ms=4, color=colour, label=method.name)
    scale = "1 = full scale" if measure == "linear" else "8-bit RGB distance, full scale 441.7"
    axes.set_title(f"Scatter of responses against rays ({scale})")
    _finish(axes)
    _save_png(path, figure)


@checked
def save_speed_test(path: PathLike, found: SpeedTest) -> None:
    """Write frames/s against rays per ommatidium to `.csv`, or a plot `.png` with those published.

    `.csv`: machine, threads, backend, ommatidia, frames, rays_per_ommatidium, frames_per_s,
    batch_frames_per_s.

    Raises:
        omma.Error: another ending, no Matplotlib, no such folder.
    """
    columns = (found.rays.tolist(), found.frames_per_s.tolist(), found.batch_frames_per_s.tolist())
    if _suffix(path, ".csv", ".png") == ".csv":
        about = (found.machine, found.threads, found.backend, found.ommatidia, found.frames)
        header = ("machine", "threads", "backend", "ommatidia", "frames", "rays_per_ommatidium")
        rows = [(*about, *row) for row in zip(*columns, strict=True)]
        _save_csv(path, (*header, "frames_per_s", "batch_frames_per_s"), rows)
        return
    figure, axes = _figure("rays per ommatidium", "frames per second")
    rays, single, batch = columns
    blue = _COLOURS[OURS]
    axes.loglog(rays, batch, "o-", ms=4, color=blue, label="Omma, all frames in one call")
    axes.loglog(rays, single, "o--", ms=4, color=blue, label="Omma, one call a frame", mfc="white")
    for shade, (label, speeds) in zip((_GREY, "0.7"), PUBLISHED_FRAMES_PER_S.items(), strict=True):
        label = label.replace("(published)", "(published; 1,000 ommatidia)")
        axes.loglog(PUBLISHED_RAYS, speeds, "s-", ms=4, color=shade, label=label)
    axes.set_title(
        f"Omma: {found.ommatidia:,} ommatidia\n"
        f"{found.machine}, {found.threads} threads; {found.backend}",
        fontsize="medium",
    )
    _finish(axes)
    _save_png(path, figure)


def _map_figure(
    values: NDArray[np.float64],
    x: NDArray[np.float64],
    z: NDArray[np.float64],
    half_m: float,
    quantity: str,
    statistic: str,
) -> Figure:
    figure, axes = _figure("x (m)", "z (m); ahead, which is -z, is at the top", size=(6.4, 5.2))
    low, high = np.percentile(values, (1, 99))
    image = axes.imshow(
        values,
        extent=(x[0] - half_m, x[-1] + half_m, z[-1] + half_m, z[0] - half_m),
        origin="upper",
        cmap="viridis",
        vmin=low,
        vmax=high,
    )
    figure.colorbar(image, ax=axes, label=quantity, extend="both")
    axes.grid(False)
    of = "mean" if statistic == "mean" else "largest"
    axes.set_title(f"How much the light varies within 1 sr ({of} of twelve ommatidia)", fontsize=10)
    return figure


def _figure(
    x_label: str, y_label: str, size: tuple[float, float] = (7.2, 4.8)
) -> tuple[Figure, Axes]:
    figure = load_matplotlib()(figsize=size, layout="constrained")
    axes = figure.add_subplot()
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    axes.grid(True, which="major", color="0.88")
    return figure, axes


def _finish(axes: Axes) -> None:
    """Plain numbers along logarithmic axes, and a legend."""
    axes.xaxis.set_major_formatter("{x:,g}")
    axes.yaxis.set_major_formatter("{x:,g}")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2, fontsize="small")


def _suffix(path: PathLike, *known: str) -> str:
    check_ending(path, *known)
    return Path(os.fsdecode(path)).suffix.lower()


def _names(method: Method) -> tuple[str, str]:
    return method.angular_sensitivity, method.points


def _save_csv(path: PathLike, header: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    def text(value: Any) -> Any:
        if not isinstance(value, float):
            return value
        return "" if math.isnan(value) else f"{value:.9g}"

    cells = (map(text, row) for row in rows)
    write_whole(path, csv_text(header, cells).encode())


def _save_png(path: PathLike, figure: Figure) -> None:
    buffer = io.BytesIO()
    # Tight, as the layout alone cuts labels beside pictures that keep their aspect.
    figure.savefig(buffer, format="png", dpi=130, bbox_inches="tight")
    write_whole(path, buffer.getvalue())
