"""A thing in a lit scene, as an eye sees it from a distance: rendered with it and without it, with
the same rays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from omma._core import Eye
from omma.base.arrays import Floats
from omma.colour_vision.targets import SceneTarget
from omma.colour_vision.views import Seen, View, met
from omma.light.lights import Light
from omma.receptors.catches import photon_catch
from omma.rendering.call import Call
from omma.rendering.receptor_frames import frames_of_receptors
from omma.rendering.renderer import Renderer
from omma.rendering.settings import Fixed
from omma.scene.world import World

# Independent estimates, each with rays as of a frame of its own, of what the target adds.
_REPEATS = 8


class SceneView(View):
    """A thing in a scene, as some of an eye's ommatidia see it from any distance."""

    def __init__(
        self, whole: Eye, target: SceneTarget, light: Light, direction: Floats, time_s: float
    ) -> None:
        super().__init__(whole, target.diameter_m, direction)
        self._light, self._time_s = light, time_s
        self._worlds = [
            World(scene, light=light, ultraviolet=target.ultraviolet)
            for scene in (target.without, target.scene)
        ]
        towards = np.array(target.towards)
        self._towards = towards / np.sqrt(np.sum(towards**2))
        self._on_target = self.pose_on(np.array(target.center_m), self._towards)

    def through(self, ommatidia: NDArray[np.intp], sampling: Fixed, seed: int) -> SceneSeen:
        """What these ommatidia see, by so many rays in each of 8 estimates."""
        eye = self._whole.take(ommatidia)
        renderers = [
            Renderer(world, eye, sampling, seed=seed, noise="new_every_frame")
            for world in self._worlds
        ]
        # Photons for a response of 1.
        each = photon_catch(
            eye, np.ones(len(eye.receptor_type)), self._light, integration_time_s=self._time_s
        )
        return SceneSeen(renderers, self._on_target, self._towards, each)


class SceneSeen:
    """Responses to a thing at any distance, of one eye."""

    def __init__(
        self, renderers: list[Renderer], on_target: Floats, towards: Floats, each: Floats
    ) -> None:
        self._eye = renderers[0].eye
        self._renderers, self._on_target = renderers, on_target
        self._towards, self._each = towards, each

    def at(self, distance_m: float) -> Seen:
        """From this distance between the thing's middle and the head's origin."""
        pose = self._on_target.copy()
        pose[:3, 3] += distance_m * self._towards
        frames = np.broadcast_to(pose, (_REPEATS, 4, 4))
        # Without the word of `render_receptors` on polarisation that is left out: `detect` has one.
        calls = [Call.of(one, frames, {}, first_pose=0) for one in self._renderers]
        without, with_it = (
            frames_of_receptors(one, None, None, False).responses.astype(np.float64) * self._each
            for one in calls
        )
        more = with_it - without
        error = more.std(axis=0, ddof=1) / np.sqrt(_REPEATS)
        added = more.mean(axis=0)
        return Seen(self._eye, without.mean(axis=0), added, error, met(added, error))
