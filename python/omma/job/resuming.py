"""Renders of a path that go on where they were cut off: what is kept of them, and of what inputs.

Beside an output NAME stands NAME.partial, which has what is rendered so far, and beside the first
one NAME.resume, which says how far that is and what it was made from.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from omma import _core
from omma._core import Error
from omma.base.backend_names import backend_record, without_ordinals
from omma.base.files import PathLike, WholeFiles, digests_of, write_whole
from omma.base.said import is_number
from omma.rendering.report import SpentRays
from omma.rendering.settings import Settings, settings_as_record


class KeptRender:
    """How far a render is that was asked to go on, and what its files have of it."""

    def __init__(self, names: Sequence[str], made_from: Mapping[str, Any]) -> None:
        self.names = names
        self.record = names[0] + ".resume"
        self.made_from = json.loads(json.dumps(made_from))  # as it is read back
        self.done = 0
        """Poses that are rendered and written."""
        self.saved = 0
        """The same, with those that this run has added."""
        self.seconds = 0.0
        """Spent on rendering them."""
        self.bytes: dict[str, int] = {}
        """Of each file, those that are of these poses."""
        self.spent: SpentRays | None = None
        if os.path.lexists(self.record):
            self._read()

    def save(self, files: WholeFiles, spent: SpentRays | None, done: int, seconds: float) -> None:
        """Bring all to the disk that is rendered so far, then say so; ``seconds`` are since it went
        on."""
        said = {
            "made_from": self.made_from,
            "done": done,
            "seconds": self.seconds + seconds,
            "bytes": files.sync(),
            "spent": None if spent is None else asdict(spent),
        }
        write_whole(self.record, json.dumps(said, indent=1).encode())
        self.saved = done

    @contextmanager
    def telling(self, poses: int) -> Iterator[None]:
        """Errors say how many of the poses are kept, and so does Ctrl-C."""
        try:
            yield
        except KeyboardInterrupt as error:
            # As add_note, which Python has from 3.11 on.
            error.__notes__ = [  # type: ignore[attr-defined]
                f"{self.saved:,} of {poses:,} poses are kept; the same command goes on"
            ]
            raise
        except Error as error:
            raise Error(
                f"{error}. {self.saved:,} of {poses:,} poses are kept; mend that and run the same "
                "command again"
            ) from None

    def remove(self) -> None:
        """All files are whole and have their names."""
        Path(self.record).unlink(missing_ok=True)

    def _read(self) -> None:
        try:
            said = json.loads(_core.read_file(self.record))
            made_from, done = said["made_from"], int(said["done"])
            kept = {name: int(size) for name, size in dict(said["bytes"]).items()}
            seconds = float(said["seconds"])
            spent = None if said["spent"] is None else SpentRays(**said["spent"])
            if done < 0 or min(kept.values(), default=0) < 0 or not math.isfinite(seconds):
                raise ValueError
            if spent is not None:
                numbers = asdict(spent)
                missed = [one for pair in numbers.pop("first_missed") for one in (*pair, len(pair))]
                if not all(map(is_number, [*numbers.values(), *missed])):
                    raise ValueError
        except (ValueError, TypeError, KeyError, OverflowError, RecursionError):
            raise Error(
                f"{self.record}: is no record of a render that was cut off; remove it to begin anew"
            ) from None
        other = list(_differences(made_from, self.made_from))
        if other:
            raise Error(
                f"{self.record}: what is rendered so far was made from other inputs: "
                f"{'; '.join(other)}. Remove it to begin anew"
            )
        if all(_core.kept_bytes(name) >= size for name, size in kept.items()):
            self.done = self.saved = done
            self.bytes, self.seconds, self.spent = kept, seconds, spent


def inputs_of(
    settings: Settings,
    others: Mapping[str, Any],
    files: Iterable[PathLike],
    names: Sequence[str],
    backend: str,
) -> dict[str, Any]:
    """What responses are made from, as text and numbers: settings, other arguments, and what is in
    the files.

    Raises:
        omma.Error: an argument cannot be told again.
    """
    if isinstance(others["background"], _core.Background):
        raise Error("resume: expected a background as text, which can be compared, found an object")
    return {
        "omma": _core.__version__,
        **backend_record(without_ordinals(backend)),
        "outputs": list(names),
        **settings_as_record(settings),
        "seed": str(settings.seed),  # as always, so that what older versions began goes on
        **{name: np.asarray(value).tolist() for name, value in others.items()},
        "files": {name: digest for path in files for name, digest in digests_of(path).items()},
    }


def _differences(then: Any, now: Mapping[str, Any]) -> Iterable[str]:
    then = then if isinstance(then, dict) else {}
    for name in [*now, *(name for name in then if name not in now)]:
        if name == "files":
            before, after = then.get(name, {}), now[name]
            before = before if isinstance(before, dict) else {}
            for file in [*after, *(file for file in before if file not in after)]:
                if before.get(file) != after.get(file):
                    yield f"{file} has changed"
        elif name == "instruction_set" and name not in then:
            continue  # older versions did not tell it
        elif then.get(name) != now.get(name):
            yield f"{name} was {then.get(name)!r}, is {now.get(name)!r}"
