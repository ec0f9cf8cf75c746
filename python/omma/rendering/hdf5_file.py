"""A file that HDF5 writes to without ever meeting an error. Where a disk is full HDF5 2.0 cannot
close a file, and ends the process by a segmentation fault when what is left of it is collected; so
it is told that all was written, and the error is raised once it is gone. Ctrl-C while a file object
is asked for something would be such an error too: it waits.
"""

from __future__ import annotations

import io
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any


class Hdf5File:
    """What h5py asks of a file object. After an error nothing more is written."""

    def __init__(self, path: str, mode: str) -> None:
        self._file = io.FileIO(path, mode)
        self.error: OSError | None = None

    def write(self, data: Any) -> int:
        def write_all() -> None:
            left = memoryview(data)
            while len(left) > 0:
                left = left[self._file.write(left) :]

        self._try(write_all)
        return len(data)

    def read(self, size: int = -1) -> bytes:  # by which h5py knows files
        return self._file.read(size) or b""

    def readinto(self, buffer: Any) -> int:
        view, found = memoryview(buffer), 0
        while found < len(view):
            count = self._file.readinto(view[found:])
            if not count:
                break
            found += count
        view[found:] = bytes(len(view) - found)  # what was to be written, but could not
        return len(view)

    def seek(self, offset: int, whence: int = 0) -> int:
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        return self._file.tell()

    def truncate(self, size: int) -> int:
        self._try(lambda: self._file.truncate(size))
        return size

    def flush(self) -> None:
        pass  # nothing is buffered

    def close(self) -> None:
        self._file.close()

    def _try(self, write: Callable[[], Any]) -> None:
        if self.error is not None:
            return
        try:
            write()
        except OSError as error:
            self.error = error


@contextmanager
def signals_wait() -> Iterator[None]:
    """Ctrl-C and the end that others ask for, which the main thread alone is told of, come
    afterwards."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[tuple[int, FrameType | None]] = []
    asked = (signal.SIGINT, signal.SIGTERM)
    # What is not Python's own handler says nothing in Python's code.
    before = {one: handler for one in asked if callable(handler := signal.getsignal(one))}
    for one in before:
        signal.signal(one, lambda number, frame: came.append((number, frame)))
    try:
        yield
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)
    for number, frame in came:
        before[signal.Signals(number)](number, frame)


@contextmanager
def opened(h5netcdf: Any, path: str, mode: str) -> Iterator[Any]:
    """A netCDF-4 file, "w" or "a". Raises OSError where it cannot be written."""
    file = Hdf5File(path, "w+" if mode == "w" else "r+")
    try:
        # The file has the lock of whole files already.
        with signals_wait(), h5netcdf.File(file, mode, locking=False) as netcdf:
            yield netcdf
        if file.error is not None:
            raise file.error
    finally:
        file.close()
