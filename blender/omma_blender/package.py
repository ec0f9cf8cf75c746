"""Finds the Python that has the package omma, and lets it work in a process of its own.

What is said between the two is in worker.py. Nothing here needs Blender.
"""

from __future__ import annotations

import json
import os
import queue
import shutil
import subprocess
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

HOW_TO_INSTALL = (
    "Install the package (pip install omma, in an environment of its own), then name that "
    "environment's folder in Edit > Preferences > Add-ons > Omma"
)
WORKER = Path(__file__).with_name("worker.py")


class OmmaError(Exception):
    """What goes wrong with words for whoever sits before the screen."""


def python_of(program: str) -> str:
    """The Python that a path means: itself, or the one beside an executable called omma.

    Raises:
        OmmaError: there is no such file, or none beside it.
    """
    path = Path(os.path.expanduser(program))
    if path.is_dir():
        places = [path / name for name in ("bin/python", "Scripts/python.exe", "python.exe")]
    elif not path.is_file():
        raise OmmaError(f"{program}: there is no such file (Preferences > Add-ons > Omma)")
    elif path.stem == "omma":
        # The environment's folder; else the first line of the script says who runs it.
        places = [path.with_name("python"), path.with_name("python.exe")]
        with path.open("rb") as file:
            first = file.readline(1000)
        if first.startswith(b"#!"):
            places.insert(0, Path(first[2:].decode("utf-8", "replace").strip()))
    else:
        places = [path]
    for place in places:
        if place.is_file():
            return str(place)
    raise OmmaError(f"{program}: found no Python there (Preferences > Add-ons > Omma)")


def candidates() -> list[str]:
    """Pythons that may have omma, the likeliest first."""
    found = [os.environ.get("OMMA_PYTHON", "")]
    if omma := shutil.which("omma"):
        found.append(omma)
    places = [os.environ.get("VIRTUAL_ENV"), os.environ.get("CONDA_PREFIX")]
    home = Path.home()
    places += [str(home / name) for name in (".venv", "omma/.venv", "omma", "venv")]
    found += [place for place in places if place and Path(place).is_dir()]
    found += [python for name in ("python3", "python") if (python := shutil.which(name))]
    unique: list[str] = []
    for one in filter(None, found):
        try:
            python = python_of(one)
        except OmmaError:
            continue
        if python not in unique:
            unique.append(python)
    return unique


_found: dict[str, str] = {}  # what the preference said, and the Python that was found for it


def find_python(preferred: str) -> str:
    """The Python with omma: the one the preferences name, else the first that has it.

    Raises:
        OmmaError: none has it; it says how to install it.
    """
    if preferred in _found and Path(_found[preferred]).is_file():
        return _found[preferred]
    if preferred:
        python = python_of(preferred)
        if not _has_omma(python):
            raise OmmaError(
                f"{preferred}: there is no package omma in this Python. {HOW_TO_INSTALL}"
            )
        _found[preferred] = python
        return python
    for python in candidates():
        if _has_omma(python):
            _found[preferred] = python
            return python
    raise OmmaError(f"There is no Python with the package omma. {HOW_TO_INSTALL}")


def _has_omma(python: str) -> bool:
    try:
        tried = subprocess.run(
            [python, "-c", "import omma; omma.__version__"],
            env=_environment(),
            cwd=tempfile.gettempdir(),  # not where a folder might be called omma
            capture_output=True,
            timeout=60,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return tried.returncode == 0


def _environment() -> dict[str, str]:
    # Blender may run with a home of Python of its own, in which the other would look for modules.
    return {name: value for name, value in os.environ.items() if name != "PYTHONHOME"}


class Work:
    """A task that another process is at. `poll` never waits."""

    def __init__(self, python: str, task: str, **arguments: Any) -> None:
        self.stage = "Starting omma"
        self.fraction: float | None = None
        self.warnings: list[str] = []
        self.done: dict[str, Any] | None = None
        self.error: str | None = None
        self._folder = tempfile.TemporaryDirectory(prefix="omma-request-")
        request = Path(self._folder.name, "request.json")
        request.write_text(json.dumps({"task": task, **arguments}), encoding="utf-8")
        self._said = Path(self._folder.name, "said.txt")
        try:
            with self._said.open("wb") as said:
                self._process = subprocess.Popen(
                    [python, str(WORKER), str(request)],
                    env=_environment(),
                    cwd=self._folder.name,
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.PIPE,
                    stderr=said,
                )
        except OSError as error:
            self._folder.cleanup()
            raise OmmaError(f"{python}: cannot be started: {error.strerror}") from None
        self._lines: queue.Queue[bytes | None] = queue.Queue()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as lines:
            for line in lines:
                self._lines.put(line)
        self._lines.put(None)

    def poll(self) -> bool:
        """Takes in what was answered; True when the process has ended."""
        while self.done is None and self.error is None:
            try:
                line = self._lines.get_nowait()
            except queue.Empty:
                return False
            if line is None:
                said = self._said.read_text(encoding="utf-8", errors="replace").strip()
                code = self._process.wait()
                last = said.splitlines()[-1] if said else "it said nothing"
                self.error = f"omma ended with code {code}: {last}"
                break
            self._take(json.loads(line))
        return True

    def _take(self, answer: dict[str, Any]) -> None:
        if "done" in answer:
            self.done = answer["done"]
        elif "error" in answer:
            self.error = answer["error"]
            if answer.get("missing"):
                self.error = f"{self.error}. {HOW_TO_INSTALL}"
        elif "warning" in answer:
            self.warnings.append(answer["warning"])
        else:
            self.stage, self.fraction = answer["stage"], answer["fraction"]

    def close(self) -> None:
        """Ends the process where it still works, and takes away what it was asked by."""
        if self._process.poll() is None:
            if self.done is None:
                self._process.terminate()
            try:
                self._process.wait(10)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        self._folder.cleanup()

    def result(self) -> dict[str, Any]:
        """Waits for the end.

        Raises:
            OmmaError: what the other side said went wrong.
        """
        try:
            while not self.poll():
                time.sleep(0.01)
        finally:
            self.close()
        if self.done is None:
            raise OmmaError(self.error or "omma ended without a result")
        return self.done


def ask(preferred: str, task: str, **arguments: Any) -> dict[str, Any]:
    """Has one task done and waits for it; raises OmmaError as `find_python` and `Work.result`."""
    return Work(find_python(preferred), task, **arguments).result()
