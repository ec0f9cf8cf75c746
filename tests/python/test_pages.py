"""What the pages say to type, typed: every Python snippet and every command of README.md, docs and
examples, in a folder that holds what the page speaks of.

A snippet is a fenced block of Python, a command a line of an indented block. All of a page's
snippets run after one another in one Python, all of its commands in one folder. A command of Omma's
alone runs in this process, as most of its time would be importing the same again; those of the page
about installing, and those that need a shell or Python, run in a shell. What is not run is listed
here with the reason; a command that is neither run nor listed fails.
"""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from capture_files import write_transforms
from conftest import DATA

import omma

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted(
    str(page.relative_to(ROOT))
    for page in [ROOT / "README.md", *ROOT.glob("docs/*.md"), *ROOT.glob("examples/**/*.md")]
)
COMPOUND_RAY = DATA / "compound-ray"

# And what besides, ahead of a snippet of a page (counted from 0).
GIVEN_BESIDES = {
    "docs/datasets.md": {
        4: """
import omma
files = ["flight.zarr", "seen.csv"]
omma.render_file("meadow.glb", files, eyes="honeybee.eye", path="flight.csv")
"""
    },
    "docs/scenes.md": {
        6: """
import numpy as np
header = "ply\\nformat ascii 1.0\\nelement vertex 9000\\n" + "".join(
    f"property {kind}\\n" for kind in ("float x", "float y", "float z", "uchar classification")
)
rows = np.random.default_rng(1).random((9000, 4)) * (0.3, 0.3, 0.01, 2) + (0, 0, 0, 2)
rows[:, 3] = np.floor(rows[:, 3])
np.savetxt("scan.ply", rows, "%.5g", header=header + "end_header", comments="")
""",
    },
    "docs/receptors.md": {
        1: """
assert responses.shape == (2, 43040) == (2, len(eye.receptor_type))
""",
        # A smaller eye, on which what follows takes a second.
        3: "eye = omma.eye.generate_eye(300)",
    },
}

# What a page says comes out of it.
COMES_OUT = {
    "README.md": "assert responses.shape == errors.shape == (1, 10760, 3)",
    "docs/closed-loops.md": "assert observations.shape == (64, 200, 3) and responses.any()",
    "docs/colours.md": """
assert f"{colour_vision.noise_limited_distance(one, other, noise, photon_noise=True):.1f}" == "2.7"
assert abs(found.distance_m - 1.71) < 0.01 + 4 * found.standard_error_m
""",
    "docs/datasets.md": """
assert evening.sizes["view"] == 40 and len(views) == 80
assert few.sizes["view"] == 20 and again.shape[1:] == data.response.shape[1:]
assert 0 < ahead.sizes["ommatidium"] < data.sizes["ommatidium"]
""",
    "docs/eyes.md": """
assert f"{math.degrees(fly.width_rad()):.1f}" == "2.2"
assert len(omma.load_eye("head.csv")) == len(head)
""",
    "docs/fly-columns.md": """
assert table.r1_6.shape == (1, 1696) and movie.shape == (1, 3, 1, 721)
assert data.sizes["column"] == 1696
""",
    "docs/learning.md": """
assert batch["response"].shape == (16, 200, 3) and batch["yaw_deg"].shape == (16,)
assert (out == responses).all() and out.any()
assert slope[0, 1] < 0  # towards where it saw it
""",
    "docs/gallery.md": "import glob; assert len(glob.glob('gallery-*.png')) == 10",
    "docs/materials.md": "assert photons.shape == (1, 77_232) and (photons >= 0).all()",
    "docs/motion-detection.md": """
assert left < 0 < right
assert np.nanmean(motion[level, 0]) > 0.01
assert light.shape == (1, 3, 1, 721) and published.q.tolist() == [0, 1]
""",
    "docs/mujoco.md": "assert responses.shape == (1, 1000, 3) and lit.lighting == 'path'",
    "docs/receptors.md": """
assert cartridges.shape == (2, 300) and responses.shape == (2, 300, 3)
assert photons.shape == (2, 300) and (photons > 0).any()
""",
    "docs/sampling.md": "assert report.rays.shape == (1, 10_760) and (low <= high).all()",
    "docs/start.md": """
assert flight.shape == (3, 10760, 3) and inside.min() < 0.5 < inside.max()
assert len(receptors) == 1 and len(eye) == 10_760 and responses.shape == (10_760, 3)
""",
    "examples/from_compoundray.md": """
old = np.array(frames) / 255.0  # the same picture, within sampling and 8 bits
new = np.clip(responses, 0, 1) ** (1 / 2.2)
assert np.abs(new - old).mean() < 2 / 255
""",
}

INSTALLING = "docs/install.md"
NEEDS_DATA = "examples/from_compoundray.md"

# What docs/datasets.md speaks of, but smaller.
JOB = """
[rendering]
samples = 1
[[scene]]
file = "meadow.glb"
[[eye]]
files = "honeybee.eye"
[[condition]]
name = "day"
[[condition]]
name = "evening"
background = "0.5,0.2,0.1"
[[poses]]
sampler = "uniform"
low_m = [-4, 1, -8]
high_m = [4, 2, 0]
count = 40
"""

# Reflectances in per cent, and an irradiance as Ocean Optics writes it, made up.
PETALS = "wl,white,red\n300,5,3\n400,40,3\n500,70,4\n600,71,50\n700,72,61\n"
DAYLIGHT = """Date: noon
>>>>>Begin Spectral Data<<<<<
250,0\t-0,5
300,0\t1,0
500,0\t120,0
700,0\t110,0
"""

# Pages whose snippets need a package that is not one of all tests.
NEEDS_PACKAGE = {"docs/mujoco.md": ("mujoco",), "docs/learning.md": ("torch", "jax")}

# Pages whose snippets are not run, and why.
SNIPPETS_NOT_RUN: dict[str, str] = {}

# Commands that are not run, by regular expressions of how they begin, and why.
NOT_RUN = {
    r"\. \.venv/bin/activate": "a shell's own matter",
    "scripts/quickstart": "installs; scripts/test starts with the same set-up",
    "scripts/test": "it is what runs this",
    "scripts/blender_addon": "fetches Blender; test_blender_addon.py runs it without",
    "omma view": "goes on until Ctrl-C; test_view_command.py",
    "scripts/bench": "ten minutes, and says nothing on a machine with other work",
    "scripts/web": "twenty minutes; test_web_page.py tries what it makes",
    "pip install": "installs; it is what scripts/setup does",
    "omma dataset run job.toml --": "needs a cluster; test_datasets_cluster.py has a small one",
    "omma render-cameras examples/meadow.glb": "half a minute; test_cameras.py has smaller",
    "omma render examples/meadow_lit.glb .*lighting=baked": "minutes; test_first_light.py: small",
    "omma measure min-samples examples/meadow.glb": "two minutes; see the next",
    "omma measure min-samples arena.gltf": "minutes; test_sampling_tools.py has smaller ones",
    "omma measure variance-map meadow.glb": "minutes; test_sampling_tools.py has smaller ones",
    "omma measure aliasing meadow.glb": "minutes; test_sampling_tools.py has smaller ones",
    "omma measure speed arena.gltf": "minutes; test_speed_test.py has smaller ones",
    "python bench/many_cameras.py": "a minute; test_many_cameras.py has it smaller",
    r"(\.venv/bin/)?python docs/make_": "figures and tables of the pages: minutes to half an hour",
    "cd compound-ray": "needs a clone of CompoundRay's repository; test_compoundray.py",
    "mkdir -p build/make/lib": "see above",
    "ln -s ": "see above",
    "cd python-examples": "see above",
    "OMMA_COMPAT_KERNEL=gaussian": "see above",
    "python examples/localisation/localise.py": "minutes; test_localisation.py has it small",
    "python examples/python/corridor.py": "minutes; test_corridor_example.py has it small",
    "python examples/python/evolve_eye.py": "a minute; test_evolve_example.py has it small",
    "python examples/python/acute_zone.py": "a minute; test_acute_zone_example.py has it small",
    "python examples/python/ppo_corridor.py": "minutes; test_ppo_example.py has it small",
    "python examples/python/t4t5.py": "minutes; test_t4t5_example.py has it small",
    "python examples/python/looming_and_target.py": "a minute; test_motion_example.py has it small",
}

# Indented blocks that are no commands: what comes out, formulas, lines of files.
NO_COMMANDS = (r"[\d,]+ rays", "rays  ", "# receptor_type", "R_t = ", "R = ", "[\u2212+]0\\.0")


def blocks(page, kind):
    """The fenced Python ("python") or the indented blocks ("") of a page, from the top."""
    found, lines, in_fence, body = [], (ROOT / page).read_text().split("\n"), None, []
    for line in [*lines, ""]:
        if in_fence is not None:
            if line == "```":
                if in_fence == kind:
                    found.append("\n".join(body))
                in_fence, body = None, []
            else:
                body.append(line)
        elif line.startswith("```"):
            in_fence, body = line[3:], []
        elif kind == "":
            if line.startswith("    "):
                body.append(line[4:])
            elif body:
                found.append("\n".join(body))
                body = []
    return found


def given():
    """What pages that do not begin with an import take as given, as docs/start.md has it."""
    return blocks("docs/start.md", "python")[-1]


def commands(page):
    """Lines of shell; one that ends in a backslash goes on in the next."""
    no_command = re.compile("|".join(NO_COMMANDS))
    shell = [block for block in blocks(page, "") if not no_command.match(block)]
    return [line for block in shell for line in block.replace("\\\n", " ").split("\n") if line]


def spoken_of(page):
    """Commands in the text of a page, between backquotes and with a file to write."""
    return re.findall(r"`(omma [^`]* -o [^` ]+\.\w+)`", (ROOT / page).read_text())


@pytest.fixture
def folder(tmp_path):
    """What pages speak of: the clone's files where README.md has them, and beside, as the other
    pages do, a meadow and eyes."""
    examples = ROOT / "examples"
    (tmp_path / "examples").mkdir()
    for name in examples.iterdir():
        if name.name != "flight.csv":
            (tmp_path / "examples" / name.name).symlink_to(name)
    few_poses = (examples / "flight.csv").read_text().splitlines()[:4]
    for path in (tmp_path / "flight.csv", tmp_path / "examples" / "flight.csv"):
        path.write_text("\n".join(few_poses) + "\n")
    (tmp_path / "job.toml").write_text(JOB)
    for name in ("meadow.glb", "garden.glb"):
        (tmp_path / name).symlink_to(examples / "meadow.glb")
    left, right = (examples / f"honeybee_worker_{side}.eye" for side in ("left", "right"))
    for name, eye in (("left", left), ("right", right), ("bee", left)):
        (tmp_path / f"{name}.eye").symlink_to(eye)
    for eye in (left, right):
        (tmp_path / eye.name).symlink_to(eye)
    few = tmp_path / "honeybee.eye"  # every twentieth, for what takes many rays
    few.write_text("\n".join([*left.read_text().splitlines()[::20], ""]))
    receptors = omma.receptors.assign_receptors(
        omma.load_eye(few), omma.receptors.honeybee_ommatidia()
    )
    omma.save_eye(tmp_path / "bee.csv", receptors)
    crossed = [
        omma.receptors.ReceptorType(
            name, peak_wavelength_nm=345, microvillus_angle_rad=angle, polarisation_sensitivity=6.3
        )
        for name, angle in (("along", 0), ("across", np.pi / 2))
    ]
    rim = omma.receptors.assign_receptors(
        receptors, omma.receptors.OmmatidiumType("rim", crossed), where=lambda a, e: e > 1
    )
    omma.save_eye(tmp_path / "rim.csv", rim)
    around = [omma.look_at((x, 1, 3), (0, 0, 0)) for x in (-1, 0, 1)]
    write_transforms(tmp_path / "transforms.json", around)
    (tmp_path / "petals.csv").write_text(PETALS)
    (tmp_path / "daylight.txt").write_text(DAYLIGHT)
    if COMPOUND_RAY.is_dir():
        scenes = COMPOUND_RAY / "scenes"
        (tmp_path / "eyes").symlink_to(scenes / "eyes")
        for name in ("ofstad-arena.gltf", "arena.gltf"):
            (tmp_path / name).symlink_to(scenes / "ofstad-arena.gltf")
        for eye in scenes.glob("*.eye"):
            (tmp_path / eye.name).symlink_to(eye)
    library = tmp_path / "build" / "make" / "lib"
    library.mkdir(parents=True)
    (library / "libEyeRenderer3.so").symlink_to(omma.compat.compoundray_library())
    return tmp_path


def run(command, folder):
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"PATH": path, "MPLBACKEND": "Agg"}
    # A watchdog against hanging only: each takes seconds.
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=900
    )


@pytest.mark.parametrize(
    "page", [page for page in PAGES if blocks(page, "python") and page not in SNIPPETS_NOT_RUN]
)
def test_snippets_run(page, folder):
    if page == NEEDS_DATA and not COMPOUND_RAY.is_dir():
        pytest.skip(f"needs {COMPOUND_RAY}, which is not here")
    for package in NEEDS_PACKAGE.get(page, ()):
        pytest.importorskip(package)
    snippets, besides = blocks(page, "python"), GIVEN_BESIDES.get(page, {})
    parts = [] if snippets[0].startswith(("import ", "from ")) else [given()]
    for number, snippet in enumerate(snippets):
        parts += [besides.get(number, ""), snippet]
    (folder / "page.py").write_text("\n".join([*parts, COMES_OUT.get(page, "")]))
    done = run([sys.executable, "page.py"], folder)
    assert done.returncode == 0, f"{page}:\n{done.stderr}"
    if page == "docs/sampling.md":
        said = "".join(block for block in blocks(page, "") if re.match(r"[\d,]+ rays", block))
        # Where rounding differs, as between instruction sets, a few ommatidia take a round more.
        assert numbers(done.stdout) == pytest.approx(numbers(said), rel=0.02)


def numbers(text):
    return [float(word.replace(",", "")) for word in re.findall(r"\d[\d,]*(?:\.\d+)?", text)]


def test_the_first_page_makes_the_spectra_that_others_take():
    makes = (ROOT / "docs/start.md").read_text().replace(r"\t", "\t").replace(r"\n", "\n")
    for text in (PETALS, *DAYLIGHT.splitlines()):
        assert text in makes


@pytest.mark.parametrize("page", [page for page in PAGES if commands(page) or spoken_of(page)])
def test_commands_run(page, folder, run_omma, monkeypatch):
    monkeypatch.chdir(folder)
    failed = []
    for command in [*commands(page), *spoken_of(page)]:
        if any(re.match(beginning, command) for beginning in NOT_RUN):
            continue
        if "arena.gltf" in command and not COMPOUND_RAY.is_dir():
            continue
        assert command.startswith(("omma ", "python ")), f"{page}: what is this? {command}"
        if page == INSTALLING or not command.startswith("omma ") or re.search(r"[$|<>&;]", command):
            done = run(["bash", "-c", command], folder)
            code, said = done.returncode, done.stderr
        else:
            code, _, said = run_omma(*shlex.split(command, comments=True)[1:])
        if code != 0:
            failed.append(f"{command}\n{said}")
    assert not failed, f"{page}:\n" + "\n".join(failed)


def test_what_is_not_run_is_on_a_page():
    """So that the lists above do not outlive the pages."""
    everything = [c for page in PAGES for c in [*commands(page), *spoken_of(page)]]
    indented = [block for page in PAGES for block in blocks(page, "")]
    for beginning in NOT_RUN:
        assert any(re.match(beginning, command) for command in everything), beginning
    for beginning in NO_COMMANDS:
        assert any(re.match(beginning, block) for block in indented), beginning
    for page in {*GIVEN_BESIDES, *COMES_OUT, *SNIPPETS_NOT_RUN, *NEEDS_PACKAGE}:
        assert blocks(page, "python"), page


def test_pages_that_are_named_are_there():
    """In docstrings, messages and comments, which a merge of two pages is quick to forget."""
    sources = {".py", ".pyi", ".h", ".cpp", ".cu", ".toml", ""}
    folders = ("python", "src", "include", "tests", "scripts", "examples", "bench", "blender")
    missing = []
    for path in (path for folder in folders for path in (ROOT / folder).rglob("*")):
        if path.suffix in sources and path.is_file():
            text = path.read_text(encoding="utf-8", errors="replace")
            named = set(re.findall(r"\bdocs/[\w-]+\.md\b", text))
            missing += [f"{path}: {name}" for name in named if not (ROOT / name).is_file()]
    assert not missing, "\n".join(missing)
