"""First light: worlds are lit by paths unless baking is asked for by name, and whoever waits is
told for what and how long."""

import io
import os
import re
import signal
import subprocess
import sys
import time

import pytest
from conftest import make_eye
from lit_checks import BAND, matter, square
from rich.progress import BarColumn

import omma
from omma.cli import working
from omma.cli.working import DelayedBar, times_of
from omma.scene.building import BAKING, BUILDING, build_world
from omma.scene.light_words import full_words, words_of_before

SKY = omma.light.uniform_sky(1.0, bands=BAND)
SMALL = omma.Scene(meshes=[square(1, (0, 0, 0), (0, 1, 0))], materials=[matter(0.5)])


def test_paths_unless_baking_is_asked_for():
    world = omma.World(SMALL, light=SKY)
    assert (world.lighting, world.baked) == ("path", None)
    assert omma.World(SMALL).with_light(SKY).lighting == "path"
    assert world.with_light(SKY, depth=2).lighting == "path"
    baked = world.with_light(SKY, lighting="baked", bake=omma.scene.Bake(cache=False))
    assert baked.lighting == "baked"
    assert baked.with_light(SKY.scaled(2)).lighting == "baked"  # as the world was


def test_each_stage_has_its_name():
    told = []
    world = build_world(SMALL, lambda *stage: told.append(stage), light=SKY)
    assert {stage for stage, _ in told} == {BUILDING}
    assert world.lighting == "path"
    told.clear()
    world = build_world(
        SMALL,
        lambda *stage: told.append(stage),
        light=SKY,
        lighting="baked",
        bake=omma.scene.Bake(cell_m=0.05, cache=False),
    )
    assert world.lighting == "baked"
    stages = [stage for stage, _ in told]
    assert stages == sorted(stages, key=lambda stage: stage.startswith(BAKING))
    # What it takes is told before it is baked.
    cells = rf"{BAKING} \({world.baked.cells:,} cells, \d+ MB.*\)"
    assert re.fullmatch(cells, told[-1][0])
    assert told[-1][1] == 1.0
    with pytest.raises(omma.Error, match="depth: expected None"):
        build_world(SMALL, lambda *_: None, light=SKY, lighting="baked", depth=2)


def test_where_stderr_is_no_terminal_lines_say_how_far_it_is(monkeypatch):
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr(working, "LINE_EVERY_S", 0.05)
    with DelayedBar() as bar:
        for done in (0.0, 0.25, 0.5):
            bar.show(BAKING, done)
            time.sleep(0.12)
    lines = stream.getvalue().splitlines()
    assert re.fullmatch(r"omma: Baking light: 50 %, \d s elapsed, \d s left", lines[-1])
    monkeypatch.setattr(working, "LINE_EVERY_S", 10.0)
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    with DelayedBar() as bar:
        bar.show(BAKING, 0.5)
    assert stream.getvalue() == ""


def test_where_no_share_is_known_none_is_told():
    """After a stage whose share was known too."""
    bar = DelayedBar()
    bar.show(BAKING, 0.5)
    bar.show("Preparing the page", None)
    task, columns = bar._bar.tasks[0], bar._bar.columns
    assert task.total is None
    shown = [str(column(task)) for column in columns if not isinstance(column, BarColumn)]
    assert "Preparing the page" in shown
    assert not [one for one in shown if "%" in one or "left" in one]


def test_of_what_is_done_no_time_is_left():
    """Files may still be closed after the last of it: "0 s left" for a minute would be wrong."""
    bar = DelayedBar()
    for done in (0.0, 0.5, 1.0):
        bar.show("Verifying", done)
    assert times_of(bar._bar.tasks[0]) == "0 s elapsed"


def test_a_command_that_bakes_says_so_and_what_is_kept(tmp_path):
    omma.scene.save_scene(tmp_path / "plane.glb", SMALL)
    omma.save_eye(tmp_path / "bug.csv", make_eye(10))
    program = (
        "import sys; from omma.cli import working; working.LINE_EVERY_S = 0.2\n"
        "from omma.scene import Bake, lighting; lighting.Bake = lambda: Bake(paths=4096)\n"
        "from omma.cli.main import main; sys.exit(main())"
    )
    words = "uniform_sky ultraviolet=dark lighting=baked"
    command = [sys.executable, "-c", program, "render", "plane.glb", "--eye", "bug.csv"]
    command += ["--light", words, "-o", "view.npy"]
    environment = os.environ | {"OMMA_CACHE": str(tmp_path / "cache")}
    with subprocess.Popen(
        command, cwd=tmp_path, env=environment, stderr=subprocess.PIPE, text=True
    ) as ran:
        line = ran.stderr.readline()
        # It has begun, and has said what it takes.
        while not re.match(r"omma: Baking light \([\d,]+ cells, \d+ MB.*\): [1-9]\d* %", line):
            assert line, "ended before it baked"
            line = ran.stderr.readline()
        ran.send_signal(signal.SIGINT)
        _, err = ran.communicate(timeout=60)
    assert ran.returncode == 130
    assert "omma: error: interrupted: " in err
    assert "kept" in err
    assert not (tmp_path / "view.npy").exists()


def test_what_files_tell_says_how_it_was_lit():
    assert full_words("uniform_sky radiance=2") == "uniform_sky radiance=2 lighting=path"
    assert full_words("uniform_sky lighting=baked") == "uniform_sky lighting=baked"
    # Omma baked where nothing was said, before paths became the default.
    assert words_of_before("uniform_sky radiance=2") == "uniform_sky radiance=2 lighting=baked"
    assert words_of_before("uniform_sky depth=2") == "uniform_sky depth=2 lighting=path"
    assert words_of_before("uniform_sky lighting=path") == "uniform_sky lighting=path"
    assert words_of_before(None) is None


def test_the_time_left_does_not_jump_about():
    """Where work is twice as fast for a minute and then slower again, the time left goes by that
    of minutes."""
    bar = DelayedBar()
    now = 0.0
    bar._bar.get_time = lambda: now
    total, done, left = 60 * 45.0, 0.0, []
    bar.show("Rendering", 0.0)
    while done < total:
        now += 1.0
        done += 2.0 if now // 60 % 2 else 1.0
        bar.show("Rendering", min(done / total, 1.0))
        if now > 300 and done < 0.9 * total:
            left.append(bar._bar.tasks[0].time_remaining * 1.5 / (total - done))
    # Of five minutes two or three are fast ones: 1.4 to 1.6 a second beside the mean, 1.5. Times
    # are whole seconds.
    assert 0.93 < min(left) <= max(left) < 1.08
