"""What the commands of ``omma eye`` share: eye files in and out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np

from omma._core import Eye
from omma.base.files import check_ending
from omma.cli.parameters import argument, option, out
from omma.cli.working import check_outputs, say, warn
from omma.eye.change import is_left, pair_of_eyes, place_on_head
from omma.eye.files import EYE_SUFFIXES, save_eye


def eye_target(path: Path | None) -> Path | None:
    """The name of an eye file that is to be written; an error now where it will not do."""
    if path is not None:
        check_ending(path, *EYE_SUFFIXES)
        check_outputs(path)
    return path


EyeArgument = Annotated[Path, argument("Eye file.", "EYE")]
EyesArgument = Annotated[list[Path], argument("Eye file; several make one head.", "EYE")]
OutOption = Annotated[
    Path, out("Eye file to write: .csv, .gltf, .glb or .eye.", callback=eye_target)
]
UnitOption = Annotated[
    str, option("Unit of lengths in .eye files: mm, um, m or a number of metres.", "UNIT")
]


def save(path: Path, eye: Eye, unit: str) -> None:
    """Write an eye file and say what is in it."""
    save_eye(path, eye, unit, lossy=True)
    # What the file's next user wants to know, so that a wrong unit is seen at once.
    radius_mm = 1e3 * float(np.linalg.norm(eye.position_m.astype(np.float64), axis=1).mean())
    degrees = np.degrees(eye.acceptance_angle_rad.astype(np.float64))
    low, high = f"{degrees.min():.4g}", f"{degrees.max():.4g}"
    say(
        f"wrote {path}: {len(eye):,} ommatidia, mean radius {radius_mm:.4g} mm, acceptance "
        + (f"{low}°" if low == high else f"{low} to {high}°")
    )


def head_of(eye: Eye) -> Eye:
    """The eye and its mirror image, with a warning where they interpenetrate, which is where one
    reaches over the midline."""
    side, other, sign = ("left", "right", -1) if is_left(eye) else ("right", "left", 1)
    over = int((sign * eye.position_m[:, 0] < 0).sum())
    if over:
        warn(
            f"--pair: the eyes interpenetrate: {over:,} of {len(eye):,} ommatidia of the {side} "
            f"one sit {other} of the midline; omma eye place moves it before it is paired"
        )
    return pair_of_eyes(eye)


def clear_of_midline(eye: Eye) -> Eye:
    """The eye moved to its side until all of it is beside the midline, with a gap of a twentieth
    of its width; as it is where that holds or all its ommatidia are at a point."""
    sign = -1 if is_left(eye) else 1
    x = sign * eye.position_m[:, 0].astype(np.float64)
    width = float(np.ptp(x))
    if width == 0 or x.min() >= 0:
        return eye
    return place_on_head(eye, (sign * (0.05 * width - float(x.min())), 0.0, 0.0))
