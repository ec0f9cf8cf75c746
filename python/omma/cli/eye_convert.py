"""``omma eye convert``: one format of eyes into another, and measurements into eyes."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal

import typer

from omma._core import Error, Eye
from omma.cli.eye_files import EyeArgument, OutOption, UnitOption, save
from omma.cli.numbers import above_zero, acceptance_angle, numbers_of
from omma.cli.parameters import option, switch
from omma.cli.working import warn, working
from omma.eye.files import OCES_SUFFIXES, eye_file_losses, load_eye
from omma.eye.old_files import convert_eye
from omma.eye.scans import import_lens_cone, import_oda

CONVERT_HELP = """
Convert eye files. The endings say the formats: **.csv** has named columns with units, **.gltf** and
**.glb** are the Open Compound Eye Standard, anything else is an .eye file.

CSV and OCES keep everything. An .eye file holds position, axis, acceptance angle and focal offset
only: what would be lost is said, and it is written only with --lossy. Old .eye files of 7 or 9
columns are read too; what is assumed of them is said.

With --from, the file is a measurement. **oda**: ommatidial_data.csv of the Ommatidia Detecting
Algorithm. **lens-cone**: a CSV file of the points x, y, z where lenses are in a scan, or the
positions that Imaris exports, with --cones a second one of the tips of the crystalline cones, in
any order; each axis points from a tip to its lens. Both eyes of a head may be in one pair of files.
--scan-unit, --ahead and --up say what the scan's numbers and directions are.

**Examples**

`omma eye convert honeybee.eye -o honeybee.csv`

`omma eye convert eyes.glb --head worker -o worker.csv`

`omma eye convert bee.csv -o bee.eye --lossy`

`omma eye convert old-in-degrees.eye --degrees -o new.eye`

`omma eye convert measured.csv --missing-acceptance neighbours -o whole.csv`

`omma eye convert ommatidial_data.csv --from oda --ahead=0,1,0 --up=0,0,1 -o fly.csv`

`omma eye convert lenses.csv --from lens-cone --cones cones.csv --scan-unit mm -o bee.glb`
"""


def add_convert_command(app: typer.Typer) -> None:
    """Adds ``convert`` to the commands of ``omma eye``."""
    app.command(help=CONVERT_HELP, short_help="Convert eye files; import measurements.")(convert)


def convert(
    eye: EyeArgument,
    output: OutOption,
    source: Annotated[
        Literal["oda", "lens-cone"] | None,
        switch("--from", "The file is a measurement of this kind."),
    ] = None,
    cones: Annotated[
        Path | None, option("Tips of the cones, with --from lens-cone.", "CSV")
    ] = None,
    scan_unit: Annotated[
        str | None,
        option(
            "With --from: unit of lengths: um, mm, m or a number of metres. Default: what a "
            "file of points says, else um.",
            "UNIT",
        ),
    ] = None,
    ahead: Annotated[
        str | None, option("With --from: the animal's front in the scan. Default: 0,0,-1.", "X,Y,Z")
    ] = None,
    up: Annotated[
        str | None, option("With --from: its upper side in the scan. Default: 0,1,0.", "X,Y,Z")
    ] = None,
    acceptance_ratio: Annotated[
        float | None,
        option(
            "With --from: acceptance over interommatidial angle. Default: 1.", "RATIO", above_zero
        ),
    ] = None,
    acceptance_deg: Annotated[
        float | None, option("With --from: one acceptance angle for all.", "DEG", acceptance_angle)
    ] = None,
    allow_unmatched: Annotated[
        bool, switch("--allow-unmatched", "Leave out lenses and cones that have no partner.")
    ] = False,
    head: Annotated[str | None, option("Head of an OCES file, by name or number.", "NAME")] = None,
    degrees: Annotated[
        bool, switch("--degrees", "Acceptance angles of the .eye file are degrees.")
    ] = False,
    missing_acceptance: Annotated[
        Literal["refuse", "neighbours", "interommatidial"],
        option(
            "What becomes of ommatidia of a .csv file without an acceptance angle: neighbours "
            "gives them the mean of the six that look nearest, interommatidial the mean angle to "
            "those."
        ),
    ] = "refuse",
    lossy: Annotated[
        bool, switch("--lossy", "Write an .eye file although it loses something.")
    ] = False,
    unit: UnitOption = "mm",
) -> None:
    """Convert eye files; import measurements."""
    measured = {
        "--cones": cones,
        "--scan-unit": scan_unit,
        "--ahead": ahead,
        "--up": up,
        "--acceptance-ratio": acceptance_ratio,
        "--acceptance-deg": acceptance_deg,
        "--allow-unmatched": allow_unmatched or None,
    }
    for name, value in measured.items():
        if source is None and value is not None:
            raise Error(f"convert: {name} is for measurements (--from)")
    if source is not None and (head is not None or degrees):
        raise Error("convert: --head and --degrees are for eye files, not for measurements")
    if (source == "lens-cone") != (cones is not None):
        raise Error("convert: expected --from lens-cone and --cones together")
    if acceptance_ratio is not None and acceptance_deg is not None:
        raise Error("convert: expected --acceptance-ratio or --acceptance-deg, not both")
    if source is not None and missing_acceptance != "refuse":
        raise Error("convert: --missing-acceptance is for eye files, not for measurements")
    with working() as bar:
        bar.show("reading", None)
        if source is None:
            found, notes = _read(eye, unit, head, degrees, missing_acceptance)
            if output.suffix.lower() in (".csv", *OCES_SUFFIXES):
                # That there is nothing old about a file is no news to who wants another format.
                notes = tuple(n for n in notes if not n.startswith("Nothing to convert"))
        else:
            options = {
                "unit": scan_unit or ("um" if source == "oda" else None),
                "ahead": numbers_of("--ahead", ahead or "0,0,-1", 3),
                "up": numbers_of("--up", up or "0,1,0", 3),
                "acceptance_ratio": 1.0 if acceptance_ratio is None else acceptance_ratio,
                "acceptance_angle_rad": None
                if acceptance_deg is None
                else math.radians(acceptance_deg),
            }
            if source == "oda":
                imported = import_oda(eye, progress=bar.show, **options)  # type: ignore[arg-type]
            else:
                assert cones is not None
                imported = import_lens_cone(
                    eye,
                    cones,
                    allow_unmatched=allow_unmatched,
                    progress=bar.show,
                    **options,  # type: ignore[arg-type]
                )
            found, notes = imported.eye, imported.notes
        for note in notes:
            warn(f"{eye}: {note}")
        losses = eye_file_losses(output, found)
        if losses and not lossy:
            raise Error(
                f"{output}: an .eye file cannot hold {'; '.join(losses)}. Write a .csv, .gltf "
                "or .glb file, which keep everything, or say --lossy"
            )
        save(output, found, unit)


def _read(
    path: Path, unit: str, head: str | None, degrees: bool, missing: str
) -> tuple[Eye, tuple[str, ...]]:
    if path.suffix.lower() in (".csv", *OCES_SUFFIXES) or head is not None:
        if degrees:
            raise Error("convert: --degrees is for .eye files; other files say their units")
        return load_eye(path, unit, head=head, missing_acceptance=missing), ()
    if missing != "refuse":
        raise Error(f"{path}: only .csv files can have gaps in acceptance angles")
    converted = convert_eye(path, unit, degrees=degrees)
    return converted.eye, converted.notes
