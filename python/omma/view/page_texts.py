"""Pieces of HTML that the page shows: the live pictures, numbers, commands."""

from __future__ import annotations

import html

import numpy as np

from omma.view.command import Sources, render_command, render_python
from omma.view.state import Seen

# The scripts of the page put the pictures in.
PICTURE = (
    '<div style="padding:6px 12px 0"><img id="omma-{name}" data-omma-picture="{name}" '
    'alt="{says}" title="{title}" draggable="false" style="width:100%;{size}display:block;'
    'background:#808080;object-fit:contain"></div>'
)
EYE_PICTURE = PICTURE.format(
    name="eye",
    says="what the animal sees",
    title="Click: pick the ommatidium; drag: turn the head",
    # Lambert's discs would be as high as they are wide.
    size="min-height:120px;max-height:45vh;",
)
CAMERA_PICTURE = PICTURE.format(
    name="camera", says="a camera's picture", title="", size="aspect-ratio:16 / 9;"
)
LINKS = (
    '<div class="omma-links"><button data-omma-do="layout">Larger (V)</button>'
    '<button data-omma-do="save">Save (P)</button>'
    '<button data-omma-do="help">Keys (H)</button></div>'
)
FLY = '<div class="omma-links"><button data-omma-do="fly">Fly (F)</button></div>'
# By it the page's scripts know which of viser's clients their browser is.
CLIENT = '<i data-omma-client="{number}" hidden></i>'
_PRE = (
    "white-space:pre-wrap;overflow-wrap:anywhere;font-size:11px;background:rgba(127,127,127,.14);"
    "padding:8px;border-radius:4px;margin:4px 12px;user-select:all"
)


def numbers_html(seen: Seen, frame_s: float, note: str) -> str:
    """The line below the picture: rays, error, time."""
    rays = f"{seen.samples} rays"
    error = ""
    if seen.standard_error:
        errors = seen.errors if seen.receptors is None else seen.receptor_errors
        assert errors is not None
        rays = f"8 × {seen.samples} rays"
        error = f" · standard error {float(np.median(errors)):.3g} (median)"
    speed = f"{1e3 * seen.seconds:.0f} ms"
    if not seen.standard_error and 0 < frame_s < 1:
        speed += f", {1 / frame_s:.0f} frames/s"
    lines = f'<span id="omma-status">{rays}{error} · {speed}</span>'
    if note:
        lines += f"<br>In the scene {html.escape(note)}."
    return f'<p style="margin:4px 12px;font-size:12px">{lines}</p>'


def saved_html(sources: Sources, seen: Seen) -> str:
    """The command and the lines of Python that render what is seen."""
    command, why = render_command(sources, seen)
    parts = ['<p style="margin:4px 12px">These numbers as files, from the command line:</p>']
    if why is None:
        parts.append(f'<pre id="omma-command" style="{_PRE}">{html.escape(command)}</pre>')
    else:
        parts.append(f'<p style="margin:4px 12px">No command does: {html.escape(why)}.</p>')
    python = html.escape(render_python(sources, seen))
    parts.append('<p style="margin:4px 12px">In Python:</p>')
    parts.append(f'<pre id="omma-python" style="{_PRE}">{python}</pre>')
    return "".join(parts)
