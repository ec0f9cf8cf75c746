"""Videos: a frame for each pose, whole or not at all."""

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


def path_of(tmp_path, poses):
    file = tmp_path / "path.csv"
    rows = "".join(f"0,1,0,{30 * k},0,0\n" for k in range(poses))
    file.write_text("x,y,z,yaw_deg,pitch_deg,roll_deg\n" + rows)
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
