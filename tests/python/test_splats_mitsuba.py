"""Gaussian splats beside Mitsuba 3's volumetric primitives, on the same rays.

Its shape `ellipsoids` and its integrator `volprim_rf_basic` have the same response (once for each
splat, at its peak along the ray, opacity times a Gaussian), the same harmonics with 0.5 added and
no less than 0, and composite front to back. Where it differs, and what is done about it:

- colours depend on the ray's own direction: `direction="ray"` here;
- display sums are decoded from sRGB at the end of the ray: not with `srgb_primitives` off, and
  `color_space="linear"` here;
- a splat ends at an extent in standard deviations (3), ours where α is 1/255: all have one opacity,
  and the extent at which that is so;
- α is 0.9999 at most, ours 0.99: the opacity is below;
- a ray ends where less than 0.01 gets through, ours 1e-4: only rays that keep more are compared;
- splats that a ray starts in are not seen: rays start outside;
- the ray goes on a little behind the point where it entered a splat, and splats entered within that
  are passed over: splats are large here;
- splats are in the order in which the ray enters their extents, ours in that of their peaks. It is
  the same where splats lie one behind another; where they overlap some rays differ.

Needs `pip install 'omma[peers]'`, and libLLVM (DRJIT_LIBLLVM_PATH).
"""

import numpy as np
import pytest

import omma
from omma.scene import SplatCloud

mi = pytest.importorskip("mitsuba")
drjit = pytest.importorskip("drjit")

VARIANT = "llvm_ad_rgb"
OPACITY = 0.6
LEAST_ALPHA = 1 / 255
THEIR_LEAST_TRANSMITTANCE = 0.01
SIDE = 48


@pytest.fixture(autouse=True)
def variant():
    """Mitsuba ready with its splats, or a test that is skipped."""
    if VARIANT not in mi.variants():
        pytest.skip(f"this Mitsuba has no {VARIANT}")
    try:
        mi.set_variant(VARIANT)
        drjit.eval(drjit.arange(mi.Float, 2))
    except Exception as error:  # drjit raises several kinds where libLLVM is missing
        pytest.skip(f"Mitsuba's {VARIANT} does not run here: {error}")
    try:
        mi.load_dict({"type": "volprim_rf_basic"})
    except RuntimeError as error:
        pytest.skip(f"this Mitsuba has no volumetric primitives: {error}")


def extent_of(opacity):
    """Standard deviations at which α is the least that counts."""
    return np.sqrt(2 * np.log(opacity / LEAST_ALPHA))


def camera(field_deg):
    """Rays through the centres of SIDE x SIDE pixels, ahead, (N, 3)."""
    place = ((np.arange(SIDE) + 0.5) / SIDE * 2 - 1) * np.tan(np.radians(field_deg / 2))
    x, y = np.meshgrid(place, -place)
    axes = np.stack([x, y, -np.ones_like(x)], axis=-1).reshape(-1, 3)
    return axes / np.linalg.norm(axes, axis=1, keepdims=True)


def cloud_at(positions, scales, terms, seed):
    rng = np.random.default_rng(seed)
    count = len(positions)
    rotations = rng.normal(size=(count, 4))
    return SplatCloud(
        positions,
        scales,
        rotations / np.linalg.norm(rotations, axis=1, keepdims=True),
        np.full(count, OPACITY),
        rng.uniform(-0.5, 0.5, (count, terms, 3)),
        color_space="linear",
        direction="ray",
    )


def one_behind_another(terms, count=12, seed=3):
    """Splats of which each has a range of distances to itself, 1 to 20 m, within 3°."""
    rng = np.random.default_rng(seed)
    edges = np.linspace(20, 80, count + 1)
    distance = (edges[1:] + edges[:-1]) / 2
    most = 0.45 * np.diff(edges) / extent_of(OPACITY)
    axes = np.append(
        rng.uniform(-1, 1, (count, 2)) * np.tan(np.radians(1.5)), -np.ones((count, 1)), 1
    )
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    scales = most[:, None] * rng.uniform(0.4, 1, (count, 3))
    return cloud_at(axes * distance[:, None], scales, terms, seed)


def overlapping(terms, count=400, seed=4):
    """Splats of all shapes in a ball of 20 m, 60 m ahead."""
    rng = np.random.default_rng(seed)
    positions = rng.normal(size=(count, 3))
    positions *= 20 * rng.random((count, 1)) ** (1 / 3) / np.linalg.norm(positions, axis=1)[:, None]
    return cloud_at(positions + (0, 0, -60), np.exp(rng.uniform(-1, 0.5, (count, 3))), terms, seed)


def ours(splats, axes):
    """(N, 3), what rays see, and (N,), what gets through."""
    zero = np.zeros_like(axes)
    eye = omma.Eye(zero, axes, zero[:, 0])

    def seen(behind):
        scene = omma.Scene(splats=[splats], background=omma.Background.constant([behind] * 3))
        return omma.Renderer(omma.World(scene), eye, omma.Fixed(1)).render(np.eye(4))[0]

    found = seen(0.0)
    return found, (seen(1.0) - found)[:, 0]


def theirs(splats, axes):
    """The same rays through Mitsuba, (N, 3)."""
    scene = mi.load_dict(  # kept until what is traced in it has been evaluated
        {
            "type": "scene",
            "splats": {
                "type": "ellipsoids",
                "centers": mi.TensorXf(splats.positions_m),
                "scales": mi.TensorXf(splats.scales_m),
                "quaternions": mi.TensorXf(splats.rotations),
                "extent": float(extent_of(OPACITY)),
                "opacities": mi.TensorXf(splats.opacities[:, None]),
                "sh_coeffs": mi.TensorXf(splats.harmonics.reshape(len(splats.opacities), -1)),
            },
        }
    )
    integrator = mi.load_dict(
        {"type": "volprim_rf_basic", "max_depth": 128, "srgb_primitives": False}
    )
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(0, len(axes))
    rays = mi.RayDifferential3f(
        mi.Point3f(0), mi.Vector3f(np.ascontiguousarray(axes.T, np.float32))
    )
    found = integrator.sample(drjit.ADMode.Primal, scene, sampler, rays, None, None, mi.Bool(True))[
        0
    ]
    return np.array(found).T


def differences(splats, field_deg):
    """What rays see in Mitsuba, and how far ours is from it in any channel, where both go on."""
    axes = camera(field_deg)
    found, through = ours(splats, axes)
    other = theirs(splats, axes)
    on = through > 1.01 * THEIR_LEAST_TRANSMITTANCE
    assert on.mean() > 0.9
    return other[on], np.abs(found - other)[on].max(axis=1)


@pytest.mark.parametrize("terms", [1, 16])
def test_one_behind_another(terms):
    """To single precision, but for rays at the edge of a splat, which counts for one alone."""
    other, off = differences(one_behind_another(terms), 4)
    assert other.mean() > 0.2
    assert np.sum(off > 1e-5) <= 5
    assert off.max() < 1.5 * LEAST_ALPHA


@pytest.mark.parametrize("terms", [1, 16])
def test_overlapping(terms):
    """Rays that enter splats in the order of their peaks see the same; in the mean all do."""
    other, off = differences(overlapping(terms), 40)
    assert np.median(off) < 1e-6
    assert off.mean() < 0.02 * other.mean()
