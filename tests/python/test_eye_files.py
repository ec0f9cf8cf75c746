"""Eyes in files: all survives CSV and OCES to the last bit; .eye files say what they lose."""

import numpy as np
import pytest
from conftest import DATA
from hypothesis import given, settings
from hypothesis import strategies as st

import omma
from omma import Acceptance
from omma.receptors import ReceptorType

EYES = DATA / "compound-ray" / "bees"
needs_bees = pytest.mark.skipif(not EYES.is_dir(), reason=f"there is no {EYES}")
ARRAYS = (
    "position_m",
    "axis",
    "acceptance_angle_rad",
    "focal_offset_m",
    "eye_id",
    "up",
    "facet_diameter_m",
    "aperture_diameter_m",
    "first_receptor",
    "receptor_type",
)


def assert_same(a, b):
    """Every number, text and order."""
    assert len(a) == len(b)
    for name in ARRAYS:
        one, other = getattr(a, name), getattr(b, name)
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other, name)
    assert a.receptor_types == b.receptor_types
    assert [values_of(a.acceptance(i)) for i in range(len(a))] == [
        values_of(b.acceptance(i)) for i in range(len(b))
    ]
    assert (np.asarray(a.acceptance_of) >= 0).tolist() == (
        np.asarray(b.acceptance_of) >= 0
    ).tolist()
    assert list(a.columns) == list(b.columns)
    for name, values in a.columns.items():
        if isinstance(values, list):
            assert values == b.columns[name], name
        else:
            np.testing.assert_array_equal(values, b.columns[name], name)


def values_of(acceptance):
    """All parameters of an acceptance, with the numbers of a table as lists."""
    names = [
        name
        for name in dir(type(acceptance))
        if isinstance(getattr(type(acceptance), name), property)
    ]
    values = [getattr(acceptance, name) for name in names]
    return [v.tolist() if isinstance(v, np.ndarray) else v for v in values]


def numbers(low, high, **kwargs):
    return st.floats(low, high, allow_nan=False, allow_infinity=False, **kwargs)


def float32s(low, high):
    return numbers(float(np.float32(low)), float(np.float32(high)), width=32)


lengths = st.one_of(st.just(0.0), float32s(2**-30, 1.0))
tables = st.lists(numbers(0.001, 0.2), min_size=1, max_size=5).flatmap(
    lambda steps: st.lists(numbers(0, 1), min_size=len(steps), max_size=len(steps)).map(
        lambda values: Acceptance.table(
            np.concatenate([[0.0], np.cumsum(steps)]), np.array([1.0, *values[:-1], 0.0])
        )
    )
)
acceptances = st.one_of(
    st.builds(
        lambda width, ratio, angle: Acceptance.gaussian(
            width, width * ratio, angle, allow_unusual=True
        ),
        numbers(0.001, 1),
        numbers(0.2, 1),
        numbers(-3, 3),
    ),
    st.builds(Acceptance.pillbox, numbers(0.001, 1)),
    st.builds(Acceptance.compoundray, numbers(0.001, 1)),
    st.builds(Acceptance.airy, numbers(1e-5, 1e-4), numbers(300, 700)),
    st.builds(
        Acceptance.lens_rhabdom,
        numbers(1e-5, 4e-5),
        numbers(2e-5, 1e-4),
        numbers(1e-6, 3e-6),
        numbers(300, 700),
        model=st.sampled_from(["waveguide", "geometric", "snyder"]),
    ),
    tables,
)
texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=6) | st.sampled_from(
    ["", " a", "b ", "1", "nan", 'x"y', "a,b", "c\nd", "#", "e\r\nf", "#0;x", "g\0h", "\0"]
)
receptor_types = st.builds(
    ReceptorType,
    texts,
    allow_unusual=st.just(True),  # files keep any number
    peak_wavelength_nm=numbers(310, 700),
    microvillus_angle_rad=numbers(-3, 3),
    polarisation_sensitivity=numbers(1, 10),
    absorption_per_m=numbers(0, 1e4),
    length_m=numbers(0, 1e-3),
    right_rad=numbers(-0.1, 0.1),
    up_rad=numbers(-0.1, 0.1),
    acceptance=st.none() | st.builds(Acceptance.airy, numbers(1e-5, 1e-4), numbers(300, 700)),
)
column_names = st.one_of(
    texts.filter(bool),
    st.sampled_from(
        ["kernel", "position_x_mm", "position_x", "column:a", "DIAMETER", "OMMA_UP", "eye_name"]
    ),
)


@st.composite
def eyes(draw):
    """Eyes with all that an eye can have."""
    count = draw(st.integers(1, 6))
    some = st.lists

    def each(strategy):
        return draw(some(strategy, min_size=count, max_size=count))

    def vectors(strategy):
        return np.array(each(st.tuples(strategy, strategy, strategy)), dtype=np.float32)

    axis = vectors(float32s(-1, 1))
    axis[np.linalg.norm(axis, axis=1) < 0.01] = (0, 1, 0)
    up = None
    if draw(st.booleans()):
        up = np.cross(axis, np.roll(axis, 1, axis=1) + np.array([0.1, 0.2, 0.4]))
        up[np.linalg.norm(up, axis=1) < 0.01] = 0
    # Two that are the same become one when eyes are put together, as OCES files are read.
    different = {"unique_by": lambda type_: (type_.name, type_.peak_wavelength_nm)}
    types = draw(st.lists(receptor_types, max_size=3, **different))
    receptors = None
    if types:
        indices = st.lists(st.integers(0, len(types) - 1), max_size=4)
        receptors = each(indices.map(lambda some: np.array(some, dtype=np.int32)))
    columns = {}
    for name in draw(st.lists(column_names, max_size=3, unique=True)):
        columns[name] = each(texts) if draw(st.booleans()) else np.array(each(st.floats()))
    optics = {"acceptance": each(st.none() | acceptances)} if draw(st.booleans()) else {}
    return omma.Eye(
        vectors(float32s(-1, 1)),
        axis,
        np.array(each(float32s(0, 6.25)), dtype=np.float32),
        np.array(each(lengths), dtype=np.float32),
        np.array(each(st.integers(0, 3)), dtype=np.int32),
        up=up,
        facet_diameter_m=np.array(each(lengths), dtype=np.float32),
        aperture_diameter_m=np.array(each(lengths), dtype=np.float32),
        receptor_types=types or None,
        receptors=receptors,
        columns=columns or None,
        **optics,
    )


@pytest.mark.parametrize("suffix", [".csv", ".gltf", ".glb"])
@settings(max_examples=60, deadline=None)
@given(eye=eyes())
def test_everything_survives_to_the_last_bit(tmp_path_factory, suffix, eye):
    path = tmp_path_factory.getbasetemp() / f"eye{suffix}"
    omma.save_eye(path, eye)
    assert omma.eye.eye_file_losses(path, eye) == []
    back = omma.load_eye(path)
    assert_same(eye, back)
    assert back.path == str(path)
