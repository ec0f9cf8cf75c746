"""How figures look and how they are written: to `.pdf`, `.svg` and `.png`, the same bytes for the
same figure. Needs Matplotlib, an optional extra.
"""

from __future__ import annotations

import io
import os
import textwrap
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omma.base.addresses import local_path
from omma.base.files import PathLike, WholeFiles, check_ending, check_target
from omma.base.optional import needs

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK = "#222222"
GREY = "#8a8a8a"
#: Told apart by colour-blind eyes too (Okabe and Ito 2008).
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")

MM = 1 / 25.4  # inches
_ENDINGS = (".pdf", ".svg", ".png")


def load_matplotlib() -> type[Figure]:
    """Matplotlib's Figure; it draws without a display.

    Raises:
        omma.Error: Matplotlib is not installed.
    """
    kind: type[Figure] = needs("matplotlib.figure", "plots", "a plot needs Matplotlib").Figure
    return kind


def figure_names(paths: PathLike | Sequence[PathLike]) -> list[str]:
    """The names; omma.Error where one ends in none of .pdf, .svg and .png or cannot be written."""
    given = [paths] if isinstance(paths, (str, os.PathLike)) else paths
    names = [local_path(path) for path in given]
    for name in names:
        check_ending(name, *_ENDINGS)
        check_target(name)
    return names


@contextmanager
def figure_style(size_pt: float = 7.5) -> Iterator[None]:
    """Type and lines as papers have them; to be in force while a figure is made and written.

    Raises:
        omma.Error: Matplotlib is not installed.
    """
    load_matplotlib()
    from matplotlib import rc_context

    settings: Any = {
        "font.size": size_pt,
        "axes.titlesize": size_pt * 1.05,
        "axes.labelsize": size_pt,
        "xtick.labelsize": size_pt * 0.9,
        "ytick.labelsize": size_pt * 0.9,
        "legend.fontsize": size_pt * 0.9,
        "axes.linewidth": 0.6,
        "axes.edgecolor": INK,
        "axes.labelcolor": INK,
        "text.color": INK,
        "xtick.color": INK,
        "ytick.color": INK,
        "xtick.major.width": 0.6,
        "ytick.major.width": 0.6,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "lines.linewidth": 1.2,
        # Text as outlines, and no ids or dates that change: the same figure gives the same bytes.
        "svg.fonttype": "path",
        "svg.hashsalt": "omma",
        "pdf.fonttype": 42,  # journals want fonts, not drawings of letters
    }
    with rc_context(settings):
        yield


def wrapped(title: str, letters: int) -> str:
    """A title in lines of so many letters at most, which end at its commas where they can: not
    between a number and its unit."""
    lines = [""]
    for part in title.split(", "):
        longer = f"{lines[-1]}, {part}" if lines[-1] else part
        if len(longer) < letters or not lines[-1]:
            lines[-1] = longer
        else:
            lines[-1] += ","
            lines.append(part)
    return "\n".join(textwrap.fill(line, letters) for line in lines)


def plain(name: str) -> str:
    """A name that is drawn as it stands: between two $ Matplotlib reads mathematics."""
    return name.replace("$", r"\$")


def legend_of(
    owner: Axes | Figure, marks: Sequence[Any], names: Sequence[str], **place: Any
) -> Any:
    """A legend of marks by names as they stand; Matplotlib's own leaves out those that begin with
    an underscore."""
    legend = owner.legend(marks, [f"{k}" for k in range(len(names))], frameon=False, **place)
    for text, name in zip(legend.get_texts(), names, strict=True):
        text.set_text(plain(name))
    return legend


def save_figure(figure: Figure, names: Sequence[str], dpi: float = 200) -> None:
    """Write a figure under names from `figure_names`: all of them or none."""
    with WholeFiles() as files:
        for name in names:
            kind = Path(name).suffix.lower()[1:]
            dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": {}}
            picture = io.BytesIO()
            figure.savefig(picture, format=kind, dpi=dpi, metadata=dates[kind])
            files.open(name).write(picture.getvalue())
