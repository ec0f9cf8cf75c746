"""A flower's ultraviolet guide: how far a bee can tell it from the petals, and man.

The flower is a buttercup's kind of bull's eye: yellow petals that reflect ultraviolet, and do not
at their inner ends (spectra: docs/materials.md; they still differ a little at 400 to 430 nm, which
is what people see of it here). It stands in daylight over a sward. Contrasts are those
of Vorobyev & Osorio 1998 (Proc R Soc B 265:351), limited by the noise of receptors: 1 is about the
threshold. Assumed, as recalled from there and from others, not read again:

- bee: a Weber fraction of 0.13 for one receptor, and as many receptors of each kind as a worker's
  ommatidium has in the mean (Wakakuwa et al. 2005); acceptance 2.6 degrees (Eheim & Wehner 1972).
- man: 0.02 for the long cones, and 1 short to 16 middle to 32 long ones; cones are pigments of
  Govardovskii's template with peaks at 420, 530 and 560 nm behind a lens that stops all below
  400 nm; acceptance 1 minute of arc.

python examples/python/flower_in_ultraviolet.py -o flower_in_ultraviolet.png
"""

import argparse

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection

import omma

RADIUS_M = 0.012
GUIDE = 0.6  # of the radius
DISTANCES_M = (0.02, 0.04, 0.08, 0.12, 0.18, 0.25, 0.4, 0.7)
SHOWN_M = (0.04, 0.12, 0.25)
TILT_DEG = 50  # of the line of sight, from the ground
NM = np.arange(300.0, 701.0)


def flower():
    """Five petals 0.3 m above a sward, facing the eye, each with a guide at its foot."""
    around = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    edge = RADIUS_M * (0.72 + 0.28 * np.abs(np.sin(2.5 * around)) ** 0.6)
    up, _ = _facing()
    right = np.array([1.0, 0.0, 0.0])
    rim = np.cos(around)[:, None] * right + np.sin(around)[:, None] * up
    centre = np.array([[0, 0.3, 0.0]])
    inner, outer = (centre + share * edge[:, None] * rim for share in (GUIDE, 1.0))
    here, there = np.arange(200), (np.arange(200) + 1) % 200
    fan = np.stack([0 * here, 1 + here, 1 + there], axis=1)
    ring = np.concatenate(
        [np.stack([here, 200 + here, 200 + there], 1), np.stack([here, 200 + there, there], 1)]
    )
    ground = [[-9, 0, 9], [9, 0, 9], [9, 0, -9], [-9, 0, -9]]
    names = ("yellow petal", "yellow petal with ultraviolet", "green sward")
    return omma.Scene(
        meshes=[
            omma.scene.Mesh(np.concatenate([centre, inner]), fan, material=0),
            omma.scene.Mesh(np.concatenate([inner, outer]), ring, material=1),
            omma.scene.Mesh(ground, [[0, 1, 2], [0, 2, 3]], material=2),
        ],
        materials=[omma.scene.natural_material(name) for name in names],
    )


def _facing():
    """Up along the flower, and its normal, towards the eye."""
    tilt = np.radians(TILT_DEG)
    return np.array([0, np.cos(tilt), -np.sin(tilt)]), np.array([0, np.sin(tilt), np.cos(tilt)])


def pose(distance_m):
    up, out = _facing()
    centre = np.array([0, 0.3, 0.0])
    return omma.look_at(centre + distance_m * out, centre, up)


def bee():
    """Receptor types, and the noise of each kind: (3,)."""
    kinds = omma.receptors.honeybee_ommatidia()
    types = tuple(dict.fromkeys(one for kind in kinds for one in kind.receptors))
    share = np.array([kind.abundance for kind in kinds]) / sum(kind.abundance for kind in kinds)
    number = [sum(s * k.receptors.count(one) for s, k in zip(share, kinds)) for one in types]
    return types, 0.13 / np.sqrt(number)


def man():
    """The same of people: cones behind a lens."""
    through_lens = (NM >= 400).astype(float)
    types = tuple(
        omma.receptors.ReceptorType(
            name,
            wavelength_nm=NM,
            sensitivity=through_lens * omma.receptors.govardovskii(peak, NM),
        )
        for name, peak in (("short", 420.0), ("middle", 530.0), ("long", 560.0))
    )
    return types, 0.02 * np.sqrt(32 / np.array([1, 16, 32]))


def contrast(first, second, noise):
    """Distance of two colours (..., 3) in just noticeable differences, by Vorobyev & Osorio's
    equation for three receptors whose signals are the logarithms of catches."""
    d = np.log(first) - np.log(second)
    e = np.asarray(noise)
    above = (
        e[0] ** 2 * (d[..., 2] - d[..., 1]) ** 2
        + e[1] ** 2 * (d[..., 2] - d[..., 0]) ** 2
        + e[2] ** 2 * (d[..., 0] - d[..., 1]) ** 2
    )
    return np.sqrt(above / ((e[0] * e[1]) ** 2 + (e[0] * e[2]) ** 2 + (e[1] * e[2]) ** 2))


def looking(distance_m, acceptance_rad):
    """An eye of three: at the guide, at the petals beside it, and at the sward next to the flower,
    for a petal's length along its middle."""
    off = np.arctan2(RADIUS_M * np.array([0, 0.8, 2.5]), distance_m)
    angle = np.radians(18)  # the middle of a petal
    axis = np.column_stack([np.sin(off) * np.cos(angle), np.sin(off) * np.sin(angle), -np.cos(off)])
    return omma.Eye(np.zeros((3, 3)), axis, acceptance_angle_rad=np.full(3, acceptance_rad))


ANIMALS = {"bee": (bee, np.radians(2.6)), "man": (man, np.radians(1 / 60))}


def contrasts(world, distances=DISTANCES_M, rays=4096):
    """{animal: (distances, 2)}: of the guide to the petals, and of the petals to the sward."""
    found = {}
    for name, (make, acceptance) in ANIMALS.items():
        types, noise = make()
        matrix = omma.receptors.receptor_matrix(types, bands=world.light.bands)
        rows = []
        for distance in distances:
            renderer = omma.Renderer(world, looking(distance, acceptance), omma.Fixed(rays))
            guide, petal, sward = renderer.render(pose(distance))[0] @ matrix.T
            rows.append([contrast(guide, petal, noise), contrast(petal, sward, noise)])
        found[name] = np.array(rows)
    return found


def hexagons(width_deg, step_deg=1.4):
    """Middles (N, 2), degrees, of a hexagonal lattice around straight ahead; outlines (N, 6, 2)."""
    half = int(np.ceil(width_deg / 2 / step_deg)) + 1
    column, row = np.meshgrid(np.arange(-half, half + 1), np.arange(-half - 2, half + 3))
    at = step_deg * np.stack([column + row % 2 / 2, row * np.sqrt(0.75)], axis=-1).reshape(-1, 2)
    corner = np.radians(30 + 60 * np.arange(6))
    outline = step_deg / np.sqrt(3) * np.stack([np.cos(corner), np.sin(corner)], axis=-1)
    return at, at[:, None] + outline


def false_colours(radiance, light):
    """A bee's green, blue and ultraviolet as red, green and blue; half of white ground is 1."""
    matrix = omma.receptors.receptor_matrix(bee()[0], bands=light.bands)
    white = matrix @ sum(light.irradiance()) / np.pi
    return np.clip((radiance @ matrix.T / white)[..., ::-1] / 0.5, 0, 1) ** (1 / 2.2)


def draw(path, world, found, samples):
    figure, panels = plt.subplots(2, 3, figsize=(10.5, 6.6), layout="constrained")
    camera = omma.scene.Camera(
        world_from_camera=pose(0.045), yfov_rad=np.radians(40), aspect_ratio=1.0
    )
    light = world.light
    picture = omma.render_camera(world, camera, width=220, height=220, samples=samples)
    rgb = np.clip(omma.picture.bands_to_rgb(picture, light) / 0.5, 0, 1) ** (1 / 2.2)
    panels[0, 0].imshow(rgb)
    panels[0, 0].set_title("as people see it", fontsize=10)
    panels[0, 1].imshow(false_colours(picture, light))
    panels[0, 1].set_title("green, blue, ultraviolet as red, green, blue", fontsize=10)
    for panel, distance in zip((panels[0, 2], panels[1, 0], panels[1, 1]), SHOWN_M):
        width = max(12.0, 1.5 * np.degrees(2 * np.arctan(RADIUS_M / distance)))
        at, outlines = hexagons(width)
        acceptance = np.full(len(at), ANIMALS["bee"][1])
        axis = omma.eye.direction(*at.T)
        eye = omma.Eye(np.zeros_like(axis), axis, acceptance_angle_rad=acceptance)
        seen = omma.Renderer(world, eye, omma.Fixed(256)).render(pose(distance))[0]
        colours = false_colours(seen, light)
        panel.add_collection(PolyCollection(outlines, facecolor=colours, lw=0, antialiased=False))
        panel.set(xlim=(-width / 2, width / 2), ylim=(-width / 2, width / 2), aspect="equal")
        panel.set_title(f"by a bee's ommatidia, {100 * distance:.0f} cm away", fontsize=10)
        panel.set_xlabel(f"{width:.0f}° across", fontsize=9)
    for panel in panels.ravel()[:5]:
        panel.set_xticks([])
        panel.set_yticks([])
        panel.spines[:].set_visible(False)
    curves = panels[1, 2]
    for name, colour in (("bee", "#b8860b"), ("man", "#3b5bdb")):
        curves.loglog(100 * np.array(DISTANCES_M), found[name][:, 0], "o-", ms=4, color=colour,
                      label=f"{name}: guide, petals")  # fmt: skip
        curves.loglog(100 * np.array(DISTANCES_M), found[name][:, 1], "--", lw=1, color=colour,
                      label=f"{name}: petals, sward")  # fmt: skip
    curves.axhline(1, color="0.6", lw=0.8)
    curves.set(xlabel="distance, cm", ylim=(0.1, 100))
    curves.set_xticks([2, 5, 10, 20, 50], ["2", "5", "10", "20", "50"])
    curves.minorticks_off()
    curves.set_title("contrast, just noticeable differences", fontsize=10)
    curves.spines[["top", "right"]].set_visible(False)
    curves.legend(frameon=False, fontsize=8)
    figure.savefig(path, dpi=130)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument(
        "-o", "--output", default="flower_in_ultraviolet.png", help="the figure to write"
    )
    parser.add_argument("--rays", type=int, default=4096, help="for a contrast (default: 4096)")
    parser.add_argument("--samples", type=int, default=32, help="for a pixel (default: 32)")
    asked = parser.parse_args()
    world = omma.World(flower(), light=omma.light.clear_sky(50, sun_azimuth_deg=60), depth=4)
    found = contrasts(world, rays=asked.rays)
    print("contrast in just noticeable differences: of guide and petals, of petals and sward")
    print("distance            bee             man")
    for k, distance in enumerate(DISTANCES_M):
        cells = "".join(f"{one[k, 0]:8.2f}{one[k, 1]:8.2f}" for one in found.values())
        print(f"{100 * distance:5.0f} cm   {cells}")
    draw(asked.output, world, found, asked.samples)
    print(f"wrote {asked.output}")


if __name__ == "__main__":
    main()
