"""Writes the numbers of docs/validation.md and its figure: what must come out, what came out; and
every number of lit worlds into bench/notes/lit-worlds.md.

    .venv/bin/python docs/make_validation.py

Effects of validation_checks.py are computed anew, a minute or two on two cores; closed forms of lit
worlds are those of tests/python/lit_checks*.py; gratings of MuJoCo's page are read from
bench/results/mujoco_gratings.csv. Exits with 1 where something is further off than allowed.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np
import validation_checks as checks
from matplotlib.figure import Figure
from validation_checks import Line

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
sys.path.insert(0, str(ROOT / "tests" / "python"))

from lit_checks_lights import CASES as OF_LIGHTS  # noqa: E402
from lit_checks_surfaces import CASES as OF_SURFACES  # noqa: E402
from lit_checks_volumes import CASES as OF_VOLUMES  # noqa: E402

BLUE, ORANGE = "#0072B2", "#D55E00"

PAGE = DOCS / "validation.md"
LIT = ROOT / "bench" / "notes" / "lit-worlds.md"
NUMBERS = ("<!-- numbers: made by make_validation.py -->", "<!-- end of the numbers -->")
GRATINGS = ("<!-- gratings: made by make_validation.py -->", "<!-- end of the gratings -->")

TESTS = {
    "The quantity": ["tests/cpp/render_reference.cpp", "tests/python/test_renderer.py"],
    "Gratings": ["tests/python/test_stimuli.py", "tests/python/test_motion_rendered.py"],
    "Optics of an ommatidium": ["tests/cpp/optics_warp.cpp", "tests/cpp/optics_acceptances.cpp"],
    "Standard errors": ["tests/python/test_error_target.py", "tests/python/test_confidence.py"],
    "Time": ["tests/python/test_time_in_frames.py", "tests/python/test_photoreceptor_gratings.py"],
    "Motion detectors": ["tests/python/test_motion.py"],
    "Distance and optic flow": ["tests/python/test_truth.py"],
    "Stimuli": ["tests/python/test_stimuli.py", "tests/python/test_stimuli_things.py"],
    "The clear sky": ["tests/python/test_sky.py"],
    "Photons": ["tests/python/test_photoreceptor_noise.py"],
    "Lit worlds": ["tests/python/test_lit_forms.py", "tests/python/test_lit_mitsuba.py"],
}


def number(value: float, digits: int = 4) -> str:
    """With so many digits, and signs as they are printed."""
    text = f"{value:.{digits}g}".replace("-", "−")
    return text.replace("e−0", "e−")


def table(lines: list[Line]) -> str:
    """Rows of lines, numbers to four digits."""
    rows = [
        "| effect | must be, by | it says | came out | off by | allowed, as |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    rows += [
        f"| {one.effect} | {one.form} | {number(one.expected)} | {number(one.found)} | "
        f"{number(one.found - one.expected, 2)} | {number(one.allowed, 2)}: {one.because} |"
        for one in lines
    ]
    return "\n".join(rows)


def lit_numbers(found: dict[str, list]) -> str:
    """A row for each number of lit worlds."""
    rows = [
        "| effect | closed form | it says | came out | off by | standard error |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for one in (one for numbers in found.values() for one in numbers):
        spread = f"{one.standard_error:.1e}" if one.standard_error else "–"
        rows.append(
            f"| {one.effect} | {one.form} | {one.expected:.6g} | {one.found:.6g} | "
            f"{one.found - one.expected:+.1e} | {spread} |"
        )
    return "\n".join(rows)


def lit_table(found: dict[str, list]) -> str:
    """A row for each group of lit checks: how many numbers, and the one that is furthest off."""
    rows = [
        "| what | numbers | furthest off, of what is allowed | that one |",
        "| --- | --- | --- | --- |",
    ]
    for name, numbers in found.items():
        worst = max(numbers, key=lambda one: abs(one.error()) / one.limit())
        rows.append(
            f"| {name.replace('_', ' ')} | {len(numbers)} | "
            f"{abs(worst.error()) / worst.limit():.2f} | {worst.effect} |"
        )
    return "\n".join(rows)


def mujoco_table() -> str:
    """Contrast of gratings as a Gaussian of a fly's retina keeps it."""
    with open(ROOT / "bench" / "results" / "mujoco_gratings.csv", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["azimuth_deg"] == "0 to 25"]
    lines = [
        "| cycles per degree | Gaussian of 6.52° | Omma | FlyGym's way |",
        "| --- | --- | --- | --- |",
    ]
    lines += [
        f"| {float(row['cycles_per_degree']):.2f} | {float(row['gaussian']):.3f} | "
        f"{float(row['omma']):.3f} | {float(row['flygym_way']):.3f} |"
        for row in rows
    ]
    return "\n".join(lines)


def put(page: str, marks: tuple[str, str], text: str) -> str:
    """The page with this text between two marks."""
    before, rest = page.split(marks[0])
    return f"{before}{marks[0]}\n\n{text}\n\n{marks[1]}{rest.split(marks[1])[1]}"


def figure(panels: list, lit: dict[str, list]) -> None:
    """docs/validation-forms.png."""
    picture = Figure(figsize=(9, 6.6), layout="constrained", dpi=130)
    axes = picture.subplots(2, 2).ravel()
    labels = [
        ("Δρ/λ", "contrast kept", "Gratings on a drum", "linear"),
        ("frequency, Hz", "contrast kept", "Flicker, frames that last", "log"),
        ("frequency, Hz", "output", "A motion detector, τ 35 ms", "log"),
    ]
    for at, (x, expected, found), (below, beside, title, scale) in zip(axes, panels, labels):
        order = np.argsort(x)
        at.plot(x[order], expected[order], color=BLUE, label="closed form")
        at.plot(x, found, "o", color=ORANGE, ms=4.5, label="Omma")
        at.set(xlabel=below, ylabel=beside, xscale=scale)
        at.set_title(title, fontsize=10)
        at.legend(frameon=False)
    last = axes[3]
    share = sorted(one.error() / one.limit() for numbers in lit.values() for one in numbers)
    last.axhspan(-1, 1, color="#eeeeee", label="allowed")
    last.plot(share, "o", color=ORANGE, ms=3.5, label="Omma")
    last.axhline(0, color=BLUE, lw=1)
    last.set(xlabel="number, in order", ylabel="difference / allowed", ylim=(-1.15, 1.15))
    last.set_title(f"Lit worlds: {len(share)} closed forms", fontsize=10)
    last.legend(frameon=False, loc="upper left")
    for at in axes:
        at.spines[["top", "right"]].set_visible(False)
    picture.savefig(DOCS / "validation-forms.png")


def main() -> int:
    """Compute all, write page and figure."""
    of_gratings, *grating_panel = checks.gratings()
    of_time, *time_panel = checks.time()
    of_motion, *motion_panel = checks.motion()
    parts = {
        "The quantity": checks.quantity(),
        "Gratings": of_gratings,
        "Optics of an ommatidium": checks.optics(),
        "Standard errors": checks.standard_errors(),
        "Time": of_time,
        "Motion detectors": of_motion,
        "Distance and optic flow": checks.flow(),
        "Stimuli": checks.stimuli(),
        "The clear sky": checks.sky(),
        "Photons": checks.photons(),
    }
    cases = OF_SURFACES | OF_VOLUMES | OF_LIGHTS
    lit = {name: list(case("portable")) for name, case in cases.items()}
    text = []
    for title, lines in parts.items():
        tests = ", ".join(f"`{test}`" for test in TESTS[title])
        text += [f"### {title}\n", table(lines), f"\nTests: {tests}.\n"]
    count = sum(len(numbers) for numbers in lit.values())
    text += [
        "### Lit worlds\n",
        f"{count} closed forms of light between surfaces, gloss, polarisation, glass, shade, skies "
        "and lamps, each as the whole renderer gives it for a small scene and an eye of one ray "
        "([every number](../bench/notes/lit-worlds.md)). Here the one of each kind that is "
        "furthest off, where 1 is as far as allowed: three standard errors, and 10⁻⁵ or "
        "[what is said below](#what-lit-worlds-may-be-off-by).\n",
        lit_table(lit),
        f"\nTests: {', '.join(f'`{test}`' for test in TESTS['Lit worlds'])}.",
    ]
    page = put(PAGE.read_text(encoding="utf-8"), NUMBERS, "\n".join(text))
    PAGE.write_text(put(page, GRATINGS, mujoco_table()), encoding="utf-8")
    LIT.write_text(
        put(LIT.read_text(encoding="utf-8"), NUMBERS, lit_numbers(lit)), encoding="utf-8"
    )
    figure([grating_panel, time_panel, motion_panel], lit)
    off = [one for lines in parts.values() for one in lines if not one.holds()]
    off += [one for numbers in lit.values() for one in numbers if abs(one.error()) > one.limit()]
    for one in off:
        print(f"further off than allowed: {one}", file=sys.stderr)
    print(f"wrote both pages and validation-forms.png; {len(off)} numbers are too far off")
    return 1 if off else 0


if __name__ == "__main__":
    sys.exit(main())
