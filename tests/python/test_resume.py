"""``--resume``: a render of a path that was cut off goes on, to the same bits, or says why not."""

import json
import re
import shutil
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import make_eye

import omma
from omma.base import processors
from omma.base.files import WholeFiles
from omma.job import pieces
from omma.rendering.response_files import Piece

POSES = 30


@pytest.fixture
def folder(files, tmp_path, monkeypatch):
    """scene.gltf, bug.eye and path.csv, to be changed; pieces grow however slow the disk is."""
    monkeypatch.setattr("omma.job.pieces._KEPT_PIECE_S", 1e9)
    for name in ("scene.gltf", "bug.eye"):
        shutil.copy(files / name, tmp_path)
    lines = [f"{0.1 * i:g},1,0,{3 * i},0,0" for i in range(POSES)]
    text = "\n".join(["x,y,z,yaw_deg,pitch_deg,roll_deg", *lines])
    (tmp_path / "path.csv").write_text(text + "\n")
    return tmp_path


def render(folder, *outputs, resume=True, **settings):
    given = {
        "eyes": folder / "bug.eye",
        "path": folder / "path.csv",
        "sampling": omma.Fixed(4),
    } | settings
    given["noise"] = "new_every_frame"  # frames differ by their numbers, which pieces must know
    names = [folder / name for name in outputs]
    return omma.render_file(folder / "scene.gltf", names, resume=resume, **given)


class CutOffError(Exception):
    pass


def cut_off(folder, *outputs, piece=3, **settings):
    """Renders, and ends while that piece is written; each is eight times as long as the last."""
    written = []

    def progress(stage, fraction):
        written.extend([stage] if stage == "Writing" else [])
        if len(written) == piece:
            raise CutOffError

    with pytest.raises(CutOffError):
        render(folder, *outputs, progress=progress, **settings)


def contents(folder, pattern):
    """What is in the files; of what `.json` files say not when and by which call."""
    found = {path.name: path.read_bytes() for path in folder.glob(pattern)}
    for name in found:
        if name.endswith(".json"):
            found[name] = json.loads(found[name])
            for said in ("created", "command"):
                del found[name]["attributes"][said]
    return found


@pytest.mark.parametrize(
    ("outputs", "settings"),
    [
        (["out.npy"], {}),
        (["out.csv"], {}),
        (["out.npy", "out.csv"], {"standard_error": True, "seed": 5}),
        (["out.npy", "out.csv"], {"sampling": omma.ToError(0.02), "standard_error": True}),
        (["out.png", "out.npy"], {"width": 32}),
        (["out.png"], {"width": 32, "threads": 1}),
    ],
)
def test_the_same_bits(folder, outputs, settings):
    whole = render(folder, *outputs, resume=False, **settings)
    expected = contents(folder, "out*")
    for path in folder.glob("out*"):
        path.unlink()
    cut_off(folder, *outputs, **settings)
    assert json.loads((folder / (outputs[0] + ".resume")).read_text())["done"] == 9
    report = render(folder, *outputs, **settings | {"threads": 2})
    assert contents(folder, "out*") == expected  # and no .partial, no .resume
    assert report.view.endswith("resumed at pose 9")
    assert (report.rays, report.poses, report.outputs) == (whole.rays, whole.poses, whole.outputs)
    assert report.spent == whole.spent


def test_receptors(folder):
    eye = omma.receptors.assign_receptors(make_eye(), omma.receptors.honeybee_ommatidia())
    omma.save_eye(folder / "bee.csv", eye)
    settings = {"eyes": folder / "bee.csv", "receptors": True, "ultraviolet": (0, 0, 1)}
    render(folder, "out.npy", "out.csv", resume=False, **settings)
    expected = contents(folder, "out*")
    cut_off(folder, "out.npy", "out.csv", **settings)
    render(folder, "out.npy", "out.csv", **settings)
    assert contents(folder, "out*") == expected


def test_cut_off_again_and_again(folder):
    render(folder, "out.npy", resume=False)
    expected = contents(folder, "out*")
    for _ in range(4):
        cut_off(folder, "out.npy", piece=2)  # one pose further each time
    render(folder, "out.npy")
    assert contents(folder, "out*") == expected


def test_what_was_written_but_not_recorded_is_written_anew(folder):
    render(folder, "out.npy", resume=False)
    expected = contents(folder, "out*")
    cut_off(folder, "out.npy")
    with (folder / "out.npy.partial").open("ab") as file:  # as after a loss of power
        file.write(b"\0" * 12345)
    render(folder, "out.npy")
    assert contents(folder, "out*") == expected


def test_without_its_partial_file_it_begins_anew(folder):
    cut_off(folder, "out.npy")
    (folder / "out.npy.partial").unlink()
    assert "resumed" not in render(folder, "out.npy").view
    assert sorted(p.name for p in folder.glob("out*")) == ["out.json", "out.npy"]


def change_path(folder):
    path = folder / "path.csv"
    path.write_text(path.read_text().replace("0.1,1,", "0.1,1.5,"))


def change_eye(folder):
    omma.save_eye(folder / "bug.eye", make_eye(60, seed=9))


def change_scene(folder):
    path = folder / "scene.gltf"
    path.write_text(path.read_text() + "\n")


@pytest.mark.parametrize(
    ("change", "settings", "says"),
    [
        (change_path, {}, "path.csv has changed"),
        (change_eye, {}, "bug.eye has changed"),
        (change_scene, {}, "scene.gltf has changed"),
        (None, {"sampling": omma.Fixed(8)}, "samples was 4, is 8"),
        (None, {"seed": 1}, "seed was '0', is '1'"),
        (None, {"background": "1,1,1"}, "background was None, is '1,1,1'"),
        (None, {"standard_error": True}, "standard_error was False, is True"),
    ],
)
def test_other_inputs_are_refused(folder, change, settings, says):
    cut_off(folder, "out.npy")
    if change:
        change(folder)
    before = contents(folder, "out*")
    with pytest.raises(omma.Error, match=f"out.npy.resume: .*{re.escape(says)}.*Remove it"):
        render(folder, "out.npy", **settings)
    assert contents(folder, "out*") == before


def test_another_instruction_set_is_refused(folder, monkeypatch):
    cut_off(folder, "out.npy")
    record = folder / "out.npy.resume"
    said = json.loads(record.read_text())
    monkeypatch.setattr(processors, "processor_flags", lambda: frozenset({"an x86"}))
    assert said["made_from"].pop("instruction_set") != "SSE2"
    with pytest.raises(omma.Error, match=r"instruction_set was '.*', is 'SSE2'.*Remove it"):
        render(folder, "out.npy")
    record.write_text(json.dumps(said))  # as older versions wrote it
    assert render(folder, "out.npy").view.endswith("resumed at pose 9")


def test_a_full_disk_says_what_is_kept(folder):
    """Files that may not grow: as a full disk, the system refuses to write on."""
    render(folder, "out.npy", resume=False)
    expected = contents(folder, "out*")
    code = (
        "import resource, signal, sys, omma\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "pieces = []\n"
        "def limit(stage, share):\n"
        "    pieces.extend([stage] if stage == 'Writing' else [])\n"
        "    if len(pieces) == 3:\n"
        "        resource.setrlimit(resource.RLIMIT_FSIZE, (600, 600))\n"
        "scene, eye, path, out = sys.argv[1:]\n"
        "omma.render_file(scene, out, omma.Fixed(4), eyes=eye, path=path, resume=True,\n"
        "                 noise='new_every_frame', progress=limit)\n"
    )
    names = ("scene.gltf", "bug.eye", "path.csv", "out.npy")
    command = [sys.executable, "-c", code, *(folder / name for name in names)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert "9 of 30 poses are kept; mend that and run the same command again" in done.stderr
    assert "out.npy" in done.stderr
    assert render(folder, "out.npy").view.endswith("resumed at pose 9")
    assert contents(folder, "out*") == expected


def test_files_that_the_scene_names_count_too(folder):
    picture = folder / "a picture.png"
    omma.save_png(picture, np.zeros((2, 2, 3), np.uint8))
    path = folder / "scene.gltf"
    document = json.loads(path.read_text())
    path.write_text(json.dumps(document | {"images": [{"uri": "a%20picture.png"}]}))
    cut_off(folder, "out.npy")
    omma.save_png(picture, np.ones((2, 2, 3), np.uint8))
    with pytest.raises(omma.Error, match=r"a picture\.png has changed"):
        render(folder, "out.npy")


def test_a_background_picture_counts_too(folder):
    picture = folder / "sky.png"
    omma.save_png(picture, np.zeros((2, 4, 3), np.uint8))
    cut_off(folder, "out.npy", background=str(picture))
    omma.save_png(picture, np.ones((2, 4, 3), np.uint8))
    with pytest.raises(omma.Error, match=r"sky\.png has changed"):
        render(folder, "out.npy", background=str(picture))


@pytest.mark.parametrize(
    "text", ["", "{}", "[]", '{"made_from": 1, "done": 1, "seconds": 0, "bytes": 3, "spent": null}']
)
def test_a_record_that_is_none(folder, text):
    (folder / "out.npy.resume").write_text(text)
    with pytest.raises(omma.Error, match="is no record of a render that was cut off"):
        render(folder, "out.npy")


def test_only_of_a_path(folder):
    with pytest.raises(omma.Error, match="resume: expected a path of poses"):
        render(folder, "out.npy", path=None)
    with pytest.raises(omma.Error, match="resume: expected a background as text"):
        render(folder, "out.npy", background=omma.Background.simple_sky())


def test_pieces_are_short_where_writing_takes_long(monkeypatch):
    """By a clock of its own: a pose takes 0.1 s to render, 2 s to write, a piece 1 s to save."""
    now = [0.0]
    monkeypatch.setattr(pieces, "time", SimpleNamespace(perf_counter=lambda: now[0]))
    lengths = []

    class Slow:
        def write(self, piece):
            lengths.append(len(piece.responses))
            now[0] += 2 * lengths[-1]

    def render(poses, first, progress):
        now[0] += 0.1 * len(poses)
        return Piece(first, np.zeros((len(poses), 1, 3), np.float32))

    def save(done, seconds):
        now[0] += 1

    poses = np.tile(np.eye(4), (40, 1, 1))
    seconds = pieces.render_pieces(render, [Slow()], poses, 12, lambda *_: None, save)
    assert sum(lengths) == 40
    assert max(lengths) == 4  # 9.4 s
    assert seconds == pytest.approx(4)


def test_two_at_once(folder):
    with WholeFiles({}) as files:
        files.open(str(folder / "out.npy"))
        with pytest.raises(omma.Error, match=r"out\.npy\.partial: .*another process is writing it"):
            render(folder, "out.npy")


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_killed_in_the_command_line(folder, number):
    render(folder, "out.npy", resume=False, sampling=omma.Fixed(60_000))
    expected = contents(folder, "out*")
    command = [
        *(sys.executable, "-m", "omma", "render", folder / "scene.gltf"),
        *("--eye", folder / "bug.eye", "--path", folder / "path.csv", "--samples", "60000"),
        *("--noise", "new_every_frame", "--resume", "-o", folder / "out.npy"),
    ]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    deadline = time.perf_counter() + 60
    while not (folder / "out.npy.resume").exists():  # the first piece is written
        assert time.perf_counter() < deadline
        assert process.poll() is None, process.stderr.read()
        time.sleep(0.001)
    process.send_signal(number)
    _, said = process.communicate(timeout=60)
    assert process.returncode != 0
    if number != signal.SIGKILL:
        assert re.search(r"interrupted.*poses are kept; the same command goes on", said)
    assert (folder / "out.npy.partial").exists()
    again = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "resumed at pose" in again.stdout
    assert contents(folder, "out*") == expected
