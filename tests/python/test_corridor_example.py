"""The worked example of a closed loop: flow tells a fly in a corridor which wall is near, and a
rule by it comes further than none."""

from pathlib import Path

import numpy as np
import pytest
from conftest import load_script

pytest.importorskip("gymnasium", reason="needs Gymnasium: pip install 'omma[gym]'")

SCRIPT = Path(__file__).resolve().parents[2] / "examples" / "python" / "corridor.py"


@pytest.fixture(scope="module")
def example():
    module = load_script(SCRIPT)
    module.LENGTH_M, module.STEPS = 1.2, 140
    return module


def test_balancing_flow_leads_on(example, tmp_path):
    loop = example.make_loop(example.fly_eyes(), phase=0.0, seed=1)
    weights = np.zeros((6, 4))
    weights[::2, 0] = 2.0  # what is learned, in short; the others do not turn
    come, ways = example.fly(loop, weights, np.repeat([1, 2, 3], 2))
    assert (come[::2] > 1.19).all()
    assert come[1::2].mean() < 0.8
    example.draw(
        tmp_path / "one.png", np.stack([come, come]), weights[:3], ways[:, 1::2], ways[:, ::2],
        0.0, 1.0,
    )  # fmt: skip
    assert (tmp_path / "one.png").stat().st_size > 30_000
