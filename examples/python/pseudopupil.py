"""The pseudopupil: the facets that look at who looks at the eye, dark as they take the light in.

Where angles between axes are small against facets it is large, as in a robber fly's fovea; a
honeybee's is a tall oval, as its vertical angles are the smaller.

python examples/python/pseudopupil.py [directory to write to] [animals of omma.species]
"""

import sys
from pathlib import Path

import numpy as np

import omma


def gaze(eye, viewer):
    """How sensitive each ommatidium (N,) is to light from a far viewer in direction (3,), and how
    far off that is from its axis, radians."""
    across = np.linalg.norm(np.cross(eye.axis.astype(float), viewer), axis=1)
    angle = np.arctan2(across, eye.axis @ viewer)
    return np.array([eye.acceptance(i).eval(angle[i]) for i in range(len(eye))]), angle


def main(directory="out", *names):
    out = Path(directory)
    out.mkdir(parents=True, exist_ok=True)
    for name in names or ("holcocephala", "honeybee_worker"):
        animal = omma.species.make(name)
        eye = animal.eye.select(1)
        # From where the most ommatidia look: the animal's finest direction.
        azimuth, elevation = finest(eye)
        shown, angle = gaze(eye, omma.eye.direction(azimuth, elevation))
        count = int((shown > 0.5).sum())
        print(
            f"{animal.latin}: {count} of {len(eye):,} facets look back, {shown.sum():.1f} in all,"
        )
        print(f"  from azimuth {azimuth:.0f}°, elevation {elevation:.0f}°")
        around = np.flatnonzero(angle < np.radians(12))
        omma.picture.draw_eye(
            out / f"pseudopupil_{name}.png",
            eye.replace(columns={"sensitivity to the viewer": shown}).take(around),
            yaw_deg=azimuth,
            pitch_deg=elevation,
            colour="sensitivity to the viewer",
            title=f"{animal.latin}: the pseudopupil, and the facets that look within 12° of it",
        )
        print(f"wrote {out / f'pseudopupil_{name}.png'}")


def finest(eye):
    """Azimuth and elevation, degrees, of the axis whose neighbours are nearest."""
    x, y, z = eye.axis[int(np.argmin(eye.interommatidial_angle_rad()))].astype(float)
    return np.degrees(np.arctan2(x, -z)), np.degrees(np.arcsin(y))


if __name__ == "__main__":
    main(*sys.argv[1:])
