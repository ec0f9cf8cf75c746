"""Makes docs/eye-*.png: the figures that `omma eye plot` makes of a honeybee.

.venv/bin/python docs/make_eye_figures.py
"""

import math
from pathlib import Path

from PIL import Image

import omma
from omma.eye import measure_eye
from omma.picture import plot_acceptance, plot_eye_maps, plot_species

ROOT = Path(__file__).resolve().parent.parent
HERE = ROOT / "docs"
POSTER_WIDTH = 1800


def lenses() -> omma.Eye:
    """A honeybee's eyes with the angular sensitivity of lens and rhabdom, and an oblong one."""
    bee = omma.species.make("honeybee_worker").eye
    optics = omma.Acceptance.lens_rhabdom(20e-6, 66e-6, 2.0e-6, 500)
    oblong = omma.Acceptance.gaussian(math.radians(2.6), math.radians(1.3), math.radians(40))
    return bee.replace(acceptance=[oblong if i == 1 else optics for i in range(len(bee))])


def main() -> None:
    names = [ROOT / "examples" / f"honeybee_worker_{side}.eye" for side in ("left", "right")]
    bee = omma.eye.merge_eyes([omma.load_eye(name) for name in names])
    title = "Honeybee worker, after Giger (1996)"
    measures = measure_eye(bee)
    omma.picture.draw_eye(
        HERE / "eye-3d.png",
        bee.select(1),
        yaw_deg=50,
        pitch_deg=10,
        style="both",
        size_mm=110,
        title=f"{title}: its right eye",
    )
    for projection in ("mollweide", "lambert", "mercator"):
        plot_eye_maps(
            HERE / f"eye-map-{projection}.png",
            bee,
            ["interommatidial", "smaller"],
            projection=projection,
            title=title,
            measures=measures,
        )
    plot_acceptance(
        HERE / "eye-acceptance.png",
        lenses(),
        [1, (45.0, 0.0), (120.0, 45.0)],
        title="Lens and rhabdom at two places of the eye, and an elliptical Gaussian",
    )
    poster = HERE / "eye-poster.png"
    plot_species(poster, omma.species.make("honeybee_worker"))
    page = Image.open(poster).convert("RGB")
    height = round(page.height * POSTER_WIDTH / page.width)
    page.resize((POSTER_WIDTH, height), Image.Resampling.LANCZOS).save(poster, optimize=True)


if __name__ == "__main__":
    main()
