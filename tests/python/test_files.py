"""Responses in files: what is in them, and that no half of one is ever left."""

import csv
import os

import numpy as np
import pytest
from conftest import make_eye

import omma
from omma.files import NpyWriter, WholeFiles


def responses_of(eye, poses=2):
    return np.random.default_rng(5).random((poses, len(eye), 3), np.float32)


def test_npy(tmp_path, eye):
    values = responses_of(eye)
    omma.save_responses(tmp_path / "a.npy", values, eye)
    back = np.load(tmp_path / "a.npy")
    assert back.dtype == np.float32
    assert (back == values).all()
    omma.save_responses(tmp_path / "a.npy", values[0], eye)  # replaces, and has three axes
    assert np.load(tmp_path / "a.npy").shape == (1, 60, 3)


def test_csv(tmp_path, eye):
    values = responses_of(eye)
    omma.save_responses(tmp_path / "a.csv", values, eye, values / 10)
    with (tmp_path / "a.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 120
    row = rows[60 + 7]
    assert (row["pose"], row["ommatidium"], row["eye_id"]) == ("1", "7", "0")
    x, y, z = eye.axis[7]
    # Six digits are written.
    assert float(row["azimuth_deg"]) == pytest.approx(np.degrees(np.arctan2(x, -z)), rel=1e-5)
    assert float(row["elevation_deg"]) == pytest.approx(np.degrees(np.arcsin(y)), rel=1e-5)
    # Nine digits are all of a float32.
    assert [np.float32(row[c]) for c in "rgb"] == values[1, 7].tolist()
    assert np.float32(row["g_error"]) == np.float32(values[1, 7, 1] / 10)


@pytest.mark.parametrize(
    ("name", "shape", "errors", "word"),
    [
        ("a.txt", (1, 60, 3), False, "a.txt: expected a name ending in .npy or .csv"),
        ("a", (1, 60, 3), False, "expected a name ending"),
        ("a.npy", (1, 61, 3), False, r"responses: expected shape \(P, 60, 3\), found \(1, 61, 3\)"),
        ("a.npy", (60,), False, "responses"),
        ("a.npy", (1, 60, 3), True, "save responses and errors apart"),
        ("no/such/a.npy", (1, 60, 3), False, "there is no directory"),
    ],
)
def test_wrong_arguments(tmp_path, eye, name, shape, errors, word):
    values = np.zeros(shape)
    with pytest.raises(omma.Error, match=word):
        omma.save_responses(tmp_path / name, values, eye, values if errors else None)
    assert list(tmp_path.iterdir()) == []


def test_a_directory_is_not_replaced(tmp_path, eye):
    (tmp_path / "a.npy").mkdir()
    with pytest.raises(omma.Error, match="it is a directory"):
        omma.save_responses(tmp_path / "a.npy", responses_of(eye), eye)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_directory_that_may_not_be_written(tmp_path, eye):
    tmp_path.chmod(0o500)
    with pytest.raises(omma.Error, match="cannot be written: Permission denied"):
        omma.save_responses(tmp_path / "a.npy", responses_of(eye), eye)
    tmp_path.chmod(0o700)


def test_nothing_is_left_when_writing_fails(tmp_path):
    old = tmp_path / "a.npy"
    old.write_text("the old one")
    with pytest.raises(ZeroDivisionError), WholeFiles() as files:
        NpyWriter(files, str(old), (1, 2, 3)).write(np.zeros((1, 2, 3), np.float32), None, 0)
        raise ZeroDivisionError
    assert old.read_text() == "the old one"
    assert [p.name for p in tmp_path.iterdir()] == ["a.npy"]


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full here")
def test_a_full_disk_is_an_error_that_names_the_file(tmp_path):
    class Full(WholeFiles):
        def open(self, name):
            file = super().open(name)
            os.dup2(os.open("/dev/full", os.O_WRONLY), file.fileno())
            return file

    for size in (3, 3_000_000):  # found out when closing, and while writing
        with pytest.raises(omma.Error, match=r"a\.npy: cannot be written: No space left"), \
                Full() as files:  # fmt: skip
            writer = NpyWriter(files, str(tmp_path / "a.npy"), (1, 1, size))
            writer.write(np.zeros((1, 1, size), np.float32), None, 0)
        assert list(tmp_path.iterdir()) == []


def test_save_eye_leaves_nothing_behind(tmp_path):
    with pytest.raises(omma.Error, match="no/such"):
        omma.save_eye(tmp_path / "no/such/a.eye", make_eye(3))
    omma.save_eye(tmp_path / "a.eye", make_eye(3))
    assert [p.name for p in tmp_path.iterdir()] == ["a.eye"]
