"""Method of `omma.Renderer`: how responses of a world that is not lit change with the pixels of an
image that surfaces show.

Where on the image a ray ends is read from renders themselves, of the image with its columns, then
its rows, on a circle: pixel k of n has the angle 2π k/n. Bilinear filtering puts a point between
two neighbours on their chord, so that its angle tells both and their weights, round the edge too.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Background, Error, Image, Material, Scene
from omma.base.arguments import array_of, checked
from omma.base.arrays import Floats
from omma.base.methods import method_of
from omma.base.progress import Progress, share_of
from omma.rendering.call import Poses, Prepared, poses_of
from omma.rendering.color_gradients import (
    band_from_rgb_of,
    black,
    check_linear,
    rays_of,
    samples_without_filter,
)
from omma.rendering.settings import frame_number
from omma.scene.world import World
from omma.scene.world_colors import index_of

_BLACK = np.zeros(3)
# Two pixels of a row or a column that each ray (N, S) reads, and the weight of the second.
_Place = tuple[NDArray[np.int64], NDArray[np.int64], Floats]


@checked
@method_of("omma.rendering.renderer", "Renderer")
def image_vjp(
    self: Prepared,
    poses: Poses,
    cotangent: ArrayLike,
    image: int | str,
    *,
    first_pose: int = 0,
    progress: Progress | None = None,
) -> Floats:
    """The gradient of a number by each pixel of an image that surfaces show: (H, W, 3), by linear
    red, green and blue. With a cotangent of 1 for one ommatidium, what it sees of it.

    Responses are linear in the image: their change by a picture D, as of `World.set_image`, times
    the cotangent is the sum of the gradient times D, for the rays of `render` without footprints
    (``footprints=False``), whose pictures they average by more than pixels. Weights of pixels are
    known to some 1e-7 of the width of the image. For each pose and each material that shows the
    image the rays are followed six times, nine times where bands are not red, green and blue.
    Meanwhile nothing else may render this world.

    Args:
        poses: as in `render`.
        cotangent: (P, N, C), the number's gradient by responses.
        image: which, an index in ``scene.images`` or the name of one.
        first_pose: the number of the first pose's frame, where noise is new in every frame.
        progress: called with the finished share (0 to 1).

    Example:
        >>> wall = omma.scene.Material(base_color_texture=0, double_sided=True)
        >>> mesh = omma.scene.Mesh(
        ...     [(-9, -9, -1), (9, -9, -1), (9, 9, -1), (-9, 9, -1)], [(0, 1, 2), (0, 2, 3)],
        ...     texture_coordinates=[(0, 1), (1, 1), (1, 0), (0, 0)], material=0)
        >>> picture = omma.scene.Image(np.ones((8, 16, 3)))
        >>> scene = omma.Scene(meshes=[mesh], materials=[wall], images=[picture],
        ...     textures=[omma.scene.Texture(0)])
        >>> eye = omma.eye.generate_eye(20)
        >>> renderer = omma.Renderer(scene, eye, omma.Fixed(64), footprints=False)
        >>> gradient = renderer.image_vjp(np.eye(4), np.ones((1, 20, 3)), 0)
        >>> gradient.shape, bool(gradient.sum() > 20)
        ((8, 16, 3), True)

    Raises:
        omma.Error: no such image, one that no material shows or whose alpha cuts out or blends, a
            world that is or was lit, or what `background_vjp` raises.
    """
    check_linear(self.world)
    samples = samples_without_filter(self)
    scene = self.world.scene
    index = index_of(image, "image", [one.name for one in scene.images])
    uses = _uses(scene, index)
    matrices = poses_of(self, poses)
    expected = (len(matrices), len(self.eye), self.bands)
    weights = array_of(cotangent, "cotangent", expected, finite=True)
    pixels = scene.images[index].pixels.shape
    size = int(pixels[0]), int(pixels[1])
    factors = [_factor(self.world, use) for use in uses]
    gradient = np.zeros((size[0] * size[1], 3))
    number = frame_number(first_pose) or 0
    renders = len(matrices) * len(uses)
    with _coded(self, index, size) as coded:
        for p in range(len(matrices)):
            for k, (use, factor) in enumerate(zip(uses, factors)):
                done = p * len(uses) + k
                part = share_of(progress, done / renders, (done + 1) / renders)
                met = coded.follow(use, matrices[p : p + 1], number + p, samples, part)
                _spread(gradient, size, met, weights[p], factor / samples)
    return gradient.reshape(*size, 3)


@dataclass(frozen=True)
class _Use:
    """A material that shows the image, in its base colour or in what it gives off."""

    material: int
    shines: bool


@dataclass(frozen=True)
class _Met:
    """What rays (N, S) meet of an image."""

    radiance: Floats  # (3, N, S, C): of an image of 1, by its red, green and blue
    column: _Place
    row: _Place


@dataclass(frozen=True)
class _Coded:
    """A renderer of a black world in which an image is replaced."""

    renderer: Prepared
    world: World
    image: int
    size: tuple[int, int]
    lift: Floats | None

    def follow(
        self, use: _Use, pose: Floats, number: int, samples: int, progress: Progress | None
    ) -> _Met:
        """What the rays of one pose meet of the image where a material uses it."""
        lights = [] if self.lift is None else [*np.eye(3)]
        steps = 6 + len(lights)

        def seen(light: ArrayLike, picture: Floats, step: int) -> Floats:
            self._show(picture)
            self._light(use, light)
            part = share_of(progress, step / steps, (step + 1) / steps)
            return rays_of(self.renderer, pose, number, samples, part)

        rows, columns = self.size
        full, white = np.ones(self.size), np.ones(3)
        dark = seen(_BLACK, full, 0)
        radiance = seen(white, full, 1) - dark
        power = (radiance**2).sum(-1)
        met = power > 0

        def grey(codes: Floats, step: int) -> Floats:
            """What share of white the rays find, (N, S)."""
            found = seen(white, codes, step) - dark
            return np.asarray((found * radiance).sum(-1) / np.where(met, power, 1))

        places = []
        for count, axis in ((columns, 1), (rows, 0)):
            angle = 2 * np.pi * np.arange(count) / max(count, 3)
            codes = (0.5 + 0.5 * of(angle) for of in (np.cos, np.sin))
            shape = (1, count) if axis == 1 else (count, 1)
            x, y = (
                2 * grey(np.broadcast_to(one.reshape(shape), self.size), 2 + 2 * (1 - axis) + k) - 1
                for k, one in enumerate(codes)
            )
            places.append(_between(np.where(met, x, 1), np.where(met, y, 0), count))
        if self.lift is None:
            by_color = np.zeros((3, *radiance.shape))
            for c in range(3):
                by_color[c, ..., c] = radiance[..., c]
        else:
            by_color = np.stack([seen(one, full, 6 + j) - dark for j, one in enumerate(lights)])
        self._light(use, _BLACK)
        return _Met(by_color, places[0], places[1])

    def _show(self, grey: Floats) -> None:
        picture = np.repeat(grey[:, :, None], 3, axis=2).astype(np.float32)
        self.world._engine.set_image(self.image, Image(picture))

    def _light(self, use: _Use, color: ArrayLike) -> None:
        if use.shines:
            self.world.set_color(use.material, _BLACK, emissive=color)
        else:
            self.world.set_color(use.material, color, emissive=_BLACK)


@contextmanager
def _coded(renderer: Prepared, image: int, size: tuple[int, int]) -> Iterator[_Coded]:
    """The renderer's world as long as the image is replaced; all is as it was afterwards."""
    lift = band_from_rgb_of(renderer.world)
    with black(renderer.world) as world:
        changed, _ = world._colors.parts()
        before = changed.get(image, world.scene.images[image])
        dark = renderer.with_world(world.with_background(Background.constant(_BLACK)))
        try:
            yield _Coded(dark, world, image, size, lift)
        finally:
            world._engine.set_image(image, before)


def _uses(scene: Scene, image: int) -> list[_Use]:
    """The materials that show an image."""
    found = [
        _Use(k, shines)
        for k, material in enumerate(scene.materials)
        for shines in (False, True)
        if _shows(scene, material, shines) == image
    ]
    if not found:
        raise Error(
            f"image: expected one that the base colour or the emission of a material shows; {image}"
            " is none of them"
        )
    return found


def _shows(scene: Scene, material: Material, shines: bool) -> int | None:
    use = material.emissive_texture if shines else material.base_color_texture
    return None if use is None else scene.textures[use.texture].image


def _factor(world: World, use: _Use) -> Floats:
    """By what a material multiplies the image, linear RGB."""
    own = world.scene.materials[use.material]
    _, colors = world._colors.parts()
    base, emissive = colors.get(use.material, (np.array(own.base_color[:3]), own.emissive))
    if use.shines:
        return _BLACK if own.unlit else np.asarray(emissive, float)
    return np.asarray(base, float)


def _between(x: Floats, y: Floats, count: int) -> _Place:
    """The two neighbours on whose chord points lie, and the weight of the second."""
    nodes = max(count, 3)  # of two alone the chord would go through the middle
    step = 2 * np.pi / nodes
    angle = np.arctan2(y, x) % (2 * np.pi)
    first = np.minimum((angle / step).astype(np.int64), nodes - 1)
    into = angle - first * step
    before, behind = np.sin(into), np.sin(step - into)
    second, last = (first + 1) % nodes, count - 1
    return np.minimum(first, last), np.minimum(second, last), before / (before + behind)


def _spread(
    gradient: Floats, size: tuple[int, int], met: _Met, cotangent: Floats, factor: Floats
) -> None:
    """Add to pixels (H W, 3) what rays read of them, bilinearly."""
    of_ray = np.einsum("jnsc,nc->jns", met.radiance, cotangent) * factor[:, None, None]
    for column, across in _weighted(met.column):
        for row, down in _weighted(met.row):
            pixel = (row * size[1] + column).ravel()
            for c in range(3):
                told = (of_ray[c] * across * down).ravel()
                gradient[:, c] += np.bincount(pixel, told, size[0] * size[1])


def _weighted(place: _Place) -> Iterator[tuple[NDArray[np.int64], Floats]]:
    first, second, weight = place
    yield first, 1 - weight
    yield second, weight
