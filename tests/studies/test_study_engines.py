"""Workers that die, are interrupted or killed: no case is lost, none counted twice."""

from __future__ import annotations

import json
import multiprocessing
import os
import random
import signal
import subprocess
import sys
import time

import pytest
import xarray as xr
from small_studies import TINY, Silent, run_here, study_of
from worker_calls import die, die_at_first, double, fail, nap, threads

from flatland.results import load_dataset
from studies.command_line import _run
from studies.sweeps import engines, runner
from studies.sweeps.engines import Death, EngineLostError, Processes, Serial, Task, drive
from studies.sweeps.runner import run_study
from studies.sweeps.table import stable_part

_MAIN = "from studies.command_line import main; main()"
SWEEP = {"scenes": "tiny", "propagators": ["lpv", "dom8"], "bands": [1, 2, 3], "iterations": [2]}


def answers(engine, *tasks):
    named = [Task(str(i), call, arguments) for i, (call, *arguments) in enumerate(tasks)]
    found = [(task.key, answer) for task, answer in drive(engine, named)]
    assert len(found) == len(named) == len(dict(found))
    return [dict(found)[task.key] for task in named]


@pytest.mark.parametrize(
    "engine", [Serial(), pytest.param(Processes(2), marks=pytest.mark.slow)], ids=["serial", "two"]
)
def test_every_task_gets_its_answer_and_errors_are_deaths(engine):
    found = answers(engine, (double, 1), (fail, "why"), (double, 3))
    assert found == [2, Death("KeyError: 'why'"), 6]


def test_workers_are_other_processes_with_one_thread_and_leave_no_trace(monkeypatch):
    monkeypatch.setenv("FLATLAND_THREADS", "7")
    before = set(multiprocessing.active_children())
    ((own, blas, process),) = answers(Processes(1), (threads,))
    assert (own, blas) == ("1", "1")
    assert process != os.getpid()
    assert os.environ["FLATLAND_THREADS"] == "7"
    assert set(multiprocessing.active_children()) == before


def test_a_task_that_kills_its_worker_is_given_up_and_costs_no_other(tmp_path):
    """One dies whenever it is run, one only the first time; both break the pool of all."""
    found = answers(
        Processes(2), (nap, 0), (die, 0), (nap, 1), (die_at_first, tmp_path / "mark"), (double, 4)
    )
    assert found[0] == found[2] == "woke"
    assert isinstance(found[1], Death)
    assert "worker process died" in found[1].reason
    assert found[3:] == ["lived", 8]


def test_leaving_the_loop_ends_the_workers():
    before = set(multiprocessing.active_children())
    tasks = [Task(str(i), nap, (i,)) for i in range(50)]
    begin = time.perf_counter()
    generator = drive(Processes(2), tasks)
    next(generator)
    generator.close()
    assert time.perf_counter() - begin < 30  # 50 naps take 5 s with two workers
    assert set(multiprocessing.active_children()) == before


def test_a_lost_engine_is_no_failed_case():
    class Lost(Serial):
        def open(self):
            executor = super().open()

            def submit(*_):
                from concurrent.futures import Future

                future = Future()
                future.cancel()
                future.set_running_or_notify_cancel()
                return future

            executor.submit = submit
            return executor

    with pytest.raises(EngineLostError, match="finished cases are kept"):
        answers(Lost(), (double, 1))


@pytest.mark.slow
def test_a_case_whose_worker_dies_is_recorded_as_failed(tmp_path, monkeypatch):
    monkeypatch.setattr(runner, "run_case", die)
    monkeypatch.setattr(engines, "MOST_DEATHS", 1)
    study = study_of({"scenes": "tiny", "bands": 2, "reference": False})
    outcome = run_study(study, tmp_path, Processes(1), Silent())
    ((_, reason),) = outcome.failed
    assert "worker process died" in reason
    data = load_dataset(outcome.dataset)
    assert list(data["status"].values) == ["failed"]
    assert str(data["scene"].values[0]) == "tiny"


# -- the command, killed from outside -------------------------------------------------------------


@pytest.fixture
def study_file(tmp_path):
    path = tmp_path / "try.toml"
    path.write_text(study_of(SWEEP, tiny=TINY).to_toml(), encoding="utf-8")
    return path


def started(study_file, folder, *options):
    """The command in a process group of its own."""
    words = [sys.executable, "-c", _MAIN, "study", str(study_file), "-o", str(folder), *options]
    return subprocess.Popen(
        words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )


def finished(process):
    out, error = process.communicate(timeout=120)
    assert process.returncode == 0, out + error
    return out


def wait_for_cases(folder, count, process):
    """Until so many cases are stored, or the run is over."""
    while process.poll() is None and len(list((folder / "cases").glob("*.json"))) < count:
        time.sleep(0.01)


def assert_same_data(folder, other):
    first, second = (stable_part(load_dataset(each / "study.nc")) for each in (folder, other))
    xr.testing.assert_identical(first, second)


def kill_and_resume(study_file, tmp_path, kills, jobs):
    """Kill runs of one study at random moments, so often in all; gives each finished folder."""
    rng = random.Random(7)
    killed, round_ = 0, 0
    while killed < kills:
        folder = tmp_path / f"killed-{round_}"
        round_ += 1
        # A folder is used until its study is finished, so that runs die at all stages of it.
        for _ in range(5):
            process = started(study_file, folder, "--jobs", str(jobs))
            wait_for_cases(folder, rng.randrange(6), process)
            time.sleep(rng.uniform(0, 0.2))
            process.send_signal(signal.SIGKILL)
            process.communicate()
            killed += process.returncode == -signal.SIGKILL
            if killed == kills or process.returncode == 0:
                break
        finished(started(study_file, folder, "--jobs", str(jobs)))
        yield folder


def test_a_killed_study_resumed_gives_the_undisturbed_data_set(study_file, tmp_path):
    run_here(study_of(SWEEP, tiny=TINY), tmp_path / "calm")
    for folder in kill_and_resume(study_file, tmp_path, kills=2, jobs=1):
        assert_same_data(folder, tmp_path / "calm")
        assert not list(folder.rglob(".*"))


@pytest.mark.slow
def test_twenty_kills_change_no_number(study_file, tmp_path):
    finished(started(study_file, tmp_path / "calm", "--jobs", "2"))
    for folder in kill_and_resume(study_file, tmp_path, kills=20, jobs=2):
        assert_same_data(folder, tmp_path / "calm")
        assert not list(folder.rglob(".*"))


def test_an_interrupt_keeps_what_is_finished_and_says_how_to_go_on(study_file, tmp_path):
    folder = tmp_path / "folder"
    text = study_file.read_text(encoding="utf-8")
    study_file.write_text(text.replace("iterations = [2]", "iterations = [2, 400000]"))
    process = started(study_file, folder, "--jobs", "1")
    wait_for_cases(folder, 1, process)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    _, error = process.communicate(timeout=60)
    assert process.returncode == 130, error
    assert "interrupted; " in error
    assert f"flatland study --resume -o {folder}" in error
    assert "Traceback" not in error
    assert not list(folder.rglob(".*"))
    kept = len(list((folder / "cases").glob("*.json")))
    assert f"{kept} of 6 cases" in error


# -- Dask -----------------------------------------------------------------------------------------


@pytest.fixture
def cluster(tmp_path):
    """A scheduler and two workers, processes of their own on this machine; (address, workers)."""
    where = tmp_path / "scheduler.json"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": tmp_path}
    module = [sys.executable, "-m"]
    file = ["--scheduler-file", str(where), "--no-dashboard"]
    here = ["--host", "127.0.0.1", "--port", "0"]
    scheduler = subprocess.Popen([*module, "distributed.cli.dask_scheduler", *file, *here], **quiet)
    one = ["distributed.cli.dask_worker", *file, "--nthreads", "1", "--no-nanny"]
    workers = [subprocess.Popen([*module, *one], **quiet) for _ in range(2)]
    try:
        while not where.exists() or not where.read_text(encoding="utf-8"):
            assert scheduler.poll() is None
            time.sleep(0.05)
        yield json.loads(where.read_text(encoding="utf-8"))["address"], workers
    finally:
        for process in (*workers, scheduler):
            process.kill()
            process.wait()


def test_a_dask_worker_killed_in_the_middle_costs_no_case(study_file, tmp_path, cluster):
    address, workers = cluster
    folder = tmp_path / "dask"
    process = started(study_file, folder, "--dask", address)
    wait_for_cases(folder, 1, process)
    workers[0].kill()
    assert len(list((folder / "cases").iterdir())) < 6
    assert "6 cases done" in finished(process)
    run_here(study_of(SWEEP, tiny=TINY), tmp_path / "calm")
    assert_same_data(folder, tmp_path / "calm")


@pytest.mark.parametrize(
    "address",
    ["nonsense", "udp://1.2.3.4:5", pytest.param("tcp://127.0.0.1:9", marks=pytest.mark.slow)],
)
def test_an_address_without_a_scheduler_is_refused(address, study_file, capfd):
    """The last one is looked for in vain for a while."""
    assert _run(["study", str(study_file), "--dask", address]) == 2
    error = capfd.readouterr().err
    assert f"--dask = '{address}'" in error
    assert "no Dask scheduler" in error
    assert "Traceback" not in error
