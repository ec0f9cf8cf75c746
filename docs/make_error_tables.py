"""Prints the tables of tails and of intervals in bench/notes/error-targets.md.

    .venv/bin/python docs/make_error_tables.py [--data FOLDER] [--quick] [--skies] [--lit]

FOLDER holds CompoundRay's scenes and eyes (scenes/natural-standin-sky.gltf,
bees/AM_60185-real.eye, ...); without it those that need it are left out. Some minutes; --quick
tries everything in half a minute and means nothing. --skies: only the table of intervals of skies
without edges, in a minute. --lit: only the last one, intervals of an arena lit by paths and unlit.
"""

import argparse
import base64
import json
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

import omma

ROOT = Path(__file__).resolve().parent.parent
EXAMPLES = ROOT / "examples"
TARGETS, SAMPLES = (0.003, 0.01, 0.03), (1, 16, 200)
SKY_SAMPLES, SKY_SEEDS = (1, 4, 16, 64), 100
LIT_SAMPLES, LIT_SEEDS = (1, 4, 16), 40
RENDERS = 16  # to an error; a quarter of it of fixed numbers of rays
SUMS = 2e-5  # what sums in single precision are off by


class Case(NamedTuple):
    """Who looks at what, and with how many rays that is known."""

    name: str
    renderer: omma.Renderer
    pose: np.ndarray
    true_samples: int


def at(x: float, y: float, z: float) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def thousand() -> omma.Eye:
    """A thousand ommatidia all round, 2.6 degrees wide and 6.4 apart."""
    i = np.arange(1000)
    z = 1 - (2 * i + 1) / 1000
    azimuth, across = np.pi * (3 - np.sqrt(5)) * i, np.sqrt(1 - z**2)
    axis = np.stack([across * np.cos(azimuth), z, across * np.sin(azimuth)], axis=1)
    return omma.Eye(np.zeros((1000, 3)), axis, np.radians(2.6))


def one_in(eye: omma.Eye, parts: int) -> omma.Eye:
    """Part of an eye, half of it or less: who looks to the left of the middle."""
    azimuth = np.arctan2(eye.axis[:, 0], -eye.axis[:, 2])
    end = len(eye) // 2
    return eye.take(np.sort(np.argsort(azimuth, kind="stable")[end - len(eye) // parts : end]))


def checkerboard(folder: Path) -> omma.Scene:
    """A ground of squares 5 cm wide, as bench/scenes.cpp has it."""
    row, column = np.mgrid[:256, :256] // 32
    grey = np.where((row + column) % 2 == 0, 30, 220).astype(np.uint8)
    omma.save_png(folder / "squares.png", np.stack([grey, grey, np.full_like(grey, 90)], axis=2))
    corners = np.array([[-200, 0, -200], [200, 0, -200], [200, 0, 200], [-200, 0, 200]], "<f4")
    data = corners.tobytes() + (corners[:, ::2] / 0.4).astype("<f4").tobytes()
    data += np.array([0, 2, 1, 0, 3, 2], "<u4").tobytes()
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    views = [(0, 48), (48, 32), (80, 24)]
    kinds = [(5126, 4, "VEC3"), (5126, 4, "VEC2"), (5125, 6, "SCALAR")]
    material = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "doubleSided": True}
    primitive = {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0], "extras": {"background-shader": "simple_sky"}}],
        "scene": 0,
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive]}],
        "materials": [material],
        "textures": [{"source": 0}],
        "images": [{"uri": "squares.png"}],
        "buffers": [{"byteLength": len(data), "uri": uri}],
        "bufferViews": [{"buffer": 0, "byteOffset": o, "byteLength": n} for o, n in views],
        "accessors": [
            {"bufferView": i, "componentType": component, "count": count, "type": kind}
            for i, (component, count, kind) in enumerate(kinds)
        ],
    }
    document["accessors"][0] |= {"min": [-200, 0, -200], "max": [200, 0, 200]}
    (folder / "ground.gltf").write_text(json.dumps(document))
    return omma.load_scene(folder / "ground.gltf")


def black_and_white() -> omma.Background:
    """Stripes 2.5, 5 and 10 degrees wide, upright and lying, and squares; dark floor and sky."""
    image = np.zeros((1800, 3600), np.float32)
    row, column = np.mgrid[:1800, :3600] // 25
    for k, width in enumerate((1, 2, 4)):
        upright, lying = slice(500 * k, 500 * k + 500), slice(1500 + 500 * k, 2000 + 500 * k)
        image[:, upright] = (column // width % 2)[:, upright]
        image[:, lying] = (row // width % 2)[:, lying]
    squares = np.random.default_rng(3).integers(0, 2, (36, 12))
    image[:, 3000:] = np.kron(squares, np.ones((50, 50)))
    image[:600] = image[1100:] = 0
    return omma.Background.image(np.repeat(image[..., None], 3, axis=2))


def empty(folder: Path) -> omma.Scene:
    """A scene of nothing but its background."""
    path = folder / "empty.gltf"
    path.write_text('{"asset": {"version": "2.0"}, "scenes": [{}], "scene": 0}')
    return omma.load_scene(path)


def cases(data: Path, quick: bool) -> Iterator[Case]:
    """The scenes of bench/error.cpp, and black and white ones for eyes whose fields are apart."""
    parts, known = (64, 512) if quick else (1, 16384)
    bee = omma.load_eye(EXAMPLES / "honeybee_worker_left.eye")
    apart = one_in(thousand(), parts) if quick else thousand()
    with tempfile.TemporaryDirectory() as folder:
        ground, nothing = checkerboard(Path(folder)), empty(Path(folder))
    if data.is_dir():
        bee = omma.load_eye(data / "bees" / "AM_60185-real.eye")
        arena = omma.load_scene(data / "scenes" / "ofstad-arena.gltf")
        meadow = omma.load_scene(data / "scenes" / "natural-standin-sky.gltf")
        many, inside = one_in(bee, 2 * parts), at(0, 1.98288, 0)
        yield Case("meadow", omma.Renderer(meadow, many), at(0, 0.15, 0), known)
        yield Case("arena", omma.Renderer(arena, many), inside, known)
        yield Case("arena, fields apart", omma.Renderer(arena, apart), inside, known)
    else:
        print(f"left out: meadow and arena, no CompoundRay data at {data}")
    many = one_in(bee, 2 * parts)
    yield Case("checkerboard", omma.Renderer(ground, many), at(0, 1.5, 0), known)
    grass = omma.load_scene(EXAMPLES / "meadow.glb")
    camera = next(camera for camera in grass.cameras if camera.name == "bee")
    pose = np.asarray(camera.world_from_camera)
    yield Case("grass", omma.Renderer(grass, one_in(bee, 8 * parts)), pose, known)
    for name, eye in (("black and white", many), ("black and white, fields apart", apart)):
        renderer = omma.Renderer(nothing, eye, background=black_and_white())
        yield Case(name, renderer, np.eye(4), known)


def measure_tails(case: Case, truth: np.ndarray) -> None:
    """A row for each error: how far off those are that say that they have reached it."""
    for target in TARGETS:
        to_error = case.renderer.with_eye(
            case.renderer.eye, omma.ToError(target), noise="new_every_frame"
        )
        responses, report = to_error.render(np.tile(case.pose, (RENDERS, 1, 1)), report=True)
        errors = np.abs(responses - truth).max(axis=-1) / target
        reached = (report.standard_error <= np.float32(target)).all(axis=-1)
        known, rms = errors[reached], np.sqrt((errors**2).mean(axis=0))[reached.all(axis=0)]
        p99, p999 = np.percentile(known, [99, 99.9])
        print(
            f"| {case.name} | {target:g} | {report.mean_rays:,.1f} | {100 * reached.mean():.1f} % "
            f"| {100 * (known <= 1).mean():.2f} % | {100 * (known <= 2).mean():.2f} % | {p99:.2f} "
            f"| {p999:.2f} | {known.max():.1f} | {rms.max():.1f} |",
            flush=True,
        )


def measure_intervals(case: Case, truth: np.ndarray) -> str:
    """A row: how often the bounds hold, of all responses and of those that vary."""
    fractions = []
    for samples in SAMPLES:
        fixed = case.renderer.with_eye(
            case.renderer.eye, omma.Fixed(samples), noise="new_every_frame"
        )
        poses = np.tile(case.pose, (RENDERS // 4, 1, 1))
        responses, errors = fixed.render(poses, standard_error=True)
        low, high = omma.study.confidence_interval(fixed.eye, responses, errors, 8 * samples)
        student = 2.3646 * errors
        off = np.abs(responses - truth)
        vary = np.broadcast_to(off.max(axis=0) > SUMS, off.shape)
        for held in (
            off <= student + SUMS,
            (low - SUMS <= truth) & (truth <= high + SUMS),
        ):
            fractions.append(f"{held.mean():.3f} ({held[vary].mean():.3f})")
    return f"| {case.name} | " + " | ".join(fractions) + " |"


def measure_skies(seeds: int) -> None:
    """A row for each sky and width of fields: how skew single renders are, how large their spread
    is over its estimate, and how often the bounds hold."""
    few = omma.light.Bands.equal(4, 400, 700)
    skies = {
        "clear": omma.light.clear_sky(40, sun_azimuth_deg=30, bands=few),
        "overcast": omma.light.overcast_sky(40, bands=few),
    }
    axis = omma.eye.generate_eye(120).axis
    axis = axis[axis[:, 1] > 0.5]
    print("\n| sky | fields | samples | skewness | spread / estimate | alone | with neighbours |\n"
          + "| --- " * 7 + "|")  # fmt: skip
    for name, light in skies.items():
        world = omma.World(omma.Scene(), light=light)
        for width_deg in (2.6, 20.0):
            eye = omma.Eye(np.zeros((len(axis), 3)), axis, np.radians(width_deg))
            many = omma.Renderer(world, eye, omma.Fixed(8192))
            truth = np.mean(
                [many.with_eye(eye, seed=1000 + k).render(np.eye(4))[0] for k in range(4)], axis=0
            )
            for samples in SKY_SAMPLES:
                renderers = [
                    omma.Renderer(world, eye, omma.Fixed(samples), seed=seed)
                    for seed in range(seeds)
                ]
                both = [one.render(np.eye(4), standard_error=True) for one in renderers]
                responses, errors = (np.stack([one[k][0] for one in both]) for k in range(2))
                single = np.stack([one.render(np.eye(4))[0] for one in renderers])
                scores = (single - single.mean(axis=0)) / single.std(axis=0)
                spread = np.sqrt((responses.var(axis=0, ddof=1) / (errors**2).mean(axis=0)).mean())
                low, high = omma.study.confidence_interval(eye, responses, errors, 8 * samples)
                alone = np.abs(responses - truth) <= 2.3646 * errors
                print(
                    f"| {name} | {width_deg:g}° | {samples} "
                    f"| {np.abs((scores**3).mean(axis=0)).mean():.1f} | {spread:.2f} "
                    f"| {alone.mean():.3f} | {((low <= truth) & (truth <= high)).mean():.3f} |",
                    flush=True,
                )


def arena() -> omma.Scene:
    """Patterned walls all round, a dark post and a floor, open to the sky."""
    cells = np.random.default_rng(0).random((4, 16, 1))
    walls = np.kron(cells, np.ones((8, 8, 3)))
    floor = omma.scene.plane((2.2, 2.2), (0.4, 0.4, 0.4), center_m=(0, -0.6, 0), name="floor")
    post = omma.scene.cylinder(0.08, 1.0, (0.02, 0.02, 0.02), center_m=(0.3, 0, -0.6), name="post")
    return omma.scene.merge_scenes(
        [omma.scene.drum(1.0, 1.2, walls, name="wall"), post, floor],
        background=omma.Background.constant((0.8, 0.9, 1.0)),
    )


def measure_lit(seeds: int) -> None:
    """A row for each light and number of samples: how often the bounds with neighbours hold, of all
    responses, of the darkest tenth and of the response of which they hold least often."""
    scene, eye = arena(), omma.eye.generate_eye(60)
    sky = omma.light.clear_sky(30, bands=omma.light.Bands.equal(3, 400, 700))
    worlds = {"unlit": omma.World(scene), "clear sky, by paths": omma.World(scene, light=sky)}
    pose = omma.look_at((0, 0, 0), (0.3, 0, -0.6))
    print("\n| arena | samples | all | darkest tenth | worst response |\n" + "| --- " * 5 + "|")
    for name, world in worlds.items():
        many = omma.Renderer(world, eye, omma.Fixed(4096), footprints=False)
        truth = np.mean([many.with_eye(eye, seed=5000 + k).render(pose)[0] for k in range(8)], 0)
        dark = truth < np.quantile(truth, 0.1)
        for samples in LIT_SAMPLES:
            few = many.with_eye(eye, omma.Fixed(samples))
            both = [
                few.with_eye(eye, seed=seed).render(pose, standard_error=True)
                for seed in range(seeds)
            ]
            responses, errors = (np.stack([one[k][0] for one in both]) for k in range(2))
            low, high = omma.study.confidence_interval(eye, responses, errors, 8 * samples)
            held = (low <= truth) & (truth <= high)
            print(
                f"| {name} | {samples} | {held.mean():.3f} | {held[:, dark].mean():.3f} "
                f"| {held.mean(axis=0).min():.3f} |",
                flush=True,
            )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    everything = ROOT.parent / "shared" / "data" / "compound-ray"
    parser.add_argument("--data", type=Path, default=everything)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--skies", action="store_true")
    parser.add_argument("--lit", action="store_true")
    arguments = parser.parse_args()
    if arguments.skies:
        return measure_skies(SKY_SEEDS)
    if arguments.lit:
        return measure_lit(LIT_SEEDS)
    intervals = []
    print("| scene | target | rays | reached | within it | within twice | 99 % | 99.9 % | worst "
          "| worst RMS |\n" + "| --- " * 10 + "|")  # fmt: skip
    for case in cases(arguments.data, arguments.quick):
        truth = case.renderer.with_eye(
            case.renderer.eye, omma.Fixed(case.true_samples), seed=99, footprints=False
        ).render(case.pose)
        measure_tails(case, truth)
        intervals.append(measure_intervals(case, truth))
    print("\n| scene | " + " | ".join(f"{n}: alone | {n}: with neighbours" for n in SAMPLES) + " |")
    print("| --- " * 7 + "|")
    print("\n".join(intervals))
    measure_skies(4 if arguments.quick else SKY_SEEDS)
    measure_lit(4 if arguments.quick else LIT_SEEDS)
    return None


if __name__ == "__main__":
    main()
