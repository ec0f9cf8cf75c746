"""``omma render --receptors``: responses of receptors in files."""

import csv

import numpy as np
import pytest

import omma
from omma.job import pieces
from omma.rendering.receptor_files import quoted

PATH = "x,y,z,yaw_deg,pitch_deg,roll_deg\n0,1,0,0,0,0\n1,2,0,40,-20,5\n"


@pytest.fixture
def fly(tmp_path, eye, files, monkeypatch):
    """An eye file with a receptor along the axis and one beside it; a path of two poses."""
    types = [
        omma.receptors.ReceptorType('R7, "pale"', peak_wavelength_nm=345),
        omma.receptors.ReceptorType("R1", peak_wavelength_nm=478, right_rad=0.1),
    ]
    receptors = [[0, 1] if i % 2 else [1] for i in range(len(eye))]
    made = eye.replace(receptor_types=types, receptors=receptors)
    omma.save_eye(tmp_path / "fly.csv", made)
    (tmp_path / "path.csv").write_text(PATH)
    monkeypatch.chdir(tmp_path)
    return omma.load_eye("fly.csv")


def test_receptors_are_written_as_they_are_rendered(run_omma, fly, files):
    arguments = ["render", files / "scene.gltf", "--eye", "fly.csv", "--path", "path.csv"]
    code, out, err = run_omma(
        *arguments, "--receptors", "--ultraviolet", "0,0.5,1", "-o", "r.npy", "-o", "r.csv"
    )
    assert (code, err) == (0, "")
    assert "receptors  90" in out
    # All 60 beside the axis and, as some look along it, all along it: 120 views, 16 rays, 2 poses.
    assert "rays       3,840" in out
    renderer = omma.Renderer(omma.load_scene(files / "scene.gltf"), fly)
    poses = omma.load_poses("path.csv")
    expected = renderer.render_receptors(poses, ultraviolet=(0, 0.5, 1))
    found = np.load("r.npy")
    assert found.dtype == np.float32
    assert np.array_equal(found, expected)
    with open("r.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == [
        "pose", "ommatidium", "eye_id", "receptor", "azimuth_deg", "elevation_deg", "response",
    ]  # fmt: skip
    assert len(rows) == 180
    values = np.array([float(row["response"]) for row in rows], np.float32)
    assert np.array_equal(values.reshape(2, 90), expected)
    assert [int(row["ommatidium"]) for row in rows[:90]] == (
        omma.receptors.ommatidium_of_receptor(fly).tolist()
    )
    assert [row["receptor"] for row in rows[:3]] == ["R1", 'R7, "pale"', "R1"]
    assert [row["pose"] for row in rows[::90]] == ["0", "1"]
    looking = omma.receptors.receptor_axis(fly)[2]
    assert float(rows[2]["azimuth_deg"]) == pytest.approx(
        np.degrees(np.arctan2(looking[0], -looking[2])), abs=1e-3
    )
    assert float(rows[2]["elevation_deg"]) == pytest.approx(
        np.degrees(np.arcsin(looking[1])), abs=1e-3
    )


@pytest.mark.parametrize("standard_error", [False, True])
def test_many_poses_are_written_in_pieces(fly, files, monkeypatch, standard_error):
    fractions = []

    def write(name):
        told = []
        omma.render_file(
            files / "scene.gltf",
            name,
            eyes="fly.csv",
            path="path.csv",
            receptors=True,
            standard_error=standard_error,
            progress=lambda stage, done: told.append(done) if stage == "Rendering" else None,
        )
        assert told == sorted(told)
        fractions.append(set(told))
        return np.load(name)

    whole = write("whole.npy")
    monkeypatch.setattr(pieces, "_PIECE_BYTES", 4 * 90)  # one pose
    assert np.array_equal(write("pieces.npy"), whole)
    assert {0.5, 1.0} <= fractions[1]


def test_standard_errors_are_written_beside(run_omma, fly, files):
    arguments = ["render", files / "scene.gltf", "--eye", "fly.csv", "--position", 0, 1, 0]
    code, _, err = run_omma(
        *arguments, "--receptors", "--standard-error", "-o", "r.npy", "-o", "r.csv"
    )
    assert (code, err) == (0, "")
    with open("r.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for column, name in (("response", "r.npy"), ("response_error", "r.error.npy")):
        values = np.array([float(row[column]) for row in rows], np.float32)
        assert np.array_equal(values, np.load(name)[0])
    assert np.load("r.error.npy").max() > 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["--eye", "fly.csv", "--receptors", "-o", "r.png"],
            "r.png: expected numbers, not a picture, for responses of receptors; of .npy files, in "
            "Python, omma.picture.plot_responses(picture, eye, numpy.load(file), receptors=True)",
        ),
        (["--eye", "bug.eye", "--receptors", "-o", "r.npy"], "expected receptors, found none"),
        (["--eye", "fly.csv", "--ultraviolet", "dark", "-o", "r.npy"], "--ultraviolet: goes with"),
        (["--camera", "plain", "--receptors", "-o", "r.npy"], "receptors: is for eyes"),
        (
            ["--eye", "fly.csv", "--receptors", "--error", 0.1, "-o", "r.npy"],
            "--error: not for receptors",
        ),
    ],
)
def test_what_cannot_be_is_said(run_omma, fly, files, tmp_path, eye, arguments, message):
    omma.save_eye("bug.eye", eye)
    code, _, err = run_omma("render", files / "scene.gltf", *arguments)
    assert code == 1
    assert message in err
    assert not list(tmp_path.glob("r.*"))


@pytest.mark.parametrize(("word", "mix"), [("dark", (0, 0, 0)), ("as_blue", (0, 0, 1))])
def test_ultraviolet_is_said_by_word(run_omma, fly, files, word, mix):
    renderer = omma.Renderer(omma.load_scene(files / "scene.gltf"), fly)
    poses = omma.load_poses("path.csv")
    expected = renderer.render_receptors(poses, ultraviolet=mix)
    assert np.array_equal(renderer.render_receptors(poses, ultraviolet=word), expected)
    arguments = ["render", files / "scene.gltf", "--eye", "fly.csv", "--path", "path.csv"]
    code, _, err = run_omma(*arguments, "--receptors", "--ultraviolet", word, "-o", "r.npy")
    assert (code, err) == (0, "")
    assert np.array_equal(np.load("r.npy"), expected)
    code, _, err = run_omma("render-again", "r.npy", "-o", "again.npy")
    assert (code, err) == (0, "")
    assert np.array_equal(np.load("again.npy"), expected)


def test_texts_are_quoted_where_they_must_be():
    assert quoted("R1") == "R1"
    assert quoted('a "b", c') == '"a ""b"", c"'
