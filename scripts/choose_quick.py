"""Chooses what scripts/test --quick leaves out: the long tests of the last whole run, but for those
of what has changed since.

Usage: choose_quick.py FOLDER OUT

FOLDER holds what scripts/test left: cpp.xml and python.xml (JUnit), and `commit`. Writes
OUT/pytest.txt, arguments for pytest, and OUT/ctest.txt, an expression of names that CTest leaves
out. Tests belong to a changed file where their file is it, includes or imports it, or where their
name says its path, as tests of pages do.
"""

import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from collections import Counter
from pathlib import Path

# The shortest tests that together take about two minutes on two cores: six of seven.
LONGEST_S = {"cpp.xml": 0.5, "python.xml": 0.3}
# Files whose long tests take more are left out whole: what their tests share takes as long.
LONGEST_OF_A_FILE_S = 30
SUITE = re.compile(r"^\s*TEST(?:_[FP])?\(\s*(\w+)", re.MULTILINE)


def git(*arguments: str) -> list[str]:
    done = subprocess.run(["git", *arguments], capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


def long_tests(report: Path) -> dict[tuple[str, str], float]:
    """Seconds of the tests that took longer than a quick run has for one, by class and name."""
    cases = ET.parse(report).getroot().iter("testcase")
    times = {
        (case.get("classname", ""), case.get("name", "")): float(case.get("time", 0))
        for case in cases
    }
    return {test: time for test, time in times.items() if time > LONGEST_S[report.name]}


def changed_since(commit: str) -> list[str]:
    """Paths of what has changed since a commit, or was never committed."""
    changed = git("diff", "--name-only", commit)
    return changed + git("ls-files", "--others", "--exclude-standard")


def tests_of(changed: list[str]) -> list[Path]:
    """Test files that have changed, or include or import what has."""
    said = []
    for path in changed:
        if (where := re.fullmatch(r"python/(omma/.*)/(\w+)\.py", path)) is not None:
            room, module = where[1].replace("/", r"\."), where[2]
            said.append(rf"\b{room}\.{module}\b|from {room} import [^\n]*\b{module}\b")
        elif (where := re.fullmatch(r"(src|include)/(.*\.h)", path)) is not None:
            said.append(f'"{re.escape(where[2])}"')
    mention = re.compile("|".join(said)) if said else None
    files = [*Path("tests/python").glob("test_*.py"), *Path("tests/cpp").glob("*.cpp")]
    return [
        file
        for file in sorted(files)
        if str(file) in changed or (mention and mention.search(file.read_text("utf-8")))
    ]


def main() -> None:
    folder, out = map(Path, sys.argv[1:])
    changed = changed_since((folder / "commit").read_text().strip())
    files = tests_of(changed)
    suites = {suite for file in files for suite in SUITE.findall(file.read_text("utf-8"))}
    of_python, seconds = [], Counter[str]()
    for (place, name), time in long_tests(folder / "python.xml").items():
        path = f"{place.replace('.', '/')}.py"
        if Path(path) not in files and not any(each in name for each in changed):
            of_python.append((path, name))
            seconds[path] += time
    whole = [path for path in seconds if seconds[path] > LONGEST_OF_A_FILE_S]
    of_cpp = [
        name
        for _, name in long_tests(folder / "cpp.xml")
        if not suites.intersection(re.split(r"[./]", name))
    ]
    lines = [f"--ignore={path}" for path in whole]
    lines += [f"--deselect={path}::{name}" for path, name in of_python if path not in whole]
    (out / "pytest.txt").write_text("\n".join(lines) + "\n")
    left_out = "|".join(re.escape(name) for name in of_cpp)
    (out / "ctest.txt").write_text(f"^({left_out or 'none'})$")
    print(
        f"Left out, as they took long in the last whole run: {len(of_cpp)} C++ tests, "
        f"{len(of_python)} Python tests and the rest of {len(whole)} of their files. "
        f"{len(files)} test files belong to what has changed since."
    )


main()
