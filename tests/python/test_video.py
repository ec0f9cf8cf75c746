"""Videos: a frame for each pose, whole or not at all."""

import re

import numpy as np
import pytest

import omma
from omma.picture import video

ffmpeg = pytest.importorskip("imageio_ffmpeg")


def frames_of(path):
    reader = ffmpeg.read_frames(str(path))
    about = next(reader)
    width, height = about["size"]
    return about, [np.frombuffer(f, np.uint8).reshape(height, width, 3) for f in reader]


def path_of(tmp_path, poses, times_s=None):
    file = tmp_path / "path.csv"
    when = [""] * poses if times_s is None else [f"{time:.10g}," for time in times_s]
    rows = "".join(f"{when[k]}0,1,0,{30 * k},0,0\n" for k in range(poses))
    head = "x,y,z,yaw_deg,pitch_deg,roll_deg\n"
    file.write_text(head + rows if times_s is None else f"t_s,{head}{rows}")
    return file


def test_frames_are_the_pictures_of_the_poses(files, tmp_path, run_omma, monkeypatch):
    monkeypatch.chdir(files)
    code, out, err = run_omma(
        *("render", "scene.gltf", "--eye", "bug.eye", "--path", path_of(tmp_path, 7)),
        *("--width", 75, "-o", tmp_path / "a.mp4", "-o", tmp_path / "a.npy"),
    )
    assert (code, err) == (0, "")
    assert "a.mp4" in out
    about, frames = frames_of(tmp_path / "a.mp4")
    assert about["codec"] == "h264"
    assert about["fps"] == 30
    assert len(frames) == 7
    eye = omma.load_eye("bug.eye")
    for frame, responses in zip(frames, np.load(tmp_path / "a.npy"), strict=True):
        picture = omma.picture.framed(eye, responses, 75)
        height, width = picture.shape[:2]
        assert height % 2 == 1
        assert about["size"] == (width + width % 2, height + 1)  # made even
        # Lossy: a frame is nearer to its own picture than a few grey levels.
        assert np.abs(frame[:height, :width].astype(int) - picture).mean() < 6
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.json", "a.mp4", "a.npy", "path.csv"]


@pytest.mark.parametrize(
    ("times_s", "rate", "words"),
    [
        (None, 30, None),
        (np.arange(7) * 0.1, 10, None),
        (5 + np.arange(7) / 240, 240, None),
        (np.round(np.arange(7) / 60, 3), 60, None),  # as tables have it
        ([0, 0.1, 0.2, 0.3, 0.5, 0.55, 0.6], 10, "are not even: .* 10 frames a second, the mean"),
        (np.arange(7) * 2.0, 30, "1 to 240 poses a second, found 0.5 .* 0.2 s stand for 12$"),
        (np.arange(7) / 600, 30, "1 to 240 poses a second, found 600 .* 0.2 s stand for 0.01$"),
    ],
)
def test_a_video_has_the_rate_of_the_path(files, tmp_path, times_s, rate, words):
    given = {"eyes": files / "bug.eye", "path": path_of(tmp_path, 7, times_s), "width": 64}
    outputs = [tmp_path / "a.mp4", tmp_path / "a.npy"]
    report = omma.render_file(files / "scene.gltf", outputs, **given)
    about, frames = frames_of(outputs[0])
    assert about["fps"] == pytest.approx(rate, rel=2e-3)
    assert len(frames) == 7
    assert report.video == (*about["size"], pytest.approx(rate, rel=2e-3))
    told = [one for one in report.warnings if one.startswith(f"{outputs[0]}: ")]
    assert len(told) == (words is not None)
    assert all(re.search(words, one) for one in told)
    # Of numbers alone nothing has a rate; the same again has it.
    assert omma.render_file(files / "scene.gltf", outputs[1], **given).video is None
    again = omma.job.render_like(outputs[1], tmp_path / "again.mp4")
    assert again.video[2] == report.video[2]


def test_a_rate_that_one_pose_has_is_none():
    assert video.frame_rate(np.array([4.0])) == (30, None)


def test_the_command_says_how_large_a_video_is_and_how_long(files, tmp_path, run_omma, monkeypatch):
    monkeypatch.chdir(files)
    path = path_of(tmp_path, 7, np.arange(7) * 0.1)
    code, out, err = run_omma(
        *("render", "scene.gltf", "--eye", "bug.eye", "--path", path, "--width", 101),
        *("--height", 51, "--projection", "mollweide", "-o", tmp_path / "odd.mp4"),
    )
    assert (code, err) == (0, "")
    said = "video      102 x 52 pixels (even, as H.264 takes them), 10 frames a second, 0.7 s\n"
    assert said in out
    assert frames_of(tmp_path / "odd.mp4")[0]["size"] == (102, 52)


def test_nothing_is_left_where_a_render_fails(files, tmp_path, monkeypatch):
    monkeypatch.setattr("omma.job.pieces._PIECE_BYTES", 60 * 12)  # a pose at a time
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    paint = omma._core.paint
    seen = []

    def failing(*arguments):
        seen.append(1)
        if len(seen) == 4:
            raise KeyboardInterrupt
        return paint(*arguments)

    monkeypatch.setattr(omma._core, "paint", failing)
    flight = path_of(tmp_path, 7)
    with pytest.raises(KeyboardInterrupt):
        omma.render_file(
            files / "scene.gltf", tmp_path / "a.mp4", eyes=files / "bug.eye", path=flight
        )
    assert [p.name for p in tmp_path.iterdir()] == ["path.csv"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"resume": True}, "resume: is for .npy, .csv and .png"),
        ({"projection": "facets_ids"}, "projection: a video shows responses"),
        ({"eyes": (), "camera": "plain", "path": None}, "a.mp4: expected .npy or .png"),
    ],
)
def test_what_no_video_can_be_of(files, tmp_path, arguments, words):
    given = {"eyes": files / "bug.eye", "path": path_of(tmp_path, 2), **arguments}
    with pytest.raises(omma.Error, match=words):
        omma.render_file(files / "scene.gltf", tmp_path / "a.mp4", **given)
    assert not (tmp_path / "a.mp4").exists()


def test_a_missing_extra_is_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "imageio_ffmpeg", None)
    with pytest.raises(omma.Error, match=r"pip install 'omma\[video\]'"):
        video._load_ffmpeg()
