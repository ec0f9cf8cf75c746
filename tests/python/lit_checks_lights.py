"""Checks of lights: skies, the sun, lamps, shining surfaces, shadows, units, receptors."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from lit_checks import (
    BAND,
    DARK,
    ROUNDING,
    Check,
    Floats,
    eyes_at,
    look,
    look_many,
    matter,
    shining,
    square,
)

import omma
from omma.light import Bands, Disc, Light, Spectrum, uniform_sky
from omma.receptors import ReceptorType
from omma.scene import Instance, PunctualLight

SUN_RADIUS_RAD = float(np.radians(0.533 / 2))
ONE_W = Spectrum([200.0, 800.0], [1.0, 1.0])

# CIE 1924, from 380 nm in steps of 10: relative luminous efficiency, so that a candela is checked
# against numbers that are not the engine's own.
LUMINOUS_EFFICIENCY = np.array(
    [0.000039, 0.00012, 0.000396, 0.00121, 0.0040, 0.0116, 0.023, 0.038, 0.060, 0.09098]
    + [0.13902, 0.20802, 0.323, 0.503, 0.710, 0.862, 0.954, 0.99495, 0.995, 0.952]
    + [0.870, 0.757, 0.631, 0.503, 0.381, 0.265, 0.175, 0.107, 0.061, 0.032]
    + [0.017, 0.00821, 0.004102]
)


def ground(reflectance: float = 1.0, size_m: float = 200.0) -> omma.Scene:
    return omma.Scene(
        meshes=[square(size_m, (0, 0, 0), (0, 1, 0))], materials=[matter(reflectance)]
    )


def overcast(backend: str) -> Iterator[Check]:
    """A sky of L_z (1 + 2 sin e)/3, on level ground and on a wall."""
    rows = np.sin(np.linspace(0, np.pi / 2, 721))
    sky = np.zeros((2, 721, 4, 1, 1), np.float32)
    sky[0] = ((1 + 2 * rows) / 3)[:, None, None, None]
    # Of the shipped one rows are 1 deg apart, linear between.
    made = omma.light.overcast_sky(40, bands=BAND, albedo=0.0)
    zenith = made.radiance((0, 1, 0))[0, 0]
    for name, light, level, tolerance in (
        ("overcast sky", Light(BAND, "watts", sky), 1.0, ROUNDING),
        ("overcast_sky()", made, zenith, 5e-4),
    ):
        found = []
        for normal in ((0.0, 1.0, 0.0), (1.0, 0.0, 0.0)):
            scene = omma.Scene(meshes=[square(2, (0, 0, 0), normal)], materials=[matter(1.0)])
            world = omma.World(scene, light=light, backend=backend, lighting="path")
            seen, error = look(world, normal, -np.array(normal), samples=2048)
            found.append((np.pi * seen[0] / level, np.pi * error[0] / level))
        yield Check(f"{name}, level ground", "E = 7π/9 L_z", 7 * np.pi / 9, *found[0], tolerance)
        yield Check(f"{name}, wall", "0.3962 · 7π/9 L_z", np.pi / 6 + 4 / 9, *found[1], tolerance)


def form_factors(backend: str) -> Iterator[Check]:
    """What a shining unit square gives to another, over the whole of it."""
    side, repeats = 40, 8
    corner = np.stack(np.meshgrid(np.arange(side), np.arange(side), indexing="ij"), axis=-1)
    for name, factor, shining_at, facing in (
        ("opposite, at distance 1", opposite_squares(), (0.5, 1, 0.5), (0, -1, 0)),
        ("with a common edge", adjacent_squares(), (0.5, 0.5, 0), (0, 0, 1)),
    ):
        scene = omma.Scene(
            meshes=[square(1, (0.5, 0, 0.5), (0, 1, 0), 0), square(1, shining_at, facing, 1)],
            materials=[matter(1.0), shining(1.0)],
        )
        world = omma.World(scene, light=DARK, backend=backend, lighting="path")
        found = []
        for seed in range(repeats):
            # A place in each cell of a grid, all else of random numbers anew.
            random = np.random.default_rng(seed)
            u, v = ((corner + random.random(corner.shape)) / side).reshape(-1, 2).T
            eye = eyes_at(np.column_stack([u, np.full(u.size, 1e-3), v]), (0, -1, 0))
            renderer = omma.Renderer(world, eye, omma.Fixed(64), seed=seed)
            found.append(renderer.render(np.eye(4)).mean())
        yield Check(
            f"unit squares {name}",
            "form factor",
            factor,
            float(np.mean(found)),
            float(np.std(found, ddof=1) / np.sqrt(repeats)),
        )


def opposite_squares() -> float:
    """The form factor of unit squares opposite each other at distance 1 (Howell, C-11)."""
    root = np.sqrt(2)
    return float(
        2 / np.pi * (np.log(np.sqrt(4 / 3)) + 2 * root * np.arctan(1 / root) - 2 * np.arctan(1))
    )


def adjacent_squares() -> float:
    """The form factor of unit squares at a right angle with a common edge (Howell, C-14)."""
    root = np.sqrt(2)
    logarithm = np.log(4 / 3 * (3 / 4) * (3 / 4))
    return float((np.pi / 2 - root * np.arctan(1 / root) + logarithm / 4) / np.pi)


def disc_shade(backend: str) -> Iterator[Check]:
    """A black disc above the ground takes its share of a uniform sky."""
    for radius, height in ((1.0, 1.0), (0.5, 1.5)):
        # Light leaves a ground of 10 m some 10 µm above it, one of 200 m 0.2 mm.
        scene = omma.Scene(
            meshes=[square(10, (0, 0, 0), (0, 1, 0), 0), disc_mesh(radius, height)],
            materials=[matter(1.0), matter(0.0)],
        )
        world = omma.World(
            scene,
            light=uniform_sky(1.0, below=0, bands=BAND, unit="watts"),
            backend=backend,
            lighting="path",
        )
        seen, error = look(world, (0, 0.1, 0), (0, -1, 0), samples=4096)
        taken = radius**2 / (radius**2 + height**2)
        yield Check(
            f"black disc of radius {radius} m at {height} m: E below it",
            "π L (1 − a²/(a² + h²))",
            np.pi * (1 - taken),
            np.pi * seen[0],
            np.pi * error[0],
        )


def disc_mesh(radius_m: float, height_m: float, corners: int = 2048) -> omma.scene.Mesh:
    around = np.linspace(0, 2 * np.pi, corners, endpoint=False)
    rim = np.column_stack(
        [radius_m * np.cos(around), np.full(corners, height_m), radius_m * np.sin(around)]
    )
    positions = np.vstack([[[0, height_m, 0]], rim])
    k = np.arange(corners)
    triangles = np.column_stack([np.zeros(corners, int), 1 + k, 1 + (k + 1) % corners])
    return omma.scene.Mesh(positions, triangles, material=1)


def sun(backend: str) -> Iterator[Check]:
    """The sun on level ground, and the half-shade of an edge."""
    for elevation in (90.0, 30.0, 5.0):
        angle = np.radians(elevation)
        limb = Disc((0, np.sin(angle), -np.cos(angle)), SUN_RADIUS_RAD, [2.0], [0.6])
        world = omma.World(
            ground(0.4), light=Light(BAND, "watts", discs=(limb,)), backend=backend, lighting="path"
        )
        seen, error = look(world, (0, 1, 0), (0, -1, 0))
        yield Check(
            f"ground of ρ 0.4 in the sun at {elevation:.0f}°",
            "ρ E sin e/π",
            0.4 * limb.irradiance()[0] * np.sin(angle) / np.pi,
            seen[0],
            error[0],
        )
    height = 2.0
    edge = square(100, (50, height, 0), (0, 1, 0), 1)
    scene = ground()
    scene = omma.Scene(meshes=[*scene.meshes, edge], materials=[*scene.materials, matter(0.0)])
    overhead = Light(BAND, "watts", discs=(Disc((0, 1, 0), SUN_RADIUS_RAD, [1.0]),))
    world = omma.World(scene, light=overhead, backend=backend, lighting="path")
    radius = height * np.tan(SUN_RADIUS_RAD)
    x = (np.arange(240) + 0.5) / 240 * 2.4 * radius - 1.2 * radius
    at = np.column_stack([x, np.full(len(x), 1.0), np.zeros(len(x))])
    seen, error = look_many(world, at, (0, -1, 0), samples=512, repeats=4)
    full = overhead.discs[0].irradiance()[0] / np.pi
    share = seen[:, 0] / full
    # The part of a disc beyond a straight edge; its slope is a half ellipse as wide as the
    # half-shade, whose standard deviation is a quarter of that.
    s = np.clip(-x / radius, -1, 1)
    part = 0.5 + (s * np.sqrt(1 - s**2) + np.arcsin(s)) / np.pi
    yield Check(
        "half-shade of an edge, rms of the profile",
        "part of a disc beyond a chord",
        0.0,
        float(np.sqrt(np.mean((share - part) ** 2))),
        0.0,
        2e-3,
        1.0,
    )
    slope, middle = -np.diff(share), (x[1:] + x[:-1]) / 2
    mean = (slope * middle).sum() / slope.sum()
    spread = np.sqrt((slope * (middle - mean) ** 2).sum() / slope.sum())
    yield Check(
        "width of the half-shade, mm per m of height",
        "2 tan(0.2665°) = 9.30",
        2e3 * radius / height,
        4e3 * spread / height,
        0.0,
        0.02,
    )


def lamps(backend: str) -> Iterator[Check]:
    """Lamps without size."""

    def seen_of(lamp: PunctualLight, x: float) -> tuple[float, float]:
        world = omma.World(
            ground().replace(lights=[lamp]), light=DARK, backend=backend, lighting="path"
        )
        seen, error = look(world, (x, 0.5, 0), (0, -1, 0), samples=16)
        return seen[0], error[0]

    for height in (0.5, 3.0, 40.0):
        at = translated(1.0, height, 0.0)
        lamp = PunctualLight(type="point", spectrum=ONE_W, world_from_light=at)
        cosine = height / np.hypot(1.0, height)
        yield Check(
            f"lamp of 1 W/(sr nm), {height:g} m above and 1 m beside",
            "ρ I cos θ/(π d²)",
            cosine / np.pi / (1 + height**2),
            *seen_of(lamp, 0.0),
        )
    down = np.array([[1.0, 0, 0, 0], [0, 0, 1, 2], [0, -1, 0, 0], [0, 0, 0, 1]])
    inner, outer = np.radians([20, 40])
    spot = PunctualLight(
        type="spot",
        spectrum=ONE_W,
        inner_cone_rad=inner,
        outer_cone_rad=outer,
        world_from_light=down,
    )
    for angle_deg in (10.0, 30.0, 45.0):
        angle = np.radians(angle_deg)
        part = np.clip((np.cos(angle) - np.cos(outer)) / (np.cos(inner) - np.cos(outer)), 0, 1)
        yield Check(
            f"spot, {angle_deg:.0f}° off its axis",
            "ρ I s² cos³θ/(π h²)",
            part**2 * np.cos(angle) ** 3 / np.pi / 4,
            *seen_of(spot, 2 * np.tan(angle)),
            scale=1 / np.pi / 4,
        )
    fine = Bands.equal(128, 380, 700)
    nm = fine.centers_nm
    efficiency = np.interp(nm, 380 + 10.0 * np.arange(33), LUMINOUS_EFFICIENCY)
    for lamp, level in (
        (PunctualLight(type="point", intensity=100.0, world_from_light=translated(0, 2, 0)), 25.0),
        (PunctualLight(type="directional", intensity=70.0, world_from_light=down), 70.0),
    ):
        world = omma.World(
            ground().replace(lights=[lamp]),
            light=Light(fine, "watts"),
            backend=backend,
            lighting="path",
        )
        seen, _ = look(world, (0.0, 0.5, 0), (0, -1, 0), samples=16, count=4)
        lux = 683 * (np.pi * seen * efficiency * fine.widths_nm).sum()
        named = "point lamp of 100 cd at 2 m, lx" if level == 25 else "directional lamp of 70 lx"
        # Linear between the tabulated efficiencies, of which those above 700 nm are 7e-4.
        yield Check(named, "683 ∫ V E dλ", level, lux, tolerance=2e-3)


def translated(x: float, y: float, z: float) -> Floats:
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def moved(backend: str) -> Iterator[Check]:
    """A shining square that has moved shines from where it is."""
    scene = omma.Scene(
        meshes=[
            square(100, (0, 0, 0), (0, 1, 0), 0),
            square(0.02, (0, 0, 0), (0, -1, 0), 1),
        ],
        materials=[matter(1.0), shining(1000.0)],
        instances=[Instance(0), Instance(1, translated(0, 4, 0), name="lamp")],
    )
    world = omma.World(scene, light=DARK, backend=backend, lighting="path")
    for height in (4.0, 1.5):
        if height != 4.0:
            world.set_transforms("lamp", translated(0, height, 0))
        seen, error = look(world, (0.0, 0.5, 0), (0, -1, 0))
        # From 0.02 m of side at a distance h: within (side/h)²/3 of a point.
        point = 1000 * 0.02**2 / np.pi / height**2
        yield Check(
            f"small shining square, moved to {height:g} m",
            "ρ L A/(π h²)",
            point,
            seen[0],
            error[0],
            (0.02 / height) ** 2,
        )


def microvilli(backend: str) -> Iterator[Check]:
    """A receptor with microvilli before a uniformly polarised sky."""
    ratio, degree = 6.3, 0.6
    m = (ratio - 1) / (ratio + 1)
    psi = np.radians(25.0)
    sky = np.zeros((2, 2, 4, 3, 1), np.float32)
    sky[..., 0, 0] = 1
    sky[..., 1, 0], sky[..., 2, 0] = degree * np.cos(2 * psi), degree * np.sin(2 * psi)
    world = omma.World(
        omma.Scene(),
        light=Light(BAND, "photons", sky),
        polarized=True,
        backend=backend,
        lighting="path",
    )
    types = [
        ReceptorType(
            f"{phi:.0f}°",
            peak_wavelength_nm=530,
            polarisation_sensitivity=ratio,
            microvillus_angle_rad=float(np.radians(phi)),
        )
        for phi in (0.0, 25.0, 70.0, 115.0)
    ]
    eye = eyes_at((0, 0, 0), (0.6, 0, -0.8)).replace(receptor_types=types, receptors=[[0, 1, 2, 3]])
    renderer = omma.Renderer(world, eye, omma.Fixed(4))
    seen = renderer.render_receptors(np.eye(4), matrix=np.ones((4, 1)))[0]
    for one, value in zip(types, seen, strict=True):
        phi = one.microvillus_angle_rad
        yield Check(
            f"receptor of PS 6.3, microvilli at {one.name}, p 0.6 at 25°",
            "I + m (Q cos 2φ + U sin 2φ)",
            1 + m * degree * np.cos(2 * (phi - psi)),
            value,
        )


def photons(backend: str) -> Iterator[Check]:
    """The same shining surface in photons and in watts."""
    edges = np.array([349.9, 350.1, 500.0, 500.2, 650.0, 650.2])
    bands = Bands.from_edges(edges)
    scene = omma.Scene(meshes=[square(2, (0, 0, 0), (0, 1, 0))], materials=[shining(2.5)])
    found = [
        look(
            omma.World(scene, light=Light(bands, unit), backend=backend, lighting="path"),
            (0, 1, 0),
            (0, -1, 0),
            samples=1,
            count=2,
        )[0]
        for unit in ("photons", "watts")
    ]
    for band, nm in ((0, 350.0), (2, 500.1), (4, 650.1)):
        yield Check(
            f"photons per joule, {nm:g} nm",
            "5.0341e15 λ/nm",
            5.03411657e15 * nm,
            float(found[0][band]) / float(found[1][band]),
        )


def catch(backend: str) -> Iterator[Check]:
    """Photons that a receptor of known size catches."""
    light = uniform_sky(1e17)
    kind = ReceptorType("green", peak_wavelength_nm=530, absorption_per_m=7000, length_m=350e-6)
    eye = omma.Eye(
        [[0, 0, 0]],
        [[0, 0, -1]],
        np.radians(2.5),
        facet_diameter_m=25e-6,
        receptor_types=[kind],
        receptors=[[0]],
    )
    world = omma.World(omma.Scene(), light=light, backend=backend, lighting="path")
    answers = omma.Renderer(world, eye, omma.Fixed(16)).render_receptors(np.eye(4))
    found = omma.receptors.photon_catch(eye, answers, light, integration_time_s=0.014)
    nm = np.arange(300.0, 700.01, 0.5)
    absorbed = omma.receptors.spectral_sensitivity(kind, nm)
    # Self-screening is in the sensitivity: 1 − exp(−k A l) over its largest value.
    most = 1 - np.exp(-7000 * 350e-6)
    integral = ((absorbed[1:] + absorbed[:-1]) / 2 * np.diff(nm)).sum()
    # Of a Gaussian so narrow ∫ S dω is π Δρ²/(4 ln 2), to Δρ²/(16 ln 2), 2e-4.
    solid_angle = np.pi * np.radians(2.5) ** 2 / (4 * np.log(2))
    expected = np.pi / 4 * (25e-6) ** 2 * solid_angle * 0.014 * 1e17 * most * integral
    yield Check(
        "photons caught in 14 ms, D 25 µm, Δρ 2.5°",
        "(π/4) D² π Δρ²/(4 ln 2) t ∫ L (1 − e^(−kAl)) dλ",
        expected,
        float(found[0, 0]),
        tolerance=1e-3,
    )


CASES = {
    "overcast": overcast,
    "form factors": form_factors,
    "disc": disc_shade,
    "sun": sun,
    "lamps": lamps,
    "moved": moved,
    "microvilli": microvilli,
    "photons": photons,
    "catch": catch,
}
