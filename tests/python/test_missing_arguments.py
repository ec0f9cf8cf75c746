"""Arguments that are missing, or too many: calls say which in plain words."""

import re

import numpy as np
import pytest
from public_names import public_things

import omma

ONE = [[0.0, 0.0, -1.0]]
TRIANGLE = [[0, 1, 2]]
NUMBERS = "expected numbers of shape"


def said_without_arguments(kind):
    try:
        kind()
    except (omma.Error, TypeError) as error:
        return str(error)
    return ""


def test_constructors_without_arguments():
    kinds = {thing for _, _, thing in public_things() if isinstance(thing, type)}
    assert omma.Eye in kinds
    said = {kind.__name__: said_without_arguments(kind) for kind in kinds}
    assert [name for name, text in said.items() if "incompatible function arg" in text] == []


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: omma.Eye(axis=ONE, acceptance_angle_rad=0.1), rf"^position_m: {NUMBERS} \(1, 3\)"),
        (lambda: omma.Eye(None, ONE, 0.1), rf"^position_m: {NUMBERS} \(1, 3\), in .*, found None"),
        (lambda: omma.Eye(ONE, acceptance_angle_rad=0.1), rf"^axis: {NUMBERS} \(N, 3\), found Non"),
        (lambda: omma.light.Spectrum([300, 400]), rf"^value: {NUMBERS} \(N,\), found None$"),
        (lambda: omma.receptors.ReceptorType(), r"^name: expected a text, found NoneType$"),
        (lambda: omma.scene.BoundaryTable([300, 400]), r"^mueller: .* found None$"),
        (lambda: omma.scene.ExtraReflectance(spectra=[]), r"^texture: expected the index of a tex"),
        (lambda: omma.scene.ExtraReflectance(0), r"^spectra: expected up to three .*NoneType$"),
        (lambda: omma.scene.HitBox("a", triangles=TRIANGLE), rf"^positions_m: {NUMBERS}"),
        (lambda: omma.scene.Image(), r"^pixels: expected a path or pixels, found None$"),
        (lambda: omma.scene.Instance(), r"^mesh: expected a whole number, found NoneType$"),
        (lambda: omma.scene.Mesh(triangles=TRIANGLE), rf"^positions_m: {NUMBERS}"),
        (lambda: omma.scene.Mesh(ONE), r"^triangles: expected whole numbers .*, found None$"),
        (lambda: omma.scene.SplatCloud(ONE), rf"^scales_m: {NUMBERS} \(N, 3\), found None$"),
        (lambda: omma.scene.Texture(), r"^image: expected a whole number"),
        (lambda: omma.scene.TextureUse(), r"^texture: expected a whole number"),
    ],
)
def test_what_is_missing_is_named(make, says):
    with pytest.raises((omma.Error, TypeError)) as caught:
        make()
    assert re.search(says, str(caught.value))


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (
            lambda: omma.eye.set_acceptance(omma.eye.generate_eye(20), 0.03),
            r"^set_acceptance: expected at most 1 positional argument \(eye\), found 2; "
            r"by keyword: angle_rad, factor, ratio, ",
        ),
        (
            lambda: omma.rendering.see_panorama(np.ones((2, 4, 3)), omma.Eye(ONE, ONE, 1), None, 3),
            r"^see_panorama: expected at most 3 positional arguments \(picture, eye, "
            r"world_from_head\), found 4; by keyword: layout$",
        ),
        (
            lambda: omma.World(omma.Scene()).with_light(None, "path"),
            r"^World\.with_light: expected at most 1 positional argument \(light\), found 2; by ",
        ),
        (
            lambda: omma.eye.split_eye(omma.eye.generate_eye(20), 0, 0, 1),
            r"^split_eye: expected at most 3 positional arguments \(eye, shift_m, overlap_m\), "
            r"found 4$",
        ),
    ],
)
def test_of_too_many_the_names_are_told(call, says):
    with pytest.raises(TypeError) as caught:
        call()
    assert re.search(says, str(caught.value))


@pytest.mark.parametrize(
    ("named", "says"),
    [
        ({"eye": 1, "unti": "mm"}, "'unti'; did you mean 'unit'"),
        ({"columns_of_it": 1}, "'columns_of_it'"),
    ],
)
def test_what_is_unknown_is_told_before_what_is_missing(named, says):
    with pytest.raises(TypeError, match=f"^save_eye: got an unexpected keyword argument {says}"):
        omma.save_eye(**named)


def test_the_beginning_of_a_name_is_told_the_whole():
    with pytest.raises(TypeError) as caught:
        omma.light.clear_sky(sun=30)
    names = ("sun_elevation_deg", "sun_azimuth_deg")
    assert all(f"{name!r}" in str(caught.value) for name in names)
    assert "unexpected keyword argument 'sun'" in str(caught.value)
