"""Checks of arguments that several functions share."""

from __future__ import annotations

import difflib
import functools
import inspect
import operator
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from inspect import Parameter
from types import NoneType, SimpleNamespace, UnionType
from typing import Any, Literal, TypeVar, Union, cast, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from omma._core import Error, Eye
from omma.base.arrays import new_floats
from omma.base.card_arrays import OnCard, find_on_card
from omma.base.dlpack import as_numpy

F = TypeVar("F", bound=Callable[..., Any])


@contextmanager
def as_named(**names: str) -> Iterator[None]:
    """Errors inside are about an argument by the name that the caller's own function has for it."""
    try:
        yield
    except Error as error:
        message = str(error)
        for inside, here in names.items():
            message = re.sub(rf"(^|: ){inside}: ", rf"\1{here}: ", message, count=1)
            message = re.sub(rf"(?<![\w.]){inside}=", f"{here}=", message)
        raise Error(message) from None


def whole(value: Any, name: str, low: int, high: int) -> int:
    """``value`` as an int from ``low`` to ``high``; TypeError or omma.Error names the argument."""
    try:
        number = operator.index(value)
    except TypeError:
        number = None
    if number is None or isinstance(value, bool):
        raise TypeError(
            f"{name}: expected a whole number, found {type(value).__name__} {value!r:.40}"
        )
    if not low <= number <= high:
        raise Error(f"{name}: expected {low} to {high}, found {number}")
    return number


def one_of(value: Any, choices: Iterable[str], name: str, more: str = "") -> str:
    """``value`` where it is among the choices; omma.Error names them, and the one most like it.

    Args:
        more: what else is possible, put behind the choices.
    """
    known = list(choices)
    if isinstance(value, str) and value in known:
        return value
    longer = [one for one in known if isinstance(value, str) and one.startswith(f"{value}_")]
    alike = longer or difflib.get_close_matches(str(value), known, 1)
    hint = f"; did you mean {' or '.join(map(repr, alike))}?" if alike else ""
    raise Error(f"{name}: expected one of {', '.join(known)}{more}, found {value!r:.60}{hint}")


def positive(value: float, name: str) -> float:
    """``value`` where it is a finite number above 0; omma.Error names the argument."""
    if not (_is_number(value) and 0 < _as_float(value) < float("inf")):
        raise Error(f"{name}: expected a number above 0, found {value!r:.40}")
    return float(value)


def within(value: float, name: str, low: float, high: float) -> float:
    """``value`` where it is a number from ``low`` to ``high``; omma.Error names the argument."""
    if not (_is_number(value) and low <= _as_float(value) <= high):
        raise Error(f"{name}: expected {low:g} to {high:g}, found {value!r:.40}")
    return float(value)


def _as_float(value: Any) -> float:
    """A number in double precision, as limits beside NumPy's own become numbers of its type."""
    try:
        return float(value)
    except OverflowError:  # a whole number with hundreds of digits
        return float("inf") if value > 0 else -float("inf")


# Lengths of an array's axes: None or a name for any, ... first for any axes before the others.
Shape = tuple[Any, ...]


def array_of(
    value: Any,
    name: str,
    shape: Shape | list[Shape] | None = None,
    dtype: Any = np.float64,
    *,
    finite: bool = False,
) -> NDArray[Any]:
    """``value`` as an array of numbers, where it is one; the array itself where it fits already,
    and the memory of another library's array (`as_numpy`).

    Args:
        shape: that it must have, or a list of those that it may have. None: whatever it has.
        finite: whether all of its numbers must be.

    Raises:
        omma.Error: rows of different lengths, texts, complex numbers, objects, fractions or truths
            where ``dtype`` is whole, one truth for a number, another shape, numbers that are not
            finite; it names the argument.
    """
    try:
        given = np.asarray(as_numpy(value, name))
    except ValueError:
        raise Error(f"{name}: expected numbers, found rows of different lengths") from None
    if given.dtype.kind not in "biuf":
        raise Error(f"{name}: expected numbers, found {type(value).__name__} {value!r:.40}")
    are_whole = dtype is not None and np.dtype(dtype).kind in "iu"
    if given.dtype.kind == "b" and (given.ndim == 0 or are_whole):
        raise Error(f"{name}: expected numbers, found True or False: {value!r:.40}")
    if shape is not None:
        shapes = shape if isinstance(shape, list) else [shape]
        if not any(_fits(given.shape, one) for one in shapes):
            raise Error(f"{name}: expected {_shapes_text(shapes)}, found {given.shape}")
    # What is beyond the range of float32 becomes infinite; callers say whether that may be.
    with np.errstate(over="ignore", invalid="ignore"):
        array = np.asarray(given, dtype)
    if given.dtype.kind == "f" and array.dtype.kind in "iu" and np.any(array != given):
        raise Error(f"{name}: expected whole numbers, found {value!r:.40}")
    if finite and not np.isfinite(array).all():
        raise Error(f"{name}: expected finite numbers")
    return array


def _fits(found: tuple[int, ...], wanted: Shape) -> bool:
    if wanted[:1] == (...,):
        wanted = wanted[1:]
        found = found[max(0, len(found) - len(wanted)) :]
    fits = [isinstance(n, str | None) or n == length for n, length in zip(wanted, found)]
    return len(found) == len(wanted) and all(fits)


def _shapes_text(shapes: list[Shape]) -> str:
    words = {None: "N", ...: "..."}
    texts = []
    for one in shapes:
        lengths = ", ".join(str(words.get(length, length)) for length in one)
        texts.append(f"({lengths}{',' if len(one) == 1 else ''})" if one else "a number")
    return " or ".join(texts).replace("(", "shape (", 1)


def expect(value: object, kind: type, name: str, hint: str) -> None:
    """TypeError where ``value`` is no ``kind``; ``hint`` says where to get one."""
    if not isinstance(value, kind):
        found = type(value).__name__
        known = "a dictionary" if kind is Mapping else _OWN.get(kind.__name__)
        full_name = known or f"omma.{kind.__name__}"
        instead = or_its_eye(value, full_name, hint)
        raise TypeError(f"{name}: expected {full_name}, found {found} ({instead})")


def or_its_eye(value: object, expected: str, hint: str = "") -> str:
    """Where an eye is expected and an animal given, which has one, that; else the hint."""
    has_one = "omma.Eye" in expected and isinstance(getattr(value, "eye", None), Eye)
    return "its .eye is one" if has_one else hint


_NOT_WRITTEN = "expected an array that can be written to, found one that is read-only"


def output_array(out: Any, shape: tuple[int, ...], name: str) -> NDArray[np.float32] | OnCard:
    """``out`` where the engine can write to it, as NumPy's or on a card; a new array where it is
    None."""
    if out is None:
        return new_floats(shape)
    on_card = find_on_card(out, name)
    if on_card is not None:
        if on_card.dtype != np.float32:
            raise TypeError(
                f"{name}: expected a float32 array of shape {shape}, found {on_card.dtype} array"
            )
        if on_card.shape != shape:
            raise Error(f"{name}: expected shape {shape}, found {on_card.shape}")
        if not on_card.writable:
            raise Error(f"{name}: {_NOT_WRITTEN}")
        return on_card
    never = type(out).__module__.startswith("jax")
    out = as_numpy(out, name)
    if not isinstance(out, np.ndarray) or out.dtype != np.float32:
        found = f"{out.dtype} array" if isinstance(out, np.ndarray) else type(out).__name__
        raise TypeError(f"{name}: expected a float32 array of shape {shape}, found {found}")
    if out.shape != shape:
        raise Error(f"{name}: expected shape {shape}, found {out.shape}")
    if not out.flags.writeable:
        why = ", as arrays of JAX always are" if never else ""
        raise Error(f"{name}: {_NOT_WRITTEN}{why}")
    if not out.flags.c_contiguous:
        raise Error(f"{name}: expected a C-contiguous array, found strides of {out.strides} bytes")
    if not out.flags.aligned:
        raise Error(f"{name}: expected an array whose numbers lie at multiples of 4 bytes")
    return out


def arrays_of(**values: Any) -> list[NDArray[np.float64]]:
    """Each as `array_of` reads it, broadcast; omma.Error names them where they do not fit."""
    arrays = [array_of(value, name) for name, value in values.items()]
    try:
        return list(np.broadcast_arrays(*arrays))
    except ValueError:
        found = ", ".join(str(array.shape) for array in arrays)
        names = ", ".join(values)
        raise Error(f"{names}: expected shapes that go together, found {found}") from None


# Omma's own types that `checked` knows, and what messages call them.
_OWN = {
    "AcuteZone": "omma.eye.AcuteZone",
    "Background": "omma.Background",
    "Bake": "omma.scene.Bake",
    "Bands": "omma.light.Bands",
    "Camera": "omma.scene.Camera",
    "CaptureCameras": "omma.scene.CaptureCameras",
    "Columns": "omma.columns.Columns",
    "SplatCloud": "omma.scene.SplatCloud",
    "CloudShadow": "omma.light.CloudShadow",
    "Disc": "omma.light.Disc",
    "DiscTarget": "omma.colour_vision.DiscTarget",
    "DetectorState": "omma.motion.DetectorState",
    "EventState": "omma.photoreceptors.EventState",
    "Eye": "omma.Eye",
    "EyeMeasures": "omma.eye.EyeMeasures",
    "GroundTruth": "omma.rendering.GroundTruth",
    "HeadPose": "omma.view.HeadPose",
    "ImpulseResponse": "omma.photoreceptors.ImpulseResponse",
    "Job": "omma.datasets.Job",
    "Light": "omma.light.Light",
    "Loop": "omma.gym.Loop",
    "Method": "omma.study.Method",
    "MinimumSamples": "omma.study.MinimumSamples",
    "Observer": "omma.colour_vision.Observer",
    "OmmatidiumType": "omma.receptors.OmmatidiumType",
    "PointCloud": "omma.scene.PointCloud",
    "ReceptorType": "omma.receptors.ReceptorType",
    "Renderer": "omma.Renderer",
    "Scene": "omma.Scene",
    "SceneTarget": "omma.colour_vision.SceneTarget",
    "SpeedTest": "omma.study.SpeedTest",
    "Species": "omma.species.Species",
    "Spectrum": "omma.light.Spectrum",
    "Surface": "a surface as of omma.eye.surfaces.ellipsoid",
    "Views": "omma.datasets.Views",
    "Wiring": "omma.eye.superposition.Wiring",
    "World": "omma.World",
}


def _is_number(value: Any) -> bool:
    """Whether it is one real number, of whatever kind; not an array of one, and not a truth."""
    return (
        hasattr(value, "__float__")
        and np.ndim(value) == 0
        and np.asarray(value).dtype.kind in "iufO"
    )


# Other types: whether a value is one, and what messages call it.
_Kind = tuple[Callable[[Any], bool], str]
_PLAIN: dict[Any, _Kind] = {
    NoneType: (lambda value: value is None, "None"),
    bool: (lambda value: isinstance(value, (bool, np.bool_)), "True or False"),
    int: (lambda value: _is_number(value) and hasattr(value, "__index__"), "a whole number"),
    float: (_is_number, "a number"),
    str: (lambda value: isinstance(value, str), "a text"),
    os.PathLike[str]: (lambda value: isinstance(value, (str, bytes, os.PathLike)), "a path"),
}


def _own(hint: Any) -> str | None:
    """What messages call a type, where it is one of Omma's own."""
    is_own = isinstance(hint, type) and hint.__module__.startswith("omma.")
    return _OWN.get(hint.__name__) if is_own else None


def _kinds(hint: Any) -> list[_Kind] | None:
    """The check for each alternative of a type, and its name in messages; None: not checked."""
    alternatives = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    if os.PathLike[str] in alternatives:  # of which a text is one
        alternatives = tuple(one for one in alternatives if one is not str)
    kinds = [_kind(one) for one in alternatives]
    return None if None in kinds else [kind for kind in kinds if kind is not None]


def _kind(hint: Any) -> _Kind | None:
    origin, items = get_origin(hint), get_args(hint)
    if origin is Literal:  # which of them it is, the function itself sees
        return _PLAIN[str][0], f"one of {', '.join(items)}"
    if origin is Callable:
        return callable, "a function"
    if origin is Sequence and (name := _own(items[0])):
        return partial(_is_sequence_of, items[0]), f"a sequence of {name}"
    if origin is Mapping and items[0] is str and (name := _own(items[1])):
        return partial(_is_mapping_to, items[1]), f"a mapping of names to {name}"
    if name := _own(hint):
        return (lambda value: isinstance(value, hint)), name
    return _PLAIN.get(hint)


def _is_sequence_of(kind: type, value: Any) -> bool:
    return isinstance(value, Sequence) and all(isinstance(one, kind) for one in value)


def _is_mapping_to(kind: type, value: Any) -> bool:
    return isinstance(value, Mapping) and all(isinstance(one, kind) for one in value.values())


def _checks_of(
    function: Callable[..., Any], signature: inspect.Signature
) -> dict[str, list[_Kind]]:
    """What each argument may be, where that can be told from its type."""
    several = (Parameter.VAR_POSITIONAL, Parameter.VAR_KEYWORD)
    # Without what is returned, which may be of a package that is not installed.
    typed = {
        name: function.__annotations__[name]
        for name, one in signature.parameters.items()
        if one.annotation is not Parameter.empty
        and one.kind not in several
        and name in function.__annotations__
    }
    # Names of annotations are those of where the function itself was written.
    names = inspect.unwrap(function).__globals__
    hints = get_type_hints(SimpleNamespace(__annotations__=typed), names)
    found = {name: _kinds(hint) for name, hint in hints.items()}
    known = {name: kinds for name, kinds in found.items() if kinds is not None}
    # Eyes and scenes are checked first, as a wrong one says most about the mistake.
    first = sorted(known, key=lambda name: not any("omma." in text for _, text in known[name]))
    return {name: known[name] for name in first}


def _too_many(signature: inspect.Signature, arguments: Sequence[Any]) -> str:
    """What a call with more positional arguments than there are is told; "" of other calls."""
    parameters = signature.parameters.values()
    if any(one.kind is Parameter.VAR_POSITIONAL for one in parameters):
        return ""
    by_place = (Parameter.POSITIONAL_ONLY, Parameter.POSITIONAL_OR_KEYWORD)
    placed = [one.name for one in parameters if one.kind in by_place]
    more = len(arguments) - len(placed)
    if more <= 0:
        return ""
    own = [name for name in placed if name != "self"]  # of a method, which Python gives itself
    count = f"{len(own) or 'no'} positional argument{'' if len(own) == 1 else 's'}"
    at_most = "at most " if own else ""
    listed = f" ({', '.join(own)})" if own else ""
    named = [one.name for one in parameters if one.kind is Parameter.KEYWORD_ONLY]
    rest = f"; by keyword: {', '.join(named)}" if named else ""
    return f"expected {at_most}{count}{listed}, found {len(own) + more}{rest}"


def _unknown(signature: inspect.Signature, named: Mapping[str, Any]) -> tuple[str, str]:
    """The first name that a function does not know, and a hint at what was meant; "" where it knows
    all."""
    parameters = signature.parameters
    if any(one.kind is Parameter.VAR_KEYWORD for one in parameters.values()):
        return "", ""
    unknown = next((name for name in named if name not in parameters), "")
    longer = [name for name in parameters if unknown and name.startswith(f"{unknown}_")]
    alike = difflib.get_close_matches(unknown, parameters, 1) or longer
    return unknown, f"; did you mean {' or '.join(map(repr, alike))}?" if alike else ""


def checked(function: F) -> F:
    """The same function, which says by name where an argument is to be an eye, a number, a function
    or another thing that its annotation tells, and is something else: a TypeError.

    For the package's front door; inside, functions trust what was checked.
    """
    signature = inspect.signature(function)

    @functools.cache
    def known() -> dict[str, list[_Kind]]:
        # When it is first called, as by then all that annotations name is there.
        return _checks_of(function, signature)

    @functools.wraps(function)
    def edge(*arguments: Any, **named: Any) -> Any:
        try:
            given = signature.bind(*arguments, **named).arguments
        except TypeError as error:  # which does not say of what, and first of what is missing
            unknown, hint = _unknown(signature, named)
            method = f"{function.__name__}_{unknown}"  # as render_stokes
            if unknown and arguments and hasattr(arguments[0], method):
                hint = f"; did you mean the method {method}?"
            said = f"got an unexpected keyword argument {unknown!r}" if unknown else str(error)
            said = _too_many(signature, arguments) or said
            raise TypeError(f"{function.__qualname__}: {said}{hint}") from None
        for name, kinds in known().items():
            if name in given and not any(fits(given[name]) for fits, _ in kinds):
                value = given[name]
                expected = " or ".join(text for _, text in kinds if text != "None")
                found = f"{type(value).__name__} {value!r:.40}"
                if hint := or_its_eye(value, expected):
                    found += f" ({hint})"
                raise TypeError(f"{name}: expected {expected}, found {found}")
        return function(*arguments, **named)

    return cast(F, edge)
