"""What ``--help`` of every command says, at the widths that terminals have."""

import re
import subprocess

import pytest
import typer

from omma.cli import main
from omma.cli.help import command_lines

WIDTHS = (60, 80, 100, 140)


def commands():
    """The words of every command, with the command."""

    def below(words, command):
        command = command.load() if isinstance(command, main.Later) else command
        yield words, command
        for name, one in getattr(command, "commands", {}).items():
            yield from below((*words, name), one)

    return list(below((), typer.main.get_command(main.app)))


EVERY = [pytest.param(*one, id=" ".join(one[0]) or "omma") for one in commands()]


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize(("words", "command"), EVERY)
def test_names_are_whole_and_switches_are_switches(run_omma, monkeypatch, words, command, width):
    monkeypatch.setenv("COLUMNS", str(width))
    code, out, err = run_omma(*words, "--help")
    assert (code, err) == (0, "")
    assert "…" not in out
    assert "bool" not in out.lower()
    assert not re.search(r"--\w[\w-]*-$", out, re.MULTILINE), "a name broken at its hyphen"
    assert not re.search(r"<(float|int|str|path|file)\b", out), "a type instead of a word"
    for parameter in command.params:
        for name in (*parameter.opts, *parameter.secondary_opts):
            if name.startswith("-") and not getattr(parameter, "hidden", False):
                assert re.search(rf"^ .*(?<![\w-]){name}(?![\w-])", out, re.MULTILINE), name
    for name, one in getattr(command, "commands", {}).items():
        assert f" {name} {one.short_help or one.help} " in f"{' '.join(out.split())} "


@pytest.mark.parametrize(("words", "command"), EVERY)
def test_every_help_has_an_example_to_copy(run_omma, monkeypatch, words, command):
    monkeypatch.setenv("COLUMNS", "80")
    _, out, _ = run_omma(*words, "--help")
    start = " ".join(("omma", *words))
    assert "Examples:" in out
    assert "`" not in out
    assert re.search(rf"^    {start} ", out, re.MULTILINE), start


def test_examples_are_the_same_command_for_a_shell():
    command = "omma render a.glb --eye b.csv --light 'clear_sky sun_elevation_deg=30' -o c.png"
    lines = command_lines(command, 40)
    assert max(map(len, lines)) <= 44
    assert len(lines) > 2
    said = subprocess.run(
        ["bash", "-c", "\n".join(["omma() { printf '%s\\n' \"$@\"; }", *lines])],
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    ).stdout.splitlines()
    assert said == [
        "render", "a.glb", "--eye", "b.csv", "--light", "clear_sky sun_elevation_deg=30",
        "-o", "c.png",
    ]  # fmt: skip


@pytest.mark.parametrize("words", [[], ["eye"]])
def test_a_group_alone_is_its_help(run_omma, words):
    code, out, err = run_omma(*words)
    assert (code, out) == (2, "")
    assert "\n\nCommands:\n  " in err


@pytest.mark.parametrize("words", [["render"], ["view"], ["dataset", "run"]])
def test_how_light_is_followed_is_said(run_omma, words):
    _, out, _ = run_omma(*words, "--help")
    text = " ".join(out.split())
    for part in ("lighting", "path", "baked", "~/.cache/omma", "OMMA_CACHE"):
        assert part in text
