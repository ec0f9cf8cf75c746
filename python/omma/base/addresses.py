"""Outputs that are addresses: `s3://...`, `gs://...`, `memory://...` are written through fsspec, an
optional extra; `file:///...` and `~/...` are files of this system.

What goes to an address is written here first and sent when it is whole, so that nothing half is
ever seen there, and nothing is lost where the sending fails.
"""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from omma._core import Error
from omma.base.directories import WhatIsKept, why_not_replaced
from omma.base.optional import needs

PathLike = str | os.PathLike[str]

# One letter and a colon is a drive of another system, and no address.
_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]+):/")
# Where making folders would make a bucket, which nobody asked for.
_WITHOUT_FOLDERS = ("s3", "s3a", "gs", "gcs", "az", "abfs", "abfss", "adl", "oss", "cos")


def local_path(path: PathLike) -> str:
    """A name as it is used: of `file:` addresses the path, `~` as the home; others as they are."""
    name = os.fsdecode(path)
    if name.lower().startswith("file:/"):
        address = urlsplit(name)
        if address.netloc not in ("", "localhost") or address.query or address.fragment:
            raise Error(f"{name}: expected file:/// and a path of this system")
        name = unquote(address.path)
    found = _SCHEME.match(name)
    if found:  # with both slashes again, where `Path` has made one of them
        return f"{found[1]}://{name[found.end() :].lstrip('/')}"
    return os.path.expanduser(name)


def is_address(name: PathLike) -> bool:
    """Whether a name is an address, also where `Path` has made one slash of two."""
    return _SCHEME.match(os.fsdecode(name)) is not None


def expect_local(path: PathLike, what: str) -> str:
    """`local_path`, or omma.Error where it is an address: ``what`` is written here only."""
    name = local_path(path)
    if is_address(name):
        raise Error(
            f"{name}: {what} cannot be written to an address; write it here and copy it there"
        )
    return name


def check_address(name: str) -> None:
    """Throws omma.Error where nothing could be written to an address."""
    files, path = _files_of(name)
    if not path.strip("/"):
        raise Error(f"{name}: expected a name behind the address")
    try:
        files.exists(path)  # asks those who keep it: who cannot be reached is told of now
    except Exception as error:  # of many libraries
        raise Error(f"{name}: cannot be reached: {_said(error)}") from None


class SentFiles:
    """Files and directories that are sent to addresses when they are whole."""

    def __init__(self) -> None:
        self._folder = tempfile.mkdtemp(prefix="omma-")
        self._here: dict[str, str] = {}  # by address
        # Markers of directories, by address, and what of these is kept.
        self._markers: dict[str, tuple[str, WhatIsKept]] = {}

    def path_of(self, name: str) -> str:
        """Where here is written what goes to that address."""
        if name not in self._here:
            check_address(name)
            own = Path(self._folder) / str(len(self._here))
            own.mkdir()
            self._here[name] = str(own / name.rstrip("/").rsplit("/", 1)[-1])
        return self._here[name]

    def directory_of(self, name: str, marker: str, kept: WhatIsKept) -> str:
        """The same for a directory; one that is there is replaced as by `WholeDirectory`."""
        here = self.path_of(name)
        self._markers[name] = marker, kept
        files, path = _files_of(name)
        try:
            _is_taken(files, path, marker, kept)
        except FileExistsError as error:
            raise Error(f"{name}: cannot be written: {error}") from None
        return here

    def send(self) -> None:
        """Send all; what cannot be sent stays here, and the error says where."""
        for name, here in self._here.items():
            files, path = _files_of(name)
            try:
                if name in self._markers and _is_taken(files, path, *self._markers[name]):
                    files.rm(path, recursive=True)
                parent = path.rstrip("/").rpartition("/")[0]
                if parent and name.partition(":")[0].lower() not in _WITHOUT_FOLDERS:
                    files.makedirs(parent, exist_ok=True)
                if name in self._markers:
                    files.put(f"{here}/", f"{path}/", recursive=True)
                else:
                    files.put_file(here, path)
            except Exception as error:  # of many libraries
                raise Error(
                    f"{name}: cannot be written: {_said(error)}; what was made is in {here}"
                ) from None
            self._remove(here)
        self.discard()

    def discard(self) -> None:
        """Remove what is here."""
        shutil.rmtree(self._folder, ignore_errors=True)

    def _remove(self, here: str) -> None:
        shutil.rmtree(os.path.dirname(here), ignore_errors=True)


def _is_taken(files: Any, path: str, marker: str, kept: WhatIsKept) -> bool:
    """Whether something has a directory's name; FileExistsError where that is not replaced."""
    if not files.exists(path):
        return False
    file = f"{path}/{marker}"
    held = files.cat_file(file) if files.exists(file) else None
    inside = (one.removeprefix(f"{path.rstrip('/')}/") for one in files.find(path))
    why = why_not_replaced(held, inside, marker, kept)
    if why is not None:
        raise FileExistsError(why)
    return True


def _files_of(name: str) -> tuple[Any, str]:
    """What fsspec has for an address, and the path there."""
    fsspec = needs("fsspec.core", "remote", f"{name}: is an address and needs fsspec")
    try:
        files, path = fsspec.url_to_fs(name)
    except ImportError as error:
        raise Error(f"{name}: {_said(error)}") from None
    except Exception as error:
        raise Error(f"{name}: expected an address that fsspec knows: {_said(error)}") from None
    return files, path


def _said(error: Exception) -> str:
    """What another library says, in one line."""
    return " ".join(str(error).split()) or type(error).__name__
