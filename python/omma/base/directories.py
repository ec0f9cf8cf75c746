"""Directories that are written whole or not at all, as a Zarr store is one; the cache folder."""

from __future__ import annotations

import os
import re
import secrets
import shutil
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from pathlib import Path

from omma._core import Error
from omma.base.locks import is_free, lock_directory, sync

_TOKEN_BYTES = 6

# Of a directory that is there, by what its marker holds and the files in it, below it and with /
# between: what it is, where it is to be kept.
WhatIsKept = Callable[[bytes, Iterable[str]], str | None]


def nothing_is_kept(marker: bytes, files: Iterable[str]) -> str | None:
    """Any directory with the marker may be replaced."""
    return None


def cache_folder(of: str) -> Path:
    """Where things of a kind are kept from run to run; it need not be there.

    Below the folder that the environment variable OMMA_CACHE names, else the user's cache folder.
    """
    given = os.environ.get("OMMA_CACHE")
    if given:
        return Path(given) / of
    import platformdirs

    return Path(platformdirs.user_cache_dir("omma")) / of


class WholeDirectory:
    """A directory that is written beside its target and renamed by `finish`.

    It is locked meanwhile, so that what a killed run left can be told from what is still written.
    """

    def __init__(self, name: str, marker: str, kept: WhatIsKept = nothing_is_kept) -> None:
        """One of that name is replaced if the file ``marker`` is in it and ``kept`` says None of
        what that holds and of the files there, else omma.Error; links are followed."""
        self._name, self._marker, self._kept = name, marker, kept
        self._target = Path(os.path.realpath(name))
        self._is_taken()
        self._own = self._beside("partial")
        try:
            self._own.mkdir()
            self._lock = lock_directory(str(self._own))
        except OSError as error:
            raise self._error(error) from None
        self._process = os.getpid()  # a forked child must not remove its parent's

    @property
    def temporary(self) -> str:
        """What it is called meanwhile."""
        return str(self._own)

    def sync(self) -> None:
        """Bring all that is in it to the disk."""
        try:
            for folder, _, files in os.walk(self._own):
                for path in [*(os.path.join(folder, file) for file in files), folder]:
                    sync(path)
        except OSError as error:
            raise self._error(error) from None

    def finish(self, replaces: bool = True) -> bool:
        """Give it its name. Of several that replace each other the last one wins, whole; where it
        is not to replace what has that name, False, and it has none."""
        moved: list[Path] = []
        try:
            while not self._gets_its_name():
                if not replaces:
                    return False
                old = self._beside("replaced")
                with suppress(FileNotFoundError):  # another process has taken that one away
                    self._target.rename(old)
                    moved.append(old)
            sync(str(self._target.parent))
        except OSError as error:
            if moved and not self._target.exists():
                with suppress(OSError):
                    moved[-1].rename(self._target)
            raise self._error(error) from None
        for old in moved:
            shutil.rmtree(old, ignore_errors=True)
        return True

    def _gets_its_name(self) -> bool:
        """Give it its name, unless something has that; a full directory is never renamed over."""
        if self._is_taken():
            return False
        try:
            self._own.rename(self._target)
        except OSError:
            if self._is_taken():  # since it was asked
                return False
            raise
        return True

    def _is_taken(self) -> bool:
        """Whether something has its name; omma.Error where that is not to be replaced."""
        held = self._read_marker()
        if held is None and not self._target.exists():
            return False
        if held is None:  # asked again: another process may have named its own in between
            held = self._read_marker()
        why = why_not_replaced(held, _files_below(self._target), self._marker, self._kept)
        if why is not None:
            raise Error(f"{self._name}: cannot be written: {why}")
        return True

    def _read_marker(self) -> bytes | None:
        """What the marker of that which has its name holds; None where there is none."""
        marker = self._target / self._marker
        if not marker.is_file():
            return None
        try:
            return marker.read_bytes()
        except FileNotFoundError:
            return None
        except OSError as error:
            raise self._error(error) from None

    def discard(self) -> None:
        """Remove it, unless it has its name."""
        if self._process == os.getpid():
            shutil.rmtree(self._own, ignore_errors=True)
        if self._lock >= 0:
            os.close(self._lock)
            self._lock = -1

    def _beside(self, ending: str) -> Path:
        token = secrets.token_hex(_TOKEN_BYTES)
        return self._target.with_name(f".{self._target.name}.{token}.{ending}")

    def _error(self, error: OSError) -> Error:
        return Error(f"{self._name}: cannot be written: {error.strerror}")


def why_not_replaced(
    held: bytes | None, files: Iterable[str], marker: str, kept: WhatIsKept
) -> str | None:
    """Why a directory with these files is not replaced whose ``marker`` holds that, None of one
    without; None where it may be."""
    if held is None:
        return f"what has that name has no {marker} in it"
    what = kept(held, files)
    return None if what is None else f"what has that name is {what}; remove it first to replace it"


def _files_below(directory: Path) -> Iterator[str]:
    """Files in a directory and below, links too, by their paths from there."""
    for folder, folders, files in os.walk(directory):
        links = [one for one in folders if os.path.islink(os.path.join(folder, one))]
        for name in (*files, *links):
            yield Path(folder, name).relative_to(directory).as_posix()


def abandoned_directories(name: str) -> list[str]:
    """What killed runs left of a directory of that name; not of runs that still go on."""
    target = Path(os.path.realpath(name))
    pattern = re.compile(
        rf"\.{re.escape(target.name)}\.[0-9a-f]{{{2 * _TOKEN_BYTES}}}\.(partial|replaced)"
    )
    if not target.parent.is_dir():
        return []
    return [
        str(path)
        for path in sorted(target.parent.iterdir())
        if pattern.fullmatch(path.name) and path.is_dir() and is_free(str(path))
    ]
