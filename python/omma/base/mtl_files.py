"""Materials of OBJ files, from .mtl files: colour, transparency, glow and their pictures; roughness
and metal where programs write them (Pr, Pm). What else there is, is told.

Read here: tinyobjloader's Python package gives neither Ke nor the options of pictures, trimesh none
of them, and a line of these files is a word and its values.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma import _core
from omma._core import Error, Image, Material, Texture, TextureUse
from omma.base.mesh_parts import MeshParts
from omma.base.mesh_pictures import MOST_PIXELS, alpha_of, opaque, read_picture, with_alpha
from omma.base.named_files import found_beside, material_libraries

# Options before the name of a picture, and how many values each has at most; -o, -s and -t take
# one to three numbers.
_OPTIONS = {
    "-blendu": 1, "-blendv": 1, "-boost": 1, "-bm": 1, "-cc": 1, "-clamp": 1, "-imfchan": 1,
    "-mm": 2, "-o": 3, "-s": 3, "-t": 3, "-texres": 1, "-type": 1,
}  # fmt: skip
_HARMLESS = ("-blendu", "-blendv", "-bm", "-cc", "-texres", "-type")  # change no colour
_PICTURES = ("map_kd", "map_d", "map_ke")
# Other keywords that change the look; all that are neither here nor read are specular only.
_TOLD = {
    "map_bump", "bump", "norm", "disp", "decal", "refl", "map_ks", "map_ns", "map_pr", "map_pm",
    "map_ps", "map_tr", "map_opacity",
}  # fmt: skip


@dataclass
class _Picture:
    """What a line says of a picture."""

    name: str
    offset: tuple[float, float] = (0.0, 0.0)
    scale: tuple[float, float] = (1.0, 1.0)
    clamped: bool = False


@dataclass
class _Entry:
    """A material as its file has it."""

    values: dict[str, list[float]] = field(default_factory=dict)
    pictures: dict[str, _Picture] = field(default_factory=dict)


class Materials:
    """Those that an OBJ file uses, in ``parts``, and a white one for faces that name none."""

    def __init__(self, path: str, libraries: list[str], used: list[str]) -> None:
        self.parts = MeshParts()
        self._folder = os.path.dirname(path)
        self._told: Counter[str] = Counter()
        # Bytes of pictures that may be in memory, as for glTF: one of the largest size, and
        # well-packed ones beyond.
        self._bytes_left = 4 * MOST_PIXELS
        self._counted: set[str] = set()
        self._missing = False  # whether one of its .mtl files is
        self._entries: dict[str, _Entry] = {}
        self._texture_of: dict[object, int | None] = {}
        for library in libraries:
            self._read_library(library)
        for name in used:
            if name not in self._entries and not self._missing:
                self._told[f'material "{name}" is in no .mtl file and counts as white'] += 1
            self.parts.materials.append(self._material(name, self._entries.get(name, _Entry())))
        self.parts.materials.append(Material(double_sided=True))
        self.parts.warnings += [
            sentence + (f" ({count} times)" if count > 1 else "")
            for sentence, count in self._told.items()
        ]

    def _read_library(self, line: str) -> None:
        for name in material_libraries(self._folder, line):
            file = found_beside(self._folder, name)
            if file is None:
                self._missing = True
                self._told[f"{name or '.mtl'} is missing; its materials count as white"] += 1
                continue
            data = _core.read_file(file).replace(b"\\\n", b" ").replace(b"\\\r\n", b" ")
            entry = _Entry()
            for text in data.decode("utf-8", "replace").splitlines():
                word, _, rest = text.strip().replace("\t", " ").partition(" ")
                rest = rest.strip()
                if word.lower() == "newmtl":
                    entry = self._entries.setdefault(rest, _Entry())
                else:
                    self._read_line(entry, word.lower(), rest)

    def _read_line(self, entry: _Entry, word: str, rest: str) -> None:
        if word in _PICTURES:
            picture = self._picture(word, rest)
            if picture is not None:
                entry.pictures[word] = picture
        elif word in ("kd", "ke", "d", "tr", "pr", "pm", "tf"):
            values = rest.removeprefix("-halo").split()
            if values and values[0] in ("spectral", "xyz"):
                self._told[f"{word.capitalize()} {values[0]} is not read"] += 1
                return
            try:
                entry.values[word] = [float(one) for one in values[:3]]
                if not entry.values[word] or not np.isfinite(entry.values[word]).all():
                    raise ValueError
            except ValueError:
                entry.values.pop(word, None)
                self._told[f'"{word.capitalize()} {rest[:40]}" holds no numbers'] += 1
        elif word in _TOLD:
            self._told[f"{word} is not read"] += 1

    def _picture(self, word: str, rest: str) -> _Picture | None:
        made = _Picture("")
        words = rest.split(" ")
        while words and words[0].lower() in _OPTIONS:
            option = words.pop(0).lower()
            values: list[str] = []
            # The last word is of the name, whatever it looks like.
            while len(values) < _OPTIONS[option] and len(words) > 1:
                if option in ("-o", "-s", "-t", "-mm") and not _is_number(words[0]):
                    break
                values.append(words.pop(0))
            if option in ("-o", "-s") and values:
                pair = [float(one) for one in values[:2]]
                # Of coordinates that are left out, the scale is 1 and the offset 0.
                pair += [1.0 if option == "-s" else 0.0] * (2 - len(pair))
                if option == "-o":
                    made.offset = pair[0], pair[1]
                else:
                    made.scale = pair[0], pair[1]
            elif option == "-clamp":
                made.clamped = values == ["on"]
            elif option == "-mm" and [float(one) for one in values] == [0.0, 1.0]:
                continue
            elif option not in _HARMLESS:
                self._told[f"{word} {option} is not read"] += 1
        made.name = " ".join(words).strip().strip('"')
        return made if made.name else None

    def _material(self, name: str, entry: _Entry) -> Material:
        values, pictures = entry.values, entry.pictures
        color = self._color(values, "kd", 1.0)
        emissive = self._color(values, "ke", 1.0 if "map_ke" in pictures else 0.0)
        # Some write both, one of them the wrong way round: d is the one that is clear.
        opacity = values["d"][0] if "d" in values else 1 - values.get("tr", [0.0])[0]
        if not 0 <= opacity <= 1:
            self._told[f"an opacity of {opacity:g} counts as one of 0 to 1"] += 1
            opacity = min(max(opacity, 0.0), 1.0)
        if opacity == 0 and "map_d" not in pictures:
            self._told[f'material "{name}" is wholly transparent (d 0 or Tr 1), not seen'] += 1
        if any(one != 1 for one in values.get("tf", [])):
            self._told["Tf is not read"] += 1
        base, cut = self._base_texture(pictures)
        glow = self._texture(pictures["map_ke"]) if "map_ke" in pictures else None
        if "map_kd" in pictures and base is not None:
            color = [1.0, 1.0, 1.0]  # as exporters mean it: the picture replaces it
        mode = "blend" if opacity < 1 or cut == "blend" else cut
        return Material(
            name,
            base_color=[*color, opacity],
            base_color_texture=base,
            emissive=emissive,
            emissive_texture=glow,
            alpha_mode=mode,
            double_sided=True,
            roughness=min(max(values.get("pr", [1.0])[0], 0.0), 1.0),
            metallic=min(max(values.get("pm", [0.0])[0], 0.0), 1.0),
        )

    def _color(self, values: dict[str, list[float]], word: str, default: float) -> list[float]:
        found = values.get(word, [default])
        # One number stands for three.
        color = [max(one, 0.0) for one in (found if len(found) == 3 else found[:1] * 3)]
        if word == "kd" and max(color) > 1:
            self._told["Kd above 1 counts as 1"] += 1
            color = [min(one, 1.0) for one in color]
        return color

    def _base_texture(self, pictures: dict[str, _Picture]) -> tuple[TextureUse | None, str]:
        """The picture of colour and opacity, and what its alpha does: one of both, as the engine
        has them together."""
        picture, mask = pictures.get("map_kd"), pictures.get("map_d")
        if mask is None:
            return (None if picture is None else self._texture(picture)), "opaque"
        if picture is not None and (picture.offset, picture.scale) != (mask.offset, mask.scale):
            self._told["map_d is laid as map_Kd is, which has other options"] += 1
        alpha = self._pixels(mask)
        if alpha is None:
            return (None if picture is None else self._texture(picture)), "opaque"
        shown = None if picture is None else self._pixels(picture)
        own = alpha_of(alpha)
        mode = "mask" if np.isin(own, (0, 255)).all() else "blend"
        use = picture if picture is not None and shown is not None else mask
        key = (None if shown is None else use.name, mask.name, use.clamped)
        return self._use(use, key, lambda: with_alpha(shown, own)), mode

    def _texture(self, picture: _Picture) -> TextureUse | None:
        def make() -> NDArray[Any] | None:
            pixels = self._pixels(picture)
            if pixels is None or pixels.dtype != np.uint8:
                return pixels
            if (pixels[..., 3] < 255).any():
                self._told[
                    f"{picture.name} has transparent parts, which no map_d asks for: opaque"
                ] += 1
            return opaque(pixels)

        return self._use(picture, (picture.name, picture.clamped), make)

    def _use(
        self, picture: _Picture, key: object, make: Callable[[], NDArray[Any] | None]
    ) -> TextureUse | None:
        if key not in self._texture_of:
            pixels = make()
            if pixels is None:
                self._texture_of[key] = None
            else:
                self._bytes_left -= pixels.nbytes
                if self._bytes_left < 0:
                    raise Error("its pictures take too much memory for the sizes of their files")
                self.parts.images.append(Image(pixels, name=os.path.basename(picture.name)))
                wrap = "clamp_to_edge" if picture.clamped else "repeat"
                self.parts.textures.append(Texture(len(self.parts.images) - 1, wrap, wrap))
                self._texture_of[key] = len(self.parts.textures) - 1
        texture = self._texture_of[key]
        if texture is None:
            return None
        # OBJ's v grows upwards, ours downwards.
        (u, v), scale = picture.offset, picture.scale
        return TextureUse(texture, offset=(u, 1 - scale[1] - v), scale=scale)

    def _pixels(self, picture: _Picture) -> NDArray[Any] | None:
        file = found_beside(self._folder, picture.name)
        if file is None:
            self._told[f"the picture {picture.name} is missing; its material is seen without"] += 1
            return None
        try:
            if file not in self._counted:
                self._counted.add(file)
                self._bytes_left += 256 * os.path.getsize(file)
            return read_picture(file)
        except Error as error:
            self._told[f"a picture is passed over: {error}"] += 1
            return None


def _is_number(text: str) -> bool:
    try:
        return bool(np.isfinite(float(text)))
    except ValueError:
        return False
