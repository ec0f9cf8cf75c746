"""Solids and surrounds: how large they are seen, which way their faces and pictures look."""

import contextlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import omma
from omma.scene import box, corridor, cylinder, disc, drum, merge_scenes, plane, sphere

RED, GREEN, BLUE, WHITE = (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)
# Upper left, upper right, lower left, lower right.
QUARTERS = np.array([[RED, GREEN], [BLUE, WHITE]], float).repeat(32, 0).repeat(32, 1)


def ray(scene, direction, position=(0, 0, 0), background=(0.5, 0.5, 0.5)):
    """The radiance along one ray."""
    eye = omma.Eye([position], [direction], 0.0)
    sky = omma.Background.constant(background)
    return omma.Renderer(scene, eye, omma.Fixed(1), background=sky).render(np.eye(4))[0, 0].tolist()


def part_of_pillbox(scene, width_rad, samples=4096):
    """How bright a cone around -Z is to an ommatidium that is as sensitive all over it."""
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], width_rad)
    renderer = omma.Renderer(scene, eye, omma.Fixed(samples), angular_sensitivity="pillbox")
    return float(renderer.render(np.eye(4))[0, 0, 0])


def cap(angle_rad):
    """Solid angle of a cone of that half angle, over 2 pi."""
    return 1 - np.cos(angle_rad)


@pytest.mark.parametrize("radius", [0.1, 0.5, 2.0])
def test_a_disc_on_the_axis_has_its_solid_angle(radius):
    target = disc(radius, center_m=(0, 0, -3), segments=720)
    expected = cap(np.arctan(radius / 3)) / cap(np.radians(40))
    # A point set of n points finds an edge to within some n^-3/4; the polygon of 720 corners lacks
    # 1.3e-5 of the disc.
    assert part_of_pillbox(target, np.radians(80)) == pytest.approx(expected, abs=2e-3)


@pytest.mark.parametrize("radius", [0.2, 1.0, 1.9])
def test_a_sphere_has_its_solid_angle(radius):
    ball = sphere(radius, center_m=(0, 0, -3), segments=512)
    expected = cap(np.arcsin(radius / 3)) / cap(np.radians(45))
    # As above; its silhouette lies within by at most 2e-5 of the radius.
    assert part_of_pillbox(ball, np.radians(90)) == pytest.approx(expected, abs=2e-3)


SOLIDS = {
    "box": box((1, 2, 3)),
    "sphere": sphere(0.7),
    "cylinder": cylinder(0.5, 1.5),
}


def corners(scene):
    """(T, 3, 3) of all triangles in the world."""
    found = []
    for one in scene.instances:
        mesh = scene.meshes[one.mesh]
        places = mesh.positions_m @ one.world_from_mesh[:3, :3].T + one.world_from_mesh[:3, 3]
        found.append(places[mesh.triangles])
    return np.concatenate(found)


@pytest.mark.parametrize("name", SOLIDS)
def test_solids_are_closed_and_look_outwards(name):
    triangles = corners(SOLIDS[name])
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    assert (np.linalg.norm(normals, axis=1) > 1e-9).all()
    # Convex around the origin: outwards is away from it.
    assert ((normals * triangles.mean(axis=1)).sum(axis=1) > 0).all()
    # Closed: the volume by the divergence theorem is that of the hull, and each edge has two sides.
    volume = np.linalg.det(triangles).sum() / 6
    from scipy.spatial import ConvexHull

    assert volume == pytest.approx(ConvexHull(triangles.reshape(-1, 3)).volume, rel=1e-5)
    keys = np.round(triangles, 5) + 0.0
    edges = {}
    for one in keys:
        for a, b in ((0, 1), (1, 2), (2, 0)):
            edge = (tuple(one[a]), tuple(one[b]))
            edges[edge] = edges.get(edge, 0) + 1
    assert all(edges.get((b, a)) == count for (a, b), count in edges.items())


@pytest.mark.parametrize("name", SOLIDS)
def test_solids_are_seen_from_outside_only(name):
    assert ray(SOLIDS[name], (0, 0, -1), (0.1, 0.1, 5)) == [1, 1, 1]
    assert ray(SOLIDS[name], (0, 0, -1), (0.1, 0.1, 0)) == [0.5, 0.5, 0.5]


def quarters_seen(scene, position, target, side):
    """Upper left, upper right, lower left, lower right of what is at ``target``."""
    forward = np.subtract(target, position) / np.linalg.norm(np.subtract(target, position))
    above = (0, 1, 0) if abs(forward[1]) < 0.9 else (0, 0, -1)
    right = np.cross(forward, above)
    up = np.cross(right, forward)
    seen = []
    for u, v in ((-1, 1), (1, 1), (-1, -1), (1, -1)):
        to = np.add(target, side * (u * right + v * up)) - position
        seen.append(tuple(np.round(ray(scene, to / np.linalg.norm(to), position), 3)))
    return seen


@pytest.mark.parametrize("facing", [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1),
                                    (0, 0, -1), (1, 0.3, -2)])  # fmt: skip
def test_pictures_of_planes_and_discs_are_upright_and_not_mirrored(facing):
    expected = [RED, GREEN, BLUE, WHITE]
    front = 3 * np.array(facing) / np.linalg.norm(facing)
    for flat in (
        plane((2, 2), QUARTERS, facing=facing), disc(1, QUARTERS, facing=facing)
    ):  # fmt: skip
        assert quarters_seen(flat, front, (0, 0, 0), 0.4) == expected
        # From behind the same surface, mirrored.
        assert set(quarters_seen(flat, -front, (0, 0, 0), 0.4)) == set(expected)


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("sign", [-1, 1])
def test_pictures_of_boxes_are_upright_on_every_side(axis, sign):
    outside = np.zeros(3)
    outside[axis] = 4 * sign
    cube = box((2, 2, 2), QUARTERS)
    assert quarters_seen(cube, outside, outside / 4, 0.4) == [RED, GREEN, BLUE, WHITE]


@pytest.mark.parametrize("round_solid", [sphere(1, QUARTERS), cylinder(1, 2, QUARTERS)])
def test_pictures_of_round_solids_are_not_mirrored(round_solid):
    seen = quarters_seen(round_solid, (0, 0, 4), (0, 0, 1), 0.3)
    assert seen == [RED, GREEN, BLUE, WHITE]


def test_caps_have_their_own_paint():
    tin = cylinder(1, 2, QUARTERS, caps=RED)
    assert ray(tin, (0, -1, 0), (0.1, 5, 0.1)) == [1, 0, 0]
    assert ray(tin, (0, 1, 0), (0.1, -5, 0.1)) == [1, 0, 0]
    assert ray(cylinder(1, 2, GREEN), (0, -1, 0), (0, 5, 0.1)) == [0, 1, 0]


def test_the_picture_of_a_drum_is_upright_and_not_mirrored_from_within():
    around = drum(1, 2, QUARTERS)
    assert quarters_seen(around, (0, 0, 0), (0, 0, -1), 0.3) == [RED, GREEN, BLUE, WHITE]
    # Its middle is ahead; what is left of the middle lies at the left, all the way to the seam.
    assert ray(around, (-1, 0.1, 0.2)) == [1, 0, 0]
    assert ray(around, (1, 0.1, 0.2)) == [0, 1, 0]
    # From outside it is not there.
    assert ray(around, (0, 0.1, -1), (0, 0, 5)) == pytest.approx([0, 1, 0], abs=1)
    assert ray(around, (0, 0, -1), (0, -0.5, 1.5))[2] == 1


def test_a_drum_closes_without_a_gap():
    around = drum(1, 2, (1, 1, 1))
    angle = np.pi + np.linspace(-1e-3, 1e-3, 2001)  # about its seam, behind
    axes = np.stack([np.sin(angle), np.zeros_like(angle), -np.cos(angle)], -1)
    eye = omma.Eye(np.zeros((len(axes), 3)), axes, 0.0)
    black = omma.Background.constant((0, 0, 0))
    renderer = omma.Renderer(around, eye, omma.Fixed(1), background=black)
    assert (renderer.render(np.eye(4)) == 1).all()
    # The same place to the last bit, of the first and the last column of vertices.
    positions = around.meshes[0].positions_m.reshape(2, -1, 3)
    assert (positions[:, 0] == positions[:, -1]).all()


def test_a_wave_around_a_drum_has_no_edge_at_the_seam():
    columns = 512
    wave = 0.5 + 0.5 * np.cos(2 * np.pi * (np.arange(columns) + 0.5) / columns)
    around = drum(1, 2, np.repeat(wave[None, :, None], 3, axis=2).repeat(4, 0), repeats=3)
    azimuth = np.linspace(-np.pi, np.pi, 721)
    axes = np.stack([np.sin(azimuth), np.zeros_like(azimuth), -np.cos(azimuth)], -1)
    eye = omma.Eye(np.zeros((len(axes), 3)), axes, 0.0)
    seen = omma.Renderer(around, eye, omma.Fixed(1)).render(np.eye(4))[0, :, 0]
    # Interpolation between 512 columns is within (pi / 512)^2 / 2 of the cosine; sides are flat
    # over 1 degree, which shifts it by 1e-5.
    expected = 0.5 + 0.5 * np.cos(3 * azimuth + 3 * np.pi)
    assert seen == pytest.approx(expected, abs=2e-4)


def test_sharp_stripes_have_two_values_and_their_width():
    around = drum(0.15, 0.4, [[[0.0, 0, 0], [1, 1, 1]]], repeats=36, sharp=True)
    azimuth = np.radians(np.arange(-180, 180, 0.1) + 0.05)
    axes = np.stack([np.sin(azimuth), np.zeros_like(azimuth), -np.cos(azimuth)], -1)
    eye = omma.Eye(np.zeros((len(axes), 3)), axes, 0.0)
    seen = omma.Renderer(around, eye, omma.Fixed(1)).render(np.eye(4))[0, :, 0]
    assert set(seen.tolist()) == {0, 1}
    # 72 edges, 5 degrees apart; the first is behind, dark to its right.
    assert (seen.reshape(72, 50) == (np.arange(72) % 2)[:, None]).all()


def test_pictures_of_a_corridor_are_not_mirrored_from_within():
    hall = corridor(
        4, 2, 2, QUARTERS, QUARTERS, floor=QUARTERS, ceiling=(0.2, 0.2, 0.2),
    )  # fmt: skip
    inside = (0, 1, -2)
    expected = [RED, GREEN, BLUE, WHITE]
    assert quarters_seen(hall, inside, (-1, 1, -2), 0.5) == expected
    assert quarters_seen(hall, inside, (1, 1, -2), 0.5) == expected
    assert quarters_seen(hall, inside, (0, 0, -2), 0.4) == expected
    assert ray(hall, (0, 1, 0), inside) == pytest.approx([0.2, 0.2, 0.2])
    assert ray(hall, (0, 0, -1), inside) == [0.5, 0.5, 0.5]  # open
    assert hall.bounds == pytest.approx(np.array([[-1, 0, -4], [1, 2, 0]]))
    assert {one.name for one in omma.World(hall).instances} == {
        "corridor left", "corridor right", "corridor floor", "corridor ceiling",
    }  # fmt: skip


def test_a_corridor_repeats_its_grating():
    hall = corridor(
        3, 1, 1, [[[0.0, 0, 0], [1, 1, 1]]], RED, picture_length_m=0.2, sharp=True
    )  # fmt: skip
    z = -np.arange(0.025, 3, 0.05)
    eye = omma.Eye(np.stack([0 * z, 0 * z + 0.5, z], -1), np.tile([-1, 0, 0], (len(z), 1)), 0.0)
    seen = omma.Renderer(hall, eye, omma.Fixed(1)).render(np.eye(4))[0, :, 0]
    # The left wall begins at z = 0, at the left of who looks at it: 0.1 m dark, 0.1 m bright.
    assert seen.tolist() == [0, 0, 1, 1] * 15


def test_things_move_under_their_names():
    world = omma.World(merge_scenes([box(name="a", center_m=(0, 0, -3)), sphere(name="b")]))
    there = np.eye(4)
    there[:3, 3] = 0, 9, 0
    world.set_transforms("b", there)
    assert world.instances[1].world_from_node[1, 3] == 9
    tin = omma.World(cylinder(paint=QUARTERS, name="tin"))
    assert [one.name for one in tin.instances] == ["tin"]


WRONG = {
    "size_m: expected shape (3,)": lambda: box(1),
    "size_m: expected 3 numbers above 0": lambda: box((1, -1, 1)),
    "radius_m: expected a number above 0": lambda: sphere(0.0),
    "segments: expected 3 to": lambda: disc(segments=2),
    "facing: expected a direction": lambda: plane(facing=(0, 0, 0)),
    "center_m: expected three finite": lambda: disc(center_m=(0, np.nan, 0)),
    "paint: expected a colour": lambda: box(paint=(1, 2)),
    "paint: expected a colour of finite": lambda: box(paint=(1, -2, 0)),
    "paint: pixels: expected": lambda: box(paint=np.zeros((2, 2, 5))),
    "wall: expected numbers": lambda: drum(1, 1, {"a": 1}),
    "left: expected a colour": lambda: corridor(1, 1, 1, 0.5, WHITE),
    "repeats: expected 1 to": lambda: drum(1, 1, WHITE, repeats=0),
}


@pytest.mark.parametrize("message", WRONG)
def test_what_is_wrong_is_said(message):
    with pytest.raises(omma.Error) as caught:
        WRONG[message]()
    assert str(caught.value).startswith(message)


numbers = st.floats(allow_nan=True) | st.integers(-3, 3)


@settings(max_examples=100, deadline=None)
@given(st.lists(numbers, max_size=4), numbers, st.lists(numbers, min_size=3, max_size=3))
def test_nonsense_gives_errors_or_finite_solids(size, radius, place):
    for make in (
        lambda: box(size, center_m=place),
        lambda: sphere(radius, center_m=place, segments=8),
        lambda: disc(radius, facing=place),
        lambda: drum(radius, 1.0, size),
    ):
        with contextlib.suppress(omma.Error, TypeError):
            assert np.isfinite(make().bounds).all()


@pytest.mark.parametrize("solid", [box, sphere, cylinder, plane, disc])
def test_materials_are_paint(solid):
    matt = omma.scene.Material("matt", base_color=(0.2, 0.3, 0.4), specular=0)
    assert set(solid(paint=matt).materials) == {matt}
    textured = matt.replace(emissive_texture=0)
    with pytest.raises(omma.Error, match=r"paint: .* without textures.*found emissive_texture"):
        solid(paint=textured)
