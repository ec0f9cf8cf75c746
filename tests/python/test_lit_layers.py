"""Stacks of layers in lit worlds: what ommatidia see of them, against tables and closed forms, on
both backends, by paths and with baked light."""

import pickle

import numpy as np
import pytest
from lit_checks import eyes_at, look, slanted, square
from lit_checks_surfaces import ALBEDO_TABLE, MIRROR

import omma
from omma.light import Bands, uniform_sky
from omma.scene import Bake, BoundaryTable, LayerStack, Material, refractive_index

BANDS = Bands.equal(4, 400, 700)
SKY = uniform_sky(1.0, bands=BANDS, unit="watts")
BACKENDS = pytest.mark.parametrize("backend", ["embree", "portable"])
SCALE = LayerStack([(65, 1.56), (125, 1.0)] * 8, substrate=1.56 + 0.06j, spread=0.04)
GOLD = LayerStack(substrate=refractive_index("gold"))
# Means over a band of what is straight between the wavelengths of a table, which are 2 nm apart.
OF_TABLE = 5e-4


def band_means(stack, angle_deg):
    """(B, 3), by quadrature."""
    edges = BANDS.edges_nm
    fine = edges[:-1, None] + (np.arange(300) + 0.5) / 300 * np.diff(edges)[:, None]
    return stack.mueller(fine.ravel(), angle_deg)[:, 0].reshape(len(edges) - 1, 300, 3).mean(axis=1)


def world_of(material, *, meshes=None, **how):
    meshes = meshes or [square(2, (0, 0, 0), (0, 1, 0))]
    return omma.World(omma.Scene(meshes=meshes, materials=[material]), light=SKY, **how)


@BACKENDS
@pytest.mark.parametrize("stack", [SCALE, GOLD], ids=["scale", "gold"])
def test_smooth_stacks_reflect_as_their_tables(stack, backend):
    material = stack.material("stack")
    for lighting in ({"lighting": "path"}, {"lighting": "baked", "bake": Bake(cache=False)}):
        world = world_of(material, backend=backend, **lighting)
        for angle in (0, 40, 70):
            seen, error = look(world, *slanted(angle))
            expected = band_means(stack, angle)[:, 0]
            assert np.all(error < 4e-4)
            assert np.all(np.abs(seen - expected) < MIRROR + OF_TABLE + 3 * error)


@BACKENDS
def test_smooth_stacks_polarise_each_band_by_its_own(backend):
    """Q is by the ommatidium's up vector, which lies in the plane of incidence: -b."""
    for stack in (SCALE, GOLD):
        world = world_of(stack.material(), polarized=True, backend=backend, lighting="path")
        for angle in (30, 60, 75):
            a, b, _ = band_means(stack, angle).T
            seen, error = look(world, *slanted(angle))
            assert np.all(error < 4e-4)
            assert np.all(np.abs(seen - [a, -b, 0 * b]) < MIRROR + OF_TABLE + 3 * error)


@BACKENDS
def test_two_mirrors_pass_polarisation_on(backend):
    """A ray that two stacks mirror, in planes of incidence that are turned by some angle: Mueller
    matrices of the three elements, c among them, multiplied by hand. Each band by itself."""
    first = np.array([0.0, 0.0, -1.0])
    normals, ways, axes = [], [first], []
    for angle, turn in ((40, 0.0), (65, 0.6)):
        way = ways[-1]
        s = np.array([1.0, 0.0, 0.0])  # across the way of both, before it is turned about that
        s = np.cos(turn) * s + np.sin(turn) * np.cross(way, s)
        normal = -way + np.tan(np.radians(angle)) * np.cross(way, s)
        normals.append(normal / np.linalg.norm(normal))
        ways.append(way - 2 * np.dot(way, normals[-1]) * normals[-1])
        axes.append(s)
    meet = 2.0 * ways[1]
    meshes = [square(0.4, (0, 0, 0), normals[0]), square(0.4, meet, normals[1])]
    stacks = SCALE, LayerStack([(150, 1.4)], substrate=2.2 + 0.5j)
    meshes = [meshes[0], meshes[1].replace(material=1)]
    scene = omma.Scene(meshes=meshes, materials=[stack.material() for stack in stacks])
    world = omma.World(scene, light=SKY, polarized=True, backend=backend, lighting="path")
    s1, s2 = axes
    e2 = np.cross(ways[1], s1)
    cosine, sine = np.dot(s1, s2), np.dot(e2, s2)
    cos2, sin2 = cosine**2 - sine**2, 2 * cosine * sine
    expected = []
    for (a1, b1, c1), (a2, b2, _) in zip(band_means(stacks[0], 40), band_means(stacks[1], 65)):
        q, u = b2 * cos2, b2 * sin2
        expected.append([a1 * a2 + b1 * q, b1 * a2 + a1 * q, c1 * u])
    seen, error = look(world, -first, first, up=s1)
    assert np.abs(np.array(expected)[:, 2]).max() > 0.02
    assert np.all(error < 5e-4)
    np.testing.assert_allclose(seen.T, expected, atol=2 * (MIRROR + OF_TABLE))


@BACKENDS
@pytest.mark.parametrize("roughness", [0.0, 0.4, 1.0])
def test_white_stacks_give_back_all(roughness, backend):
    """Whatever light facets pass to each other before it leaves."""
    all_back = BoundaryTable([300, 700], np.tile([1.0, 0.0, -1.0], (2, 3, 1)))
    white = Material(metallic=1, roughness=roughness, boundary=all_back)
    for polarized in (False, True):
        world = world_of(white, polarized=polarized, backend=backend, lighting="path")
        for angle in (0, 50, 75):
            seen, error = look(world, *slanted(angle), samples=1024)
            seen, error = (seen[0], error[0]) if polarized else (seen, error)
            assert np.all(np.abs(seen - 1) < 4 * ALBEDO_TABLE + 3 * error)


def test_a_table_of_schlicks_law_is_the_metal_of_its_colour():
    cosine = np.linspace(0, 1, 129)
    a = 0.5 + 0.5 * (1 - cosine) ** 5
    table = BoundaryTable([300, 700], np.tile(np.stack([a, 0 * a, -a], axis=1), (2, 1, 1)))
    # Light that facets pass on, up to 0.08 of all, counts by another mean: 0.524 for 0.5.
    for roughness, tolerance in ((0.0, 5e-4), (0.3, 0.08 * 0.024)):
        plain = Material(base_color=(0.5, 0.5, 0.5), metallic=1, roughness=roughness)
        for angle in (0, 60, 80):
            by_color, _ = look(world_of(plain, lighting="path"), *slanted(angle))
            by_table, error = look(
                world_of(plain.replace(boundary=table), lighting="path"), *slanted(angle)
            )
            assert np.all(np.abs(by_table - by_color) < tolerance + 3 * error)
            assert np.all(error < 1e-3)


def test_only_the_metal_of_a_material_is_a_stack():
    """Half metal, half a matt base: each by its share."""
    grey = omma.light.Spectrum([300, 800], [0.3, 0.3])
    parts = {"roughness": 0.0, "specular": 0.0, "reflectance": grey, "boundary": GOLD.boundary()}
    half = Material(metallic=0.5, **parts)
    seen, error = look(world_of(half, lighting="path"), *slanted(35), samples=1024)
    expected = 0.5 * band_means(GOLD, 35)[:, 0] + 0.5 * 0.3
    np.testing.assert_allclose(seen, expected, atol=2e-3)
    assert np.all(error < 1e-3)


def test_stacks_stand_beside_other_materials():
    """In packets that see both, and with more than one table."""
    materials = [SCALE.material(), Material(specular=0, base_color=(0.5, 0.5, 0.5)),
                 GOLD.material()]  # fmt: skip
    meshes = [square(1, (i, 0, 0), (0, 1, 0), material=i) for i in range(3)]
    scene = omma.Scene(meshes=meshes, materials=materials)
    eye = eyes_at([[i, 1, 0] for i in range(3)] * 5, [0, -1, 0])
    world = omma.World(scene, light=SKY, lighting="path")
    seen = omma.Renderer(world, eye, omma.Fixed(1024)).render(np.eye(4))[0].reshape(5, 3, 4)
    expected = [band_means(SCALE, 0)[:, 0], [0.5] * 4, band_means(GOLD, 0)[:, 0]]
    np.testing.assert_allclose(seen.mean(axis=0), expected, atol=3e-3)


def test_ultraviolet_is_known_where_the_table_has_it():
    """Of all metal nothing else is asked; what ends at 400 nm is."""
    sky = uniform_sky(1.0, bands=Bands.equal(4, 300, 700))
    mesh = square(2, (0, 0, 0), (0, 1, 0))
    omma.World(omma.Scene(meshes=[mesh], materials=[GOLD.material()]), light=sky)
    visible = Material(metallic=1, boundary=GOLD.boundary(np.arange(400, 701, 5.0)))
    with pytest.raises(omma.Error, match="ultraviolet"):
        omma.World(omma.Scene(meshes=[mesh], materials=[visible]), light=sky)


def test_tables_are_values_and_go_to_files_and_back(tmp_path):
    table = GOLD.boundary([300, 450, 700])
    assert table == GOLD.boundary([300, 450, 700])
    assert table != GOLD.boundary([300, 451, 700])
    assert pickle.loads(pickle.dumps(table)) == table
    assert table.mueller.dtype == np.float32
    material = Material("gold", metallic=1, roughness=0.25, boundary=table)
    assert pickle.loads(pickle.dumps(material)) == material
    assert material != material.replace(boundary=None)
    scene = omma.Scene(meshes=[square(1, (0, 0, 0), (0, 1, 0))], materials=[material])
    omma.scene.save_scene(tmp_path / "gold.glb", scene)
    assert omma.load_scene(tmp_path / "gold.glb").materials == scene.materials
    joined = omma.scene.merge_scenes([scene, scene])
    assert all(one.boundary == table for one in joined.materials)
    grey = omma.light.Spectrum([300, 800], [0.3, 0.3])
    assert omma.scene.with_reflectance(scene, "gold", grey).materials[0].boundary is None


def test_what_is_refused():
    good = np.tile([0.5, 0.1, -0.4], (2, 3, 1))
    for nm, values, message in (
        ([300, 700], good[:1], "mueller: expected a table for each of 2 wavelengths, found 1"),
        ([700, 300], good, "wavelength_nm: expected wavelengths that grow"),
        ([300, 700], good[:, :1], "cosines: expected 2 to"),
        ([300, 700], 3 * good, "mueller: expected a from 0 to 1"),
        ([300, 700], good * [1, 6, 1], "b^2 + c^2 of at most a^2"),
        ([300, 700], good * np.nan, "mueller: expected a from 0 to 1"),
        ([], np.zeros((0, 3, 3)), "wavelength_nm: expected 2 or more"),
    ):
        with pytest.raises(omma.Error) as error:
            BoundaryTable(nm, values)
        assert message in str(error.value)
    with pytest.raises(omma.Error, match="boundary: expected a metallic above 0"):
        Material(boundary=BoundaryTable([300, 700], good))
    with pytest.raises(TypeError, match=r"boundary: expected omma\.scene\.BoundaryTable or None"):
        Material(metallic=1, boundary=GOLD)
