"""What a world is lit by: a sky and discs far away, in bands and in absolute units, as a value."""

from __future__ import annotations

import functools
import inspect
import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of, checked, expect
from omma.base.arrays import Floats
from omma.base.directions import azimuth_elevation_deg_of
from omma.base.notebook import html_table
from omma.base.values import value_class
from omma.light import sky_map
from omma.light.bands import Bands
from omma.light.cloud_shadow import CloudShadow
from omma.light.discs import Disc, directions_of, strengths
from omma.light.units import Unit, check_unit

F = TypeVar("F", bound=Callable[..., Any])

# A maker's name and its arguments.
Recipe = tuple[str, dict[str, Any]]

# Of the brightest of a light: what is much weaker is 0 in single precision.
LEAST_RADIANCE = 1e-30
_MOST_EXTINCTION_PER_M = 1000.0
# So that rounding stays far below what is looked at.
MOST_AZIMUTH_DEG = 1e6
# Letters of a repr for how a light was made.
_LONGEST = 120


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Light:
    """What a world is lit by: a sky and discs far away, in bands and in absolute units.

    Made by `uniform_sky`, `clear_sky` and others; here are the numbers themselves. Spectral
    radiance is in photons m⁻² s⁻¹ sr⁻¹ nm⁻¹ or in W m⁻² sr⁻¹ nm⁻¹. docs/light.md has a drawing of
    how Stokes vectors are meant.

    bands: wavelengths of its bands.
    unit: "photons" or "watts".
    sky: (2, rows, columns, components, channels), radiance above and below the horizon, rows from
        the horizon (row 0) to the zenith and to the nadir, columns from -Z to the right; one
        component I, or three I, Q, U. None: dark.
    band_from_channel: (B, channels), as of a panorama in RGB. None: channels are the bands.
    discs: the sun, the moon.
    extinction_per_m: (B,), of the air between surfaces (`with_air`). None: it is clear.
    cloud_shadow: of clouds, on what discs shine on (`clouded`). None: there is none.
    recipe: the name and the arguments of what made it, which is what a pickle holds. None: of
        numbers, which a pickle then holds.

    Raises:
        omma.Error: shapes that do not go together, numbers that are negative or not finite, light
            that is below 1e-30 everywhere and not 0.
    """

    bands: Bands
    unit: Unit = "photons"
    sky: NDArray[np.float32] | None = None
    band_from_channel: Floats | None = None
    discs: tuple[Disc, ...] = ()
    extinction_per_m: Floats | None = None
    cloud_shadow: CloudShadow | None = None
    recipe: Recipe | None = None
    # What `turned` turned, and by how many degrees. No field: what `replace` changes has none.
    _turned_from: ClassVar[tuple[Light, float] | None] = None

    def __post_init__(self) -> None:
        expect(self.bands, Bands, "bands", "omma.light.Bands.equal gives some")
        check_unit(self.unit)
        matrix = self.band_from_channel
        if matrix is not None:
            matrix = strengths(matrix, "band_from_channel", (len(self.bands), None))
        if self.sky is not None:
            object.__setattr__(self, "sky", sky_map.checked_sky(self.sky, len(self.bands), matrix))
        elif matrix is not None:
            raise Error("band_from_channel: goes with a sky, found none")
        discs = tuple(self.discs)
        for k, disc in enumerate(discs):
            expect(disc, Disc, f"discs[{k}]", "omma.light.Disc makes one")
            if len(disc.radiance) != len(self.bands):
                raise Error(
                    f"discs[{k}]: expected radiance in {len(self.bands)} bands, found "
                    f"{len(disc.radiance)}"
                )
        check_not_lost(
            [*(one.radiance for one in discs), *([] if self.sky is None else [self.sky])], "light"
        )
        air = self.extinction_per_m
        if air is not None:
            air = strengths(air, "extinction_per_m", (len(self.bands),))
            if np.any(air > _MOST_EXTINCTION_PER_M):
                raise Error(f"extinction_per_m: expected at most 1000 per m, found {air.max():g}")
        if self.cloud_shadow is not None:
            expect(self.cloud_shadow, CloudShadow, "cloud_shadow", "clouded makes one")
        object.__setattr__(self, "extinction_per_m", air)
        object.__setattr__(self, "band_from_channel", matrix)
        object.__setattr__(self, "discs", discs)

    def __repr__(self) -> str:
        return f"Light({self._made_by()}, {self.bands!r}, {self.unit})"

    def _repr_html_(self) -> str:
        unit = f"{self.unit} m⁻² s⁻¹" if self.unit == "photons" else "W m⁻²"
        total = [float(one @ self.bands.widths_nm) for one in self.irradiance()]
        rows = {
            "made by": self._made_by(),
            "bands": repr(self.bands),
            "unit": f"{self.unit} m⁻² s⁻¹ sr⁻¹ nm⁻¹" if self.unit == "photons" else
                    "watts m⁻² sr⁻¹ nm⁻¹",
            "sky": "none" if self.sky is None else f"{self.sky.shape[1]} x {self.sky.shape[2]} "
                   f"directions in each half{', polarised' if self.sky.shape[3] == 3 else ''}",
        }  # fmt: skip
        for k, disc in enumerate(self.discs):
            azimuth, elevation = azimuth_elevation_deg_of(disc.direction)
            rows["disc" if k == 0 else f"disc {k + 1}"] = (
                f"at azimuth {azimuth:.4g}°, elevation {elevation:.4g}°, "
                f"{2 * np.degrees(disc.angular_radius_rad):.3g}° across"
            )
        if self.extinction_per_m is not None:
            thin, thick = np.sort(self.extinction_per_m)[[0, -1]]
            rows["air"] = f"extinction {thin:.3g} to {thick:.3g} m⁻¹ by band"
        if self.cloud_shadow is not None:
            rows["clouds' shadows"] = f"from a layer at {self.cloud_shadow.height_m:g} m"
        rows["on level ground"] = f"{total[0]:.3g} {unit} from the sky, {total[1]:.3g} from discs"
        return html_table("omma.light.Light", rows)

    def __reduce__(self) -> tuple[Callable[..., Light], tuple[Any, ...]]:
        if self.recipe is not None:
            return _made, self.recipe
        if self._turned_from is not None:
            return Light.turned, self._turned_from
        own = {one.name: getattr(self, one.name) for one in fields(self)}
        return _of_fields, (own,)

    def radiance(self, direction: ArrayLike) -> Floats:
        """Stokes vectors of sky and discs in directions (..., 3): (..., 3, B).

        I, Q, U; the reference axis points up. Between nodes of the sky linear, as in rendering.
        Where clouds cast shadows, discs are as the world's origin gets them.

        Raises:
            omma.Error: directions that are zero or not finite.
        """
        towards = directions_of(direction)
        found = np.zeros((*towards.shape[:-1], 3, len(self.bands)))
        if self.sky is not None:
            seen = self._in_bands(sky_map.look_up(self.sky, towards))
            found[..., : seen.shape[-2], :] = seen
        self._add_discs(towards, found, slice(None))
        return found

    def _radiance_of(self, direction: ArrayLike, bands: list[int]) -> Floats:
        """As `radiance`, of some bands alone: (..., 3, len(bands))."""
        towards = directions_of(direction)
        found = np.zeros((*towards.shape[:-1], 3, len(bands)))
        if self.sky is not None:
            matrix = self.band_from_channel
            if matrix is None:
                seen = sky_map.look_up(self.sky[..., bands], towards)
            else:
                seen = sky_map.look_up(self.sky, towards) @ matrix[bands].T
            found[..., : seen.shape[-2], :] = seen
        self._add_discs(towards, found, bands)
        return found

    def irradiance(self, normal: ArrayLike = (0, 1, 0)) -> tuple[Floats, Floats]:
        """What falls on an unshaded surface from the sky and from the discs, each (B,).

        Discs count where their centre is above the surface's horizon, and as the world's origin
        gets them where clouds cast shadows.

        Args:
            normal: (3,) of the surface; by default it lies on its back.

        Example:
            >>> sky, discs = omma.light.uniform_sky(1.0).irradiance()
            >>> float(sky[0] / np.pi).__round__(4), float(discs[0])
            (1.0, 0.0)

        Raises:
            omma.Error: a normal that is zero or not finite.
        """
        facing = directions_of(array_of(normal, "normal", (3,)), "normal")
        sky = np.zeros(len(self.bands))
        if self.sky is not None:
            sky = self._in_bands(sky_map.irradiance(self.sky, facing))
        discs = np.zeros(len(self.bands))
        for disc in self.discs:
            cosine = max(float(disc.direction @ facing), 0.0)
            discs = discs + disc.irradiance() * (self._open(disc) * cosine)
        return sky, discs

    @checked
    def turned(self, azimuth_deg: float) -> Light:
        """The same light turned to the right, seen from above: a sun in the north goes east.

        A sky is looked up between its nodes, which softens it a little, unless it goes on by whole
        steps between nodes: by halves of a pixel of a panorama. Turned several times running it is
        softened once.

        Raises:
            omma.Error: a light whose clouds cast shadows.
        """
        if self.cloud_shadow is not None:
            raise Error(
                "light: clouds that cast shadows cannot be turned; turn the light, then give it "
                "clouds by clouded"
            )
        turn = float(np.radians(azimuth_deg))
        if not abs(azimuth_deg) <= MOST_AZIMUTH_DEG:
            raise Error(f"azimuth_deg: expected -1e6 to 1e6, found {azimuth_deg}")
        if self._turned_from is not None:
            origin, before_deg = self._turned_from
            return origin.turned(math.remainder(before_deg + azimuth_deg, 360))
        c, s = np.cos(turn), np.sin(turn)
        to_the_right = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
        discs = tuple(replace(one, direction=to_the_right @ one.direction) for one in self.discs)
        sky = None if self.sky is None else sky_map.turned(self.sky, turn)
        recipe = self._changed("turned", azimuth_deg=azimuth_deg)
        made = replace(self, sky=sky, discs=discs, recipe=recipe)
        object.__setattr__(made, "_turned_from", (self, azimuth_deg))
        return made

    @checked
    def scaled(self, factor: float) -> Light:
        """The same light ``factor`` times as strong, 0 or 1e-30 to 1e30."""
        if factor != 0 and not LEAST_RADIANCE <= factor <= 1 / LEAST_RADIANCE:
            raise Error(f"factor: expected 0, or 1e-30 to 1e30, found {factor}")
        sky = None if self.sky is None else np.float32(factor) * self.sky
        discs = tuple(replace(one, radiance=factor * one.radiance) for one in self.discs)
        recipe = self._changed("scaled", factor=factor)
        return replace(self, sky=sky, discs=discs, recipe=recipe)

    @checked
    def plus(self, other: Light) -> Light:
        """Both lights at once, which is ``light + other``: radiances and Stokes vectors add.

        Discs at one place, of one size and limb, become one. Maps of different grids are added on
        the finer one, between nodes linear. ``0.3 * clear + 0.7 * overcast`` is a mixture: a
        number times a light is `scaled`.

        Example:
            >>> both = 0.5 * omma.light.uniform_sky(1.0) + omma.light.uniform_sky(2.0, below=0)
            >>> both.radiance([(0, 1, 0), (0, -1, 0)])[:, 0, 0].tolist()
            [2.5, 0.5]

        Raises:
            omma.Error: other bands, another unit, other air, or a sky above water and one below.
        """
        if self.bands != other.bands:
            raise Error(f"other: expected light in the same bands, found {other.bands!r:.80}")
        if self.unit != other.unit:
            raise Error(f"other: expected light in {self.unit}, found {other.unit}")
        airs = [one.extinction_per_m for one in (self, other) if one.extinction_per_m is not None]
        if len(airs) == 2 and not np.array_equal(airs[0], airs[1]):
            raise Error("other: expected light in the same air, found other extinction_per_m")
        shadows = [one.cloud_shadow for one in (self, other) if one.cloud_shadow is not None]
        if len(shadows) == 2 and shadows[0] != shadows[1]:
            raise Error("other: expected light below the same clouds, found another cloud_shadow")
        wet = [is_under_water(one) for one in (self, other) if one.sky is not None]
        if len(set(wet)) == 2:
            raise Error(
                "other: expected light under water too, or none, found a sky above it: add skies "
                "first, then under_water"
            )
        skies = [one._sky_in_bands() for one in (self, other) if one.sky is not None]
        recipe = None if other.recipe is None else self._changed("plus", other=other)
        return Light(
            self.bands,
            self.unit,
            skies[0] if len(skies) == 1 else sky_map.added(*skies) if skies else None,
            discs=_joined([*self.discs, *other.discs]),
            extinction_per_m=airs[0] if airs else None,
            cloud_shadow=shadows[0] if shadows else None,
            recipe=recipe,
        )

    def __add__(self, other: Light) -> Light:
        return self.plus(other) if isinstance(other, Light) else NotImplemented

    def __mul__(self, factor: float) -> Light:
        is_number = isinstance(factor, (int, float, np.number))
        return self.scaled(float(factor)) if is_number else NotImplemented

    __rmul__ = __mul__
    __array_ufunc__ = None  # so that numbers of NumPy leave a product to it

    @checked
    def in_bands(self, bands: Bands) -> Light:
        """The same light in other bands, made anew.

        Raises:
            omma.Error: it was made of numbers, which say nothing of other bands.
        """
        if self.recipe is None:
            raise Error(
                "light: expected one with a recipe, such as clear_sky, found one of numbers"
            )
        name, arguments = self.recipe
        if "light" not in arguments:
            return _made(name, {**arguments, "bands": bands})
        anew = {
            key: one.in_bands(bands) if isinstance(one, Light) else one
            for key, one in arguments.items()
        }
        return _made(name, anew)

    def _made_by(self) -> str:
        if self.recipe is None:
            sky = "no sky" if self.sky is None else f"sky {self.sky.shape[1]} x {self.sky.shape[2]}"
            return f"{sky}, {len(self.discs)} disc{'s' if len(self.discs) != 1 else ''}"
        name, arguments = self.recipe
        own = [f"{k}={v!r:.60}" for k, v in arguments.items() if k not in ("bands", "unit")]
        made = f"{name}({', '.join(own)})"
        return made if len(made) <= _LONGEST else made[: _LONGEST - 4] + "...)"

    def _add_discs(self, towards: Floats, found: Floats, bands: list[int] | slice) -> None:
        for disc in self.discs:
            found[..., 0, :] += self._open(disc) * disc.radiance_at(towards)[..., bands]

    def _open(self, disc: Disc) -> float:
        """How much of a disc clouds leave at the world's origin."""
        shadow = self.cloud_shadow
        return 1.0 if shadow is None else float(shadow.transmittance((0, 0, 0), disc.direction))

    def _sky_in_bands(self) -> NDArray[np.float32]:
        sky, matrix = cast(NDArray[np.float32], self.sky), self.band_from_channel
        return sky if matrix is None else sky @ matrix.T.astype(np.float32)

    def _in_bands(self, channels: Floats) -> Floats:
        return channels if self.band_from_channel is None else channels @ self.band_from_channel.T

    def _changed(self, name: str, **arguments: Any) -> Recipe | None:
        return None if self.recipe is None else (name, {"light": self, **arguments})

    def _for_engine(self) -> dict[str, Any]:
        """The arguments of the engine's own Light."""
        zero = np.zeros(len(self.bands))
        return {
            "wavelength_nm": self.bands.wavelength_nm,
            "weight": self.bands.weight,
            "cell_nm": self.bands.cell_nm,
            "unit": self.unit,
            "sky": self.sky,
            "band_from_channel": self.band_from_channel,
            "discs": [
                (
                    one.direction,
                    one.angular_radius_rad,
                    one.radiance,
                    zero if one.limb_darkening is None else one.limb_darkening,
                )
                for one in self.discs
            ],
            "extinction_per_m": self.extinction_per_m,
            "cloud_shadow": self.cloud_shadow and self.cloud_shadow._for_engine(),
            "ultraviolet": None,
            "bottomless": is_under_water(self),
        }


def is_made_by(light: Light, *names: str) -> bool:
    """Whether a light, or one that it was made of, was made by a function of one of these names."""
    if light.recipe is None:
        return False
    name, arguments = light.recipe
    parts = (one for one in arguments.values() if isinstance(one, Light))
    return name in names or any(is_made_by(one, *names) for one in parts)


def is_under_water(light: Light) -> bool:
    return is_made_by(light, "under_water")


def makes_light(function: F) -> F:
    """The same function, whose light remembers how it was made."""
    signature = inspect.signature(function)

    @functools.wraps(function)
    def maker(*arguments: Any, **named: Any) -> Light:
        given = dict(signature.bind(*arguments, **named).arguments)
        made: Light = function(*arguments, **named)
        return replace(made, recipe=(function.__name__, given))

    return cast(F, maker)


def _made(name: str, arguments: dict[str, Any]) -> Light:
    # By its public name, as a pickle would look for it: the makers' modules import this one.
    from omma import light as makers

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # they were given when the light was made
        if "light" in arguments and hasattr(Light, name):
            rest = {key: value for key, value in arguments.items() if key != "light"}
            return getattr(arguments["light"], name)(**rest)  # type: ignore[no-any-return]
        return getattr(makers, name)(**arguments)  # type: ignore[no-any-return]


def _joined(discs: list[Disc]) -> tuple[Disc, ...]:
    """The same discs, those that differ in radiance alone as one."""
    found: list[Disc] = []
    for disc in discs:
        for k, one in enumerate(found):
            if replace(one, radiance=disc.radiance) == disc:
                found[k] = replace(one, radiance=one.radiance + disc.radiance)
                break
        else:
            found.append(disc)
    return tuple(found)


def _of_fields(own: dict[str, Any]) -> Light:
    return Light(**own)


def check_not_lost(radiances: Sequence[NDArray[Any]], name: str) -> None:
    """Refuses light that is there and would be darkness in single precision."""
    brightest = max((float(one.max(initial=0)) for one in radiances), default=0.0)
    if 0 < brightest < LEAST_RADIANCE:
        raise Error(f"{name}: expected radiance of at least 1e-30 somewhere, found {brightest:g}")
