"""Makes docs/lit-meadow.png and docs/lit-meadow-bee.png: the lit meadow at three times of day.

    .venv/bin/python docs/make_lit_figures.py

Some minutes on two cores. Each picture of lit-meadow.png has an exposure of its own: its brightness
says nothing of how much light there is.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from make_figures import dense_eye

import omma

FOLDER = Path(__file__).resolve().parent
WIDTH, HEIGHT = 400, 250
RAYS = 24  # a pixel
BEE_RAYS = 48  # an ommatidium
# The camera looks north; the sun is behind it, on the right, then on the left between two trees.
LIGHTS = {
    "noon: clear, sun at 60°": omma.light.clear_sky(60, sun_azimuth_deg=150),
    "evening: clear, sun at 10°": omma.light.clear_sky(10, sun_azimuth_deg=225),
    "overcast": omma.light.overcast_sky(60),
}


def white_ground(light: omma.light.Light, eye: omma.Eye) -> np.ndarray:
    """What each type of receptor answers to white matt ground in that light: (types,)."""
    matrix = omma.receptors.receptor_matrix(eye, bands=light.bands)
    return matrix @ sum(light.irradiance()) / np.pi


def bee_colours(radiance: np.ndarray, light: omma.light.Light, eye: omma.Eye) -> np.ndarray:
    """Green, blue and ultraviolet as red, green and blue, each adapted to the light: white matt
    ground is 1."""
    matrix = omma.receptors.receptor_matrix(eye, bands=light.bands)
    answers = radiance @ matrix.T / white_ground(light, eye)
    return answers[..., ::-1].astype(np.float32)


def exposed(colours: np.ndarray) -> np.ndarray:
    """As on film: the ground, in the lower half, well lit, and the sky not burnt out."""
    ground = np.quantile(colours[len(colours) // 2 :].mean(axis=-1), 0.9)
    film = 1 - np.exp(-np.clip(colours, 0, None) * (0.5 / ground))
    return omma.picture.display(film.astype(np.float32))


def cameras(world: omma.World, eye: omma.Eye) -> None:
    """What a camera sees among the flowers: for people, and in false colours for a bee."""
    figure, panels = plt.subplots(3, 2, figsize=(11, 10.9), layout="constrained")
    for row, (name, light) in zip(panels, LIGHTS.items()):
        lit = world.with_light(light)
        radiance = omma.render_camera(lit, "bee", width=WIDTH, height=HEIGHT, samples=RAYS)
        row[0].imshow(exposed(omma.picture.bands_to_rgb(radiance, light)))
        row[1].imshow(exposed(bee_colours(radiance, light, eye)))
        row[0].set_ylabel(name, fontsize=11)
    panels[0, 0].set_title("as people see it", fontsize=11)
    panels[0, 1].set_title("bee: green, blue, ultraviolet as red, green, blue", fontsize=11)
    for panel in panels.ravel():
        panel.set_xticks([])
        panel.set_yticks([])
        panel.spines[:].set_visible(False)
    figure.savefig(FOLDER / "lit-meadow.png", dpi=110)
    plt.close(figure)


def through_the_eye(world: omma.World, eye: omma.Eye) -> None:
    """The whole surround at noon, sharp and through a bee's eyes, as her receptors answer."""
    name, light = next(iter(LIGHTS.items()))
    lit = world.with_light(light)
    all_three = omma.receptors.OmmatidiumType("all", tuple(eye.receptor_types))
    dense = omma.receptors.assign_receptors(dense_eye(720, 360), all_three)
    white = white_ground(light, eye)
    seen = [
        omma.Renderer(lit, one, omma.Fixed(rays)).render_receptors("bee")[0]
        / white[one.receptor_type]
        for one, rays in ((dense, 8), (eye, BEE_RAYS))
    ]
    omma.picture.plot_responses(
        FOLDER / "lit-meadow-bee.png",
        [dense, eye],
        seen,
        receptors=True,
        full_scale=0.4,
        titles=["What is there", f"Honeybee worker, {len(eye) // 2:,} ommatidia"],
        title=f"The lit meadow at {name}; 1 is white matt ground",
    )


def main() -> None:
    world = omma.World(
        omma.load_scene(omma.examples.lit_meadow()), light=LIGHTS["overcast"], lighting="path"
    )
    eye = omma.species.honeybee_worker().eye
    cameras(world, eye)
    through_the_eye(world, eye)


if __name__ == "__main__":
    main()
