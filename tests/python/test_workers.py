"""Renderers in worker processes: multiprocessing, joblib and Dask give the same bits as here."""

import multiprocessing
import os

import numpy as np
import pytest
from processes import Program

import omma

# Two workers that share few cores: more threads would only be in each other's way.
THREADS = 1


@pytest.fixture(scope="module")
def renderer(scene, eye):
    return omma.Renderer(scene, eye, omma.Fixed(4), threads=THREADS, noise="new_every_frame")


@pytest.fixture(scope="module")
def expected(renderer, flight):
    return renderer.render(flight, first_pose=0)


def rendered(renderer, poses, first_pose):
    return os.getpid(), renderer.render(poses, first_pose=first_pose)


def check(found, expected):
    """That the pieces, in order, are the whole, and that none was made in this process."""
    processes = {process for process, _ in found}
    assert os.getpid() not in processes
    assert (np.concatenate([responses for _, responses in found]) == expected).all()


def pieces(poses):
    """Two halves, each with the number of its first pose."""
    half = len(poses) // 2
    return [(poses[:half], 0), (poses[half:], half)]


@pytest.mark.parametrize("method", ["spawn", "forkserver"])
def test_spawned_processes(renderer, flight, expected, method):
    with multiprocessing.get_context(method).Pool(2) as pool:
        found = pool.starmap(rendered, [(renderer, *piece) for piece in pieces(flight)])
    check(found, expected)


def test_joblib(renderer, flight, expected):
    joblib = pytest.importorskip("joblib")
    with joblib.parallel_config("loky", inner_max_num_threads=THREADS):
        found = joblib.Parallel(n_jobs=2)(
            joblib.delayed(rendered)(renderer, *piece) for piece in pieces(flight)
        )
    check(found, expected)
    from joblib.externals.loky import get_reusable_executor

    get_reusable_executor().shutdown(wait=True)


def test_dask(renderer, flight, expected, tmp_path):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None,
        local_directory=tmp_path,
    ) as cluster, distributed.Client(cluster) as client:  # fmt: skip
        there = client.scatter(renderer, broadcast=True)
        tasks = [client.submit(rendered, there, *piece, pure=False) for piece in pieces(flight)]
        found = client.gather(tasks)
    check(found, expected)


def test_a_fork_after_rendering_unpickles_no_world(files):
    """What it inherits it renders with; a world, which has to be built, is refused with why."""
    text = (
        "import os, pickle, sys\n"
        "import omma\n"
        "eye = omma.Eye([[0, 1, 0]], [[0, 0, -1]], 0.3)\n"
        "renderer = omma.Renderer(omma.load_scene(sys.argv[1]), eye)\n"
        "expected = renderer.render((((0, 0, 0),), ((0, 0, 0, 1),)))\n"
        "data, an_eye = pickle.dumps(renderer), pickle.dumps(eye)\n"
        "if os.fork() == 0:\n"
        "    print((renderer.render((((0, 0, 0),), ((0, 0, 0, 1),))) == expected).all())\n"
        "    print(pickle.loads(an_eye) == eye)\n"
        "    try:\n"
        "        pickle.loads(data)\n"
        "    except omma.Error as error:\n"
        "        print(\"'spawn' or 'forkserver'\" in str(error), flush=True)\n"
        "    os._exit(0)\n"
        "os.wait()\n"
    )
    with Program(text, files / "scene.gltf") as program:
        assert program.end() == (0, "True\nTrue\nTrue\n", "")
