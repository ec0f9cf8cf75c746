"""Gaussian splats on the page: where they are, how large, in which colours."""

import numpy as np
import pytest

import omma
from omma.scene import SplatCloud

pytest.importorskip("viser", reason="pip install 'omma[view]'")
from omma.view import splat_scene
from omma.view.scene_mesh import drawn_scene


def cloud(**more):
    """Two splats of which the first is half as long as the axis it lies along."""
    return SplatCloud(
        [(1, 0, 0), (0, 0, 0)],
        [(0.5, 0.1, 0.2), (0.1, 0.1, 0.1)],
        [(0, 0, 0, 1), (0, 0, 0, 1)],
        [0.5, 1.0],
        np.zeros((2, 4, 3)),
        **more,
    )


def test_they_are_drawn_where_they_are():
    turned = np.eye(4)
    turned[:3, :3] = 2 * np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    turned[:3, 3] = 5, 0, 0
    (drawn,), note = splat_scene.drawn_splats(omma.Scene(splats=[cloud(world_from_splats=turned)]))
    assert note == ""
    assert drawn.centers == pytest.approx(np.array([(5, 2, 0), (5, 0, 0)]))
    assert drawn.covariances[0] == pytest.approx(np.diag([0.04, 1, 0.16]), abs=1e-6)
    assert drawn.rgbs == pytest.approx(0.5)
    assert drawn.opacities.ravel() == pytest.approx([0.5, 1])


def test_linear_colours_are_shown_as_pictures_are():
    scene = omma.Scene(splats=[cloud(color_space="linear")])
    (drawn,), _ = splat_scene.drawn_splats(scene)
    # As the pictures beside them, in steps of 1/255.
    assert drawn.rgbs == pytest.approx(0.5 ** (1 / 2.2), abs=0.002)


def test_of_many_some_are_drawn(monkeypatch):
    monkeypatch.setattr(splat_scene, "MOST_SPLATS", 1)
    (drawn,), note = splat_scene.drawn_splats(omma.Scene(splats=[cloud()]))
    assert len(drawn.centers) == 1
    assert note == "one of 2 Gaussian splats is drawn"


def test_meshes_are_drawn_without_them():
    scene = omma.scene.merge_scenes([omma.scene.box(), omma.Scene(splats=[cloud()])])
    assert b"KHR_gaussian_splatting" not in drawn_scene(omma.World(scene)).still
