"""Makes docs/species-*.png, maps of all animals' eyes, for docs/species.md and the site's pages.

.venv/bin/python docs/make_species_figures.py    minutes
"""

from pathlib import Path

import numpy as np

import omma
from omma.picture import plot_eye_maps

DOCS = Path(__file__).resolve().parent


def main():
    for name in omma.species.names():
        animal = omma.species.make(name)
        angle = np.degrees(animal.eye.interommatidial_angle_rad())
        plot_eye_maps(
            DOCS / f"species-{name}.png",
            animal.eye,
            ["interommatidial", "smaller", "facet", "acceptance"],
            title=animal.latin,
        )
        print(f"wrote species-{name}.png: Δφ {angle.min():.2f} to {angle.max():.2f}°")


if __name__ == "__main__":
    main()
