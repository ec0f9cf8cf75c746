"""Files in and out. Whatever is written is written under another name first and renamed when it is
whole, so that no half of a file is ever left under its final name.
"""

from __future__ import annotations

import hashlib
import io
import os
import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from omma import _core
from omma._core import Error
from omma.base.addresses import SentFiles, check_address, expect_local, is_address, local_path
from omma.base.directories import (
    WhatIsKept,
    WholeDirectory,
    abandoned_directories,
    nothing_is_kept,
)
from omma.base.named_files import files_in, files_named_by
from omma.base.progress import Progress

PathLike = str | os.PathLike[str]

# Files that are named where many were left behind; and what ends their names, .TOKEN.partial.
_NAMED = 3
_TAIL = len(".0123456789ab.partial")

METRES_PER_UNIT = {"mm": 1e-3, "um": 1e-6, "m": 1.0}


def metres_per_unit(unit: str | float) -> float:
    """Metres in a unit of length: "mm", "um", "m", or already a number of metres."""
    if isinstance(unit, str) and unit in METRES_PER_UNIT:
        return METRES_PER_UNIT[unit]
    try:
        metres = float(unit)
    except (TypeError, ValueError):
        metres = 0.0
    if not (metres > 0 and np.isfinite(metres)):
        raise Error(f"unit: expected mm, um, m or a number of metres, found {unit!r}")
    return metres


def open_text(path: PathLike) -> io.TextIOWrapper:
    """The text of a file, to be read as an open one is; line ends are as they stand there.

    It is UTF-8, or UTF-16 where a byte-order mark says so, as Excel saves "Unicode text".

    Raises:
        omma.Error: it is no regular file (a pipe may never end), cannot be read or is neither.
    """
    data = _core.read_file(path)
    is_utf_16 = data[:2] in (b"\xff\xfe", b"\xfe\xff")
    encoding = "utf-16" if is_utf_16 else "utf-8-sig"
    try:
        data.decode(encoding)
    except UnicodeDecodeError as error:
        line = data[: error.start].decode(encoding, "replace").count("\n") + 1
        raise Error(
            f"{os.fsdecode(path)}, line {line}: expected {'UTF-16' if is_utf_16 else 'UTF-8'} "
            "text, found other bytes"
        ) from None
    # Decoded again line by line: a million poses are then not in memory as text.
    return io.TextIOWrapper(io.BytesIO(data), encoding=encoding, newline="")


@contextmanager
def reading(path: PathLike, what: str) -> Iterator[None]:
    """Whatever the library for files of that kind raises, as omma.Error that names the file, and
    the first line of what it says."""
    try:
        yield
    except Error:
        raise
    except Exception as error:  # each library has its own, and more than it says
        why = " ".join(str(error).strip().partition("\n")[0].split()) or type(error).__name__
        raise Error(f"{os.fsdecode(path)}: cannot be read as {what}: {why:.300}") from None


@contextmanager
def reading_told(path: PathLike, what: str, progress: Progress | None) -> Iterator[Progress | None]:
    """As `reading`. The block gets a progress function: what ``progress`` raises is its caller's,
    not the file's fault."""
    raised: list[BaseException] = []

    def tell(share: float) -> None:
        try:
            assert progress is not None
            progress(share)
        except BaseException as error:
            raised.append(error)
            raise

    try:
        with reading(path, what):
            yield None if progress is None else tell
    except Error:
        if raised:
            raise raised[0] from None
        raise


class WholeFiles:
    """Files that get their names together, when the block ends well, or are removed.

    Written by the engine's one writer: links are followed, permissions of a file that is replaced
    are kept, and everything is on the disk before it gets its name. omma.Error where the system
    refuses, or where a name is that of a directory, a device or a pipe.
    """

    def __init__(self, kept: Mapping[str, int] | None = None) -> None:
        """With ``kept`` what is written stays as NAME.partial where the block does not end well,
        and goes on after so many bytes of each file."""
        self._files = _core.WholeFiles()
        self._directories: list[WholeDirectory] = []
        self._last: list[Callable[[], object]] = []
        self.kept = kept
        self._numbers: dict[str, int] = {}
        self._sent: SentFiles | None = None

    def open(self, name: str) -> WholeFile:
        """A file to write to that will be called ``name``."""
        name = self._here(name)
        if self.kept is None:
            return WholeFile(self._files, self._files.open(name))
        begun = self.kept.get(name, 0)
        self._numbers[name] = self._files.open_kept(name, begun)
        return WholeFile(self._files, self._numbers[name], begun > 0)

    def path_of(self, name: str) -> str:
        """Where a library that writes to a path itself is to write what will be called ``name``."""
        name = self._here(name)
        return self._files.temporary(self._files.open(name))

    def open_directory(self, name: str, marker: str, kept: WhatIsKept = nothing_is_kept) -> str:
        """A new directory that will be called ``name``, as it is called meanwhile. One that has
        that name is replaced as by `WholeDirectory`."""
        name = self._here(name, marker, kept)
        self._directories.append(WholeDirectory(name, marker, kept))
        return self._directories[-1].temporary

    def at_end(self, last: Callable[[], object]) -> None:
        """What is to be done to complete files, before any of them gets its name."""
        self._last.append(last)

    def sync(self) -> dict[str, int]:
        """Brings what is kept to the disk; the sizes of these files."""
        return {name: self._files.sync(number) for name, number in self._numbers.items()}

    def __enter__(self) -> WholeFiles:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        # What has no name yet is removed with the object too, should Ctrl-C come right here.
        try:
            if kind is None:
                for last in self._last:
                    last()
                for directory in self._directories:
                    directory.sync()
                self._files.finish()
                for directory in self._directories:
                    directory.finish()
                if self._sent is not None:
                    self._sent.send()
        finally:
            self._files.discard()
            for directory in self._directories:
                directory.discard()
            if self._sent is not None and kind is not None:
                self._sent.discard()

    def _here(
        self, name: str, marker: str | None = None, kept: WhatIsKept = nothing_is_kept
    ) -> str:
        """The path to write to, of what goes to an address one from which it will be sent."""
        name = local_path(name)
        if not is_address(name):
            return name
        if self._sent is None:
            self._sent = SentFiles()
        if marker is not None:
            return self._sent.directory_of(name, marker, kept)
        return self._sent.path_of(name)


class WholeFile:
    """One of `WholeFiles`, as far as NumPy and others need a file."""

    def __init__(self, files: _core.WholeFiles, number: int, begun: bool = False) -> None:
        self._files, self._number, self._begun = files, number, begun

    def write_header(self, data: bytes) -> None:
        """Begin with these bytes, if it has not begun before."""
        if not self._begun:
            self.write(data)

    def write(self, data: Any) -> None:
        """Add bytes, or what can be read as such."""
        self._files.write(self._number, data)

    def close(self) -> None:
        """Nothing more will be written to it. Only needed where there are thousands."""
        self._files.close(self._number)


def write_whole(path: PathLike, data: bytes) -> None:
    """A file of these bytes, there whole or not at all."""
    with WholeFiles() as files:
        files.open(os.fsdecode(path)).write(data)


def check_target(name: str) -> None:
    """Throws omma.Error where a file of that name cannot be made."""
    name = local_path(name)
    if is_address(name):
        check_address(name)
    else:
        _core.check_target(name)


def check_kept(written: Iterable[PathLike], read: Iterable[PathLike]) -> None:
    """omma.Error where a file to write is there twice, or is one of those that are read or that a
    file of a scene among them names, by whatever name or link."""
    places: dict[str, str] = {}
    for name in map(local_path, written):
        place = name if is_address(name) else os.path.realpath(name)
        if place in places:
            raise Error(f"{name}: is an output twice")
        places[place] = name
    # What is not there yet is not read either; scenes are only looked into where it matters.
    there = {place: name for place, name in places.items() if _exists(place)}
    if not there:
        return
    inputs = [local_path(name) for name in read]
    for source in [*inputs, *(file for name in inputs for file in files_named_by(name))]:
        for place, name in there.items():
            if _exists(source) and os.path.samefile(source, place):
                raise Error(f"{name}: would replace what it is made from")


def check_ending(path: PathLike, *endings: str) -> None:
    """omma.Error where a name ends in none of these, which say the format."""
    name = os.fsdecode(path)
    if Path(name).suffix.lower() not in endings:
        *others, last = endings
        known = f"{', '.join(others)} or {last}" if others else last
        raise Error(f"{name}: expected a name ending in {known}")


def left_behind(names: Sequence[str], directories: Sequence[str] = ()) -> list[str]:
    """Warnings of what runs that were killed left of files with these names, and of directories,
    and how to remove it.

    Nothing is said of runs that still go on.
    """
    warnings = [
        f"a run that was killed left {path} behind; to remove it: rm -r {shlex.quote(path)}"
        for name in directories
        if not is_address(name)
        for path in abandoned_directories(name)
    ]
    found = _core.left_behind([name for name in names if not is_address(name)])
    if not found:
        return warnings
    size = sum(bytes_ for _, bytes_ in found) / 1e6
    listed = ", ".join(path for path, _ in found[:_NAMED])
    more = f" and {len(found) - _NAMED} more" if len(found) > _NAMED else ""
    # One pattern for all files of one run.
    patterns = dict.fromkeys(
        f"{shlex.quote(folder + os.sep if folder else '')}.*{name[-_TAIL:]}"
        for folder, name in (os.path.split(path) for path, _ in found)
    )
    return [
        *warnings,
        f"runs that were killed left {size:,.1f} MB behind: {listed}{more}; to remove it: "
        f"rm {' '.join(patterns)}",
    ]


@contextmanager
def named_in_errors(name: str) -> Iterator[None]:
    """Writing a file by a library that does not say which one could not be written."""
    try:
        yield
    except OSError as error:
        raise Error(f"{name}: cannot be written: {error.strerror or error}") from None


def make_parents(names: Iterable[str]) -> tuple[str, ...]:
    """Makes the directories that files of these names go into; those that were not there before. At
    addresses there are none."""
    parents = (Path(name).parent for name in map(local_path, names) if not is_address(name))
    return tuple(str(parent) for parent in parents if make_directory(parent))


def make_directory(directory: Path) -> bool:
    """Makes a directory and what is above it, and says whether it was not there before; omma.Error
    where that cannot be."""
    directory = Path(expect_local(directory, "a directory"))
    was_there = directory.is_dir()
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Error(f"{directory}: cannot be made: {error.strerror}") from None
    return not was_there


def _exists(name: str) -> bool:
    return not is_address(name) and len(name) > 0 and "\0" not in name and os.path.exists(name)


def digests_of(path: PathLike) -> dict[str, str]:
    """SHA-256 of a file, and of every file that one of a scene names."""
    name = os.fsdecode(path)
    data = _core.read_file(name)
    digests = {name: hashlib.sha256(data).hexdigest()}
    for file in files_in(name, data):
        digests[file] = hashlib.sha256(_core.read_file(file)).hexdigest()
    return digests
