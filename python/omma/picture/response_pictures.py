"""Pictures of responses, one for each pose of each eye: what is where in them, and their titles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from omma._core import Eye
from omma.base.arrays import Flags, Floats
from omma.eye.neighbours import sides
from omma.picture.eye_maps import eye_title, known_title
from omma.picture.kept_ids import Ids
from omma.picture.projections import projection_ids, projection_size
from omma.picture.response_colours import Shown

_PIXELS = 1080  # across a picture of the whole sphere


@dataclass(frozen=True)
class Picture:
    """One picture: pixel values (H, W, K), NaN where no ommatidium is ``seen`` (H, W)."""

    values: Floats
    seen: Flags
    title: str
    is_error: bool


def pictures_of(
    eyes: Sequence[Eye],
    shown: Sequence[Shown],
    beside: Sequence[Shown] | None,
    projection: str | None,
    titles: Sequence[str] | None,
) -> list[list[list[Picture]]]:
    """For each pose of each eye its pictures and, where there are errors, theirs: lists of one for
    each eye of the head that is drawn apart."""
    entries: list[list[list[Picture]]] = []
    for k, eye in enumerate(eyes):
        maps = _id_maps(eye, projection)
        names = ["left eye", "right eye"] if len(maps) == 2 else [f"eye {e}" for e in range(9)]
        for pose in range(len(shown[k].values)):
            moment = f", pose {pose}" if len(shown[k].values) > 1 else ""
            if titles is not None:
                called = [titles[len(entries)]]
                if len(maps) > 1:
                    called = [f"{called[0]}: {each}" for each in names]
            elif len(maps) > 1:
                of_all = f"of {len(eye):,} ommatidia{moment}"
                called = [
                    f"{known_title(eye)}{name}, {_members(eye, ids):,} {of_all}"
                    for name, ids in zip(names, maps, strict=False)
                ]
            else:
                called = [eye_title(eye) + moment]
            entry = []
            for what, is_error in ((shown, False), (beside, True)):
                if what is None:
                    continue
                values = what[k].values[pose]
                entry.append(
                    [
                        Picture(
                            _painted(ids, values),
                            ids >= 0,
                            "standard error" if is_error else title,
                            is_error,
                        )
                        for ids, title in zip(maps, called, strict=True)
                    ]
                )
            entries.append(entry)
    return entries


def _members(eye: Eye, ids: Ids) -> int:
    """How many ommatidia the eye in a panel has, those too that are smaller than a pixel."""
    side = sides(eye.position_m.astype(np.float64), eye.eye_id)
    return int((side == np.bincount(side[ids[ids >= 0]]).argmax()).sum())


def _id_maps(eye: Eye, projection: str | None) -> list[Ids]:
    if projection == "single_dimension_fast":
        return [projection_ids(eye, projection)]
    width, height = projection_size(eye, projection, _PIXELS)
    ids = projection_ids(eye, projection, width, height)
    return list(np.split(ids, ids.shape[1] // width, axis=1))


def _painted(ids: Ids, values: Floats) -> Floats:
    return np.concatenate([values, np.full((1, values.shape[1]), np.nan)])[ids]
