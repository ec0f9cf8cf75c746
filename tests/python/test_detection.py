"""From how far a target is detected: against the closed form of one Gaussian ommatidium, an eye's
sum over its lattice, and light."""

import math

import numpy as np
import pytest
from detection_cases import DIM, LIGHT, bee, catches, root, share

import omma
from omma.colour_vision import DiscTarget, Observer, SceneTarget


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
