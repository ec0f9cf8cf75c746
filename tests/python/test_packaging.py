"""What is packaged is whole, and what several files say of it is one thing: version, dependencies,
the steps of images and of bare roots. Wheels themselves: test_wheel.py."""

import importlib.metadata
import re
import shutil
import subprocess
import sys
import tarfile
from pathlib import Path

import pytest

import omma

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib
yaml = pytest.importorskip("yaml", reason="needs PyYAML, which Dask brings")

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())


def run(*command, cwd=ROOT):
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True)


def test_what_a_message_says_to_install_brings_what_is_missing():
    """On every Python: a requirement with a condition would leave it missing where that fails."""
    extras = PROJECT["project"]["optional-dependencies"]
    told = set()
    for path in (ROOT / "python/omma").rglob("*.py"):
        told |= set(re.findall(r'needs\(\s*"([\w.]+)", "(\w+)"', path.read_text()))
    assert len(told) > 10
    for module, extra in told - {("PIL.Image", "view")}:  # Pillow comes with viser
        package = module.split(".")[0].replace("_", "[-_]")
        rows = [row for row in extras[extra] if re.match(rf"{package}\b", row)]
        assert rows, (module, extra)
        assert ";" not in rows[0], (module, extra)


def test_the_version_is_one():
    said = run("scripts/version").stdout.strip()
    assert re.fullmatch(r"\d+\.\d+\.\d+", said)
    assert said == omma.__version__ == importlib.metadata.version("omma")
    assert "version" not in PROJECT["project"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert "version" not in citation
    assert citation["cff-version"] == "1.2.0"
    assert f"## {said} (" in (ROOT / "CHANGELOG.md").read_text()


@pytest.fixture(scope="module")
def sdist(tmp_path_factory):
    """The source distribution of this tree, unpacked in an empty folder."""
    if not (ROOT / ".git").exists():
        pytest.skip("only a clone makes source distributions")
    out = tmp_path_factory.mktemp("sdist")
    done = run(sys.executable, "packaging/make_sdist.py", str(out))
    assert done.returncode == 0, done.stderr
    (archive,) = out.glob("omma-*.tar.gz")
    with tarfile.open(archive) as file:
        file.extractall(out, filter="data") if sys.version_info >= (3, 12) else file.extractall(out)
    return archive, Path(str(archive).removesuffix(".tar.gz"))


def test_the_source_distribution_has_what_is_needed_and_no_more(sdist):
    archive, tree = sdist
    committed = run("git", "ls-files").stdout.splitlines()
    left_out = re.compile(r"\.ci/|docs/.*\.(png|svg)$")
    needed = {name for name in committed if (ROOT / name).exists() and not left_out.match(name)}
    there = {str(path.relative_to(tree)) for path in tree.rglob("*") if path.is_file()}
    assert needed - there == set()
    others = {name for name in there - needed if run("git", "check-ignore", name).returncode == 0}
    assert others == set()
    assert archive.stat().st_size < 15e6  # of which 8 MB are tables of the sky and meadows


def test_the_source_distribution_is_configured(sdist, tmp_path):
    """CMake finds every file that it compiles. What it compiles to is scripts/wheel's to try."""
    _, tree = sdist
    command = ["cmake", "-S", tree, "-B", tmp_path / "build", "-DOMMA_BUILD_PYTHON=ON"]
    done = run(*command, "-DOMMA_BUILD_TESTS=ON", f"-DPython_EXECUTABLE={sys.executable}")
    if "is not installed for" in done.stderr:
        pytest.skip("needs nanobind in this environment, which is not here")
    assert done.returncode == 0, done.stderr


def dependencies(lines):
    """Names as PyPI and conda-forge both have them, with the least version."""
    pairs = (re.fullmatch(r"([\w.-]+)\s*(>=[\d.]+)?", line.strip()).groups() for line in lines)
    return {(name.lower().replace("-", "_"), least) for name, least in pairs}


def test_the_conda_recipe_asks_for_what_the_package_needs():
    recipe = yaml.safe_load((ROOT / "packaging" / "conda" / "recipe.yaml").read_text())
    python = f"python {PROJECT['project']['requires-python']}"
    run_time = dependencies(recipe["requirements"]["run"])
    assert run_time == dependencies([*PROJECT["project"]["dependencies"], python])
    # Of some systems only: {if: x86_64, then: embree}.
    host = dependencies(
        line["then"] if isinstance(line, dict) else line for line in recipe["requirements"]["host"]
    )
    assert dependencies(PROJECT["build-system"]["requires"]) <= host
    # Debian's packages of libraries are each one of conda-forge's.
    conda_of = {
        "embree": "embree", "tbb": "tbb_devel", "png": "libpng", "jpeg": "libjpeg_turbo",
        "openexr": "openexr", "webp": "libwebp_base", "meshoptimizer": "meshoptimizer",
        "draco": "draco",        "nlohmann-json3": "nlohmann_json", "nanoflann": "nanoflann",
    }  # fmt: skip
    libraries = {
        name.removeprefix("lib").removesuffix("-dev")
        for name in build_packages()
        if name.endswith("-dev") and name != "python3-dev"
    }
    assert libraries == set(conda_of)
    assert set(conda_of.values()) <= {name for name, _ in host}


def build_packages():
    done = run("bash", "-c", 'source scripts/common.sh; printf "%s\\n" "${build_packages[@]}"')
    return done.stdout.split()


def test_the_image_is_made_by_the_scripts_that_are_tested():
    dockerfile = (ROOT / "packaging" / "Dockerfile").read_text()
    steps = re.findall(r"^RUN (.*)$", dockerfile, re.M)
    own = [step for step in steps if not step.startswith("apt-get")]
    programs = [step.split()[0].replace("/tmp/", "packaging/") for step in own]
    assert programs == ["scripts/wheel", "packaging/install_wheel", "packaging/first_steps"]
    assert all((ROOT / program).stat().st_mode & 0o100 for program in programs)
    # The image's system is that of the bare roots in which wheels are tried.
    (system,) = (step for step in steps if step.startswith("apt-get"))
    installed = re.search(r"--no-install-recommends ([\w -]+?) &&", system)[1].split()
    bare = re.search(r'make_root "\$suite" "\$root" (\S+)$', script("try_wheel"), re.M)[1]
    assert installed == bare.split(",")
    for name in ("install_wheel", "first_steps"):
        assert f'in_root "$root" /try/{name}' in script("try_wheel")
        assert f"/tmp/{name}" in dockerfile


def script(name):
    return (ROOT / "scripts" / name).read_text()


@pytest.fixture
def clone(tmp_path):
    """The scripts of this tree with a version, in a repository of their own."""
    for name in ("release", "version", "common.sh"):
        (tmp_path / "scripts").mkdir(exist_ok=True)
        shutil.copy(ROOT / "scripts" / name, tmp_path / "scripts" / name)
    # What would build for half an hour.
    fake = tmp_path / "scripts" / "wheel"
    fake.write_text(
        "mkdir -p dist; cd dist; echo w > omma-1.2.3-cp312-abi3-x.whl; echo s > omma-1.2.3.tar.gz\n"
    )
    fake.chmod(0o755)
    tools = tmp_path / "build" / "wheel" / "tools" / "bin"  # not from PyPI in a test
    tools.mkdir(parents=True)
    for name in ("python", "cffconvert"):
        (tools / name).write_text("#!/bin/sh\n")
        (tools / name).chmod(0o755)
    (tmp_path / ".gitignore").write_text("build\ndist\n")
    (tmp_path / "CMakeLists.txt").write_text("project(omma VERSION 1.2.3 LANGUAGES CXX)\n")
    changes = "# Changelog\n\n## 1.2.3 (2026-11-23)\n\n- New.\n\n## 1.2.2 (2026-01-01)\n\n- Old.\n"
    (tmp_path / "CHANGELOG.md").write_text(changes)
    commit(tmp_path)
    return tmp_path


def commit(folder):
    run("git", "init", "-q", cwd=folder)
    run("git", "add", "-A", cwd=folder)
    who = ["-c", "user.name=a", "-c", "user.email=a@b"]
    assert run("git", *who, "commit", "-qm", "All", cwd=folder).returncode == 0


def test_a_release_has_checksums_and_its_changes(clone):
    done = run("bash", "scripts/release", "1.2.3", cwd=clone)
    assert done.returncode == 0, done.stderr
    assert (clone / "dist" / "CHANGES.md").read_text() == "## 1.2.3 (2026-11-23)\n\n- New.\n\n"
    assert run("sha256sum", "--check", "SHA256SUMS", cwd=clone / "dist").returncode == 0
    assert len((clone / "dist" / "SHA256SUMS").read_text().splitlines()) == 2


def test_a_release_is_refused(clone):
    def refusal(version="1.2.3"):
        done = run("bash", "scripts/release", version, cwd=clone)
        assert done.returncode == 1
        return done.stderr

    assert "CMakeLists.txt says 1.2.3" in refusal("1.2.4")
    (clone / "new").write_text("")
    assert "not committed" in refusal()
    (clone / "CHANGELOG.md").write_text("## 1.2.3 (unreleased)\n")
    commit(clone)
    assert "## 1.2.3 (unreleased)" in refusal()
    (clone / "CHANGELOG.md").write_text("## 1.2.3 (2026-11-23)\n")
    commit(clone)
    (clone / "dist").mkdir()
    (clone / "dist" / "omma-1.2.2.tar.gz").write_text("")
    assert "omma-1.2.2.tar.gz" in refusal()
