"""Python warnings that name the line of the caller's code, not one inside the package."""

from __future__ import annotations

import sys
import warnings

# Whose frames lie between the caller's and the one that warns: the package's own, and those of its
# cached properties.
_WITHIN = ("omma.", "functools")


def warn_caller(sentence: str, kind: type[Warning]) -> None:
    """Tell the caller of the package something that is no reason to stop."""
    level, frame = 2, sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith(_WITHIN):
        level, frame = level + 1, frame.f_back
    warnings.warn(sentence, kind, stacklevel=level)
