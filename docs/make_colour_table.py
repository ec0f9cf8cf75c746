"""Makes the table of docs/colours.md: from how far a honeybee makes out flowers of 3 cm before
green leaves, as Markdown. Some minutes on two cores.

    .venv/bin/python docs/make_colour_table.py
"""

import numpy as np
from make_colour_figures import BEE, LEAF, PETALS, reflectance

import omma
from omma import colour_vision as cv

NOISE = tuple(cv.class_noise(0.13, [1, 1, 1]))
GREEN = ("green",)
OBSERVERS = (
    cv.Observer(by="colour", noise=NOISE),
    cv.Observer(by="colour", noise=NOISE, ommatidia=59),
    cv.Observer(by="achromatic", noise=NOISE, receptors=GREEN),
    cv.Observer(by="photons", receptors=GREEN),
)
LIGHTS = {"noon": omma.light.clear_sky(60.0), "dusk": omma.light.clear_sky(-4.0)}


def cell(found: cv.Detection) -> str:
    """A distance in metres, with its error where that is more than one of the last digit."""
    if found.distance_m == 0:
        return "never"
    digits = 2 if found.distance_m < 3 else 1
    text = f"{found.distance_m:.{digits}f}"
    if np.isfinite(found.standard_error_m) and found.standard_error_m < 10.0**-digits:
        return text
    return f"{text} ± {found.standard_error_m:.1g}"


def main() -> None:
    print(
        "| petal | colour, 7 ommatidia | colour, 59 | green receptors, 7 | photons of green "
        "receptors, d' = 1 |"
    )
    print("| --- | --- | --- | --- | --- |")
    for petal in PETALS:
        target = cv.DiscTarget(0.03, reflectance(petal), background=reflectance(LEAF))
        for name, light in LIGHTS.items():
            found = [omma.detect(BEE, target, light, observer) for observer in OBSERVERS]
            row = [f"{petal.split()[0]}, {name}", *map(cell, found)]
            print("|", " | ".join(row), "|", flush=True)


if __name__ == "__main__":
    main()
