"""Examples in the docstrings of everything public run and give what they say."""

import doctest
import inspect

import numpy as np
import pytest
from public_names import public_things

import omma


def examples():
    """Everything public that has an example, by its full name; methods of classes too."""
    found = {}
    for subpackage, name, thing in public_things():
        full = f"{subpackage}.{name}".strip(".")
        members = vars(thing).items() if inspect.isclass(thing) else ()
        for called, one in [(full, thing), *((f"{full}.{key}", value) for key, value in members)]:
            text = getattr(one, "__doc__", None) or ""
            if ">>>" in text:
                found[called] = text
    return found


def test_there_are_examples():
    assert len(examples()) >= 15


@pytest.mark.parametrize("name", examples())
def test_examples_are_true(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # some write files
    names = {"omma": omma, "np": np}
    test = doctest.DocTestParser().get_doctest(examples()[name], names, name, None, 0)
    said = []
    result = doctest.DocTestRunner(verbose=False).run(test, out=said.append)
    assert result.attempted > 0
    assert result.failed == 0, "".join(said)
