"""Directories that are written whole, where another process makes one of that name meanwhile."""

import errno
from pathlib import Path

import pytest

import omma
from omma.base.directories import WholeDirectory

MARKER = "zarr.json"


def begun(target, text, marker=MARKER):
    """A directory that is written and has no name yet."""
    directory = WholeDirectory(str(target), marker)
    (Path(directory.temporary) / MARKER).write_text(text)
    return directory


def finished(directory, replaces=True):
    try:
        return directory.finish(replaces)
    finally:
        directory.discard()


def listing(folder):
    return sorted(path.name for path in folder.iterdir())


def test_the_last_one_wins(tmp_path):
    """Two that began before either was there, and two that replace an older one."""
    target = tmp_path / "out.zarr"
    for _ in range(2):
        one, other = begun(target, "one"), begun(target, "other")
        assert finished(other)
        assert finished(one)
        assert (target / MARKER).read_text() == "one"
        assert listing(tmp_path) == ["out.zarr"]


@pytest.mark.parametrize("step", ["before the old one goes", "after the old one went"])
def test_the_last_one_wins_between_two_names(tmp_path, monkeypatch, step):
    """Another gets the name while this one, too, takes it from an older directory."""
    target = tmp_path / "out.zarr"
    assert finished(begun(target, "old"))
    one, other = begun(target, "one"), begun(target, "other")
    rename = Path.rename

    def hooked(path, to):
        if path != target:
            return rename(path, to)
        monkeypatch.setattr(Path, "rename", rename)
        if step == "before the old one goes":
            rename(target, tmp_path / "moved")
            with pytest.raises(FileNotFoundError):
                rename(path, to)
            assert finished(other)
            raise FileNotFoundError(errno.ENOENT, "gone", str(path))
        moved = rename(path, to)
        assert finished(other)
        return moved

    monkeypatch.setattr(Path, "rename", hooked)
    assert finished(one)
    assert (target / MARKER).read_text() == "one"
    assert set(listing(tmp_path)) <= {"out.zarr", "moved"}


@pytest.mark.parametrize("holds", [None, "notes.txt"])
def test_what_is_no_store_and_came_meanwhile_is_kept(tmp_path, holds):
    target = tmp_path / "out.zarr"
    directory = begun(target, "one")
    target.mkdir()
    if holds is not None:
        (target / holds).write_text("mine")
    with pytest.raises(omma.Error, match=r"no zarr\.json in it"):
        finished(directory)
    assert listing(tmp_path) == ["out.zarr"]
    assert listing(target) == ([] if holds is None else [holds])


def test_the_first_one_wins_where_nothing_is_replaced(tmp_path):
    target = tmp_path / "out.zarr"
    one, other = begun(target, "one"), begun(target, "other")
    assert finished(other, replaces=False)
    assert not finished(one, replaces=False)
    assert (target / MARKER).read_text() == "other"
    assert listing(tmp_path) == ["out.zarr"]


def test_a_name_that_cannot_be_given_is_an_error(tmp_path):
    target = tmp_path / "out.zarr"
    directory = begun(target, "one")
    Path(directory.temporary, MARKER).unlink()
    Path(directory.temporary).rmdir()
    with pytest.raises(omma.Error, match=r"out\.zarr: cannot be written: No such file"):
        finished(directory)
    assert listing(tmp_path) == []
