"""Haze, as it is set from Python."""

import pickle

import numpy as np
import pytest

import omma
from omma.scene.baked_files import scene_digest


def test_haze_leaves_exp_of_the_way():
    wall = omma.scene.plane((4, 4)).replace(extinction_per_m=0.4)
    assert wall.extinction_per_m == 0.4
    clear = wall.replace(extinction_per_m=0)
    eye = omma.Eye([[0, 3.0, 0]], [[0, -1.0, 0]], 0.0)
    hazy, open_ = (
        omma.Renderer(omma.World(one), eye, omma.Fixed(1)).render(np.eye(4))
        for one in (wall, clear)
    )
    assert hazy == pytest.approx(open_ * np.exp(-1.2), rel=2e-6)  # single precision
    assert pickle.loads(pickle.dumps(wall)) == wall != clear
    assert scene_digest(wall) != scene_digest(clear)
    assert omma.scene.merge_scenes([wall, clear]).extinction_per_m == 0.4


@pytest.mark.parametrize("wrong", [-1, float("nan"), 2e6])
def test_wrong_haze(wrong):
    with pytest.raises(omma.Error, match="extinction_per_m: expected"):
        omma.Scene(extinction_per_m=wrong)
