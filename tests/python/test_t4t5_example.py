"""The worked example of a network of the fly's motion pathway: its lattice, its filters against
steps one by one, its measures in closed form, and that a small one becomes selective."""

import importlib
from pathlib import Path

import numpy as np
import pytest

import omma

torch = pytest.importorskip("torch", reason="needs PyTorch: pip install 'omma[torch]'")
pytest.importorskip("matplotlib", reason="the examples draw figures")
EXAMPLES = Path(__file__).resolve().parents[2] / "examples" / "python"


@pytest.fixture
def example(monkeypatch):
    monkeypatch.syspath_prepend(EXAMPLES)
    torch.set_num_threads(1)
    return importlib.import_module("t4t5")


def test_neighbours_lie_where_their_numbers_say(example):
    eye, around, inner = example.column_lattice(3)
    assert (len(eye), inner.sum()) == (37, 19)
    assert (around[:, 0] == np.arange(37)).all()
    place = np.stack(omma.eye.azimuth_elevation_deg_of(eye.axis), axis=1)
    steps = place[around[inner, 1:]] - place[inner][:, None]
    angles = np.degrees(np.arctan2(steps[..., 1], steps[..., 0]))
    # On a sphere the lattice is a little bent: 15° from the middle by a degree.
    off = (angles - (30 + 60 * np.arange(6)) + 180) % 360 - 180
    assert np.abs(off).max() < 2
    np.testing.assert_allclose(np.hypot(*np.moveaxis(steps, -1, 0)), 5, rtol=0.04)


def test_filters_are_those_of_leaky_cells(example):
    """A cell whose drive stands still for a frame goes towards it by 1 - exp(-dt/τ)."""
    network = example.Network(example.column_lattice(1)[1])
    drive = torch.rand((3, 20, 4), generator=torch.Generator().manual_seed(1))
    found = network.filtered("Mi4", drive)
    tau_s = float(network.log_tau["Mi4"].detach().exp())
    assert tau_s == pytest.approx(example.TAU_S["Mi4"], rel=1e-6)
    value = drive[:, 0]
    for frame in range(20):
        value = value + (drive[:, frame] - value) * (1 - np.exp(-0.01 / tau_s))
        # Sums of twenty numbers of single precision.
        np.testing.assert_allclose(found[:, frame].detach(), value, atol=1e-5)


def test_light_that_stands_still_changes_nothing(example):
    network = example.Network(example.column_lattice(2)[1])
    rates = network(torch.full((1, 30, 19), 0.4))
    for values in rates.values():
        assert values.shape == (1, 30, 4, 19)
        assert (values > 0).all()
        np.testing.assert_allclose(values.detach().std(dim=1), 0, atol=1e-6)
        # Nor does it differ from column to column, all of which have the same strengths.
        np.testing.assert_allclose(values.detach().std(dim=3), 0, atol=1e-6)


def test_brightening_goes_to_t4_and_darkening_to_t5(example):
    network = example.Network(example.column_lattice(2)[1])
    steps = torch.full((2, 60, 19), 0.5)
    steps[0, 20:], steps[1, 20:] = 0.9, 0.1
    inputs = {}
    with torch.no_grad():
        for kind in ("T4", "T5"):
            # Without inhibition: what excites them.
            excites = torch.tensor([sign > 0 for _, sign in example.INPUTS[kind]])
            network.strength[kind][:, ~excites] = -30.0
        rates = network(steps)
    for kind, values in rates.items():
        inputs[kind] = (values[:, -1] - values[:, 0]).mean(dim=(1, 2)).numpy()
    assert inputs["T4"][0] > 0.1
    assert inputs["T5"][1] > 0.1
    # What is left below the soft threshold.
    assert abs(inputs["T4"][1]) < 0.05
    assert abs(inputs["T5"][0]) < 0.05


def test_selectivity_in_closed_form(example):
    directions = 15.0 + 30.0 * np.arange(12)
    towards = np.radians(directions - 70.0)
    index, preferred = example.selectivity(
        directions, np.stack([1 + np.cos(towards), np.ones(12), 1 + 0.5 * np.cos(towards)], axis=1)
    )
    np.testing.assert_allclose(index, [0.5, 0, 0.25], atol=1e-12)
    np.testing.assert_allclose(preferred[[0, 2]], 70.0)


def test_a_small_one_becomes_selective(example, tmp_path, monkeypatch):
    """Four directions and gratings alone, on 37 columns for 0.4 s: from world to selectivity."""
    monkeypatch.setattr(example, "FRAMES", 40)
    eye, around, inner = example.column_lattice(3)
    four = 90.0 * np.arange(4)
    stimuli, towards = example.gratings(four, (40.0,), (0.0, 4.0))
    light = example.watch(eye, stimuli, rays=8)
    assert light.shape == (8, 40, 37)
    assert (towards[::2] == 0).all()
    assert light[::2].std(dim=1).max() < 1e-6  # those that stand still
    network = example.Network(around)
    misses = example.learn(network, light, towards, inner, 110, log=lambda *told: None)
    # Told nothing, half of the stimuli are missed by 1, the length of a direction.
    assert np.mean(misses[:5]) > 0.4
    assert np.mean(misses[-5:]) < 0.1
    rates = example.tuning(network, light, inner)
    index, preferred = example.selectivity(four, rates["T4"][1::2] + rates["T5"][1::2])
    assert (index > 0.1).all()
    off = (preferred - list(example.SUBTYPES.values()) + 180) % 360 - 180
    assert np.abs(off).max() < 30
    example.draw(tmp_path / "one.png", network, misses, four,
                 {kind: values[1::2] for kind, values in rates.items()},
                 {name: {kind: values[1::2] for kind, values in rates.items()}
                  for name in ("ON", "OFF")}, 1.0)  # fmt: skip
    assert (tmp_path / "one.png").stat().st_size > 50_000
