"""Pictures of all that is around, seen by an eye without a ray: each response is the exact mean of
the picture's pixels by the angular sensitivity, a sparse matrix for an eye and the way it is
turned."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from omma._core import Acceptance, Error, Eye
from omma.base.arguments import array_of, checked, expect
from omma.base.arrays import Floats
from omma.base.directions import angle_of_chord
from omma.base.files import PathLike
from omma.base.gpano import expect_whole_sphere
from omma.base.orientation import upright_picture
from omma.base.pixels import check_radiance, warn_of_alpha, warn_of_bytes
from omma.base.poses import as_pose
from omma.base.slips import warn_of_shape
from omma.base.srgb import linear_of_srgb
from omma.rendering.picture_layouts import Equirectangular, Layout, pixels_of

Responses = NDArray[np.float32]

# Pixels are divided until they are so much smaller than the acceptance angle, each part with four
# points by Gauss and Legendre; more where the sensitivity has an edge.
_FINER, _FINER_BY_AN_EDGE = 6, 64
_NODE = 0.5 / np.sqrt(3)
# Of the sensitivity, what may lie beyond the pixels that count.
_BEYOND = 1e-5
_AZIMUTHS = np.linspace(0, 2 * np.pi, 16, endpoint=False)
# Bytes of pictures, and pictures, that a thread sees at once.
_CHUNK_BYTES, _AT_ONCE = 1 << 28, 16
# Of uint8.
_OF_SRGB = linear_of_srgb(np.arange(256) / 255).astype(np.float32)


class PanoramaView:
    """What an eye sees of pictures that are all around it, at infinity.

    The response of ommatidium i is R[i] = Σ_p w[i,p] L[p] / Σ_p w[i,p], with w[i,p] the integral of
    its angular sensitivity over pixel p, each of which has one radiance. Rays, their noise and
    their number have no part in it. An eye that turns needs a view for each way it is turned: many
    ways of few pictures are quicker as rays, of ``omma.World(scene, background=...)``.

    Args:
        eye: whose axes and acceptances count, and whose positions do not.
        layout: of the pictures, `Equirectangular`, `CubeFaces` or `Fisheye`.
        world_from_head: (4, 4) or a rotation (3, 3); its position does not count.
        allow_missing: of an ommatidium's sensitivity, the share that pictures may leave out, as
            beyond a fisheye's rim. Of those that miss more, the responses are NaN.

    Raises:
        omma.Error: an argument is out of its range, or no ommatidium sees enough of the pictures.
        TypeError: an argument is of another type.
    """

    @checked
    def __init__(
        self,
        eye: Eye,
        layout: Layout,
        world_from_head: ArrayLike | None = None,
        *,
        allow_missing: float = 0.5,
    ) -> None:
        expect(eye, Eye, "eye", "omma.load_eye gives one")
        if not 0 <= allow_missing <= 1:
            raise Error(f"allow_missing: expected 0 to 1, found {allow_missing}")
        if not isinstance(layout, Layout):
            raise TypeError(
                "layout: expected Equirectangular, CubeFaces or Fisheye, found "
                f"{type(layout).__name__} (omma.rendering has them)"
            )
        self.layout = layout
        turned = _rotation(world_from_head)
        weights = _weights(eye, layout, turned)
        self.coverage: Floats = np.minimum(np.asarray(weights.sum(axis=1)), 1.0)
        """(N,): the share of each sensitivity that pictures show, from 0 to 1."""
        unseen = self.coverage < max(1 - allow_missing, 1e-6)
        if np.all(unseen):
            raise Error(
                "eye: expected ommatidia that see the picture, found that it shows at most "
                f"{self.coverage.max():.0%} of what any of them sees"
            )
        scale = np.where(unseen, 0.0, 1 / np.maximum(np.asarray(weights.sum(axis=1)), 1e-300))
        self._matrix = csr_array(weights.multiply(scale[:, None]), dtype=np.float32)
        self._unseen = unseen

    def __repr__(self) -> str:
        return f"<omma.rendering.PanoramaView of {self.layout!r}: {len(self.coverage)} ommatidia>"

    @property
    def weights(self) -> csr_array:
        """(N, pixels) float32, the share of each pixel in a response; rows of 0 where it is NaN."""
        return self._matrix

    @checked
    def see(self, pictures: ArrayLike) -> Responses:
        """Responses (N, B) of a picture, or (..., N, B) of several: float32, linear.

        Args:
            pictures: (..., \\*layout.shape, B), linear radiance in any number of bands, floats; or
                uint8, which is sRGB. Every band is light, also the fourth of RGBA: give
                ``pictures[..., :3]`` of such. Pixels that are NaN, not known, make NaN of all that
                see them.

        Raises:
            omma.Error: a shape that is not the layout's, whole numbers of another kind, or pixels
                that are negative or infinite; it names one. Of differences of pictures, and of Q
                and U, ``weights @ pixels`` tells the same.

        Warns:
            UserWarning: floats that look like a picture in 8 bits, with white at 255; uint8 in
                four bands, which look like RGBA.
        """
        given = np.asarray(pictures)
        shape = self.layout.shape
        bands_at = given.ndim - 1 - len(shape)
        if bands_at < 0 or given.shape[bands_at:-1] != shape:
            wanted = ", ".join(map(str, shape))
            raise Error(f"pictures: expected shape (..., {wanted}, bands), found {given.shape}")
        if given.dtype.kind == "f":
            check_radiance(
                given, "pictures", "; PanoramaView.weights @ pixels takes differences, and Q and U"
            )
            warn_of_bytes(given, "pictures")
        warn_of_alpha(given, "pictures")
        several, bands = given.shape[:bands_at], given.shape[-1]
        flat = given.reshape(-1, self._matrix.shape[1], bands)
        seen = np.empty((len(flat), self._matrix.shape[0], bands), np.float32)
        step = int(np.clip(_CHUNK_BYTES // max(flat[:1].size * 4, 1), 1, _AT_ONCE))

        def see_some(first: int) -> None:
            some = linear(flat[first : first + step])
            columns = np.ascontiguousarray(some.transpose(1, 0, 2)).reshape(some.shape[1], -1)
            mixed = (self._matrix @ columns).reshape(-1, len(some), bands)
            seen[first : first + step] = mixed.transpose(1, 0, 2)

        if len(flat) <= step:
            see_some(0)
        else:
            with ThreadPoolExecutor(os.cpu_count()) as threads:
                list(threads.map(see_some, range(0, len(flat), step)))
        seen[:, self._unseen] = np.nan
        return seen.reshape(*several, *seen.shape[1:])

    def see_each(self, pictures: Iterable[ArrayLike]) -> Iterator[Responses]:
        """Responses (N, B) of one picture after the other, as of a film that is read meanwhile."""
        for picture in pictures:
            yield self.see(picture)


@checked
def see_panorama(
    picture: PathLike | ArrayLike,
    eye: Eye,
    world_from_head: ArrayLike | None = None,
    *,
    layout: Layout | None = None,
) -> Responses:
    """What an eye sees of a panorama: (N, B) float32, linear.

    Args:
        picture: PNG, JPEG and WebP, which are sRGB and turned as their EXIF says, Radiance HDR or
            OpenEXR, linear, whose pixels are finite; or an array as `PanoramaView.see` takes
            it, with any number of bands.
            Of files, alpha is left out; of an array of RGBA it would be a band of light.
        eye, world_from_head: as of `PanoramaView`.
        layout: None: equirectangular, as large as the picture, which is then twice as wide as high;
            the caller is warned of another shape.

    Example:
        >>> sky = np.ones((90, 180, 3), np.float32)
        >>> float(omma.rendering.see_panorama(sky, omma.eye.generate_eye(100)).round(3).max())
        1.0

    Raises:
        omma.Error: no such picture, a panorama's file that says by its GPano that it is a part of
            the sphere or not equirectangular, or what `PanoramaView` and its ``see`` raise.

    Warns:
        UserWarning: a picture of another shape, one that ``see`` warns of, or a panorama's file
            that says by its GPano that the camera was turned or tilted.
    """
    if isinstance(picture, (str, os.PathLike)):
        around = layout is None or isinstance(layout, Equirectangular)
        pixels = load_picture(picture, is_panorama=around)
    else:
        pixels = np.asarray(picture)
    if layout is None:
        if pixels.ndim != 3:
            raise Error(f"picture: expected shape (height, width, bands), found {pixels.shape}")
        warn_of_shape(
            pixels.shape,
            "picture",
            "; pad a part of one with NaN, which is not known, and give see_panorama(layout=) an "
            "omma.rendering.Fisheye for a fisheye's",
        )
        layout = Equirectangular(*pixels.shape[:2])
    return PanoramaView(eye, layout, world_from_head).see(pixels)


def load_picture(path: PathLike, *, is_panorama: bool) -> Responses:
    """A picture of a file as linear radiance, (height, width, 3) float32.

    Raises:
        omma.Error: there is no such picture, or one whose pixels are not finite or negative; a
            panorama that its GPano says is a part of the sphere or not equirectangular.
    """
    image = upright_picture(path)
    if is_panorama:
        expect_whole_sphere(path, image)
    colors: Responses = linear(image.pixels)[..., :3]
    check_radiance(colors, os.fsdecode(path))
    return colors


def linear(pixels: NDArray[np.generic]) -> Responses:
    """Pixels as linear float32: uint8 is sRGB, floats are linear already."""
    if pixels.dtype == np.uint8:
        return np.asarray(_OF_SRGB[pixels])
    if pixels.dtype.kind in "biu":
        raise Error(f"pictures: expected uint8 (sRGB) or float (linear), found {pixels.dtype}")
    array: Responses = array_of(pixels, "pictures", dtype=np.float32)
    return array


def _rotation(world_from_head: ArrayLike | None) -> Floats:
    if world_from_head is None:
        return np.eye(3)
    given = array_of(world_from_head, "world_from_head")
    if given.shape == (3, 3):
        whole = np.eye(4)
        whole[:3, :3] = given
        given = whole
    turned: Floats = as_pose(given, "world_from_head")[:3, :3]
    if not np.allclose(turned @ turned.T, np.eye(3), atol=1e-4) or np.linalg.det(turned) < 0:
        raise Error("world_from_head: expected a rotation, found one that stretches or mirrors")
    return turned


def _weights(eye: Eye, layout: Layout, turned: Floats) -> csr_array:
    """The integral of each angular sensitivity, which is 1 in all, over each pixel."""
    middles = pixels_of(layout)
    ways, solid_angle = layout.at(*middles)
    shown = np.flatnonzero(solid_angle > 0)
    tree = cKDTree(ways[shown])
    half = _half_diagonal_rad(layout, [one[shown] for one in middles], ways[shown])
    frame = [np.asarray(one, float) @ turned.T for one in (eye.up, eye.right, eye.axis)]
    known: dict[tuple[int, float], tuple[Acceptance, float, float]] = {}
    rows: list[NDArray[np.int64]] = []
    columns: list[NDArray[np.int64]] = []
    values: list[Floats] = []
    for i in range(len(eye)):
        kind = int(eye.acceptance_of[i]), float(eye.acceptance_angle_rad[i])
        if kind not in known:
            of_kind = eye.acceptance(i)
            known[kind] = of_kind, _reach_rad(of_kind), _part_rad(of_kind)
        acceptance, reach_rad, part_rad = known[kind]
        up, right, axis = (one[i] for one in frame)
        if reach_rad == 0:
            pixel, weight = np.array([tree.query(axis)[1]]), np.ones(1)
        else:
            chord = 2 * np.sin(min(reach_rad + float(half.max()), np.pi) / 2)
            pixel = np.sort(np.asarray(tree.query_ball_point(axis, chord), np.int64))
            beside = np.arccos(np.clip(ways[shown[pixel]] @ axis, -1, 1))
            pixel = pixel[beside < reach_rad + half[pixel]]
            weight = _over_pixels(
                acceptance,
                layout,
                [one[shown[pixel]] for one in middles],
                half[pixel] / part_rad,
                (up, right, axis),
            )
        rows.append(np.full(len(pixel), i))
        columns.append(shown[pixel])
        values.append(weight)
    return csr_array(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
        shape=(len(eye), len(solid_angle)),
    )


def _over_pixels(
    acceptance: Acceptance,
    layout: Layout,
    middles: list[Floats],
    parts: Floats,
    frame: tuple[Floats, Floats, Floats],
) -> Floats:
    """The integral of a sensitivity over pixels (P,), each divided into so many parts a side, or
    the next power of two."""
    counts = np.int64(2 ** np.ceil(np.log2(np.maximum(parts, 1))))
    weights = np.empty(len(counts))
    for count in np.unique(counts):
        some = counts == count
        pieces = [one[some] for one in middles]
        weights[some] = _over_equal_parts(acceptance, layout, pieces, int(count), frame)
    return weights


def _over_equal_parts(
    acceptance: Acceptance,
    layout: Layout,
    middles: list[Floats],
    parts: int,
    frame: tuple[Floats, Floats, Floats],
) -> Floats:
    """The same of pixels that are divided alike: in so many parts a side."""
    face, row, column = middles
    offset = ((np.arange(parts)[:, None] + [0.5 - _NODE, 0.5 + _NODE]) / parts - 0.5).ravel()
    down, along = (one.ravel() for one in np.meshgrid(offset, offset, indexing="ij"))
    ways, solid_angle = layout.at(
        np.repeat(face[:, None], len(down), 1), row[:, None] + down, column[:, None] + along
    )
    up, right, axis = (ways @ one for one in frame)
    theta = np.arctan2(np.hypot(up, right), axis)
    density = acceptance.pdf(theta, np.arctan2(right, up))
    return np.asarray((density * solid_angle).mean(axis=1))


def _half_diagonal_rad(layout: Layout, middles: list[Floats], ways: Floats) -> Floats:
    """The widest angle from the middle of each pixel to a corner of it."""
    face, row, column = middles
    chord = np.zeros(len(face))
    for down in (-0.499, 0.499):
        for along in (-0.499, 0.499):
            corner, solid_angle = layout.at(face, row + down, column + along)
            across = np.linalg.norm(corner - ways, axis=1)
            chord = np.maximum(chord, np.where(solid_angle > 0, across, 0))
    return np.maximum(angle_of_chord(chord), 1e-9)


def _part_rad(acceptance: Acceptance) -> float:
    """Half the diagonal of parts of pixels that are small beside the acceptance angle."""
    narrow = min(acceptance.width_rad(0.0), acceptance.width_rad(np.pi / 2))
    finer = _FINER_BY_AN_EDGE if acceptance.kernel == "pillbox" else _FINER
    return float(narrow / finer / np.sqrt(2))


def _reach_rad(acceptance: Acceptance) -> float:
    """The angle from the axis within which the sensitivity lies; 0 of one that has no width."""
    if acceptance.mean_width_rad == 0:
        return 0.0
    # Finer where it is narrow.
    edges = np.concatenate([[0.0], np.geomspace(acceptance.mean_width_rad / 100, np.pi, 1000)])
    middle = (edges[1:] + edges[:-1]) / 2
    ring = 2 * np.pi * (np.cos(edges[:-1]) - np.cos(edges[1:]))
    azimuths = _AZIMUTHS[:1] if acceptance.is_round else _AZIMUTHS
    density = np.mean([acceptance.pdf(middle, azimuth) for azimuth in azimuths], axis=0)
    within = np.cumsum(density * ring)
    far = np.flatnonzero(within >= (1 - _BEYOND) * within[-1])
    return float(edges[far[0] + 1])
