"""Nothing is lost: a full disk, signals, two runs in one directory, damaged files, a directory that goes away.

Two squares with a joint (test_wrong_decks), pressed by the explicit solver, which goes on bit for bit.
"""

import fcntl
import os
import random
import resource
import signal
import subprocess
import time

import h5py
import pytest

from femdem.results import Fields, ResultsError
from test_wrong_decks import MESH

DECK = """
&run mesh = 'box.msh', solver = 'SOLVER' /
&material group = 'rock', density = 2700, young = 30e9, poisson = 0.27 /
&joint group = 'fracture', law = 'coulomb', friction_angle = 30, kn_mpa_mm = 10, ks_mpa_mm = 5 /
&contact friction_angle = 30 /
&boundary group = 'bottom', vx = 0, vy = 0 /
&boundary group = 'top', pressure = 5e6 /
&stage name = 'load', move_time = 0.01, cycles = CYCLES /
&output directory = 'results', EVERY /
"""
STATUS_STOPPED = 3
ALWAYS = "fields_every = 1, checkpoint_minutes = 0"
SELDOM = "history_every = 7, fields_every = 10, checkpoint_minutes = 100"


def write(folder, solver="explicit", cycles=12, every=ALWAYS):
    """Mesh and deck; the deck's name"""
    (folder / "box.msh").write_text(MESH)
    deck = DECK.replace("SOLVER", solver).replace("CYCLES", str(cycles)).replace("EVERY", every)
    (folder / "deck.nml").write_text(deck)
    return "deck.nml"


def run(femdem, folder, *arguments, **options):
    return subprocess.run(
        [femdem, "--quiet", *arguments, "deck.nml"],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        **options,
    )


def go_on(femdem, folder, name):
    return run(femdem, folder, "--restart", f"{name}/checkpoint.h5", "--output", name)


def snapshots(path):
    """Times of the snapshots in a file"""
    with h5py.File(path) as file:
        return [file[name].attrs["time_s"] for name in sorted(file) if name.startswith("step_")]


def same_results(one, other):
    for name in ("history.csv", "edges.csv"):
        assert (one / name).read_bytes() == (other / name).read_bytes(), f"another {name}"
    assert snapshots(one / "fields.h5") == snapshots(other / "fields.h5")


# ---- A full disk -----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def whole(femdem, tmp_path_factory):
    """A run that nothing has stopped"""
    folder = tmp_path_factory.mktemp("whole")
    write(folder)
    assert run(femdem, folder).returncode == 0
    return folder / "results"


@pytest.mark.fast
@pytest.mark.parametrize("kilobytes", range(26, 206, 12))
def test_a_full_disk_ends_the_run_and_it_goes_on_when_there_is_room(kilobytes, femdem, whole, tmp_path):
    """Played by the largest size of a file; fields.h5 comes to 215 kB, and each limit meets another part of it"""
    write(tmp_path)

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (1024 * kilobytes, resource.RLIM_INFINITY))

    done = run(femdem, tmp_path, preexec_fn=limit)
    assert done.returncode == 1, done.stderr
    assert "disk full?" in done.stderr
    assert len(done.stderr.splitlines()) == 1, done.stderr
    results = tmp_path / "results"
    before = snapshots(results / "fields.h5")
    assert before == snapshots(whole / "fields.h5")[: len(before)]
    if (results / "checkpoint.h5").exists():
        done = go_on(femdem, tmp_path, "results")
    else:
        assert kilobytes < 50
        done = run(femdem, tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    same_results(results, whole)


@pytest.mark.fast
@pytest.mark.parametrize("damage", ["cut short", "emptied", "overwritten"])
def test_a_fields_file_that_cannot_be_read_is_set_aside(damage, femdem, whole, tmp_path):
    write(tmp_path, cycles=12)
    assert run(femdem, tmp_path).returncode == 0
    fields = tmp_path / "results" / "fields.h5"
    content = fields.read_bytes()
    cut = {"cut short": content[: len(content) // 2], "emptied": b"", "overwritten": bytes(len(content))}
    fields.write_bytes(cut[damage])
    done = go_on(femdem, tmp_path, "results")
    assert done.returncode == 0, done.stderr
    assert "it is set aside as results/fields.h5.damaged" in done.stderr
    # The library makes a file of an empty one
    if damage != "emptied":
        assert (tmp_path / "results" / "fields.h5.damaged").read_bytes() == cut[damage]
    assert (tmp_path / "results" / "history.csv").read_bytes() == (whole / "history.csv").read_bytes()


@pytest.mark.fast
def test_a_fields_file_that_a_kill_left_half_way_says_what_to_do(femdem, tmp_path):
    """(That nothing of it is lost: unit test of fields.h5, kills.py)"""
    write(tmp_path, cycles=2)
    assert run(femdem, tmp_path).returncode == 0
    fields = tmp_path / "results" / "fields.h5"
    assert not (tmp_path / "results" / "fields.h5.writing").exists()
    fields.write_bytes(fields.read_bytes()[:100])
    with pytest.raises(ResultsError, match="cannot be read") as without:
        Fields(fields)
    assert "--restart" not in str(without.value)
    (tmp_path / "results" / "fields.h5.writing").write_text("")
    with pytest.raises(ResultsError, match="when that goes on"):
        Fields(fields)
    # More than a kill has damaged it: nothing is lost of that either
    done = go_on(femdem, tmp_path, "results")
    assert done.returncode == 2, done.stderr
    assert "move it away to go on without it" in done.stderr
    fields.rename(tmp_path / "away.h5")
    assert go_on(femdem, tmp_path, "results").returncode == 0


# ---- Two runs in one directory ---------------------------------------------------------------------------------------


def hear_signals():
    """Signals that nohup or a shell in the background has ignored, which the program then leaves ignored"""
    for name in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        signal.signal(name, signal.SIG_DFL)


@pytest.fixture
def endless(femdem, tmp_path):
    """A run that goes on for minutes, and its directory"""
    write(tmp_path, cycles=2000000, every=SELDOM)
    with subprocess.Popen(
        [femdem, "--quiet", "deck.nml"],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=hear_signals,
    ) as process:
        wait_for_rows(tmp_path / "results" / "history.csv", 3)
        yield process, tmp_path
        if process.poll() is None:
            process.kill()


def wait_for_rows(path, number, process=None):
    """Until a table has more lines than that, or the run has ended"""
    end = time.monotonic() + 30
    while time.monotonic() < end:
        if path.exists() and path.read_text(encoding="utf-8").count("\n") > number:
            return
        if process and process.poll() is not None:
            return
        time.sleep(0.01)
    raise AssertionError(f"{path} does not grow")


@pytest.mark.fast
def test_a_second_run_in_the_same_directory_is_refused(femdem, endless):
    process, folder = endless
    before = (folder / "results" / "deck.nml").read_bytes()
    for arguments in ((), ("--restart", "results/checkpoint.h5")):
        done = run(femdem, folder, *arguments)
        assert done.returncode == 2
        assert f"results is in use: process {process.pid} on " in done.stderr
    assert process.poll() is None
    assert (folder / "results" / "deck.nml").read_bytes() == before
    assert run(femdem, folder, "--check").returncode == 0
    # Killed without a chance to clean up: the lock stays, and is taken over
    process.kill()
    process.wait()
    assert (folder / "results" / "run.lock").exists()
    write(folder)
    done = run(femdem, folder)
    assert done.returncode == 0, done.stderr
    assert "has gone, is taken over" in (folder / "results" / "run.log").read_text()
    assert not (folder / "results" / "run.lock").exists()


@pytest.mark.fast
@pytest.mark.parametrize(
    ("content", "expect"),
    [
        ("1\n{host}\n2026-01-01 00:00:00\n-5\n", None),
        ("4711\nelsewhere.example\n2026-01-01 00:00:00\n17\n", "cannot be seen from here"),
        ("", "does not say whose it is"),
        ("\0\0\0", "does not say whose it is"),
    ],
    ids=["same number, other process", "another machine", "empty", "damaged"],
)
def test_locks_of_others(content, expect, femdem, tmp_path):
    write(tmp_path, cycles=1)
    (tmp_path / "results").mkdir()
    lock = tmp_path / "results" / "run.lock"
    lock.write_text(content.format(host=os.uname().nodename))
    done = run(femdem, tmp_path)
    assert done.returncode == (2 if expect else 0), done.stderr
    assert (expect or "") in done.stderr
    assert lock.exists() == bool(expect)


@pytest.mark.fast
def test_only_one_run_takes_over_a_stale_lock(femdem, tmp_path):
    """A run that is to look at a lock waits while another one does, and sees what that one has left"""
    write(tmp_path, cycles=1)
    results = tmp_path / "results"
    results.mkdir()
    lock = results / "run.lock"
    stale = f"1\n{os.uname().nodename}\n2026-01-01 00:00:00\n-5\n"
    lock.write_text(stale)
    looking = os.open(results, os.O_RDONLY)
    fcntl.flock(looking, fcntl.LOCK_EX)
    with subprocess.Popen(
        [femdem, "deck.nml"], cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    ) as process:
        time.sleep(0.5)
        assert process.poll() is None
        assert lock.read_text() == stale
        lock.write_text(f"{os.getpid()}\n{os.uname().nodename}\n2026-01-01 00:00:00\n\n")
        os.close(looking)
        said = process.communicate(timeout=30)[1]
    assert process.returncode == 2
    assert f"results is in use: process {os.getpid()} on " in said


@pytest.mark.fast
def test_of_many_runs_that_start_at_once_one_goes_on(femdem, whole, tmp_path):
    """In a directory with a stale lock; the results are those of a run alone"""
    write(tmp_path)
    (tmp_path / "results").mkdir()
    lock = tmp_path / "results" / "run.lock"
    for _ in range(3):
        lock.write_text(f"1\n{os.uname().nodename}\n2026-01-01 00:00:00\n-5\n")
        runs = [
            subprocess.Popen([femdem, "--quiet", "deck.nml"], cwd=tmp_path, stderr=subprocess.PIPE, text=True)
            for _ in range(6)
        ]
        said = [one.communicate(timeout=120)[1] for one in runs]
        ended = [one.returncode for one in runs]
        # One after the other does no harm, two at once would
        assert set(ended) <= {0, 2}, said
        assert ended.count(0) >= 1
        assert all("is in use" in text for text, end in zip(said, ended, strict=True) if end == 2)
        assert not lock.exists()
        same_results(whole, tmp_path / "results")


# ---- Damaged checkpoints ---------------------------------------------------------------------------------------------


@pytest.mark.fast
def test_every_damaged_checkpoint_is_refused(femdem, whole, tmp_path):
    """A byte changed anywhere, or the end missing"""
    write(tmp_path)
    good = (whole / "checkpoint.h5").read_bytes()
    path = tmp_path / "checkpoint.h5"
    chance = random.Random(11)
    damaged = []
    for _ in range(120):
        place = chance.randrange(len(good))
        other = bytes([good[place] ^ chance.randrange(1, 256)])
        damaged.append(good[:place] + other + good[place + 1 :])
    damaged += [good[:length] for length in (0, 10, len(good) // 2, len(good) - 1)] + [good + b"\n"]
    for content in damaged:
        path.write_bytes(content)
        done = run(femdem, tmp_path, "--restart", "checkpoint.h5")
        assert done.returncode == 2, done.stderr
        assert len(done.stderr.splitlines()) == 1, done.stderr
        assert "checkpoint.h5: the checkpoint " in done.stderr
    path.write_bytes(good)
    assert run(femdem, tmp_path, "--restart", "checkpoint.h5").returncode == 0


@pytest.mark.fast
def test_the_checksum_does_not_disturb_readers_of_the_checkpoint(whole):
    with h5py.File(whole / "checkpoint.h5") as file:
        assert file.attrs["cycle"] == 12
        assert file["displacement"].shape == (8, 2)


# ---- Signals ---------------------------------------------------------------------------------------------------------


@pytest.mark.fast
@pytest.mark.parametrize("name", ["SIGTERM", "SIGINT", "SIGHUP"])
def test_a_signal_keeps_what_was_done(name, endless):
    process, folder = endless
    process.send_signal(getattr(signal, name))
    said = process.communicate(timeout=20)[1]
    assert process.returncode == STATUS_STOPPED, said
    assert f"stopped by {name}; kept is all up to cycle" in said
    assert "femdem --restart results/checkpoint.h5 deck.nml" in said
    results = folder / "results"
    assert not (results / "run.lock").exists()
    with h5py.File(results / "checkpoint.h5") as file:
        cycle, now = int(file.attrs["cycle"]), file.attrs["time"]
    last = (results / "history.csv").read_text().splitlines()[-1].split(",")
    assert int(last[3]) == cycle
    assert snapshots(results / "fields.h5")[-1] == now


@pytest.mark.fast
@pytest.mark.parametrize("solver", ["explicit", "relaxation", "implicit"])
def test_a_run_that_was_stopped_ends_as_one_that_was_not(solver, femdem, tmp_path):
    """What it has written at its stops that the deck does not ask for is gone in the end"""
    write(
        tmp_path,
        solver,
        {"explicit": 2000, "relaxation": 4000, "implicit": 1500}[solver],
        SELDOM.replace("10", "900"),
    )
    assert run(femdem, tmp_path, "--output", "whole").returncode == 0
    whole, stopped = tmp_path / "whole", tmp_path / "stopped"
    stops = 0
    for stop in range(3):
        restart = ("--restart", "stopped/checkpoint.h5") if stop else ()
        rows = (stopped / "history.csv").read_text().count("\n") if stop else 0
        with subprocess.Popen(
            [femdem, "--quiet", *restart, "--output", "stopped", "deck.nml"],
            cwd=tmp_path,
            stderr=subprocess.PIPE,
            text=True,
        ) as process:
            wait_for_rows(stopped / "history.csv", rows + 20, process)
            process.terminate()
            said = process.communicate(timeout=20)[1]
        if process.returncode == 0:
            break
        assert process.returncode == STATUS_STOPPED, said
        stops += 1
    else:
        done = go_on(femdem, tmp_path, "stopped")
        assert done.returncode == 0, done.stderr
    assert stops > 0, "the run was too short to be stopped"
    if solver == "explicit":
        same_results(stopped, whole)
    assert snapshots(stopped / "fields.h5") == pytest.approx(snapshots(whole / "fields.h5"))
    lines = [(path / "history.csv").read_text().splitlines() for path in (stopped, whole)]
    assert [line.split(",")[3] for line in lines[0]] == [line.split(",")[3] for line in lines[1]]


@pytest.mark.fast
def test_a_second_signal_ends_a_run_at_once(femdem, tmp_path):
    """An increment that never comes to rest does not hear the first one"""
    write(tmp_path, "relaxation", 1, "checkpoint_minutes = 0")
    with (tmp_path / "deck.nml").open("a", encoding="utf-8") as file:
        file.write("&relaxation tolerance = 1e-15, max_steps = 999999999 /\n")
    with subprocess.Popen([femdem, "--quiet", "deck.nml"], cwd=tmp_path) as process:
        wait_for_rows(tmp_path / "results" / "history.csv", 0)
        process.terminate()
        time.sleep(0.5)
        assert process.poll() is None
        process.terminate()
        assert process.wait(timeout=10) == -signal.SIGTERM


@pytest.mark.fast
def test_before_the_first_cycle_there_is_nothing_to_keep(femdem, tmp_path):
    write(tmp_path, "explicit", 1, "checkpoint_minutes = 0")
    deck = (tmp_path / "deck.nml").read_text().replace("move_time = 0.01", "move_time = 1000")
    (tmp_path / "deck.nml").write_text(deck)
    with subprocess.Popen(
        [femdem, "--quiet", "deck.nml"], cwd=tmp_path, stderr=subprocess.PIPE, text=True
    ) as process:
        wait_for_rows(tmp_path / "results" / "history.csv", 0)
        process.terminate()
        said = process.communicate(timeout=10)[1]
    assert process.returncode == STATUS_STOPPED
    assert "before the first cycle was completed: there is nothing to go on from" in said


# ---- Directories -----------------------------------------------------------------------------------------------------


@pytest.mark.fast
def test_a_directory_that_goes_away_is_named(endless):
    process, folder = endless
    (folder / "results").rename(folder / "elsewhere")
    said = process.communicate(timeout=20)[1]
    assert process.returncode == 1
    assert "the results directory results/, or history.csv in it, has been deleted or moved" in said


@pytest.mark.fast
def test_a_directory_that_cannot_be_written_to_is_named(femdem, tmp_path):
    write(tmp_path)
    (tmp_path / "closed").mkdir(mode=0o500)
    # The superuser may write there all the same
    closed = "/proc/self" if os.geteuid() == 0 else "closed"
    (tmp_path / "file").write_text("")
    for directory in (f"{closed}/results", "file", "file/results"):
        done = run(femdem, tmp_path, "--output", directory)
        assert done.returncode == 2
        assert f"the results directory {directory} cannot be made or written to" in done.stderr
        assert len(done.stderr.splitlines()) == 1
