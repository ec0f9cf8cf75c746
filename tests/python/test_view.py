"""A window into the eye, without a browser: what is shown is what is rendered, who gets in, what is
said when something is wrong, and that nothing is left at the end."""

import json
import shlex
import socket
import struct
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request
from dataclasses import replace

import numpy as np
import pytest
from animated_scenes import swinging_box
from conftest import make_eye, write_gltf

import omma
from omma.scene.light_words import parse_light
from omma.view.command import Sources, path_text, render_command, render_python
from omma.view.door import Door, listening_socket
from omma.view.live import Live
from omma.view.painting import (
    channels_of,
    eye_ids,
    paint_eye,
    shown_values,
    unseen_in,
    white_of,
)
from omma.view.path_files import poses_of_csv
from omma.view.picked import cone_of, ommatidium_looking_at, ommatidium_towards, rays_of
from omma.view.poses import HeadPose, pose_from_matrix
from omma.view.scene_mesh import drawn_scene
from omma.view.state import Look, Looker, finer, refined
from omma.view.window import _files_of

LEVEL = HeadPose((0.3, 1.2, 4.0), yaw_deg=12.5, pitch_deg=-20.0)
ROLLED = HeadPose((0.3, 1.2, 4.0), yaw_deg=12.5, pitch_deg=-20.0, roll_deg=33.0)


@pytest.fixture
def ground(tmp_path):
    """A coloured ground as a file, and an eye as a file beside it."""
    write_gltf(tmp_path / "ground.gltf", cameras=[("bee", None, {"translation": [0, 1.0, 4]})])
    omma.save_eye(tmp_path / "plain.csv", make_eye(40))
    return tmp_path


@pytest.fixture
def looker(ground):
    world = omma.World(omma.load_scene(ground / "ground.gltf"), threads=1)
    return Looker(world, omma.load_eye(ground / "plain.csv"), threads=1)


def sources(folder):
    return Sources(str(folder / "ground.gltf"), (str(folder / "plain.csv"),))


def wait_for(condition, seconds=60.0):
    """Waits for what another thread does; fails where it never does."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def rotations(count):
    rng = np.random.default_rng(3)
    for _ in range(count):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        matrix = np.eye(4)
        matrix[:3, :3] = turn * np.sign(np.linalg.det(turn))
        matrix[:3, 3] = rng.normal(size=3)
        yield matrix


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
    still = refined(looker, look, most=16)
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
    poses = poses_of_csv("path.csv", path_text(looks).encode())
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


def test_rays_are_those_that_are_rendered(looker):
    look = Look(LEVEL, samples=16)
    below = int(np.argmin(looker.eye.axis[:, 1]))
    rays = rays_of(looker, look, below, 16)
    seen = looker.see(look)
    assert np.allclose(rays.radiance.mean(axis=0), seen.responses[below], atol=1e-6)
    assert np.allclose(np.linalg.norm(rays.direction, axis=1), 1)
    # They meet the ground, which is at y = 0 and 20 m wide.
    ends = rays.start_m + rays.distance_m[:, None] * rays.direction
    met = np.isfinite(rays.distance_m)
    assert met.any()
    assert np.abs(ends[met, 1]).max() < 1e-4
    # Each alone, looked along by an eye of its own, brings what it brought.
    single = omma.Eye(rays.start_m, rays.direction, 1e-6)
    alone = omma.Renderer(looker.world, single, omma.Fixed(1), footprints=False).render(np.eye(4))
    plain = omma.Renderer(looker.world, looker.eye, omma.Fixed(16), footprints=False)
    exact = plain.render_rays(LEVEL.world_from_head)[0, below]
    # Directions are read from a picture of 1024 x 512, to some 1e-3 rad at worst; the ground is
    # 1.2 m away and goes from one colour to another in 20 m.
    assert np.abs(alone[0] - exact).max() < 1e-4
    assert np.abs(exact - exact.mean(axis=0)).max() > 5e-3


def test_what_is_clicked_on_is_what_is_picked(looker):
    look = Look(LEVEL, samples=1)
    pose = LEVEL.world_from_head
    for wanted in (3, 17):
        axis = pose[:3, :3] @ looker.eye.axis[wanted].astype(float)
        # On the head as it is drawn, 0.1 m in radius, from 1 m outside.
        start = pose[:3, 3] + axis
        found = ommatidium_looking_at(looker, look, start, -axis, 0.1)
        assert found == wanted
    # On the ground, from high above it: whoever looks at that place.
    place = np.array([1.0, 0.0, 2.0])
    start = np.array([1.5, 5.0, 1.0])
    found = ommatidium_looking_at(looker, look, start, place - start, 1e-3)
    assert found == ommatidium_towards(looker.eye, (place - pose[:3, 3]) @ pose[:3, :3])
    assert ommatidium_looking_at(looker, look, start, np.array([0, 1.0, 0]), 1e-3) is None


def test_a_cone_is_where_sensitivity_is_half():
    eye = make_eye(3).replace(acceptance=omma.Acceptance.gaussian(0.2, 0.1, 0.3))
    directions = cone_of(eye, 1, 16)
    axis, up = eye.axis[1].astype(float), eye.up[1].astype(float)
    theta = np.arccos(directions @ axis)
    azimuth = np.arctan2(directions @ np.cross(axis, up), directions @ up)
    assert np.allclose(eye.acceptance(1).eval(theta, azimuth), 0.5, atol=1e-4)
    assert np.ptp(theta) > 0.04


def test_pictures_show_what_was_rendered(looker):
    seen = looker.see(Look(LEVEL, samples=4))
    channels = {one.name: one for one in channels_of(looker.world, looker.eye)}
    assert list(channels) == ["colours", "red", "green", "blue"]
    ids = eye_ids(looker.eye, "Mollweide", 400)
    colours = shown_values(looker.world, looker.eye, seen, channels["colours"])
    hidden = unseen_in(ids, "Mollweide")
    pixels = paint_eye(ids, colours, 1.0, 0.0, hidden=hidden)
    assert np.array_equal(
        pixels, omma.picture.project(looker.eye, seen.responses, "mollweide", 400)
    )
    in_green = shown_values(looker.world, looker.eye, seen, channels["green"])
    green = paint_eye(ids, in_green, 1, 0, hidden=hidden)
    assert np.array_equal(green[..., 0], pixels[..., 1])
    assert np.array_equal(green[..., 0], green[..., 2])
    brighter = paint_eye(ids, colours, 1.0, 1.0, hidden=hidden)
    assert np.array_equal(
        brighter, omma.picture.project(looker.eye, 2 * seen.responses, "mollweide", 400)
    )
    chosen = int(ids[100, 200])
    marked = (paint_eye(ids, colours, 1.0, 0.0, chosen, hidden) != pixels).any(axis=2)
    assert marked.any()
    assert not marked[ids == chosen].any()
    with pytest.raises(omma.Error, match="projection: expected one of"):
        eye_ids(looker.eye, "none", 400)


def test_worlds_that_are_lit_are_shown_by_band_and_in_colours(ground):
    light = omma.light.overcast_sky(40, bands=omma.light.Bands.equal(4, 400, 700))
    world = omma.World(
        omma.load_scene(ground / "ground.gltf"), light=light, lighting="path", depth=1
    )
    looker = Looker(world, make_eye(200))
    channels = {one.name: one for one in channels_of(world, looker.eye)}
    assert list(channels)[:2] == ["colours", "band 0, 438 nm"]
    assert len(channels) == 5
    seen = looker.see(Look(LEVEL, samples=4))
    colours = shown_values(world, looker.eye, seen, channels["colours"])
    assert np.array_equal(colours, omma.picture.bands_to_rgb(seen.responses, light))
    band = shown_values(world, looker.eye, seen, channels["band 0, 438 nm"])
    assert np.array_equal(band[:, 0], seen.responses[:, 0])
    # Radiance in photons, 1e17 and more, is shown by what nearly all of it stays below.
    white = white_of(world, channels["band 0, 438 nm"], band)
    assert 0.9 < np.mean(band[:, 0] <= white) < 1
    assert white > 1e10
    command, why = render_command(Sources("a", ("b",), lit=True), seen)
    assert (command, "made in Python" in why) == ("", True)


def test_receptors_are_shown_by_kind(ground):
    eye = omma.receptors.assign_receptors(make_eye(60), omma.receptors.honeybee_ommatidia())
    world = omma.World(omma.load_scene(ground / "ground.gltf"))
    looker = Looker(world, eye, ultraviolet=np.array([0, 0, 1.0]))
    channels = {one.name: one for one in channels_of(world, eye)}
    seen = looker.see(Look(LEVEL, samples=4, receptors=True))
    plain = omma.Renderer(world, eye, omma.Fixed(4))
    expected = plain.render_receptors(LEVEL.world_from_head, ultraviolet=(0, 0, 1))
    assert np.array_equal(seen.receptors, expected[0])
    false = shown_values(world, eye, seen, channels["receptors, false colours"])
    assert false.shape == (60, 3)
    for column, name in enumerate(("green", "blue", "ultraviolet")):
        one = shown_values(world, eye, seen, channels[f"receptor {name}"])
        assert np.allclose(one[:, 0], false[:, column])
        assert np.array_equal(one[:, 0], one[:, 2])
    assert np.ptp(false) > 0.01


def test_things_in_many_places_are_stored_once():
    box = omma.scene.box((0.1, 0.1, 0.1))
    mesh = box.meshes[0]
    places = []
    for k in range(10):
        matrix = np.eye(4)
        matrix[:3, 3] = (k, 0, 0)
        places.append(omma.scene.Instance(0, matrix))
    scene = omma.Scene(meshes=[mesh.replace(material=None)], instances=places)
    still = drawn_scene(omma.World(scene)).still
    length = struct.unpack_from("<I", still, 12)[0]
    document = json.loads(still[20 : 20 + length])
    roots = document["scenes"][0]["nodes"]
    assert len(roots) == 1
    given = document["nodes"][roots[0]]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]
    accessor = document["accessors"][given["TRANSLATION"]]
    view = document["bufferViews"][accessor["bufferView"]]
    start = 20 + length + 8 + view["byteOffset"]
    found = np.frombuffer(still[start : start + view["byteLength"]], "<f4").reshape(-1, 3)
    assert np.array_equal(np.sort(found[:, 0]), np.arange(10))


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


def test_an_error_does_not_end_the_work(looker):
    frames, errors = [], []
    live = Live(looker, Look(LEVEL), on_seen=frames.append, on_still=lambda _: None,
                on_error=errors.append)  # fmt: skip

    def broken():
        raise omma.Error("that cannot be done")

    live.refine(False)
    live.start()
    try:
        wait_for(lambda: frames)
        live.do(broken)
        wait_for(lambda: errors)
        live.want(Look(ROLLED))
        wait_for(lambda: frames[-1].look == Look(ROLLED))
    finally:
        live.close()
    assert str(errors[0]) == "that cannot be done"
    assert not any(one.name == "omma-view-render" for one in threading.enumerate())


def test_what_is_done_piece_by_piece_does_not_stop_frames(looker):
    frames, steps = [], []
    live = Live(looker, Look(LEVEL), on_seen=frames.append, on_still=lambda _: None,
                on_error=print)  # fmt: skip

    def step():
        steps.append(len(frames))
        live.want(Look(HeadPose((0, 1, len(steps) / 10))))
        return len(steps) < 20

    live.refine(False)
    live.start()
    try:
        wait_for(lambda: frames)
        live.do(step)
        wait_for(lambda: len(steps) == 20)
    finally:
        live.close()
    # A frame between each two steps.
    assert np.array_equal(np.diff(steps), np.ones(19))


def test_what_holds_still_gets_finer(looker):
    frames = []
    live = Live(looker, Look(LEVEL, samples=16), on_seen=frames.append, on_still=lambda _: None,
                on_error=print)  # fmt: skip
    live.start()
    try:
        wait_for(lambda: frames and frames[-1].samples == 64)
    finally:
        live.close()
    assert [(one.samples, one.standard_error) for one in frames] == [
        (16, False), (16, True), (32, True), (64, True),
    ]  # fmt: skip


# Who gets in.


class Inner:
    """Stands for viser: answers with what it was asked."""

    def __init__(self):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.heads = []
        threading.Thread(target=self.run, daemon=True).start()

    def run(self):
        while True:
            try:
                connection, _ = self.listener.accept()
            except OSError:
                return
            with connection:
                self.heads.append(connection.recv(65536))
                connection.sendall(b"HTTP/1.1 200 OK\r\nContent-Length: 5\r\n\r\ninner")


@pytest.fixture
def make_door():
    made, inner, clicks = [], Inner(), []

    def make(token="", check_host=True):
        listener = listening_socket("127.0.0.1", 0)
        made.append(
            Door(listener, inner.port, secret="s3cret", token=token, check_host=check_host,
                 on_click=lambda *click: clicks.append(click))
        )  # fmt: skip
        return made[-1], inner, clicks

    yield make
    for door in made:
        door.close()
    inner.listener.close()
    assert not any(one.name == "omma-view-door" for one in threading.enumerate())


def ask(port, path="/", method="GET", **headers):
    """Status and body of a request."""
    request = urllib.request.Request(f"http://127.0.0.1:{port}{path}", method=method)
    for name, value in headers.items():
        request.add_header(name, value)
    try:
        with urllib.request.urlopen(request, timeout=20) as answer:
            return answer.status, answer.read()
    except urllib.error.HTTPError as error:
        return error.code, error.read()


def test_the_token_opens_and_nothing_else(make_door):
    door, inner, _ = make_door(token="abc123", check_host=False)
    assert ask(door.port, "/abc123/") == (200, b"inner")
    assert ask(door.port, "/abc123/page.js?x=1") == (200, b"inner")
    first = inner.heads[-1].split(b"\r\n")[0]
    assert first == b"GET /page.js?x=1 HTTP/1.1"
    assert b"X-Omma-Door: s3cret" in inner.heads[-1]
    assert b"abc123" not in first
    before = len(inner.heads)
    for path in ("/", "/abc12", "/abc1234/", "/?abc123", "/ABC123/", "//abc123/", "/x/abc123/"):
        status, text = ask(door.port, path)
        assert status == 403
        assert b"token" in text
    for path in ("/eye.mjpeg", "/x/eye.mjpeg"):
        assert ask(door.port, path)[0] == 403
    # Web sockets too.
    for path in ("/", "/wrong"):
        assert ask(door.port, path, Upgrade="websocket", Connection="Upgrade")[0] == 403
    assert len(inner.heads) == before


def test_a_second_request_on_a_connection_does_not_slip_through(make_door):
    door, inner, _ = make_door(token="abc123", check_host=False)
    with socket.create_connection(("127.0.0.1", door.port), timeout=20) as connection:
        good = b"GET /abc123/ HTTP/1.1\r\nHost: x\r\n\r\n"
        connection.sendall(good + b"GET /secret HTTP/1.1\r\nHost: x\r\n\r\n")
        while connection.recv(65536):
            pass
    assert len(inner.heads) == 1
    assert b"/secret" not in inner.heads[0]


def test_other_pages_and_other_names_are_kept_out(make_door):
    door, inner, _ = make_door()
    assert ask(door.port)[0] == 200
    assert ask(door.port, Host=f"localhost:{door.port}")[0] == 200
    before = len(inner.heads)
    assert ask(door.port, Host="evil.example")[0] == 403
    assert ask(door.port, Host="127.0.0.1.evil.example")[0] == 403
    assert ask(door.port, Origin="http://evil.example")[0] == 403
    upgrade = {"Upgrade": "websocket", "Connection": "Upgrade"}
    assert ask(door.port, Origin="http://evil.example", **upgrade)[0] == 403
    assert ask(door.port, Origin=f"http://127.0.0.1:{door.port}", **upgrade)[0] == 200
    assert ask(door.port, "/", method="DELETE")[0] == 405
    assert len(inner.heads) == before + 1


def test_nonsense_at_the_door_is_answered(make_door):
    door, _, _ = make_door()
    for head in (b"\r\n\r\n", b"GET\r\n\r\n", b"GET / HTTP/2\r\n\r\n", b"\xff\x00 / x\r\n\r\n",
                 b"GET / HTTP/1.1\r\nno colon\r\n\r\n", b"x" * 100_000):  # fmt: skip
        with socket.create_connection(("127.0.0.1", door.port), timeout=20) as connection:
            connection.sendall(head)
            if not head.endswith(b"\r\n\r\n"):
                connection.shutdown(socket.SHUT_WR)
            try:
                answer = connection.recv(65536)
            except ConnectionResetError:
                continue  # the rest was not read
            assert answer == b"" or answer.startswith(b"HTTP/1.1 400")
    assert ask(door.port)[0] == 200


def test_clicks_and_pictures_go_through_the_door(make_door):
    door, _, clicks = make_door()
    assert ask(door.port, "/eye.click?x=0.25&y=0.5", method="POST")[0] == 204
    assert clicks == [("eye", 0.25, 0.5)]
    for query in ("", "?x=2&y=0", "?x=nan&y=0", "?x=a&y=0"):
        assert ask(door.port, f"/eye.click{query}", method="POST")[0] == 400
    door.show("eye", b"first")
    with urllib.request.urlopen(f"http://127.0.0.1:{door.port}/eye.mjpeg", timeout=20) as stream:
        assert stream.headers["Content-Type"].startswith("multipart/x-mixed-replace")
        assert b"first" in stream.read(90)
        door.show("eye", b"second")
        found = b""
        while b"second" not in found:
            found += stream.read(1)
    # A browser that is gone is no trouble for the next.
    assert ask(door.port)[0] == 200


def test_a_port_in_use_is_said():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(omma.Error, match=f"port: {port} is in use"):
            listening_socket("127.0.0.1", port)
    with pytest.raises(omma.Error, match="host: "):
        listening_socket("no.such.host.invalid", 0)
    with pytest.raises(omma.Error, match=r"host: cannot listen at 192\.0\.2\.1"):
        listening_socket("192.0.2.1", 0)


# With viser.


@pytest.fixture
def window(ground):
    pytest.importorskip("viser", reason="viser (omma[view]) is not installed")
    scene = omma.load_scene(ground / "ground.gltf")
    eye = omma.load_eye(ground / "plain.csv")
    before = set(threading.enumerate())
    with omma.view.show(scene, eye, port=0, samples=4) as window:
        yield window
    # Its pool's threads end when they next look.
    wait_for(lambda: not [one for one in set(threading.enumerate()) - before if one.is_alive()])


def test_a_window_shows_what_is_rendered_and_leaves_nothing(window):
    wait_for(lambda: window.seen is not None and window.seen.samples == 64)
    scene = omma.load_scene(window._page.sources.scene)
    eye = omma.load_eye(window._page.sources.eyes[0])
    renderer = omma.Renderer(scene, eye, omma.Fixed(64))
    responses, errors = renderer.render(window.look.pose.world_from_head, standard_error=True)
    assert np.array_equal(window.seen.responses, responses[0])
    assert np.array_equal(window.seen.errors, errors[0])
    assert window.look.pose == HeadPose((0, 1.0, 4.0))
    window.go_to(ROLLED)
    wait_for(lambda: window.seen.look.pose == ROLLED)
    status, page = ask(int(window.url.rsplit(":", 1)[1].strip("/")))
    assert status == 200
    assert b"<html" in page
    assert window.url in window._repr_html_()
    window.close()
    assert "closed" in repr(window)
    with pytest.raises(urllib.error.URLError):
        urllib.request.urlopen(window.url, timeout=5)


def test_a_lit_world_opens_and_another_band_has_a_white_of_its_own(ground):
    pytest.importorskip("viser", reason="viser (omma[view]) is not installed")
    sky = omma.light.clear_sky(40.0, bands=omma.light.Bands.equal(4, 400, 700))
    scene = omma.load_scene(ground / "ground.gltf")
    world = omma.World(scene, light=sky, lighting="path", depth=1)
    with omma.view.show(world, make_eye(50), port=0) as window:
        page = window._page
        wait_for(lambda: window.seen is not None)
        assert page.white == 1.0
        page.show_channel("band 2, 588 nm")
        wait_for(lambda: page.white != 1.0)
        # Of this band, in photons, and not of the colours that were shown before.
        assert page.white > 1e10


def test_only_what_files_give_has_a_command(ground):
    scene = omma.load_scene(ground / "ground.gltf")
    eye = omma.load_eye(ground / "plain.csv")
    assert _files_of(omma.World(scene), [eye]).scene.endswith("ground.gltf")
    assert len(_files_of(omma.World(scene), [eye, eye]).eyes) == 2
    wider = omma.eye.set_acceptance(eye, factor=2)
    white = omma.Background.constant((1, 1, 1))
    moved = omma.World(scene)
    moved.set_transforms(0, np.diag([2.0, 1, 1, 1]))
    for world, one in (
        (omma.World(scene), wider),
        (omma.World(scene), make_eye(3)),
        (omma.World(scene, background=white), eye),
        (omma.World(scene.replace(background=white)), eye),
        (moved, eye),
    ):
        assert _files_of(world, [one]) == Sources()


def test_viser_itself_lets_nobody_in_but_by_the_door(window):
    import viser
    from websockets.exceptions import ConnectionClosed
    from websockets.sync.client import connect

    inner = window._server.get_port()
    protocol = [f"viser-v{viser.__version__}"]
    stranger = connect(f"ws://127.0.0.1:{inner}", subprotocols=protocol)
    with stranger, pytest.raises(ConnectionClosed):
        stranger.recv(timeout=20)
    with connect(window.url.replace("http", "ws"), subprotocols=protocol) as socket_of_browser:
        assert len(socket_of_browser.recv(timeout=20)) > 100


def test_others_need_the_token(ground):
    pytest.importorskip("viser", reason="viser (omma[view]) is not installed")
    import viser
    from websockets.exceptions import InvalidStatus
    from websockets.sync.client import connect

    scene = omma.load_scene(ground / "ground.gltf")
    with omma.view.show(scene, make_eye(5), host="0.0.0.0", port=0) as window:
        port, token = window.url.removeprefix("http://0.0.0.0:").strip("/").split("/")
        assert len(token) > 30
        assert ask(port)[0] == 403
        assert ask(port, f"/{token}/")[0] == 200
        protocol = [f"viser-v{viser.__version__}"]
        for path in ("", "/", "/nonsense"):
            with pytest.raises(InvalidStatus):
                connect(f"ws://127.0.0.1:{port}{path}", subprotocols=protocol)
        with connect(f"ws://127.0.0.1:{port}/{token}", subprotocols=protocol) as browser:
            assert len(browser.recv(timeout=20)) > 100
        with omma.view.show(scene, make_eye(5), host="0.0.0.0", port=0) as other:
            assert other.url.split("/")[3] != token


def test_bad_input_of_a_window_is_said_and_leaves_nothing(ground):
    pytest.importorskip("viser", reason="viser (omma[view]) is not installed")
    scene = omma.load_scene(ground / "ground.gltf")
    eye = make_eye(5)
    before = threading.active_count()
    with pytest.raises(omma.Error, match="port"):
        omma.view.show(scene, eye, port=99999)
    with pytest.raises(omma.Error, match=r"nothing\.csv"):
        omma.view.show(scene, eye, port=0, path="nothing.csv")
    with pytest.raises(omma.Error, match="pose"):
        omma.view.show(scene, eye, port=0, pose=np.zeros((4, 4)))
    taken = socket.create_server(("127.0.0.1", 0))
    with taken, pytest.raises(omma.Error, match="in use"):
        omma.view.show(scene, eye, port=taken.getsockname()[1])
    assert threading.active_count() == before


def test_the_command_says_where_and_ends_with_ctrl_c(ground):
    pytest.importorskip("viser", reason="viser (omma[view]) is not installed")
    words = [sys.executable, "-m", "omma", "view", "ground.gltf", "--eye", "plain.csv",
             "--no-browser", "--port", "0"]  # fmt: skip
    with subprocess.Popen(
        words, cwd=ground, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as program:
        url = program.stdout.readline().strip()
        assert url.startswith("http://127.0.0.1:")
        assert ask(int(url.rsplit(":", 1)[1].strip("/")))[0] == 200
        program.send_signal(2)
        out, err = program.communicate(timeout=60)
    assert (program.returncode, err) == (0, "")
    assert "viser" not in out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nothing.gltf", "--eye", "plain.csv"], "nothing.gltf"),
        (["ground.gltf", "--eye", "nothing.csv"], "nothing.csv"),
        (["ground.gltf", "--eye", "empty.csv"], "empty.csv"),
        (["ground.gltf", "--eye", "plain.csv", "--camera", "x"], "camera"),
        (["ground.gltf", "--eye", "plain.csv", "--look-at", "0", "0", "0"], "--look-at"),
        (["ground.gltf", "--eye", "plain.csv", "--host", "no.such.invalid"], "--host"),
        (["ground.gltf"], "--eye"),
    ],
)
def test_the_command_says_what_is_wrong(ground, run_omma, monkeypatch, words, said):
    pytest.importorskip("viser", reason="viser (omma[view]) is not installed")
    monkeypatch.chdir(ground)
    header = (ground / "plain.csv").read_text().splitlines()[0]
    (ground / "empty.csv").write_text(header + "\n")
    code, _, err = run_omma("view", *words, "--no-browser", "--port", "0")
    assert code != 0
    assert err.count("\n") == 1
    assert said in err


def test_without_viser_it_says_what_to_install(ground, monkeypatch):
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(omma.Error, match=r"pip install 'omma\[view\]'"):
        omma.view.show(omma.load_scene(ground / "ground.gltf"), make_eye(5))


def test_nothing_of_it_is_loaded_with_the_package():
    code = "import omma, sys; omma.view; print([m for m in ('viser', 'PIL') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
