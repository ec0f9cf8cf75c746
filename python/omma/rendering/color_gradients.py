"""Methods of `omma.Renderer`: how responses of a world that is not lit change with its colours.

Radiance along a ray is there a sum of the colours of surfaces and of what is behind them, each
times what no colour changes (textures, opacity), so that derivatives are renders of the change: of
one colour alone, all else black, by the same rays. They are exact but for rounding.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Background, Error
from omma.base.arguments import array_of, checked, whole
from omma.base.arrays import Floats
from omma.base.methods import method_of
from omma.base.progress import Progress, share_of
from omma.rendering.call import Call, Poses, Prepared, Responses, poses_of
from omma.rendering.settings import fixed_samples, frame_number
from omma.scene.world import World
from omma.scene.world_colors import index_of

# What `color_jacobian` calls the world's background.
BACKGROUND = "background"
_BLACK, _WHITE = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)


@checked
@method_of("omma.rendering.renderer", "Renderer")
def color_jacobian(
    self: Prepared,
    poses: Poses,
    by: int | str | Sequence[int | str],
    *,
    emissive: bool = False,
    first_pose: int = 0,
    progress: Progress | None = None,
) -> Responses:
    """How responses change with colours: float32 (P, N, C, K, 3), by the linear red, green and blue
    of K colours, exact and without noise of its own for the rays of `render`.

    The response is Σ_k J_k · colour_k, plus what is given off by emission, splats and colours that
    were not asked for. As many renders as colours are asked for, and one; three times as many where
    the world's bands are not red, green and blue. Meanwhile nothing else may render this world.

    Args:
        poses: as in `render`.
        by: materials, by their indices in ``scene.materials`` or their names: their base colours,
            by which textures are multiplied; and ``"background"``, of a constant one, or of one
            that is added. (A material of that name has its index.)
        emissive: by what materials give off (`Material.emissive`), which their emissive textures
            are multiplied by, instead of their base colours.
        first_pose: the number of the first pose's frame, where noise is new in every frame.
        progress: called with the finished share (0 to 1).

    Example:
        >>> scene = omma.load_scene(omma.examples.meadow())
        >>> renderer = omma.Renderer(scene, omma.eye.generate_eye(20), omma.Fixed(4))
        >>> renderer.color_jacobian("bee", ["ground", "background"]).shape
        (1, 20, 3, 2, 3)

    Raises:
        omma.Error: a world that is or was lit, or with the colours of CompoundRay, rays that are
            not `Fixed`, no such material, or what `render` raises.
    """
    check_linear(self.world)
    fixed_samples(self.settings.sampling, "derivatives by colours")
    names = list(by) if isinstance(by, Sequence) and not isinstance(by, str) else [by]
    materials = [one.name for one in self.world.scene.materials]
    which = [
        None if isinstance(name, str) and name == BACKGROUND else _index(name, materials)
        for name in names
    ]
    matrices = poses_of(self, poses)
    lift = band_from_rgb_of(self.world)
    found = np.zeros((len(matrices), len(self.eye), self.bands, len(which), 3), np.float32)
    # Red, green and blue do not mix: white tells of all three.
    lights = [_WHITE] if lift is None else [*np.eye(3)]
    renders = 1 + len(which) * len(lights)

    def seen(background: ArrayLike, number: int) -> Responses:
        renderer = self.with_world(self.world.with_background(Background.constant(background)))
        part = share_of(progress, number / renders, (number + 1) / renders)
        call = Call.of(renderer, matrices, {}, frame_number(first_pose), part)
        return call.render(call.new_frames()).responses

    with black(self.world) as world:
        none = seen(_BLACK, 0)
        for k, material in enumerate(which):
            for j, light in enumerate(lights):
                number = 1 + k * len(lights) + j
                if material is None:
                    change = seen(light, number) - none
                else:
                    on, off = (light, _BLACK) if emissive else (_BLACK, light)
                    world.set_color(material, off, emissive=on)
                    change = seen(_BLACK, number) - none
                    world.set_color(material, _BLACK, emissive=_BLACK)
                if lift is None:
                    found[:, :, range(3), k, range(3)] = change
                else:
                    found[..., k, j] = change
    return found


@checked
@method_of("omma.rendering.renderer", "Renderer")
def background_vjp(
    self: Prepared,
    poses: Poses,
    cotangent: ArrayLike,
    shape: tuple[int, int],
    *,
    first_pose: int = 0,
    progress: Progress | None = None,
) -> Floats:
    """The gradient of a number by each pixel of a panorama that is the background: (H, W, 3), by
    linear red, green and blue. With a cotangent of 1 for one ommatidium, what it sees of it.

    Responses are linear in the panorama: their change by a panorama D, as of
    `Background.image(D)`, times the cotangent is the sum of the gradient times D, exact but for
    rounding, for the rays of `render` without footprints (``footprints=False``), whose pictures
    they average by more than pixels.

    Args:
        poses: as in `render`.
        cotangent: (P, N, C), the number's gradient by responses.
        shape: (H, W) of the panorama.
        first_pose, progress: as in `color_jacobian`.

    Example:
        >>> eye = omma.eye.generate_eye(20)
        >>> renderer = omma.Renderer(omma.Scene(), eye, omma.Fixed(64), footprints=False)
        >>> gradient = renderer.background_vjp(np.eye(4), np.ones((1, 20, 3)), (90, 180))
        >>> gradient.shape, round(gradient.sum())
        ((90, 180, 3), 60)

    Raises:
        omma.Error: a renderer with footprints or frames that last, another shape, or what
            `color_jacobian` raises.
    """
    check_linear(self.world)
    samples = samples_without_filter(self)
    rows, columns = array_of(shape, "shape", (2,), np.int64).tolist()
    size = whole(rows, "shape", 1, 1 << 15), whole(columns, "shape", 1, 1 << 15)
    matrices = poses_of(self, poses)
    expected = (len(matrices), len(self.eye), self.bands)
    weights = array_of(cotangent, "cotangent", expected, finite=True)
    lift = band_from_rgb_of(self.world)
    lift = np.eye(3) if lift is None else lift
    gradient = np.zeros((size[0] * size[1], 3))
    number = frame_number(first_pose) or 0
    # How much of the background comes through, by the colour and the band that tell it best.
    band, color = (int(k) for k in np.unravel_index(np.abs(lift).argmax(), lift.shape))
    if lift[band, color] == 0:
        return gradient.reshape(*size, 3)
    with black(self.world) as world:
        dark, clear = (
            self.with_world(world.with_background(Background.constant(one)))
            for one in (_BLACK, np.eye(3)[color])
        )
        for p in range(len(matrices)):
            part = share_of(progress, p / len(matrices), (p + 1) / len(matrices))
            let_through = rays_of(clear, matrices[p : p + 1], number + p, samples, part)
            let_through -= rays_of(dark, matrices[p : p + 1], number + p, samples, None)
            directions = np.empty((1, len(self.eye), samples, 3), np.float32)
            self._engine.ray_directions(matrices[p : p + 1], number + p, directions)
            share = let_through[..., band] / lift[band, color] / samples
            # By red, green and blue of what the rays of an ommatidium see.
            _spread(gradient, size, directions[0], share, weights[p] @ lift)
    return gradient.reshape(*size, 3)


def samples_without_filter(renderer: Prepared) -> int:
    """Rays of an ommatidium that see pixels themselves."""
    samples = fixed_samples(renderer.settings.sampling, "derivatives by colours")
    if renderer.settings.footprints:
        raise Error(
            "footprints: expected footprints=False, by which rays see the pixels themselves"
        )
    if renderer.settings.impulse_response is not None:
        raise Error("impulse_response: expected frames that do not last")
    return samples


def _index(name: int | str, materials: Sequence[str]) -> int:
    try:
        return index_of(name, "by", materials)
    except Error as error:
        raise Error(f"{error}; or {BACKGROUND!r}") from None


def rays_of(
    renderer: Prepared, pose: Floats, number: int, samples: int, progress: Progress | None
) -> Floats:
    """(N, samples, C), radiance of each ray at one pose."""
    call = Call.of(renderer, pose, {}, number, progress)
    rays = np.empty((*call.size, samples, renderer.bands), np.float32)
    call.render(call.new_frames(), ray_radiance=rays)
    found: Floats = rays[0].astype(np.float64)
    return found


def _spread(
    gradient: Floats,
    size: tuple[int, int],
    directions: NDArray[np.float32],
    share: Floats,
    of_each: Floats,
) -> None:
    """Add to pixels (H W, 3) what rays (N, samples) that look along the directions read of them,
    bilinearly: the azimuth goes round, rows end at the poles."""
    rows, columns = size
    x, y, z = np.moveaxis(directions.astype(np.float64), -1, 0)
    column = (0.5 + np.arctan2(x, -z) / (2 * np.pi)) * columns - 0.5
    row = (0.5 - np.arcsin(np.clip(y, -1, 1)) / np.pi) * rows - 0.5
    left, above = np.floor(column).astype(np.int64), np.floor(row).astype(np.int64)
    for i in (0, 1):
        for j in (0, 1):
            across, down = (np.abs(1 - k - (at - first)) for k, at, first in (
                (i, column, left), (j, row, above)))  # fmt: skip
            pixel = np.clip(above + j, 0, rows - 1) * columns + (left + i) % columns
            weight = share * across * down
            for c in range(3):
                told = (weight * of_each[:, c, None]).ravel()
                gradient[:, c] += np.bincount(pixel.ravel(), told, rows * columns)


def band_from_rgb_of(world: World) -> Floats | None:
    """(C, 3), or None where bands are red, green and blue themselves."""
    found: Floats | None = world._band_from_rgb
    return found


def check_linear(world: World) -> None:
    """omma.Error where responses are not linear in the colours of a world: before anything else, as
    no change of the renderer mends that."""
    if world.light is not None:
        raise Error("world: expected one that is not lit, where light goes from surface to surface")
    if world.scene.color_rule != "gltf":
        raise Error(
            "scene: expected the colour rule gltf, by which responses are linear in colours, found "
            f"{world.scene.color_rule}"
        )


@contextmanager
def black(world: World) -> Iterator[World]:
    """A world of `check_linear` with all materials black, which have their colours back
    afterwards."""
    with world._colors.kept(world._engine):
        for k in range(len(world.scene.materials)):
            world.set_color(k, _BLACK, emissive=_BLACK)
        yield world
