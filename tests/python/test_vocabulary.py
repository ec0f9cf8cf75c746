"""What the C++ sources promise their readers: short signatures, one name for each header, folders
that include downwards."""

import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
MOST_PARAMETERS = 6

# Folders, from the lowest to the highest: each includes from those before it, and from itself.
# Those of one line know nothing of each other. The public headers, include/omma, are below all.
FOLDERS = [
    ["system"],
    ["threads", "physics"],
    ["optics"],
    ["model"],
    ["io", "light", "receptor", "sampling", "project"],
    ["backend"],
    ["world"],
    ["render"],
]
# The same within src/physics: the chapters of a reading from the first page to the last.
CHAPTERS = [
    ["lanes"], ["sampling"], ["views"], ["search"], ["rays"], ["surface"], ["light"], ["path"],
    ["block"],
]  # fmt: skip

FUNCTION = re.compile(r"OMMA_HD(?:_CALLED)?\s[^;{}=]*?\b([\w]+|operator\S+?)\s*\(")


def without_comments(text):
    return re.sub(r"//[^\n]*", "", text)


def parameters_of(text, begin):
    """What lies between the brackets that open before ``begin``, cut at its commas."""
    depth, parts, last = 0, [], begin
    for at in range(begin, len(text)):
        if text[at] in "([{<":
            depth += 1
        elif text[at] in ")]}>" and text[at - 1] != "-":
            depth -= 1
            if depth < 0:
                parts.append(text[last:at])
                break
        elif text[at] == "," and depth == 0:
            parts.append(text[last:at])
            last = at + 1
    return [part for part in parts if part.strip()]


def functions(path):
    """Names and numbers of parameters of the functions that a header has."""
    text = without_comments(path.read_text())
    for found in FUNCTION.finditer(text):
        yield found[1], len(parameters_of(text, found.end()))


def headers():
    return sorted([*(ROOT / "src").rglob("*.h"), *(ROOT / "include").rglob("*.h")])


def test_functions_of_the_physics_have_few_parameters():
    counted = [
        (path.name, name, count)
        for path in sorted((ROOT / "src" / "physics").rglob("*.h"))
        for name, count in functions(path)
    ]
    assert len(counted) > 300
    assert ("lanes.h", "gather", 2) in counted
    assert [one for one in counted if one[2] > MOST_PARAMETERS] == []


def test_headers_have_names_of_their_own():
    names = Counter(path.name for path in headers())
    assert [name for name, count in names.items() if count > 1] == []


def test_block_says_what_a_search_has():
    physics = sorted((ROOT / "src" / "physics").rglob("*.h"))
    called = {
        name
        for path in physics
        for name in re.findall(r"\bsearch\.(\w+)\(", without_comments(path.read_text()))
    }
    said = set(re.findall(r"^//   (\w+)\(", (ROOT / "src/physics/block/block.h").read_text(), re.M))
    assert called == said == {"closest", "occluded", "placed", "visits_of_trees"}


def includes(folder):
    """(file, its folder below ``folder``, folder of what it includes from there)."""
    for path in sorted([*folder.rglob("*.h"), *folder.rglob("*.cpp"), *folder.rglob("*.cu")]):
        own = path.relative_to(folder).parts[0]
        for name in re.findall(r'#include "([^"]+)"', path.read_text()):
            target = ROOT / "src" / name
            if target.is_relative_to(folder) and target.is_file():
                yield path.name, own, target.relative_to(folder).parts[0]


@pytest.mark.parametrize(
    ("folder", "levels", "least"),
    [("src", FOLDERS, 400), ("src/physics", CHAPTERS, 100)],
    ids=["src", "physics"],
)
def test_folders_include_downwards(folder, levels, least):
    level = {name: height for height, names in enumerate(levels) for name in names}
    assert set(level) == {path.name for path in (ROOT / folder).iterdir()}
    found = list(includes(ROOT / folder))
    assert len(found) > least
    wrong = [
        (file, other) for file, own, other in found if own != other and level[own] <= level[other]
    ]
    assert wrong == []


# Headers of POSIX and of Windows, by which sources depend on a system. Those of the standard C
# library are none.
OF_A_SYSTEM = re.compile(
    r"#include\s*<((?:sys|linux|netinet|arpa)/\S+|windows\.h|winsock2\.h|io\.h|direct\.h|process\.h"
    r"|(?:unistd|fcntl|dlfcn|pthread|signal|sched|dirent|poll|termios|pwd|glob|spawn|semaphore)\.h)>"
)
# Libraries of graphics cards are loaded by dlopen: only where OMMA_CUDA is on.
LOADS_LIBRARIES = {"src/backend/cuda/driver.cpp", "src/backend/cuda/nvrtc.cpp"}


def test_what_is_of_a_system_is_in_one_room():
    found = {}
    for base in ("src", "include", "python/src", "compat"):
        for path in [*(ROOT / base).rglob("*.h"), *(ROOT / base).rglob("*.cpp")]:
            names = OF_A_SYSTEM.findall(path.read_text())
            if names:
                found[path.relative_to(ROOT).as_posix()] = names
    elsewhere = {
        path: names
        for path, names in found.items()
        if not path.startswith("src/system/") and path not in LOADS_LIBRARIES
    }
    assert elsewhere == {}
    assert all(found[path] == ["dlfcn.h"] for path in LOADS_LIBRARIES)
    # Each header of the room is done for both, in files that only its system compiles.
    room = {path.name for path in (ROOT / "src/system").iterdir()}
    headers_of_room = [name[:-2] for name in room if name.endswith(".h")]
    assert room == {
        f"{name}{end}" for name in headers_of_room for end in (".h", "_posix.cpp", "_windows.cpp")
    }


def test_the_reading_path_is_as_long_as_architecture_says():
    printed = subprocess.run(
        [sys.executable, ROOT / "scripts" / "reading_path"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout.splitlines()
    page = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8").splitlines()
    assert len(printed) > 4
    for line in printed[2:]:
        *what, own, total = line.strip("| ").split(" | ")
        said = [other for other in page if other.startswith("| " + " | ".join(what))]
        assert len(said) == 1, f"ARCHITECTURE.md lacks what scripts/reading_path prints: {line}"
        # A page more or less by small changes.
        numbers = [int(number) for number in said[0].strip("| ").split(" | ")[-2:]]
        assert numbers == pytest.approx([int(own), int(total)], abs=1)


# Includes for what lies behind them: an umbrella, errors that callers of public functions catch, a
# library that a file of ours stands for, a type that is deleted.
FOR_OTHERS = {"omma.h", "error.h", "io.h", "embree_api.h", "camera_rays.h"}
DECLARED = (
    r"\b(?:struct|class|enum class|enum|union)\s+(?:alignas\([^)]*\)\s*)?(\w+)",
    r"\busing\s+(\w+)\s*=",
    r"#define\s+(\w+)",
    r"\b(\w+)\s*\(",
    r"\bconstexpr\b[^=;(]*?\b(\w+)\s*(?:\[[^\]]*\])*\s*[={]",
    r",\s*(\w+)\s*=",
)


def test_includes_are_used():
    """Of each header of ours something is named in the file that includes it: read as text, so a
    word that both happen to have hides one that is not used."""
    checked, unused = 0, []
    for path in sorted([*headers(), *(ROOT / "src").rglob("*.cpp")]):
        text = without_comments(path.read_text())
        words = set(re.findall(r"\w+", re.sub(r"#include[^\n]*", "", text)))
        for name in re.findall(r'#include "([^"]+)"', text):
            found = [ROOT / base / name for base in ("src", "include")]
            header = next((one for one in found if one.is_file()), None)
            if header is None or header.stem == path.stem or path.name == "omma.h":
                continue
            declares = without_comments(header.read_text())
            names = {one for pattern in DECLARED for one in re.findall(pattern, declares)}
            checked += 1
            if not names & words and header.name not in FOR_OTHERS:
                unused.append((path.name, name))
    assert checked > 700
    assert unused == []
