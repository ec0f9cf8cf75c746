"""The cache of baked light: what it is named by, and what is done where it is not whole."""

import json
import os
import pickle
import subprocess
import sys
import zlib

import numpy as np
import pytest
from lit_checks import BAND, matter

import omma
from omma.light import Disc, Light, uniform_sky
from omma.scene import Bake, Instance, Mesh

SKY = uniform_sky(1.0, below=0.2, bands=BAND)
SUNNY = Light(BAND, "watts", discs=(Disc((0, 1, 0), 0.01, [1.0]),))


def sheets(reflectance=0.5, shift_m=0.0):
    """A strip of ground and a sheet above it: about a line there are few probes, baked at once."""
    place = np.eye(4)
    place[0, 3] = shift_m
    return omma.Scene(
        meshes=[strip(2, 0, 0), strip(1, 0.05, 1)],
        materials=[matter(reflectance), matter(0.2)],
        instances=[Instance(0, name="ground"), Instance(1, place, name="leaf")],
    )


def strip(length_m, height_m, material):
    x, z = length_m / 2, 0.02
    corners = [[-x, height_m, z], [x, height_m, z], [x, height_m, -z], [-x, height_m, -z]]
    return Mesh(corners, [[0, 1, 2], [0, 2, 3]], material=material)


def world_of(folder, scene=None, light=SKY, progress=None, threads=0, **settings):
    bake = Bake(**{"cell_m": 0.5, "paths": 16, "cache": folder, **settings})
    how = {"lighting": "baked", "bake": bake, "progress": progress, "threads": threads}
    return omma.World(scene or sheets(), light=light, **how)


def seen_by(world):
    at = np.column_stack([np.linspace(-0.9, 0.9, 200), np.full(200, 0.1), np.zeros(200)])
    eye = omma.Eye(at, np.tile([0.0, -1, 0.1], (200, 1)), 0.3)
    return omma.Renderer(world, eye, omma.Fixed(4)).render(np.eye(4))


@pytest.fixture
def kept(tmp_path):
    """A world, what is seen of it, and the one file that it has left in the folder."""
    world = world_of(tmp_path)
    (file,) = tmp_path.iterdir()
    return world, seen_by(world), file


def test_from_the_cache_to_the_same_bits(kept):
    world, seen, file = kept
    assert not world.baked.from_cache
    told = []
    again = world_of(file.parent, progress=told.append)
    assert again.baked.from_cache
    assert again.baked.seconds == world.baked.seconds
    np.testing.assert_array_equal(seen, seen_by(again))
    assert told == sorted(told)
    assert told[-1] == 1
    # Polarisation, threads and names play no part.
    other = again.with_light(SKY, polarized=True)
    assert other.baked.from_cache
    named = sheets().replace(materials=[one.replace(name="a") for one in sheets().materials])
    assert world_of(file.parent, named).baked.from_cache
    assert list(file.parent.iterdir()) == [file]


@pytest.mark.parametrize(
    "change",
    [
        {"scene": sheets(0.501)},
        {"scene": sheets(shift_m=0.001)},
        {"scene": sheets().replace(materials=[matter(0.5), matter(0.2, roughness=0.9)])},
        {"light": uniform_sky(1.001, below=0.2, bands=BAND)},
        {"light": SUNNY},
        {"cell_m": 0.4},
        {"paths": 32},
        {"most_bytes": 1 << 29},
    ],
)
def test_named_by_what_it_depends_on(kept, change):
    world = world_of(kept[2].parent, **change)
    assert not world.baked.from_cache
    assert len(list(kept[2].parent.iterdir())) == 2


def test_named_by_where_things_are(kept):
    world = kept[0]
    place = np.eye(4)
    place[1, 3] = 0.02
    start = world.instances[1].world_from_node
    world.set_transforms("leaf", place)
    moved = world.with_light(SKY)
    assert not moved.baked.from_cache
    world.set_transforms("leaf", start)
    assert world.with_light(SKY).baked.from_cache


def rewritten(data, **changes):
    """A whole file whose header says something else."""
    start = len(b"omma baked light\n") + 16
    length = int.from_bytes(data[start - 8 : start], "little")
    header = json.dumps(json.loads(data[start : start + length]) | changes).encode()
    body = len(header).to_bytes(8, "little") + header + data[start + length :]
    return data[: start - 16] + zlib.crc32(body).to_bytes(8, "little") + body


BROKEN = {
    "empty": lambda data: b"",
    "another file": lambda data: b"glTF" + data[4:],
    "cut in the header": lambda data: data[:60],
    "cut short": lambda data: data[:-1],
    "longer": lambda data: data + b"\0",
    "a byte of the header": lambda data: data[:50] + bytes([data[50] ^ 1]) + data[51:],
    "a byte of the light": lambda data: data[:-300] + bytes([data[-300] ^ 16]) + data[-299:],
    "another format": lambda data: rewritten(data, format=0),
    "another world": lambda data: rewritten(data, key="0" * 64),
    "fewer arrays": lambda data: rewritten(data, arrays=[]),
}


@pytest.mark.parametrize("name", BROKEN)
def test_what_is_not_whole_is_baked_anew(kept, name):
    _, seen, file = kept
    data = file.read_bytes()
    broken = BROKEN[name](data)
    assert broken != data
    file.write_bytes(broken)
    again = world_of(file.parent)
    assert not again.baked.from_cache
    np.testing.assert_array_equal(seen, seen_by(again))
    assert world_of(file.parent).baked.from_cache
    assert list(file.parent.iterdir()) == [file]


def test_a_folder_in_the_place_of_the_file(kept):
    _, seen, file = kept
    file.unlink()
    file.mkdir()
    with pytest.warns(UserWarning, match="cache of baked light"):
        np.testing.assert_array_equal(seen, seen_by(world_of(file.parent)))


def test_a_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.warns(
        UserWarning, match=r"cache of baked light: .*file.inside.*OMMA_CACHE"
    ) as told:
        world = world_of(tmp_path / "file" / "inside")
    assert told[0].filename == __file__
    assert world.baked.cells > 0


def test_without_a_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("OMMA_CACHE", str(tmp_path))
    assert not world_of(False).baked.from_cache
    assert not list(tmp_path.iterdir())
    assert not world_of(True).baked.from_cache
    assert world_of(True).baked.from_cache
    assert [one.name for one in tmp_path.iterdir()] == ["baked-light"]
    assert len(list((tmp_path / "baked-light").iterdir())) == 1


class Stop:
    """Progress that is ended at a share of the work."""

    def __init__(self, at, kind=KeyboardInterrupt):
        self.at, self.kind = at, kind

    def __call__(self, done):
        if done > self.at:
            raise self.kind


# Long enough to be ended in its middle, on any number of cores.
MANY = {"paths": 512, "cell_m": 0.04, "threads": 1}


@pytest.fixture(scope="module")
def never_stopped():
    return seen_by(world_of(False, **MANY))


@pytest.mark.parametrize(
    ("share", "kind"),
    [(0.2, KeyboardInterrupt), (0.5, ZeroDivisionError), (0.9, KeyboardInterrupt)],
)
def test_a_bake_that_was_stopped_goes_on(tmp_path, never_stopped, kind, share):
    with pytest.raises(kind) as stopped:
        world_of(tmp_path, progress=Stop(share, kind), **MANY)
    (kept,) = tmp_path.iterdir()
    assert kept.suffix == ".unfinished"
    (note,) = stopped.value.__notes__
    assert f"% of the light that was being baked are kept in {tmp_path}" in note
    told = []
    world = world_of(tmp_path, progress=told.append, **MANY)
    assert not world.baked.from_cache
    assert told[0] < told[-1] == 1
    (finished,) = tmp_path.iterdir()
    assert finished.suffix == ".baked"
    # To the bits of one that was not stopped.
    np.testing.assert_array_equal(seen_by(world), never_stopped)


def test_what_is_kept_of_a_bake_may_be_damaged(tmp_path, never_stopped):
    with pytest.raises(KeyboardInterrupt):
        world_of(tmp_path, progress=Stop(0.5), **MANY)
    (kept,) = tmp_path.iterdir()
    kept.write_bytes(kept.read_bytes()[:-100])
    np.testing.assert_array_equal(seen_by(world_of(tmp_path, **MANY)), never_stopped)


def test_without_a_cache_nothing_is_kept():
    with pytest.raises(KeyboardInterrupt) as stopped:
        world_of(False, progress=Stop(0.5), **MANY)
    (note,) = stopped.value.__notes__
    assert note == "of the light that was being baked nothing is kept, as there is no cache"


def test_two_processes_at_once(tmp_path):
    code = (
        "import sys; sys.path.insert(0, sys.argv[1])\n"
        "from test_baked_cache import world_of\n"
        "print(world_of(sys.argv[2], paths=64).baked.cells)"
    )
    command = [sys.executable, "-c", code, os.path.dirname(__file__), str(tmp_path / "new")]
    running = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    said = [one.communicate()[0] for one in running]
    assert [one.returncode for one in running] == [0, 0]
    assert said[0] == said[1]
    assert len(list((tmp_path / "new").iterdir())) == 1
    assert world_of(tmp_path / "new", paths=64).baked.from_cache


def test_what_was_used_least_recently_goes_first(kept, monkeypatch):
    _, _, file = kept
    folder = file.parent
    size = file.stat().st_size
    monkeypatch.setattr("omma.scene.baked_files._MOST_BYTES", int(2.5 * size))
    os.utime(file, (1, 1))
    old = folder / "old.baked"
    old.write_bytes(file.read_bytes())
    os.utime(old, (2, 2))
    left = folder / f".{file.name}.0123456789ab.partial"
    left.write_bytes(b"half")
    os.utime(left, (2, 2))
    assert world_of(folder).baked.from_cache  # used now
    world_of(folder, paths=32)
    assert file.exists()
    assert not old.exists()
    assert not left.exists()
    assert len(list(folder.iterdir())) == 2


def test_pickles_find_it_in_the_cache(kept):
    world, seen, _ = kept
    other = pickle.loads(pickle.dumps(world))
    assert other.baked.from_cache
    np.testing.assert_array_equal(seen, seen_by(other))


def test_pickles_of_what_moved_after_the_bake(kept):
    world, _, file = kept
    dusk = world.with_light(uniform_sky(0.1, below=0, bands=BAND))
    files = set(file.parent.iterdir())
    place = np.eye(4)
    place[:2, 3] = 0.3, 0.02
    dusk.set_transforms("leaf", place)
    other = pickle.loads(pickle.dumps(dusk))
    # What was baked was baked before it moved.
    assert other.baked.from_cache
    assert set(file.parent.iterdir()) == files
    np.testing.assert_array_equal(other.instances[1].world_from_node, place)
    np.testing.assert_array_equal(seen_by(dusk), seen_by(other))
