"""Kernels of a graphics card: that NVIDIA's compiler takes them, and what they take of a card. How
they are compiled and kept is tested in tests/cpp/cuda_compile.cpp."""

import ctypes
import hashlib
import subprocess
import sys
from pathlib import Path

import pytest

from omma.base.card_compiler import find_nvrtc
from omma.base.directories import cache_folder

ROOT = Path(__file__).parents[2]
PROGRAM = ROOT / "build/default/tests/cpp/omma_kernel_report"
TABLE = ROOT / "src/backend/cuda/kernels.txt"
COMPILED_FOR = "90"
# What is compiled, with which options, and what is read out of the compiler's log.
SOURCES = (
    ROOT / "build/default/kernel_sources.cpp",
    ROOT / "src/backend/cuda/compile.cpp",
    ROOT / "tests/cpp/kernel_report.cpp",
)


def rows_of(lines):
    """What depends on the compiler alone: without the seconds that it took."""
    ours = [line.split() for line in lines if line.startswith(f"sm_{COMPILED_FOR} ")]
    return [row[:4] if row[1].endswith(".cu:") else row for row in ours]


def version_of(nvrtc):
    numbers = ctypes.c_int(), ctypes.c_int()
    assert ctypes.CDLL(nvrtc).nvrtcVersion(*(ctypes.byref(one) for one in numbers)) == 0
    return "NVRTC {}.{}".format(*(one.value for one in numbers))


def test_kernels_are_those_of_the_table():
    """One compiler makes one thing of the same sources, and takes two minutes for it: it is run
    where the table is not of these sources."""
    nvrtc = find_nvrtc()
    if not nvrtc:
        pytest.skip("NVRTC is not installed: pip install 'omma[cuda]'")
    if not PROGRAM.exists():
        pytest.skip("no build of omma_kernel_report in build/default")
    table = TABLE.read_text().splitlines()
    assert rows_of(table)
    sources = hashlib.sha256(b"".join(path.read_bytes() for path in SOURCES)).hexdigest()
    if version_of(nvrtc) in table and f"sources {sources}" in table:
        return
    report = subprocess.run([PROGRAM, COMPILED_FOR, nvrtc], capture_output=True, text=True)
    assert report.returncode == 0, report.stderr  # warnings, or the log of a failure
    lines = report.stdout.splitlines()
    if lines[0] not in table:
        pytest.skip(f"{TABLE.name} is not of {lines[0]}")
    assert rows_of(lines) == rows_of(table), "where that is meant to be: scripts/kernel_report"


@pytest.mark.parametrize(
    ("newest", "found"),
    [(None, "cu14/lib/libnvrtc.so.14"), (13, "cu13/lib/libnvrtc.so.13"), (11, "")],
)
def test_where_nvrtc_is(tmp_path, monkeypatch, newest, found):
    for name in (
        "cu13/lib/libnvrtc.so.13",
        "cu14/lib/libnvrtc.so.14",
        "cu13/lib/libnvrtc-builtins.so.13.5",
        "cuda_nvrtc/lib/libnvrtc.so.12",
        "cuda_nvrtc/lib/libnvrtc.alt.so.12",
    ):
        path = tmp_path / "nvidia" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    monkeypatch.setattr("sys.path", [str(tmp_path)])
    monkeypatch.delitem(sys.modules, "nvidia", raising=False)
    assert find_nvrtc(newest) == (str(tmp_path / "nvidia" / found) if found else "")


def test_nothing_of_nvidia_is_installed(tmp_path, monkeypatch):
    monkeypatch.setattr("sys.path", [str(tmp_path)])
    monkeypatch.delitem(sys.modules, "nvidia", raising=False)
    assert find_nvrtc() == ""


def test_where_kernels_are_kept(tmp_path, monkeypatch):
    monkeypatch.setenv("OMMA_CACHE", str(tmp_path))
    assert cache_folder("kernels") == tmp_path / "kernels"
    monkeypatch.delenv("OMMA_CACHE")
    assert cache_folder("kernels").name == "kernels"
