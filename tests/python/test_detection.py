"""From how far a target is detected: against the closed form of one Gaussian ommatidium, an eye's
sum over its lattice, and light."""

import math

import numpy as np
import pytest

import omma
from omma.colour_vision import DiscTarget, Observer, SceneTarget

WIDTH_RAD = math.radians(2.6)
DIM, LIGHT, BRIGHT = (omma.light.uniform_sky(radiance) for radiance in (1e13, 1e16, 3e18))


def bee(axes=((0.0, 0.0, -1.0),), width_rad=WIDTH_RAD):
    """Ommatidia of one receptor of each type of a honeybee, at the head's middle."""
    types = omma.species.honeybee_worker().eye.receptor_types
    eye = omma.Eye(np.zeros((len(axes), 3)), axes, width_rad)
    return eye.replace(
        facet_diameter_m=np.full(len(axes), 20e-6),
        receptor_types=types,
        receptors=[range(len(types))] * len(axes),
    )


def catches(eye, reflectance, time_s, light=LIGHT):
    """Photons of each receptor before a wide surface of this grey in the light on level ground."""
    radiance = reflectance * sum(light.irradiance()) / math.pi
    matrix = omma.receptors.receptor_matrix(eye, bands=light.bands)
    return omma.receptors.photon_catch(
        eye, (matrix @ radiance)[eye.receptor_type], light, integration_time_s=time_s
    )


def share(distance_m, radius_m, width_rad=WIDTH_RAD):
    """Of a Gaussian's sensitivity on a disc in its middle. In the plane; on the sphere the share
    differs by less than Δρ²/10, 2e-4 of itself."""
    angle = math.atan2(radius_m, distance_m)
    return 1 - 2 ** -((2 * angle / width_rad) ** 2)


def root(function, low, high):
    """Where a falling function is 0."""
    for _ in range(200):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if function(middle) > 0 else (low, middle)
    return low


def agrees(found, distance_m):
    """Within four standard errors, of 7 degrees of freedom as they are, and what the plane and the
    polygon leave."""
    assert 0 < found.standard_error_m < 0.02 * found.distance_m
    assert found.distance_m == pytest.approx(
        distance_m, abs=4 * found.standard_error_m + 3e-4 * distance_m
    )


@pytest.mark.parametrize(
    ("dark", "light", "criterion"), [(0.02, 0.3, 1.0), (0.6, 0.2, 5.0), (0.0, 0.5, 5.0)]
)
def test_one_ommatidium_by_photons(dark, light, criterion):
    eye, time_s, dark_per_s = bee(), 0.03, 200.0
    ground, disc = (catches(eye, one, time_s)[2] for one in (light, dark))

    def d_prime(distance_m):
        more = (disc - ground) * share(distance_m, 0.01)
        return abs(more) / math.sqrt(ground + more / 2 + dark_per_s * time_s)

    observer = Observer(
        criterion=criterion, integration_time_s=time_s, receptors=("green",), dark_per_s=dark_per_s
    )
    found = omma.detect(eye, DiscTarget(0.02, dark, light), LIGHT, observer)
    agrees(found, root(lambda d: d_prime(d) - criterion, 0.01, 1000))
    assert found.diameter_rad == pytest.approx(2 * math.atan(0.01 / found.distance_m), rel=1e-14)


@pytest.mark.parametrize("facing", [(0.0, 1.0, 0.0), (1.0, 0.0, 0.0)])
def test_through_fog_it_is_nearer(facing):
    """Both are dimmed by exp(-σ d), and the horizon's light comes between, which is noise."""
    sky = omma.light.clear_sky(50.0, sun_azimuth_deg=90)
    fog = omma.light.with_air(sky, extinction_per_m=1.5)
    eye, time_s = bee(), 0.03
    matrix = omma.receptors.receptor_matrix(eye, bands=sky.bands)[2]
    lit = sum(sky.irradiance(facing)) / math.pi
    azimuth_deg = 180 + 90 * facing[0] + 180 * facing[1]  # opposite to where it faces
    ahead = omma.base.directions.direction(azimuth_deg, 0)
    horizon = sky.radiance(ahead)[0]

    def caught(radiance):
        values = np.zeros(len(eye.receptor_type))
        values[2] = matrix @ radiance
        return omma.receptors.photon_catch(eye, values, sky, integration_time_s=time_s)[2]

    def d_prime(distance_m):
        left = math.exp(-1.5 * distance_m)
        more = left * caught((0.3 - 0.1) * lit) * share(distance_m, 0.01)
        ground = left * caught(0.1 * lit) + (1 - left) * caught(horizon)
        return more / math.sqrt(ground + more / 2)

    target = DiscTarget(0.02, 0.3, 0.1, facing)
    by = Observer(receptors=("green",), integration_time_s=time_s)
    found = omma.detect(eye, target, fog, by)
    agrees(found, root(lambda distance_m: d_prime(distance_m) - 1, 0.01, 100))
    assert found.distance_m < 0.8 * omma.detect(eye, target, sky, by).distance_m


def test_all_receptors_add_up():
    eye = bee()
    ground, disc = (catches(eye, one, 0.01) for one in (0.2, 0.05))

    def d_prime(distance_m):
        seen = ground + (disc - ground) * share(distance_m, 0.005)
        return omma.colour_vision.d_prime(seen, ground)

    observer = Observer(integration_time_s=0.01, criterion=3.0)
    found = omma.detect(eye, DiscTarget(0.01, 0.05, 0.2), LIGHT, observer)
    agrees(found, root(lambda d: d_prime(d) - 3, 0.01, 1000))


def test_one_ommatidium_by_colour():
    eye = bee()
    yellow = omma.light.Spectrum([300, 480, 520, 700], [0.05, 0.05, 0.6, 0.6])
    noise = (0.12, 0.06, 0.13)
    matrix = omma.receptors.receptor_matrix(eye, bands=LIGHT.bands)
    falls = sum(LIGHT.irradiance()) / math.pi
    ground, disc = (
        omma.receptors.photon_catch(eye, matrix @ (falls * one), LIGHT, integration_time_s=0.03)
        for one in (0.1, LIGHT.bands.mean(yellow.value, yellow.wavelength_nm))
    )

    def apart(distance_m):
        seen = ground + (disc - ground) * share(distance_m, 0.01)
        return omma.colour_vision.noise_limited_distance(seen, ground, noise, photon_noise=True)

    observer = Observer(by="colour", criterion=2.0, noise=noise, ommatidia=1)
    found = omma.detect(eye, DiscTarget(0.02, yellow, 0.1), LIGHT, observer)
    agrees(found, root(lambda d: apart(d) - 2, 0.01, 1000))


def test_one_ommatidium_by_one_receptor():
    eye = bee()
    ground, disc = (catches(eye, one, 0.03)[2] for one in (0.3, 0.1))

    def apart(distance_m):
        seen = ground + (disc - ground) * share(distance_m, 0.01)
        return omma.colour_vision.achromatic_distance(seen, ground, 0.05, photon_noise=True)

    observer = Observer(by="achromatic", receptors=("green",), noise=(0.2, 0.2, 0.05), ommatidia=1)
    found = omma.detect(eye, DiscTarget(0.02, 0.1, 0.3), LIGHT, observer)
    agrees(found, root(lambda d: apart(d) - 1, 0.01, 1000))


def test_a_lattice_sums_over_what_its_ommatidia_see():
    width = math.radians(4)
    tilt = math.radians(3)
    around = np.radians(60 * np.arange(6))
    ring = np.stack([np.sin(tilt) * np.cos(around), np.sin(tilt) * np.sin(around),
                     np.full(6, -np.cos(tilt))], axis=1)  # fmt: skip
    eye = bee([(0.0, 0.0, -1.0), *ring.tolist()], width)
    ground, disc = (catches(eye, one, 0.03)[2] for one in (0.2, 0.1))
    # The disc's share of each Gaussian, by a fine grid of its own solid angle.
    radius, azimuth = np.meshgrid((np.arange(400) + 0.5) / 400, np.arange(360) * np.pi / 180)
    whole = omma.receptors.solid_angle_sr(width)

    def d_prime(distance_m):
        polar = radius * math.atan2(0.05, distance_m)
        rays = np.stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth),
                         -np.cos(polar)], axis=-1)  # fmt: skip
        cell = np.sin(polar) * math.atan2(0.05, distance_m) / 400 * np.pi / 180
        off = np.arccos(np.clip(rays @ eye.axis.astype(float).T, -1, 1))
        sensitivity = np.exp(-4 * math.log(2) * (off / width) ** 2)
        shares = (sensitivity * cell[..., None]).sum((0, 1)) / whole
        assert shares[0] > shares[1] > 0
        return omma.colour_vision.d_prime(ground + (disc - ground) * shares, np.full(7, ground))

    observer = Observer(receptors=("green",), criterion=4.0)
    found = omma.detect(eye, DiscTarget(0.1, 0.1, 0.2), LIGHT, observer)
    assert d_prime(found.distance_m - 4 * found.standard_error_m) > 4
    assert d_prime(found.distance_m + 4 * found.standard_error_m) < 4
    assert found.standard_error_m < 0.01 * found.distance_m


def test_an_eye_of_an_animal():
    eye = omma.species.honeybee_worker().eye
    eye = eye.take(np.flatnonzero(eye.axis[:, 2] < -0.96))  # that are within 16° of ahead
    green = Observer(receptors=("green",), criterion=5.0)
    dim = omma.light.uniform_sky(1e14)

    def detect(diameter_m, light, seed=0):
        spot = DiscTarget(diameter_m, 0.02, 0.2)
        few = omma.Fixed(256)
        return omma.detect(eye, spot, light, green, between_m=(0.2, 50), sampling=few, seed=seed)

    small = detect(0.02, dim)
    assert detect(0.02, LIGHT).distance_m > 2 * small.distance_m > 0
    # Twice as large is the same twice as far, but for the few millimetres between the lenses.
    large = detect(0.04, dim)
    error = math.hypot(2 * small.standard_error_m, large.standard_error_m)
    assert large.distance_m == pytest.approx(2 * small.distance_m, abs=4 * error + 0.004)
    # Rays of another seed agree within the error, and are others.
    other = detect(0.02, dim, seed=5)
    error = math.hypot(small.standard_error_m, other.standard_error_m)
    assert other.distance_m != small.distance_m
    assert other.distance_m == pytest.approx(small.distance_m, abs=4 * error)
    assert detect(0.02, dim) == small


def test_where_the_target_is_kept():
    eye = bee([(0.0, 0.0, -1.0), (math.sqrt(0.5), 0.0, -math.sqrt(0.5)), (0.0, 1.0, 0.0)])
    target = DiscTarget(0.02, 0.02, 0.3)
    there = [
        omma.detect(
            eye,
            target,
            LIGHT,
            Observer(azimuth_deg=azimuth, elevation_deg=elevation),
            sampling=omma.Fixed(512),
        )
        for azimuth, elevation in ((0, 0), (45, 0), (0, 90))
    ]
    for one in there:
        error = math.hypot(one.standard_error_m, there[0].standard_error_m)
        assert one.distance_m == pytest.approx(there[0].distance_m, abs=4 * error)
    # Two widths beside all axes it is not seen but from near.
    aside = Observer(azimuth_deg=5.2)
    beside = omma.detect(eye, target, LIGHT, aside, sampling=omma.Fixed(512))
    assert 0 < beside.distance_m < 0.5 * there[0].distance_m


def matte(shape, reflectance):
    """A thing of one material that scatters light alike from 300 to 700 nm, and has no gloss."""
    grey = omma.light.Spectrum([300, 700], [reflectance] * 2)
    return shape.replace(
        materials=[one.replace(reflectance=grey, specular=0.0) for one in shape.materials]
    )


def test_a_disc_in_a_scene_is_a_disc():
    # The same as of reflectances, in light that is the same from everywhere: but for the millimetre
    # between disc and wall, through which some of the wall's light comes and goes.
    eye = bee()
    wall = matte(omma.scene.plane((4, 4), facing=(0, 0, 1), center_m=(0, 0, -1e-3)), 0.1)
    disc = matte(omma.scene.disc(0.05, segments=512), 0.4)
    target = SceneTarget(omma.scene.merge_scenes([wall, disc]), wall, 0.1)
    ground, on_disc = (catches(eye, one, 0.03, DIM)[2] for one in (0.1, 0.4))

    def d_prime(distance_m):
        more = (on_disc - ground) * share(distance_m, 0.05)
        return more / math.sqrt(ground + more / 2)

    few = omma.Fixed(512)
    observer = Observer(receptors=("green",), criterion=2.0)
    found = omma.detect(eye, target, DIM, observer, between_m=(0.5, 8), sampling=few)
    agrees(found, root(lambda d: d_prime(d) - 2, 0.01, 1000))
    # Seen from elsewhere, and elsewhere, it is the same.
    turned, moved = omma.look_at((0, 0, 0), (1, -1, 0)), (1.0, 2.0, 3.0)
    turned[:3, 3] = moved
    there = SceneTarget(
        omma.scene.place_scene(target.scene, turned),
        omma.scene.place_scene(wall, turned),
        0.1,
        moved,
        turned[:3, 2],
    )
    again = omma.detect(eye, there, DIM, observer, between_m=(0.5, 8), sampling=few)
    agrees(again, root(lambda d: d_prime(d) - 2, 0.01, 1000))


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
