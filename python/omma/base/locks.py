"""Locks that other processes see, of files and directories, and bringing these to the disk, by what
the system has. It lets go of a lock where a process ends, however it does.
"""

from __future__ import annotations

import errno
import os
import sys
from contextlib import suppress

if sys.platform == "win32":
    import msvcrt

    # Directories cannot be opened, nor renamed with an open file in them: a file beside them is
    # locked, which goes when it is closed.
    _ENDING = ".lock"
    _TO_LOCK = os.O_RDWR | os.O_CREAT | os.O_TEMPORARY
    _TO_SYNC = os.O_RDWR
    _SYNCS_NAMES = True

    def lock(descriptor: int, wait: bool = False) -> bool:
        """Lock an open file until it is closed; False where somebody else has it."""
        os.lseek(descriptor, 0, os.SEEK_SET)  # a byte is locked there, which need not exist
        with suppress(OSError):
            msvcrt.locking(descriptor, msvcrt.LK_LOCK if wait else msvcrt.LK_NBLCK, 1)
            return True
        return False

else:
    import fcntl

    _ENDING = ""
    _TO_LOCK = _TO_SYNC = os.O_RDONLY
    _SYNCS_NAMES = False

    def lock(descriptor: int, wait: bool = False) -> bool:
        """Lock an open file until it is closed; False where somebody else has it."""
        with suppress(OSError):
            fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
            return True
        return False


def lock_directory(path: str) -> int:
    """Lock a directory that nobody else writes; closing the descriptor lets go of it."""
    descriptor = os.open(f"{path}{_ENDING}", _TO_LOCK)
    if not lock(descriptor, wait=True):  # who asks whether it is free is done at once
        os.close(descriptor)
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK), path)
    return descriptor


def is_free(path: str) -> bool:
    """Whether nobody has locked a directory."""
    try:
        descriptor = os.open(f"{path}{_ENDING}", _TO_LOCK)
    except PermissionError:  # of Windows, while it is being removed
        return False
    try:
        return lock(descriptor)
    finally:
        os.close(descriptor)


def sync(path: str) -> None:
    """Bring a file, or the names in a directory, to the disk."""
    if _SYNCS_NAMES and os.path.isdir(path):  # the system does so itself
        return
    descriptor = os.open(path, _TO_SYNC)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
