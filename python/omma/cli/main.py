"""The command ``omma``: its commands, and what an error, a signal and an exit code are to it."""

from __future__ import annotations

import importlib
import os
import re
import sys
import warnings
from collections.abc import Callable, Sequence
from typing import Annotated, Any

import typer
import typer.core

from omma._core import Error, __version__
from omma.cli.help import App, Group
from omma.cli.typed import as_typed
from omma.cli.working import fail, interrupted, open_missing_streams, unwinding_on_signals

OMMA_HELP = """
What an animal with compound eyes sees: from a scene and an eye to responses.

**Examples**

`omma info meadow.glb`

`omma render meadow.glb --eye honeybee.eye -o view.png`

Each command says more with --help, such as `omma render --help`.
"""

# The module of each command, its app there, and what the list of commands says of it.
_COMMANDS = {
    "render": ("render", "render_app", "Render what an eye or a camera sees in a scene."),
    "render-again": ("render_again", "again_app", "Render again what an earlier render wrote."),
    "render-cameras": ("render_cameras", "cameras_app", "Render every camera of a scene."),
    "info": ("info", "info_app", "Say what is in a scene, an eye or responses."),
    "eye": ("eye", "eye_app", "Make, change, convert, check and draw eyes."),
    "view": ("view", "view_app", "Show what an eye sees in a browser, live."),
    "dataset": ("dataset", "dataset_app", "Make data sets of views for models, and read them."),
    "light": ("light", "light_app", "Draw skies: radiance, polarisation, spectrum."),
    "measure": (
        "measure",
        "measure_app",
        "Measure scatter and speed: rays needed, variance maps, aliasing, frames/s.",
    ),
}


class Later(typer.core.TyperCommand):
    """A command whose module is imported when it is used, so that ``omma --help`` is quick."""

    def __init__(self, name: str, module: str, app_name: str, text: str) -> None:
        super().__init__(name, help=text)
        self._module, self._app_name = module, app_name

    def load(self) -> Any:
        """The command itself."""
        module = importlib.import_module(f"omma.cli.{self._module}")
        command = typer.main.get_command(getattr(module, self._app_name))
        command.name = self.name
        return command

    def make_context(self, *arguments: Any, **named: Any) -> Any:
        """Of the command itself, which then runs."""
        return self.load().make_context(*arguments, **named)


class _Commands(Group):
    """All commands of ``omma``."""

    def __init__(self, **attributes: Any) -> None:
        super().__init__(**attributes)
        for name, where in _COMMANDS.items():
            self.add_command(Later(name, *where))


app = App(
    name="omma",
    cls=_Commands,
    help=OMMA_HELP,
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"omma {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool,
        typer.Option(
            "--version", help="Print the version.", callback=_print_version, is_eager=True
        ),
    ] = False,
) -> None:
    pass


def main() -> None:
    """Run the command line: exit code 0, 1 for an error, 2 for wrong usage, 130 for Ctrl-C, 143 and
    129 for SIGTERM and SIGHUP (SIGBREAK on Windows, 149)."""
    warnings.formatwarning = _warning_line
    open_missing_streams()
    with unwinding_on_signals():
        code = run(app)
    sys.exit(code)


def run(command: Callable[..., object]) -> int:
    """Run a typer app; every error becomes one line on stderr and an exit code."""
    try:
        code = command(standalone_mode=False)
        sys.stdout.flush()
        return code if isinstance(code, int) else 0
    except Error as error:
        return fail(as_typed(str(error), _options_of(sys.argv[1:])), 1)
    except KeyboardInterrupt as error:
        return interrupted(error)
    except MemoryError:
        return fail("not enough memory", 1)
    except BrokenPipeError:
        # Whoever read the output has enough. What is still buffered has nowhere to go.
        sys.stdout = None
        return 1
    except OSError as error:
        try:
            sys.stdout.flush()
        except OSError:
            sys.stdout = None  # or Python fails once more on its way out, with an exit code of 120
        return fail(f"{error.filename or 'system'}: {error.strerror}", 1)
    except Exception as error:
        # What typer says about wrong usage; its class has moved between typer's versions.
        message = getattr(error, "format_message", None)
        code = getattr(error, "exit_code", None)
        if type(error).__name__ == "NoArgsIsHelpError" and message is not None:
            print(message(), file=sys.stderr)
            return 2
        if message is not None and isinstance(code, int):
            return fail(_usage(error, message()), code) if message() else code
        if type(error).__name__ == "Abort":
            return interrupted(KeyboardInterrupt())
        raise


# What somebody may type behind a switch.
_SWITCHED = re.compile(
    r"unexpected extra argument.*\((true|false|yes|no|on|off|1|0)\b", re.IGNORECASE
)


def _options_of(arguments: Sequence[str]) -> set[str]:
    """The options of the command that was typed."""
    command: Any = typer.main.get_command(app)
    for word in arguments:
        command = getattr(command, "commands", {}).get(word, command)
        command = command.load() if isinstance(command, Later) else command
    return {text for parameter in command.params for text in parameter.opts}


def _usage(error: Exception, message: str) -> str:
    """What typer says, in words where several numbers are expected: it names a parser's trouble."""
    parameter: Any = getattr(error, "param", None)
    if getattr(error, "option_name", None) is not None:  # of one that the command does not have
        files = [f"./{word}" for word in sys.argv[1:] if word[:1] == "-" and os.path.isfile(word)]
        return f"{message}; for the file of that name: {files[0]}" if files else message
    if _SWITCHED.search(message):
        return f"{message}; switches take no word behind them, as --standard-error and --no-browser"
    if parameter is None:
        return message
    if parameter.nargs < 2 or "number" not in message:
        number = _not_a_number(error)
        return message if number is None else f"{_name_of(parameter)}: {number}"
    metavar = parameter.metavar or "numbers"
    return f"{parameter.opts[0]}: expected {parameter.nargs} numbers, {metavar}"


def _not_a_number(error: Exception) -> str | None:
    """What was expected and found, where a newer typer could not read a number; None of others."""
    details = getattr(error.__cause__, "errors", None)  # of pydantic
    first: dict[str, Any] = next(iter(details()), {}) if callable(details) else {}
    kinds = {"int_parsing": "a whole number", "int_from_float": "a whole number"}
    expected = (kinds | {"float_parsing": "a number"}).get(str(first.get("type")))
    return None if expected is None else f"expected {expected}, found {first.get('input')!r:.60}"


def _name_of(parameter: Any) -> str:
    """An option's name, or what help calls an argument."""
    is_option = parameter.opts[0].startswith("-")
    return str(parameter.opts[-1] if is_option else parameter.metavar or parameter.name)


def _warning_line(message: Warning | str, *_: object, **__: object) -> str:
    return f"omma: warning: {message}\n"
