"""Numbers about an eye: angles between neighbours, acceptance, skew, field, and what looks wrong.

docs/looking-at-eyes.md says what each one means and where it comes from.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, Eye
from omma.base.arguments import checked
from omma.base.arrays import Flags, Floats, Ints
from omma.base.directions import normalized
from omma.base.values import value_class
from omma.eye.field import Field, field_of_view
from omma.eye.neighbours import Neighbours, eye_centre, sides, surface_normals
from omma.eye.outliers import angle_or_nan, outliers, surroundings
from omma.receptors.sensitivity import ommatidium_of_receptor, receptor_optical_sensitivity

_SAME = 1e-6  # of the eye's extent, and radians: what counts as the same position and direction
_FLAT_RAD = np.pi / 3  # between axes: where they are further apart no lattice is flat around one
_WAVELENGTH_NM = 500.0  # of the diffraction limit, where no other is asked for

#: Snyder (1977, J Comp Physiol 116:161): D·Δφ of a diffraction-limited hexagonal eye, times λ.
DIFFRACTION_LIMIT = 0.58


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class EyeMeasures:
    """Numbers about N ommatidia. All arrays are (N,); NaN where a value is not known or there are
    no neighbours. Angles in radians, lengths in metres. See `measure_eye`.

    eye_id: which eye; left 0 and right 1 where one `Eye` is clearly two.
    neighbours, border: how many neighbours in direction, and whether at the border of the field.
    surface_border: whether at the border of the surface, where the ring of neighbours is open; as
        ``border`` where the positions form no surface.
    interommatidial_rad: Δφ, the mean angle to the neighbours in direction: how finely the eye
        samples the world.
    surface_angle_rad: the mean angle between the axes of an ommatidium and of its neighbours on the
        surface, whose facets touch; where the positions form none, as ``interommatidial_rad``. On
        a stretched surface others may look nearer: then it is larger than Δφ.
    smaller_rad, larger_rad: the smaller and the larger surface angle, the half axes of the ellipse
        that the axes of the neighbours on the surface lie on: a regular hexagonal lattice of 1 rad,
        stretched by these two, has the same triangles.
    horizontal_rad, vertical_rad: Δφ in the head's horizontal and vertical direction: a regular
        hexagonal lattice of 1 rad, stretched by these two, has the same triangles.
        These two are NaN where Δφ, the two above where ``surface_angle_rad`` is more than 60°, as
        of a dozen ommatidia all around: no triangles are flat there.
    acceptance_rad, ratio: acceptance angle Δρ, and Δρ/Δφ.
    facet_diameter_m, eye_parameter_m_rad: D where known, and D·Δφ.
    facet_spacing_m: mean distance to the neighbours on the surface.
    skew_head_rad, skew_eye_rad, skew_normal_rad: the angle between the axis and the direction from
        the origin of the head's frame, that from the centre of the eye (the sphere that fits its
        positions best, of which three or fewer have none), the surface's normal.
    sensitivity_m2_sr: Land's optical sensitivity S of the most sensitive receptor, m² sr, where D
        and the rhabdom's length and absorption are known; see `omma.receptors.optical_sensitivity`.
    outlier: what is far from the neighbours': "", or "spacing", "axis" or "position", or several
        with + between; or "double of 17", of which ommatidium it is one.
    duplicate_of: the first ommatidium with the same position and axis, -1 where there is none.
    axis: (N, 3), directions. lattice: neighbours in direction.
    """

    eye_id: NDArray[np.int32]
    neighbours: Ints
    border: Flags
    surface_border: Flags
    interommatidial_rad: Floats
    surface_angle_rad: Floats
    smaller_rad: Floats
    larger_rad: Floats
    horizontal_rad: Floats
    vertical_rad: Floats
    acceptance_rad: Floats
    facet_diameter_m: Floats
    facet_spacing_m: Floats
    skew_head_rad: Floats
    skew_eye_rad: Floats
    skew_normal_rad: Floats
    sensitivity_m2_sr: Floats
    outlier: NDArray[np.str_]
    duplicate_of: Ints
    axis: Floats
    lattice: Neighbours

    def __len__(self) -> int:
        return len(self.eye_id)

    def __repr__(self) -> str:
        eyes = len(np.unique(self.eye_id))
        known = self.interommatidial_rad[np.isfinite(self.interommatidial_rad)]
        spacing = f", median Δφ {np.degrees(np.median(known)):.3g}°" if len(known) else ""
        return f"EyeMeasures({len(self):,} ommatidia, {eyes} eye{'s' * (eyes != 1)}{spacing})"

    @cached_property
    def field(self) -> Field:
        """Solid angles of what is seen, and what is not; takes a second at the first call."""
        return field_of_view(self.axis, self.eye_id, self.lattice, self.cell_rad)

    @cached_property
    def cell_rad(self) -> Floats:
        """How wide an ommatidium's cell of the visual field is: Δφ; without neighbours, Δρ. At most
        four times the Δφ that 19 of 20 of the eye stay below, which the sparse zone of an acute eye
        may have: an axis that stands apart does not fill the hole it stands in."""
        alone = np.isnan(self.interommatidial_rad)
        cell = np.where(alone, self.acceptance_rad, self.interommatidial_rad)
        for which in np.unique(self.eye_id[~alone]):
            mine = self.eye_id == which
            most = 4 * np.percentile(self.interommatidial_rad[mine & ~alone], 95)
            cell[mine] = np.minimum(cell[mine], most)
        return cell

    @cached_property
    def ratio(self) -> Floats:
        """Δρ/Δφ."""
        return np.asarray(self.acceptance_rad / self.interommatidial_rad)

    @cached_property
    def eye_parameter_m_rad(self) -> Floats:
        """D·Δφ, m rad: `DIFFRACTION_LIMIT` times the wavelength at least (Snyder 1977)."""
        return np.asarray(self.facet_diameter_m * self.interommatidial_rad)

    @cached_property
    def sampling_per_rad(self) -> Floats:
        """Sampling frequency 1/(2Δφ), cycles/rad: of the finest grating whose stripes neighbours
        can tell apart."""
        return np.asarray(1 / (2 * self.interommatidial_rad))

    @cached_property
    def hexagonal_sampling_per_rad(self) -> Floats:
        """1/(√3 Δφ), cycles/rad: the Nyquist frequency of the rows of a hexagonal lattice, which
        are √3/2 Δφ apart."""
        return np.asarray(1 / (np.sqrt(3) * self.interommatidial_rad))


@checked
def measure_eye(eye: Eye) -> EyeMeasures:
    """Numbers about an eye, or about all eyes of a head, each with neighbours of its own.

    Outliers are found by a robust rule: for each ommatidium |ln(Δφ / median of the neighbours' Δφ)|
    ("spacing"), the angle between the axis and the mean axis of the neighbours on the surface over
    the median of their surface angles ("axis"), the distance from the mean position of the
    neighbours in direction over the facet spacing ("position"). One is an outlier where that is
    over 8 robust standard deviations (1.4826 times the median absolute deviation) above the eye's
    median, and over ln 2, 1.5 and 1.5, so that a border or a smooth gradient is none. Of an axis
    and a position that do not go together, the one is told that is out of place among its kind.
    Those beside a wrong axis or position are judged without it. One whose axis is far from all
    others, so that it has no neighbours, is an outlier in spacing.

    Doubles, which lie and look less than a fifth as far from another of their eye as others do from
    either, count as one with it: they are named, are nobody's neighbours, and have its neighbours.

    Raises:
        omma.Error: an eye without ommatidia.
    """
    if len(eye) == 0:
        raise Error("eye: expected at least one ommatidium, found none")
    position = eye.position_m.astype(np.float64)
    axis = eye.axis.astype(np.float64)
    axis = normalized(axis)
    eye_id = sides(position, eye.eye_id)
    around = surroundings(position, axis, eye_id)
    directions, surface = around.directions, around.surface
    across = _local_metric(axis, directions)
    ellipse = _local_ellipse(axis, surface)
    flat = np.isnan(ellipse[:, 0])
    if flat.any():
        ellipse[flat] = _local_ellipse(axis, directions)[flat]
    has_surface = np.isfinite(around.on_surface)
    on_surface = np.where(has_surface, around.on_surface, around.spacing)
    across[around.spacing > _FLAT_RAD] = np.nan
    ellipse[on_surface > _FLAT_RAD] = np.nan
    outward = np.zeros_like(position)
    for which in np.unique(eye_id):
        members = eye_id == which
        if members.sum() >= 4:  # three lie on many spheres
            outward[members] = position[members] - eye_centre(position[members])
    duplicate_of = _duplicates(position, axis)
    outlier = outliers(position, axis, eye_id, around)
    for i in np.flatnonzero((around.double_of >= 0) & (duplicate_of < 0)):
        outlier[i] = f"double of {around.double_of[i]}"
    return EyeMeasures(
        eye_id=eye_id,
        neighbours=directions.count(),
        border=directions.border,
        surface_border=np.where(has_surface, surface.border, directions.border),
        interommatidial_rad=around.spacing,
        surface_angle_rad=on_surface,
        smaller_rad=ellipse[:, 0],
        larger_rad=ellipse[:, 1],
        horizontal_rad=np.sqrt(across[:, 0]),
        vertical_rad=np.sqrt(across[:, 1]),
        acceptance_rad=eye.acceptance_angle_rad.astype(np.float64),
        facet_diameter_m=_known(eye.facet_diameter_m),
        facet_spacing_m=around.facet_spacing,
        skew_head_rad=angle_or_nan(position, axis),
        skew_eye_rad=angle_or_nan(outward, axis),
        skew_normal_rad=angle_or_nan(surface_normals(position, surface), axis),
        sensitivity_m2_sr=_sensitivity(eye),
        outlier=outlier,
        duplicate_of=duplicate_of,
        axis=axis,
        lattice=directions,
    )


def diffraction_limit_m_rad(wavelength_nm: float = _WAVELENGTH_NM) -> float:
    """The least D·Δφ, m rad, at which diffraction lets a hexagonal eye resolve what it samples:
    about 0.58 λ (Snyder 1977, J Comp Physiol 116:161)."""
    return DIFFRACTION_LIMIT * wavelength_nm * 1e-9


def _known(lengths: ArrayLike) -> Floats:
    values = np.asarray(lengths, dtype=np.float64)
    return np.where(values > 0, values, np.nan)


def _local_metric(axis: Floats, lattice: Neighbours) -> Floats:
    """Squares of the horizontal and of the vertical interommatidial angle: (N, 2), rad².

    Of a triangle of a hexagonal lattice with sides e, Σ e eᵀ = (3/2) Δφ² 1. Stretching the lattice
    stretches that tensor, so its diagonal has the squares of what is wanted. Whole triangles are
    averaged, as the neighbours of an ommatidium at the border do not lie evenly around it.
    """
    corners = axis[lattice.triangles]
    middle = corners.mean(axis=1)
    level = np.hypot(middle[:, 0], middle[:, 2])
    # Straight up and down no direction is horizontal.
    safe = np.where(level > 1e-6, level, np.nan)
    east = np.column_stack([-middle[:, 2] / safe, np.zeros(len(middle)), middle[:, 0] / safe])
    north = np.cross(east, normalized(middle))
    north *= np.sign(north[:, 1:2])
    edges = corners - np.roll(corners, 1, axis=1)
    along = np.stack([np.einsum("tkc,tc->tk", edges, way) for way in (east, north)], axis=1)
    return np.asarray(lattice.mean_over_triangles((along**2).sum(axis=2) * 2 / 3))


def _local_ellipse(axis: Floats, lattice: Neighbours) -> Floats:
    """The smaller and the larger interommatidial angle: (N, 2), rad. The half axes of the ellipse
    of neighbours are the roots of the eigenvalues across the axis of the tensor of `_local_metric`,
    in three dimensions."""
    corners = axis[lattice.triangles]
    edges = corners - np.roll(corners, 1, axis=1)
    tensor = lattice.mean_over_triangles(np.einsum("tki,tkj->tij", edges, edges) * 2 / 3)
    known = np.isfinite(tensor[:, 0, 0])
    across = np.eye(3) - axis[known, :, None] * axis[known, None, :]
    ellipse = np.full((len(axis), 2), np.nan)
    # Along the axis there is nothing: the least of the three is zero.
    squares = np.linalg.eigvalsh(across @ tensor[known] @ across)[:, 1:]
    ellipse[known] = np.sqrt(np.maximum(squares, 0))
    return ellipse


def _sensitivity(eye: Eye) -> Floats:
    """S of the most sensitive receptor of each ommatidium."""
    most = np.full(len(eye), np.nan)
    np.fmax.at(most, ommatidium_of_receptor(eye), receptor_optical_sensitivity(eye))
    return most


def _duplicates(position: Floats, axis: Floats) -> Ints:
    from scipy.spatial import cKDTree

    extent = float(np.ptp(position, axis=0).max()) or 1.0
    points = np.column_stack([position / extent, axis])
    _, index, inverse = np.unique(points, axis=0, return_index=True, return_inverse=True)
    first = index[inverse.reshape(-1)]
    near = cKDTree(points[index]).query_pairs(_SAME, output_type="ndarray")
    for one, other in np.sort(index[near], axis=1):
        first[first == first[other]] = first[one]
    return np.where(first == np.arange(len(points)), -1, first)
