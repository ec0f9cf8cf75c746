"""What the colours of Gaussian splats are in units of light."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error, Scene
from omma.base.arguments import array_of, checked, positive, within
from omma.base.srgb import linear_of_srgb

# Luminance, cd/m², of what saturates a camera at EV100 0: 78 / (S q) N² / t with S = 100 and
# q = 0.65 (ISO 12232:2019; Lagarde and de Rousiers 2014, Moving Frostbite to PBR, section 5.1.1).
_SATURATED_CD_M2 = 1.2
# Of linear sRGB (IEC 61966-2-1).
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


@checked
def calibrate(
    scene: Scene,
    *,
    gray_card: ArrayLike | None = None,
    reflectance: float = 0.18,
    exposure: float | None = None,
) -> Scene:
    """The same scene, the light of whose Gaussian splats has a scale.

    Splats are relative: 1 is what was white in the pictures that they were trained from. A gray
    card that is seen in them tells the light of the place in each channel: from then on 1 is what a
    white surface sends that lies where the card lay, so that a matt surface has its reflectance. An
    exposure tells cd/m² (of linear RGB, by its luminance), as far as the camera's pictures were
    not developed otherwise. Both together take the ratios of the channels from the card. Of splats
    whose channels are bands a card alone tells.

    Args:
        scene: with splats. Its surfaces keep their colours.
        gray_card: the card's colour (C,) in the pictures, in the splats' channels and colour
            space, 0 to 1.
        reflectance: of the card.
        exposure: EV100 of the pictures: log2(N² / t) at ISO 100, of an aperture N and a time t, s.

    Example:
        >>> card = omma.scene.SplatCloud(
        ...     [(0, 0, -1)], [(0.1, 0.1, 0.1)], [(0, 0, 0, 1)], [1.0], np.zeros((1, 1, 3))
        ... )
        >>> scene = omma.Scene(splats=[card])
        >>> calibrated = omma.scene.calibrate(scene, gray_card=(0.5, 0.5, 0.5), reflectance=0.18)
        >>> round(calibrated.splats[0].white[0] * 0.214, 3)
        0.18

    Raises:
        omma.Error: a scene without splats, neither card nor exposure, an exposure of splats that
            are not RGB, numbers out of range.
    """
    if not scene.splats:
        raise Error("scene: expected Gaussian splats, found none")
    if gray_card is None and exposure is None:
        raise Error("calibrate: expected gray_card or exposure, found neither")
    channels = len(scene.splats[0].white)
    if exposure is not None and scene.splats[0].bands_nm is not None:
        raise Error(
            f"exposure: expected splats of RGB, found {channels} bands: give gray_card, which "
            "tells the light of each"
        )
    white = np.ones(channels)
    if gray_card is not None:
        card = array_of(gray_card, "gray_card", (channels,))
        if not (np.isfinite(card).all() and (card > 0).all() and (card <= 1).all()):
            of_bytes = (card >= 1).all() and (card <= 255).all()
            hint = "; divide a picture's bytes by 255" if of_bytes else ""
            raise Error(
                f"gray_card: expected a colour above 0 and up to 1, found {card.tolist()}{hint}"
            )
        if scene.splats[0].color_space == "srgb":
            card = linear_of_srgb(card)
        white = within(positive(reflectance, "reflectance"), "reflectance", 0, 1) / card
    if exposure is not None:
        level = _SATURATED_CD_M2 * 2.0 ** within(exposure, "exposure", -30, 30)
        white = white / (white @ _LUMINANCE) * level
    return scene.replace(splats=[one.replace(white=white) for one in scene.splats])
