"""Outputs that are addresses: written there through fsspec, or refused; never a folder here."""

import os
import socket
import subprocess
import sys
import time

import numpy as np
import pytest

import omma
from omma.base.addresses import is_address, local_path

fsspec = pytest.importorskip("fsspec")

OMMA = [sys.executable, "-m", "omma"]
POSES = np.tile(np.eye(4), (3, 1, 1))


@pytest.fixture
def inputs(tmp_path, monkeypatch):
    """A scene and an eye in a folder of their own, which is where we are."""
    monkeypatch.chdir(tmp_path)
    omma.save_eye("e.csv", omma.eye.generate_eye(12))
    omma.scene.save_scene("s.glb", omma.scene.plane((4, 4)))
    return tmp_path


def made_here(folder):
    return sorted(one.name for one in folder.iterdir() if one.name not in ("e.csv", "s.glb"))


def test_names_that_are_addresses():
    assert local_path("file:///a/b%20c.nc") == "/a/b c.nc"
    assert local_path("file://localhost/a.nc") == "/a.nc"
    assert local_path("~/a.nc") == os.path.expanduser("~/a.nc")
    assert local_path("a/b.nc") == "a/b.nc"
    # As pathlib, and with it the command line, changes them.
    for name in ("s3://bucket/a.nc", "s3:/bucket/a.nc"):
        assert is_address(name)
        assert local_path(name) == "s3://bucket/a.nc"
    assert not is_address("c:/a.nc")
    assert not is_address("a:b/c.nc")
    with pytest.raises(omma.Error, match="expected file:///"):
        local_path("file://elsewhere/a.nc")


def render(outputs, **options):
    return omma.render_file("s.glb", outputs, omma.Fixed(2), eyes="e.csv", poses=POSES, **options)


@pytest.fixture
def memory():
    files = fsspec.filesystem("memory")
    yield files
    files.rm("/", recursive=True)


def test_every_format_is_written_to_an_address(inputs, memory):
    pytest.importorskip("zarr")
    pytest.importorskip("pyarrow")
    pytest.importorskip("h5netcdf")
    names = ["a.zarr", "a.nc", "a.parquet", "a.npy", "a.csv", "a.png"]
    report = render([f"memory://out/{name}" for name in names], standard_error=True)
    here = inputs / "here"
    render([str(here / name) for name in names], standard_error=True)
    assert made_here(inputs) == ["here"]
    files = sorted(one.name for one in here.iterdir() if one.is_file())
    assert {one["name"] for one in memory.ls("/out") if one["type"] == "file"} == {
        f"/out/{name}" for name in files
    }
    assert all(one.startswith("memory://out/") for one in report.outputs)
    for name in files:
        # netCDF and Parquet have their own file's name in their history.
        if name.endswith((".npy", ".csv", ".png")):
            assert memory.cat(f"/out/{name}") == (here / name).read_bytes()
    import xarray

    found = xarray.open_zarr("memory://out/a.zarr")
    there = xarray.open_zarr(here / "a.zarr")
    assert found.response.values.tobytes() == there.response.values.tobytes()
    # Written again, in the place of the one before.
    render("memory://out/a.zarr")
    assert "standard_error" not in xarray.open_zarr("memory://out/a.zarr")


def test_what_is_there_and_no_store_is_not_replaced(inputs, memory):
    pytest.importorskip("zarr")
    memory.pipe("/out/a.zarr/thesis.txt", b"all of it")
    with pytest.raises(omma.Error, match=r"memory://out/a\.zarr: cannot be written: .*zarr\.json"):
        render("memory://out/a.zarr")
    assert memory.cat("/out/a.zarr/thesis.txt") == b"all of it"


def test_a_data_set_is_not_replaced(inputs, memory):
    pytest.importorskip("zarr")
    manifest = b'{"attributes": {"format": "omma dataset 1"}}'
    memory.pipe("/out/a.zarr/zarr.json", manifest)
    with pytest.raises(omma.Error, match=r"memory://out/a\.zarr: .* is a data set of omma dataset"):
        render("memory://out/a.zarr")
    assert memory.find("/out") == ["/out/a.zarr/zarr.json"]


def test_what_is_no_store_and_came_meanwhile_is_not_replaced(inputs, memory):
    pytest.importorskip("zarr")

    def meanwhile(stage, share):
        if stage == "Rendering":
            memory.pipe("/out/a.zarr/thesis.txt", b"all of it")

    with pytest.raises(
        omma.Error, match=r"memory://out/a\.zarr: .*zarr\.json in it; what"
    ) as error:
        render("memory://out/a.zarr", progress=meanwhile)
    assert memory.find("/out") == ["/out/a.zarr/thesis.txt"]
    kept = str(error.value).rsplit(" ", 1)[1]
    assert os.path.exists(os.path.join(kept, "zarr.json"))


def test_what_cannot_be_sent_stays_here(inputs, memory, monkeypatch):
    def refuse(self, *_, **__):
        raise PermissionError("no room for you")

    monkeypatch.setattr(type(memory), "put_file", refuse)
    with pytest.raises(omma.Error, match=r"memory://out/a\.npy: cannot be written") as error:
        render("memory://out/a.npy")
    assert "no room for you" in str(error.value)
    kept = str(error.value).rsplit(" ", 1)[1]
    assert np.load(kept).shape[0] == 3


def test_nothing_is_sent_of_a_render_that_stops(inputs, memory):
    def stop(stage, share):
        if stage == "Rendering":
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        render("memory://out/a.npy", progress=stop)
    assert memory.ls("/") == []


@pytest.mark.parametrize("address", ["file://{}/out/a.npy", "~/out/a.npy"])
def test_files_of_this_system_by_other_names(inputs, address, monkeypatch):
    monkeypatch.setenv("HOME", str(inputs))
    render(address.format(inputs))
    assert made_here(inputs) == ["out"]
    assert np.load(inputs / "out" / "a.npy").shape[0] == 3


def test_addresses_that_nobody_knows_are_refused_at_once(inputs):
    for name, words in (
        ("nowhere://bucket/a.npy", "expected an address that fsspec knows"),
        ("file://elsewhere/a.npy", "expected file:///"),
    ):
        with pytest.raises(omma.Error, match=words):
            render(name)
        done = subprocess.run(
            [*OMMA, "render", "s.glb", "--eye", "e.csv", "--position", "0", "1", "0", "-o", name],
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 1
        assert words in done.stderr
    assert made_here(inputs) == []


def test_without_fsspec_it_is_said(inputs, monkeypatch):
    monkeypatch.setitem(sys.modules, "fsspec.core", None)
    with pytest.raises(omma.Error, match=r"pip install 'omma\[remote\]'"):
        render("s3://bucket/a.npy")
    assert made_here(inputs) == []


def test_what_is_written_here_only_says_so(inputs):
    eye = omma.load_eye("e.csv")
    (inputs / "job.toml").write_text(
        '[dataset]\nseed = 1\nstore = "s3://bucket/views.zarr"\n[rendering]\nsamples = 1\n'
        '[[scene]]\nname = "a"\nfile = "s.glb"\n[[eye]]\nfiles = ["e.csv"]\n'
        '[[poses]]\nsampler = "uniform"\nlow_m = [-1, 1, -1]\nhigh_m = [1, 2, 1]\ncount = 2\n'
    )
    calls = (
        lambda: omma.save_eye("s3://bucket/e.csv", eye),
        lambda: omma.scene.save_scene("s3://bucket/s.glb", omma.scene.plane((4, 4))),
        lambda: omma.save_png("s3://bucket/a.png", np.zeros((2, 2, 3), np.uint8)),
        lambda: omma.datasets.load_job("job.toml"),
        lambda: render("s3://bucket/a.npy", path=None, resume=True),
    )
    for call in calls:
        with pytest.raises(omma.Error) as error:
            call()
        assert "address" in str(error.value) or "resume" in str(error.value)
    assert made_here(inputs) == ["job.toml"]


def test_a_data_set_goes_into_the_home(inputs, monkeypatch):
    pytest.importorskip("zarr")
    pytest.importorskip("xarray")
    monkeypatch.setenv("HOME", str(inputs / "home"))
    (inputs / "home").mkdir()
    (inputs / "job.toml").write_text(
        '[dataset]\nseed = 1\nstore = "~/views.zarr"\n[rendering]\nsamples = 1\n'
        '[[scene]]\nname = "a"\nfile = "s.glb"\n[[eye]]\nfiles = ["e.csv"]\n'
        '[[poses]]\nsampler = "uniform"\nlow_m = [-1, 1, -1]\nhigh_m = [1, 2, 1]\ncount = 2\n'
    )
    omma.datasets.run("job.toml")
    assert os.listdir(inputs / "home") == ["views.zarr"]
    assert made_here(inputs) == ["home", "job.toml"]


@pytest.fixture
def s3(monkeypatch):
    """A server of S3 on this machine, with a bucket."""
    pytest.importorskip("moto")
    pytest.importorskip("s3fs")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    server = subprocess.Popen(
        [sys.executable, "-m", "moto.server", "-H", "127.0.0.1", "-p", str(port)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    for name, value in {
        "AWS_ENDPOINT_URL": f"http://127.0.0.1:{port}",
        "AWS_ACCESS_KEY_ID": "here",
        "AWS_SECRET_ACCESS_KEY": "here",
        "AWS_DEFAULT_REGION": "us-east-1",
    }.items():
        monkeypatch.setenv(name, value)
    try:
        for _ in range(300):
            with socket.socket() as tried:
                if tried.connect_ex(("127.0.0.1", port)) == 0:
                    break
            time.sleep(0.1)
        import s3fs

        files = s3fs.S3FileSystem(skip_instance_cache=True)
        files.mkdir("bucket")
        yield files
    finally:
        server.kill()
        server.wait()


def test_a_render_goes_to_s3(inputs, s3):
    pytest.importorskip("zarr")
    xarray = pytest.importorskip("xarray")
    names = ["out.zarr", "out.nc", "out.parquet"]
    outputs = [word for name in names for word in ("-o", f"s3://bucket/day/{name}")]
    command = [*OMMA, "render", "s.glb", "--eye", "e.csv", "--position", "0", "1", "0", *outputs]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert made_here(inputs) == []
    assert {one.rsplit("/", 1)[1] for one in s3.ls("bucket/day")} == set(names)
    subprocess.run([*command[:11], "-o", "here.zarr"], capture_output=True, check=True)
    found = xarray.open_zarr("s3://bucket/day/out.zarr")
    there = xarray.open_zarr("here.zarr")
    assert found.response.values.tobytes() == there.response.values.tobytes()
    with s3.open("bucket/day/out.nc") as file:
        netcdf = xarray.open_dataset(file, engine="h5netcdf")
        assert netcdf.response.values.tobytes() == there.response.values.tobytes()
    nobody = subprocess.run(
        [*command[:11], "-o", "s3://nobody/out.npy"], capture_output=True, text=True, check=False
    )
    assert nobody.returncode == 1
    assert "s3://nobody/out.npy: cannot be " in nobody.stderr
