"""What docs/make_validation.py puts side by side: for each effect what must come out, by a closed
form or a published number, and what Omma gives.

A `Line` is a row of the page. Effects are computed anew here, with few rays; the tests that are
named hold them to more cases.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import omma
from omma.photoreceptors import ImpulseResponse

Floats = NDArray[np.float64]
AHEAD = [[0.0, 0.0, -1.0]]
FWHM = 3.5597  # pi^2 / (4 ln 2), of a Gaussian's modulation transfer
LOW_PASS = ImpulseResponse.howard(0.010, 0.3)


@dataclass(frozen=True)
class Line:
    """One number of one effect.

    effect: what it is. form: the closed form, or who published the number.
    expected, found: by that, and by Omma.
    allowed: how far apart they may be, and why: `because`.
    """

    effect: str
    form: str
    expected: float
    found: float
    allowed: float
    because: str

    def holds(self) -> bool:
        """Whether what came out is as near as allowed."""
        return abs(self.found - self.expected) <= self.allowed


def one_place(width_deg: Floats) -> omma.Eye:
    """Ommatidia that all look straight ahead from one point, with these acceptance angles."""
    count = len(width_deg)
    return omma.Eye(np.zeros((count, 3)), np.repeat(AHEAD, count, axis=0), np.radians(width_deg))


def amplitude(frames: Floats) -> Floats:
    """Contrast of a sine that goes through one period in the frames (T, N), around its mean."""
    turns = np.exp(-2j * np.pi * np.arange(len(frames)) / len(frames))
    return 2 * np.abs(np.mean(frames * turns[:, None], axis=0)) / frames.mean(axis=0)


def quantity() -> list[Line]:
    """A surround of radiance 1 gives 1, met as a surface or as a background."""
    eye = omma.species.honeybee_worker().eye.take(range(0, 10760, 20))
    closed = omma.stimuli.Bar(bar=1.0, background=1.0).world()
    white = omma.Background.constant((1, 1, 1))
    found = {
        "closed sphere of radiance 1, the worst of 538 ommatidia": omma.Renderer(closed, eye),
        "background of radiance 1, the worst of 538 ommatidia": omma.Renderer(
            omma.Scene(), eye, background=white
        ),
    }
    lines = []
    for effect, renderer in found.items():
        responses = renderer.render(np.eye(4)).ravel()
        worst = float(responses[np.abs(responses - 1).argmax()])
        lines.append(Line(effect, "R = 1", 1.0, worst, 1e-5, "rounding of single precision"))
    return lines


def gratings() -> tuple[list[Line], Floats, Floats, Floats]:
    """Contrast that ommatidia keep of a drum's sine: lines; frequencies times widths, expected and
    found for the figure."""
    width_deg = np.array([1.0, 2, 3, 4, 5, 6, 8, 10, 12, 15])
    eye = one_place(width_deg)
    kept, at = [], []
    for wavelength_deg in (10, 20, 40):
        grating = omma.stimuli.DrumGrating(wavelength_deg=wavelength_deg, contrast=0.8)
        renderer = omma.Renderer(grating.world(), eye, omma.Fixed(1024), footprints=False)
        frames = grating.play(renderer, np.arange(12) / 12)[..., 1]
        kept.append(amplitude(frames) / 0.8)
        at.append(width_deg / wavelength_deg)
    ratio, found = np.concatenate(at), np.concatenate(kept)
    expected = np.exp(-FWHM * ratio**2)
    lines = [
        Line(
            f"contrast of a grating that {wide:g}° of acceptance keep of 20°",
            "exp(−3.5597 (Δρ/λ)²)",
            float(expected[10 + i]),
            float(found[10 + i]),
            0.005,
            "1,024 rays; the formula is that of narrow fields",
        )
        for i, wide in enumerate(width_deg)
        if wide in (2, 5, 10, 15)
    ]
    return lines, ratio, expected, found


def optics() -> list[Line]:
    """Widths of angular sensitivities."""
    facet_m, wavelength_nm = 25e-6, 500.0
    airy = omma.Acceptance.airy(facet_m, wavelength_nm)
    width = float(np.degrees(airy.mean_width_rad))
    ideal = float(np.degrees(1.02899 * wavelength_nm * 1e-9 / facet_m))
    cutoff = airy.mtf(facet_m / (wavelength_nm * 1e-9) * 1.001)
    half = airy.mtf(facet_m / (wavelength_nm * 1e-9) / 2)
    disc = 2 / np.pi * (np.arccos(0.5) - 0.5 * np.sqrt(0.75))
    return [
        Line(
            "width of an Airy pattern, D 25 µm, λ 500 nm, °",
            "1.029 λ/D",
            ideal,
            width,
            1e-3,
            "1.029 has four digits",
        ),
        Line(
            "contrast of gratings of half the highest frequency, D/2λ",
            "2/π (arccos ½ − ½ √¾)",
            float(disc),
            float(half),
            2e-3,
            "tabulated",
        ),
        Line(
            "contrast beyond the highest frequency that a lens passes, D/λ",
            "0",
            0.0,
            float(cutoff),
            1e-3,
            "tabulated",
        ),
    ]


def standard_errors() -> list[Line]:
    """Standard errors against what 32 seeds scatter by, in the meadow."""
    scene = omma.load_scene(omma.examples.meadow())
    eye = omma.species.honeybee_worker().eye.take(range(0, 10760, 40))
    renderer = omma.Renderer(scene, eye, omma.Fixed(8))
    seen = [
        renderer.with_eye(eye, seed=seed).render("bee", standard_error=True) for seed in range(32)
    ]
    scatter = np.var([one for one, _ in seen], axis=0, ddof=1)
    told = np.mean([errors**2 for _, errors in seen], axis=0)
    ratio = float(np.sqrt(told.sum() / scatter.sum()))
    return [
        Line(
            "standard error told over scatter of 32 seeds, 269 ommatidia in the meadow, rms",
            "1",
            1.0,
            ratio,
            0.06,
            "scatter of 32 seeds; errors of 7 degrees of freedom",
        ),
    ]


def time() -> tuple[list[Line], Floats, Floats, Floats]:
    """What a frame that lasts keeps of flicker: a head that turns before stripes."""
    cycles, width_deg, contrast = 20, 4.0, 0.8
    azimuth = (np.arange(4096) + 0.5) / 4096 * 2 * np.pi
    stripes = np.repeat(1 + contrast * np.cos(cycles * azimuth), 3).reshape(1, -1, 3)
    scene = omma.Scene(background=omma.Background.image(np.tile(stripes, (8, 1, 1)).astype("f4")))
    eye = one_place(np.array([width_deg]))
    renderer = omma.Renderer(
        scene, eye, omma.Fixed(2048), footprints=False, impulse_response=LOW_PASS
    )
    frequencies = np.array([1.0, 5, 10, 15, 25, 40, 60, 90])
    seen = contrast * np.exp(-FWHM * (cycles / 360) ** 2 * width_deg**2)
    found = []
    for frequency_hz in frequencies:
        rate = 2 * np.pi * frequency_hz / cycles
        past_s = np.linspace(-1.01 * LOW_PASS.duration_s, 0, 8)[:-1]
        times_s = np.arange(12) / 12 / frequency_hz

        def turning(angles: Floats) -> Floats:
            return np.stack([omma.look_at((0, 0, 0), (np.sin(a), 0, -np.cos(a))) for a in angles])

        past = (turning(rate * past_s), past_s)
        frames = renderer.render(turning(rate * times_s), times_s=times_s, past=past)
        found.append(float(amplitude(frames[:, :, 0])[0]) / seen)
    expected = np.abs(LOW_PASS.transfer(frequencies))
    lines = [
        Line(
            f"flicker of {frequencies[i]:g} Hz that a log-normal response (10 ms, σ 0.3) keeps",
            "size of H(f)",
            float(expected[i]),
            found[i],
            0.01,
            "2,048 rays",
        )
        for i in (1, 3, 5)
    ]
    return lines, frequencies, expected, np.array(found)


def motion() -> tuple[list[Line], Floats, Floats, Floats]:
    """Correlation detectors run on a sine, over its frequency."""
    tau_s, wavelength, apart = 0.035, np.radians(20), np.radians(4)
    frequencies = np.geomspace(0.3, 40, 12)
    eye = omma.Eye(
        np.zeros((2, 3)), [[0, 0, -1], [np.sin(apart), 0, -np.cos(apart)]], np.radians(5)
    )
    expected, found = [], []
    for frequency_hz in frequencies:
        rate = 64 * frequency_hz
        array = omma.motion.detector_array(eye, tau_s, rate, pairs=[[0, 1]])
        time_s = np.arange(64 * max(3, round(6 * tau_s * frequency_hz) + 2)) / rate
        phase = np.array([0, apart]) / wavelength
        signal = 1 + 0.8 * np.sin(2 * np.pi * (frequency_hz * time_s[:, None] - phase))
        found.append(float(array.run(signal)[-64:].mean()))
        expected.append(
            float(omma.motion.grating_response(0.8, wavelength, frequency_hz, apart, tau_s))
        )
    lines = [
        Line(
            f"detector of τ 35 ms, λ 20°, Δφ 4°, {frequencies[i]:.2g} Hz",
            "C² sin(2πΔφ/λ) ωτ/(1 + ω²τ²)",
            expected[i],
            found[i],
            1.5e-3,
            "straight lines between frames, 64 a period",
        )
        for i in (2, 6, 10)
    ]
    return lines, frequencies, np.array(expected), np.array(found)


def flow() -> list[Line]:
    """Optic flow and distance in a drum of radius 1 m, ahead at 0.5 m/s and turning at 1 rad/s."""
    azimuth = np.radians([30.0, 90.0, 150.0])
    axis = np.stack([np.sin(azimuth), 0 * azimuth, -np.cos(azimuth)], axis=1)
    eye = omma.Eye(np.zeros((3, 3)), axis, np.radians(0.5))
    world = omma.World(omma.scene.drum(1.0, 4.0, (0.5, 0.5, 0.5)))
    velocity = (np.array([0, 0, -0.5]), np.array([0, -1.0, 0]))  # ahead; to the right
    truth = omma.Renderer(world, eye, omma.Fixed(256)).ground_truth(
        np.eye(4), head_velocity=velocity
    )
    lines = []
    for i, at in enumerate((30, 90, 150)):
        lines.append(
            Line(
                f"flow to the right at {at}°, rad/s: 0.5 m/s in a drum of 1 m, turning at 1 rad/s",
                "v sin θ/r − ω",
                float(0.5 * np.sin(azimuth[i]) - 1),
                float(truth.flow_rad_s[0, i, 0]),
                2e-3,
                "a drum of flat walls",
            )
        )
    lines.append(
        Line(
            "distance of the drum's wall, m",
            "r",
            1.0,
            float(truth.distance_m[0, 1]),
            2e-3,
            "a drum of flat walls",
        )
    )
    return lines


def stimuli() -> list[Line]:
    """A looming disc, a target and dots, rendered, beside what their formulas say."""
    eye = omma.eye.generate_eye(200)
    shown = {
        "looming disc": (omma.stimuli.LoomingDisc(), [0.5, 0.9, 0.95]),
        "target of 4° on its path": (
            omma.stimuli.Target(4.0, [0, 1], [-40, 40], [0, 20]),
            [0.2, 0.8],
        ),
        "random dots": (omma.stimuli.RandomDots(), [0.0, 0.5]),
        "bar of 10°": (omma.stimuli.Bar(), [0.0, 0.4]),
    }
    lines = []
    for name, (stimulus, times_s) in shown.items():
        renderer = omma.Renderer(stimulus.world(), eye, omma.Fixed(1024), footprints=False)
        found = stimulus.play(renderer, times_s)[..., 1]
        must = stimulus.expected(eye.axis, eye.acceptance_angle_rad, times_s)
        rms = float(np.sqrt(np.mean((found - must) ** 2)))
        lines.append(
            Line(
                f"{name}: rms difference over 200 ommatidia",
                "mean of radiance on the sphere",
                0.0,
                rms,
                3e-3,
                "1,024 rays at edges",
            )
        )
    return lines


def sky() -> list[Line]:
    """The clear sky beside a separate computation of radiative transfer, given to two digits."""
    bands = omma.light.Bands.from_edges([348, 352, 438, 442, 538, 542])
    light = omma.light.clear_sky(30, sun_azimuth_deg=0, aerosol=0.0, bands=bands)
    diffuse, sun = light.irradiance()
    share = (diffuse / (diffuse + sun))[[0, 2, 4]]
    lines = [
        Line(
            f"sky's share of light on the ground at {at} nm, sun at 30°, 300 DU",
            "a separate computation",
            must,
            float(found),
            0.01,
            "two digits",
        )
        for at, must, found in zip((350, 440, 540), (0.55, 0.25, 0.11), share, strict=True)
    ]
    visible = omma.light.Bands.equal(12, 400, 700)
    diffuse, sun = omma.light.clear_sky(
        30, sun_azimuth_deg=0, aerosol=0.0, bands=visible
    ).irradiance()
    total = float(25 * (diffuse + sun).sum() / 1e20)
    lines.append(
        Line(
            "photons of 400 to 700 nm, 10²⁰ m⁻² s⁻¹",
            "a separate computation",
            6.4,
            total,
            0.07,
            "two digits",
        )
    )
    elevation = np.radians(np.arange(2.0, 90.0, 0.25))
    up = np.stack([0 * elevation, np.sin(elevation), -np.cos(elevation)], axis=1)
    degree_q = np.array([light.radiance(one)[1, 2] for one in up])
    crossings = np.flatnonzero(degree_q[:-1] * degree_q[1:] < 0)
    for name, at, must in (
        ("Babinet's point above", crossings[-1], 17.5),
        ("Brewster's below", crossings[0], 22),
    ):
        found = abs(float(np.degrees(elevation[at])) - 30)
        lines.append(
            Line(
                f"{name} the sun at 30°, 440 nm, °",
                "a separate computation",
                must,
                found,
                0.75,
                "half a degree of the table, a quarter of the steps here",
            )
        )
    return lines


def photons() -> list[Line]:
    """Photon noise: variance as mean."""
    noisy = omma.photoreceptors.photon_noise(np.full((2000, 50), 40.0), seed=1)
    return [
        Line(
            "variance of photon numbers of mean 40",
            "Poisson: the mean",
            40.0,
            float(noisy.var()),
            0.8,
            "100,000 numbers: 0.18 a standard deviation",
        ),
    ]
