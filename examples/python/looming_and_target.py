"""A blowfly stands before grass; a small target passes, and a disc looms. What moves, and where to?

Every pair of neighbours in the fly's two eyes feeds a motion detector after Hassenstein and
Reichardt (docs/motion-detection.md); the outputs around an ommatidium make a local motion vector.
The target, 2.3° across, passes on the right from the front to the back; the disc comes from the
left at constant speed, its half size over its speed 50 ms. The fly does not move, so that nothing
else does. Time constants are of the size found in flies, and chosen here: 35 ms for the delay, 250
ms for the high-pass that takes away the standing light. There are no photoreceptors in it: light
comes without delay, and twice the light gives four times the output, here over the scene's mean.

python examples/python/looming_and_target.py -o looming_and_target.png
"""

import argparse

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import hsv_to_rgb
from matplotlib.patches import Ellipse
from matplotlib.patheffects import withStroke
from matplotlib.projections.geo import MollweideAxes

import omma

FLY_M = np.array([0.1, 0.9, 4.7])  # looks along -Z, over the meadow
RATE_HZ, DURATION_S = 250.0, 0.84
TAU_S, HIGH_PASS_TAU_S = 0.035, 0.25
# The disc: where it comes from, and when it would be there.
DISC_AT = omma.eye.direction(-35.0, -8.0)
DISC_RADIUS_M, DISC_SPEED_M_S, COLLISION_S = 0.1, 2.0, 0.95
# The target: from one azimuth to another on a circle about the fly.
TARGET_RADIUS_M, TARGET_AWAY_M, TARGET_ELEVATION_DEG = 0.012, 0.6, -8.0
TARGET_FROM_DEG, TARGET_DEG_S = 15.0, 150.0
SHOWN_S = (0.3, 0.76)  # the moments that are drawn


def disc_distance_m(time_s):
    return DISC_SPEED_M_S * (COLLISION_S - time_s)


def target_direction(time_s):
    return omma.eye.direction(TARGET_FROM_DEG + TARGET_DEG_S * time_s, TARGET_ELEVATION_DEG)


def meadow_with_both():
    dark = (0.01, 0.01, 0.01)
    return omma.scene.merge_scenes(
        [
            omma.load_scene(omma.examples.meadow()),
            omma.scene.disc(DISC_RADIUS_M, dark, facing=-DISC_AT, name="disc"),
            omma.scene.sphere(TARGET_RADIUS_M, dark, segments=24, name="target"),
        ]
    )


def places(time_s):
    """``world_from_node`` (2, 4, 4) of the disc and the target."""
    found = np.tile(np.eye(4), (2, 1, 1))
    found[0, :3, 3] = FLY_M + disc_distance_m(time_s) * DISC_AT
    found[1, :3, 3] = FLY_M + TARGET_AWAY_M * target_direction(time_s)
    return found


def watch(eye, rays=16):
    """Times (T,), light (T, N) and motion vectors (T, N, 2), both over the scene's mean light."""
    renderer = omma.Renderer(meadow_with_both(), eye, omma.Fixed(rays))
    detectors = omma.motion.detector_array(eye, TAU_S, RATE_HZ, high_pass_tau_s=HIGH_PASS_TAU_S)
    pose = np.eye(4)
    pose[:3, 3] = FLY_M
    times_s = np.arange(round(DURATION_S * RATE_HZ)) / RATE_HZ
    light, vectors = np.empty((len(times_s), len(eye))), np.empty((len(times_s), len(eye), 2))
    state, mean = None, None
    for t, time_s in enumerate(times_s):
        renderer.world.set_transforms(["disc", "target"], places(time_s))
        green = renderer.render(pose)[0, :, 1].astype(float)
        mean = green.mean() if mean is None else mean
        light[t] = green / mean
        state, outputs = detectors.step(state, light[t])
        vectors[t] = detectors.vectors(outputs)
    return times_s, light, vectors


def in_space(eye, vectors):
    """Motion vectors (..., N, 2) of ommatidia as vectors of the head's frame (..., N, 3)."""
    return vectors[..., :1] * eye.right.astype(float) + vectors[..., 1:] * eye.up.astype(float)


def rightward(eye, vectors):
    """The mean motion (T,) to the right, of ommatidia within 3° of the target's elevation on the
    right."""
    azimuth, elevation = omma.eye.azimuth_elevation_deg_of(eye.axis)
    near = (np.abs(elevation - TARGET_ELEVATION_DEG) < 3) & (azimuth > 10) & (azimuth < 150)
    near &= np.isfinite(vectors[0, :, 0])
    right = np.stack([np.cos(np.radians(azimuth)), 0 * azimuth, np.sin(np.radians(azimuth))], 1)
    return np.einsum("tnk,nk->tn", in_space(eye, vectors), right)[:, near].mean(axis=1)


def on_map(directions):
    """Places (..., 2) of directions (..., 3) on Mollweide's map."""
    azimuth, elevation = np.radians(omma.eye.azimuth_elevation_deg_of(directions))
    flat = np.stack([azimuth.ravel(), elevation.ravel()], axis=1)
    return MollweideAxes.MollweideTransform(60).transform(flat).reshape(*azimuth.shape, 2)


def flat(azimuth_deg, elevation_deg):
    """The same of angles (K,), degrees."""
    angles = np.radians(np.broadcast_arrays(azimuth_deg, elevation_deg)).T
    return MollweideAxes.MollweideTransform(60).transform(angles)


def around(direction, radius_deg):
    """A circle around a direction, on the map."""
    right = np.cross(direction, (0.0, 1.0, 0.0))
    right /= np.linalg.norm(right)
    turn = np.linspace(0, 2 * np.pi, 60)[:, None]
    across = np.cos(turn) * right + np.sin(turn) * np.cross(right, direction)
    radius = np.radians(radius_deg)
    return on_map(np.cos(radius) * direction + np.sin(radius) * across)


def draw_map(panel, eye, light, vectors, largest, time_s, *, longest, dot):
    """The whole map; ``longest`` is an arrow's length on it, ``dot`` an ommatidium's area."""
    for elevation in range(-60, 61, 30):
        panel.plot(*flat(np.arange(-180, 181, 3), elevation).T, color="0.85", lw=0.5)
    for azimuth in range(-120, 121, 60):
        panel.plot(*flat(azimuth, np.arange(-90, 91, 3)).T, color="0.85", lw=0.5)
    panel.add_patch(Ellipse((0, 0), 4 * 2**0.5, 2 * 2**0.5, fill=False, ec="0.6", lw=0.8))
    degrees = {"fontsize": 7, "color": "0.1", "clip_on": True, "zorder": 5,
               "path_effects": [withStroke(linewidth=2, foreground="w")]}  # fmt: skip
    for azimuth in (-120, -60, 0, 60, 120):
        at = flat(np.array([azimuth]), -2.0)[0]
        panel.text(*at, f"{azimuth}°" if azimuth else "ahead 0°", ha="center", va="top", **degrees)
    for elevation in (-60, -30, 30, 60):
        at = flat(np.array([-180]), elevation)[0]
        panel.text(*at, f"{elevation}°  ", ha="right", va="center", **degrees)
    shade = np.clip(light / 2, 0, 1) ** (1 / 2.2)
    panel.scatter(*on_map(eye.axis).T, c=shade, s=dot, lw=0, cmap="gray", vmin=-0.2, vmax=1.15)
    size = np.hypot(*vectors.T)
    shown = np.flatnonzero(size > 0.005 * largest)  # NaN are not
    way = in_space(eye, vectors)[shown] / size[shown, None]
    # The root, so that small arrows are seen beside large ones.
    length = np.clip(np.sqrt(size[shown] / largest), 0.2, 1.0)
    start = on_map(eye.axis[shown])
    ahead = on_map(eye.axis[shown] + 1e-3 * way) - start
    ahead *= (longest * length / np.hypot(*ahead.T))[:, None]
    hue = np.arctan2(*ahead.T[::-1]) / (2 * np.pi) % 1
    colour = hsv_to_rgb(np.stack([hue, np.ones(len(hue)), np.full(len(hue), 0.85)], axis=1))
    panel.quiver(*start.T, *ahead.T, color=colour, angles="xy", scale_units="xy", scale=1,
                 units="inches", width=0.014, headwidth=5)  # fmt: skip
    for direction, radius in ((DISC_AT, disc_radius_deg(time_s)), (target_direction(time_s), 4.0)):
        panel.plot(*around(direction, radius).T, color="k", lw=0.8, ls=":")
    panel.set_aspect("equal")
    panel.set(xlim=(-2.85, 2.85), ylim=(-1.45, 1.45), xticks=[], yticks=[])


def disc_radius_deg(time_s):
    return np.degrees(np.arctan(DISC_RADIUS_M / disc_distance_m(time_s)))


def draw_course(panel, times_s, motion, colour, label, angle_deg, angle_label, title):
    panel.plot(times_s, 1e3 * motion, color=colour)
    panel.axhline(0, color="0.7", lw=0.8)
    panel.set(xlabel="time, s", xlim=(0, DURATION_S))
    panel.set_ylabel(f"{label}, 10⁻³", color=colour)
    panel.set_title(title, fontsize=10)
    for moment in SHOWN_S:
        panel.axvline(moment, color="0.85", lw=0.8, zorder=0)
    beside = panel.twinx()
    beside.plot(times_s, angle_deg, "--", color="0.45", lw=1)
    beside.set_ylabel(f"{angle_label} (dashed)", color="0.35")
    beside.set_ylim(0, None)
    for one in (panel, beside):
        one.spines["top"].set_visible(False)


def draw(path, eye, times_s, light, vectors):
    figure = plt.figure(figsize=(13, 10.4), layout="constrained")
    above, below = figure.subfigures(2, 1, height_ratios=(2.1, 1))
    largest = np.nanquantile(np.hypot(*np.moveaxis(vectors, -1, 0)), 0.9995)
    panels = above.subplots(2, 3, width_ratios=(2.1, 1, 1))
    for (whole, disc, target), moment in zip(panels, SHOWN_S):
        t = round(moment * RATE_HZ)
        seen = eye, light[t], vectors[t], largest, times_s[t]
        draw_map(whole, *seen, longest=0.1, dot=4)
        whole.axis("off")
        whole.set_title(f"{times_s[t]:.2f} s", fontsize=10)
        azimuth = TARGET_FROM_DEG + TARGET_DEG_S * times_s[t]
        for panel, direction, half, title in (
            (disc, DISC_AT, 0.42, f"the disc, {2 * disc_radius_deg(times_s[t]):.0f}° across"),
            (target, target_direction(times_s[t]), 0.21, f"the target, at {azimuth:.0f}°"),
        ):
            draw_map(panel, *seen, longest=0.11 * half / 0.42, dot=16 * (0.42 / half) ** 2)
            x, y = on_map(direction)
            panel.set(xlim=(x - half, x + half), ylim=(y - half, y + half))
            panel.set_title(title, fontsize=10)
    left, right = below.subplots(1, 2)
    draw_course(
        left, times_s, omma.motion.expansion(eye, vectors, DISC_AT), "#0072b2",
        "mean motion away from its middle",
        2 * disc_radius_deg(times_s), "angle across, °", "The disc: ommatidia within 30° of it",
    )  # fmt: skip
    draw_course(
        right, times_s, rightward(eye, vectors), "#d55e00", "mean motion to the right",
        TARGET_FROM_DEG + TARGET_DEG_S * times_s, "azimuth, °",
        "The target: ommatidia within 3° of its elevation",
    )  # fmt: skip
    figure.suptitle(
        f"What a fly's {len(eye):,} ommatidia see, and their local motion vectors (length: the "
        "root of the output; hue: direction)", fontsize=11,
    )  # fmt: skip
    figure.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", default="looming_and_target.png", help="the figure")
    parser.add_argument("--rays", type=int, default=16, help="for each ommatidium (default: 16)")
    asked = parser.parse_args()
    eye = omma.species.calliphora().eye
    times_s, light, vectors = watch(eye, asked.rays)
    looming = omma.motion.expansion(eye, vectors, DISC_AT)
    passing = rightward(eye, vectors)
    print(f"{len(eye):,} ommatidia, {len(times_s)} frames at {RATE_HZ:.0f} Hz")
    print("time, s   away from the disc's middle   right along the target's way")
    for moment in (0.1, 0.3, 0.5, 0.7, 0.8):
        t = round(moment * RATE_HZ)
        print(f"{times_s[t]:7.2f}   {looming[t]:27.2e}   {passing[t]:28.2e}")
    cells = omma.motion.looming_cells(eye)
    t = round(0.7 * RATE_HZ)
    strongest = cells.center[np.nanargmax(cells.responses(vectors[t]))]
    off_deg = np.degrees(np.arccos(strongest @ DISC_AT))
    print(
        f"of {len(cells)} cells like LPLC2 the strongest at {times_s[t]:.2f} s looks "
        f"{off_deg:.0f}° beside the disc's middle"
    )
    draw(asked.output, eye, times_s, light, vectors)
    print(f"wrote {asked.output}")


if __name__ == "__main__":
    main()
