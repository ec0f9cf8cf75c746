"""The way to CompoundRay's library under its old name, for scripts that load it with ctypes."""

from pathlib import Path

from omma._core import Error

__all__ = ["compoundray_library"]


def compoundray_library() -> str:
    """Where this package keeps ``libEyeRenderer3.so``.

    It has the C functions of CompoundRay's library of that name, so that its Python scripts run as
    they are; ``examples/from_compoundray.md`` says how. Raises ``omma.Error`` where the package was
    built without it.

        eyeRenderer = CDLL(omma.compat.compoundray_library())
    """
    path = Path(__file__).resolve().parent / "lib" / "libEyeRenderer3.so"
    if not path.exists():
        raise Error(
            f"{path}: expected CompoundRay's library, built with OMMA_BUILD_COMPAT=ON; "
            "there is no such file"
        )
    return str(path)
