"""What omma.detect says where a distance cannot be told, or not well: too few rays, targets that
are never or always seen, classes of receptors, and what is refused."""

import math

import numpy as np
import pytest
from detection_cases import BRIGHT, LIGHT, bee, catches, root, share

import omma
from omma.colour_vision import DiscTarget, Observer, SceneTarget


def test_targets_that_few_rays_meet():
    # In bright light d' is 1 where the disc fills 3e-4 of the acceptance: 256 rays meet it by luck.
    eye = bee()
    ground, disc = (catches(eye, one, 0.03, BRIGHT)[2] for one in (0.1, 0.4))

    def d_prime(distance_m):
        more = (disc - ground) * share(distance_m, 0.015)
        return more / math.sqrt(ground + more / 2)

    observer = Observer(receptors=("green",))
    for seed in range(2):
        found = omma.detect(eye, DiscTarget(0.03, 0.4, 0.1), BRIGHT, observer, seed=seed)
        expected = root(lambda d: d_prime(d) - 1, 0.01, 1000)
        assert share(expected, 0.015) < 1e-3
        assert found.distance_m == pytest.approx(expected, abs=4 * found.standard_error_m)
        assert 0 < found.standard_error_m < 0.1 * expected


def test_too_few_rays_are_told():
    eye, target = bee(), DiscTarget(0.03, 0.4, 0.1)
    with pytest.warns(UserWarning, match=r"sampling: of 8 x 16 rays too few .*omma\.Fixed\(128\)"):
        few = omma.detect(eye, target, BRIGHT, sampling=omma.Fixed(16))
    assert few.standard_error_m == math.inf
    # At 500 m it fills a millionth of the acceptance, and none of 128 rays meets it.
    with pytest.warns(UserWarning, match=r"sampling: .* 0 m is off"):
        far = omma.detect(eye, target, BRIGHT, between_m=(500, 1000), sampling=omma.Fixed(16))
    assert (far.distance_m, far.standard_error_m) == (0, math.inf)


def test_what_is_never_and_what_is_always_told():
    eye = bee()
    same = omma.detect(eye, DiscTarget(0.02, 0.2, 0.2), LIGHT)
    assert same.distance_m == 0
    assert math.isnan(same.standard_error_m)
    for ends in ((0.01, 0.1), (0.07, 0.1)):
        plain = omma.detect(eye, DiscTarget(0.02, 0.0, 0.2), LIGHT, between_m=ends)
        assert plain.distance_m == math.inf
        assert math.isnan(plain.standard_error_m)
    # A grey on a grey is no colour.
    by_colour = Observer(by="colour", ommatidia=1)
    assert omma.detect(eye, DiscTarget(0.02, 0.1, 0.5), LIGHT, by_colour).distance_m == 0


def test_fewer_ommatidia_than_are_summed_over_are_told():
    target = DiscTarget(0.03, 0.4, 0.1)
    by = {"by": "achromatic", "receptors": ("green",)}
    with pytest.warns(UserWarning, match="expected 7 ommatidia, .* found 1: the distance is by"):
        seven = omma.detect(bee(), target, BRIGHT, Observer(**by))
    one = omma.detect(bee(), target, BRIGHT, Observer(**by, ommatidia=1))
    assert seven.distance_m == one.distance_m


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: DiscTarget(0, 0.1, 0.1), "diameter_m: expected a number above 0"),
        (lambda: DiscTarget(0.1, 1.1, 0.1), "reflectance: expected 0 to 1"),
        (
            lambda: DiscTarget(0.1, 0.1, omma.light.Spectrum([300, 700], [0.1, 2])),
            "background: expected 0 to 1, found 2",
        ),
        (lambda: DiscTarget(0.1, 0.1, 0.1, (0, 0, 0)), "facing: expected a direction"),
        (lambda: SceneTarget(omma.Scene(), omma.Scene(), -1), "diameter_m: expected a number"),
        (
            lambda: SceneTarget(omma.Scene(), omma.Scene(), 1, towards=(0, 0, 0)),
            "towards: expected a direction",
        ),
        (
            lambda: SceneTarget(omma.Scene(), omma.Scene(), 1, (0, 0, np.inf)),
            "center_m: expected finite numbers",
        ),
        (lambda: Observer(by="sound"), "by: expected one of photons, achromatic, colour"),
        (lambda: Observer(criterion=0), "criterion: expected a number above 0"),
        (lambda: Observer(receptors="green"), "receptors: expected a sequence of names"),
        (lambda: Observer(by="achromatic"), "receptors: expected the one that is achromatic"),
        (lambda: Observer(noise=(0.1, -1)), "noise: expected finite numbers above 0"),
        (lambda: Observer(noise=(13, 13, 15)), "found 13 or more; 13 per cent would be 0.13"),
        (
            lambda: omma.detect(bee(), DiscTarget(1, 0, 1), LIGHT, Observer(receptors=("red",))),
            "receptors: expected one of ultraviolet, blue, green, found 'red'",
        ),
        (
            lambda: omma.detect(bee(), DiscTarget(1, 0, 1), LIGHT, Observer(noise=(0.1,))),
            "noise: expected 3, one for each class of receptors of the eye ",
        ),
        (
            lambda: omma.detect(
                bee(), DiscTarget(0.01, 0, 1), LIGHT, Observer(azimuth_deg=180), between_m=(1, 9)
            ),
            "observer: expected a direction that ommatidia of the eye look into, found azimuth 180",
        ),
        (
            lambda: omma.detect(bee(), DiscTarget(1, 0, 1), LIGHT, between_m=(2, 1)),
            "between_m: expected two ascending distances",
        ),
        (
            lambda: omma.detect(
                bee(), DiscTarget(1, omma.light.Spectrum([400, 500], [0, 1]), 1), LIGHT
            ),
            "reflectance: expected values from 300",
        ),
        (
            lambda: omma.detect(bee(), DiscTarget(1, 0, 1), omma.light.uniform_sky(unit="watts")),
            "light: expected one in photons",
        ),
        (
            lambda: omma.detect(
                bee().replace(facet_diameter_m=np.zeros(1)), DiscTarget(1, 0, 1), LIGHT
            ),
            "eye: expected what photons are counted by",
        ),
        (
            lambda: omma.detect(bee(), DiscTarget(1, 0.2, 0), LIGHT, Observer(by="colour")),
            "target: expected photons of its ground in ultraviolet, found none in those of the 7 ",
        ),
    ],
)  # fmt: skip
def test_what_is_refused(call, told):
    with pytest.raises(omma.Error, match=told):
        call()


def test_progress_is_told_and_may_end_it():
    eye = bee()
    told = []
    omma.detect(eye, DiscTarget(0.02, 0.05, 0.2), LIGHT, progress=told.append)
    assert told[0] == 0
    assert told == sorted(told)
    assert told[-1] == 1

    def end(share):
        if share > 0:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        omma.detect(eye, DiscTarget(0.02, 0.05, 0.2), LIGHT, progress=end)


def fly():
    """The 31 ommatidia of a fly that look ahead: as many types of R1 as offsets."""
    eye = omma.species.drosophila(assume="honeybee_worker").eye
    return eye.take(np.flatnonzero(eye.axis[:, 2] < -0.985))


def test_a_criterion_that_is_passed_by_a_step_has_no_error():
    """Where the last ray leaves the target; 0 was told."""
    target, few = DiscTarget(0.03, 0.5, 0.1), omma.Fixed(16)
    found = omma.detect(fly(), target, BRIGHT, Observer(receptors=("R1",)), sampling=few)
    assert found.standard_error_m > 0.1 * found.distance_m


def test_types_of_one_name_are_one_class():
    """A fly has a type of R1 for each way in which it looks beside the axis."""
    eye = fly()
    names = list(dict.fromkeys(one.name for one in eye.receptor_types))
    assert len(names) < 12 < len(eye.receptor_types)
    target = DiscTarget(0.03, 0.5, 0.1)
    by = Observer(by="achromatic", receptors=("R1",), noise=(0.1,) * len(names))
    found = omma.detect(eye, target, BRIGHT, by, sampling=omma.Fixed(256))
    assert 0.05 < found.distance_m < 0.5
    with pytest.raises(omma.Error, match=rf"noise: expected {len(names)}, one for each class"):
        omma.detect(eye, target, BRIGHT, Observer(by="achromatic", receptors=("R1",), noise=(1,)))


def test_colour_is_told_by_the_classes_that_are_there_or_named():
    """A desert ant's dorsal rim is not ahead."""
    ant = omma.species.cataglyphis(assume="honeybee_worker").eye
    ahead = ant.take(np.flatnonzero(ant.axis[:, 2] < -0.9))
    petal = omma.light.Spectrum([300, 700], [0.1, 0.9])
    found = [
        omma.detect(ahead, DiscTarget(0.03, petal, 0.1), BRIGHT, Observer(by="colour", receptors=r))
        for r in ((), ("ultraviolet", "green"))
    ]
    assert found[0] == found[1]
    assert found[0].distance_m > 0.5
    rim = Observer(by="colour", receptors=("green", "dorsal rim ultraviolet along"))
    with pytest.raises(omma.Error, match="expected some with the receptor dorsal rim"):
        omma.detect(ahead, DiscTarget(0.03, petal, 0.1), BRIGHT, rim)


@pytest.mark.filterwarnings("error")
def test_what_cannot_be_told_is_never_seen():
    """In silence, and without an angle."""
    for by in ("photons", "colour"):
        found = omma.detect(bee(), DiscTarget(0.02, 0.2, 0.2), BRIGHT, Observer(by=by, ommatidia=1))
        assert found.distance_m == 0
        assert math.isnan(found.diameter_rad)


def test_a_black_ground_is_told_for_what_it_is():
    by = Observer(by="achromatic", receptors=("green",), ommatidia=1)
    with pytest.raises(omma.Error, match=r"photons of its ground in green.* reflectance above 0"):
        omma.detect(bee(), DiscTarget(0.02, 0.2, 0.0), BRIGHT, by)


def test_a_disc_that_nothing_lights_is_told():
    target = DiscTarget(0.02, 0.02, 0.2)
    with pytest.warns(UserWarning, match=r"target: no light falls on the side \(0\.0, 1"):
        found = omma.detect(bee(), target, omma.light.lamps())
    assert found.distance_m == 0
    assert math.isnan(found.diameter_rad)
