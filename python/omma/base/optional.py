"""Packages that Omma does without until something asks for them."""

from __future__ import annotations

import importlib
from typing import Any

from omma._core import Error


def needs(module: str, extra: str, told: str) -> Any:
    """A module of an optional package.

    Args:
        extra: of Omma that brings the package; "" where none does.
        told: who needs it, such as "datasets need xarray".

    Raises:
        omma.Error: it is not installed, with how to install it.
    """
    try:
        return importlib.import_module(module)
    except ImportError:
        package = f"'omma[{extra}]'" if extra else module.split(".")[0]
        raise Error(f"{told}, which is not installed: pip install {package}") from None
