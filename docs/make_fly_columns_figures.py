"""Makes the figures of docs/fly-columns.md, and prints its numbers.

.venv/bin/python docs/make_fly_columns_figures.py [folder]

fly-columns-angles.png: interommatidial angles of the measured fly over its two eyes, and how they
are distributed. fly-columns-looming.png: one dark disc as it grows, seen by the columns of the
measured fly, by the modelled fly and by FlyGym's 721 hexagons, FlyGym's way (bench/fly_retina.py).
A minute on two cores.
"""

import sys
from pathlib import Path

import matplotlib
import numpy as np

import omma
from omma.picture.map_projections import project_directions

matplotlib.use("Agg")
ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "bench"))
import fly_retina  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402

STEPS = [(1, 0), (0, 1), (1, 1), (-1, 0), (0, -1), (-1, -1)]
DISC_DEG = (60.0, 15.0)  # azimuth and elevation, in all three fields
SIZES_DEG = (3.0, 5.0, 10.0, 20.0, 40.0, 80.0)
SHOWN_DEG = (5.0, 20.0, 60.0)
DARK, BRIGHT = 0.0, 1.0
# The eyes' cameras in FlyGym's vision.yaml: turned by 0.47 rad from straight to the side to the
# front (Euler angles about fixed axes), level.
FLYGYM_AZIMUTH_DEG = 90 - np.degrees(0.47)


def mean_angles_deg(columns):
    """Mean angle to the six neighbours of each column that has them, else NaN: (M,)."""
    keys = list(zip(columns.side.tolist(), columns.p.tolist(), columns.q.tolist()))
    row = {key: k for k, key in enumerate(keys)}
    found = np.full(len(keys), np.nan)
    for k, (side, p, q) in enumerate(keys):
        near = [row.get((side, p + a, q + b), -1) for a, b in STEPS]
        if min(near) >= 0:
            chord = np.linalg.norm(columns.axis[near] - columns.axis[k], axis=1)
            found[k] = np.degrees(2 * np.arcsin(chord / 2)).mean()
    return found


def mollweide(axis):
    """Mollweide's map (K, 2), ahead in the middle, the right on the right; 90° is 1 wide."""
    return project_directions(axis, "mollweide") / np.sqrt(2)


def draw_grid(panel):
    for azimuth in range(-180, 181, 30):
        line = omma.eye.direction(np.full(91, float(azimuth)), np.linspace(-89.9, 89.9, 91))
        line[:, 0] += 1e-9 * np.sign(azimuth)
        panel.plot(*mollweide(line).T, color="0.85", lw=0.6, zorder=0)
    for elevation in range(-60, 61, 30):
        line = omma.eye.direction(np.linspace(-179.9, 179.9, 181), np.full(181, float(elevation)))
        panel.plot(*mollweide(line).T, color="0.85", lw=0.6, zorder=0)
    panel.set(aspect="equal", xticks=[], yticks=[])
    panel.set_frame_on(False)


def draw_angles(path, columns):
    angle = mean_angles_deg(columns)
    figure, (panel, counts) = plt.subplots(
        1, 2, figsize=(12.5, 4.6), layout="constrained", width_ratios=(2.6, 1)
    )
    draw_grid(panel)
    place = mollweide(columns.axis)
    rim = np.isnan(angle)
    panel.scatter(*place[rim].T, s=7, color="0.6", zorder=1)
    dots = panel.scatter(
        *place[~rim].T, c=angle[~rim], s=15, cmap="viridis_r", vmin=3.5, vmax=8, zorder=2
    )
    equator = np.isin(columns.p + columns.q, (0, -1))
    panel.scatter(*place[equator].T, s=26, facecolors="none", edgecolors="black", lw=0.5, zorder=3)
    panel.set_title(
        "Interommatidial angle Δφ (mean of six); rings: the equator's rows; grey: the rim",
        fontsize=10,
    )
    figure.colorbar(dots, ax=panel, shrink=0.7, label="degrees", extend="max")
    bins = np.arange(3, 10.1, 0.25)
    for side, name, colour in ((-1, "left", "#d55e00"), (1, "right", "#0072b2")):
        mine = angle[(columns.side == side) & ~rim]
        counts.hist(mine, bins, histtype="step", lw=1.6, color=colour, label=f"{name}, {len(mine)}")
        counts.axvline(np.median(mine), color=colour, lw=0.8, ls="--")
    model = omma.species.drosophila().eye
    spread = np.degrees(model.interommatidial_angle_rad()) / 1.0
    counts.hist(
        spread, bins, weights=np.full(len(spread), 0.5), histtype="step", color="0.5", lw=1.2,
        label="modelled fly, an eye",
    )  # fmt: skip
    counts.set(xlabel="Δφ, degrees (dashed: medians)", ylabel="ommatidia")
    counts.legend(fontsize=8, frameon=False)
    figure.savefig(path, dpi=110)
    azimuth, elevation = omma.eye.azimuth_elevation_deg_of(columns.axis)
    lateral = azimuth * columns.side
    level, ahead = np.abs(elevation) < 30, (np.abs(azimuth) < 40) & (np.abs(elevation) < 20)
    for side, name in ((-1, "left"), (1, "right")):
        mine = columns.side == side
        inner = mine & ~rim
        low, middle, high = np.percentile(angle[inner], (5, 50, 95))
        print(
            f"{name}: {mine.sum()} columns, {inner.sum()} with six neighbours; Δφ {middle:.2f} "
            f"({low:.2f} to {high:.2f}), in front {np.median(angle[inner & ahead]):.2f}; azimuth "
            f"{lateral[mine & level].min():.1f} to {lateral[mine & level].max():.1f}, elevation "
            f"{elevation[mine].min():.1f} to {elevation[mine].max():.1f}"
        )


class Flygym:
    """The right eye of FlyGym: where its hexagons look, and what they take of a disc."""

    def __init__(self):
        self.ids = fly_retina.hexagonal_map()
        camera = omma.mujoco.fly_eye(self.ids)
        turn = omma.look_at((0, 0, 0), omma.eye.direction(FLYGYM_AZIMUTH_DEG, 0))[:3, :3]
        self.axis = camera.axis.astype(float) @ turn.T
        self.spacing_deg = np.degrees(camera.interommatidial_angle_rad())
        half = np.tan(np.radians(fly_retina.FOVY_DEG) / 2)
        fine = 3  # rays across a pixel of its picture
        rows, columns = (n * fine for n in (fly_retina.ROWS, fly_retina.COLUMNS))
        y, x = np.mgrid[:rows, :columns].astype(float) + 0.5
        across = half * fly_retina.COLUMNS / fly_retina.ROWS
        ray = np.stack(
            [across * (2 * x / columns - 1), half * (1 - 2 * y / rows), -np.ones_like(x)], -1
        )
        self.cosine = (ray / np.linalg.norm(ray, axis=-1, keepdims=True)) @ (
            turn.T @ omma.eye.direction(*DISC_DEG)
        )
        self.fine = fine

    def seen(self, size_deg):
        light = np.where(self.cosine > np.cos(np.radians(size_deg / 2)), DARK, BRIGHT)
        rows, columns = fly_retina.ROWS, fly_retina.COLUMNS
        light = light.reshape(rows, self.fine, columns, self.fine).mean(axis=(1, 3))
        return fly_retina.pooled(np.rint(255 * light) / 255, self.ids)


def flies():
    """For each of three: name, axes (N, 3) of the right eye, spacing (N,), and what it sees."""
    disc = omma.stimuli.LoomingDisc(
        l_over_v_s=0.05, collision_s=0.0, largest_deg=170.0, azimuth_deg=DISC_DEG[0],
        elevation_deg=DISC_DEG[1], disc=DARK, background=BRIGHT,
    )  # fmt: skip
    world = disc.world()

    def place(size_deg):
        disc.move(world, -disc.l_over_v_s / np.tan(np.radians(size_deg / 2)))

    columns = omma.columns.fly_columns()
    right = np.flatnonzero(columns.side > 0)
    measured = omma.columns.ColumnRenderer(world, sampling=omma.Fixed(256))
    white = omma.columns.photoreceptor_table(
        omma.Scene(background=omma.Background.constant([BRIGHT] * 3)), np.eye(4)
    ).r1_6[0, right]
    model = omma.species.drosophila().eye
    model = model.take(np.flatnonzero(model.eye_id == 1))
    plain = omma.Renderer(world, model, omma.Fixed(1024))
    flygym = Flygym()

    def by_columns(size_deg):
        place(size_deg)
        return measured.render(np.eye(4)).r1_6[0, right] / white

    def by_model(size_deg):
        place(size_deg)
        return plain.render(np.eye(4))[0, :, 1]

    own = columns.chosen(right)
    model_spacing = np.degrees(model.interommatidial_angle_rad())
    return (
        ("measured fly, R1–6", own.axis, mean_angles_deg(own), by_columns),
        ("modelled fly", model.axis.astype(float), model_spacing, by_model),
        ("FlyGym's hexagons", flygym.axis, flygym.spacing_deg, flygym.seen),
    )


def shares_sr(axis):
    """The share of the sphere that each axis is the nearest to, within its field: (N,)."""
    from scipy.spatial import cKDTree

    count = 400_000
    z = 1 - 2 * (np.arange(count) + 0.5) / count
    turn = np.pi * (1 + 5**0.5) * np.arange(count)
    level = np.sqrt(1 - z**2)
    points = np.stack([level * np.cos(turn), z, level * np.sin(turn)], axis=1)
    chord, nearest = cKDTree(axis).query(points)
    # What lies further from all axes than neighbours are apart is outside of the field.
    apart = cKDTree(axis).query(axis, 2)[0][:, 1]
    inside = chord < 0.75 * np.median(apart)
    return np.bincount(nearest[inside], minlength=len(axis)) * 4 * np.pi / count


def size_told_deg(darkness, share):
    """The disc whose solid angle the darkness of all ommatidia adds up to."""
    solid = np.sum(darkness * share)
    return np.degrees(2 * np.arccos(1 - min(solid / (2 * np.pi), 1)))


def draw_looming(path, three):
    figure, panels = plt.subplots(3, len(SHOWN_DEG), figsize=(10.5, 10.6), layout="constrained")
    middle = omma.eye.direction(*DISC_DEG)
    right = np.cross(middle, (0, 1, 0))
    right /= np.linalg.norm(right)
    up = np.cross(right, middle)
    for row, (name, axis, _, seen) in zip(panels, three):
        # Lambert's equal-area map around the disc.
        along = axis @ middle
        place = np.stack([axis @ right, axis @ up], 1) * np.sqrt(2 / (1 + along))[:, None]
        for panel, size in zip(row, SHOWN_DEG):
            panel.scatter(*place.T, c=seen(size), s=22, cmap="gray", vmin=0, vmax=1,
                          edgecolors="0.75", linewidths=0.3)  # fmt: skip
            edge = 2 * np.sin(np.radians(size / 4))
            turn = np.linspace(0, 2 * np.pi, 200)
            panel.plot(edge * np.cos(turn), edge * np.sin(turn), color="#d55e00", lw=1)
            panel.set(aspect="equal", xlim=(-0.85, 0.85), ylim=(-0.85, 0.85), xticks=[], yticks=[])
        row[0].set_ylabel(name)
    for panel, size in zip(panels[0], SHOWN_DEG):
        panel.set_title(f"disc of {size:g}°")
    figure.savefig(path, dpi=100)


def main():
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs"
    draw_angles(folder / "fly-columns-angles.png", omma.columns.fly_columns())
    three = flies()
    draw_looming(folder / "fly-columns-looming.png", three)
    for name, axis, spacing, seen in three:
        share = shares_sr(axis)
        near = np.arccos(np.clip(axis @ omma.eye.direction(*DISC_DEG), -1, 1)) < np.radians(40)
        azimuth, elevation = omma.eye.azimuth_elevation_deg_of(axis)
        level = np.abs(elevation) < 30
        print(
            f"{name}: {len(axis)} in {share.sum():.2f} sr, azimuth {azimuth[level].min():.0f} to "
            f"{azimuth[level].max():.0f}, elevation {elevation.min():.0f} to {elevation.max():.0f},"
            f" spacing here {np.nanmedian(spacing[near]):.2f}°"
        )
        for size in SIZES_DEG:
            light = seen(size)
            print(
                f"  {size:4.0f}°: {np.sum(light < 0.5):3d} darker than half, darkest "
                f"{light.min():.2f}, adds up to {size_told_deg(1 - light, share):.1f}°"
            )
        sizes = np.arange(1.0, 20.01, 0.25)
        first = sizes[[seen(size).min() < 0.9 for size in sizes].index(True)]
        print(f"  one darker by a tenth from {first:.2f}° on")


if __name__ == "__main__":
    main()
