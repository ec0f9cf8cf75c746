"""What an arena of LEDs makes of a stimulus that nobody means: pixels, frames and grey levels that
are too few for it. The caller is told, with what to change."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from omma.base.arrays import Floats
from omma.base.slips import warn_of_slip
from omma.base.warn import warn_caller
from omma.stimuli.bars import Bar
from omma.stimuli.discs import Target
from omma.stimuli.dots import RandomDots
from omma.stimuli.gratings import DrumGrating, PlaneGrating, SphereGrating
from omma.stimuli.stimulus import Stimulus

# Of its time: by so much what is shown may be shorter or longer.
_MOST_OFF = 0.005
# Of a period, by which a grating may jump where frames come again.
_MOST_JUMP = 0.05
# Of contrast and of an even light, by which levels may be off.
_MOST_COARSE = 0.1


def tell_of_frames(shown: Stimulus, duration_s: float, refresh_hz: float, frame_count: int) -> None:
    """Frames that are too slow for a stimulus, or do not go on where they come again."""
    warn_of_slip("frames per second", refresh_hz, "refresh_hz")
    lasts_s = frame_count / refresh_hz
    if abs(lasts_s / duration_s - 1) > _MOST_OFF:
        _tell(
            f"duration_s: {duration_s:g} s are {duration_s * refresh_hz:.4g} frames of "
            f"{refresh_hz:g} Hz; {frame_count} are shown, {lasts_s:.4g} s. Take "
            f"refresh_hz={frame_count / duration_s:.6g}, or duration_s={lasts_s:.6g}"
        )
    if not isinstance(shown, DrumGrating | SphereGrating | PlaneGrating):
        return
    rate_hz = abs(shown.temporal_frequency_hz)
    if rate_hz >= refresh_hz / 2:
        seen_hz = rate_hz - refresh_hz * round(rate_hz / refresh_hz)
        _tell(
            f"refresh_hz: {rate_hz:g} periods a second in {refresh_hz:g} frames look like "
            f"{seen_hz:g} (below 0: backwards). Take a refresh_hz above {2 * rate_hz:g}"
        )
    jump = abs(rate_hz * lasts_s - round(rate_hz * lasts_s))
    if jump > _MOST_JUMP:
        _tell(
            f"duration_s: frames come again each {lasts_s:.4g} s, where the grating jumps by "
            f"{jump:.2g} periods. Take a whole number of them: duration_s="
            f"{_whole_periods_s(rate_hz, refresh_hz):.6g}"
        )


def tell_of_pixels(shown: Stimulus, pixels_around: int) -> None:
    """A stimulus that is too fine for pixels."""
    pixel_deg = 360 / pixels_around
    if isinstance(shown, DrumGrating | SphereGrating):
        wavelength_deg, name = shown.wavelength_deg, "wavelength_deg"
    elif isinstance(shown, PlaneGrating):
        away_m = float(np.linalg.norm(shown.center_m))
        wavelength_deg, name = np.degrees(shown.wavelength_m / away_m), "wavelength_m"
    else:
        _tell_of_size(shown, pixel_deg)
        return
    if wavelength_deg < 2 * pixel_deg:
        around = 360 / wavelength_deg
        others = abs(around - pixels_around * round(around / pixels_around))
        seen = f"a wavelength of {360 / others:.3g}°" if others > 1e-6 else "an even light"
        _tell(
            f"{name}: {wavelength_deg:.3g}° on pixels of {pixel_deg:.3g}° look like {seen}. Take "
            f"{2 * pixel_deg:.3g}° or more, or panels_around={int(np.ceil(2 * around / 8))}"
        )


def _tell_of_size(shown: Stimulus, pixel_deg: float) -> None:
    """A thing that may lie between the middles of pixels."""
    sizes = {}
    if isinstance(shown, RandomDots | Target):
        sizes = {"diameter_deg": shown.diameter_deg}
    elif isinstance(shown, Bar):
        sizes = {"width_deg": shown.width_deg, "height_deg": shown.height_deg}
    for name, size_deg in sizes.items():
        if size_deg < pixel_deg:
            _tell(
                f"{name}: {size_deg:g}° is less than a pixel of {pixel_deg:.3g}°, whose middle "
                "alone tells its light, so that it comes and goes. Take a larger one or more panels"
            )


class RangeShown:
    """Radiances of frames: from the least to the most, and whether some are in between."""

    def __init__(self) -> None:
        self.least, self.most, self.is_graded = np.inf, 0.0, False

    def add(self, radiance: Floats) -> None:
        """Of a frame's pixels."""
        low, high = float(radiance.min()), float(radiance.max())
        self.least, self.most = min(self.least, low), max(self.most, high)
        share = (radiance - low) / max(high - low, 1e-9 * high, 1e-300)
        self.is_graded |= bool(np.any((share > _MOST_COARSE) & (share < 1 - _MOST_COARSE)))


def tell_of_levels(shown: RangeShown, brightest: float, bits: int) -> None:
    """Radiances that levels do not tell apart, or that LEDs do not reach."""
    least, most, step = shown.least, shown.most, brightest / (2**bits - 1)
    if most > brightest + step / 2:
        _tell(
            f"brightest: the stimulus goes up to {most:.3g}, of which all above {brightest:g} is "
            f"shown as {brightest:g}. Take brightest={_rounded_up(most):g}"
        )
        return
    low, high = (step * np.floor(radiance / step + 0.5) for radiance in (least, most))
    span = most - least
    if high - low > 1.5 * step:
        return
    off = abs(high - low - span) / span if span > 1e-9 * most else abs(high - most) / (most or 1)
    # Who asks for one bit knows that there is no grey.
    if off > _MOST_COARSE or (shown.is_graded and bits > 1):
        levels = f"{low:.3g} alone" if low == high else f"{low:.3g} and {high:.3g} alone"
        finer = "bits=8" if bits < 8 else "a stimulus of more contrast"
        own = _rounded_up(most)
        nearer = f", or brightest={own:g}, its own" if own < 0.9 * brightest else ""
        _tell(
            f"bits: radiances from {least:.3g} to {most:.3g} are shown as {levels}, as levels are "
            f"{step:.3g} apart. Take {finer}{nearer}"
        )


def tell_of_seam(frame_count: int) -> None:
    """What is played beyond the last frame, and does not go on in the first."""
    _tell(
        f"duration_s: what is played goes beyond the {frame_count} frames that are shown again and "
        "again, and the first does not follow the last. Take a duration_s that holds all of it, or "
        "a whole turn of what turns; frames that last see what was shown before them too"
    )


def jumps_at_seam(shown: Stimulus, frames: NDArray[np.uint8], of_frame: NDArray[np.int64]) -> bool:
    """Whether the first frame differs from the last by more than twice what any other does from the
    one before. Of gratings `tell_of_frames` tells."""
    if isinstance(shown, DrumGrating | SphereGrating | PlaneGrating) or len(of_frame) < 3:
        return False
    steps: Floats = np.array(
        [
            np.abs(frames[now].astype(np.int16) - frames[before]).mean()
            for before, now in zip(of_frame, np.roll(of_frame, -1), strict=True)
        ]
    )
    return bool(steps[-1] > 2 * steps[:-1].max())


def _rounded_up(radiance: float) -> float:
    """To two digits."""
    unit = 10.0 ** (np.floor(np.log10(radiance)) - 1) if radiance > 0 else 1.0
    return float(unit * np.ceil(radiance / unit - 1e-6))


def _whole_periods_s(rate_hz: float, refresh_hz: float) -> float:
    """The shortest time of whole periods that is whole frames, nearly."""
    periods = np.arange(1, 101)
    frames = periods * refresh_hz / rate_hz
    off = np.abs(np.maximum(np.rint(frames), 1) / frames - 1)
    return float(periods[np.argmax(off <= max(_MOST_OFF, off.min()))] / rate_hz)


def _tell(sentence: str) -> None:
    warn_caller(f"{sentence} (docs/scenes.md, LED arenas)", UserWarning)
