"""The processor that this runs on: its model and its instruction set."""

from __future__ import annotations

import platform
from functools import cache
from pathlib import Path

# What Embree asks of a processor, besides what is above, before it takes its code for one of these.
_SETS = (
    ("SSE4.2", {"sse4_2", "popcnt"}),
    ("AVX", {"avx"}),
    ("AVX2", {"avx2", "fma", "f16c", "rdrand", "abm", "bmi1", "bmi2"}),
    ("AVX-512", {"avx512f", "avx512dq", "avx512cd", "avx512bw", "avx512vl"}),
)


def instruction_set() -> str:
    """The newest that Embree has code for, such as "AVX2"; where the system does not say what its
    processor has, the kind of machine, such as "arm64"."""
    flags = processor_flags()
    if not flags:
        return platform.machine()
    found = "SSE2"
    for name, asked in _SETS:
        if not asked <= flags:
            break
        found = name
    return found


def processor_flags() -> frozenset[str]:
    """What Linux says that an x86 processor has; else nothing."""
    return frozenset(_said_by_linux("flags").split())


def processor_model() -> str:
    """The model, as Linux says it; else ""."""
    return _said_by_linux("model name")


@cache
def _said_by_linux(what: str) -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return ""
    return next((line.partition(":")[2].strip() for line in lines if line.startswith(what)), "")
