"""
Claims about worker processes: every call is made even if workers are killed or stopped, and every wait ends.
"""

import contextlib
import multiprocessing
import os
import random
import signal
import sys
import threading
import time
from typing import Any

import psutil
import pytest

from auv_core.cli.one_line_parser import MOST_WORKERS
from auv_core.machine import worker_pipe, worker_watch, workers
from auv_core.machine.failure import Failure, WorkersError

WAIT_S = 60.0
LONGER_THAN_A_PIPE_BYTES = 1 << 22


def collect(calls, n_workers=2, **options):
    """Make calls; return results by index, amounts of progress, and messages."""
    results: dict[int, Any] = {}
    amounts: list[float] = []
    words: list[str] = []
    workers.spread(
        calls,
        n_workers,
        on_result=results.__setitem__,
        on_progress=amounts.append,
        on_message=words.append,
        **options,
    )
    assert multiprocessing.active_children() == []
    return results, amounts, words


def once(path, deed):
    """Return a call that does something to its worker the first time that it is made, and then returns 1."""

    def call(advance):
        advance(0.25)
        try:
            path.touch(exist_ok=False)
        except FileExistsError:
            return 1
        deed()
        return 1

    return call


def send_self(number):
    os.kill(os.getpid(), number)


@pytest.fixture
def hasty_watch(monkeypatch):
    """Look often and lose patience early."""
    monkeypatch.setattr(workers, "_LOOK_EVERY_S", 0.05)
    monkeypatch.setattr(workers, "_WAIT_SLICE_S", 0.05)


def test_calls_need_not_be_picklable_and_tell_progress():
    def call(number):
        def inner(advance):
            advance(0.5)
            return number

        return inner

    results, amounts, _ = collect([call(n) for n in range(5)])
    assert results == {n: n for n in range(5)}
    assert amounts[-1] == 2.5


def test_a_result_may_be_longer_than_a_pipe_holds():
    results, _, _ = collect([lambda advance: bytes(LONGER_THAN_A_PIPE_BYTES)])
    assert results == {0: bytes(LONGER_THAN_A_PIPE_BYTES)}


def test_a_result_that_cannot_be_sent_is_a_failure():
    results, _, _ = collect([lambda advance: lambda: None, lambda advance: 1])
    assert isinstance(results[0], Failure)
    assert results[1] == 1


def test_a_call_that_kills_every_worker_fails_alone():
    results, _, _ = collect([lambda advance: send_self(signal.SIGKILL), *[lambda advance: 1] * 5])
    assert "died every time" in results[0].line
    assert [results[n] for n in range(1, 6)] == [1] * 5


def test_a_call_whose_worker_was_killed_is_made_again_and_its_progress_counts_once(tmp_path):
    results, amounts, _ = collect([once(tmp_path / "done", lambda: send_self(signal.SIGKILL))])
    assert results == {0: 1}
    assert amounts[-1] == 0.25


def test_a_stopped_worker_is_named_and_replaced(tmp_path, hasty_watch):
    calls = [once(tmp_path / "done", lambda: send_self(signal.SIGSTOP)), lambda advance: 2]
    results, _, words = collect(calls)
    assert results == {0: 1, 1: 2}
    (line,) = words
    assert line.startswith("worker process ")
    assert "has been stopped for" in line


def test_a_call_that_never_ends_is_ended_at_its_limit_and_fails_alone(hasty_watch):
    def loop(advance):
        advance(0.25)
        while True:
            pass

    limits_s = {0: 0.5}
    calls = [loop, *[lambda advance: 1] * 5]
    results, amounts, words = collect(calls, limit_s=lambda index: limits_s.get(index, WAIT_S))
    assert results[0].line == "took longer than 0.5 s, and was ended"
    assert [results[n] for n in range(1, 6)] == [1] * 5
    assert amounts[-1] == 0.25
    assert words == []


def test_after_ctrl_z_and_fg_no_worker_is_blamed():
    """All stop together; the parent may run again a little before the others."""
    process = multiprocessing.get_context("fork").Process(target=burn)
    process.start()
    assert process.pid is not None
    watch = worker_watch.Watch(process.pid)
    try:
        for _ in range(5):
            os.kill(process.pid, signal.SIGSTOP)
            wait_until(lambda: psutil.Process(process.pid).status() == psutil.STATUS_STOPPED)
            assert [watch.look() for _ in range(3)] == [""] * 3
            before_s = psutil.Process(process.pid).cpu_times().user
            os.kill(process.pid, signal.SIGCONT)
            wait_until(lambda: psutil.Process(process.pid).cpu_times().user > before_s)  # noqa: B023
            assert watch.look() == ""
    finally:
        process.kill()
        process.join()


def burn():
    while True:
        pass


def wait_until(condition):
    pause = threading.Event()
    for _ in range(int(WAIT_S / 0.01)):
        if condition():
            return
        pause.wait(0.01)
    raise AssertionError("it did not happen in time")


def test_a_worker_that_takes_no_processor_time_is_named_and_replaced(tmp_path, hasty_watch, monkeypatch):
    monkeypatch.setattr(worker_watch, "_LOOKS_IDLE", 5)
    results, _, words = collect([once(tmp_path / "done", lambda: time.sleep(WAIT_S))])
    assert results == {0: 1}
    assert "has taken no processor time for" in words[0]


def test_a_worker_that_stops_in_the_middle_of_its_result_holds_up_nobody(hasty_watch, monkeypatch):
    """The parent has the first half of a message, and the second never comes."""
    send_truly = worker_pipe.send

    def send_half(stream, message):
        if message[0] == "result" and message[1] == "half":
            stream.sendall((1 << 20).to_bytes(8, "little") + b"half")
            send_self(signal.SIGSTOP)
        send_truly(stream, message)

    monkeypatch.setattr(workers, "send", send_half)
    results, _, words = collect([lambda advance: "half", lambda advance: 1])
    assert results[1] == 1
    assert isinstance(results[0], Failure)
    assert len(words) == 3, "two tries in company and one alone"


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_workers_that_all_end_while_they_start_are_told_in_one_line(hasty_watch, monkeypatch, number):
    monkeypatch.setattr(workers, "_become_worker", lambda parent: send_self(number))
    with pytest.raises(WorkersError, match=r"^all of 6 worker processes ended while they started$"):
        collect([lambda advance: 1] * 4)
    assert multiprocessing.active_children() == []


def test_a_process_that_cannot_be_started_is_told_in_one_line(monkeypatch):
    def refuse(process):
        raise BlockingIOError(11, "Resource temporarily unavailable")

    monkeypatch.setattr(workers, "_start", refuse)
    with pytest.raises(WorkersError, match=r"no worker process can be started \(Resource temp"):
        collect([lambda advance: 1])


def test_the_most_workers_fit_into_the_usual_number_of_open_files():
    counts = []
    n_workers = 8
    before = psutil.Process().num_fds()
    workers.spread(
        [lambda advance: 1] * 50,
        n_workers,
        on_result=lambda index, result: counts.append(psutil.Process().num_fds()),
    )
    files_per_worker = (max(counts) - before) / n_workers
    assert MOST_WORKERS * files_per_worker < 1024 - 200


def test_no_calls_need_no_worker():
    assert collect([]) == ({}, [], [])


def test_what_ends_the_wait_ends_the_workers():
    def interrupt(index, result):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        workers.spread([lambda advance: 1, lambda advance: time.sleep(WAIT_S)], 2, on_result=interrupt)
    assert multiprocessing.active_children() == []


@pytest.mark.slow
def test_hostile_kills_and_stops_at_random_moments_leave_no_call_unanswered(capsys):
    """A hundred workers are killed, a hundred stopped; each call is made, or given up after three tries."""
    rng = random.Random(1)
    counts = {signal.SIGKILL: 0, signal.SIGSTOP: 0}
    over = threading.Event()

    def attack():
        while min(counts.values()) < 100 and not over.wait(rng.uniform(0.0, 0.1)):
            number = rng.choice(list(counts))
            children = psutil.Process().children()
            with contextlib.suppress(psutil.NoSuchProcess, IndexError):
                rng.choice(children).send_signal(number)
                counts[number] += 1

    def work(advance):
        end_s = time.process_time() + 0.02
        while time.process_time() < end_s:
            advance(0.0)
        return 1

    attacker = threading.Thread(target=attack)
    attacker.start()
    made = 0
    try:
        with pytest.MonkeyPatch.context() as patched:
            patched.setattr(workers, "_LOOK_EVERY_S", 0.02)
            while attacker.is_alive():
                results, _, _ = collect([work] * 20, n_workers=4)
                made += sum(result == 1 for result in results.values())
                assert all(r == 1 or "died every time" in r.line for r in results.values())
                assert len(results) == 20
    finally:
        over.set()
        attacker.join()
    with capsys.disabled():
        kills, stops = counts.values()
        sys.stdout.write(f"\n{kills} kills and {stops} stops of workers; {made} calls made\n")
