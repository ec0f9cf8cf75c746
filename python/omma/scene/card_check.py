"""Whether a graphics card sees a small scene as the processor does: asked before one is taken."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from omma import _core
from omma._core import Error, Scene
from omma.base.progress import Progress, without_share
from omma.eye import generate_eye
from omma.light import Bands, uniform_sky
from omma.scene.joining import merge_scenes
from omma.scene.lighting import checked_lighting
from omma.scene.solids import box, plane, sphere

# Of the mean response, in the mean over the eye. Square roots and powers of a card may round
# otherwise, which is 1e-6; what is compiled wrongly is another picture.
_ALLOWED = 1e-3


def trouble_with_card(progress: Progress | None = None) -> str:
    """What is wrong with the card's pictures of a small scene, unlit and lit; "" for nothing.

    ``progress`` is told of nothing finished while kernels are compiled.
    """
    scene = _small_scene()
    try:
        _core.card_note([], without_share(progress))
        for is_lit in (False, True):
            expected, found = (_seen(scene, backend, is_lit) for backend in ("portable", "cuda"))
            difference = float(np.abs(found - expected).mean() / expected.mean())
            if not difference <= _ALLOWED:
                return (
                    f"it sees a small scene otherwise, by {difference:.1g} of the mean response "
                    f'(expected {_ALLOWED:g} at most); backend="cuda" takes it all the same'
                )
    except Error as error:
        return str(error)
    return ""


def _small_scene() -> Scene:
    """Surfaces with edges, a picture and shadows."""
    checks = np.kron(np.indices((4, 4)).sum(axis=0) % 2, np.ones((4, 4)))
    ground = np.repeat(checks[:, :, None].astype(np.float32), 3, axis=2)
    return merge_scenes(
        [
            plane((8, 8), ground, name="ground"),
            box((1, 1, 1), (0.6, 0.3, 0.1), center_m=(-1, 0.5, -2)),
            sphere(0.6, (0.1, 0.4, 0.2), center_m=(1, 0.6, -2), segments=24),
        ]
    )


def _seen(scene: Scene, backend: str, is_lit: bool) -> NDArray[np.float32]:
    lit = None
    if is_lit:
        bands = Bands.equal(4, 400, 700)
        given = checked_lighting(
            uniform_sky(below=0.2, bands=bands), None, None, True, "dark", "exact", None
        )
        assert given is not None
        lit = given.for_engine(given.light_arguments(scene))
    world = _core.World(scene, 0, None, backend, [], [], lit, None)
    eye = generate_eye(100)
    engine = _core.Renderer(world, eye, _core.RenderSettings(sampling=("fixed", 8)))
    pose = _core.look_at((0, 1, 1.5), (0, 0.5, -2))[None]
    seen = np.empty((1, len(eye), world.bands), np.float32)
    engine.render(pose, seen, None, None, None, None, None, None, False, None, None)
    return seen
