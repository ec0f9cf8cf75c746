"""Files: what is in them, that they are written whole or not at all, and read if they are files."""

import csv
import os
import re
import resource
import stat
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from conftest import make_eye, write_gltf

import omma
from omma import _core
from omma.base.files import WholeFiles, left_behind
from omma.job.info import describe_file
from omma.rendering.response_files import NpyWriter, Piece


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
    world = omma.World(omma.scene.plane((1, 1)))
    omma.save_responses(tmp_path / "a.csv", values, eye, values / 10, world=world)
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
        ("a.npy", (1, 61, 3), False, r"expected shape \(P, 60, bands\), found \(1, 61, 3\)"),
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
        NpyWriter(files, str(old), (1, 2, 3)).write(Piece(0, np.zeros((1, 2, 3), np.float32)))
        raise ZeroDivisionError
    assert old.read_text() == "the old one"
    assert [p.name for p in tmp_path.iterdir()] == ["a.npy"]


@contextmanager
def small_disk(size):
    """No file can grow beyond ``size`` bytes: what a full disk does, without one."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_full_disk_is_an_error_that_names_the_file(tmp_path):
    wrong = pytest.raises(omma.Error, match=r"a\.npy: cannot be written: File too large")
    with small_disk(1000), wrong, WholeFiles() as files:
        writer = NpyWriter(files, str(tmp_path / "a.npy"), (1, 1, 3000))
        writer.write(Piece(0, np.zeros((1, 1, 3000), np.float32)))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("ending", [".zarr", ".nc", ".parquet"])
def test_a_full_disk_is_an_error_that_names_labelled_files(files, tmp_path, ending):
    pytest.importorskip({".zarr": "zarr", ".nc": "h5netcdf", ".parquet": "pyarrow"}[ending])
    poses = np.random.default_rng(1).uniform(-1, 1, (3000, 6))
    path, out = tmp_path / "path.csv", tmp_path / f"out{ending}"
    np.savetxt(path, poses, "%.9f", ",", header="x,y,z,yaw_deg,pitch_deg,roll_deg", comments="")
    render = {"eyes": files / "bug.eye", "path": path, "sampling": omma.Fixed(1)}
    wrong = pytest.raises(omma.Error, match=re.escape(f"{out.name}: cannot be written"))
    with small_disk(20_000), wrong:
        omma.render_file(files / "scene.gltf", out, **render)
    assert list(tmp_path.iterdir()) == [path]


def test_stokes_vectors_are_told_how_they_are_kept(tmp_path):
    eye = omma.Eye(np.zeros((2, 3)), [[0, 0, -1], [0, 1, 0]], 0.1)
    with pytest.raises(omma.Error, match=r"numpy\.save"):
        omma.save_responses(tmp_path / "a.npy", np.ones((1, 2, 3, 4)), eye)


def test_a_series_of_pictures_is_there_whole_or_not_at_all(files, tmp_path, monkeypatch):
    path = tmp_path / "path.csv"
    path.write_text("x,y,z,yaw_deg,pitch_deg,roll_deg\n" + "0,1,0,0,0,0\n" * 3 + "0,1,0,90,0,0\n")
    render = {"eyes": files / "bug.eye", "path": path, "sampling": omma.Fixed(1), "width": 64}
    whole = _core.encode_png

    def encode(name, pixels, quick):
        return whole(name, pixels, quick) + (b"x" * 100_000 if "0003" in name else b"")

    monkeypatch.setattr(_core, "encode_png", encode)
    with small_disk(50_000), pytest.raises(omma.Error, match=r"out_0003\.png: cannot be written"):
        omma.render_file(files / "scene.gltf", tmp_path / "out.png", **render)
    assert [p.name for p in tmp_path.iterdir()] == ["path.csv"]
    monkeypatch.undo()
    omma.render_file(files / "scene.gltf", tmp_path / "out.png", **render)
    assert len(list(tmp_path.glob("out_*.png"))) == 4


def write_any(path, eye):
    """Write something to a file of whatever kind its name says."""
    suffix = Path(path).suffix
    if suffix == ".npy":
        omma.save_responses(path, responses_of(eye), eye)
    elif suffix == ".csv":
        omma.eye.save_eye_table(path, eye, omma.eye.measure_eye(eye))
    elif suffix == ".png":
        omma.save_png(path, np.zeros((2, 3, 3), np.uint8))
    else:
        omma.save_eye(path, eye)


KINDS = (".npy", ".csv", ".png", ".eye", ".gltf")


@pytest.mark.parametrize("kind", KINDS)
def test_links_are_followed_and_permissions_kept(tmp_path, eye, kind):
    (tmp_path / "far").mkdir()
    link, target = tmp_path / f"link{kind}", tmp_path / f"far/target{kind}"
    link.symlink_to(f"far/target{kind}")
    write_any(link, eye)  # where there is nothing yet
    assert target.stat().st_size > 10
    target.chmod(0o604)
    target.write_bytes(b"old")
    write_any(link, eye)
    assert link.is_symlink()
    assert target.read_bytes() != b"old"
    assert stat.S_IMODE(target.stat().st_mode) == 0o604
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["far", link.name, target.name]


@pytest.mark.parametrize("kind", KINDS)
def test_new_files_have_the_mode_of_the_umask(tmp_path, eye, kind):
    before = os.umask(0o027)
    try:
        write_any(tmp_path / f"new{kind}", eye)
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / f"new{kind}").stat().st_mode) == 0o640


@pytest.mark.parametrize("kind", KINDS)
def test_pipes_are_refused(tmp_path, eye, kind):
    os.mkfifo(tmp_path / f"pipe{kind}")
    with pytest.raises(omma.Error, match="cannot be written: it is not a regular file"):
        write_any(tmp_path / f"pipe{kind}", eye)
    assert (tmp_path / f"pipe{kind}").is_fifo()


READERS = [
    omma.load_poses,
    omma.eye.load_acceptance,
    omma.eye.angles.load_angle_table,
    omma.load_eye,
    omma.load_scene,
    omma.eye.convert_eye,
    omma.eye.scans.import_oda,
    lambda path: omma.eye.scans.import_lens_cone(path, path),
    omma.eye.eye_file_heads,
    omma.Background.image,
    describe_file,
]


@pytest.mark.parametrize("read", READERS)
@pytest.mark.parametrize("kind", ["pipe", "device", "folder", "nothing"])
def test_only_regular_files_are_read(tmp_path, read, kind):
    path = Path("/dev/zero") if kind == "device" else tmp_path / "p"
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    with pytest.raises(omma.Error, match=re.escape(str(path))):
        read(path)


@pytest.mark.parametrize("read", READERS[:3])
def test_text_that_is_no_utf8(tmp_path, read):
    (tmp_path / "a.csv").write_bytes(b"x,y\nK\xe4fer\n")
    with pytest.raises(omma.Error, match=r"a\.csv, line 2: expected UTF-8 text"):
        read(tmp_path / "a.csv")


LATIN = os.fsdecode(b"K\xe4fer")  # a name that is not UTF-8


def test_names_that_are_no_utf8(tmp_path, eye):
    for kind in KINDS:
        path = tmp_path / f"{LATIN}{kind}"
        write_any(path, eye)
        assert os.fsencode(path.name) in os.listdir(os.fsencode(tmp_path))
    back = omma.load_eye(tmp_path / f"{LATIN}.eye")
    assert back.path == str(tmp_path / f"{LATIN}.eye")
    assert r"K\xe4fer.eye" in repr(back)
    scene = write_gltf(tmp_path / f"{LATIN}.gltf")
    assert omma.load_scene(scene).path == str(scene)


@pytest.mark.parametrize("read", READERS)
def test_errors_name_them_readably(tmp_path, read):
    with pytest.raises(omma.Error, match=r"K\\xe4fer\\nx\\x1b\[31m") as caught:
        read(tmp_path / f"{LATIN}\nx\x1b[31m")
    str(caught.value).encode()  # no lone surrogates
    assert str(caught.value).isprintable()


def test_errors_of_python_are_readable():
    assert str(omma.Error(f"{LATIN}\n\x85 蜂")) == r"K\xe4fer\n\xc2\x85 蜂"
    assert str(omma.Error("\ud800")).encode() == rb"'\ud800'"


def test_a_chunk_of_a_png_whose_name_is_no_text(tmp_path):
    omma.save_png(tmp_path / "a.png", np.zeros((2, 3, 3), np.uint8))
    data = (tmp_path / "a.png").read_bytes()
    (tmp_path / "a.png").write_bytes(data[:12] + b"\xc4\xd6\xdc\xdf" + data[16:])
    with pytest.raises(omma.Error, match=r"a\.png"):
        omma.Background.image(tmp_path / "a.png")


KILLED = """
import os, signal, sys
import numpy as np
from omma.base.files import WholeFiles
from omma.rendering.response_files import NpyWriter, Piece

with WholeFiles() as files:
    for name in sys.argv[1:]:
        NpyWriter(files, name, (1, 1, 1)).write(Piece(0, np.zeros((1, 1, 250_000), np.float32)))
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_what_a_killed_run_left_is_named(files, tmp_path, monkeypatch, run_omma):
    monkeypatch.chdir(tmp_path)
    subprocess.run([sys.executable, "-c", KILLED, "a.npy", "b c.csv"], check=False)
    render = ["render", files / "scene.gltf", "--eye", files / "bug.eye", "--samples", "1"]
    code, _, err = run_omma(*render, "-o", "a.npy", "-o", "b c.csv")
    assert code == 0
    left = sorted(p.name for p in tmp_path.glob(".*.partial"))
    assert len(left) == 2
    assert err.startswith("omma: warning: runs that were killed left 2.0 MB behind: ")
    assert all(name in err for name in left)
    # Another target's are not ours, and nothing is removed unasked.
    assert run_omma(*render, "-o", "other.npy")[2] == ""
    subprocess.run(err.partition("to remove it: ")[2], shell=True, check=True)
    assert list(tmp_path.glob(".*.partial")) == []
    assert run_omma(*render, "-o", "a.npy")[2] == ""


def test_a_run_that_goes_on_left_nothing(tmp_path):
    name = str(tmp_path / "a.npy")
    with WholeFiles() as files:
        NpyWriter(files, name, (1, 1, 1)).write(Piece(0, np.zeros((1, 1, 1), np.float32)))
        assert left_behind([name]) == []


def test_another_command_names_it_too(files, tmp_path, monkeypatch, run_omma):
    monkeypatch.chdir(tmp_path)
    subprocess.run([sys.executable, "-c", KILLED, "a.csv"], check=False)
    for command in (
        ["eye", "acceptance", files / "bug.eye", "-o", "a.csv", "--degrees", "3"],
        ["eye", "info", files / "bug.eye", "-o", "a.csv"],
        ["eye", "species", "--facts", "a.csv"],
    ):
        code, _, err = run_omma(*command)
        assert code == 0
        assert "left 1.0 MB behind: ./.a.csv." in err


def test_save_eye_leaves_nothing_behind(tmp_path):
    with pytest.raises(omma.Error, match="no/such"):
        omma.save_eye(tmp_path / "no/such/a.eye", make_eye(3))
    omma.save_eye(tmp_path / "a.eye", make_eye(3))
    assert [p.name for p in tmp_path.iterdir()] == ["a.eye"]


@pytest.mark.parametrize("signal_name", ["SIGINT", "SIGTERM"])
def test_ctrl_c_waits_until_hdf5_is_done(tmp_path, signal_name):
    """Within HDF5's call of a file object it would end the process by a segmentation fault."""
    pytest.importorskip("h5netcdf")
    code = f"""
import gc, os, signal, h5netcdf
from omma.rendering import hdf5_file

def stop(number, frame):
    raise KeyboardInterrupt

signal.signal(signal.{signal_name}, stop)
seek = hdf5_file.Hdf5File.seek

def interrupted(self, *arguments):
    os.kill(os.getpid(), signal.{signal_name})
    return seek(self, *arguments)

hdf5_file.Hdf5File.seek = interrupted
name = {str(tmp_path / "a.nc")!r}
try:
    with hdf5_file.opened(h5netcdf, name, "w") as file:
        file.dimensions = {{"x": 3000}}
        file.create_variable("v", ("x",), "f8")[...] = 7
except KeyboardInterrupt:
    print("stopped")
gc.collect()
with h5netcdf.File(name) as file:
    print(file.variables["v"][2999])
"""
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (ran.returncode, ran.stdout) == (0, "stopped\n7.0\n"), ran.stderr
