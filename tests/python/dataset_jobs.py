"""Small jobs of data sets that the tests make."""

import json
import os

import numpy as np
from conftest import make_eye, write_gltf

import omma

# What Linux says of a processor with AVX2, but of that only what is asked.
AVX2 = frozenset(
    ("sse4_2", "popcnt", "avx", "avx2", "fma", "f16c", "rdrand", "abm", "bmi1", "bmi2")
)

JOB = """
[dataset]
seed = 5
views_per_chunk = 2
views_per_shard = 4
{dataset}
[rendering]
samples = 2
{rendering}
[[scene]]
name = "ground"
file = "scene.gltf"
[[eye]]
name = "bug"
files = "bug.csv"
{more}
[[poses]]
name = "high"
sampler = "uniform"
low_m = [-5, 1, -5]
high_m = [5, 3, 5]
count = {count}
"""


def write_job(folder, *, count=10, dataset="", rendering="", more="", poses=None):
    """A job in a folder of its own, with a scene and an eye; its file."""
    folder.mkdir(exist_ok=True)
    if not (folder / "scene.gltf").exists():
        write_gltf(folder / "scene.gltf")
        omma.save_eye(folder / "bug.csv", make_eye(30))
    text = JOB.format(count=count, dataset=dataset, rendering=rendering, more=more)
    if poses is not None:
        text = text[: text.index("[[poses]]")] + poses
    path = folder / "job.toml"
    path.write_text(text)
    return path


def made_store(folder):
    """A job and its store, whole."""
    job = write_job(folder)
    store = job.with_name("made.zarr")
    report = omma.datasets.run(job, store)
    assert (report.views, report.shards, report.made) == (10, 3, 3)
    return job, store


def bytes_of(store):
    """Every file of a store but those that say when and where it was made, by name."""
    found = {}
    for path in store.rglob("*"):
        name = os.path.relpath(path, store)
        if path.is_file() and name != "zarr.json":
            if path.parent.name == "done":
                said = json.loads(path.read_text())
                found[name] = said["views"], said["files"]
            else:
                found[name] = path.read_bytes()
    return found


def rendered(job, poses):
    """What `render` gives for a job of `write_job`."""
    folder = job.parent
    scene = omma.load_scene(folder / "scene.gltf")
    eye = omma.load_eye(folder / "bug.csv")
    return omma.Renderer(scene, eye, omma.Fixed(2)).render(np.asarray(poses))
