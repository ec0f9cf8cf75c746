"""The tutorials, run as a reader runs them: each notebook in an empty folder of its own, to its
end.

What a tutorial says in numbers it checks itself, by asserts in its cells. Here it is checked that
no cell fails, that nothing is said on standard error that the text does not explain (cells with the
tag "warns"), and that each ends with what is not simulated and what to try next.
"""

import re
from pathlib import Path

import pytest

jupytext = pytest.importorskip("jupytext")
nbclient = pytest.importorskip("nbclient")
pytest.importorskip("ipykernel")

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "tutorials"
TUTORIALS = sorted(page.stem for page in FOLDER.glob("*.md") if page.name != "index.md")
# Packages besides those of every test, and beyond what `import omma` needs.
NEEDS = ("matplotlib", "xarray", "zarr", "h5netcdf", "ephem")


def prose(notebook):
    return "\n".join(cell.source for cell in notebook.cells if cell.cell_type == "markdown")


@pytest.mark.parametrize("name", TUTORIALS)
def test_tutorial_runs(name, tmp_path, monkeypatch):
    for package in NEEDS:
        pytest.importorskip(package)
    monkeypatch.delenv("MPLBACKEND", raising=False)  # notebooks draw into themselves
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    folder = tmp_path / "notebook"
    folder.mkdir()
    notebook = jupytext.read(FOLDER / f"{name}.md")
    # A watchdog against hanging only: a cell takes seconds.
    client = nbclient.NotebookClient(
        notebook, timeout=900, kernel_name="python3", resources={"metadata": {"path": str(folder)}}
    )
    client.execute()  # raises what a cell raises, with the cell

    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert code
    for cell in code:
        said = [one.text for one in cell.outputs if one.get("name") == "stderr"]
        explained = "warns" in cell.metadata.get("tags", [])
        assert bool(said) == explained, f"{name}:\n{cell.source}\n{''.join(said)}"
    assert any("image/png" in one.get("data", {}) for cell in code for one in cell.outputs)


@pytest.mark.parametrize("animal", ["cataglyphis", "drosophila", "fiddler_crab"])
# Two of these see polarisation, which the world of that page does not follow.
@pytest.mark.filterwarnings("ignore:receptors have a polarisation sensitivity")
def test_the_world_of_a_bee_is_any_animals(animal, tmp_path, monkeypatch):
    for package in NEEDS:
        pytest.importorskip(package)
    pytest.importorskip("matplotlib").use("agg")
    monkeypatch.chdir(tmp_path)
    notebook = jupytext.read(FOLDER / "world-of-a-bee.md")
    code = "\n".join(cell.source for cell in notebook.cells if is_code(cell))
    # As the page says, and few of its ommatidia.
    for old, new in (
        ("honeybee_worker", animal),
        ("eyes = bee.eye\n", "eyes = bee.eye.take(range(0, len(bee.eye), len(bee.eye) // 400))\n"),
    ):
        assert code.count(old) == 1
        code = code.replace(old, new)
    exec(code, {})
    assert (tmp_path / "daylight.png").is_file()


@pytest.mark.parametrize("name", TUTORIALS)
def test_tutorial_says_what_one_needs_to_know(name):
    notebook = jupytext.read(FOLDER / f"{name}.md")
    assert notebook.metadata.kernelspec.name == "python3"
    first = notebook.cells[0].source
    assert re.match(r"# .+\n\n.+takes .+ to read.+need", first), "what, how long, what is needed"
    headings = re.findall(r"^## (.+)$", prose(notebook), re.MULTILINE)
    assert headings[-2:] == ["What is not simulated here", "What to try next"]
    longest = max(len(cell.source.split("\n")) for cell in notebook.cells if is_code(cell))
    assert longest <= 45, "short cells, not walls"


def is_code(cell):
    return cell.cell_type == "code"


@pytest.mark.parametrize("name", [*TUTORIALS, "index"])
def test_links_lead_to_files(name):
    text = (FOLDER / f"{name}.md").read_text()
    links = [link for link in re.findall(r"\]\(([^)]+)\)", text) if "://" not in link]
    assert links
    for link in links:
        assert (FOLDER / link.split("#")[0]).is_file(), link


def test_index_names_every_tutorial():
    text = (FOLDER / "index.md").read_text()
    assert sorted(re.findall(r"\]\(([\w-]+)\.md\)", text)) == TUTORIALS
