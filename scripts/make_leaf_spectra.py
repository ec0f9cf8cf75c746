"""Computes the visible part of leaves, blades and swards: python/omma/scene/leaf_spectra.csv.

    pip install prosail==2.0.5
    python scripts/make_leaf_spectra.py

Leaves are PROSPECT-D, swards four-stream SAIL over such leaves and a soil, both as in prosail.
They begin at 400 nm; what is known below that is in materials.csv. To be run when a number here
has changed.
"""

import csv
from pathlib import Path

import numpy as np
import prosail

TABLE = Path(__file__).resolve().parents[1] / "python" / "omma" / "scene" / "leaf_spectra.csv"
NM = range(400, 701, 10)

# Of a leaf: layers N, chlorophyll, carotenoids (µg/cm²), brown pigments, water, dry matter (g/cm²),
# anthocyanins (µg/cm²). All assumed, in the usual range, so that a green leaf reflects 0.14 at
# 540 nm and transmits 0.10.
LEAVES = {
    "green leaf": (1.7, 45.0, 9.0, 0.0, 0.012, 0.006, 1.0),
    "grass blade": (1.4, 40.0, 8.0, 0.0, 0.010, 0.004, 0.0),
    "dry grass": (2.2, 1.0, 3.0, 0.5, 0.001, 0.006, 0.0),
}
# Of a sward: its blades, and the leaf area over an area of ground. The blades stand at all angles.
SWARDS = {"green sward": ("grass blade", 3.0), "dry sward": ("dry grass", 2.0)}


def inputs(name: str) -> str:
    layers, chlorophyll, carotenoids, brown, water, dry, anthocyanins = LEAVES[name]
    return (
        f"N {layers:g}; chlorophyll {chlorophyll:g}; carotenoids {carotenoids:g}; "
        f"anthocyanins {anthocyanins:g} µg/cm²; brown {brown:g}; water {water:g}; "
        f"dry matter {dry:g} g/cm²"
    )


def leaf(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Reflectance and transmittance from 400 nm on, by 1 nm."""
    *rest, anthocyanins = LEAVES[name]
    _, reflectance, transmittance = prosail.run_prospect(
        *rest, ant=anthocyanins, prospect_version="D"
    )
    return reflectance, transmittance


def sward(name: str) -> np.ndarray:
    """What a sward gives back of light that falls on it evenly from all sides, from 400 nm on."""
    blade, leaf_area = SWARDS[name]
    *rest, anthocyanins = LEAVES[blade]
    return prosail.run_prosail(
        *rest,
        leaf_area,
        -0.35,  # a and b of Verhoef's distribution of leaf angles: all angles alike
        0.05,  # the hot spot, which plays no part in what comes from all sides
        45.0,
        0.0,
        0.0,
        ant=anthocyanins,
        typelidf=1,
        lidfb=-0.15,
        prospect_version="D",
        rsoil=0.6,
        psoil=0.5,
        factor="BHR",
    )


def main() -> None:
    rows = []
    for name in LEAVES:
        for quantity, values in zip(("reflectance", "transmittance"), leaf(name)):
            rows += [
                (name, quantity, nm, f"{values[nm - 400]:.4f}", "prospect", inputs(name))
                for nm in NM
            ]
    for name, (blade, leaf_area) in SWARDS.items():
        note = f"leaves of {blade}; leaf area {leaf_area:g}; soil half moist"
        rows += [
            (name, "reflectance", nm, f"{value:.4f}", "sail", note)
            for nm, value in zip(NM, sward(name)[:301:10])
        ]
    with TABLE.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(
            ("material", "quantity", "wavelength_nm", "value", "standing", "source", "note")
        )
        writer.writerows((*row[:4], "computed", *row[4:]) for row in rows)


if __name__ == "__main__":
    main()
