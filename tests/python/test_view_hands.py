"""What hands do on the window's page: keys, flying, cameras, rays, saved pictures."""

import io
import json
from pathlib import Path

import numpy as np
import pytest
from conftest import make_eye, write_gltf
from view_checks import wait_for

import omma
from omma.view.keys import KEYS, page_settings
from omma.view.poses import HeadPose

PAGE_FILES = Path(omma.__file__).parent / "view" / "page_files"
DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture
def window(tmp_path):
    pytest.importorskip("viser", reason="viser (omma[view]) is not installed")
    cameras = [
        (name, None, {"translation": [x, 1.0, 4]}) for x, name in enumerate(("one", "two", "three"))
    ]
    write_gltf(tmp_path / "ground.gltf", cameras=cameras)
    scene = omma.load_scene(tmp_path / "ground.gltf")
    with omma.view.show(scene, make_eye(40), port=0) as window:
        wait_for(lambda: window.seen is not None)
        yield window


@pytest.fixture
def do(window):
    files = []

    def do(what, **more):
        window._page.hands.take({"do": what, **more}, files.append)
        return files

    return do


def fly(do, **ways):
    do("fly", client=-1, **{"ahead": 0, "right": 0, "up": 0, "yaw": 0, "pitch": 0, **ways})


def test_flying_goes_at_the_speed_that_is_set(window, do):
    window.go_to(HeadPose((0, 1, 4), 90.0))
    head = window._page.tabs.head
    head.speed_m_s = 2.0
    fly(do, ahead=0.5, up=-0.1)
    x, y, z = window.look.pose.position_m
    assert (x, y, z) == pytest.approx((1.0, 0.8, 4.0), abs=1e-5)
    do("faster")
    assert head.speed_m_s == 2.5
    do("slower")
    do("speed", factor=0.5)
    assert head.speed_m_s == 1.0
    fly(do, right=1.0)
    assert window.look.pose.position_m == pytest.approx((1.0, 0.8, 5.0), abs=1e-5)
    # However often.
    for _ in range(100):
        do("slower")
    assert head.speed_m_s == 1e-4


def test_the_view_turns_and_does_not_turn_over(window, do):
    window.go_to(HeadPose((0, 1, 4)))
    fly(do, yaw=30.0, pitch=20.0)
    assert (window.look.pose.yaw_deg, window.look.pose.pitch_deg) == (30.0, 20.0)
    fly(do, pitch=300.0)
    assert window.look.pose.pitch_deg == 89.0
    fly(do, pitch=-10.0)
    assert window.look.pose.pitch_deg == 79.0
    steep = HeadPose((0, 1, 4), 0.0, 89.9)
    window.go_to(steep)
    fly(do, pitch=5.0)
    assert window.look.pose == steep


def test_keys_go_from_camera_to_camera(window, do):
    found = []
    for what in ("next_camera",) * 4 + ("previous_camera",) * 2:
        do(what)
        found.append(window.look.pose.position_m[0])
    assert found == [0, 1, 2, 0, 2, 1]


def test_rays_double_and_halve(window, do):
    found = []
    for what in ("more_rays",) * 5 + ("fewer_rays",) * 8:
        do(what)
        found.append(window.look.samples)
    assert found == [8, 16, 32, 64, 64, 32, 16, 8, 4, 2, 1, 1, 1]
    assert window._page.tabs._rays.value == 1


def test_a_saved_picture_is_the_one_that_is_shown(window, do):
    from PIL import Image

    wait_for(lambda: window.seen.samples == 64)
    window._page.choose(3)
    files = do("save")
    wait_for(lambda: files)
    pixels = np.asarray(Image.open(io.BytesIO(files[0])))
    ids = window._page._ids()
    assert pixels.shape == (*ids.shape, 3)
    expected = omma.picture.display(window.seen.responses[None])[0]
    # The picked one's frame is no part of what the animal sees.
    assert np.array_equal(pixels[ids >= 0], expected[ids[ids >= 0]])


def test_what_makes_no_sense_is_told_and_changes_nothing(window, do, monkeypatch):
    told = []
    monkeypatch.setattr(window._page, "tell_error", lambda error: told.append(str(error)))
    before = window.look
    for message in (
        {"do": "fly"},
        {"do": "fly", "ahead": "x"},
        {"do": "fly", "ahead": float("nan"), "right": 0, "up": 0, "yaw": 0, "pitch": 0},
        {"do": "pick", "x": None, "y": 0},
        {"do": "speed", "factor": True},
        {"do": "step_aside"},
        {"do": "nonsense"},
        {},
    ):
        told.clear()
        window._page.hands.take(message, print)
        assert len(told) == 1
        assert told[0].startswith("page: ")
    assert window.look == before
    assert window._page.tabs.head.speed_m_s > 0


def test_all_keys_are_known_and_listed():
    settings = json.loads(page_settings())
    keys = [key for one in settings["keys"] for key in one["keys"]]
    assert len(keys) == len(set(keys))
    assert len(settings["help"]) > len(KEYS)
    scripts = "".join(path.read_text() for path in PAGE_FILES.glob("*.js"))
    page = (DOCS / "view.md").read_text()
    for one in KEYS:
        assert one.shown in page, one
    for what in ("layout", "fly", "help", "leave"):
        assert f"{what}: ()" in scripts


def test_each_key_does_what_it_says(window, do, monkeypatch):
    told = []
    monkeypatch.setattr(window._page, "tell_error", told.append)
    for one in KEYS:
        if one.does not in ("layout", "fly", "help", "leave"):
            do(one.does)
    assert not told
