"""By how much responses depend on what nobody says of the ultraviolet: the same frames by paths,
with all that is unknown dark there, and as bright there as in blue."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arguments import checked
from omma.base.progress import Progress, share_of
from omma.base.values import value_class
from omma.rendering.call import Poses, Responses
from omma.rendering.renderer import Renderer


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class UltravioletDependence:
    """What `ultraviolet_dependence` found."""

    materials: tuple[str, ...]
    """Of which only RGB is known; "" are surfaces without a material."""
    dark: Responses
    """(P, N, C), or of receptors (P, R): where these reflect nothing below 400 nm."""
    as_blue: Responses
    """The same where they reflect there as much as in blue."""
    standard_error: Responses
    """Of the difference of both, by the chance of rays."""

    @property
    def share(self) -> NDArray[np.float32]:
        """(P, N, C) or (P, R): the share of the larger response that depends on the choice, 0 to 1.

        Of a few times `share_error` and less it is chance: which ways paths take depends on all
        bands, so that bands above 400 nm differ too.
        """
        return self._of_larger(np.abs(self.as_blue - self.dark))

    @property
    def share_error(self) -> NDArray[np.float32]:
        """The standard error of `share`, of its shape."""
        return self._of_larger(self.standard_error)

    def _of_larger(self, difference: Responses) -> NDArray[np.float32]:
        larger = np.maximum(self.dark, self.as_blue)
        return np.asarray(
            np.divide(difference, larger, out=np.zeros_like(larger), where=larger > 0)
        )

    def __repr__(self) -> str:
        share = self.share
        told = "nothing was rendered"
        if share.size:
            most = np.argmax(share)
            told = f"up to {share.flat[most]:.1%} ± {self.share_error.flat[most]:.1%} of a response"
        return f"<omma.rendering.UltravioletDependence on {len(self.materials)} materials: {told}>"


@checked
def ultraviolet_dependence(
    renderer: Renderer,
    poses: Poses,
    *,
    receptors: bool = False,
    progress: Progress | None = None,
) -> UltravioletDependence:
    """By how much responses depend on materials of which only RGB is known.

    Renders twice by paths with standard errors, whatever ``ultraviolet`` the world was given: with
    all these materials dark below 400 nm, and with all of them as in blue. What lies between is
    what nobody knows; where that is too much, materials need spectra (docs/materials.md).

    Args:
        renderer: of a lit world.
        poses, progress: as of `Renderer.render`.
        receptors: tell of receptors, instead of bands.

    Raises:
        omma.Error: the world has no light; what `Renderer.render` raises.
        TypeError: ``renderer`` is none.
    """
    world = renderer.world
    light = world.light
    if light is None:
        raise Error("renderer: expected one of a lit world, found one without light")
    names = world.materials_without_ultraviolet
    found, errors = [], []
    rules: tuple[Literal["dark", "as_blue"], ...] = ("dark", "as_blue")
    for k, rule in enumerate(rules):
        there = renderer.with_world(world.with_light(light, lighting="path", ultraviolet=rule))
        told = share_of(progress, k / 2, (k + 1) / 2)
        render = there.render_receptors if receptors else there.render
        responses, error = render(poses, standard_error=True, first_pose=0, progress=told)
        found.append(responses)
        errors.append(error)
    dark, as_blue = found
    return UltravioletDependence(names, dark, as_blue, np.hypot(*errors))
