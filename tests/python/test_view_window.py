"""The window into the eye with viser, without a browser: that it shows what is rendered, who gets
in, what is said when something is wrong, and that nothing is left at the end."""

import socket
import subprocess
import sys
import threading
import urllib.error
import urllib.request

import numpy as np
import pytest
from animated_scenes import swinging_box
from conftest import make_eye
from view_checks import ROLLED, ask, wait_for

import omma
from omma.base.poses import load_timed_poses
from omma.view.command import Sources
from omma.view.path_files import poses_of_csv
from omma.view.poses import HeadPose
from omma.view.window import _files_of


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
    status, page = ask(window._page._door.port, "/view/")
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


def test_a_page_behind_a_proxy_has_a_token_and_the_address_there(ground):
    pytest.importorskip("viser", reason="viser (omma[view]) is not installed")
    scene = omma.load_scene(ground / "ground.gltf")
    proxy = "https://lab.example/bees"
    with omma.view.show(scene, make_eye(5), port=0, proxy=proxy) as window:
        assert window.url.startswith("https://lab.example/bees/")
        token = window.url.removeprefix("https://lab.example/bees/").strip("/")
        assert len(token) > 30
        port = window._page._door.port
        assert ask(port, f"/{token}/", Host="inner:80")[0] == 200
        assert ask(port, f"/bees/{token}/", Host="inner:80")[0] == 200
        assert ask(port, "/view/", Host="inner:80")[0] == 403


def test_a_path_with_times_moves_the_scene(tmp_path):
    """As `omma render --path` does, whether it is asked for at first or opened on the page."""
    pytest.importorskip("viser", reason="viser (omma[view]) is not installed")
    scene = swinging_box(tmp_path / "box.gltf")
    path = tmp_path / "path.csv"
    rows = [f"{time_s},0,{0.1 * k},0,0,0,0" for k, time_s in enumerate((0.25, 0.5, 7))]
    path.write_text("t_s,x,y,z,yaw_deg,pitch_deg,roll_deg\n" + "\n".join(rows) + "\n")
    poses, times_s = load_timed_poses(path)
    eye = make_eye(30)
    seen = omma.Renderer(scene, eye, omma.Fixed(4)).render(poses, times_s=times_s)
    with omma.view.show(scene, eye, port=0, samples=4, path=str(path)) as window:
        tabs = window._page.tabs
        for number, time_s in enumerate(times_s):
            tabs._go_to(number)
            assert window.look.time_s == time_s
            assert tabs._time.value == min(time_s, 1)
            wait_for(lambda: window.seen is not None and window.seen.look == window.look)
            assert window.look.pose.position_m[1] == pytest.approx(0.1 * number)
            found = tabs.page.looker.see(window.look, samples=4).responses
            assert found == pytest.approx(seen[number], abs=1e-6)
        path.write_text("x,y,z,yaw_deg,pitch_deg,roll_deg\n0,0,0,0,0,0\n0,1,0,0,0,0\n")
        tabs._take_path(*poses_of_csv("other.csv", path.read_bytes()))
        tabs._go_to(1)
        assert window.look.time_s == 7


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
    with pytest.raises(omma.Error, match=r"pose: expected one pose \(4, 4\), found 2"):
        omma.view.show(scene, eye, port=0, pose=[np.eye(4)] * 2)
    with pytest.raises(omma.Error, match="proxy: expected the address"):
        omma.view.show(scene, eye, port=0, proxy="lab.example")
    taken = socket.create_server(("127.0.0.1", 0))
    with taken, pytest.raises(omma.Error, match="in use"):
        omma.view.show(scene, eye, port=taken.getsockname()[1])
    assert threading.active_count() == before


@pytest.mark.parametrize("name", ["viser", "aiohttp"])
def test_without_viser_it_says_what_to_install(ground, monkeypatch, name):
    monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(omma.Error, match=r"pip install 'omma\[view\]'"):
        omma.view.show(omma.load_scene(ground / "ground.gltf"), make_eye(5))


def test_nothing_of_it_is_loaded_with_the_package():
    names = ("viser", "PIL", "aiohttp")
    code = f"import omma, sys; omma.view.show; print([m for m in {names} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
