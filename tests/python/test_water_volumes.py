"""Water that one looks into: a pool against water as a surface, what it takes of light, and files.

Closed forms of refraction are in the engine's tests: tests/cpp/render_volumes.cpp.
"""

import numpy as np
import pytest
from lit_checks import BAND, ROUNDING, flat_spectrum, look, matter, shining, slanted, square

import omma
from omma.light import Light, uniform_sky
from omma.light import water as under
from omma.light.water_types import TURNED
from omma.scene import water, water_volume

N = 1.34
BACKENDS = pytest.mark.parametrize("backend", ["embree", "portable"])
WHITE_SKY = uniform_sky(1.0, bands=BAND, unit="watts")


def pool(depth_m, bottom, surface):
    """A wide pool whose surface is level at 0."""
    return omma.Scene(
        meshes=[
            square(40, (0, 0, 0), (0, 1, 0)),
            square(40, (0, -depth_m, 0), (0, 1, 0), material=1),
        ],
        materials=[surface, bottom],
    )


@BACKENDS
@pytest.mark.parametrize("degrees", [0, 50, 75])
def test_a_film_over_matter_is_what_water_of_no_depth_is(backend, degrees):
    # One follows rays that bend, the other sums their returns up (docs/materials.md).
    film = pool(5e-3, matter(0.5), water_volume("IB"))
    sheet = omma.Scene(
        meshes=[square(2000, (0, 0, 0), (0, 1, 0))],
        materials=[water("IB", depth_m=0, bottom=flat_spectrum(0.5))],
    )
    found = [
        look(
            omma.World(scene, light=WHITE_SKY, lighting="path", backend=backend), *slanted(degrees)
        )
        for scene in (film, sheet)
    ]
    (a, error_a), (b, error_b) = found
    # Both by tables of what a boundary reflects, within 1e-3; at 75 degrees twice on the way.
    assert np.all(np.abs(a - b) <= 4 * np.hypot(error_a, error_b) + 2e-3 * b)


@BACKENDS
def test_light_from_below_is_dimmed_by_what_the_water_takes(backend):
    depth = 3.0
    surface = water_volume("3C")
    world = omma.World(
        pool(depth, shining(1.0), surface), light=Light(BAND, "watts"), lighting="path",
        backend=backend,
    )  # fmt: skip
    found, error = look(world, *slanted(0))
    nm = np.linspace(500, 600, 101)
    k = np.interp(nm, surface.absorption_per_m.wavelength_nm, surface.absorption_per_m.value)
    through = (1 - ((N - 1) / (N + 1)) ** 2) / N**2
    # One band is taken as one k, its mean.
    expected = through * np.exp(-np.mean(k) * depth)
    assert abs(found[0] - expected) <= 4 * error[0] + 2e-3 * expected


@BACKENDS
@pytest.mark.parametrize("degrees", [20, 53.3, 75])
def test_light_from_below_is_polarised_as_it_gets_out(backend, degrees):
    world = omma.World(
        pool(1.0, shining(1.0), water_volume("IB")), light=Light(BAND, "watts"), lighting="path",
        polarized=True, backend=backend,
    )  # fmt: skip
    position, axis = slanted(degrees)
    # Q is along the ommatidium's up, which is in the plane of exit.
    found, _ = look(world, position, axis, up=(0, 1, 0))
    i, q, u = found[:, 0]
    c = np.cos(np.radians(degrees))
    g = np.sqrt(N**2 - 1 + c**2)
    s, p = 1 - ((c - g) / (c + g)) ** 2, 1 - ((N**2 * c - g) / (N**2 * c + g)) ** 2
    assert q / i == pytest.approx((p - s) / (p + s), abs=1e-5)
    assert u / i == pytest.approx(0, abs=1e-5)


@BACKENDS
@pytest.mark.parametrize("degrees", [0, 30, 60])
def test_dark_water_mirrors_with_little_noise_and_honest_errors(backend, degrees):
    world = omma.World(
        pool(1.0, matter(0.0), water_volume("IB")), light=WHITE_SKY, lighting="path",
        backend=backend,
    )  # fmt: skip
    position, axis = slanted(degrees)
    # As many ommatidia as there are random numbers to try.
    eye = omma.Eye(np.tile(position, (200, 1)), np.tile(axis, (200, 1)), np.radians(1.0))
    found = omma.Renderer(world, eye, omma.Fixed(16)).render(np.eye(4), standard_error=True)
    response, error = np.asarray(found[0])[0, :, 0], np.asarray(found[1])[0, :, 0]
    c = np.cos(np.radians(degrees))
    g = np.sqrt(N**2 - 1 + c**2)
    mirrored = (((c - g) / (c + g)) ** 2 + ((N**2 * c - g) / (N**2 * c + g)) ** 2) / 2
    # A quarter of stratified rays is mirrored at least, 4 of 16, off by less than a third of one.
    # Were it Fresnel's 2 % of them, most ommatidia would have none or one, and be 23 % off.
    off = response / mirrored - 1
    assert np.sqrt(np.mean(off**2)) < 0.08
    assert abs(off.mean()) < 0.01
    assert np.all(np.abs(response - mirrored) <= 10 * error + ROUNDING)


@BACKENDS
@pytest.mark.parametrize("off_axis", [0.0, 0.4, 0.8])
def test_a_ball_of_glass_bends_rays_as_a_sphere_does(backend, off_axis):
    # The sky is brighter to one side: 1 + x / 2. A ray that meets the ball at the angle i, of sine
    # `off_axis`, leaves it turned aside by 2 (i - r), and by pi - 2 r more for each time that it is
    # mirrored within; what is mirrored outside turns by pi - 2 i.
    n, rows = 1.52, 180
    azimuth = 2 * np.pi * ((np.arange(2 * rows) + 0.5) / (2 * rows) - 0.5)
    height = np.pi * (0.5 - (np.arange(rows) + 0.5) / rows)
    x = np.cos(height)[:, None] * np.sin(azimuth)
    sky = omma.light.panorama_bands((1 + x / 2)[..., None], bands=BAND, unit="watts")
    glass = omma.scene.Material(
        ior=n, transmission=1, roughness=0, thickness_m=1, reflectance=flat_spectrum(1.0)
    )
    ball = omma.scene.sphere(1.0).replace(materials=[glass])
    world = omma.World(ball, light=sky, lighting="path", backend=backend)
    found, error = look(world, (off_axis, 0, 3), (0, 0, -1), samples=1024)

    i = np.arcsin(off_axis)
    r = np.arcsin(off_axis / n)
    c, g = np.cos(i), n * np.cos(r)
    back = (((c - g) / (c + g)) ** 2 + ((n**2 * c - g) / (n**2 * c + g)) ** 2) / 2
    # By how far the ray has turned towards the ball's middle, from ahead to -X.
    turned = np.array([np.pi - 2 * i, *(2 * (i - r) + k * (np.pi - 2 * r) for k in range(8))])
    turned[0] = -turned[0]
    part = np.array([back, *((1 - back) ** 2 * back**k for k in range(8))])
    expected = np.sum(part * (1 - np.sin(turned) / 2))
    # The mesh lies within the sphere by 3e-4 of its radius.
    assert abs(found[0] - expected) <= 4 * error[0] + 1e-3


def test_a_type_takes_what_is_absorbed_or_turned_away():
    surface = water_volume("II")
    a = surface.absorption_per_m
    at = list(a.wavelength_nm).index(500.0)
    measured = 0.0529  # at 500 nm
    scattered = 0.0292 * 0.8**1.7 + 0.174 * 0.8**0.3
    molecules = 0.005826 * 0.8**4.322
    assert a.value[at] == pytest.approx(measured + molecules + 0.109 * scattered, rel=1e-6)
    assert surface.ior == pytest.approx(N)


def test_what_particles_turn_away_is_that_of_their_phase_function():
    angle = np.linspace(0, np.pi, 1801)
    kept = 2 * np.pi * angle[1] * under._particle_phase(angle) @ np.sin(angle)
    assert round(kept, 3) == TURNED


def test_files_keep_it(tmp_path):
    scene = pool(1.0, matter(0.3), water_volume("IB"))
    omma.scene.save_scene(tmp_path / "pool.glb", scene)
    again = omma.scene.load_scene(tmp_path / "pool.glb")
    assert again.materials[0] == scene.materials[0]
    assert again.materials[0].thickness_m == 1.0


def test_bad_input():
    with pytest.raises(omma.Error, match="kind: "):
        water_volume("X")
    with pytest.raises(omma.Error, match="refractive_index: "):
        water_volume(refractive_index=1.0)
    with pytest.raises(omma.Error, match="expected both or none"):
        water_volume(absorption_per_m=flat_spectrum(0.1))
    with pytest.raises(omma.Error, match="thickness_m: "):
        omma.scene.Material(thickness_m=1.0, metallic=1.0)
    with pytest.raises(omma.Error, match="attenuation_distance_m: "):
        omma.scene.Material(attenuation_distance_m=0.0)
