"""Air between surfaces beside media of Mitsuba 3: one that only takes light away, exactly; and one
that only scatters, in which the same light comes from all around.

Such a medium has that light's radiance itself, as Omma's air has, whose J is the sky at the
horizon. What Omma leaves out is that fog beside a dark surface gets less light: of the order of the
surface's size times the extinction.

Needs what test_lit_mitsuba.py needs.
"""

import numpy as np
import pytest
from lit_checks import BAND, DARK, eyes_at, matter, shining, square
from test_lit_mitsuba import (
    BLOCK_MESH,
    FLOOR,
    LAMP,
    WALL,
    diffuse,
    expect_same,
    in_a_ball_of,
    mesh_of,
    mi,
    ours,
    theirs,
    use_variant,
)

import omma
from omma.light import uniform_sky, with_air

# So that no part of the picture is black.
BEHIND = square(40, (0, 0, -6), (0, 0, 1), 4)


def air(per_m, albedo):
    return {
        "type": "homogeneous",
        "sigma_t": {"type": "uniform", "value": per_m},
        "albedo": {"type": "uniform", "value": albedo},
    }


def test_black_smoke_between_lamp_surfaces_and_eye():
    use_variant(False)
    per_m = 0.15
    ball = BLOCK_MESH.replace(material=3, normals=None)
    scene = omma.Scene(
        meshes=[FLOOR, WALL, LAMP, ball, BEHIND],
        materials=[matter(0.6), matter(0.3), shining(8.0), matter(0.8), shining(0.3)],
    )
    light = with_air(DARK, extinction_per_m=per_m)
    world = omma.World(scene, light=light, lighting="path")
    back = LAMP.replace(triangles=LAMP.triangles[:, ::-1])
    shapes = [
        (FLOOR, diffuse(0.6), None),
        (WALL, diffuse(0.3), None),
        (LAMP, diffuse(0.0), 8.0),
        (back, diffuse(0.0), 8.0),
        (ball, diffuse(0.8), None),
        (BEHIND, diffuse(0.0), 0.3),
    ]
    none = {"type": "constant", "radiance": {"type": "uniform", "value": 0.0}}
    # Before the even wall alone ours is exp(−σ d) to 5e-7, theirs 0.0016 more (4096 samples, 7
    # standard errors); light that comes by way of a surface goes through such smoke twice.
    expect_same(ours(world, 64), theirs(shapes, none, 512, medium=air(per_m, 0.0)), most_share=4e-3)


# Reflectances of panels and how far off they are, in lengths 1/extinction.
PANELS = [(0.0, 0.1), (0.0, 0.5), (0.0, 2.0), (0.2, 0.5), (0.5, 1.0), (0.9, 1.0)]


def test_fog_in_front_of_panels():
    """L (1 − (1 − ρ) exp(−σ d)) in even light L, as Koschmieder has it, and as Mitsuba's fog shows
    it to within noise and half a percent of L, a panel's size in lengths 1/extinction."""
    use_variant(False)
    sky, per_m, size_m = 0.3, 0.1, 0.05
    turns = np.radians(60.0 * np.arange(len(PANELS)))
    towards = np.stack([np.sin(turns), 0 * turns, -np.cos(turns)], axis=1)
    centers = towards * np.array([[far / per_m] for _, far in PANELS])
    panels = [
        square(size_m, center, -way, k)
        for k, (center, way) in enumerate(zip(centers, towards, strict=True))
    ]
    light = with_air(uniform_sky(sky, bands=BAND, unit="watts"), extinction_per_m=per_m)
    scene = omma.Scene(meshes=panels, materials=[matter(grey) for grey, _ in PANELS])
    world = omma.World(scene, light=light, lighting="path")
    seen = omma.Renderer(world, eyes_at((0, 0, 0), towards), omma.Fixed(4096)).render(np.eye(4))

    fog = {
        "type": "scene",
        "integrator": {"type": "volpath", "max_depth": 512, "rr_depth": 512},
        "light": {"type": "constant", "radiance": {"type": "uniform", "value": sky}},
        **in_a_ball_of(air(per_m, 1.0), radius_m=30.0),
    }
    for k, (panel, (grey, _)) in enumerate(zip(panels, PANELS, strict=True)):
        fog[f"panel{k}"] = mesh_of(panel, diffuse(grey), None)
    for k, way in enumerate(towards):
        fog[f"sensor{k}"] = ray_meter(way)
    loaded = mi.load_dict(fog)
    for k, (grey, far) in enumerate(PANELS):
        found = [
            float(np.array(mi.render(loaded, sensor=k, spp=1 << 14, seed=seed)).mean())
            for seed in range(8)
        ]
        mean, error = np.mean(found), np.std(found, ddof=1) / np.sqrt(8)
        assert error < 0.005 * sky
        assert seen[0, k, 0] == pytest.approx(sky * (1 - (1 - grey) * np.exp(-far)), rel=1e-4)
        assert abs(mean - seen[0, k, 0]) < 4 * error + size_m * per_m * sky, (grey, far)


def ray_meter(way):
    """Of Mitsuba: radiance along one ray from the middle of the ball."""
    return {
        "type": "radiancemeter",
        "origin": [0, 0, 0],
        "direction": [float(x) for x in way],
        "medium": {"type": "ref", "id": "air"},
        "film": {
            "type": "hdrfilm",
            "width": 1,
            "height": 1,
            "rfilter": {"type": "box"},
            "pixel_format": "luminance",
            "component_format": "float32",
        },
    }
