"""Arrays on a graphics card, in and out, by the tests' stand-in for one: tensors of libraries that
speak ``__cuda_array_interface__``, and Omma's own."""

import inspect
from pathlib import Path

import card_programs
import numpy as np
import pytest
from test_devices import run, with_stand_in

import omma

PROGRAMS = [
    name
    for name, one in inspect.getmembers(card_programs, inspect.isfunction)
    if one.__module__ == "card_programs" and name not in ("driver", "scene", "renderer")
]


@with_stand_in
@pytest.mark.parametrize("name", PROGRAMS)
def test_on_the_card(name, tmp_path):
    program = f"import card_programs; card_programs.{name}()"
    done = run("-W", "error", "-c", program, cache=tmp_path, cards=2, cwd=Path(__file__).parent)
    assert done.returncode == 0, done.stderr


def test_without_a_card_there_is_no_array_on_it():
    program = "import omma; omma.rendering.CardArray((2, 3))"
    done = run("-c", program, card=False)
    assert "omma.Error: cuda: expected NVIDIA's driver, found none" in done.stderr


def test_a_length_is_no_shape():
    with pytest.raises(TypeError, match=r"shape: expected lengths of axes, .* found int 5"):
        omma.rendering.CardArray(5)


def test_what_has_no_such_interface_is_no_array_on_a_card(renderer):
    class Odd:
        __cuda_array_interface__ = None

    with pytest.raises((omma.Error, TypeError), match="out: expected a float32 array"):
        renderer.render(np.eye(4), out=Odd())
