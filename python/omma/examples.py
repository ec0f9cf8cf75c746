"""What the package brings along to start with: a meadow, and a flight over it."""

from pathlib import Path

from omma._core import Error

__all__ = ["flight", "lit_meadow", "meadow"]


def meadow() -> Path:
    """Where the bundled meadow is: a glTF scene with the cameras "bee", "bee-low" and "overview".

        scene = omma.load_scene(omma.examples.meadow())

    Raises omma.Error where this installation lacks it.
    """
    return _bundled("meadow.glb")


def lit_meadow() -> Path:
    """Where the meadow for worlds that are lit is: the same triangles, and a pond.

    Its materials have spectra from 300 to 700 nm and hold no light; grass, leaves and petals let
    light through. It has the cameras of `meadow`, and "pond".

        scene = omma.load_scene(omma.examples.lit_meadow())

    Raises omma.Error where this installation lacks it.
    """
    return _bundled("meadow_lit.glb")


def flight() -> Path:
    """Where the path of a bee over the meadow is: 120 poses, for `omma.load_poses`.

    Raises omma.Error where this installation lacks it.
    """
    return _bundled("flight.csv")


def _bundled(name: str) -> Path:
    # Installed by python/CMakeLists.txt, so that the repository has the file once, in examples/.
    path = Path(__file__).parent / "data" / name
    if not path.is_file():
        raise Error(f"{path}: expected the package's own {name}; there is no such file")
    return path
