"""Writes the table of docs/light.md that says what errors of catches a number of bands makes.

.venv/bin/python docs/make_band_table.py
"""

from pathlib import Path

import numpy as np

import omma
from omma.light import Bands

PAGE = Path(__file__).resolve().parent / "light.md"
START, END = "<!-- table: made by make_band_table.py -->", "<!-- end of the table -->"
COUNTS = (4, 8, 16, 20, 40)


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.nanmean(values**2)))


def shown(error: float) -> str:
    return f"{100 * error:.2g} %" if error < 0.1 else f"{100 * error:.0f} %"


def main() -> None:
    lights = [omma.light.clear_sky(30.0), omma.light.clear_sky(5.0)]
    ommatidia = omma.receptors.honeybee_ommatidia()
    eye = omma.receptors.assign_receptors(omma.species.honeybee_worker().eye, ommatidia)
    types = eye.receptor_types
    eight = ommatidia[0].receptors  # an ultraviolet one, a blue one, six green ones

    def errors(of, bands, reflections=1):
        found = omma.receptors.band_error(lights, of, bands, reflections=reflections)
        return found.relative_error

    columns = {n: errors(list(types), Bands.equal(n)) for n in COUNTS}
    rows = [
        "| bands | " + " | ".join(str(n) for n in COUNTS) + " |",
        "| --- |" + " --- |" * len(COUNTS),
    ]
    for k, one in enumerate(types):
        rows.append(
            f"| {one.name} | " + " | ".join(shown(rms(columns[n][..., k])) for n in COUNTS) + " |"
        )
    together = [shown(rms(errors(eight, Bands.equal(n)))) for n in COUNTS]
    worst = [shown(float(np.nanmax(np.abs(columns[n])))) for n in COUNTS]
    rows.append("| a worker's eight together (six are green) | " + " | ".join(together) + " |")
    rows.append("| at worst | " + " | ".join(worst) + " |")
    nm = np.arange(300.0, 701.0)
    own = Bands.from_sensitivities(
        nm, [omma.receptors.spectral_sensitivity(one, nm) for one in types]
    )
    once, twice = (shown(rms(errors(list(types), own, n))) for n in (1, 2))
    own_bands = "One band for each receptor (`Bands.from_sensitivities`)"
    rows += ["", f"{own_bands} makes {once}, and {twice} after two reflections."]
    text = PAGE.read_text(encoding="utf-8")
    before, rest = text.split(START)
    after = rest.split(END)[1]
    PAGE.write_text(
        f"{before}{START}\n\n" + "\n".join(rows) + f"\n\n{END}{after}", encoding="utf-8"
    )


if __name__ == "__main__":
    main()
