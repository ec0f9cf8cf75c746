"""Puts the pieces together: the tables as python/omma/light/sky_stored.py reads them."""

import functools
from pathlib import Path

import grid
import haze_kinds
import numpy as np
from atmosphere import (
    ANGLE_DEG,
    EARTH_RADIUS_M,
    HAZE_SCALE_HEIGHT_M,
    air_density,
    haze_optics,
    ozone_per_du,
    ozone_profile,
    rayleigh_anisotropy,
    rayleigh_cross_section_m2,
    sun_spectrum,
)

STEP = np.array([5e-4, 1e-4, 1e-4])  # of log I, Q/I, U/I as whole numbers
FINE_NM = np.arange(300.0, 701.0)
MASS_DEG = np.concatenate([np.arange(0, 10, 0.25), np.arange(10, 30, 1.0), np.arange(30, 91, 5.0)])
# Degrees of polynomials and harmonics that Monte Carlo is smoothed to: of what discrete ordinates
# are off by for high suns, of low suns and of twilight.
SMOOTH_DEGREE = {"high": (10, 5), "low": (10, 9), "twilight": (6, 7)}


def assemble(folder: Path) -> dict[str, np.ndarray]:
    """Everything that is stored, by name."""
    parts = fixed_parts()
    fields = np.stack([_fields(folder, parts, haze) for haze in grid.HAZE])
    mean = fields[:, :, 0].mean(axis=(-2, -1))
    fields[:, :, 0] -= mean[..., None, None]
    whole = np.rint(fields / STEP[:, None, None, None]).astype(np.int32)
    steps = np.diff(whole, axis=-1, prepend=0)
    assert np.abs(steps).max() < 2**15, np.abs(steps).max()
    # Differences of these, modulo 2^16, take half the space: along wavelengths and elevations.
    steps = steps.astype(np.int16)
    for axis in (-3, -2):
        steps = np.diff(steps, axis=axis, prepend=np.int16(0))
    ground, returned = zip(*(_ground(folder, parts, haze) for haze in grid.HAZE))
    return {
        **parts,
        "steps": steps,
        "step": STEP,
        "log_mean": mean.astype(np.float32),
        "ground": np.array(ground, np.float32),
        "returned": np.array(returned, np.float32),
        **_ozone(folder),
    }


def fixed_parts() -> dict[str, np.ndarray]:
    """Grids and optical depths: what needs no radiative transfer."""
    fine_m = np.linspace(0, 100e3, 100_001)
    column = np.trapezoid(air_density(fine_m), fine_m)
    total, scattered, phase, _ = haze_optics(tuple(grid.WAVELENGTH_NM))
    half = np.sin(np.radians(ANGLE_DEG[::2]) / 2)
    assert np.allclose(np.diff(half), half[1])
    return {
        "wavelength_nm": grid.WAVELENGTH_NM,
        "elevation_deg": grid.ELEVATION_DEG,
        "azimuth_deg": grid.AZIMUTH_DEG,
        "sun_deg": grid.SUN_DEG,
        "haze": grid.HAZE,
        "fine_nm": FINE_NM,
        "rayleigh_depth": rayleigh_cross_section_m2(FINE_NM) * column,
        "ozone_depth_per_du": ozone_per_du(FINE_NM, 1.0),
        "haze_depth": np.exp(np.interp(np.log(FINE_NM), np.log(grid.WAVELENGTH_NM), np.log(total))),
        "haze_scattered": scattered,
        "haze_phase": phase[:, ::2, 0].astype(np.float32),
        "anisotropy": rayleigh_anisotropy(grid.WAVELENGTH_NM),
        "mass_deg": MASS_DEG,
        "mass": _air_masses(),
    }


def sun_parts() -> dict[str, np.ndarray]:
    """The sun above the air: means of W m-2 nm-1 between edges, a tenth of a nanometre apart, half
    a nanometre beyond all bands. Its lines are finer than bands' samples."""
    nm, watts = sun_spectrum()
    up_to = np.concatenate([[0], np.cumsum(np.diff(nm) * 0.5 * (watts[1:] + watts[:-1]))])
    edges = np.linspace(FINE_NM[0] - 0.5, FINE_NM[-1] + 0.5, 4011)
    means = np.diff(np.interp(edges, nm, up_to)) / np.diff(edges)
    return {"edges_nm": edges, "watts": means.astype(np.float32)}


def haze_parts() -> dict[str, np.ndarray]:
    """Extinction over that at 550 nm, share scattered, P11 and P12 of every kind of haze, the
    tables' own among them."""
    total, scattered, phase, _ = haze_optics(tuple(grid.WAVELENGTH_NM))
    parts = {}
    kinds = {"rural": (total, scattered, phase)}
    kinds |= {kind: haze_kinds.optics(kind, grid.WAVELENGTH_NM) for kind in haze_kinds.STORED}
    for kind, (depth, share, matrix) in kinds.items():
        parts |= {f"{kind}_depth": depth, f"{kind}_scattered": share}
        for k, name in enumerate(("phase", "linear")):
            parts[f"{kind}_{name}"] = matrix[:, ::2, k].astype(np.float32)
    return parts


def height_parts(folder: Path) -> dict[str, np.ndarray]:
    """What high ground changes of clean skies under low suns: log I, Q/I and U/I are those at sea
    level + a x + b x^2, x the height over the highest one.

    "change" has [a or b, sun, (log I, Q/I, U/I), wavelength, few elevations, few azimuths], the
    others what takes these to all: a cubic spline in a measure of the air's mass, cosines in
    azimuth, and for U sines of it.
    """
    fields = []
    for height in grid.HEIGHT_M:
        every = [
            np.load(folder / f"height_{height:g}_{e:g}.npz")["stokes"]
            for e in grid.HEIGHT_ELEVATION_DEG
        ]
        i, q, u = np.moveaxis(np.array(every), (3, 4), (0, 1))  # each [wavelength, e, sun, azimuth]
        fields.append(np.moveaxis([np.log(i), q / i, u / i], 3, 0))
    x = grid.HEIGHT_M[1:] / grid.HEIGHT_M[-1]
    change = np.array(fields[1:]) - fields[0]
    solved = np.tensordot(np.linalg.inv(np.stack([x, x**2], axis=1)), change, axes=1)
    measure, nodes = (np.arcsinh(e / 4) for e in (grid.ELEVATION_DEG, grid.HEIGHT_ELEVATION_DEG))
    from scipy.interpolate import CubicSpline

    few, every = (np.radians(a)[:, None] for a in (grid.HEIGHT_AZIMUTH_DEG, grid.AZIMUTH_DEG))
    order = np.arange(len(few))
    even = np.cos(every * order) @ np.linalg.inv(np.cos(few * order))
    odd = np.sin(every * order[1:-1]) @ np.linalg.pinv(np.sin(few * order[1:-1]))
    return {
        "sun_deg": grid.HEIGHT_SUN_DEG,
        "change": solved.astype(np.float32),
        "elevation": CubicSpline(nodes, np.eye(len(nodes)))(measure),
        "azimuth": np.stack([even, even, odd]),
    }


def _air_masses() -> np.ndarray:
    """Columns along the sun's ray over those upwards: air, ozone, haze by MASS_DEG."""
    height = np.linspace(0, 1, 2001) ** 3 * 100e3
    middle = 0.5 * (height[1:] + height[:-1])
    sine = np.sin(np.radians(MASS_DEG))[:, None]
    radius = EARTH_RADIUS_M
    # Along the ray to a height: sqrt(r^2 - R^2 cos^2 e) - R sin e.
    along = np.sqrt((radius + height) ** 2 - radius**2 * (1 - sine**2)) - radius * sine
    masses = []
    for profile in (air_density, ozone_profile, lambda h: np.exp(-h / HAZE_SCALE_HEIGHT_M)):
        values = profile(middle)
        masses.append(np.diff(along) @ values / (np.diff(height) @ values))
    return np.array(masses)


def _fields(folder: Path, parts: dict[str, np.ndarray], haze: float) -> np.ndarray:
    """[sun, (log I over its first guess, Q/I, U/I), wavelength, elevation, azimuth]."""
    fields = []
    for sun, missed in zip(grid.ORDINATES_SUN_DEG, _missed(folder)):
        flat = _ordinates(folder, haze, sun)
        whole = flat + missed * _level(flat)
        fields.append(_relative(whole, parts, haze, sun, grid.AZIMUTH_DEG))
    azimuths = grid.MONTE_CARLO_AZIMUTH_DEG
    for name, suns in (("low", grid.LOW_SUN_DEG), ("twilight", grid.TWILIGHT_SUN_DEG)):
        stokes, error = _monte_carlo(folder, name, haze)
        for i, sun in enumerate(suns):
            rough = _relative(stokes[:, i], parts, haze, sun, azimuths)
            noise = error[:, i, :, 0] / np.maximum(stokes[:, i, :, 0], 1e-300)
            noise = np.moveaxis(noise, -1, 0)
            fields.append(_smooth(rough, noise, azimuths, *SMOOTH_DEGREE[name]))
    return np.array(fields)


def _monte_carlo(folder: Path, name: str, haze: float) -> tuple[np.ndarray, np.ndarray]:
    """Stokes and standard errors, [elevation, sun, azimuth, 3, wavelength]."""
    pieces = [np.load(folder / f"{name}_{haze:g}_{e:g}.npz") for e in grid.ELEVATION_DEG]
    return np.stack([one["stokes"] for one in pieces]), np.stack([one["error"] for one in pieces])


def _ordinates(folder: Path, haze: float, sun_deg: float) -> np.ndarray:
    """Stokes [elevation, azimuth, 3, wavelength]."""
    return np.load(folder / f"ordinates_{haze:g}_{sun_deg:g}.npz")["stokes"]


def _level(stokes: np.ndarray) -> np.ndarray:
    """One radiance for each elevation, [elevation, 1, 1, wavelength]."""
    return np.median(stokes[:, :, 0], axis=1)[:, None, None]


@functools.lru_cache(maxsize=1)
def _missed(folder: Path) -> np.ndarray:
    """What discrete ordinates miss, [sun, elevation, azimuth, 3, wavelength]: in round air less
    light is scattered often than in their flat air. Monte Carlo less them, smoothed.

    Relative to one radiance for each elevation, as light scattered often is even where light
    scattered once is not. It is that of air alone, and taken for hazy air as well.
    """
    every = []
    stokes, error = _monte_carlo(folder, "high", 0.0)
    some = np.isin(grid.AZIMUTH_DEG, grid.HIGH_AZIMUTH_DEG)
    for i, sun in enumerate(grid.ORDINATES_SUN_DEG):
        flat = _ordinates(folder, 0.0, sun)
        rough = np.moveaxis((stokes[:, i] - flat[:, some]) / _level(flat), (2, 3), (0, 1))
        noise = np.moveaxis(error[:, i, :, 0] / _level(flat)[:, :, 0], -1, 0)
        smooth = _smooth(rough, noise, grid.HIGH_AZIMUTH_DEG, *SMOOTH_DEGREE["high"])
        every.append(np.moveaxis(smooth, (0, 1), (2, 3)))
    return np.array(every)


def _relative(
    stokes: np.ndarray,
    parts: dict[str, np.ndarray],
    haze: float,
    sun_deg: float,
    azimuth_deg: np.ndarray,
) -> np.ndarray:
    """Stokes [elevation, azimuth, 3, wavelength] as fields [3, wavelength, elevation, azimuth]."""
    from omma.light.sky_stored import first_guess

    guess = first_guess(parts, haze, sun_deg, grid.ELEVATION_DEG, azimuth_deg)
    i, q, u = np.moveaxis(stokes, (2, 3), (0, 1))
    return np.array([np.log(i / guess), q / i, u / i])


def _smooth(
    rough: np.ndarray, noise: np.ndarray, azimuth_deg: np.ndarray, degree: int, harmonics: int
) -> np.ndarray:
    """The fields on all azimuths: polynomials of elevation times harmonics of azimuth, fitted.

    Of what the fit leaves, the share that is more than noise is kept, by wavelength: low in the red
    the sky has more structure than the fit, and Monte Carlo little noise there.
    """
    x = np.arcsinh(grid.ELEVATION_DEG / 4)
    up = np.polynomial.chebyshev.chebvander(2 * x / x[-1] - 1, degree)
    result = []
    for k, field in enumerate(rough):
        some, every = (
            _harmonics(a, k == 2, len(azimuth_deg)) for a in (azimuth_deg, grid.AZIMUTH_DEG)
        )
        turned = field @ np.linalg.pinv(some).T  # [wavelength, elevation, harmonic]
        smooth = np.zeros_like(turned)
        for nm in range(len(field)):
            weight = 1 / np.maximum(noise[nm].mean(axis=-1), 1e-3)[:, None]
            few = turned[nm, :, :harmonics]
            smooth[nm, :, :harmonics] = (
                up @ np.linalg.lstsq(weight * up, weight * few, rcond=None)[0]
            )
        left = np.mean((field - smooth @ some.T) ** 2, axis=(1, 2))
        kept = np.clip(1 - np.mean(noise**2, axis=(1, 2)) / np.maximum(left, 1e-30), 0, 1)
        result.append((smooth + kept[:, None, None] * (turned - smooth)) @ every.T)
    return np.array(result)


def _harmonics(azimuth_deg: np.ndarray, odd: bool, count: int) -> np.ndarray:
    """Cosines of azimuth, or sines for what changes sign: as many as so many nodes tell apart."""
    angle = np.radians(azimuth_deg)[:, None]
    return np.sin(angle * np.arange(1, count - 1)) if odd else np.cos(angle * np.arange(count))


def _ground(
    folder: Path, parts: dict[str, np.ndarray], haze: float
) -> tuple[np.ndarray, np.ndarray]:
    """What the ground's radiance adds to I and Q, [2, wavelength, elevation], and what comes back.

    Over albedo A the ground gets E0 / (1 - A s); so skies over 0, 0.5 and 1 give s, and the two
    over 0 and 0.5 with E0 the rest.
    """
    black, half, white = (
        np.load(folder / f"ground_{haze:g}_{a:g}.npz")["stokes"] for a in (0.0, 0.5, 1.0)
    )
    one, two = (half - black).mean(axis=1), (white - black).mean(axis=1)  # over azimuths
    ratio = np.median(two[:, 0] / one[:, 0], axis=0)
    returned = (ratio - 2) / (ratio - 1)
    sun = np.load(folder / f"ordinates_{haze:g}_{grid.GROUND_SUN_DEG:g}.npz")["stokes"][:, :, 0]
    fine = np.radians(np.linspace(0, 90, 181))
    from scipy.interpolate import CubicSpline

    over = CubicSpline(np.radians(grid.ELEVATION_DEG), sun)(fine)
    around = np.trapezoid(over, np.radians(grid.AZIMUTH_DEG), axis=1) * 2
    sky = np.trapezoid(around * (np.sin(fine) * np.cos(fine))[:, None], fine, axis=0)
    nm = parts["wavelength_nm"]
    depth = [
        np.interp(nm, FINE_NM, parts["rayleigh_depth"]),
        300 * ozone_per_du(nm),
        haze * np.interp(nm, FINE_NM, parts["haze_depth"]),
    ]
    mass = [np.interp(grid.GROUND_SUN_DEG, MASS_DEG, m) for m in parts["mass"]]
    direct = np.exp(-np.array(mass) @ np.array(depth)) * np.sin(np.radians(grid.GROUND_SUN_DEG))
    shine = 0.5 * (sky + direct) / (1 - 0.5 * returned) / np.pi
    return np.stack([(one[:, k] / shine).T for k in (0, 1)]), returned


def _ozone(folder: Path) -> dict[str, np.ndarray]:
    """log I, Q/I and U/I = those of 300 DU + a x + b x^2, x = (DU - 300) / 300.

    "ozone" has [a or b, sun, (log I, Q/I, U/I), wavelength, few elevations, few azimuths], the
    others what takes these to all: a cubic in a measure of the air's mass, cosines in azimuth, and
    for U sines of it and of its double, which stand in the place of the first azimuth.
    """
    fields = []
    for ozone in grid.OZONE_DU:
        high = [
            np.load(folder / f"ozone_{ozone:g}_{sun:g}.npz")["stokes"]
            for sun in grid.ORDINATES_SUN_DEG
        ]
        low = [
            np.load(folder / f"ozone_{ozone:g}_low_{e:g}.npz")["stokes"]
            for e in grid.OZONE_ELEVATION_DEG
        ]
        both = np.concatenate([np.array(high), np.array(low).transpose(1, 0, 2, 3, 4)])
        i, q, u = np.moveaxis(both, 3, 0)  # each [sun, elevation, azimuth, wavelength]
        i = np.maximum(i, 1e-300)
        fields.append(np.stack([np.log(i), q / i, u / i], axis=1))
    x = (grid.OZONE_DU[[0, 2]] - 300) / 300
    change = np.stack([fields[0] - fields[1], fields[2] - fields[1]])
    solved = np.tensordot(np.linalg.inv(np.stack([x, x**2], axis=1)), change, axes=1)
    measure = np.log(np.sin(np.radians(grid.ELEVATION_DEG)) + 0.05)
    nodes = np.log(np.sin(np.radians(grid.OZONE_ELEVATION_DEG)) + 0.05)
    up = np.vander(measure, 4) @ np.linalg.inv(np.vander(nodes, 4))
    few = np.cos(np.radians(grid.OZONE_AZIMUTH_DEG)[:, None] * np.arange(3))
    every = np.cos(np.radians(grid.AZIMUTH_DEG)[:, None] * np.arange(3))
    even = every @ np.linalg.inv(few)
    # U is 0 ahead and behind, and tells at 90° of the sine alone. What goes with the sine of twice
    # the azimuth is by Rayleigh's phase matrix 2 mu / (1 + mu^2) of what Q has with the cosine, mu
    # the sine of elevation (Chandrasekhar 1960, Radiative Transfer, section 17; recalled. The test
    # of tables between nodes holds it: without it U is 0.007 off 65° up at 312 nm, with it 0.0013).
    mu = np.sin(np.radians(grid.OZONE_ELEVATION_DEG))
    twice = np.einsum("z,ksezn->ksen", np.linalg.inv(few)[2], solved[:, :, 1])
    solved[:, :, 2, :, 0] = (2 * mu / (1 + mu**2))[:, None] * twice
    # In twilight what Monte Carlo tells of it is noise.
    solved[:, np.isin(grid.SUN_DEG, grid.TWILIGHT_SUN_DEG), 1:] = 0
    round_ = np.radians(grid.AZIMUTH_DEG)
    odd = np.stack([np.sin(2 * round_), np.sin(round_), 0 * round_], axis=1)
    return {
        "ozone": np.moveaxis(solved, -1, 3).astype(np.float32),
        "ozone_elevation": up,
        "ozone_azimuth": np.stack([even, even, odd]),
    }
