"""What photoreceptors tell each column of the medulla: R1-6 by way of the lamina's cartridges, R7
and R8 of its own facet; from a world, in one call."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, Eye, ReceptorType, Scene
from omma.base.arguments import checked, expect
from omma.base.arrays import Floats32, Ints
from omma.base.directions import azimuth_elevation_deg_of
from omma.base.values import value_class
from omma.columns.cartridges import cartridge_wiring
from omma.columns.coordinates import hex_from_pq
from omma.columns.fly import fly_columns
from omma.columns.lattice import Columns, expect_columns
from omma.columns.names import find_columns, malecns_names
from omma.eye.superposition import Wiring, pool
from omma.receptors.mosaic import COLUMN
from omma.rendering.dataset import load_xarray
from omma.rendering.renderer import Renderer
from omma.rendering.settings import Fixed, Sampling
from omma.scene.world import World
from omma.species.measured import measured_drosophila

if TYPE_CHECKING:
    import xarray


_SAMPLING = Fixed(16)
_RELATIVE = "of the receptor's sensitivity; white light of radiance 1 gives 1 over all wavelengths"


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class PhotoreceptorTable:
    """What the photoreceptors of M columns answer at P poses.

    Attributes:
        columns: which they are.
        kind: (M,) texts, "pale", "yellow", "yellow, dorsal" or "dorsal rim": of R7 and R8.
        r1_6: (P, M), mean of the receptors R1 to R6 that meet in the column's cartridge; NaN where
            there is none, at the rim of the eye.
        r7, r8: (P, M), of the column's own facet.
        in_cartridge: (M,), how many receptors R1 to R6 there are in the cartridge.
    """

    columns: Columns
    kind: NDArray[Any]
    r1_6: Floats32
    r7: Floats32
    r8: Floats32
    in_cartridge: Ints

    def of(self, names: Sequence[str] | Sequence[tuple[str, int, int]]) -> PhotoreceptorTable:
        """That of the columns of these names, in their order, as `find_columns` takes them."""
        k = find_columns(self.columns, names)
        return PhotoreceptorTable(
            self.columns.chosen(k), self.kind[k], self.r1_6[:, k],
            self.r7[:, k], self.r8[:, k], self.in_cartridge[k],
        )  # fmt: skip

    def dataset(self) -> xarray.Dataset:
        """As an `xarray.Dataset`: R1_6, R7 and R8 by pose and by column, whose coordinate is its
        name in MaleCNS, with side, p, q, hex1, hex2, kind, azimuth and elevation (degrees), and
        in_cartridge; its ``to_dataframe`` gives pandas' table.

        Raises:
            omma.Error: no xarray (``omma[data]``).
        """
        columns = self.columns
        hex1, hex2 = hex_from_pq(columns.p, columns.q)
        azimuth, elevation = azimuth_elevation_deg_of(columns.axis)
        degrees = {"units": "degree"}
        coordinates = {
            "column": ("column", malecns_names(columns)),
            "side": ("column", np.where(columns.side > 0, "right", "left")),
            **{name: ("column", values) for name, values in
               (("p", columns.p), ("q", columns.q), ("hex1", hex1), ("hex2", hex2))},
            "kind": ("column", list(self.kind)),
            "in_cartridge": ("column", self.in_cartridge),
            "azimuth": ("column", azimuth, degrees),
            "elevation": ("column", elevation, degrees),
        }  # fmt: skip
        about = {"units": "1", "long_name": _RELATIVE}
        values = {"R1_6": self.r1_6, "R7": self.r7, "R8": self.r8}
        data: xarray.Dataset = load_xarray().Dataset(
            {name: (("pose", "column"), array, about) for name, array in values.items()},
            coordinates,
        )
        return data


class ColumnRenderer:
    """A world seen by the photoreceptors of columns, ready to render frame after frame.

    R1 to R6 of a cartridge sit in the facets around the column's own and look along its axis; each
    has its rays, from where its facet is. R7 and R8 share those of their own facet.

    Args:
        world: a `World`, or a scene, of which one is made.
        fly: an eye whose ommatidia are columns, each with a receptor "R1-6" (or R1 to R6), one
            whose name begins with "R7" and one with "R8"; None: `omma.species.measured_drosophila`.
        columns: (M,), the column of each of its ommatidia; None: `fly_columns`.
        sampling: as of `omma.Renderer`, for each receptor R1 to R6 and each facet.
        equator: as of `cartridge_wiring`.
        options: as of `omma.Renderer`.

    Example:
        >>> white = omma.Scene(background=omma.Background.constant((1, 1, 1)))
        >>> renderer = omma.columns.ColumnRenderer(white, sampling=omma.Fixed(1))
        >>> table = renderer.render(np.eye(4))
        >>> table.r7.shape
        (1, 1696)

    Raises:
        omma.Error: an eye without these receptors, not a column for each ommatidium, what
            `omma.Renderer` raises.
    """

    @checked
    def __init__(
        self,
        world: World | Scene,
        fly: Eye | None = None,
        columns: Columns | None = None,
        *,
        sampling: Sampling = _SAMPLING,
        equator: int = 0,
        **options: Any,
    ) -> None:
        eye = measured_drosophila().eye if fly is None else fly
        expect(eye, Eye, "fly", "omma.species.measured_drosophila().eye is one")
        self.columns = fly_columns() if columns is None else columns
        expect_columns(self.columns)
        if len(eye) != len(self.columns):
            raise Error(
                f"columns: expected one for each of {len(eye)} ommatidia, found {len(self.columns)}"
            )
        self.kind = np.array(list(eye.columns.get(COLUMN, [""] * len(eye))))
        self.wiring, _ = cartridge_wiring(self.columns, equator)
        # Of what is rendered for R1 to R6, which comes in the order of the cartridges.
        index = np.arange(len(self.wiring.index))
        self._pooled = Wiring(self.wiring.first, index, self.wiring.weight, len(index))
        self.renderer = Renderer(world, _with_cartridges(eye, self.wiring), sampling, **options)

    def __repr__(self) -> str:
        return f"ColumnRenderer({len(self.columns)} columns, {self.renderer!r:.150})"

    @checked
    def render(
        self, poses: ArrayLike, *, ultraviolet: ArrayLike | None = None, **moves: Any
    ) -> PhotoreceptorTable:
        """What the photoreceptors answer.

        Args:
            poses: (P, 4, 4), or one (4, 4), as of `omma.Renderer.render`.
            ultraviolet: as of `omma.Renderer.render_receptors`: without it R7, and R8 of the
                dorsal rim, see next to nothing of worlds in red, green and blue.
            moves: instances, transforms, times_s and animation, as there.

        Raises:
            omma.Error: what `omma.Renderer.render_receptors` raises.
        """
        found = self.renderer.render_receptors(poses, ultraviolet=ultraviolet, **moves)
        count = len(self.columns)
        return PhotoreceptorTable(
            self.columns,
            self.kind,
            pool(found[:, 2 * count :], self._pooled, axis=1),
            found[:, 0 : 2 * count : 2],
            found[:, 1 : 2 * count : 2],
            self.wiring.members,
        )


@checked
def photoreceptor_table(
    world: World | Scene,
    poses: ArrayLike,
    *,
    fly: Eye | None = None,
    columns: Columns | None = None,
    sampling: Sampling = _SAMPLING,
    ultraviolet: ArrayLike | None = None,
    **options: Any,
) -> PhotoreceptorTable:
    """What R1-6, R7 and R8 of every column of a fly tell the brain of a world, in one call.

    Who renders many times keeps a `ColumnRenderer`, which this makes.

    Args:
        poses, ultraviolet: as of `ColumnRenderer.render`.
        fly, columns, sampling, options: as of `ColumnRenderer`.

    Example:
        >>> sky = omma.Background.constant((0.2, 0.4, 0.8))
        >>> table = omma.columns.photoreceptor_table(
        ...     omma.Scene(background=sky), np.eye(4), sampling=omma.Fixed(1)
        ... )
        >>> table.of(["ME_R_col_18_19", ("left", 0, 0)]).r1_6.shape
        (1, 2)

    Raises:
        omma.Error: as of `ColumnRenderer`.
    """
    renderer = ColumnRenderer(world, fly, columns, sampling=sampling, **options)
    return renderer.render(poses, ultraviolet=ultraviolet)


def _with_cartridges(eye: Eye, wiring: Wiring) -> Eye:
    """The fly's ommatidia with R7 and R8, and behind them one for each receptor R1 to R6 of a
    cartridge: at the facet that it sits in, along the axis of the column that it sees for."""
    count = len(eye)
    names = [one.name for one in eye.receptor_types]
    of_all = [
        eye.receptor_type[eye.first_receptor[k] : eye.first_receptor[k + 1]].tolist()
        for k in range(count)
    ]
    types = list(eye.receptor_types)
    straight: dict[int, int] = {}

    def one_called(k: int, *beginnings: str) -> int:
        for number in of_all[k]:
            if names[number].startswith(beginnings):
                return int(number)
        raise Error(
            f"fly: expected receptors R1-6, R7 and R8 in each ommatidium, found "
            f"{', '.join(names[number] for number in of_all[k]) or 'none'} in ommatidium {k}"
        )

    def ahead(number: int) -> int:
        if number not in straight:
            straight[number] = len(types)
            types.append(_without_offset(types[number]))
        return straight[number]

    inner = [[one_called(k, "R7"), one_called(k, "R8")] for k in range(count)]
    outer = [ahead(one_called(k, "R1")) for k in range(count)]
    of_column = np.repeat(np.arange(count), wiring.members)
    which = np.concatenate([np.arange(count), wiring.index])
    looks = np.concatenate([np.arange(count), of_column])
    return eye.take(which).replace(
        axis=eye.axis[looks],
        up=eye.up[looks],
        receptor_types=types,
        receptors=inner + [[outer[k]] for k in wiring.index.tolist()],
    )


def _without_offset(kind: ReceptorType) -> ReceptorType:
    pigment = kind.peak_wavelength_nm != 0
    return ReceptorType(
        "R1-6",
        peak_wavelength_nm=kind.peak_wavelength_nm,
        wavelength_nm=None if pigment else kind.wavelength_nm,
        sensitivity=None if pigment else kind.sensitivity,
        absorption_per_m=kind.absorption_per_m,
        length_m=kind.length_m,
    )
