"""Pieces of HTML that the page shows: the live pictures, numbers, commands."""

from __future__ import annotations

import html

import numpy as np

from omma.view.command import Sources, render_command, render_python
from omma.view.state import Seen

# The address is beside the page's own, below the token where there is one.
PICTURE = (
    '<div style="padding:6px 12px 0"><img id="omma-{name}" src="{name}.mjpeg" alt="{name}" '
    'style="width:100%;aspect-ratio:{ratio};display:block;background:#808080;'
    'object-fit:contain"{more}></div>'
)
# Where a click is in the picture goes to the door. What is not as wide as its frame stands in the
# middle of it.
_CLICK = (
    ' title="Click: pick the ommatidium" onclick="'
    "const r=this.getBoundingClientRect(),"
    "s=Math.min(r.width/this.naturalWidth,r.height/this.naturalHeight),"
    "w=s*this.naturalWidth,h=s*this.naturalHeight,"
    "x=(event.clientX-r.left-(r.width-w)/2)/w,y=(event.clientY-r.top-(r.height-h)/2)/h;"
    "if(x>=0&amp;&amp;x<=1&amp;&amp;y>=0&amp;&amp;y<=1)fetch('eye.click?x='+x+'&amp;y='+y,{method:'POST'})\""
)
EYE_PICTURE = PICTURE.replace("{more}", _CLICK.replace("{", "{{").replace("}", "}}")).format(
    name="eye", ratio="2 / 1"
)
KEYS = (
    '<p style="margin:2px 12px;font-size:12px;opacity:.75">Keys: I K J L ahead, back, left, '
    "right; U O up, down; N M turn. The camera: W A S D Q E, arrows, mouse.</p>"
)
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
