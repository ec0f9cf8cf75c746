"""A splat world beside the meadow that it was trained on, through a honeybee's eyes.

The splats are those of `train_splats.py`, or others of that place in the same frame. They hold no
sky, so both worlds have the meadow's. An ommatidium's relative difference is (splats - meadow) /
meadow, in linear light. Ommatidia are sorted into regions by where they look and by how far away
what they see of the meadow is. Both worlds are sampled by the same rays; (noise) is the rms of both
standard errors together, in green, relative to the meadow.

    python examples/python/train_splats.py -o meadow_splats.ply
    python examples/python/compare_splats.py meadow_splats.ply -o meadow_splats_bee.png
"""

import argparse
import math
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm

import omma

CAMERAS = ("bee", "bee-low")
NEAR_M, FAR_M = 1.0, 10.0
WIDTH, HEIGHT = 720, 360


def regions(renderer, pose):
    """{name: which ommatidia (N,)} by where they look and what they see of the meadow."""
    truth = renderer.ground_truth(pose)
    met, distance = truth.met[0], truth.distance_m[0]
    up = (renderer.eye.axis @ pose[:3, :3].T)[:, 1] / np.linalg.norm(pose[:3, 1])
    solid = met > 0.5
    return {
        "everywhere": np.ones(len(met), bool),
        "above the horizon": up > 0,
        "  sky alone": met == 0,
        "  with trees, flowers": (up > 0) & (met > 0),
        "below the horizon": up <= 0,
        f"nearer than {NEAR_M:g} m": solid & (distance < NEAR_M),
        f"{NEAR_M:g} to {FAR_M:g} m": solid & (distance >= NEAR_M) & (distance < FAR_M),
        f"farther than {FAR_M:g} m": solid & (distance >= FAR_M),
    }


def agreement(meadow, splats):
    """Of responses (n, bands): rms relative difference, correlation and ratio of means, by band."""
    relative = np.sqrt(np.mean(((splats - meadow) / meadow) ** 2, axis=0))
    off, other = meadow - meadow.mean(axis=0), splats - splats.mean(axis=0)
    spread = np.sqrt((off**2).sum(axis=0) * (other**2).sum(axis=0))
    correlation = (off * other).sum(axis=0) / np.maximum(spread, 1e-30)
    return relative, correlation, splats.mean(axis=0) / meadow.mean(axis=0)


def table(found, where, errors):
    """Lines of text: a row for each region, numbers of red, green and blue."""
    lines = [
        f"{'':22s}{'ommatidia':>10s}  {'rms relative difference':>24s}  "
        f"{'(noise)':>8s}  {'correlation':>18s}  {'ratio of means':>18s}"
    ]
    noise = np.sqrt(sum(error[:, 1] ** 2 for error in errors)) / found[0][:, 1]
    for name, which in where.items():
        if which.sum() < 2:
            lines.append(f"{name:22s}{which.sum():10d}")
            continue
        relative, correlation, ratio = agreement(*(one[which].astype(float) for one in found))
        lines.append(
            f"{name:22s}{which.sum():10d}  "
            + " ".join(f"{100 * value:6.1f} %" for value in relative)
            + f"  {100 * math.sqrt(np.mean(noise[which] ** 2)):6.1f} %  "
            + " ".join(f"{value:6.3f}" for value in correlation)
            + " "
            + " ".join(f"{value:6.3f}" for value in ratio)
        )
    return lines


def draw(path, eye, found, title):
    """The meadow, the splats, and the splats over the meadow, in green light."""
    figure, panels = plt.subplots(3, 1, figsize=(8, 13), layout="constrained")
    ids = omma.picture.field_ids(eye, WIDTH, HEIGHT)
    around = {"extent": (-180, 180, -90, 90), "interpolation": "nearest"}
    for panel, name, responses in zip(panels, ("the meadow", "the splats"), found):
        panel.imshow(omma.picture.paint(ids, responses), **around)
        panel.set_title(name)
    ratio = np.where(ids < 0, np.nan, (found[1][:, 1] / found[0][:, 1])[ids])
    shown = panels[2].imshow(ratio, cmap="RdBu_r", norm=LogNorm(0.5, 2), **around)
    panels[2].set_title("splats / meadow, green")
    bar = figure.colorbar(
        shown, ax=panels[2], extend="both", label="ratio of responses", location="bottom", aspect=40
    )
    bar.set_ticks([0.5, 0.7, 1, 1.4, 2], labels=["0.5", "0.7", "1", "1.4", "2"])
    bar.minorticks_off()
    for panel in panels:
        panel.set(
            ylabel="elevation, degrees", xticks=range(-180, 181, 60), yticks=range(-90, 91, 30)
        )
        panel.set_xlabel("azimuth, degrees (right is positive)")
    figure.suptitle(title)
    figure.savefig(path, dpi=110, bbox_inches="tight")
    plt.close(figure)


def compare(meadow, splats, eye, pose):
    """(responses of both, standard errors of both, regions) of a head at one pose.

    Args:
        meadow, splats: renderers of the two worlds.
    """
    both = [one.render(pose, standard_error=True) for one in (meadow, splats)]
    return [one[0][0] for one in both], [one[1][0] for one in both], regions(meadow, pose)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("splats", type=Path, help="a .ply file of 3DGS, +Y up, metres")
    parser.add_argument("-o", "--output", type=Path, default=Path("meadow_splats_bee.png"))
    parser.add_argument("--samples", type=int, default=16, help="rays, in each of 8 scrambles")
    given = parser.parse_args(arguments)
    scene = omma.load_scene(omma.examples.meadow())
    splat_scene = omma.load_scene(given.splats, up="y")
    bee = omma.species.honeybee_worker().eye
    meadow = omma.Renderer(scene, bee, omma.Fixed(given.samples), seed=0)
    splats = omma.Renderer(
        splat_scene, bee, omma.Fixed(given.samples), seed=0, background=scene.background
    )
    arrays = given.splats.with_suffix(".npz")
    cameras = np.load(arrays)["camera_position_m"] if arrays.is_file() else None
    for name in CAMERAS:
        pose = scene.camera(name).world_from_camera
        found, errors, where = compare(meadow, splats, bee, pose)
        print(f"camera {name}")
        if cameras is not None:
            nearest = np.linalg.norm(cameras - pose[:3, 3], axis=1).min()
            print(f"the nearest training camera was {nearest:.2f} m away")
        print("\n".join(table(found, where, errors)))
        if name == CAMERAS[0]:
            draw(given.output, bee, found, f"A honeybee worker at the camera “{name}”")
            print(f"wrote {given.output}")


if __name__ == "__main__":
    main()
