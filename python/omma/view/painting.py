"""What is seen as a picture: which numbers are shown, in which colours, in which projection."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from omma._core import Error, Eye, rgb_bands
from omma.base.arrays import Flags, Floats32
from omma.picture.band_colours import colours_of
from omma.picture.cameras import display
from omma.picture.id_maps import paint
from omma.picture.projections import projection_ids
from omma.picture.response_colours import receptors_shown
from omma.picture.unseen import aspect_of, hatch, unseen
from omma.scene.world import World
from omma.view.state import Seen

Pixels = NDArray[np.uint8]
Ids = NDArray[np.int32]

#: What the page calls projections, and what `omma.picture.project` calls them.
PROJECTIONS: dict[str, str | None] = {
    "facets on the eye": "facets",
    "Mollweide": "mollweide",
    "equirectangular": None,
    "Lambert": "lambert",
}
COLOURS = "colours"
FALSE_COLOURS = "receptors, false colours"
_RGB = ("red", "green", "blue")
_MARK = (255, 0, 220)
_GAMMA = 2.2
# White point of lit worlds and receptors: this quantile of the numbers.
_WHITE_SHARE = 98.0


@dataclass(frozen=True)
class Channel:
    """What of the numbers is shown. band: of responses; kind: of receptors; None: as colours."""

    name: str
    receptors: bool = False
    band: int | None = None
    kind: str | None = None


def channels_of(world: World, eye: Eye) -> list[Channel]:
    """What can be shown of an eye in a world: colours, each band, and its receptors."""
    found = []
    if world.light is not None:
        found.append(Channel(COLOURS))
        nm = world.light.bands.centers_nm.tolist()
        found += [Channel(f"band {k}, {each:.0f} nm", band=k) for k, each in enumerate(nm)]
    elif world.band_from_rgb is None:
        found.append(Channel(COLOURS))
        found += [Channel(name, band=k) for k, name in enumerate(_RGB)]
    else:
        found += [Channel(f"band {k}", band=k) for k in range(world.bands)]
    if len(eye.receptor_type) and (world.light is not None or world.band_from_rgb is None):
        found.append(Channel(FALSE_COLOURS, receptors=True))
        present, types = np.unique(eye.receptor_type).tolist(), eye.receptor_types
        names = dict.fromkeys(types[k].name for k in present)
        found += [Channel(f"receptor {name}", receptors=True, kind=name) for name in names]
    return found


def shown_values(world: World, eye: Eye, seen: Seen, channel: Channel) -> Floats32:
    """Linear red, green and blue of each ommatidium (N, 3), before exposure; one number three times
    where it is grey."""
    if channel.receptors:
        assert seen.receptors is not None
        if channel.kind is not None:
            one = receptors_shown(eye, seen.receptors, (channel.kind,), "receptors").values[0]
            return np.repeat(one[:, :1], 3, axis=1).astype(np.float32)
        values = receptors_shown(eye, seen.receptors, _kinds(eye), "receptors").values[0]
        if values.shape[1] == 3:
            return np.asarray(values, np.float32)
        # Of two: the longer in yellow, the shorter in blue; of one in grey.
        column = [0, 0, 1] if values.shape[1] == 2 else [0, 0, 0]
        return np.asarray(values[:, column], np.float32)
    assert seen.responses is not None
    if channel.band is not None:
        return np.repeat(seen.responses[:, channel.band : channel.band + 1], 3, axis=1)
    return _as_rgb(world, seen.responses)


def _kinds(eye: Eye) -> tuple[str, ...] | None:
    """The receptors of a picture in false colours: by peak, which is what None asks for, unless an
    eye has more than three; then its three most frequent types."""
    types = eye.receptor_types
    peaks = {round(t.peak_wavelength_nm) for t in types if t.peak_wavelength_nm}
    if len(peaks) <= 3 and len(types) <= 3:
        return None
    counts = np.bincount(eye.receptor_type, minlength=len(types))
    names: list[str] = []
    for k in np.argsort(-counts, kind="stable").tolist():
        name = types[k].name
        if counts[k] and name not in names and len(names) < 3:
            names.append(name)
    return tuple(names)


def _as_rgb(world: World, values: Floats32) -> Floats32:
    if world.light is not None:
        return np.asarray(colours_of(world, values))
    if values.shape[-1] != rgb_bands:
        raise Error(f"channel: expected one of the {values.shape[-1]} bands, which are no colours")
    return values


def white_of(world: World, channel: Channel, values: Floats32) -> float:
    """What is shown as white with an exposure of 0: 1, the full scale of a scene without light;
    else what nearly all of the numbers stay below."""
    if world.light is None or (not channel.receptors and channel.band is None):
        return 1.0
    white = float(np.percentile(values, _WHITE_SHARE))
    return white if np.isfinite(white) and white > 0 else 1.0


def eye_ids(eye: Eye, projection: str, width: int) -> Ids:
    """Which ommatidium each pixel shows, of one of `PROJECTIONS`; -1 for none."""
    if projection not in PROJECTIONS:
        names = ", ".join(PROJECTIONS)
        raise Error(f"projection: expected one of {names}, found {projection!r}")
    name = PROJECTIONS[projection]
    return projection_ids(eye, name, width * aspect_of(name) // 2)


def unseen_in(ids: Ids, projection: str) -> Flags:
    """Where `eye_ids` of that projection are directions that no ommatidium sees."""
    return unseen(ids, PROJECTIONS[projection])


def paint_eye(
    ids: Ids,
    values: Floats32,
    white: float,
    stops: float,
    chosen: int | None = None,
    hidden: Flags | None = None,
) -> Pixels:
    """The picture (height, width, 3) of values (N, 3); ``stops`` of exposure make it twice as
    bright each, the chosen ommatidium is framed, what is ``hidden`` is hatched."""
    # The engine paints what is finite.
    scaled = np.nan_to_num(values * np.float32(2.0**stops / white), posinf=1.0, neginf=0.0)
    pixels = paint(ids, scaled, _GAMMA)
    if hidden is not None:
        hatch(pixels, hidden)
    if chosen is not None:
        pixels[frame_of(ids == chosen)] = _MARK
    return pixels


def frame_of(inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The pixels around those that are ``inside``, two wide, so that a facet of one pixel shows."""
    wide = inside.copy()
    for _ in range(2):
        grown = wide.copy()
        grown[1:] |= wide[:-1]
        grown[:-1] |= wide[1:]
        grown[:, 1:] |= wide[:, :-1]
        grown[:, :-1] |= wide[:, 1:]
        wide = grown
    return np.asarray(wide & ~inside)


def paint_camera(world: World, picture: Floats32, stops: float) -> Pixels:
    """A camera's picture (height, width, C) in colours; without colours the first band in grey."""
    if world.light is None and picture.shape[-1] != rgb_bands:
        rgb = np.repeat(picture[..., :1], 3, axis=2)
    else:
        rgb = _as_rgb(world, picture)
    return display(np.ascontiguousarray(rgb * np.float32(2.0**stops)), _GAMMA)
