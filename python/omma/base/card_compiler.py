"""NVIDIA's compiler of kernels for graphics cards, where a package has brought it."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

# As the packages of CUDA 13 and of CUDA 12 lay it out: nvidia/cu13/lib, nvidia/cuda_nvrtc/lib.
_LIBRARIES = "*/lib/libnvrtc.so.*"


def find_nvrtc(newest: int | None = None) -> str:
    """The path of the newest NVRTC that is installed as a Python package; "" where none is.

    Args:
        newest: major version of CUDA up to which the card's driver takes kernels, None for any.
    """
    found: list[tuple[int, str]] = []
    spec = importlib.util.find_spec("nvidia")  # a folder that several packages share
    for folder in (spec.submodule_search_locations or ()) if spec is not None else ():
        for path in Path(folder).glob(_LIBRARIES):
            version = re.fullmatch(r"libnvrtc\.so\.(\d+)", path.name)
            if version is not None and (newest is None or int(version[1]) <= newest):
                found.append((int(version[1]), str(path)))
    return max(found, default=(0, ""))[1]
