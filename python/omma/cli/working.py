"""What every command does while it works: a progress bar, Ctrl-C, one line for what went wrong."""

from __future__ import annotations

import io
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from omma._core import Error


@contextmanager
def working() -> Iterator[DelayedBar]:
    """A progress bar while a command works; Ctrl-C ends the command with one line."""
    with interruptible(), DelayedBar() as bar:
        yield bar


class Terminated(KeyboardInterrupt):
    """A signal that asks the command to end; it unwinds as Ctrl-C does, and cleans up."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


def open_missing_streams() -> None:
    """Puts the null device where the shell has closed a standard stream (``>&-``).

    Else a file that we open would come to be there.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest number that is free: this one
            setattr(sys, name, open(number, "w" if number else "r"))  # noqa: SIM115
    # A name that is not UTF-8 must not end a command that has done its work.
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")


@contextmanager
def unwinding_on_signals() -> Iterator[None]:
    """SIGTERM and SIGHUP clean up as Ctrl-C does. For the command line only: in other programs it
    is not ours to say what signals do."""
    # What is ignored stays ignored: nohup.
    taken = [
        number
        for number in (signal.SIGTERM, signal.SIGHUP)
        if signal.getsignal(number) is signal.SIG_DFL
    ]
    for number in taken:
        signal.signal(number, _terminate)
    try:
        yield
    finally:
        for number in taken:
            signal.signal(number, signal.SIG_DFL)


def _terminate(number: int, _: object) -> None:
    raise Terminated(number)


@contextmanager
def interruptible() -> Iterator[None]:
    """Ctrl-C ends the command with one line."""
    # Before typer sees it, which would print an empty line first.
    try:
        yield
    except KeyboardInterrupt as error:
        raise typer.Exit(interrupted(error)) from None


def interrupted(error: KeyboardInterrupt) -> int:
    """Say that a signal ended the command; the exit code is handed back, 128 and the signal."""
    number = error.number if isinstance(error, Terminated) else signal.SIGINT
    name = "" if number == signal.SIGINT else f" by {signal.Signals(number).name}"
    return fail(f"interrupted{name}", 128 + number)


def check_outputs(*paths: Path | None) -> None:
    """An error now where a file cannot be written, not after minutes of work; and a warning where
    runs that were killed left something behind."""
    # Here, as it needs NumPy, which ``omma --help`` does not.
    from omma.base.files import check_target, left_behind

    names = [str(path) for path in paths if path is not None]
    for name in names:
        check_target(name)
    for warning in left_behind(names):
        warn(warning)


def readable(text: str) -> str:
    """The text with control characters escaped: names in files may say anything, to a terminal
    too."""
    return str(Error(text))


def say(*lines: str) -> None:
    """Lines on stdout, readable."""
    for line in lines:
        print(readable(line))


def warn(message: str) -> None:
    """Say something on stderr that is no reason to stop."""
    print(f"omma: warning: {Error(message)}", file=sys.stderr)


def fail(message: str, code: int) -> int:
    """Say on stderr what went wrong; the exit code is handed back."""
    with suppress(OSError):  # the terminal may be gone: nobody to tell
        # What typer says has several lines; what Error makes of it no control characters.
        print(f"omma: error: {Error(' '.join(message.split()))}", file=sys.stderr)
    return code


class DelayedBar:
    """A progress bar on stderr that appears after a second, and never where that is no terminal."""

    def __init__(self) -> None:
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:>3.0f} %"),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            transient=True,
        )
        self._task = self._bar.add_task("", total=None)
        self._stage = ""
        self._timer = threading.Timer(1.0, self._bar.start)
        self._timer.daemon = True
        self._wanted = sys.stderr.isatty() and sys.stdout.isatty()

    def show(self, stage: str, fraction: float | None) -> None:
        if stage != self._stage:
            # Else the time left would be that of the stage before, which is over.
            self._bar.reset(self._task)
            self._stage = stage
        self._bar.update(
            self._task,
            description=stage,
            total=None if fraction is None else 1.0,
            completed=fraction or 0.0,
        )

    def fraction_of(self, stage: str) -> Callable[[float], None]:
        """Takes how much of that stage is finished."""
        return partial(self.show, stage)

    def __enter__(self) -> DelayedBar:
        if self._wanted:
            self._timer.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._timer.cancel()
        if self._wanted:
            self._timer.join()
            self._bar.stop()
