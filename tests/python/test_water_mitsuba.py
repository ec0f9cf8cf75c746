"""Water and glass that rays bend into beside Mitsuba 3's smooth dielectrics and absorbing media, by
ommatidium.

What is compared is what Omma does not simplify (docs/materials.md): what rays from the eye find by
bending alone, and light on a level bottom under level water and an even sky. Things of glass stand
alone: what one mirrors of another is straight behind it here, bent there.

Needs what test_lit_mitsuba.py needs.
"""

from dataclasses import dataclass

import numpy as np
import pytest
from lit_checks import BAND, matter, shining, square
from test_lit_mitsuba import diffuse, mesh_of, mi, use_variant

import omma
from omma.base.directions import normalized
from omma.light import Bands, Light, uniform_sky
from omma.scene import Material, Mesh

COUNT, ACCEPTANCE_RAD = 200, np.radians(3.0)
REPEATS = 24
THREE = Bands.equal(3, 400, 700)
RADIANCES = (0.2, 0.6, 1.2, 2.0)
REFLECTANCES = (0.1, 0.3, 0.5, 0.8)


@dataclass(frozen=True)
class Volume:
    """What bends rays, as Omma's material, as Mitsuba's BSDF, and what Mitsuba has in it."""

    material: Material
    bsdf: dict
    medium: object = None


def volume(ior, left=None, distance_m=1.0):
    """`left`: of white after that distance, linear RGB, in three bands; None: clear."""
    bsdf = {"type": "dielectric", "int_ior": ior, "ext_ior": 1.0}
    clear = Material(ior=ior, transmission=1.0, roughness=0.0, thickness_m=1.0)
    if left is None:
        return Volume(clear, bsdf)
    per_m = -np.log(omma.light.band_from_rgb(THREE.edges_nm) @ left) / distance_m
    medium = {
        "type": "homogeneous",
        "sigma_t": {"type": "rgb", "value": (per_m / per_m.max()).tolist()},
        "scale": float(per_m.max()),
        "albedo": {"type": "uniform", "value": 0.0},
    }
    material = clear.replace(attenuation_color=left, attenuation_distance_m=distance_m)
    return Volume(material, bsdf, mi.load_dict(medium))


def tiles(lines_m, origin_m, facing, seed):
    """A plane, cut both ways at `lines_m` from its middle, each part of one of the materials 1 to 4
    by chance: a mesh for each of these."""
    normal = np.asarray(facing, float)
    across = np.roll(normal, 1)
    up = np.cross(normal, across)
    parts = len(lines_m) - 1
    kind = np.random.default_rng(seed).integers(1, 5, size=(parts, parts))
    meshes = []
    for k in range(1, 5):
        a, b = np.nonzero(kind == k)
        corners = np.stack(
            [
                lines_m[a + i][:, None] * across + lines_m[b + j][:, None] * up
                for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))
            ],
            axis=1,
        )
        first = 4 * np.arange(len(a))[:, None]
        triangles = np.concatenate([first + (0, 1, 2), first + (0, 2, 3)])
        meshes.append(Mesh(corners.reshape(-1, 3) + origin_m, triangles, material=k))
    return meshes


def tiled_room(half_m):
    """A cube about the origin, of walls that shine to its inside."""
    sides = np.concatenate([np.eye(3), -np.eye(3)])
    return [
        mesh
        for seed, side in enumerate(sides)
        for mesh in tiles(np.linspace(-half_m, half_m, 7), -half_m * side, side, seed)
    ]


def eye_about(ahead, half_deg, up):
    """Ommatidia that look evenly into a cone."""
    k = np.arange(COUNT)
    height = 1 - (1 - np.cos(np.radians(half_deg))) * (k + 0.5) / COUNT
    turn = k * np.pi * (3 - np.sqrt(5))
    ahead = normalized(np.asarray(ahead, float))
    right = normalized(np.cross(ahead, up))
    flat = np.sqrt(1 - height**2)
    axes = (
        height[:, None] * ahead
        + (flat * np.cos(turn))[:, None] * right
        + (flat * np.sin(turn))[:, None] * np.cross(right, ahead)
    )
    return omma.Eye(np.zeros_like(axes), axes, ACCEPTANCE_RAD, up=np.tile(up, (COUNT, 1)))


def rays_of(eye, samples, seed):
    """As many rays of each ommatidium, (samples, N, 3), where it is sensitive, and the up vector of
    each: that of the ommatidium, carried along by the shortest turn from its axis."""
    rng = np.random.default_rng(seed)
    deviation = ACCEPTANCE_RAD / np.sqrt(8 * np.log(2))
    angles = np.linspace(0, 4 * deviation, 4001)
    density = np.exp(-((angles / deviation) ** 2) / 2) * np.sin(angles)
    share = np.append(0, np.cumsum(density[1:] + density[:-1]))
    strata = (np.arange(samples)[:, None] + rng.random((samples, COUNT))) / samples
    angle = np.interp(strata * share[-1], share, angles)[..., None]
    turn = 2 * np.pi * rng.random((samples, COUNT, 1))
    axis = eye.axis
    up = normalized(eye.up - np.sum(eye.up * axis, axis=1, keepdims=True) * axis)
    beside = np.cross(axis, up)
    rays = np.cos(angle) * axis + np.sin(angle) * (np.cos(turn) * up + np.sin(turn) * beside)
    turned = np.sum(rays * up, axis=-1, keepdims=True) / (1 + np.cos(angle))
    return rays, up - turned * (axis + rays)


def mean_and_error(found):
    return np.mean(found, axis=0), np.std(found, axis=0, ddof=1) / np.sqrt(len(found))


def ours(world, eye, position_m, samples):
    """Responses, (N, B), or Stokes vectors, (N, 3, B), and their standard errors."""
    pose = np.eye(4)
    pose[:3, 3] = position_m
    found = []
    for seed in range(REPEATS):
        renderer = omma.Renderer(world, eye, omma.Fixed(samples), seed=seed)
        seen = renderer.render_stokes(pose) if world.polarized else renderer.render(pose)
        found.append(seen[0].astype(float))
    return mean_and_error(found)


def theirs(shapes, eye, position_m, samples, *, sky=0.0, polarised=False, within=None):
    """The same of Mitsuba: `shapes` are what mesh_of makes them of, `within` is the medium in which
    the eye is."""
    light = {"type": "constant", "radiance": {"type": "uniform", "value": sky}}
    scene = {"type": "scene", "light": light}
    for k, (mesh, bsdf, radiance, medium) in enumerate(shapes):
        parts = {} if medium is None else {"interior": medium}
        scene[f"shape{k}"] = mesh_of(mesh, bsdf, radiance, **parts)
    loaded = mi.load_dict(scene)
    absorbs = any(medium is not None for *_, medium in shapes)
    kind = "volpath" if absorbs else "path"
    integrator = mi.load_dict({"type": kind, "max_depth": -1, "rr_depth": 64})
    origin = mi.Point3f(*map(float, position_m))
    found = []
    for seed in range(REPEATS):
        rays, up = (
            mi.Vector3f(x.reshape(-1, 3).T.astype(np.float32)) for x in rays_of(eye, samples, seed)
        )
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(seed, samples * COUNT)
        seen = integrator.sample(loaded, sampler, mi.RayDifferential3f(origin, rays), within)[0]
        if polarised:
            basis = mi.mueller.stokes_basis(-rays)
            seen = mi.mueller.rotate_stokes_basis(-rays, basis, up) @ seen
            # Theirs turns to the left, ours to the right.
            seen = np.array([seen[0, 0], seen[1, 0], -seen[2, 0]])
        values = np.moveaxis(np.array(seen), -1, 0)
        found.append(values.reshape(samples, COUNT, *values.shape[1:]).mean(axis=0))
    return mean_and_error(found)


def expect_same(one, other):
    """Each ommatidium within noise, and the mean of all to a thousandth beside its noise, all of
    which is under 1 %."""
    (a, error_a), (b, error_b) = one, other
    scale = b if b.ndim == 2 else b[:, :1]
    # Where nothing is random, within a tile, single precision is left.
    noise = np.hypot(np.hypot(error_a, error_b), 1e-5 * scale)
    z = (a - b) / noise
    # Errors of 24 renders: of Student's t with 23 degrees of freedom the rms is 1.05; 200 ommatidia
    # leave 0.06 of it open, and one in a hundred such eyes has one beyond 5.
    assert np.sqrt(np.mean(z**2, axis=0)).max() < 1.25
    assert np.abs(z).max() < 5
    # What boundaries reflect is from tables, to a thousandth.
    whole = scale.mean(axis=0)
    share = np.abs((a - b).mean(axis=0)) / whole
    limit = 1e-3 + 4 * np.sqrt(np.sum(noise**2, axis=0)) / COUNT / whole
    assert limit.max() < 0.01
    assert np.all(share < limit)


def tilted_block():
    block = omma.scene.box((0.9, 0.9, 0.6)).meshes[0]
    (a, b), (c, d) = ((np.cos(x), np.sin(x)) for x in (0.5, 0.4))
    turn = np.array([[a, 0, b], [0, 1, 0], [-b, 0, a]]) @ [[1, 0, 0], [0, c, -d], [0, d, c]]
    return block.replace(positions_m=block.positions_m @ turn.T, normals=None, material=0)


def ball():
    mesh = omma.scene.sphere(0.6, segments=64).meshes[0]
    return mesh.replace(normals=None, material=0)  # flat facets in both


@pytest.mark.parametrize("thing", [ball, tilted_block])
def test_glass_in_a_room_that_shines(thing):
    use_variant(False, "rgb")
    glass = volume(1.52, (0.7, 0.9, 0.8), 0.3)
    mesh, walls = thing(), tiled_room(3.0)
    scene = omma.Scene(meshes=[mesh, *walls], materials=[glass.material, *map(shining, RADIANCES)])
    world = omma.World(scene, light=Light(THREE, "watts"), lighting="path")
    shapes = [(mesh, glass.bsdf, None, glass.medium)]
    shapes += [(wall, diffuse(0.0), RADIANCES[wall.material - 1], None) for wall in walls]
    eye, place = eye_about((0, 0, -1), 25, (0, 1, 0)), (0.05, 0.1, 2.0)
    expect_same(ours(world, eye, place, 128), theirs(shapes, eye, place, 256))


@pytest.mark.parametrize("absorbs", [False, True])
def test_what_shines_above_and_below_seen_from_below(absorbs):
    """What is above, in Snell's window; bottom and walls, mirrored around it. All fields are within
    the surface, by which an eye knows what it is in."""
    use_variant(False, "rgb")
    water = volume(1.34, (0.7, 0.9, 0.8), 2.0) if absorbs else volume(1.34)
    surface, walls = square(7.0, (0, 0, 0), (0, 1, 0)), tiled_room(3.0)
    scene = omma.Scene(
        meshes=[surface, *walls], materials=[water.material, *map(shining, RADIANCES)]
    )
    world = omma.World(scene, light=Light(THREE, "watts"), lighting="path")
    shapes = [(surface, water.bsdf, None, water.medium)]
    shapes += [(wall, diffuse(0.0), RADIANCES[wall.material - 1], None) for wall in walls]
    eye, place = eye_about((0, 1, 0), 58, (0, 0, -1)), (0.2, -1.0, 0.1)
    expect_same(ours(world, eye, place, 128), theirs(shapes, eye, place, 256, within=water.medium))


VIEWS = {
    "obliquely from above": (eye_about((0, -1, -1), 30, (0, 1, 0)), (0, 1, 1)),
    "from below": (eye_about((0, 1, 0), 70, (0, 0, -1)), (0.2, -0.5, 0.1)),
}


@pytest.mark.parametrize("polarised", [False, True])
@pytest.mark.parametrize("view", VIEWS)
def test_a_pond_under_an_even_sky(view, polarised):
    use_variant(polarised)
    compare_ponds(volume(1.34), *VIEWS[view], polarised)


def test_a_pond_that_absorbs():
    """What goes to and fro between the bottom and the surface is dimmed on its way, too."""
    use_variant(False, "rgb")
    water = volume(1.34, (0.7, 0.9, 0.8), 1.0)
    compare_ponds(water, *VIEWS["obliquely from above"], bands=THREE)


def compare_ponds(water, eye, place, polarised=False, bands=BAND):
    lines = np.concatenate([[-200.0], np.linspace(-3, 3, 13), [200.0]])
    surface = square(400, (0, 0, 0), (0, 1, 0))
    bottom = tiles(lines, (0, -1, 0), (0, 1, 0), 1)
    scene = omma.Scene(
        meshes=[surface, *bottom], materials=[water.material, *map(matter, REFLECTANCES)]
    )
    sky = uniform_sky(1.0, bands=bands, unit="watts")
    world = omma.World(scene, light=sky, lighting="path", polarized=polarised)
    shapes = [(surface, water.bsdf, None, water.medium)]
    shapes += [(part, diffuse(REFLECTANCES[part.material - 1]), None, None) for part in bottom]
    within = water.medium if place[1] < 0 else None
    found = theirs(shapes, eye, place, 256, sky=1.0, polarised=polarised, within=within)
    if polarised:
        assert np.abs(found[0][:, 1:]).max() > 0.1 * found[0][:, 0].mean()
    expect_same(ours(world, eye, place, 128), found)
