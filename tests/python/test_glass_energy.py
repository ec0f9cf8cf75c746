"""Energy that boundaries of glass and water keep, rough ones and several behind each other, and
what tinted panes leave of light: white furnaces and closed forms.
"""

import numpy as np
import pytest

import omma
from omma.light import Bands, Spectrum
from omma.scene import Material

BANDS = Bands.equal(1, 400, 700)
EVEN = omma.light.uniform_sky(1.0, bands=BANDS)
WHITE = Material(base_color=(1, 1, 1), specular=0, roughness=1)


def looking_down(elevations_deg, each=40, width_deg=3.0):
    e = np.radians(np.repeat(elevations_deg, each))
    axes = np.stack([0 * e, -np.sin(e), -np.cos(e)], -1)
    return omma.Eye(np.zeros((len(e), 3)), axes, np.radians(width_deg))


def seen(scene, elevations_deg, samples, light=EVEN):
    """Means over ommatidia of each elevation, and their standard errors."""
    each = 40
    renderer = omma.Renderer(
        omma.World(scene, light=light), looking_down(elevations_deg, each), omma.Fixed(samples)
    )
    response, error = renderer.render(np.eye(4), standard_error=True)
    rows = response[0, :, 0].astype(float).reshape(-1, each)
    errors = error[0, :, 0].astype(float).reshape(-1, each)
    return rows.mean(1), np.sqrt((errors**2).sum(1)) / each


@pytest.mark.parametrize("wind_m_per_s", [1.0, 5.0, 14.0])
def test_a_white_bottom_below_clear_water_with_waves_gives_back_all(wind_m_per_s):
    water = omma.scene.water_volume("IB", wind_m_per_s=wind_m_per_s).replace(
        absorption_per_m=Spectrum([300, 700], [0, 0])
    )
    scene = omma.scene.merge_scenes(
        [
            omma.scene.plane((400, 400), center_m=(0, -1.3, 0)).replace(materials=[WHITE]),
            omma.scene.plane((400, 400), center_m=(0, -1, 0)).replace(materials=[water]),
        ]
    )
    found, error = seen(scene, [60, 30], 256)
    # Within 2 %: light that goes up is mirrored as by a level boundary.
    assert np.all(np.abs(found - 1) < 4 * error + 0.02)


@pytest.mark.parametrize("roughness", [0.1, 0.3, 0.6, 1.0])
def test_frosted_blocks_give_back_all(roughness):
    glass = Material(
        base_color=(1, 1, 1), ior=1.5, roughness=roughness, transmission=1, thickness_m=0.3
    )
    block = omma.scene.box((100, 0.3, 100), center_m=(0, -1, 0)).replace(materials=[glass])
    found, error = seen(block, [60, 30], 64)
    assert np.all(np.abs(found - 1) < 4 * error + 0.01)


@pytest.mark.parametrize("through", [1.0, 0.5, 0.25])
@pytest.mark.parametrize("elevation_deg", [90, 40, 15])
def test_the_sun_through_a_tinted_pane(through, elevation_deg):
    """On a matt floor: (1 - R)^2 of the boundaries and what is absorbed on the bent way; light that
    goes to and fro in the pane, 2 to 9 % of it, is left out (docs/limits.md)."""
    ior, elevation = 1.5, np.radians(elevation_deg)
    glass = Material(
        base_color=(1, 1, 1), ior=ior, roughness=0, transmission=1, thickness_m=0.05,
        attenuation_color=(through,) * 3, attenuation_distance_m=0.05,
    )  # fmt: skip
    floor = Material(base_color=(0.5, 0.5, 0.5), specular=0, roughness=1, double_sided=True)
    scene = omma.scene.merge_scenes(
        [
            omma.scene.plane((6, 6), center_m=(0, -1, 0)).replace(materials=[floor]),
            omma.scene.box((200, 0.05, 200), center_m=(0, 1, 0)).replace(materials=[glass]),
        ]
    )
    radius_rad, radiance = 0.00465, 1e6
    towards = (0.0, np.sin(elevation), -np.cos(elevation))
    sun = omma.light.Disc(towards, radius_rad, [radiance])
    light = omma.light.Light(BANDS, "photons", discs=[sun])
    eye = omma.Eye([[0, 0, 0]], [[0, -1, 0]], np.radians(3.0))
    renderer = omma.Renderer(omma.World(scene, light=light), eye, omma.Fixed(256))
    response, error = renderer.render(np.eye(4), standard_error=True)
    up = np.sin(elevation)
    unshaded = 0.5 * radiance * radius_rad**2 * up
    bent = np.sqrt(1 - (1 - up**2) / ior**2)
    s, p = (
        ((up - ior * bent) / (up + ior * bent)) ** 2,
        ((ior * up - bent) / (ior * up + bent)) ** 2,
    )
    expected = unshaded * (1 - (s + p) / 2) ** 2 * through ** (1 / bent)
    assert response[0, 0, 0] == pytest.approx(
        expected, abs=4 * error[0, 0, 0] + 0.02 * expected + 0.0001 * unshaded
    )


@pytest.mark.parametrize("panes", [1, 2, 3])
@pytest.mark.parametrize("kind", ["thin", "frosted", "solid"])
def test_panes_in_even_light_leave_it_even_and_unpolarised(kind, panes):
    """As thermodynamics asks: what a pane mirrors of each polarisation it does not let through."""
    thin = Material(
        base_color=(1, 1, 1), ior=1.5, roughness=0.5 if kind == "frosted" else 0, transmission=1,
        double_sided=True,
    )  # fmt: skip
    solid = Material(base_color=(1, 1, 1), ior=1.5, roughness=0, transmission=1, thickness_m=0.05)
    a = np.radians([0, 50, 70, 80])
    axes = np.stack([np.sin(a), 0 * a, -np.cos(a)], -1)
    eye = omma.Eye(np.zeros((4, 3)), axes, np.radians(1.0))
    scene = omma.scene.merge_scenes(
        [
            omma.scene.box((60, 60, 0.05), center_m=(0, 0, z)).replace(materials=[solid])
            if kind == "solid"
            else omma.scene.plane((60, 60), center_m=(0, 0, z), facing=(0, 0, 1)).replace(
                materials=[thin]
            )
            for z in -1 - 0.2 * np.arange(panes)
        ]
    )
    world = omma.World(scene, light=EVEN, polarized=True)
    stokes, error = omma.Renderer(world, eye, omma.Fixed(1024)).render_stokes(
        np.eye(4), standard_error=True
    )
    even = np.broadcast_to([1.0, 0.0, 0.0], (4, 3))
    # Beside noise, what paths lose that end after many panes.
    assert np.all(np.abs(stokes[0, :, :, 0] - even) < 4 * error[0, :, :, 0] + 0.005)
