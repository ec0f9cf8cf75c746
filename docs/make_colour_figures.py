"""Makes the figures of docs/colours.md.

.venv/bin/python docs/make_colour_figures.py [folder]
"""

import sys
from pathlib import Path

import numpy as np

import omma
from omma import colour_vision as cv

FOLDER = Path(__file__).resolve().parent
PETALS = ("yellow petal", "white petal", "blue petal", "red petal")
LEAF = "green leaf"
BEE = omma.species.honeybee_worker().eye


def reflectance(name: str) -> omma.light.Spectrum:
    found = omma.scene.natural_materials()[name]
    return omma.light.Spectrum(found.wavelength_nm, found.total_reflectance)


def radiance(light: omma.light.Light, name: str) -> np.ndarray:
    """Of a wide surface in sky and sun: (band,)."""
    return light.bands.mean(reflectance(name)) * sum(light.irradiance()) / np.pi


def photons(light: omma.light.Light, seen: np.ndarray) -> np.ndarray:
    """Of an ultraviolet, a blue and a green receptor, in 30 ms: (3,) of radiances (band,)."""
    matrix = omma.receptors.receptor_matrix(BEE, bands=light.bands)
    responses = (matrix @ seen)[BEE.receptor_type]
    caught = omma.receptors.photon_catch(BEE, responses, light, integration_time_s=0.03)
    return np.array([np.median(caught[BEE.receptor_type == k]) for k in range(3)])


def main(folder: Path) -> None:
    bands = omma.light.Bands.equal(50)
    lights = {
        "noon": omma.light.clear_sky(60.0, bands=bands),
        "dusk": omma.light.clear_sky(-4.0, bands=bands),
    }
    caught = {
        name: np.array([photons(light, radiance(light, one)) for one in (*PETALS, LEAF)])
        for name, light in lights.items()
    }
    noon = cv.von_kries(caught["noon"], caught["noon"][-1])
    # Monochromatic lights of as many photons each as the leaf sends in all bands together.
    most = radiance(lights["noon"], LEAF).sum()
    alone = [photons(lights["noon"], most * one) for one in np.eye(len(bands))]
    wavelength_nm, spectrum = bands.centers_nm, cv.von_kries(alone, caught["noon"][-1])
    cv.plot_hexagon(
        folder / "colours-hexagon.png", cv.excitations(noon), labels=[*PETALS, LEAF],
        spectrum=(wavelength_nm, cv.excitations(spectrum)),
        title="Petals and a leaf for a honeybee, at noon",
    )  # fmt: skip
    noise = cv.class_noise(0.13, [1, 1, 1])
    apart = np.stack([
        cv.noise_limited_distance(by[:-1], by[-1], noise, photon_noise=True)
        for by in caught.values()
    ], axis=1)  # fmt: skip
    cv.plot_distances(
        folder / "colours-distances.png", apart, PETALS, series=list(caught),
        title="Petals from a green leaf, for a honeybee",
    )  # fmt: skip


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER)
