"""The hot loop is built once for each instruction set. A function that two builds left out of line
under one name would be linked once, and an older processor could be given a newer one's code."""

import re
import subprocess
from pathlib import Path

import pytest

BUILD = Path(__file__).parents[2] / "build/default"
NEWER = re.compile(r"omma_\w+_(avx2|avx512)\.dir")


# A row of `readelf`: what is weak but no object, or unique, and is there, in a section by number.
# nm says the same and takes fifteen times as long.
OUT_OF_LINE = re.compile(r" (?:(?:FUNC|NOTYPE) +WEAK|\w+ +UNIQUE) +\w+ +\d+ (\S+)$", re.MULTILINE)


def functions_out_of_line(path):
    """Names that the linker takes from any file that has them (weak, or unique)."""
    command = ["readelf", "--symbols", "--wide", path]
    listed = subprocess.run(command, capture_output=True, text=True, check=True)
    return set(OUT_OF_LINE.findall(listed.stdout))


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
