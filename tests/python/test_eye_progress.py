"""Long work on eyes tells how far it is, and ends where its listener says so."""

import numpy as np
import pytest
from test_eye_files_import import grid, oda_file

import omma


def cap():
    """Lenses over a part of a sphere of 1 mm, and tips 50 µm below each, metres."""
    seen = omma.eye.window(azimuth_deg=(-40, 40), elevation_deg=(-40, 40))
    out = omma.eye.lay_directions(np.radians(6), field_of_view=seen).directions
    return out, 1e-3 * out, 0.95e-3 * out


@pytest.fixture(scope="module")
def works(tmp_path_factory):
    """What takes long, by name: a function of its ``progress``."""
    out, lenses, tips = cap()
    lens, normal = grid(8)
    path = tmp_path_factory.mktemp("oda") / "ommatidial_data.csv"
    oda_file(path, lens, normal)
    ball = omma.eye.surfaces.sphere(1e-3)
    return {
        "generate_eye": lambda p: omma.eye.generate_eye(100, progress=p),
        "lay_directions": lambda p: omma.eye.lay_directions(0.3, progress=p),
        "lay_on_surface": lambda p: omma.eye.lay_on_surface(ball, 2e-4, progress=p),
        "eye_on_surface": lambda p: omma.eye.eye_on_surface(out, ball, progress=p),
        "import_oda": lambda p: omma.eye.scans.import_oda(path, progress=p),
        "import_lens_cone": lambda p: omma.eye.scans.import_lens_cone(
            lenses, tips, "m", progress=p
        ),
        "species.build": lambda p: omma.species.build("honeybee_worker", p),
    }


NAMES = (
    "generate_eye",
    "lay_directions",
    "lay_on_surface",
    "eye_on_surface",
    "import_oda",
    "import_lens_cone",
    "species.build",
)


@pytest.mark.parametrize("name", NAMES)
def test_progress_is_told(name, works):
    told = []
    works[name](lambda stage, fraction: told.append((stage, fraction)))
    assert told
    for stage in {stage for stage, _ in told}:
        assert stage
        fractions = [f for s, f in told if s == stage and f is not None]
        assert all(0 <= f <= 1 for f in fractions)


@pytest.mark.parametrize("name", NAMES)
def test_what_a_listener_raises_ends_the_work(name, works):
    """As Ctrl-C does, which Python raises in its code."""

    def stop(stage, fraction):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        works[name](stop)


def test_parts_give_the_same_eye(monkeypatch):
    out, _, _ = cap()
    ball = omma.eye.surfaces.ellipsoid((1e-3, 2e-3, 1e-3))
    whole = omma.eye.eye_on_surface(out, ball)
    monkeypatch.setattr("omma.eye.on_surface._PIECE", 7)
    fractions = []
    parts = omma.eye.eye_on_surface(out, ball, progress=lambda _, f: fractions.append(f))
    assert np.array_equal(parts.position_m, whole.position_m)
    assert np.array_equal(parts.facet_diameter_m, whole.facet_diameter_m)
    assert len(fractions) > len(out) // 7
    assert fractions[:-1] == sorted(fractions[:-1])


@pytest.mark.parametrize("window", [None, {"azimuth_deg": (-60, 60), "elevation_deg": (-60, 60)}])
def test_laying_tells_of_all_of_its_steps(window):
    """Also where the number is mended at the end, which takes as many steps as there were of the
    full lattice, and where the first lattice takes several trials."""
    seen = None if window is None else omma.eye.window(**window)
    told = []
    omma.eye.lay_directions(
        0.1, field_of_view=seen, count=601, progress=lambda _, share: told.append(share)
    )
    shares = np.array([one for one in told if one is not None])
    assert shares[-1] == 1
    assert (np.diff(shares) >= 0).all()
    if window is None:
        # Twice 150 steps of all, told every 10, beside 400 of a quarter of them: the last 150 are
        # from 5/8 on.
        assert np.count_nonzero(shares >= 5 / 8) == 15 + 1


def test_progress_is_a_function():
    with pytest.raises(TypeError, match="progress: expected a function"):
        omma.eye.generate_eye(100, progress=True)
