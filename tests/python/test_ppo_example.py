"""The worked example of reinforcement learning: its estimates against a slow one, and that flies
learn, by its own PPO and by Stable-Baselines3."""

import importlib
from pathlib import Path

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="needs PyTorch: pip install 'omma[learning]'")
pytest.importorskip("gymnasium", reason="needs Gymnasium: pip install 'omma[gym]'")
EXAMPLES = Path(__file__).resolve().parents[2] / "examples" / "python"


@pytest.fixture
def example(monkeypatch):
    monkeypatch.syspath_prepend(EXAMPLES)
    return importlib.import_module("ppo_corridor")


def test_advantages_are_sums_of_what_comes(example):
    """Of λ = 1 the discounted rewards up to the end, or up to the cut-off and what the critic says
    there, less the critic's value."""
    generator = torch.Generator().manual_seed(3)
    rewards = torch.rand((6, 1), generator=generator)
    values = torch.rand((7, 1), generator=generator)
    settings = example.Settings(gamma=0.9, gae_lambda=1.0)
    ones = torch.ones((6, 1))
    for kind in ("goes on", "ends", "is cut off"):
        goes_on, not_cut = ones.clone(), ones.clone()
        last = 5
        if kind != "goes on":
            not_cut[3], last = 0, 3
        if kind == "ends":
            goes_on[3] = 0
        found = example.estimate_advantages(rewards, values, goes_on, not_cut, settings)
        for step in range(last + 1):
            ahead = range(step, last + 1)
            worth = sum(0.9 ** (k - step) * rewards[k, 0] for k in ahead)
            if kind != "ends":
                worth += 0.9 ** (last + 1 - step) * values[last + 1, 0]
            # Sums of ten numbers of single precision.
            assert found[step, 0] == pytest.approx(float(worth - values[step, 0]), abs=1e-5)


def test_flies_learn_to_follow_the_corridor(example, tmp_path):
    torch.set_num_threads(1)
    eye = example.fly_eye()
    assert len(eye) == example.OMMATIDIA
    loop = example.make_loop(eye, phase=0.0, seed=1)
    agent, flights = example.learn(loop, example.Settings(total_steps=30_000))
    curve = flights.curve(10)
    assert curve[0, 2] < 1.0  # at first some half metre
    assert curve[-1, 2] > 3.0  # in the end nearly all reach the end, 4 m
    assert (np.diff(curve[:, :2], axis=0) > 0).all()
    come, ways = example.fly(example.make_loop(eye, phase=2.5, seed=2), agent.turn, 4)
    assert come.mean() > 2.0  # a corridor that they have not seen
    example.draw(tmp_path / "one.png", [("one", curve)], ways, 2.5)
    assert (tmp_path / "one.png").stat().st_size > 20_000


def test_stable_baselines3_learns_in_the_same_environment(example):
    pytest.importorskip("stable_baselines3", reason="needs pip install 'omma[learning]'")
    torch.set_num_threads(1)
    loop = example.make_loop(example.fly_eye(), phase=0.0, seed=1)
    turn, flights = example.learn_with_stable_baselines3(loop, example.Settings(total_steps=30_000))
    curve = flights.curve(10)
    assert curve[0, 2] < 1.0
    assert curve[-1, 2] > 3.0
    come, _ = example.fly(loop, turn, 4)
    assert come.mean() > 3.0
