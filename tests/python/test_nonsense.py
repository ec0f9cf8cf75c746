"""Nonsense where an eye, a scene or another thing of Omma's is expected is named at the door."""

import functools
import inspect
import pickle

import numpy as np
import pytest
from public_names import public_things

import omma

OWN = {
    "Camera", "Eye", "EyeMeasures", "Method", "Renderer", "Scene", "SpeedTest", "Species", "Wiring",
}  # fmt: skip

NONSENSE = [
    -1, True, float("nan"), 1e300, 2**63, 1j, "", "x", "a\udce4", b"x", [], [[]], [1, [2, 3]], {},
    {1}, object(), int, omma.Eye, lambda: None, np.empty((0, 3)), np.full((3, 3), np.nan),
    np.zeros(3, complex), np.array([None, 1, "x"]), np.datetime64("2020-01-01"),
]  # fmt: skip


def calls():
    """Functions of the package, and a parameter that is to be one of ``OWN``."""
    for _, _, function in public_things():
        if inspect.isfunction(function):
            for parameter in inspect.signature(function).parameters.values():
                words = set(str(parameter.annotation).split(" | "))
                if words & OWN and words <= OWN | {"None"}:
                    yield function, parameter.name


def test_there_are_many():
    assert len(list(calls())) > 50


@pytest.mark.parametrize(("function", "parameter"), list(calls()))
def test_it_is_named(function, parameter):
    needed = [
        other.name
        for other in inspect.signature(function).parameters.values()
        if other.default is other.empty
    ]
    owned = {name for called, name in calls() if called is function} | set(needed)
    for value in NONSENSE:
        arguments = dict.fromkeys(needed, value) | {parameter: value}
        with pytest.raises(TypeError) as caught:
            function(**arguments)
        assert str(caught.value).split(":")[0] in owned
        assert "expected omma." in str(caught.value)


def test_types_are_called_as_users_find_them():
    from omma.base.arguments import _OWN

    for name, full in _OWN.items():
        if name != "Surface":  # a protocol, which is not public
            assert functools.reduce(getattr, full.split(".")[1:], omma).__name__ == name


@pytest.mark.parametrize(
    "call", [lambda fly: omma.Renderer(omma.Scene(), fly), omma.eye.measure_eye]
)
def test_an_animal_is_told_of_its_eye(call):
    with pytest.raises(TypeError, match=r"eye: expected omma\.Eye.* Species.*its \.eye is one"):
        call(omma.species.drosophila())


@pytest.mark.parametrize("value", [3, None, b"photons", ["photons"]])
def test_choices_are_named(value):
    with pytest.raises(TypeError, match="unit: expected one of photons, watts, found"):
        omma.light.uniform_sky(1.0, unit=value)
    with pytest.raises(TypeError, match="sun: expected one of exact, map, found"):
        omma.World(omma.scene.plane((1, 1)), sun=value)


def test_functions_are_what_they_were(tmp_path, eye):
    assert omma.eye.measure_eye.__doc__ == omma.eye.measure_eye.__wrapped__.__doc__
    assert pickle.loads(pickle.dumps(omma.eye.measure_eye)) is omma.eye.measure_eye
    with pytest.raises(TypeError, match="missing a required argument"):
        omma.save_eye(tmp_path / "a.eye")
    with pytest.raises(TypeError, match="unexpected keyword argument 'units'; did you mean 'unit'"):
        omma.save_eye(tmp_path / "a.eye", eye, units="mm")


@pytest.mark.parametrize("what", ["stokes", "receptors", "rays"])
def test_what_has_a_method_of_its_own_is_told(eye, what):
    with pytest.raises(TypeError, match=f"'{what}'; did you mean the method render_{what}"):
        omma.Renderer(omma.Scene(), eye).render(np.eye(4), **{what: True})
