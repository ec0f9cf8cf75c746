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
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn
from rich.text import Text

from omma._core import Error

# Where stderr is no terminal: how often it is told how far the work is.
LINE_EVERY_S = 10.0
# Over how long the speed is a mean from which the time left follows: items take unlike times.
_SPEED_OVER_S = 300.0


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
    """SIGTERM and SIGHUP, on Windows SIGBREAK, clean up as Ctrl-C does. For the command line only:
    in other programs it is not ours to say what signals do."""
    ending = [
        getattr(signal, name) for name in ("SIGTERM", "SIGHUP", "SIGBREAK") if hasattr(signal, name)
    ]
    # What is ignored stays ignored: nohup.
    taken = [number for number in ending if signal.getsignal(number) is signal.SIG_DFL]
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
    # What was interrupted may say what is kept of its work.
    return fail(": ".join([f"interrupted{name}", *getattr(error, "__notes__", ())]), 128 + number)


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


def note(message: str) -> None:
    """Say something on stderr beside what the command says."""
    print(f"omma: {readable(message)}", file=sys.stderr)


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
    """How far the work is, on stderr: a progress bar that appears after a second, or where that is
    no terminal a line now and then."""

    def __init__(self) -> None:
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            _Share(),
            _Times(),
            console=Console(stderr=True),
            transient=True,
            speed_estimate_period=_SPEED_OVER_S,
        )
        self._task = self._bar.add_task("", total=None)
        self._stage = ""
        self._on_terminal = sys.stderr.isatty() and sys.stdout.isatty()
        self._ended = threading.Event()
        self._teller = threading.Thread(target=self._tell, daemon=True)

    def show(self, stage: str, fraction: float | None) -> None:
        if stage != self._stage:
            # Else the time left would be that of the stage before, which is over.
            self._bar.reset(self._task)
            self._stage = stage
        if fraction is None:  # of which ``update`` would leave the total as it was
            self._bar.tasks[0].total = None
        self._bar.update(
            self._task,
            description=stage,
            total=None if fraction is None else 1.0,
            completed=fraction or 0.0,
        )

    def fraction_of(self, stage: str) -> Callable[[float], None]:
        """Takes how much of that stage is finished."""
        return partial(self.show, stage)

    def _tell(self) -> None:
        if self._on_terminal:
            if not self._ended.wait(1.0):
                self._bar.start()
            return
        while not self._ended.wait(LINE_EVERY_S):
            task = self._bar.tasks[0]
            share = "" if task.total is None else f" {task.percentage:.0f} %,"
            with suppress(OSError):  # nobody may read it any more
                told = f"omma: {self._stage or 'Working'}:{share} {times_of(task)}"
                print(told, file=sys.stderr, flush=True)

    def __enter__(self) -> DelayedBar:
        self._teller.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._teller.join()
        if self._on_terminal:
            self._bar.stop()


class _Share(ProgressColumn):
    def render(self, task: Task) -> Text:
        return Text("" if task.total is None else f"{task.percentage:>3.0f} %")


class _Times(ProgressColumn):
    def render(self, task: Task) -> Text:
        return Text(times_of(task))


def times_of(task: Task) -> str:
    """How long a stage has taken, and about how long it still takes where that is known."""
    elapsed = f"{_duration(task.elapsed or 0)} elapsed"
    left = None if task.total is None or task.finished else task.time_remaining
    return elapsed if left is None else f"{elapsed}, {_duration(left)} left"


def _duration(seconds: float) -> str:
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes:02} min"
    return f"{minutes} min {rest:02} s" if minutes else f"{rest} s"
