"""What the window shows is what is rendered, number by number, and the command and the lines of
Python on it give the same."""

import shlex
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from animated_scenes import swinging_box
from conftest import make_eye
from view_checks import LEVEL, ROLLED, rotations, sources

import omma
from omma.scene.light_words import parse_light
from omma.view.command import Sources, path_text, render_command, render_python
from omma.view.path_files import poses_of_csv
from omma.view.poses import HeadPose, pose_from_matrix
from omma.view.scene_mesh import drawn_scene
from omma.view.state import Look, Looker, finer


def test_a_pose_is_what_a_transform_is_but_for_its_rounding():
    for matrix in rotations(200):
        found = pose_from_matrix(matrix).world_from_head
        # A micrometre, and half of 1e-4 degrees of each of three angles.
        assert np.abs(found - matrix).max() < 5e-6
    assert pose_from_matrix(np.diag([2.0, 2, 2, 1])) == HeadPose()
    assert HeadPose((0, 0, 0), 370.0) == HeadPose((0, 0, 0), 10.0)


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e9])
def test_a_pose_that_is_none_is_refused(bad):
    with pytest.raises(omma.Error, match="pose"):
        HeadPose((bad, 0, 0))
    with pytest.raises(omma.Error, match="angles"):
        HeadPose((0, 0, 0), np.nan)


def test_what_is_seen_is_what_the_renderer_renders(looker):
    look = Look(LEVEL, samples=4)
    seen = looker.see(look)
    plain = omma.Renderer(looker.world, looker.eye, omma.Fixed(4)).render(LEVEL.world_from_head)
    assert np.array_equal(seen.responses, plain[0])
    assert seen.errors is None
    assert np.ptp(seen.responses) > 0.1
    still = [seen]
    while still[-1].samples < 16:
        still.append(looker.see(look, *finer(still[-1])))
    assert [(one.samples, one.standard_error) for one in still] == [
        (4, False), (4, True), (8, True), (16, True),
    ]  # fmt: skip
    again = omma.Renderer(looker.world, looker.eye, omma.Fixed(16))
    responses, errors = again.render(LEVEL.world_from_head, standard_error=True)
    assert np.array_equal(still[-1].responses, responses[0])
    assert np.array_equal(still[-1].errors, errors[0])
    assert np.median(still[-1].errors) < np.median(still[1].errors)
    assert finer(looker.see(look, 64, True)) is None


@pytest.mark.parametrize("pose", [LEVEL, ROLLED, HeadPose((0, 1, 0), pitch_deg=90.0)])
@pytest.mark.parametrize(("factor", "error"), [(1.0, False), (1.5, True)])
def test_the_command_renders_the_same_numbers(
    ground, looker, run_omma, monkeypatch, pose, factor, error
):
    monkeypatch.chdir(ground)
    seen = looker.see(Look(pose, samples=4, acceptance_factor=factor), 4, error)
    command, why = render_command(sources(ground), seen)
    assert why is None
    for line in command.splitlines():
        words = shlex.split(line)
        if words[0] == "printf":
            subprocess.run(line, shell=True, check=True)
        else:
            assert run_omma(*words[1:])[0] == 0
    assert np.array_equal(np.load("view.npy")[0], seen.responses)
    if error:
        assert np.array_equal(np.load("view.error.npy")[0], seen.errors)


@pytest.mark.parametrize("pose", [LEVEL, ROLLED])
@pytest.mark.parametrize("receptors", [False, True])
def test_the_lines_of_python_give_the_same_numbers(ground, pose, receptors):
    eye = make_eye(30).replace(
        receptor_types=[omma.receptors.ReceptorType("green", peak_wavelength_nm=540)],
        receptors=[0],
    )
    omma.save_eye(ground / "plain.csv", eye)
    world = omma.World(omma.load_scene(ground / "ground.gltf"))
    looker = Looker(world, omma.load_eye(ground / "plain.csv"))
    look = Look(pose, samples=4, acceptance_factor=0.8, receptors=receptors)
    for seen in (looker.see(look), looker.see(look, 8, True)):
        names = {}
        exec(render_python(sources(ground), seen), names)
        expected = seen.receptors if receptors else seen.responses
        assert np.array_equal(names["responses"][0], expected)
        if seen.standard_error:
            errors = seen.receptor_errors if receptors else seen.errors
            assert np.array_equal(names["errors"][0], errors)


def test_the_command_and_the_lines_of_python_light_the_world(ground, run_omma, monkeypatch):
    words = "overcast_sky sun_elevation_deg=40 bands=3 ultraviolet=dark lighting=path"
    monkeypatch.chdir(ground)
    omma.save_eye("plain.csv", make_eye(30))
    world = omma.World(omma.load_scene("ground.gltf"), **parse_light(words))
    seen = Looker(world, omma.load_eye("plain.csv")).see(Look(LEVEL, samples=4))
    lit = replace(sources(ground), light=words, lit=True)
    names = {}
    exec(render_python(lit, seen), names)
    assert np.array_equal(names["responses"][0], seen.responses)
    command, why = render_command(lit, seen)
    assert why is None
    assert run_omma(*shlex.split(command.splitlines()[-1])[1:])[0] == 0
    assert np.array_equal(np.load("view.npy")[0], seen.responses)


def test_there_is_no_command_where_none_renders_it(looker, ground):
    seen = looker.see(Look(LEVEL, samples=1))
    assert "made in Python" in render_command(Sources(), seen)[1]
    assert "made in Python" in render_command(Sources("a", ("b",), lit=True), seen)[1]
    moving = omma.view.Seen(Look(LEVEL, time_s=0.5), 1, False, None, None, None, None, 0.0)
    assert "no time" in render_command(sources(ground), moving)[1]


def test_a_recorded_path_is_one_that_is_read(looker):
    looks = [Look(LEVEL), Look(ROLLED)]
    poses, times_s = poses_of_csv("path.csv", path_text(looks).encode())
    assert times_s is None
    expected = np.stack([one.pose.world_from_head for one in looks])
    # A level pose is made by a point to look at, which is rounded too.
    assert np.abs(poses - expected).max() < 5e-6
    with pytest.raises(omma.Error, match=r"mine\.csv, line 1: expected a header"):
        poses_of_csv("mine.csv", b"nonsense\n")


def test_time_moves_what_animations_move(tmp_path):
    world = omma.World(swinging_box(tmp_path / "box.gltf"))
    looker = Looker(world, make_eye(40))
    seen = looker.see(Look(samples=4, time_s=0.5))
    other = omma.World(swinging_box(tmp_path / "box.gltf"))
    expected = omma.Renderer(other, make_eye(40), omma.Fixed(4)).render(np.eye(4), times_s=[0.5])
    assert np.array_equal(seen.responses, expected[0])
    assert looker.duration_s == 1.0
    # Half way it is half a metre aside; what is drawn is drawn where the file has it, and moved.
    ((k, _),) = drawn_scene(world).moving
    assert np.allclose(world.instances[k].world_from_node[:3, 3], [0.5, 0, -3])


def test_bad_settings_are_refused_by_name(looker):
    for changes, name in (
        ({"samples": 0}, "samples"),
        ({"samples": 10**9}, "samples"),
        ({"acceptance_factor": 0.0}, "acceptance_factor"),
        ({"acceptance_factor": 1e9}, "acceptance_factor"),
        ({"time_s": float("nan")}, "time_s"),
    ):
        with pytest.raises(omma.Error, match=name):
            Look(**changes)
    with pytest.raises(omma.Error, match="noise"):
        Looker(looker.world, looker.eye, noise="new_every_frame")
