"""Receptors of many types and few sensitivities, as flies have: each of these is rendered once."""

from functools import cache

import numpy as np
import pytest

import omma
from omma.receptors import ReceptorType
from omma.rendering.call import Call

LIGHT = omma.light.overcast_sky(30, bands=omma.light.Bands.equal(4))
# Some of many types, in a line of three ommatidia; none of 128 to 191.
RECEPTORS = [[20, 0, 1], [3, 199], [81]]


def of_many_types(peaks_nm):
    """200 types that each look their own way, of so few sensitivities."""
    types = [
        ReceptorType(
            f"R{k}",
            peak_wavelength_nm=peaks_nm[k % len(peaks_nm)],
            right_rad=1e-4 * k,
            polarisation_sensitivity=2.0,
        )
        for k in range(200)
    ]
    axis = [[0, 0, -1], [1, 0, 0], [-0.5, -0.5, -0.5]]
    return omma.Eye(
        np.zeros((3, 3)), axis, [0.1, 0.2, 0.3], receptor_types=types, receptors=RECEPTORS
    )


@pytest.fixture
def mixtures(monkeypatch):
    """How many outputs each render of mixtures has had."""
    asked = []
    render = Call.render

    def counted(self, frames, *, output_from_band=None, **how):
        if output_from_band is not None:
            asked.append(len(output_from_band))
        return render(self, frames, output_from_band=output_from_band, **how)

    monkeypatch.setattr(Call, "render", counted)
    return asked


@cache
def meadow():
    return omma.load_scene(omma.examples.lit_meadow())


def renderer_of(eye, polarized):
    scene = meadow()
    world = omma.World(scene, light=LIGHT, polarized=polarized, depth=1)
    return omma.Renderer(world, eye, omma.Fixed(16)), scene.camera("bee").world_from_camera


@pytest.mark.filterwarnings("ignore:receptors have a polarisation sensitivity")
@pytest.mark.parametrize("polarized", [False, True])
def test_each_sensitivity_is_rendered_once(polarized, mixtures):
    eye = of_many_types((344, 436, 544))
    renderer, pose = renderer_of(eye, polarized)
    found, errors = renderer.render_receptors(pose, standard_error=True)
    assert mixtures == [3]
    assert np.all(errors > 0)
    # As each sensitivity has it alone, the others' weights 0.
    matrix = omma.receptors.receptor_matrix(eye, bands=LIGHT.bands)
    for k in range(3):
        alone = np.where(np.arange(200)[:, None] % 3 == k, matrix, 0.0)
        one, error = renderer.render_receptors(pose, matrix=alone, standard_error=True)
        those = eye.receptor_type % 3 == k
        assert np.array_equal(found[:, those], one[:, those])
        assert np.array_equal(errors[:, those], error[:, those])
        assert not np.any(one[:, ~those])
    mixtures.clear()
    renderer.render_receptors(pose)
    assert mixtures == ([3] if polarized else [])


def test_a_matrix_of_ones_is_one_mixture(mixtures):
    """As `omma.detect` asks for the share of a disc."""
    renderer, pose = renderer_of(of_many_types(300 + 2 * np.arange(200)), False)
    ones = np.ones((200, len(LIGHT.bands)))
    renderer.render_receptors(pose, matrix=ones, standard_error=True)
    assert mixtures == [1]


@pytest.mark.filterwarnings("ignore:receptors have a polarisation sensitivity")
def test_mixtures_that_no_receptor_has_cost_no_render(mixtures):
    eye = of_many_types(300 + 2 * np.arange(200))
    renderer, pose = renderer_of(eye, False)
    told = []
    found, errors = renderer.render_receptors(pose, standard_error=True, progress=told.append)
    assert mixtures == [64, 64, 8]
    assert told == sorted(told)
    assert told[-1] == 1
    matrix = omma.receptors.receptor_matrix(eye, bands=LIGHT.bands)
    for k, kind in enumerate(eye.receptor_type):
        alone = np.zeros_like(matrix)
        alone[kind] = matrix[kind]
        one, error = renderer.render_receptors(pose, matrix=alone, standard_error=True)
        assert np.array_equal(one[:, k], found[:, k])
        assert np.array_equal(error[:, k], errors[:, k])


@pytest.mark.filterwarnings("ignore:receptors have a polarisation sensitivity")
def test_in_populations_too():
    """Eyes that do not have the same receptors, in groups of mixtures that are those of each."""
    eye = of_many_types(300 + 2 * np.arange(200))
    eyes = [eye.take([0]), eye.take([1, 2])]
    renderer, pose = renderer_of(eye, False)
    population = omma.Population(renderer.world, eyes, omma.Fixed(16))
    found, errors = population.render_receptors(pose, standard_error=True)
    for k, one in enumerate(eyes):
        alone = renderer.with_eye(one).render_receptors(pose, standard_error=True)
        assert np.array_equal(found[k], alone[0])
        assert np.array_equal(errors[k], alone[1])
