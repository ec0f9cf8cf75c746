"""The wheels in dist/, where scripts/wheel has made some: whole, small, and good in a bare root."""

import os
import re
import shutil
import subprocess
import tarfile
import zipfile
from email.parser import Parser
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
WHEELS = sorted((ROOT / "dist").glob("omma-*.whl"))
needs_wheels = pytest.mark.skipif(
    not WHEELS, reason="needs wheels in dist/, which scripts/wheel makes"
)


@pytest.fixture(params=WHEELS or [None], ids=lambda path: path and path.name)
def wheel(request):
    with zipfile.ZipFile(request.param) as file:
        yield file


@needs_wheels
def test_a_wheel_is_small_and_runs_with_an_old_glibc(wheel):
    path = Path(wheel.filename)
    assert path.stat().st_size < 25e6
    python, abi, platform = path.stem.split("-")[2:]
    assert (python, abi) in {("cp310", "cp310"), ("cp311", "cp311"), ("cp312", "abi3")}
    # RHEL 9 has glibc 2.34, Ubuntu 22.04 2.35.
    glibc = [int(minor) for minor in re.findall(r"manylinux_2_(\d+)_", platform)]
    assert glibc
    assert min(glibc) <= 34


@needs_wheels
def test_a_wheel_has_all_that_is_read_at_run_time(wheel):
    """The package's files as the source distribution has them, of which the wheel was built."""
    names = set(wheel.namelist())
    version = Path(wheel.filename).name.split("-")[1]
    with tarfile.open(ROOT / "dist" / f"omma-{version}.tar.gz") as source:
        package = [file.name.split("/python/omma/") for file in source if file.isfile()]
    package = [f"omma/{parts[1]}" for parts in package if len(parts) == 2]
    assert len(package) > 200
    assert set(package) - names == set()
    assert {f"omma/data/{name}" for name in ("meadow.glb", "meadow_lit.glb", "flight.csv")} <= names
    assert "omma/lib/libEyeRenderer3.so" in names
    assert any(re.fullmatch(r"omma/_core\.[\w.-]*so", name) for name in names)


@needs_wheels
def test_every_library_in_a_wheel_has_its_licence(wheel):
    """By the words of each licence that must be passed on, not by the names of files alone."""
    said = {
        Path(name).name: wheel.read(name).decode("utf-8", "replace")
        for name in wheel.namelist()
        if "/licenses/" in name
    }
    everything = "\n".join(said.values())
    libraries = [Path(name).name for name in wheel.namelist() if name.startswith("omma.libs/")]
    known = {
        "libembree3": "embree-LICENSE.txt", "libtbb": "libtbb12.txt", "libpng16": "libpng16-16.txt",
        "libjpeg": "libjpeg62-turbo.txt", "libz": "zlib1g.txt", "libOpenEXR": "libopenexr",
        "libwebp": "libwebp7.txt", "libmeshoptimizer": "libmeshoptimizer2d.txt",
        "libdraco": "libdraco7.txt", "libIlmThread": "libopenexr", "libIex": "libopenexr",
        "libImath": "libimath",
    }  # fmt: skip
    assert len(libraries) >= 6
    for library in libraries:
        (licence,) = {text for name, text in known.items() if library.startswith(f"{name}-")}
        assert any(name.startswith(licence) for name in said), library
    for words in (
        "The Omma authors",
        "Wenzel Jakob",  # nanobind
        "Thibaut Goetghebuer-Planchon",  # robin_map, in nanobind
        "Niels Lohmann",  # nlohmann_json
        "Marius Muja",  # nanoflann
        "TERMS AND CONDITIONS FOR USE, REPRODUCTION, AND DISTRIBUTION",  # Apache 2.0, in full
        "Independent JPEG Group",
        "Arseny Kapoulkine",  # meshoptimizer
        "Google Inc",  # libwebp
        "Industrial Light",  # OpenEXR
    ):
        assert words in everything, words
    for name in set(re.findall(r"/usr/share/common-licenses/([\w.-]*\w)", everything)):
        assert f"common-{name}.txt" in said


@needs_wheels
def test_a_wheel_says_what_it_needs(wheel):
    (name,) = (name for name in wheel.namelist() if name.endswith(".dist-info/METADATA"))
    metadata = Parser().parsestr(wheel.read(name).decode())
    assert metadata["Version"] == Path(wheel.filename).name.split("-")[1]
    assert "all" in metadata.get_all("Provides-Extra")
    needed = [line for line in metadata.get_all("Requires-Dist") if "extra ==" not in line]
    names = {re.match(r"[\w-]+", line)[0].replace("-", "_") for line in needed}
    assert names == {"numpy", "scipy", "typer", "rich", "lazy_loader", "platformdirs", "pillow"}


@needs_wheels
@pytest.mark.skipif(
    os.geteuid() != 0 or shutil.which("debootstrap") is None,
    reason="a bare root needs root and debootstrap",
)
def test_the_example_renders_in_a_bare_root():
    done = subprocess.run(["scripts/try_wheel"], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "(1, 10760, 3)" in done.stdout
    assert "the package is whole" in done.stdout
