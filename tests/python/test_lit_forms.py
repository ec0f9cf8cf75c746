"""Lit worlds against closed forms, in the whole renderer, on both backends."""

import pytest
from lit_checks import LARGEST_ERROR
from lit_checks_lights import CASES as OF_LIGHTS
from lit_checks_surfaces import CASES as OF_SURFACES
from lit_checks_volumes import CASES as OF_VOLUMES

CASES = {**OF_SURFACES, **OF_VOLUMES, **OF_LIGHTS}
# What takes over a second, once.
SLOW = {"furnace", "energy", "form factors", "overcast", "sun"}


@pytest.mark.parametrize(
    ("name", "backend"),
    [
        pytest.param(name, backend, id=f"{name}, {backend}")
        for name in CASES
        for backend in ("embree", "portable")
        if backend == "embree" or name not in SLOW
    ],
)
def test_closed_form(name, backend):
    for check in CASES[name](backend):
        said = f"{check.effect}: {check.found:.7g}, expected {check.expected:.7g}"
        assert check.standard_error <= LARGEST_ERROR * check.measure(), said
        assert abs(check.error()) <= check.limit(), said
