"""An acuity map: how much contrast an eye keeps of stripes, by direction, against the formula.

The animal stands inside a striped drum as wide as the world and turns by steps; what is left of the
stripes in each response is its modulation. A Gaussian of width Δρ keeps exp(-3.56 ν²Δρ²).

python examples/python/acuity_map.py [animal of omma.species] [directory to write to]
"""

import sys
from pathlib import Path

import numpy as np

import omma
from omma.picture import plot_eye_maps

STRIPES = 60  # around the horizon: 6 degrees each there, less above and below
STEPS = 8  # turns within one stripe


def modulation(eye, stripes=STRIPES, samples=256):
    """What each ommatidium keeps of the stripes' contrast, (N,), rendered."""
    width = 64 * stripes
    phase = 2 * np.pi * stripes * (np.arange(width) + 0.5) / width
    row = (0.5 + 0.5 * np.sin(phase)).astype(np.float32)
    drum = omma.Background.image(np.repeat(np.repeat(row[None, :, None], 512, 0), 3, 2))
    renderer = omma.Renderer(
        omma.Scene(), eye, omma.Fixed(samples), background=drum, footprints=False
    )
    turns = np.arange(STEPS) / STEPS
    yaw = np.stack([turns * 360 / stripes, np.zeros(STEPS), np.zeros(STEPS)], axis=1)
    responses = renderer.render(omma.poses_from_angles(np.zeros((STEPS, 3)), yaw))[..., 0]
    first = np.abs(np.tensordot(np.exp(2j * np.pi * turns), responses, axes=(0, 0)))
    return 2 * first / responses.sum(axis=0)


def formula(eye, stripes=STRIPES):
    """exp(-3.56 ν²Δρ²) at each ommatidium's own elevation, where the stripes are narrower."""
    elevation = np.arcsin(eye.axis[:, 1].astype(float))
    frequency = stripes / (2 * np.pi * np.cos(elevation))  # cycles per radian
    return np.exp(-3.5597 * (frequency * eye.acceptance_angle_rad) ** 2)


def main(name="honeybee_drone", directory="out"):
    out = Path(directory)
    out.mkdir(parents=True, exist_ok=True)
    eye = omma.species.make(name).eye
    kept, wanted = modulation(eye), formula(eye)
    # Near the poles stripes meet in a point, and no plane grating is left to compare with.
    level = np.abs(eye.axis[:, 1]) < np.sin(np.radians(60))
    error = np.abs(kept - wanted)[level]
    print(f"{name}: {len(eye):,} ommatidia, {STRIPES} stripes around")
    least, most = kept[level].min(), kept[level].max()
    print(f"contrast kept within 60° of the horizon: {least:.2f} to {most:.2f}")
    print(f"from the formula: median {np.median(error):.4f}, at most {error.max():.4f}")
    picture = out / f"acuity_{name}.png"
    shown = eye.replace(columns={"contrast kept": kept, "by the formula": wanted})
    title = f"{name.replace('_', ' ')}: contrast kept of {STRIPES} stripes around the horizon"
    plot_eye_maps(picture, shown, ["contrast kept", "by the formula"], title=title)
    print(f"wrote {picture}")


if __name__ == "__main__":
    main(*sys.argv[1:])
