"""How much memory there is for what is about to be made."""

from __future__ import annotations

import ctypes
import os
import sys


def free_bytes() -> float:
    """Memory that can be taken without driving others out: what the system says is available, and
    where it does not, what the machine has."""
    if sys.platform == "win32":
        # MEMORYSTATUSEX: two 32-bit numbers, its size and the load in per cent; then seven of 64
        # bits, the first two of which are what the machine has and what is available.
        status = (ctypes.c_uint64 * 8)(64)
        ctypes.windll.kernel32.GlobalMemoryStatusEx(status)
        return float(status[2])
    try:
        with open("/proc/meminfo", encoding="ascii") as file:
            for line in file:
                if line.startswith("MemAvailable:"):
                    return float(line.split()[1]) * 1024
    except OSError:
        pass
    return float(os.sysconf("SC_PHYS_PAGES")) * os.sysconf("SC_PAGE_SIZE")


def words_for_bytes(count: float) -> str:
    """As 3.2 GB or 45 MB."""
    return f"{count / 1e9:,.1f} GB" if count >= 1e9 else f"{count / 1e6:,.0f} MB"
