"""Writes the table of docs/light-validation.md: what lit worlds give beside closed forms.

.venv/bin/python docs/make_light_validation.py
"""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "light-validation.md"
START, END = "<!-- table: made by make_light_validation.py -->", "<!-- end of the table -->"
sys.path.insert(0, str(ROOT / "tests" / "python"))

from lit_checks import Check  # noqa: E402
from lit_checks_lights import CASES as OF_LIGHTS  # noqa: E402
from lit_checks_surfaces import CASES as OF_SURFACES  # noqa: E402


def line(check: Check) -> str:
    error = check.found - check.expected
    spread = f"{check.standard_error:.1e}" if check.standard_error else "–"
    return (
        f"| {check.effect} | {check.form} | {check.expected:.6g} | {check.found:.6g} | "
        f"{error:+.1e} | {spread} |"
    )


def main() -> None:
    rows = [
        "| effect | closed form | it says | came out | off by | standard error |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for cases in (OF_SURFACES, OF_LIGHTS):
        for case in cases.values():
            rows += [line(check) for check in case("portable")]
    text = PAGE.read_text(encoding="utf-8")
    before, rest = text.split(START)
    after = rest.split(END)[1]
    table = "\n".join(rows)
    PAGE.write_text(f"{before}{START}\n\n{table}\n\n{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
