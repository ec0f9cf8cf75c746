"""Integration times of animals: whose they are is said, and where to get one that lacks."""

import ast
import re

import numpy as np
import pytest

import omma

BLOWFLY_TIME = "integration time 7.4 ms, as of calliphora (interpolated)"


@pytest.mark.parametrize(
    ("name", "assume", "last"),
    [
        ("honeybee_worker", "calliphora", BLOWFLY_TIME),
        ("honeybee_worker", ("honeybee_worker", "calliphora"), BLOWFLY_TIME),
        ("drosophila", ("calliphora", "honeybee_worker"), BLOWFLY_TIME),
        ("holcocephala", ("calliphora", "honeybee_worker"), BLOWFLY_TIME),
        (
            "cataglyphis",
            ("honeybee_worker", "bumblebee", "calliphora"),
            "integration time of dorsal rim ultraviolet along, dorsal rim ultraviolet across "
            "7.4 ms, as of calliphora (interpolated)",
        ),
    ],
)
def test_a_time_of_another_animal_is_said(name, assume, last):
    animal = omma.species.make(name, assume=assume)
    assert animal.assumed[-1] == last
    assert last in animal._repr_html_()


def test_a_time_that_is_its_own_or_nobodys_is_not_said_to_be_taken():
    for name, donor in (("calliphora", "bumblebee"), ("melophorus", "honeybee_worker")):
        donors = (donor, "honeybee_worker")
        said = omma.species.make(name, assume=donors).assumed
        assert not [one for one in said if "integration time" in one]


DONOR_OF_TIMES = {
    "honeybee_worker": "bumblebee",
    "honeybee_drone": "bumblebee",
    "melophorus": "bumblebee",
    "drosophila": "calliphora",
}


@pytest.mark.parametrize("name", omma.species.names())
def test_who_lacks_a_time_is_told_of_an_animal_with_the_same_receptors(name):
    animal = omma.species.make(name)
    try:
        times = animal.integration_time_s
    except omma.Error as error:
        said = str(error)
    else:
        assert name in ("bumblebee", "calliphora")
        assert len(times) == len(animal.eye.receptor_type)
        return
    calls = re.findall(r"omma\.species\.(\w+)\(assume=(.*)\)$", said)
    if name not in DONOR_OF_TIMES:
        assert calls == []
        assert "no receptors of all these names" in said or "nor its receptors" in said
        return
    ((whose, assume),) = calls
    donors = np.atleast_1d(ast.literal_eval(assume)).tolist()
    assert (whose, donors[0]) == (name, DONOR_OF_TIMES[name])
    assert name not in donors
    taken = omma.species.make(name, assume=donors)
    assert len(taken.integration_time_s) == len(taken.eye.receptor_type)


def test_who_assumes_already_is_told_to_keep_it():
    robber = omma.species.holcocephala(assume="honeybee_worker")
    with pytest.raises(omma.Error, match=r"assume=\('honeybee_worker', 'bumblebee'\)\)$"):
        robber.integration_time_s  # noqa: B018
