"""Where is water? The degree and angle of polarisation at the pond of the lit meadow.

Light that water reflects is polarised level with it, most of all at Brewster's angle, 53 degrees
from straight down. Backswimmers find ponds by that, with ultraviolet receptors whose microvilli lie
level and upright (Schwind 1983, Cell Tissue Res 232:53; 1984, J Comp Physiol A 155:319). Here an
insect hangs a metre above the water near the bank. The meadow there is a sward, which counts as
matt (docs/materials.md); shining leaves would be polarised too. As in imaging polarimetry (Horváth
& Varjú 2004, Polarized Light in Animal Vision, Springer) a direction counts as water where light is
polarised to more than 15 % and within 10 degrees of level: thresholds chosen here, no animal's.

python examples/python/waters_edge.py -o waters_edge.png
"""

import argparse

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm

import omma

LIGHTS = ("clear", "overcast")
SUN_ELEVATION_DEG, SUN_AZIMUTH_DEG = 35.0, 200.0
ABOVE_WATER_M = 1.0
WIDEST_DEG = 75.0  # of directions, from straight down
DEGREE, OFF_LEVEL_DEG = 0.15, 10.0
LEAST_DEGREE = 0.02  # below it there is no angle to draw
BREWSTER_DEG = np.degrees(np.arctan(1.333))


def ventral_eye(count=1500, acceptance_deg=2.5):
    """Ommatidia spread evenly around straight down; their up vectors point to the zenith."""
    index = np.arange(count) + 0.5
    down = 1 - index / count * (1 - np.cos(np.radians(WIDEST_DEG)))
    azimuth = index * 180 * (3 - 5**0.5)
    axis = omma.eye.direction(azimuth, np.degrees(np.arccos(down)) - 90)
    return omma.Eye(
        np.zeros_like(axis), axis, acceptance_angle_rad=np.full(count, np.radians(acceptance_deg))
    )


def shore(scene):
    """The pond's outline (K, 2), x and z, and the height of its surface, metres."""
    pond = next(one for one in scene.instances if one.name == "pond")
    corners = scene.meshes[pond.mesh].positions_m
    corners = corners @ pond.world_from_mesh[:3, :3].T + pond.world_from_mesh[:3, 3]
    middle = corners.mean(axis=0)
    around = np.arctan2(corners[:, 2] - middle[2], corners[:, 0] - middle[0])
    away = np.hypot(corners[:, 2] - middle[2], corners[:, 0] - middle[0])
    outer = away > 0.5 * away.max()
    order = np.argsort(around[outer])
    return corners[outer][order][:, [0, 2]], middle[1]


def place(scene):
    """Over the water, a metre from the shore, on the side of the camera "pond"."""
    outline, level = shore(scene)
    camera = scene.camera("pond").world_from_camera[[0, 2], 3]
    nearest = outline[np.argmin(np.linalg.norm(outline - camera, axis=1))]
    inwards = outline.mean(axis=0) - nearest
    x, z = nearest + inwards / np.linalg.norm(inwards)
    return np.array([x, level + ABOVE_WATER_M, z])


def is_water(scene, eye, pose):
    """Whether most of what each ommatidium sees is water (N,): the one thing that shines, unlit."""
    materials = [
        one.replace(
            base_color=(0, 0, 0, one.base_color[3]), emissive=[float(one.name == "pond water")] * 3
        )
        for one in scene.materials
    ]
    dark = omma.Background.constant((0, 0, 0))
    shining = omma.World(scene.replace(materials=materials), background=dark)
    return omma.Renderer(shining, eye, omma.Fixed(64)).render(pose)[0, :, 0] > 0.5


def polarisation(stokes):
    """Degree (N,), and angle from level (N,), degrees, of Stokes vectors (N, 3)."""
    degree = np.hypot(stokes[:, 1], stokes[:, 2]) / stokes[:, 0]
    angle = np.degrees(np.arctan2(stokes[:, 2], stokes[:, 1])) / 2  # from up to the right
    return degree, (angle + 180) % 180 - 90


def look(eye, rays=128):
    """{light: Stokes vectors (N, 3)} at 340 to 380 nm, and which ommatidia see water."""
    scene = omma.load_scene(omma.examples.lit_meadow())
    pose = np.eye(4)
    pose[:3, 3] = place(scene)
    bands = omma.light.Bands.from_edges([340, 380])
    lights = {
        "clear": omma.light.clear_sky(
            SUN_ELEVATION_DEG, sun_azimuth_deg=SUN_AZIMUTH_DEG, bands=bands
        ),
        "overcast": omma.light.overcast_sky(SUN_ELEVATION_DEG, bands=bands),
    }
    # By paths: for one pose that is sooner done than baking.
    world = omma.World(scene, light=lights["clear"], polarized=True, lighting="path")
    found = {
        name: omma.Renderer(world.with_light(light), eye, omma.Fixed(rays)).render_stokes(pose)[0]
        for name, light in lights.items()
    }
    return {name: stokes[:, :, 0] for name, stokes in found.items()}, is_water(scene, eye, pose)


def taken_for_water(stokes):
    degree, off_level = polarisation(stokes)
    return (degree > DEGREE) & (np.abs(off_level) < OFF_LEVEL_DEG)


def from_down_deg(eye):
    return np.degrees(np.arccos(np.clip(-eye.axis[:, 1].astype(float), -1, 1)))


def disc(panel, eye, values, title, **colours):
    """Directions around straight down, ahead (north) up."""
    x, _, z = eye.axis.T.astype(float)
    drawn = panel.scatter(np.arctan2(x, -z), from_down_deg(eye), c=values, s=22, lw=0, **colours)
    panel.set_theta_zero_location("N")
    panel.set_theta_direction(-1)
    panel.set(rlim=(0, WIDEST_DEG), xticks=[], yticks=[])
    panel.set_title(title, fontsize=9.5)
    return drawn


def draw(path, eye, found, water):
    figure = plt.figure(figsize=(12.5, 6.2), layout="constrained")
    grid = figure.add_gridspec(2, 4, width_ratios=(1, 1, 1, 1.15))
    curves = figure.add_subplot(grid[:, 3])
    for row, (name, stokes) in enumerate(found.items()):
        degree, off_level = polarisation(stokes)
        panels = [figure.add_subplot(grid[row, k], projection="polar") for k in range(3)]
        norm = LogNorm(*np.quantile(stokes[:, 0], (0.02, 0.98)))
        drawn = disc(panels[0], eye, stokes[:, 0], f"{name}: radiance", cmap="gray", norm=norm)
        bar = figure.colorbar(drawn, ax=panels[0], shrink=0.7, pad=0.03, extend="both")
        bar.set_label("photons m⁻² s⁻¹ sr⁻¹ nm⁻¹", fontsize=7.5)
        drawn = disc(panels[1], eye, degree, "degree of polarisation", cmap="magma", vmin=0, vmax=1)
        figure.colorbar(drawn, ax=panels[1], shrink=0.7, pad=0.03)
        shown = np.where(degree > LEAST_DEGREE, off_level, np.nan)
        panels[2].set_facecolor("0.62")
        drawn = disc(panels[2], eye, shown, "electric vector, degrees from level",
                     cmap="twilight", vmin=-90, vmax=90)  # fmt: skip
        figure.colorbar(drawn, ax=panels[2], shrink=0.7, pad=0.03, ticks=[-90, 0, 90])
        outline = taken_for_water(stokes)
        x, _, z = eye.axis.T.astype(float)
        panels[1].scatter(np.arctan2(x, -z)[outline], from_down_deg(eye)[outline], s=22,
                          facecolor="none", edgecolor="#59d0ff", lw=0.4)  # fmt: skip
        for is_it, what, colour in ((water, "water", "#1764ab"), (~water, "meadow", "#5d9732")):
            angle, line = by_angle(eye, degree, is_it)
            curves.plot(angle, line, "-" if row == 0 else "--", color=colour,
                        label=f"{what}, {name}")  # fmt: skip
    curves.axvline(BREWSTER_DEG, color="0.7", lw=0.8)
    curves.text(BREWSTER_DEG + 1, 0.96, "Brewster's angle", fontsize=8, color="0.4")
    curves.set(xlabel="angle from straight down, degrees", ylim=(0, 1))
    curves.set_title("median degree of polarisation", fontsize=9.5)
    curves.spines[["top", "right"]].set_visible(False)
    curves.legend(frameon=False, fontsize=8.5, loc="upper left")
    figure.suptitle("340 to 380 nm, looking down near a bank; blue rings: taken for water; "
                    f"grey: less than {LEAST_DEGREE:.0%} polarised", fontsize=10.5)  # fmt: skip
    figure.savefig(path, dpi=120)


def by_angle(eye, degree, where, step=6.0):
    """Middles of classes of angle from straight down, and the median degree in each."""
    edges = np.arange(0, WIDEST_DEG + 1, step)
    angle = from_down_deg(eye)
    middles, medians = [], []
    for low, high in zip(edges[:-1], edges[1:]):
        inside = where & (angle >= low) & (angle < high)
        if inside.sum() >= 5:
            middles.append((low + high) / 2)
            medians.append(np.median(degree[inside]))
    return np.array(middles), np.array(medians)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", default="waters_edge.png", help="the figure to write")
    parser.add_argument("--rays", type=int, default=128, help="for each ommatidium (default: 128)")
    asked = parser.parse_args()
    eye = ventral_eye()
    found, water = look(eye, asked.rays)
    near = np.abs(from_down_deg(eye) - BREWSTER_DEG) < 8
    print("near Brewster's angle: the median degree of polarisation; and taken for water")
    print("sky          water         meadow")
    for name, stokes in found.items():
        degree, _ = polarisation(stokes)
        taken = taken_for_water(stokes)
        cells = "".join(
            f"{np.median(degree[near & one]):6.2f} {np.mean(taken[near & one]):6.0%} "
            for one in (water, ~water)
        )
        print(f"{name:9s} {cells}")
    draw(asked.output, eye, found, water)
    print(f"wrote {asked.output}")


if __name__ == "__main__":
    main()
