"""Makes examples/flight.csv: a bee rises from the camera `bee` of the meadow and flies on, weaving.

python examples/make_flight.py
"""

import math
from pathlib import Path

POSES = 120


def pose(t: float) -> str:
    """One line of the file for the time t in [0, 1]: position in metres, angles in degrees."""
    x = 0.1 + 0.6 * math.sin(2 * math.pi * t)
    y = 0.38 + 0.75 * math.sin(math.pi / 2 * min(1, 1.2 * t)) ** 2
    z = 4.7 - 4.0 * t
    # Looks half-way between ahead and where it flies, and leans into the turn.
    yaw = 0.5 * math.degrees(math.atan2(0.6 * 2 * math.pi * math.cos(2 * math.pi * t), 4.0))
    return f"{x:.4f},{y:.4f},{z:.4f},{yaw:.3f},{-4 * t:.3f},{-0.4 * yaw:.3f}"


if __name__ == "__main__":
    lines = ["x,y,z,yaw_deg,pitch_deg,roll_deg"]
    lines += [pose(i / (POSES - 1)) for i in range(POSES)]
    Path(__file__).with_name("flight.csv").write_text("\n".join(lines) + "\n")
