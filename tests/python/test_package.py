"""The package as such: documented, typed, versioned."""

import ast
import importlib.metadata
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import omma


def public_things():
    for name in omma.__all__:
        thing = getattr(omma, name)
        if name.startswith("__"):
            continue
        yield name, thing
        if inspect.isclass(thing):
            for member, value in vars(thing).items():
                if not member.startswith("_") and name != "RenderReport":
                    yield f"{name}.{member}", value


@pytest.mark.parametrize("name", [name for name, _ in public_things()])
def test_everything_public_is_documented(name):
    assert (dict(public_things())[name].__doc__ or "").strip()


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
