"""Worlds and renderers as pickles: what they are made of, and the same bits."""

import copy
import pickle

import numpy as np
import pytest
from conftest import make_eye

import omma


def again(*things):
    return pickle.loads(pickle.dumps(things))


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"sampling": omma.ToError(0.05, most=64)},
        {"sampling": omma.ToError(0.05, least=16)},
        {"sampling": omma.Shared(4)},
        {"angular_sensitivity": "pillbox", "points": "random", "seed": 7, "footprints": False},
        {"noise": "new_every_frame", "backend": "portable", "threads": 2},
    ],
    ids=str,
)
def test_a_renderer_again_gives_the_same_bits(scene, flight, options):
    eye = make_eye(100, acceptance_deg=20)
    renderer = omma.Renderer(scene, eye, **options)
    (other,) = again(renderer)
    expected = renderer.render(flight, standard_error=True)
    for one, two in zip(other.render(flight, standard_error=True), expected, strict=True):
        assert (one == two).all()
    assert repr(other) == repr(renderer)
    assert other.eye == eye
    # As it was asked for: another eye, other settings.
    assert repr(other.with_eye(eye, seed=3)) == repr(renderer.with_eye(eye, seed=3))


def test_frames_count_from_0_again(scene, eye, flight):
    renderer = omma.Renderer(scene, eye, omma.Fixed(2), noise="new_every_frame")
    first = renderer.render(flight)
    second = renderer.render(flight)
    assert (first != second).any()
    for other in (*again(renderer), copy.copy(renderer)):
        assert (other.render(flight) == first).all()
        assert (other.render(flight) == second).all()
    third = renderer.render(flight)
    assert (third == renderer.render(flight, first_pose=2 * len(flight))).all()


def test_receptors_bands_and_backgrounds_again(scene, flight):
    eye = omma.receptors.assign_receptors(make_eye(50), omma.receptors.honeybee_ommatidia())
    world = omma.World(
        scene,
        background=omma.Background.constant((0.1, 0.2, 0.3)),
        band_from_rgb=np.eye(3)[[2, 1, 0, 0]],
    )
    renderer = omma.Renderer(world, eye, omma.Fixed(4))
    matrix = np.linspace(0, 1, 4 * len(eye.receptor_types)).reshape(-1, 4)
    (other,) = again(renderer)
    assert (other.world.band_from_rgb == world.band_from_rgb).all()
    for one, two in zip(
        other.render_receptors(flight, matrix=matrix, standard_error=True),
        renderer.render_receptors(flight, matrix=matrix, standard_error=True),
        strict=True,
    ):
        assert (one == two).all()


def moved(world, height):
    pose = np.eye(4)
    pose[1, 3] = height
    world.set_transforms("ground", pose)


@pytest.mark.parametrize("backend", ["", "portable"])
def test_what_has_moved_is_where_it_was(scene, eye, flight, backend):
    world = omma.World(scene, backend=backend)
    renderer = omma.Renderer(world, eye, omma.Fixed(4))
    before = renderer.render(flight)
    moved(world, -0.5)
    there = renderer.render(flight)
    assert (there != before).any()
    (other,) = again(renderer)
    assert (other.render(flight) == there).all()
    # Which is another world: what moves here stays there.
    moved(world, 0.0)
    assert (other.render(flight) == there).all()


def test_renderers_of_one_world_share_it_again(scene, eye, flight):
    world = omma.World(scene)
    night = world.with_background(omma.Background.constant((0, 0, 0)))
    one, two, dark = again(
        omma.Renderer(world, eye, omma.Fixed(2)),
        omma.Renderer(world, make_eye(20), omma.Fixed(2)),
        omma.Renderer(night, eye, omma.Fixed(2)),
    )
    assert one.world is two.world
    assert repr(dark.world._background) == repr(omma.Background.constant((0, 0, 0)))
    before = one.render(flight), two.render(flight), dark.render(flight)
    moved(one.world, -0.5)
    for renderer, responses in zip((one, two, dark), before, strict=True):
        assert (renderer.render(flight) != responses).any()


def test_copies(scene, eye, flight):
    renderer = omma.Renderer(scene, eye, omma.Fixed(2))
    shallow, deep = copy.copy(renderer), copy.deepcopy(renderer)
    assert copy.copy(renderer.world) is renderer.world
    assert shallow.world is renderer.world
    assert shallow is not renderer
    assert deep.world is not renderer.world
    before = renderer.render(flight)
    moved(renderer.world, -0.5)
    assert (shallow.render(flight) != before).any()
    assert (deep.render(flight) == before).all()


def test_as_many_threads_as_were_asked_for(scene, eye):
    for threads in (0, 1, 2):
        renderer = omma.Renderer(scene, eye, threads=threads)
        (other,) = again(renderer)
        assert other.threads == renderer.threads
        assert other.world.threads == renderer.world.threads
        # 0 is kept as such, so that another machine takes its own number.
        assert other.__reduce__()[1][1]["threads"] == threads


@pytest.mark.parametrize("kind", ["World", "Renderer"])
def test_pickles_of_another_version_are_refused(scene, eye, kind):
    renderer = omma.Renderer(scene, eye)
    make, arguments = (renderer if kind == "Renderer" else renderer.world).__reduce__()
    *before, state = arguments
    ours = state["format"]
    message = f"pickle of {kind}: expected format {ours}, found {ours + 1}"
    with pytest.raises(omma.Error, match=message):
        make(*before, state | {"format": ours + 1})
