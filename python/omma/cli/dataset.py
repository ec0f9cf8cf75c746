"""``omma dataset``: data sets made, checked, looked at and written as tar files."""

from __future__ import annotations

import logging
import sys
from pathlib import Path
from typing import Annotated

import typer

from omma.cli.help import App
from omma.cli.parameters import argument, option, out, switch
from omma.cli.working import check_outputs, say, warn, working
from omma.datasets.contact_sheet import contact_sheet
from omma.datasets.description import describe
from omma.datasets.job_file import load_job
from omma.datasets.records import shards_done
from omma.datasets.running import run as run_job
from omma.datasets.running import verify as verify_store
from omma.datasets.webdataset import to_webdataset as write_tars

DATASET_HELP = """
Make data sets of views for models, and read them (docs/datasets.md).

**Examples**

`omma dataset run job.toml -o views.zarr`

`omma dataset info views.zarr`

`omma dataset sample views.zarr -o sheet.png`
"""

RUN_HELP = """
Make a data set: the views that a job file asks for, in one Zarr store.

Run again, it makes what is missing and nothing else: after Ctrl-C, a kill, a full disk or a loss of
power. The bits do not depend on the number of threads and workers, nor on interruptions. All cores
of this machine work, or the workers of a Dask cluster, which must see the job's files and the store
under the same names.

A condition of the job that has a light says how it is followed: lighting = "path", the default, for
each ray; or lighting = "baked", which finds most of it once for all views, before the first, and
keeps it below ~/.cache/omma, or below the folder that the environment variable OMMA_CACHE names.

**Examples**

`omma dataset run job.toml`

`omma dataset run job.toml -o views.zarr --threads 1`

`omma dataset run job.toml --dask tcp://head-node:8786`

`omma dataset run job.toml --slurm 20`
"""

VERIFY_HELP = """
Check that every shard of a data set is there, and every byte as it was written.

Exit code 1 where something is missing or damaged.

**Examples**

`omma dataset verify views.zarr`

`omma dataset verify views.zarr --forget`
"""

INFO_HELP = """
Say what is in a data set, and how much of it is there.

**Examples**

`omma dataset info views.zarr`
"""

SAMPLE_HELP = """
Draw some views of a data set on one sheet, to see whether it is what was meant.

**Examples**

`omma dataset sample views.zarr -o sheet.png`

`omma dataset sample views.zarr -o sheet.pdf -n 8 --seed 2`
"""

TARS_HELP = """
Write a data set as tar files for WebDataset: NUMBER.response.npy and NUMBER.json for each view.

**Examples**

`omma dataset to-webdataset views.zarr -o tars`

`omma dataset to-webdataset views.zarr -o tars --views-per-file 100 --variable response`
"""

dataset_app = App(help=DATASET_HELP, no_args_is_help=True)

StoreArgument = Annotated[Path, argument("The data set.", "STORE")]
EyeOption = Annotated[str | None, option("Whose views, where there are several eyes.", "NAME")]


@dataset_app.callback()
def _dataset() -> None:
    pass


@dataset_app.command(help=RUN_HELP, short_help="Make a data set, or what is missing of it.")
def run(
    job: Annotated[Path, argument("The job, a TOML file.", "JOB")],
    output: Annotated[
        Path | None,
        out(
            "Store to write; default: as the job says. Its folder is made where it is missing.",
            "STORE",
        ),
    ] = None,
    threads: Annotated[int, option("On this machine; 0: all cores.", "N")] = 0,
    dask: Annotated[
        str | None, option("Have the workers of this Dask scheduler do it.", "ADDRESS")
    ] = None,
    slurm: Annotated[
        int,
        option(
            "Make so many jobs in SLURM, as the table [slurm] of the job says, whose "
            "workers do it.",
            "N",
        ),
    ] = 0,
) -> None:
    """Make a data set."""
    with working() as bar:
        read = load_job(job)
        store = read.store if output is None else str(output)
        try:
            report = run_job(
                read, store, threads=threads, dask=dask, slurm=slurm, progress=bar.show
            )
        except KeyboardInterrupt:
            if Path(store).is_dir():
                # What Zarr was waiting for is told of where it is dropped.
                logging.getLogger("asyncio").disabled = True
                kept = len(shards_done(store))
                print(
                    f"omma: shards kept in {store}: {kept}; the same command goes on",
                    file=sys.stderr,
                )
            raise
    for sentence in report.warnings:
        warn(sentence)
    if report.made == 0:
        say(f"{report.store}: all {report.views:,} views were there")
        return
    rate = report.views_made / report.seconds
    say(
        f"{report.store}: made {report.views_made:,} of {report.views:,} views in "
        f"{report.seconds:,.1f} s, {rate:,.0f} a second"
    )


@dataset_app.command(help=VERIFY_HELP, short_help="Check every byte of a data set.")
def verify(
    store: StoreArgument,
    forget: Annotated[
        bool, switch("--forget", "Forget shards that are damaged, so that run makes them anew.")
    ] = False,
) -> None:
    """Check a data set."""
    with working() as bar:
        report = verify_store(store, forget=forget, progress=bar.fraction_of("Verifying"))
    for sentence in report.damaged:
        say(sentence)
    if report.left:
        say(f"{len(report.left)} files that killed runs left; the next run removes them")
    if report.missing:
        say(f"{len(report.missing)} of {report.shards} shards are not made yet")
    if report.damaged and forget:
        say("what is damaged is forgotten: the next run makes it anew")
    if report.is_whole:
        say(f"{store}: all {report.shards} shards are as they were written")
    else:
        raise typer.Exit(1)


@dataset_app.command(help=INFO_HELP, short_help="Say what is in a data set.")
def info(store: StoreArgument) -> None:
    """Describe a data set."""
    for line in describe(store):
        say(line)


@dataset_app.command(help=SAMPLE_HELP, short_help="Draw some views on one sheet.")
def sample(
    store: StoreArgument,
    output: Annotated[Path, out("Figure to write: .png, .svg, .pdf.")],
    count: Annotated[int, typer.Option("-n", "--count", help="How many views.", metavar="N")] = 24,
    eye: EyeOption = None,
    seed: Annotated[int, option("Of the choice of views.", "N")] = 0,
) -> None:
    """Draw a contact sheet."""
    check_outputs(output)
    with working():
        contact_sheet(output, store, count, eye=eye, seed=seed)
    say(f"wrote {output}")


@dataset_app.command("to-webdataset", help=TARS_HELP, short_help="Write views as tar files.")
def to_webdataset(
    store: StoreArgument,
    output: Annotated[Path, out("Folder to write; made where it is missing.", "FOLDER")],
    variable: Annotated[
        list[str] | None, option("Array to write; may be repeated. Default: response.", "NAME")
    ] = None,
    eye: EyeOption = None,
    views_per_file: Annotated[int, option("Views in a file.", "N")] = 1000,
) -> None:
    """Write tar files."""
    with working() as bar:
        written = write_tars(
            store,
            output,
            variable or ["response"],
            eye=eye,
            views_per_file=views_per_file,
            progress=bar.fraction_of("Writing"),
        )
    say(f"wrote {len(written)} file{'' if len(written) == 1 else 's'} into {output}")
