"""The default picture for people to look at: each eye in a border of its own, with its name,
degrees of azimuth and elevation around it, and hatching where that eye sees nothing.

The letters are Pillow's, so that no plotting library is needed for a first picture.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Eye
from omma.base.arguments import checked
from omma.base.directions import azimuth_elevation_deg_of
from omma.eye.neighbours import sides
from omma.picture.fields import default_ids, side_by_side_ids
from omma.picture.projections import Picture, displayed_pose, projection_size
from omma.picture.unseen import hatching

if TYPE_CHECKING:
    from PIL.Image import Image as PaperImage
    from PIL.ImageDraw import ImageDraw

_PAPER, _INK = (255, 255, 255), (34, 34, 34)
_LEAST_LETTERS, _MOST_LETTERS = 9, 48  # pixels high
_LINES = 20  # of letters in the height of a panel
_STEPS = (30, 45, 90, 180)  # between labels, degrees
_MOST_DOTS = 32


@checked
def framed(
    eye: Eye,
    responses: ArrayLike,
    width: int | None = None,
    height: int | None = None,
    *,
    apart: bool = False,
    gamma: float = 2.2,
) -> Picture:
    """One pose's responses as the default picture for people: uint8 RGB, row 0 at the top.

    As `project` without a projection, in a border with degrees: azimuth grows to the right, with
    straight ahead in the middle, elevation upwards. Where eyes are drawn apart, L is the left eye
    and R the right one. Directions that no ommatidium of a panel sees are hatched. Programs want
    `project`, whose pixels are directions and nothing else.

    Args:
        eye: the eye that the responses are of.
        responses: (N, 3) or (1, N, 3), linear.
        width, height: pixels of each panel, around which the border comes; as in `projection_ids`.
        apart: each eye in a panel of its own, also where no direction is seen by two.
        gamma: display value = 255 * clamp(response) ** (1 / gamma).

    Raises:
        omma.Error: responses of another eye or below 0, or arguments that make no sense.
    """
    return Frame(eye, width, height, apart).paint(displayed_pose(eye, responses), gamma)


class Frame:
    """The id map of an eye's default picture and what is drawn around it, for any number of them.

    What no pixel shows, an ommatidium without an acceptance angle or neighbours say, is a dot with
    its number, where these are few.
    """

    def __init__(
        self, eye: Eye, width: int | None, height: int | None, apart: bool = False
    ) -> None:
        from PIL import Image, ImageDraw

        width, height = projection_size(eye, None, width, height)
        ids = side_by_side_ids(eye, width, height) if apart else default_ids(eye, width, height)
        self._ids = ids
        count = ids.shape[1] // width
        self._hatched = hatching(ids < 0)
        letters = min(max(height // _LINES, _LEAST_LETTERS), _MOST_LETTERS)
        font = _font(letters)
        line = max(1, height // 256)
        tick = letters // 2
        left = tick + line + round(font.getlength("-90°")) + 3 * letters // 2
        # Between two panels, so that -180° of the one and 180° of the other both fit.
        gap = round(font.getlength("180°")) + letters if count > 1 else 0
        top = (2 * letters if count > 1 else letters) + line
        bottom = line + tick + 3 * letters
        size = (left + count * width + (count - 1) * gap + letters * 2, top + height + bottom)
        paper = Image.new("RGB", size, _PAPER)
        draw = ImageDraw.Draw(paper)
        self._corners = [(top, left + k * (width + gap)) for k in range(count)]
        self._width = width
        for k, (y, x) in enumerate(self._corners):
            box = (x - line, y - line, x + width + line - 1, y + height + line - 1)
            draw.rectangle(box, outline=_INK, width=line)
            name = _panel_name(k, count)
            if name:
                draw.text((x, y - line - letters // 4), name, _INK, font, anchor="ls")
            _azimuths(draw, box, width, font, tick, line)
            _elevations(draw, box, height, font, tick, line, named=k == 0)
        _sideways(paper, "elevation", font, top + height // 2)
        self._paper = np.asarray(paper)

        self._font, self._dots = font, []
        missing = np.setdiff1d(np.arange(len(eye)), ids)
        for which in missing if len(missing) <= _MOST_DOTS else ():
            y, x = self._corners[_panel_of(eye, int(which), count)]
            azimuth, elevation = (float(a) for a in azimuth_elevation_deg_of(eye.axis[which]))
            at = (x + (azimuth + 180) / 360 * width, y + (90 - elevation) / 180 * height)
            self._dots.append((int(which), at))

    def paint(self, responses: NDArray[np.float32], gamma: float) -> Picture:
        """One pose's responses (N, 3) as a picture, hatched and framed."""
        pixels = self._hatched(_core.paint(self._ids, responses, gamma))
        whole: Picture = self._paper.copy()
        for k, (y, x) in enumerate(self._corners):
            panel = pixels[:, k * self._width : (k + 1) * self._width]
            whole[y : y + len(panel), x : x + self._width] = panel
        return self._with_dots(whole, responses, gamma) if self._dots else whole

    def _with_dots(self, whole: Picture, responses: NDArray[np.float32], gamma: float) -> Picture:
        from PIL import Image, ImageDraw

        shown = np.array([[which for which, _ in self._dots]], np.int32)
        colours = _core.paint(shown, responses, gamma)[0]
        picture = Image.fromarray(whole)
        draw = ImageDraw.Draw(picture)
        radius = max(3, self._font.size // 3)
        for (which, (x, y)), colour in zip(self._dots, colours.tolist(), strict=True):
            box = (x - radius, y - radius, x + radius, y + radius)
            draw.ellipse(box, fill=tuple(colour), outline=_INK)
            draw.text(
                (x + 1.5 * radius, y), str(which), _INK, self._font, anchor="lm",
                stroke_width=2, stroke_fill=_PAPER,
            )  # fmt: skip
        return np.array(picture)


def _panel_of(eye: Eye, which: int, count: int) -> int:
    """The panel of an ommatidium: of eyes that are apart, from left to right as they look."""
    if count == 1:
        return 0
    side = sides(eye.position_m.astype(np.float64), eye.eye_id)
    eyes = sorted(np.unique(side).tolist(), key=lambda one: eye.axis[side == one, 0].mean())
    return eyes.index(int(side[which]))


def _panel_name(k: int, count: int) -> str:
    if count == 1:
        return ""
    return ("L  left eye", "R  right eye")[k] if count == 2 else f"eye {k + 1} of {count}"


@lru_cache(maxsize=16)
def _font(letters: int) -> Any:
    from PIL import ImageFont

    return ImageFont.load_default(letters)


def _azimuths(
    draw: ImageDraw, box: tuple[int, int, int, int], width: int, font: Any, tick: int, line: int
) -> None:
    """Ticks each 30° below a panel, labels as close as they fit, and what they are."""
    left, _, _, bottom = box
    words = {-90: "left -90°", 0: "ahead 0°", 90: "right 90°"}
    pixels_per_degree = width / 360
    named = pixels_per_degree * 90 > 1.2 * float(font.getlength(words[90]))
    step = _step(pixels_per_degree, 1.3 * float(font.getlength("-180°")), 90 if named else 30)
    for azimuth in range(-180, 181, 30):
        x = round(left + line + (azimuth + 180) * pixels_per_degree)
        draw.line((x, bottom, x, bottom + tick // (1 if azimuth % step == 0 else 2)), _INK, line)
    for azimuth in range(-180, 181, step):
        x = round(left + line + (azimuth + 180) * pixels_per_degree)
        text = words.get(azimuth, f"{azimuth}°") if named else f"{azimuth}°"
        draw.text((x, bottom + tick), text, _INK, font, anchor="ma")
    middle = left + line + width // 2
    caption = "azimuth"
    if font.getlength(caption) < width:
        draw.text((middle, bottom + tick + font.size * 1.3), caption, _INK, font, anchor="ma")


def _elevations(
    draw: ImageDraw,
    box: tuple[int, int, int, int],
    height: int,
    font: Any,
    tick: int,
    line: int,
    named: bool,
) -> None:
    """Ticks each 30° left of a panel, and where it is the first of a row labels."""
    left, top, _, _ = box
    pixels_per_degree = height / 180
    step = _step(pixels_per_degree, 1.3 * font.size, 30)
    for elevation in range(-90, 91, 30):
        y = round(top + line + (90 - elevation) * pixels_per_degree)
        at_label = named and elevation % step == 0
        draw.line((left - tick // (1 if at_label else 2), y, left, y), _INK, line)
        if at_label:
            draw.text((left - tick - line, y), f"{elevation}°", _INK, font, anchor="rm")


def _sideways(paper: PaperImage, text: str, font: Any, middle: int) -> None:
    """What a vertical axis is, upwards along the left edge."""
    from PIL import Image, ImageDraw

    length = round(font.getlength(text))
    strip = Image.new("RGB", (length, 3 * font.size // 2), _PAPER)
    ImageDraw.Draw(strip).text((0, font.size // 8), text, _INK, font)
    if length < paper.height:
        paper.paste(strip.transpose(Image.Transpose.ROTATE_90), (0, middle - length // 2))


def _step(pixels_per_degree: float, least_pixels: float, least_degrees: int) -> int:
    """The closest labels that do not touch."""
    steps = [s for s in _STEPS if s >= least_degrees and s * pixels_per_degree > least_pixels]
    return (steps or [_STEPS[-1]])[0]
