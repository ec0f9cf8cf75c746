"""Four lit scenes beside Mitsuba 3: diffuse, glossy, and polarised by gloss and by metals.

Needs `pip install 'omma[peers]'`; Mitsuba's LLVM variants, which are quick, need libLLVM
(DRJIT_LIBLLVM_PATH says where); without it the scalar ones do what they can.
"""

import numpy as np
import pytest
from lit_checks import BAND, eyes_at, matter, shining, square

import omma
from omma.light import uniform_sky
from omma.scene import LayerStack

mi = pytest.importorskip("mitsuba")

SIZE, WITHIN, BLOCKS = 36, 4, 6
PLACE, TARGET = np.array([0.6, 1.1, 2.6]), np.array([0.0, 0.45, 0.0])
FIELD_DEG = 50.0
REPEATS = 12


def use_variant(polarised, colours="mono"):
    wanted = f"llvm_ad_{colours}" + ("_polarized" if polarised else "")
    if wanted not in mi.variants():
        pytest.skip(f"this Mitsuba has no {wanted}")
    try:
        mi.set_variant(wanted)
        import drjit

        drjit.eval(mi.Float(0.0) + drjit.arange(mi.Float, 2))
    except Exception as error:  # drjit raises several kinds where libLLVM is missing
        pytest.skip(f"Mitsuba's {wanted} does not run here: {error}")


def axes_in_pixels(seed):
    """Rays in each of WITHIN x WITHIN parts of the pixels, (N, 3), and the camera's up vector."""
    ahead = (TARGET - PLACE) / np.linalg.norm(TARGET - PLACE)
    right = np.cross(ahead, [0, 1, 0])
    right /= np.linalg.norm(right)
    up = np.cross(right, ahead)
    count = SIZE * WITHIN
    part = np.stack(np.meshgrid(np.arange(count), np.arange(count)), axis=-1)
    place = (part + np.random.default_rng(seed).random(part.shape)) / count
    x, y = np.moveaxis((2 * place - 1) * np.tan(np.radians(FIELD_DEG / 2)), -1, 0)
    axes = ahead + x[..., None] * right - y[..., None] * up
    return axes.reshape(-1, 3), up


def blocks(picture):
    """Means over BLOCKS x BLOCKS parts of a picture."""
    size = len(picture) // BLOCKS
    shape = (BLOCKS, size, BLOCKS, size, *picture.shape[2:])
    return picture.reshape(shape).mean(axis=(1, 3))


def ours(world, samples, repeats=REPEATS):
    """Blocks of Stokes vectors or of radiance, and their standard errors."""
    count = SIZE * WITHIN
    found = []
    for seed in range(repeats):
        axes, up = axes_in_pixels(seed)
        eye = eyes_at(np.tile(PLACE, (count * count, 1)), axes, up)
        renderer = omma.Renderer(world, eye, omma.Fixed(samples), seed=seed)
        seen = renderer.render_stokes(np.eye(4)) if world.polarized else renderer.render(np.eye(4))
        found.append(blocks(seen[0, ..., 0].reshape(count, count, -1)))
    return np.mean(found, axis=0), np.std(found, axis=0, ddof=1) / np.sqrt(repeats)


def theirs(shapes, light, samples, polarised=False, medium=None, repeats=REPEATS):
    """The same of Mitsuba: `shapes` are (Mesh, BSDF, radiance or None), `light` an emitter, all in
    a ball of `medium` where there is one."""
    path = {"type": "volpath" if medium else "path", "max_depth": -1, "rr_depth": 5}
    scene = {
        "type": "scene",
        "integrator": {"type": "stokes", "nested": path} if polarised else path,
        "light": light,
        "sensor": {
            "type": "perspective",
            "fov": FIELD_DEG,
            "to_world": mi.ScalarTransform4f().look_at(
                list(map(float, PLACE)), list(map(float, TARGET)), [0, 1, 0]
            ),
            "film": {
                "type": "hdrfilm",
                "width": SIZE,
                "height": SIZE,
                "rfilter": {"type": "box"},
                "pixel_format": "luminance",
                "component_format": "float32",
            },
        },
    }
    if medium:
        scene |= in_a_ball_of(medium)
        scene["sensor"]["medium"] = {"type": "ref", "id": "air"}
    for k, (mesh, bsdf, radiance) in enumerate(shapes):
        scene[f"shape{k}"] = mesh_of(mesh, bsdf, radiance)
    loaded = mi.load_dict(scene)
    found = [blocks(np.array(mi.render(loaded, spp=samples, seed=seed))) for seed in range(repeats)]
    return np.mean(found, axis=0), np.std(found, axis=0, ddof=1) / np.sqrt(repeats)


def in_a_ball_of(medium, radius_m=50.0):
    return {
        "air": medium,
        "ball": {
            "type": "sphere",
            "radius": radius_m,
            "bsdf": {"type": "null"},
            "interior": {"type": "ref", "id": "air"},
        },
    }


def mesh_of(mesh, bsdf, radiance, **parts):
    properties = mi.Properties()
    for name, part in parts.items():
        properties[name] = part
    properties["bsdf"] = mi.load_dict(bsdf)
    if radiance is not None:
        value = {"type": "uniform", "value": radiance}
        properties["emitter"] = mi.load_dict({"type": "area", "radiance": value})
    made = mi.Mesh("mesh", len(mesh.positions_m), len(mesh.triangles), props=properties)
    parameters = mi.traverse(made)
    parameters["vertex_positions"] = mesh.positions_m.ravel()
    parameters["faces"] = mesh.triangles.ravel()
    parameters.update()
    return made


def diffuse(reflectance):
    inner = {"type": "diffuse", "reflectance": {"type": "uniform", "value": reflectance}}
    return {"type": "twosided", "nested": inner}


def metal(roughness, index):
    """A rough conductor of index n + ik.

    Facets shade each other in another way there (ours is glTF's, in which heights of both ways go
    together), which up to a roughness of 0.25 is under 1e-4 within 70 degrees of the normal.
    """
    return {
        "type": "twosided",
        "nested": {
            "type": "roughconductor",
            "distribution": "ggx",
            "alpha": roughness**2,
            "eta": {"type": "uniform", "value": index.real},
            "k": {"type": "uniform", "value": index.imag},
        },
    }


def gloss(roughness):
    """Our dielectric lobe over black: a conductor without absorption has Fresnel's reflectance."""
    return metal(roughness, 1.5 + 0j)


def black_gloss(roughness):
    return matter(0.0, specular=1.0, ior=1.5, roughness=roughness)


def expect_same(one, other, most_share=2e-3):
    """Blocks agree within noise, which is under 1 %, and all of them together to that share."""
    (ours_mean, ours_error), (theirs_mean, theirs_error) = one, other
    scale = theirs_mean[..., :1]
    # Where nothing is random, as before the bare sky, single precision is left.
    noise = np.hypot(np.hypot(ours_error, theirs_error), 1e-5 * scale)
    assert np.sqrt(np.mean((noise / scale) ** 2)) < 0.01
    z = ((ours_mean - theirs_mean) / noise)[noise[..., 0] > 1e-4 * scale[..., 0]]
    # Errors of 12 renders: of Student's t with 11 degrees of freedom the rms is 1.1; 36 blocks
    # leave 0.15 of it open, and one in a thousand such pictures has a block beyond 5.
    assert np.sqrt(np.mean(z**2)) < 1.5
    assert np.abs(z).max() < 5
    share = (ours_mean - theirs_mean).mean(axis=(0, 1)) / scale.mean()
    assert np.abs(share).max() < most_share


FLOOR = square(3, (0, 0, 0), (0, 1, 0))
WALL = square(3, (-1, 1, 0), (1, 0, 0.2), 1)
LAMP = square(0.7, (0.4, 1.8, -0.3), (0, -1, 0), 2)
BLOCK_MESH = omma.scene.sphere(0.4, center_m=(0.1, 0.4, 0.2), segments=64).meshes[0]


def test_a_diffuse_scene():
    use_variant(False)
    ball = BLOCK_MESH.replace(material=3, normals=None)
    scene = omma.Scene(
        meshes=[FLOOR, WALL, LAMP, ball],
        materials=[matter(0.6), matter(0.3), shining(8.0), matter(0.8)],
    )
    world = omma.World(scene, light=uniform_sky(0.3, bands=BAND, unit="watts"), lighting="path")
    # Ours shines to both sides, theirs to the front.
    back = LAMP.replace(triangles=LAMP.triangles[:, ::-1])
    shapes = [
        (FLOOR, diffuse(0.6), None),
        (WALL, diffuse(0.3), None),
        (LAMP, diffuse(0.0), 8.0),
        (back, diffuse(0.0), 8.0),
        (ball, diffuse(0.8), None),
    ]
    sky = {"type": "constant", "radiance": {"type": "uniform", "value": 0.3}}
    expect_same(ours(world, 6), theirs(shapes, sky, 96))


def test_a_glossy_scene():
    use_variant(False)
    ball = BLOCK_MESH.replace(material=3)
    scene = omma.Scene(
        meshes=[FLOOR, WALL, LAMP, ball],
        materials=[black_gloss(0.25), matter(0.5), shining(8.0), black_gloss(0.25)],
    )
    world = omma.World(scene, light=uniform_sky(0.3, bands=BAND, unit="watts"), lighting="path")
    back = LAMP.replace(triangles=LAMP.triangles[:, ::-1])
    shapes = [
        (FLOOR, gloss(0.25), None),
        (WALL, diffuse(0.5), None),
        (LAMP, diffuse(0.0), 8.0),
        (back, diffuse(0.0), 8.0),
        (ball, gloss(0.25), None),
    ]
    sky = {"type": "constant", "radiance": {"type": "uniform", "value": 0.3}}
    expect_same(ours(world, 12), theirs(shapes, sky, 192))


def test_a_polarised_scene():
    use_variant(True)
    scene = omma.Scene(
        meshes=[FLOOR, WALL],
        materials=[black_gloss(0.25), matter(0.5)],
    )
    world = omma.World(
        scene, light=uniform_sky(0.3, bands=BAND, unit="watts"), polarized=True, lighting="path"
    )
    shapes = [(FLOOR, gloss(0.25), None), (WALL, diffuse(0.5), None)]
    sky = {"type": "constant", "radiance": {"type": "uniform", "value": 0.3}}
    expect_same_stokes(ours(world, 12), theirs(shapes, sky, 192, polarised=True))


def test_a_polarised_scene_of_metals():
    """Gold, at 549 nm, and aluminium: what one mirrors of the other has U too. Of facets as smooth
    as these light that they pass to each other is little; it is kept here and lost there, at a
    roughness of 0.15 up to 0.6 % of what comes back."""
    use_variant(True)
    gold, aluminium, roughness = 0.43 + 2.455j, 0.958 + 6.69j, 0.05
    ball = BLOCK_MESH.replace(material=1, normals=None)
    scene = omma.Scene(
        meshes=[FLOOR, WALL.replace(material=2), ball],
        materials=[
            LayerStack(substrate=gold).material(roughness=roughness),
            LayerStack(substrate=aluminium).material(roughness=roughness),
            matter(0.5),
        ],
    )
    world = omma.World(
        scene, light=uniform_sky(0.3, bands=BAND, unit="watts"), polarized=True, lighting="path"
    )
    shapes = [
        (FLOOR, metal(roughness, gold), None),
        (WALL, diffuse(0.5), None),
        (ball, metal(roughness, aluminium), None),
    ]
    sky = {"type": "constant", "radiance": {"type": "uniform", "value": 0.3}}
    expect_same_stokes(ours(world, 12), theirs(shapes, sky, 192, polarised=True))


def expect_same_stokes(found, pictures):
    mean, error = pictures
    # Luminance, then S0 to S3 in red, green and blue. Their axis is across the camera's up vector,
    # ours along it, and both look towards the light: Q changes its sign. Theirs turns to the left,
    # ours to the right: U does so twice.
    pick, sign = [1, 4, 7], np.array([1.0, -1.0, 1.0])
    mean, error = sign * mean[..., pick], error[..., pick]
    assert np.abs(mean[..., 2]).max() > 0.02 * mean[..., 0].mean()
    expect_same(found, (mean, error))
