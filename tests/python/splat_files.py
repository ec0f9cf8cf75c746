"""Files of Gaussian splats for tests, and what they are to hold."""

import numpy as np
import splat_bytes

from omma.scene import SplatCloud

TERMS = (1, 4, 9, 16)


RDF_TO_RUB = np.diag([1.0, -1.0, -1.0, 1.0])


ARRAYS = ("positions_m", "scales_m", "rotations", "opacities", "harmonics")


def expected(columns):
    """What 3DGS makes of its columns (scene/gaussian_model.py)."""
    terms = 1 + sum(name.startswith("f_rest") for name in columns) // 3
    count = len(columns["x"])
    double = {name: values.astype(float) for name, values in columns.items()}
    rest = [double[f"f_rest_{k}"] for k in range(3 * terms - 3)]
    harmonics = np.empty((count, terms, 3))
    for channel in range(3):
        harmonics[:, 0, channel] = double[f"f_dc_{channel}"]
        for k in range(terms - 1):
            harmonics[:, 1 + k, channel] = rest[channel * (terms - 1) + k]
    quaternions = np.stack([double[f"rot_{k}"] for k in (1, 2, 3, 0)], axis=1)
    return {
        "positions_m": np.stack([double[axis] for axis in "xyz"], axis=1),
        "scales_m": np.exp(np.stack([double[f"scale_{k}"] for k in range(3)], axis=1)),
        "rotations": quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True),
        "opacities": 1 / (1 + np.exp(-double["opacity"])),
        "harmonics": harmonics,
    }


def check(found, wanted, in_logs=False, **tolerances):
    for name in ARRAYS:
        values = getattr(found, name)
        assert values.dtype == np.float32
        want = wanted[name]
        if name == "scales_m" and in_logs:
            values, want = np.log(values), np.log(want)
        if name == "rotations":  # q and -q turn alike
            want = want * np.sign((values * want).sum(axis=1, keepdims=True))
        # Single precision, where a test does not say more.
        np.testing.assert_allclose(
            values, want, rtol=1e-5, atol=tolerances.get(name, 1e-6), err_msg=name
        )


def saved(tmp_path, name, data):
    path = tmp_path / name
    path.write_bytes(data)
    return path


def ply_of(tmp_path, columns, name="place.ply", **more):
    data = splat_bytes.ply({"vertex": splat_bytes.floats(columns)}, **more)
    return saved(tmp_path, name, data)


def check_spz(splats, wanted, step, turn):
    """Half a step of each byte; of rotations what a largest component makes of it."""
    check(
        splats,
        wanted,
        in_logs=True,
        positions_m=step * 1.001,
        scales_m=1 / 32 * 1.001,
        rotations=turn,
        opacities=0.5 / 255 * 1.001,
        harmonics=0.5 / 255 / 0.15 * 1.001,
    )


def some_splats(count=300, terms=16, seed=2):
    rng = np.random.default_rng(seed)
    quaternions = rng.normal(size=(count, 4))
    return SplatCloud(
        rng.normal(size=(count, 3)).astype(np.float32),
        np.exp(rng.normal(size=(count, 3)) - 2).astype(np.float32),
        (quaternions / np.linalg.norm(quaternions, axis=1)[:, None]).astype(np.float32),
        rng.uniform(0.01, 0.99, count).astype(np.float32),
        rng.uniform(-0.9, 0.9, (count, terms, 3)).astype(np.float32),
        world_from_splats=RDF_TO_RUB,
    )


def arrays_of(splats):
    return {name: getattr(splats, name).astype(float) for name in ARRAYS}
