"""Id maps that are kept: which ommatidium each pixel of a picture shows, made once for an eye."""

from __future__ import annotations

import hashlib
import threading
from collections import OrderedDict
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from omma._core import Eye

Ids = NDArray[np.int32]

_MOST_KEPT_BYTES = 1 << 28


def kept_ids(eye: Eye, picture: tuple[object, ...], make: Callable[[], Ids]) -> Ids:
    """The id map of this eye and this kind of picture, made at the first call and then kept.

    Eyes are told apart by what is in them, so that no map is ever that of another eye; the maps
    used last are kept, up to a quarter of a gigabyte.
    """
    key = (_fingerprint(eye), *picture)
    with _lock:
        if key in _kept:
            _kept.move_to_end(key)
            return _kept[key]
    ids = make()
    ids.setflags(write=False)
    with _lock:
        _kept[key] = ids
        while len(_kept) > 1 and sum(each.nbytes for each in _kept.values()) > _MOST_KEPT_BYTES:
            _kept.popitem(last=False)
    return ids


def _fingerprint(eye: Eye) -> bytes:
    digest = hashlib.blake2b(digest_size=16)
    for array in (eye.position_m, eye.axis, eye.acceptance_angle_rad, eye.eye_id):
        digest.update(array.tobytes())
    return digest.digest()


_lock = threading.Lock()
_kept: OrderedDict[tuple[object, ...], Ids] = OrderedDict()
