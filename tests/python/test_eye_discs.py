"""The sun and other discs of the sky, as ommatidia see them: by closed forms, behind things, with
errors, in every way of sampling, by paths and baked, beside ground truth."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
from lit_checks import BAND, Floats, matter
from numpy.typing import NDArray

import omma
from omma.light import Disc, Light
from omma.photoreceptors import ImpulseResponse
from omma.scene import Bake, Mesh

RADIUS_RAD = float(np.radians(0.533 / 2))
RADIANCE = 1e6
BACKENDS = ("embree", "portable")
AHEAD = np.array([0.0, 0.0, -1.0])


def sun(**parts: object) -> Light:
    disc = Disc(AHEAD, RADIUS_RAD, [RADIANCE], **parts)  # type: ignore[arg-type]
    return Light(BAND, "watts", discs=[disc])


def empty() -> omma.Scene:
    """Something that is never in the way."""
    return omma.Scene(meshes=[Mesh([[0, -50, 50], [1, -50, 50], [0, -51, 50]], [[0, 1, 2]])])


def screen(edge: float, turn_rad: float) -> omma.Scene:
    """Hides what lies on one side of an edge, so many radii of the sun beside its centre."""
    at = edge * np.tan(RADIUS_RAD)
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    corners = [
        [a * c - b * s, a * s + b * c, -1.0]
        for a, b in ((at - 1, -1), (at, -1), (at, 1), (at - 1, 1))
    ]
    return omma.Scene(
        meshes=[Mesh(corners, [[0, 1, 2], [0, 2, 3]], material=0)], materials=[matter()]
    )


def foliage() -> omma.Scene:
    """Small triangles all over the sun, some of its own size apart."""
    random = np.random.default_rng(5)
    middle = np.column_stack([random.uniform(-0.01, 0.01, (300, 2)), -random.uniform(1, 2, 300)])
    middle[:, :2] *= -middle[:, 2:]
    corners = middle[:, None] + random.normal(0, 6e-4, (300, 3, 3)) * -middle[:, None, 2:]
    return omma.Scene(
        meshes=[Mesh(corners.reshape(-1, 3), np.arange(900).reshape(-1, 3), material=0)],
        materials=[matter()],
    )


def off_axis(angle_deg: float, turn_rad: float = 0.3) -> Floats:
    a = np.radians(angle_deg)
    return np.array([np.sin(a) * np.cos(turn_rad), np.sin(a) * np.sin(turn_rad), -np.cos(a)])


def eye_of(axis: Floats, width_deg: float, count: int = 1, **parts: object) -> omma.Eye:
    axes = np.tile(axis, (count, 1))
    return omma.Eye(np.zeros_like(axes), axes, np.radians(width_deg), **parts)  # type: ignore[arg-type]


@lru_cache(maxsize=1)
def points_on_sun(n: int) -> tuple[Floats, Floats]:
    """Directions of a midpoint rule, evenly by solid angle, (n, n, 3), and how far out they are."""
    out = np.sqrt((np.arange(n) + 0.5) / n)
    chord_2 = out**2 * 4 * np.sin(RADIUS_RAD / 2) ** 2
    sine = np.sqrt(chord_2 * (1 - chord_2 / 4))[:, None]
    turn = 2 * np.pi * (np.arange(n) + 0.5) / n
    z = np.broadcast_to(-(1 - chord_2 / 2)[:, None], (n, n))
    points = np.stack([sine * np.cos(turn), sine * np.sin(turn), z], axis=-1)
    points.flags.writeable = False
    return points, out


def sensitivity(direction: Floats, axis: Floats, width_deg: float) -> Floats:
    sine = np.linalg.norm(np.cross(direction, axis), axis=-1)
    angle = np.arctan2(sine, direction @ axis)
    return np.asarray(np.exp(-4 * np.log(2) * (angle / np.radians(width_deg)) ** 2))


@lru_cache
def normalisation(width_deg: float) -> float:
    """The integral of S over the sphere."""
    angle = (np.arange(100_000) + 0.5) / 100_000 * np.pi
    values = np.exp(-4 * np.log(2) * (angle / np.radians(width_deg)) ** 2) * np.sin(angle)
    return float(2 * np.pi * values.mean() * np.pi)


# The same for one backend as for the next.
@lru_cache(maxsize=1)
def at_points(axis: tuple[float, ...], width_deg: float, limb: float) -> Floats:
    """Light of the points on the sun, times the sensitivity there, (n, n)."""
    direction, _ = points_on_sun(1000)
    sine_2 = np.linalg.norm(direction[..., :2], axis=-1) ** 2 / np.sin(RADIUS_RAD) ** 2
    light = (1 - limb * (1 - np.sqrt(np.maximum(1 - sine_2, 0)))) / (1 - limb / 3)
    values = sensitivity(direction, np.array(axis), width_deg) * light
    values.flags.writeable = False
    return np.asarray(values)


def expected(
    axis: Floats, width_deg: float, limb: float = 0.0, seen: NDArray[np.bool_] | None = None
) -> float:
    """The response to the sun, `seen` [point] where not all of it is."""
    values = at_points(tuple(axis), width_deg, limb)
    if seen is not None:
        values = values * seen
    solid_sr = np.pi * 4 * np.sin(RADIUS_RAD / 2) ** 2
    return float(RADIANCE * solid_sr * values.mean() / normalisation(width_deg))


@lru_cache(maxsize=1)
def beside_edge(edge: float, turn_rad: float) -> NDArray[np.bool_]:
    direction, _ = points_on_sun(1000)
    x, y = direction[..., 0] / -direction[..., 2], direction[..., 1] / -direction[..., 2]
    across = x * np.cos(turn_rad) + y * np.sin(turn_rad)
    return np.asarray(across > edge * np.tan(RADIUS_RAD))


def seen_by(
    scene: omma.Scene, light: Light, eye: omma.Eye, sampling: object = None, **how: object
) -> Floats:
    backend = str(how.pop("backend", ""))
    world = omma.World(scene, light=light, lighting="path", backend=backend)
    renderer = omma.Renderer(world, eye, sampling or omma.Fixed(16), **how)  # type: ignore[arg-type]
    return renderer.render(np.eye(4)).astype(float).ravel()


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("width_deg", "off"),
    [(width, off) for width in (0.2, 0.4, 1.0, 2.6, 5.0) for off in (0.0, 0.5, 1.0, 2.0)]
    # Less than 1e-7 of what a surface gets is left out, as of wider ones there.
    + [(width, 3.0) for width in (0.2, 0.4, 1.0)],
)
def test_open_sun_is_exact(backend: str, width_deg: float, off: float) -> None:
    axis = off_axis(off * width_deg)
    found = seen_by(empty(), sun(), eye_of(axis, width_deg), backend=backend)
    # The quadrature; the bound is that of this test's own midpoint rule.
    assert found[0] == pytest.approx(expected(axis, width_deg), rel=2e-5)


def test_limb_darkening() -> None:
    axis = off_axis(0.5)
    found = seen_by(empty(), sun(limb_darkening=[0.7]), eye_of(axis, 1.0))
    assert found[0] == pytest.approx(expected(axis, 1.0, limb=0.7), rel=5e-5)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("edge", [0.0, 0.3, -0.6])
@pytest.mark.parametrize("off", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("width_deg", [1.0, 5.0])
def test_sun_half_behind_an_edge(backend: str, width_deg: float, off: float, edge: float) -> None:
    axis, turn = off_axis(off * width_deg), 0.4 + edge
    found = seen_by(screen(edge, turn), sun(), eye_of(axis, width_deg, 32), backend=backend)
    exact = expected(axis, width_deg, seen=beside_edge(edge, turn))
    error = found / exact - 1
    assert np.abs(error).max() < 0.01
    assert np.sqrt(np.mean(error**2)) < 0.005
    assert abs(error.mean()) < 0.002


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(("width_deg", "off"), [(20.0, 0.0), (20.0, 1.5), (5.0, 2.0)])
def test_a_sliver_of_the_sun_in_the_dark(backend: str, width_deg: float, off: float) -> None:
    """It is all that these see, so that its error is theirs: 7 % over the root of the rays is what
    points on the disc are chosen for."""
    axis, edge, turn = off_axis(off * width_deg), 0.8, 0.4
    exact = expected(axis, width_deg, seen=beside_edge(edge, turn))
    many, eye = eye_of(axis, width_deg, 32), eye_of(axis, width_deg)
    for rays in (16, 256):
        found = seen_by(screen(edge, turn), sun(), many, omma.Fixed(rays), backend=backend)
        error = found / exact - 1
        assert np.sqrt(np.mean(error**2)) < 0.07 / np.sqrt(rays)
        assert abs(error.mean()) < 3 * 0.07 / np.sqrt(rays * 32)
    world = omma.World(screen(edge, turn), light=sun(), lighting="path", backend=backend)
    target = omma.ToError(relative_error=0.02)
    found, report = omma.Renderer(world, eye, target, seed=3).render(np.eye(4), report=True)
    assert len(report.missed) == 0
    assert found.ravel()[0] == pytest.approx(exact, rel=3 * 0.02)


def test_sun_behind_foliage() -> None:
    """Beside a million rays along points of the sun, each an ommatidium without acceptance."""
    scene, light = foliage(), sun()
    direction, _ = points_on_sun(1000)
    rays = direction.reshape(-1, 3)
    open_ = seen_by(scene, light, omma.Eye(np.zeros_like(rays), rays, 0.0), omma.Fixed(1)) > 0
    assert 0.2 < open_.mean() < 0.8
    for width_deg in (1.0, 5.0):
        for off in (0.0, 0.5, 1.0):
            axis = off_axis(off * width_deg)
            found = seen_by(scene, light, eye_of(axis, width_deg, 32))
            error = found / expected(axis, width_deg, seen=open_.reshape(1000, 1000)) - 1
            # 0.4 % rms, so that one in a hundred is beyond 1 %.
            assert np.sqrt(np.mean(error**2)) < 0.006
            assert np.abs(error).max() < 0.015
            assert abs(error.mean()) < 0.003


def test_standard_errors_are_honest() -> None:
    turn, z = 0.7, []
    for scene, seen in (
        (screen(0.3, turn), beside_edge(0.3, turn)),
        (screen(-0.4, turn), beside_edge(-0.4, turn)),
    ):
        world = omma.World(scene, light=sun(), lighting="path")
        for width_deg, off in ((1.0, 0.5), (5.0, 0.5), (5.0, 1.0)):
            axis = off_axis(off * width_deg)
            renderer = omma.Renderer(world, eye_of(axis, width_deg, 200), omma.Fixed(16))
            response, error = renderer.render(np.eye(4), standard_error=True)
            exact = expected(axis, width_deg, seen=seen)
            z.append((response.astype(float).ravel() - exact) / error.ravel())
    # Errors of 8 scrambles: z is Student's t with 7 degrees of freedom, 1.18 wide.
    spread = np.sqrt(np.mean(np.concatenate(z) ** 2)) / np.sqrt(7 / 5)
    assert 0.9 < spread < 1.1


def test_to_an_error() -> None:
    """What is claimed holds; it may be too large, as parts of even points are less even."""
    turn = 0.7
    world = omma.World(screen(0.3, turn), light=sun(), lighting="path")
    axis = off_axis(0.5)
    exact = expected(axis, 1.0, seen=beside_edge(0.3, turn))
    renderer = omma.Renderer(world, eye_of(axis, 1.0, 200), omma.ToError(0.01 * exact))
    response, error = renderer.render(np.eye(4), standard_error=True)
    off = response.astype(float).ravel() - exact
    assert abs(off.sum()) < 0.002 * exact * 200
    assert np.sqrt(np.mean(off**2)) < np.sqrt(np.mean(error.astype(float) ** 2)) < 0.02 * exact


def test_shared_rays() -> None:
    """Every ommatidium asks for itself; its neighbours' rays leave the sun out."""
    lattice = eye_about_the_sun()
    world = omma.World(screen(0.2, 0.4), light=sun(), lighting="path")
    own = omma.Renderer(world, lattice, omma.Fixed(16)).render(np.eye(4)).astype(float)
    shared = omma.Renderer(world, lattice, omma.Shared(2))
    found = shared.render(np.eye(4)).astype(float)
    assert found.sum() == pytest.approx(own.sum(), rel=5e-3)
    assert np.abs(found - own).max() < 0.01 * own.max()
    response, error = shared.render(np.eye(4), standard_error=True)
    assert response.astype(float).sum() == pytest.approx(own.sum(), rel=5e-3)
    assert 0 < error.max() < 0.01 * own.max()


def eye_about_the_sun() -> omma.Eye:
    """Some 200 ommatidia of 3 deg, 2 deg apart, in one point."""
    angle = np.radians(2.0 * np.arange(-7, 8))
    x, y = np.meshgrid(angle, angle)
    axes = np.stack([np.sin(x), np.sin(y) * np.cos(x), -np.cos(y) * np.cos(x)], -1).reshape(-1, 3)
    return omma.Eye(np.zeros_like(axes), axes, np.radians(3.0))


def test_discs_that_fill_an_acceptance_are_found_by_rays() -> None:
    """Beyond 16 times the acceptance, and where there is none."""
    wide = float(np.radians(5.0))
    light = Light(BAND, "watts", discs=[Disc(AHEAD, wide, [RADIANCE])])
    for width_deg in (0.0, 1.0, 4.0):
        found = seen_by(empty(), light, eye_of(AHEAD, width_deg), omma.Fixed(64))
        beside = 0.0 if width_deg == 0 else 2.0 ** (-4 * (5.0 / width_deg) ** 2)  # of the Gaussian
        assert found[0] == pytest.approx(RADIANCE * (1 - beside), rel=1e-4)


def test_a_head_that_turns() -> None:
    """The mean over the time that goes into a frame, of a sun that comes into view."""
    width_deg, turn_deg = 2.0, 4.0
    world = omma.World(empty(), light=sun(), lighting="path")
    box = ImpulseResponse.box(0.01)
    renderer = omma.Renderer(
        world, eye_of(AHEAD, width_deg, 16), omma.Fixed(64), impulse_response=box
    )
    poses = omma.poses_from_angles(np.zeros((2, 3)), [[turn_deg, 0, 0], [0, 0, 0]])
    found = renderer.render(poses, times_s=[0.0, 0.01])[1].astype(float).ravel()
    angles = (np.arange(25) + 0.5) / 25 * turn_deg  # of 200 the same within 1e-7
    exact = np.mean([expected(off_axis(a, 0.0), width_deg) for a in angles])
    error = found / exact - 1
    assert np.abs(error).max() < 0.03
    assert abs(error.mean()) < 0.01


def test_what_is_unseen_hides_nothing() -> None:
    scene = screen(-2.0, 0.0)
    world = omma.World(scene, light=sun(), lighting="path")
    renderer = omma.Renderer(world, eye_of(AHEAD, 1.0), omma.Fixed(16))
    hidden = screen(2.0, 0.0)
    assert renderer.render(np.eye(4)).ravel()[0] == pytest.approx(expected(AHEAD, 1.0), rel=2e-5)
    behind = omma.Renderer(
        omma.World(hidden, light=sun(), lighting="path"), eye_of(AHEAD, 1.0), omma.Fixed(16)
    )
    assert behind.render(np.eye(4)).ravel()[0] == 0
    seen = behind.render(np.eye(4), unseen=[0])
    assert np.ravel(seen)[0] == pytest.approx(expected(AHEAD, 1.0), rel=2e-5)


def test_polarised_worlds_see_the_same() -> None:
    sky = np.ones((2, 16, 32, 3, 1), np.float32) * np.array([1, 0.3, 0.1])[:, None]
    light = Light(BAND, "watts", sky, discs=[Disc(AHEAD, RADIUS_RAD, [RADIANCE])])
    eye = eye_of(off_axis(0.4), 1.0)
    found = []
    for polarized in (False, True):
        world = omma.World(screen(0.1, 0.2), light=light, lighting="path", polarized=polarized)
        found.append(omma.Renderer(world, eye, omma.Fixed(16)).render(np.eye(4)).ravel()[0])
    assert found[0] == pytest.approx(found[1], rel=1e-4)


def sun_in_sky() -> Light:
    """The sun before an even sky."""
    return Light(BAND, "watts", np.full((2, 2, 4, 1, 1), 100.0), discs=sun().discs)


def baked(scene: omma.Scene, light: Light, backend: str, sun_by: str = "exact") -> omma.World:
    """Of large cells and few paths, as nothing in these scenes gives light back."""
    bake = Bake(cell_m=1.0, paths=16, cache=False)
    how = {"sun": sun_by, "bake": bake, "backend": backend}
    return omma.World(scene, light=light, lighting="baked", **how)  # type: ignore[arg-type]


def rendered(world: omma.World, eye: omma.Eye) -> Floats:
    renderer = omma.Renderer(world, eye, omma.Fixed(16))
    return renderer.render(np.eye(4)).astype(float).ravel()


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("sun_by", ["exact", "map"])
@pytest.mark.parametrize("width_deg", [1.0, 5.0])
def test_baked_worlds_see_the_open_sun(backend: str, sun_by: str, width_deg: float) -> None:
    """As by paths, and as the closed form has it; also before a sky, which rays find."""
    world = baked(empty(), sun(), backend, sun_by)
    under_sky = baked(empty(), sun_in_sky(), backend, sun_by)
    by_paths = under_sky.with_light(sun_in_sky(), lighting="path")
    for off in (0.0, 0.5, 1.0):
        axis = off_axis(off * width_deg)
        eye = eye_of(axis, width_deg)
        exact = expected(axis, width_deg)
        assert rendered(world, eye)[0] == pytest.approx(exact, rel=2e-5)
        # All rays meet the sky, so that its mean has no noise.
        found = rendered(under_sky, eye)[0]
        assert found == pytest.approx(100 + exact, rel=2e-5)
        assert found == pytest.approx(rendered(by_paths, eye)[0], rel=1e-6)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("sun_by", ["exact", "map"])
@pytest.mark.parametrize("width_deg", [1.0, 5.0])
@pytest.mark.parametrize("edge", [0.0, -0.6])
def test_baked_worlds_see_the_sun_beside_an_edge(
    backend: str, sun_by: str, width_deg: float, edge: float
) -> None:
    """Within the bounds of the same sun by paths; the map of the sun is for surfaces alone."""
    axis, turn = off_axis(0.5 * width_deg), 0.4 + edge
    world = baked(screen(edge, turn), sun(), backend, sun_by)
    found = rendered(world, eye_of(axis, width_deg, 32))
    error = found / expected(axis, width_deg, seen=beside_edge(edge, turn)) - 1
    assert np.abs(error).max() < 0.01
    assert np.sqrt(np.mean(error**2)) < 0.005
    assert abs(error.mean()) < 0.002


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("lighting", ["path", "baked"])
@pytest.mark.parametrize("width_deg", [1.0, 5.0])
def test_truth_is_that_of_things_before_the_sun(
    backend: str, lighting: str, width_deg: float
) -> None:
    """What rays meet is the same bits with a sun behind the edge and without, and the sun counts as
    sky; the responses beside it are those of a render."""
    scene, dark = screen(0.2, 0.4), Light(BAND, "watts")
    eye = eye_of(off_axis(0.3 * width_deg), width_deg, 8)
    velocity = (np.array([0.3, 0.1, -1.0]), np.array([0.2, -0.5, 0.1]))
    world = baked(scene, sun(), backend)
    if lighting == "path":
        world = world.with_light(sun(), lighting="path")
    truths = [
        omma.Renderer(one, eye, omma.Fixed(64)).ground_truth(
            np.eye(4), shares=[0], head_velocity=velocity
        )
        for one in (world, world.with_light(dark, lighting=lighting))
    ]
    with_sun, without = truths
    assert np.all((0.1 < with_sun.met) & (with_sun.met < 0.9))
    np.testing.assert_array_equal(with_sun.shares[..., 0], with_sun.met)
    for name in (
        "met", "distance_m", "nearest_m", "inverse_distance_per_m", "position_m", "normal",
        "shares", "flow_rotation_rad_s", "flow_translation_rad_s", "flow_rad_s",
    ):  # fmt: skip
        np.testing.assert_array_equal(getattr(with_sun, name), getattr(without, name), name)
    render = omma.Renderer(world, eye, omma.Fixed(64)).render(np.eye(4))
    np.testing.assert_array_equal(with_sun.responses, render)
    assert np.all(with_sun.responses > 0)
    assert np.all(without.responses == 0)
    # The screen is a metre ahead, so that a ray's way to it is 1 / cos of its angle; where that is
    # twice the width S is 2⁻¹⁶.
    assert np.all(with_sun.nearest_m >= 1)
    assert np.all(with_sun.distance_m < 1 / np.cos(np.radians(2 * width_deg)))
