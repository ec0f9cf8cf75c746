"""What ARCHITECTURE.md and CONVENTIONS.md have in code type is there: files, or words of code."""

import functools
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = (
    *("src", "include", "python", "compat", "tests", "bench", "docs", "scripts", "examples"),
    *("packaging", "blender", "fuzz", "cmake"),
)
CODE = {
    *(".h", ".cpp", ".c", ".cu", ".py", ".pyi", ".js", ".css", ".csv", ".txt", ".cmake", ".toml"),
    *(".json", ".yaml", ".in", ".map", ""),
}
# What is in code type and names nothing: how names are written.
OTHERS = {"PascalCase", "snake_case"}
# Files of other projects that comments cite.
OTHER_FILES = {"libEyeRenderer3/shaders.cu", "MulticamScene.cpp", "analysis_tools.py", "jpeglib.h"}

PAGES = ("ARCHITECTURE.md", "CONVENTIONS.md")


@functools.cache
def files():
    """Paths of all files of the project, as texts with slashes."""
    found = [path for path in ROOT.iterdir() if path.is_file()]
    for folder in FOLDERS:
        found += [path for path in (ROOT / folder).rglob("*") if path.is_file()]
    own = Path(__file__).name
    return {
        path.relative_to(ROOT).as_posix(): path
        for path in found
        if "__pycache__" not in path.parts and path.name != own
    }


@functools.cache
def ends():
    """What the paths of files and folders end in, with and without the ending of the name."""
    found = set()
    for name in files():
        parts = name.split("/")
        for stop in range(1, len(parts) + 1):
            for start in range(stop):
                path = "/".join(parts[start:stop])
                found.update((path, path.rsplit(".", 1)[0]))
    return found


@functools.cache
def words():
    """All words of the code."""
    found = set()
    for path in files().values():
        if path.suffix in CODE and path.stat().st_size < 1 << 20:
            found.update(re.findall(r"\w+", path.read_text(encoding="utf-8", errors="ignore")))
    return found


def is_file(sign):
    """Whether a file or folder has a path that ends so; * and NAME stand for any letters, and a
    name that begins with _ for the end of one."""
    sign = sign.strip("/").replace("NAME", "*")
    if sign.startswith("_"):
        sign = f"*{sign}"
    if "*" not in sign:
        return sign in ends()
    pattern = re.compile(re.escape(sign).replace(r"\*", "[^/]*"))
    return any(pattern.fullmatch(end) for end in ends())


def is_there(sign):
    """Whether what stands in code type is a file, or all its words are in the code."""
    names = re.findall(r"[^\W\d]\w*", sign)
    return is_file(sign) or all(name in words() or name in OTHERS for name in names)


def signs(page):
    text = re.sub(r"^```.*?^```", "", (ROOT / page).read_text(encoding="utf-8"), flags=re.M | re.S)
    return sorted(set(re.findall(r"`([^`\n]+)`", text)))


@pytest.mark.parametrize("page", PAGES)
def test_names_in_code_type_are_there(page):
    assert len(signs(page)) > 20
    gone = [sign for sign in signs(page) if not is_there(sign)]
    assert not gone, f"{page} names what is nowhere: {', '.join(gone)}"


def test_the_drawing_names_files_that_are_there():
    """Files in the drawing of ARCHITECTURE.md, which is indented text."""
    lines = [
        line
        for line in (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8").splitlines()
        if line.startswith("    ")
    ]
    named = set(re.findall(r"[\w/]+\.(?:h|cpp)\b", "\n".join(lines)))
    assert len(named) > 15
    assert not [name for name in named if not is_file(name)]


def comments(path):
    """The comments and docstrings of a file of C++ or Python, as one text."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".py":
        docstrings = re.findall(r'"""(.*?)"""', text, flags=re.DOTALL)
        return "\n".join([*docstrings, *re.findall(r"#(.*)", text)])
    return "\n".join(re.findall(r"//(.*)", text))


@pytest.mark.parametrize("folder", ["src", "include", "python", "compat"])
def test_files_that_comments_name_are_there(folder):
    gone = {}
    for name, path in files().items():
        if name.startswith(f"{folder}/") and path.suffix in (".h", ".cpp", ".cu", ".py"):
            for sign in re.findall(r"(?<![\w./])[\w/]+\.(?:h|cpp|cu|py)\b", comments(path)):
                if sign not in OTHER_FILES and not is_file(sign):
                    gone.setdefault(name, []).append(sign)
    assert not gone


def test_what_is_not_there_is_found_out():
    assert not is_there("no_such_" + "name_at_all")
    assert not is_there("src/physics/no_such" + "_file.h")
    assert is_there("physics/block/block.h")
    assert is_there("RenderCall::truth")
