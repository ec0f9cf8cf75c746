"""FlyGym's pictures seen with an eye's optics: where a picture of the camera is all there is."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from omma._core import Error
from omma.base.arguments import array_of, checked
from omma.base.arrays import Floats
from omma.mujoco.fly_eyes import (
    DISTORTION,
    FOVY_DEG,
    ZOOM,
    bent_directions,
    camera_directions,
    fly_eye,
    flygym_retina,
)

# How far from its axis an ommatidium listens, in acceptance angles: a Gaussian has 2⁻¹⁶ of its
# height there, and 1.5e-5 of its weight beyond.
_REACH = 2.0


class PictureRetina:
    """What the ommatidia of `FlyRetina` make of a picture, instead of FlyGym's ``Retina``.

    FlyGym takes the mean of each hexagon of pixels. Here every pixel counts by the ommatidium's
    Gaussian in its direction, times the solid angle that the pixel covers; what lies beyond the
    picture does not count. A picture has no more detail than its pixels, and in the middle of
    FlyGym's camera one is 1.1° wide: who has the scene sees it by rays (`FlyRetina`).

    Args:
        ommatidia_id_map: as of `fly_eye`. None: FlyGym's own.
        pale_type_mask: (N,), which ommatidia are pale: 1, 0. None: FlyGym's own.
        fovy_deg, distortion, zoom, acceptance_angle_deg: as of `fly_eye`.

    Raises:
        omma.Error: FlyGym is not installed, where its own are needed; a mask of another length, or
            what `fly_eye` raises.
    """

    @checked
    def __init__(
        self,
        ommatidia_id_map: ArrayLike | None = None,
        pale_type_mask: ArrayLike | None = None,
        *,
        fovy_deg: float = FOVY_DEG,
        distortion: float = DISTORTION,
        zoom: float = ZOOM,
        acceptance_angle_deg: float | None = None,
    ) -> None:
        if ommatidia_id_map is None or pale_type_mask is None:
            own = flygym_retina("PictureRetina without a map and a mask")
            if ommatidia_id_map is None:
                ommatidia_id_map = own.ommatidia_id_map
            if pale_type_mask is None:
                pale_type_mask = own.pale_type_mask
        self._lens = {"fovy_deg": fovy_deg, "distortion": distortion, "zoom": zoom}
        self.eye = fly_eye(
            ommatidia_id_map, **self._lens, acceptance_angle_deg=acceptance_angle_deg
        )
        self.pale = array_of(pale_type_mask, "pale_type_mask", (len(self.eye),)) != 0
        self._shape = np.shape(ommatidia_id_map)

    @checked
    def raw_image_to_hex_pxls(self, raw_img: ArrayLike) -> Floats:
        """Readouts (N, 2), 0 to 1, of a picture behind the fisheye lens: yellow ommatidia (green)
        in channel 0, pale ones (blue) in channel 1, the other 0.

        Args:
            raw_img: (H, W, 3), 0 to 255, as large as the map; ``Retina.correct_fisheye`` makes one
                of the camera's.

        Raises:
            omma.Error: another shape, numbers out of that range.
        """
        return self._readouts(self._bent, raw_img)

    @checked
    def fisheye_image_to_hex_pxls(self, raw_img: ArrayLike) -> Floats:
        """Readouts as of `raw_image_to_hex_pxls` of the camera's picture itself, which a lens need
        not bend first.

        Args:
            raw_img: (H, W, 3), 0 to 255, as large as the map.

        Raises:
            omma.Error: another shape, numbers out of that range.
        """
        return self._readouts(self._straight, raw_img)

    def _readouts(self, weights: csr_array, raw_img: ArrayLike) -> Floats:
        picture = array_of(raw_img, "raw_img", (*self._shape, 3))
        if not ((picture >= 0) & (picture <= 255)).all():
            raise Error("raw_img: expected numbers from 0 to 255")
        found: Floats = weights @ picture[:, :, 1:].reshape(-1, 2) / 255
        found[self.pale, 0] = found[~self.pale, 1] = 0
        return found

    @cached_property
    def _straight(self) -> csr_array:
        return self._weights(lambda row, column: self._camera(row + 0.5, column + 0.5))

    @cached_property
    def _bent(self) -> csr_array:
        return self._weights(
            lambda row, column: bent_directions(row, column, self._shape, **self._lens)
        )

    def _camera(self, row: Floats, column: Floats) -> Floats:
        return camera_directions(row, column, self._shape, fovy_deg=self._lens["fovy_deg"])

    def _weights(self, looking: Callable[[Floats, Floats], Floats]) -> csr_array:
        """(N, pixels): by how much each pixel counts; rows sum to 1."""
        row, column = np.mgrid[: self._shape[0], : self._shape[1]].astype(float)
        direction = looking(row, column)
        down = looking(row + 0.5, column) - looking(row - 0.5, column)
        right = looking(row, column + 0.5) - looking(row, column - 0.5)
        solid_angle = np.linalg.norm(np.cross(down, right), axis=-1)
        # Beyond the camera's picture FlyGym's lens shows black, which is no light that was seen.
        corner = -self._camera(np.zeros(1), np.zeros(1))[0]
        edge = np.abs(corner[:2] / corner[2])
        with np.errstate(invalid="ignore"):
            seen = (np.abs(direction[..., :2]) <= edge * -direction[..., 2:]).all(axis=-1)
        seen &= np.isfinite(solid_angle)
        pixels = np.flatnonzero(seen)
        direction, solid_angle = direction[seen], solid_angle[seen]
        axis, width = self.eye.axis.astype(float), self.eye.acceptance_angle_rad.astype(float)
        near = cKDTree(direction).query_ball_point(axis, 2 * np.sin(_REACH * width / 2))
        counts = np.array([len(one) for one in near])
        who, which = np.repeat(np.arange(len(axis)), counts), np.concatenate(near).astype(int)
        angle = 2 * np.arcsin(np.linalg.norm(direction[which] - axis[who], axis=1) / 2)
        weight = np.exp(-4 * np.log(2) * (angle / width[who]) ** 2) * solid_angle[which]
        weight /= np.bincount(who, weight, len(axis))[who]
        size = (len(axis), seen.size)
        return csr_array((weight, (who, pixels[which])), shape=size)
