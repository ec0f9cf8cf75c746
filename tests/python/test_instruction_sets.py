"""The hot loop is built once for each instruction set. A function that two builds left out of line
under one name would be linked once, and an older processor could be given a newer one's code."""

import re
import subprocess
from pathlib import Path

import pytest

BUILD = Path(__file__).parents[2] / "build/default"
NEWER = re.compile(r"omma_\w+_(avx2|avx512)\.dir")


def functions_out_of_line(path):
    """Names that the linker takes from any file that has them (weak, or unique)."""
    listed = subprocess.run(
        ["nm", "--defined-only", path], capture_output=True, text=True, check=True
    )
    rows = [line.split() for line in listed.stdout.splitlines()]
    return {row[-1] for row in rows if row[-2] in "Wu"}


def test_no_function_is_shared():
    files = [path for path in BUILD.glob("**/*.o") if "CMakeFiles" in path.parts]
    if not any(NEWER.search(str(path)) for path in files):
        pytest.skip("no build for newer instruction sets in build/default")
    builds = {}
    for path in files:
        found = NEWER.search(str(path))
        for name in functions_out_of_line(path):
            builds.setdefault(name, set()).add(found[1] if found else "any processor")
    assert any(len(of) == 1 and "avx512" in of for of in builds.values())
    assert [name for name, of in builds.items() if len(of) > 1] == []
