"""Baked light against closed forms, and against the same worlds by paths.

Scenes are long and thin where that can be, as the probes about a line are few. Light falls on large
cells from few paths, so that means over many cells are compared.
"""

import numpy as np
import pytest
from lit_checks import BAND, DARK, eyes_at, flat_spectrum, matter, shining, square
from lit_checks_lights import (
    SUN_RADIUS_RAD,
    adjacent_squares,
    disc_mesh,
    opposite_squares,
)

import omma
from omma.light import Disc, Light, uniform_sky
from omma.scene import Bake, Instance, Mesh

UPPER = uniform_sky(1.0, below=0, bands=BAND, unit="watts")
WHITE = uniform_sky(1.0, bands=BAND, unit="watts")
# Half a percent, beside three standard errors.
MOST = 0.005


def world_of(scene, light, **settings):
    return omma.World(
        scene, light=light, lighting="baked", bake=Bake(**{"cache": False, **settings})
    )


def strip(normal, length_m=2.0, width_m=0.04, material=0, **parts):
    """A strip along x through the origin, which faces ``normal``, across x."""
    normal = np.asarray(normal, float)
    across = np.cross([1.0, 0, 0], normal) * width_m / 2
    along = np.array([length_m / 2, 0, 0])
    corners = [along - across, along + across, across - along, -across - along]
    return Mesh(corners[::-1], [[0, 1, 2], [0, 2, 3]], material=material, **parts)


def mean_seen(world, positions_m, axes, samples=4):
    """The mean over places and its standard error, as if they were independent."""
    eye = eyes_at(positions_m, axes)
    seen = omma.Renderer(world, eye, omma.Fixed(samples)).render(np.eye(4))[0, :, 0].astype(float)
    return seen.mean(), seen.std(ddof=1) / np.sqrt(len(seen)), seen


def along_strip(normal, count=2000):
    """Places before a strip, all over it, so that few look at the same cell."""
    normal = np.asarray(normal, float)
    u, v = np.random.default_rng(3).uniform(-1, 1, (2, count))
    return (
        np.outer(0.99 * u, [1, 0, 0])
        + 0.1 * normal
        + np.outer(0.018 * v, np.cross([1.0, 0, 0], normal))
    )


def closed_tube(size_m=(2.0, 0.1, 0.1)):
    """A closed box that faces inwards."""
    corners = (np.array(list(np.ndindex(2, 2, 2))) - 0.5) * size_m
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    triangles = [part for a, b, c, d in faces for part in ([a, b, c], [a, c, d])]
    return Mesh(corners, triangles, material=0)


@pytest.mark.parametrize("reflectance", [0.2, 0.5])
def test_furnace(reflectance):
    scene = omma.Scene(meshes=[closed_tube()], materials=[shining(1.0, reflectance)])
    world = world_of(scene, DARK, cell_m=0.05, paths=128)
    axes = np.random.default_rng(2).normal(size=(3000, 3))
    at = np.column_stack([np.linspace(-0.95, 0.95, 3000), np.zeros(3000), np.zeros(3000)])
    seen, error, _ = mean_seen(world, at, axes)
    truth = 1 / (1 - reflectance)
    assert error < 0.002 * truth
    assert seen == pytest.approx(truth, rel=MOST)


@pytest.mark.parametrize("tilt_deg", [0, 30, 60, 90, 120])
def test_tilted_facets(tilt_deg):
    tilt = np.radians(tilt_deg)
    normal = np.array([0, np.cos(tilt), np.sin(tilt)])
    scene = omma.Scene(meshes=[strip(normal)], materials=[matter(1.0)])
    world = world_of(scene, UPPER, cell_m=0.02, paths=64)
    seen, error, _ = mean_seen(world, along_strip(normal), -normal)
    truth = (1 + np.cos(tilt)) / 2
    assert error < MOST / 3
    assert seen == pytest.approx(truth, rel=MOST, abs=3 * error)


def test_overcast_sky():
    light = omma.light.overcast_sky(40, bands=BAND, albedo=0.0)
    zenith = light.radiance((0, 1, 0))[0, 0]
    found = []
    for normal in ([0.0, 1, 0], [0.0, 0, 1]):
        scene = omma.Scene(meshes=[strip(normal)], materials=[matter(1.0)])
        world = world_of(scene, light, cell_m=0.02, paths=64)
        found.append(np.pi * mean_seen(world, along_strip(normal), -np.array(normal))[0] / zenith)
    assert found[0] == pytest.approx(7 * np.pi / 9, rel=MOST)
    assert found[1] / found[0] == pytest.approx(0.3962, rel=2 * MOST)  # of two, each to that


@pytest.mark.parametrize(
    ("factor", "at", "facing"),
    [
        (opposite_squares(), (0.5, 1, 0.5), (0, -1, 0)),
        (adjacent_squares(), (0.5, 0.5, 0), (0, 0, 1)),
    ],
)
def test_form_factors(factor, at, facing):
    scene = omma.Scene(
        meshes=[square(1, (0.5, 0, 0.5), (0, 1, 0), 0), square(1, at, facing, 1)],
        materials=[matter(1.0), shining(1.0)],
    )
    world = world_of(scene, DARK, cell_m=0.025, paths=128)
    u, v = (np.array(list(np.ndindex(120, 120))).T + 0.5) / 120
    eye = np.column_stack([u, np.full(u.size, 1e-3), v])
    assert mean_seen(world, eye, (0, -1, 0), 1)[0] == pytest.approx(factor, rel=MOST)


def test_shade_of_a_disc():
    radius, height, half = 1.0, 1.0, 0.2
    # Of small triangles, so that the disc is not cut into cells as small.
    rows = 81
    grid = np.stack(np.meshgrid(*[np.linspace(-half, half, rows)] * 2, [0.0]), axis=-1)
    corner = np.arange(rows * rows).reshape(rows, rows)
    a, b, c, d = (
        one.ravel() for one in (corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:])
    )
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    ground = Mesh(grid.reshape(-1, 3)[:, [1, 2, 0]], triangles[:, ::-1], material=0)
    scene = omma.Scene(
        meshes=[ground, disc_mesh(radius, height, 256)], materials=[matter(1.0), matter(0.0)]
    )
    world = world_of(scene, UPPER, cell_m=2.0)
    x, z = ((np.array(list(np.ndindex(60, 60))).T + 0.5) / 60 * 2 - 1) * half
    seen = mean_seen(world, np.column_stack([x, np.full(x.size, 0.1), z]), (0, -1, 0), 1)[0]
    # Of a point so far beside the axis of a disc (Howell, B-13); a²/(a² + h²) below its middle.
    beside = x**2 + z**2
    sum_ = height**2 + beside + radius**2
    taken = (1 - (sum_ - 2 * radius**2) / np.sqrt(sum_**2 - 4 * radius**2 * beside)) / 2
    # A disc of 256 corners is 0.01 % smaller.
    assert seen == pytest.approx(1 - taken.mean(), rel=MOST)


@pytest.mark.parametrize("angle_deg", [0, 60])
def test_a_leaf_that_absorbs_nothing_is_not_seen(angle_deg):
    sheet = matter(0.6, transmittance=flat_spectrum(0.4))
    scene = omma.Scene(meshes=[strip((0, 1, 0))], materials=[sheet])
    world = world_of(scene, WHITE, cell_m=0.05)
    angle = np.radians(angle_deg)
    back = np.array([np.sin(angle), np.cos(angle), 0])
    at = along_strip((0, 0, 0), 200) * 0.8 + 0.1 * back
    _, _, seen = mean_seen(world, at, -back)
    # All paths find the same; light is kept in numbers of 12 bits, of each pass.
    np.testing.assert_allclose(seen, 1, rtol=2**-10)


def shaded():
    """A ground below an edge, in the sun alone."""
    edge = strip((0, 1, 0), 1.0, 0.2, material=1)
    edge = edge.replace(positions_m=edge.positions_m + [0.5, 0.2, 0])
    scene = omma.Scene(
        meshes=[strip((0, 1, 0), 2.0, 0.04), edge], materials=[matter(0.5), matter(0.0)]
    )
    sun = Light(BAND, "watts", discs=(Disc((0, 1, 0), SUN_RADIUS_RAD, [1.0]),))
    return world_of(scene, sun, cell_m=0.5, paths=16)


def test_the_half_shade_of_the_sun_is_that_of_paths():
    baked = shaded()
    paths = baked.with_light(baked.light, lighting="path")
    radius = 0.2 * np.tan(SUN_RADIUS_RAD)
    x = np.linspace(-1.2, 1.2, 120) * radius
    at = np.column_stack([x, np.full(120, 0.1), np.zeros(120)])
    found = [mean_seen(world, at, (0, -1, 0), 512)[2] for world in (baked, paths)]
    full = 0.5 * baked.light.discs[0].irradiance()[0] / np.pi
    # The part of a disc beyond a chord; 512 points of it are within 2e-3 rms of all.
    s = np.clip(-x / radius, -1, 1)
    part = 0.5 + (s * np.sqrt(1 - s**2) + np.arcsin(s)) / np.pi
    for seen in found:
        assert np.sqrt(np.mean((seen / full - part) ** 2)) < 5e-3
    assert found[0].max() == pytest.approx(full, rel=1e-4)
    assert found[0].min() == pytest.approx(0, abs=1e-6)


@pytest.fixture(scope="module")
def small():
    """Surfaces of all kinds along a line: matt, glossy, mirror-like, metal, coated; a leaf."""
    grey = [
        matter(0.4),
        matter(0.3, specular=1.0, roughness=0.2),
        matter(0.3, specular=1.0, roughness=0.5),
        matter(0.3, specular=1.0, roughness=1.0),
        matter(0.7, metallic=1.0, base_color=(0.7, 0.7, 0.7, 1), roughness=0.4),
        matter(0.3, clearcoat=1.0, clearcoat_roughness=0.2),
    ]
    meshes = []
    for k in range(len(grey)):
        low, high = strip((0, 1, 0), 0.3, 0.1, k), strip((0, 0.6, 0.8), 0.3, 0.1, 0)
        meshes.append(low.replace(positions_m=low.positions_m + [0.3 * k, 0, 0]))
        meshes.append(high.replace(positions_m=high.positions_m + [0.3 * k, 0.06, -0.06]))
    return omma.Scene(
        meshes=meshes,
        materials=grey,
        instances=[Instance(k, name=f"part {k}") for k in range(len(meshes))],
    )


LIGHT = Light(
    BAND,
    "watts",
    uniform_sky(1.0, below=0.3, bands=BAND, unit="watts").sky,
    discs=(Disc((0.3, 0.8, 0.5), 0.05, [60.0]),),
)


def seen_of(world, samples=64, threads=0, places=400, parts=6):
    """Of the first of the six parts, each at random places: (parts, places)."""
    x, z = np.random.default_rng(4).uniform(-1, 1, (2, 6, places))[:, :parts]
    x = (0.14 * x + 0.3 * np.arange(parts)[:, None]).ravel()
    eye = eyes_at(np.column_stack([x, np.full(x.size, 0.1), 0.1 + 0.045 * z.ravel()]), (0, -1, -1))
    renderer = omma.Renderer(world, eye, omma.Fixed(samples), threads=threads)
    return renderer.render(np.eye(4))[0, :, 0].reshape(parts, places).astype(float)


def test_gloss_has_no_bias(small):
    # Each surface by itself, at places of which few share a cell, so that what cells are off by
    # chance is in the scatter too.
    baked = world_of(small, LIGHT, cell_m=0.01, paths=64)
    paths = baked.with_light(LIGHT, lighting="path")
    found, truth = seen_of(baked, 256), seen_of(paths, 256)
    difference = (found - truth).mean(axis=1) / truth.mean(axis=1)
    scatter = (found - truth).std(axis=1, ddof=1) / np.sqrt(400) / truth.mean(axis=1)
    assert np.all(scatter < 0.002)
    assert np.all(np.abs(difference) < 3 * scatter), (difference, scatter)


def test_paths_between_mirrors_end():
    # Nothing is lost on the way in a closed box of perfect mirrors, and nothing gets in.
    mirror = omma.scene.Material(
        metallic=1.0, base_color=(1, 1, 1, 1), roughness=0.0, double_sided=True
    )
    box = omma.scene.box((1, 1, 1))
    world = world_of(
        box.replace(materials=[mirror], meshes=[one.replace(material=0) for one in box.meshes]),
        LIGHT,
        cell_m=0.1,
    )
    eye = eyes_at(np.zeros((500, 3)), (0.3, 0.2, -1))
    seen = omma.Renderer(world, eye, omma.Fixed(16)).render(np.eye(4))
    assert np.all(seen == 0)


def test_the_same_bits_for_any_number_of_threads(small):
    seen = []
    for threads in (1, 2, 3):
        bake = Bake(cell_m=0.1, paths=16, cache=False)
        world = omma.World(small, light=LIGHT, lighting="baked", threads=threads, bake=bake)
        seen.append(seen_of(world, 8, threads))
    np.testing.assert_array_equal(seen[0], seen[1])
    np.testing.assert_array_equal(seen[0], seen[2])


def test_another_light_is_baked_anew(small):
    world = world_of(small, LIGHT, cell_m=0.1, paths=16)
    dusk = world.with_light(UPPER)
    assert dusk.lighting == "baked"
    assert dusk.baked.cells == world.baked.cells
    fresh = world_of(small, UPPER, cell_m=0.1, paths=16)
    np.testing.assert_array_equal(seen_of(dusk, 8), seen_of(fresh, 8))
    # Where the sun is in shade and nothing of what is below is seen, both lights are the same.
    assert np.mean(seen_of(dusk, 8) != seen_of(world, 8)) > 0.9


def test_what_moves(small):
    sun_alone = Light(BAND, "watts", discs=LIGHT.discs)
    raised = np.eye(4)
    raised[1, 3] = 0.01
    found = {}
    for name, light in (("sun", sun_alone), ("all", LIGHT)):
        baked = world_of(small, light, cell_m=0.05, paths=256)
        paths = baked.with_light(light, lighting="path")
        direct = baked.with_light(light, depth=1)
        baked.set_transforms("part 0", raised)
        found[name] = [seen_of(world, parts=1).mean() for world in (baked, paths, direct)]
    # The sun is asked for exactly: only light between surfaces is that of probes, which are some 4
    # cm apart, as far as the walls are from what has moved, and partly behind these: they find some
    # of it, and never much more than there is.
    seen, truth, direct = found["sun"]
    assert direct * 0.999 < seen < truth + 0.5 * (truth - direct)
    # Of the sky they find less: some lie in the surfaces of this small scene, and see half of it.
    seen, truth, _ = found["all"]
    assert 0.5 * truth < seen < 1.2 * truth


def test_leaves_whose_normals_point_up():
    # As foliage is often modelled: half of the directions about such a normal lie behind the leaf.
    # What falls on a leaf must be the same whoever looks, or it cannot be baked.
    rng = np.random.default_rng(1)
    corners = (rng.uniform(-1, 1, (100, 1, 3)) + rng.normal(0, 0.25, (100, 3, 3))).reshape(-1, 3)
    leaf = omma.scene.Material(
        "leaf",
        base_color=(0.4, 0.4, 0.4, 1),
        double_sided=True,
        specular=0,
        diffuse_transmission=0.5,
        diffuse_transmission_color=(1, 1, 1),
    )
    leaves = Mesh(
        corners,
        np.arange(300).reshape(-1, 3),
        material=0,
        normals=np.tile([0.0, 1.0, 0.0], (300, 1)),
    )
    scene = omma.Scene(meshes=[leaves], materials=[leaf], instances=[Instance(0)])
    baked = omma.World(
        scene,
        light=WHITE,
        lighting="baked",
        ultraviolet=0.4,
        bake=Bake(cell_m=0.1, paths=128, cache=False),
    )
    paths = baked.with_light(WHITE, lighting="path")
    axes = rng.normal(0, 0.15, (300, 3)) + (0, 0, -1)
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    eye = omma.Eye(np.zeros((300, 3)), axes, acceptance_angle_rad=np.full(300, 0.03))
    at = np.eye(4)
    at[:3, 3] = 0, 0.3, 3
    found, truth = (
        omma.Renderer(world, eye, omma.Fixed(512)).render(at)[0, :, 0].astype(float)
        for world in (baked, paths)
    )
    # Their noise is 0.1 % of the mean, the sky that is seen between leaves is the same in both.
    assert found.mean() == pytest.approx(truth.mean(), rel=0.003)


def test_a_map_of_the_sun(small):
    exact = world_of(small, LIGHT, cell_m=0.05)
    mapped = exact.with_light(LIGHT, sun="map")
    again = exact.with_light(LIGHT, sun="map")
    seen, truth = seen_of(mapped, 16), seen_of(exact, 16)
    np.testing.assert_array_equal(seen, seen_of(again, 16))
    # A map has no half-shade, of which as much lies on either side of a shadow's edge; what is left
    # is a texel along the edges of things of 10 cm.
    assert np.any(seen != truth)
    assert seen.mean() == pytest.approx(truth.mean(), rel=0.02)


def test_where_the_sun_has_no_map(small):
    with pytest.raises(omma.Error, match='sun: "map" goes with lighting="baked"'):
        omma.World(small, light=LIGHT, lighting="path", sun="map")
    with pytest.raises(omma.Error, match='expected "exact" in a light of 0 discs'):
        omma.World(
            small, light=UPPER, lighting="baked", sun="map", bake=Bake(paths=16, cache=False)
        )
    glass = omma.Scene(
        meshes=[strip((0, 1, 0))],
        materials=[omma.scene.Material("pane", transmission=1.0)],
        instances=[Instance(0)],
    )
    with pytest.raises(omma.Error, match='sun: expected "exact" in a world with surfaces'):
        omma.World(
            glass,
            light=LIGHT,
            lighting="baked",
            sun="map",
            ultraviolet=0.5,
            bake=Bake(paths=16, cache=False),
        )


def test_how_it_is_lit(small):
    world = world_of(small, LIGHT, cell_m=0.1, paths=16)
    assert world.lighting == "baked"
    assert "light baked" in repr(world)
    assert f"{world.baked.cells:,} cells" in world._repr_html_()
    assert 0.05 < world.baked.cell_m <= 0.1
    assert world.baked.paths == 16
    assert world.baked.triangles_by_probes == 0
    assert world.baked.bytes > 4 * world.baked.cells
    paths = world.with_light(LIGHT, lighting="path")
    assert (paths.lighting, paths.baked) == ("path", None)
    assert "lit by paths" in repr(paths)
    assert paths.with_light(UPPER).lighting == "path"
    assert world.with_light(LIGHT, depth=2).lighting == "path"
    assert omma.World(small).lighting == "unlit"
    with pytest.raises(omma.Error, match="depth: expected None, as baked light"):
        omma.World(small, light=LIGHT, lighting="baked", depth=2)


def test_memory(small):
    with pytest.raises(omma.Error, match=r"expected cells in .* cells, which take .*; cells of"):
        world_of(small, LIGHT, cell_m=0.002, most_bytes=10_000)
    with pytest.warns(UserWarning, match=r"1\d of 24 triangles have no room.*most_bytes=96\)"):
        world = world_of(small, LIGHT, paths=16, most_bytes=48)
    assert world.baked.triangles_by_probes > 10
    # Enough is as much as the warning says.
    assert world_of(small, LIGHT, paths=16, most_bytes=96).baked.triangles_by_probes == 0


def test_a_large_mesh_without_room():
    scene = omma.Scene(meshes=[disc_mesh(1.0, 0.0, 40000)], materials=[matter(0.0), matter(0.5)])
    with pytest.warns(UserWarning, match="40,000 of 40,000 triangles have no room"):
        world = world_of(scene, UPPER, paths=16, most_bytes=0)
    assert (world.baked.cells, world.baked.triangles_by_probes) == (0, 40000)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"cell_m": 0}, "cell_m: expected a number above 0"),
        ({"cell_m": float("nan")}, "cell_m"),
        ({"paths": 0}, "paths: expected 16 to 65536, found 0"),
        ({"paths": 40}, "paths: expected a multiple of 16, found 40"),
        ({"seed": -1}, "seed: expected 0 to"),
        ({"most_bytes": -1}, "most_bytes"),
    ],
)
def test_bad_bakes(settings, message):
    with pytest.raises(omma.Error, match=message):
        Bake(**settings)


def test_progress_rises_once(small):
    told = []
    bake = Bake(cell_m=0.05, cache=False)
    omma.World(small, light=LIGHT, lighting="baked", bake=bake, progress=told.append)
    assert told == sorted(told)
    assert 0 <= told[0]
    assert told[-1] == pytest.approx(1)


def test_triangles_without_a_size_have_a_cell():
    """All corners in one place: such triangles have no clearance and no edge to divide."""
    flat = np.float32([[-1, 0, 1], [1, 0, 1], [0, 0, -1], [0, 0.5, 0]])
    mesh = omma.scene.Mesh(flat, [[0, 1, 2], [3, 3, 3], [3, 3, 3]], material=0)
    material = omma.scene.Material("grey", base_color=(0.5, 0.5, 0.5, 1), double_sided=True)
    scene = omma.Scene(meshes=[mesh], materials=[material], instances=[Instance(0)])
    world = world_of(scene, WHITE, paths=16)
    assert 3 <= world.baked.cells < 100_000
