"""Splats that are left out: floaters and the sky."""

import numpy as np
import pytest
from splat_files import ARRAYS, RDF_TO_RUB, some_splats

import omma
from omma.scene import cull_splats


def test_floaters_are_culled():
    splats = some_splats(400)
    matrix = splats.world_from_splats
    world = splats.positions_m @ matrix[:3, :3].T
    scan = world[:200:2]
    culled, counts = cull_splats(splats, least_opacity=0.3, scan=scan, distance_m=0.2)
    faint = splats.opacities < 0.3
    distance = np.linalg.norm(world[:, None] - scan[None], axis=2).min(axis=1)
    far = ~faint & (distance > 0.2)
    assert counts == {"opacity": faint.sum(), "distance": far.sum()}
    assert far.sum() > 20
    assert np.array_equal(culled.positions_m, splats.positions_m[~faint & ~far])
    assert np.array_equal(culled.harmonics, splats.harmonics[~faint & ~far])
    # A survey's points, far from zero.
    shift = np.array([4e5, 100, -5.8e6])
    cloud = omma.scene.PointCloud(scan.astype(np.float32), shift)
    placed = matrix.copy()
    placed[:3, 3] = shift
    moved = splats.replace(world_from_splats=placed)
    same, _ = cull_splats(moved, least_opacity=0.3, scan=cloud, distance_m=0.2)
    assert np.array_equal(same.positions_m, culled.positions_m)
    assert cull_splats(splats) == (splats, {})


def test_culling_refuses_nonsense():
    splats = some_splats(10)
    for more, message in (
        ({"scan": np.zeros((1, 3))}, "scan and distance_m together"),
        ({"distance_m": 1.0}, "scan and distance_m together"),
        ({"scan": np.zeros((0, 3)), "distance_m": 1.0}, "scan: expected points"),
        ({"scan": np.full((1, 3), np.nan), "distance_m": 1.0}, "finite"),
        ({"scan": np.zeros((1, 3)), "distance_m": -1.0}, "distance_m"),
        ({"least_opacity": 2.0}, "least_opacity"),
        ({"beyond_m": -1.0}, "beyond_m"),
        ({"center_m": (0, np.nan, 0)}, "center_m"),
        ({"above_m": np.nan}, "above_m"),
        ({"least_opacity": 1.0}, r"found none of 10 \(opacity: 10\)"),
    ):
        with pytest.raises(omma.Error, match=message):
            cull_splats(splats, **more)


def test_sky_is_culled():
    splats = some_splats(400)
    world = splats.positions_m @ RDF_TO_RUB[:3, :3].T
    center = np.array([0.5, 1.0, -0.2])
    culled, counts = cull_splats(splats, beyond_m=1.5, center_m=center, above_m=0.8)
    beyond = np.linalg.norm(world - center, axis=1) > 1.5
    above = ~beyond & (world[:, 1] > 0.8)
    assert counts == {"beyond": beyond.sum(), "above": above.sum()}
    assert min(counts.values()) > 20
    assert culled == splats.replace(
        **{name: getattr(splats, name)[~beyond & ~above] for name in ARRAYS}
    )
