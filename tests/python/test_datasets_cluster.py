"""Data sets made by other processes: Dask workers, SLURM scripts, processes that are killed."""

import os
import random
import signal
import subprocess
import sys
import threading
import time

import pytest
from dataset_jobs import bytes_of, write_job

import omma
from omma import datasets

pytest.importorskip("zarr")

RUN = "import sys, omma; omma.datasets.run(sys.argv[1])"


@pytest.fixture(scope="module")
def job(tmp_path_factory):
    """A job of 30 shards, and its store made without disturbance."""
    path = write_job(tmp_path_factory.mktemp("cluster"), count=120)
    datasets.run(path, path.with_name("whole.zarr"))
    return path


@pytest.fixture(scope="module")
def whole(job):
    return bytes_of(job.with_name("whole.zarr"))


def test_kills_at_random_moments_leave_no_trace(job, whole):
    """bench/datasets.py does it fifty times."""
    store, rng = job.with_name("job.zarr"), random.Random(2)
    for _ in range(4):
        with subprocess.Popen([sys.executable, "-c", RUN, job]) as process:
            end = time.monotonic() + 60
            before = len(list(store.glob("omma/done/*.json")))
            # Until it has done something new, and a moment that differs each time.
            while len(list(store.glob("omma/done/*.json"))) <= before and process.poll() is None:
                assert time.monotonic() < end
                time.sleep(0.001)
            time.sleep(rng.uniform(0, 0.05))
            process.send_signal(signal.SIGKILL)
    datasets.run(job)
    assert bytes_of(store) == whole
    assert datasets.verify(store).is_whole
    assert not datasets.verify(store).left


def test_what_a_kill_left_is_removed(job, whole, tmp_path):
    """Files under temporary names, which nobody writes any more."""
    store = tmp_path / "left.zarr"
    datasets.run(job, store)
    (store / "omma" / "done" / "00000003.json").unlink()
    (store / "response" / ".c.3.0.0.0123456789ab.partial").write_bytes(b"half")
    assert len(datasets.verify(store).left) == 1
    assert datasets.run(job, store).made == 1
    assert bytes_of(store) == whole


@pytest.mark.parametrize("workers", [1, 2])
def test_dask_workers_make_the_same_store(job, whole, tmp_path, workers):
    distributed = pytest.importorskip("distributed")
    store = tmp_path / "dask.zarr"
    with distributed.LocalCluster(
        n_workers=workers, threads_per_worker=2, dashboard_address=None
    ) as cluster:
        report = datasets.run(job, store, dask=cluster.scheduler_address)
    assert report.made == 30
    assert bytes_of(store) == whole


def test_dask_workers_make_flow_and_shares(tmp_path):
    distributed = pytest.importorskip("distributed")
    job = write_job(
        tmp_path,
        dataset='outputs = ["responses", "flow", "shares"]\ninstances = ["crate"]',
        more='[[condition]]\nname = "crate"\n'
        'object = [{file = "crate.glb", position_m = [0, 5, 0]}]',
    )
    job.write_text(job.read_text() + "speed_m_s = [0.5, 1]\nturn_deg_s = [-100, -50]\n")
    omma.scene.save_scene(tmp_path / "crate.glb", omma.scene.box((8, 1, 8), name="crate"))
    datasets.run(job)
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None
    ) as cluster:
        datasets.run(job, tmp_path / "dask.zarr", dask=cluster.scheduler_address)
    made = bytes_of(tmp_path / "dask.zarr")
    assert any(name.startswith("flow/c.") for name in made)
    assert any(name.startswith("share/c.") for name in made)
    assert made == bytes_of(tmp_path / "job.zarr")


def test_a_worker_that_is_killed(job, whole, tmp_path):
    """Its shards are made by another."""
    distributed = pytest.importorskip("distributed")
    store = tmp_path / "dask.zarr"
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None
    ) as cluster:
        victim, killed = cluster.workers[0], []

        def kill():
            while not list(store.glob("omma/done/*.json")):
                time.sleep(0.005)
            os.kill(victim.pid, signal.SIGKILL)
            killed.append(victim.pid)

        killer = threading.Thread(target=kill)
        killer.start()
        datasets.run(job, store, dask=cluster.scheduler_address)
        killer.join()
    assert killed
    assert bytes_of(store) == whole


def test_a_scheduler_that_goes_away(job, whole, tmp_path):
    """An error that names it; what is done is kept."""
    pytest.importorskip("distributed")
    store = tmp_path / "dask.zarr"
    code = (
        "import time\n"
        "from distributed import LocalCluster\n"
        "if __name__ == '__main__':\n"
        "    cluster = LocalCluster(n_workers=1, processes=False, dashboard_address=None,\n"
        "                           threads_per_worker=1, host='tcp://127.0.0.1')\n"
        "    print(cluster.scheduler_address, flush=True)\n"
        "    time.sleep(120)\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, text=True
    ) as scheduler:
        address = scheduler.stdout.readline().strip()

        def kill():
            while not list(store.glob("omma/done/*.json")):
                time.sleep(0.005)
            scheduler.kill()

        killer = threading.Thread(target=kill)
        killer.start()
        with pytest.raises(omma.Error, match=r"the scheduler .* has gone away"):
            datasets.run(job, store, dask=address)
        killer.join()
    datasets.run(job, store)
    assert bytes_of(store) == whole


def test_no_scheduler(job, tmp_path, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("omma.datasets.cluster._TIMEOUT_S", 1)
    with pytest.raises(omma.Error, match=r"dask: no scheduler answers at 'tcp://127.0.0.1:9'"):
        datasets.run(job, tmp_path / "none.zarr", dask="tcp://127.0.0.1:9")


def test_the_script_of_a_job_in_slurm(tmp_path):
    pytest.importorskip("dask_jobqueue")
    from omma.datasets.cluster import slurm_cluster

    slurm = (
        '[slurm]\nqueue = "short"\ncores = 16\nmemory = "32GB"\nwalltime = "02:00:00"\n'
        'account = "bees"\ninterface = "lo"\n'
    )
    job = datasets.load_job(write_job(tmp_path, more=slurm))
    with slurm_cluster(job) as cluster:
        script = cluster.job_script()
    for line in ("-p short", "-A bees", "-t 02:00:00", "--cpus-per-task=16", "--mem=30G"):
        assert f"#SBATCH {line}" in script
    assert "distributed.cli.dask_worker tcp://127.0.0.1" in script
    assert "--nthreads" in script
    wrong = datasets.load_job(write_job(tmp_path, more='[slurm]\nqueue = "short"\n'))
    with pytest.raises(omma.Error, match="slurm: "):
        slurm_cluster(wrong)
