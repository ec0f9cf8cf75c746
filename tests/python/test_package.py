"""The package as such: documented, typed, versioned."""

import ast
import importlib.metadata
import inspect
import os
import re
import subprocess
import sys
from graphlib import TopologicalSorter
from pathlib import Path

import pytest
from public_names import public_things, subpackages

import omma


def named_things():
    """Everything public and what belongs to it, by its full name; values are what they are."""
    for subpackage, name, thing in public_things():
        full = f"{subpackage}.{name}".strip(".")
        if inspect.isfunction(thing) or inspect.isclass(thing) or inspect.isbuiltin(thing):
            yield full, thing
        if inspect.isclass(thing):
            for member, value in vars(thing).items():
                is_field = member in getattr(thing, "__dataclass_fields__", {})
                if not member.startswith("_") and not is_field:
                    yield f"{full}.{member}", value


@pytest.mark.parametrize("name", [name for name, _ in named_things()])
def test_everything_public_is_documented(name):
    assert (dict(named_things())[name].__doc__ or "").strip()


@pytest.mark.parametrize("name", subpackages())
def test_every_room_says_what_it_is_for(name):
    assert len(subpackages()[name].__doc__.strip()) > 20


# From the lowest to the highest: a subpackage imports from those before it, and from itself.
SUBPACKAGES = [
    "_core", "base", "light", "receptors", "photoreceptors", "eye", "scene", "stimuli",
    "rendering", "motion", "species", "colour_vision", "picture", "study", "job", "datasets",
    "gym", "mujoco", "columns", "view", "cli",
]  # fmt: skip


def imports():
    """(file, its subpackage, module it imports, name it imports from there) in the whole
    package."""
    folder = Path(omma.__file__).parent
    for path in sorted(folder.rglob("*.py")):
        file = path.relative_to(folder)
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom) and node.module and len(file.parts) > 1:
                for alias in node.names:
                    module = f"omma.{alias.name}" if node.module == "omma" else node.module
                    if module.startswith("omma."):
                        yield str(file), file.parts[0], module, alias.name


def test_each_room_imports_downwards():
    found = list(imports())
    assert len(found) > 200
    assert {subpackage for _, subpackage, _, _ in found} == set(SUBPACKAGES) - {"_core"}
    for file, subpackage, module, _ in found:
        below = SUBPACKAGES[: SUBPACKAGES.index(subpackage) + 1]
        assert module.split(".")[1] in below, f"{file} imports {module}"


def test_no_imports_go_round():
    """Nor where they are made in functions, or for type checkers alone."""
    folder = Path(omma.__file__).parent
    importing = {}
    for file, _, module, name in imports():
        path = folder.joinpath(*module.split(".")[1:], name).with_suffix(".py")
        importer = f"omma.{file.removesuffix('.py').replace(os.sep, '.')}"
        importing.setdefault(importer, set()).add(f"{module}.{name}" if path.is_file() else module)
    assert len(importing) > 200
    TopologicalSorter(importing).prepare()  # an error names those that go round


def test_only_what_users_call_has_many_parameters():
    """There each is an option."""
    folder = Path(omma.__file__).parent
    for path in sorted(folder.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
                own = [one.arg for one in (*node.args.args, *node.args.kwonlyargs)]
                if len([name for name in own if name not in ("self", "cls")]) > 8:
                    decorators = {ast.unparse(one) for one in node.decorator_list}
                    is_front = decorators & {"checked", "overload"} or path.parent.name == "cli"
                    assert is_front, f"{path}: {node.name}"
                    assert node.name == "__init__" or not node.name.startswith("_"), node.name


def test_private_names_stay_in_their_room():
    for file, subpackage, module, name in imports():
        other = module.split(".")[1]
        if other not in (subpackage, "_core"):
            parts = (*module.split(".")[2:], name)
            assert not any(part.startswith("_") for part in parts), f"{file}: {module} {name}"


@pytest.mark.parametrize(
    "function", [thing for _, _, thing in public_things() if not inspect.isclass(thing)]
)
def test_functions_tell_their_parameters(function):
    if callable(function):
        assert inspect.signature(function) is not None


def test_measures_print_as_a_line():
    eye = omma.eye.generate_eye(200)
    assert repr(omma.eye.measure_eye(eye)).startswith("EyeMeasures(200 ommatidia, 1 eye, median Δφ")


@pytest.mark.parametrize(
    ("formula", "file"),
    [
        (r"sqrt\(5\)", "base/spirals.py"),
        (r"arcsin\(\w*\.?min\w*\(", "base/directions.py"),
        (r"2 \* math\.sqrt\(2\), math\.sqrt\(2\)", "picture/map_projections.py"),
        (r"_engine\.render\(|_core\.render_truth\(", "rendering/call.py"),
        (r"which is not installed", "base/optional.py"),
    ],
    ids=[
        "golden angle",
        "angle of a chord",
        "width and height of a map",
        "calls of the engine",
        "optional packages",
    ],
)
def test_formulas_stand_once(formula, file):
    folder = Path(omma.__file__).parent
    found = [path for path in folder.rglob("*.py") if re.search(formula, path.read_text("utf-8"))]
    assert [path.relative_to(folder).as_posix() for path in found] == [file]


def test_the_top_is_small():
    assert len([name for name in dir(omma) if name not in subpackages()]) <= 25
    assert set(dir(omma)) == set(omma.__all__)


def test_eyes_have_few_names():
    assert len(omma.eye.__all__) <= 40
    assert set(dir(omma.eye)) == set(omma.eye.__all__)


# Of omma.eye, before they had modules of their own.
MOVED = {
    "angles": "angle_table load_angle_table outline",
    "hexagonal": "DIRECTIONS NO_COORDINATE HexagonalCoordinates",
    "lattice": "Lattice LatticeCheck check_lattice",
    "scans": "ImportedEye LensConeEye import_lens_cone import_oda",
    "skew": "skew_rad squeeze_for_skew squeezed",
    "superposition": "Wiring fly_receptors neural_superposition_wiring pool receptor_wiring "
    "superposition_facets",
    "surfaces": "ellipsoid load_surface mesh_surface sphere",
}


@pytest.mark.parametrize("module", MOVED)
def test_old_names_of_eyes_work_with_a_warning(module):
    new_place = getattr(omma.eye, module)
    assert set(new_place.__all__) == set(MOVED[module].split())
    for name in MOVED[module].split():
        new = f"omma.eye.{module}.{name}"
        told = f"omma.eye.{name}: is called {new} now; the old name works until 0.2"
        with pytest.warns(DeprecationWarning, match=re.escape(told)) as warned:
            assert getattr(omma.eye, name) is getattr(new_place, name)
        assert {one.filename for one in warned} == {__file__}
        with pytest.warns(DeprecationWarning, match=re.escape(told)) as warned:
            exec(f"from omma.eye import {name}")
        assert {one.filename for one in warned} == {"<string>"}
    with pytest.raises(AttributeError, match="nonsense"):
        _ = omma.eye.nonsense


def test_importing_takes_nothing_heavy_along():
    heavy = ["numpy.linalg", "scipy", "matplotlib", "typer", "rich", "trimesh"]
    code = f"import sys, omma; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_help_of_the_command_takes_nothing_heavy_along():
    heavy = ["numpy", "scipy", "matplotlib", "omma.cli.render", "omma.rendering.renderer"]
    code = (
        "import sys\nfrom omma.cli.main import app\n"
        "app(['--help'], standalone_mode=False)\n"
        f"print([name for name in {heavy} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_version():
    assert omma.__version__ == importlib.metadata.version("omma")


def test_it_is_typed():
    assert (Path(omma.__file__).parent / "py.typed").is_file()
    assert (Path(omma.__file__).parent / "_core.pyi").is_file()


def signatures(stub):
    """What a stub says of each function and class: parameters and docstring, by qualified name."""
    found = {}

    def walk(body, prefix):
        for node in body:
            if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
                name = prefix + node.name
                parameters = ast.unparse(node.args) if isinstance(node, ast.FunctionDef) else ""
                found[name] = (parameters, ast.get_docstring(node))
                walk(node.body, name + ".")
            elif isinstance(node, ast.AnnAssign):
                found[prefix + ast.unparse(node.target)] = ast.unparse(node.annotation)

    walk(ast.parse(stub).body, "")
    return found


def test_the_stubs_are_those_of_the_module(tmp_path):
    pytest.importorskip("nanobind.stubgen")
    patterns = Path(__file__).resolve().parents[2] / "python" / "src" / "stub_patterns.txt"
    command = [sys.executable, "-m", "nanobind.stubgen", "-q", "-m", "omma._core"]
    subprocess.run([*command, "-p", patterns, "-o", tmp_path / "_core.pyi"], check=True)
    generated = signatures((tmp_path / "_core.pyi").read_text())
    kept = signatures((Path(omma.__file__).parent / "_core.pyi").read_text())
    assert len(kept) > 50
    assert kept == generated


def test_errors():
    assert issubclass(omma.Error, RuntimeError)
    assert omma.Error.__module__ == "omma"
