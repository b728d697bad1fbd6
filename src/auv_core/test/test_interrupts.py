"""Signals that end a command, and those that its caller has switched off."""

import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from auv_core.machine.interrupts import Interrupted, Interrupts, held_interrupts, make_signals_interrupt

PROGRAM = """
import signal, sys
from auv_core.machine.interrupts import Interrupts, make_signals_interrupt
make_signals_interrupt()
try:
    if sys.argv[1] == "flight":
        with Interrupts() as interrupts:
            print("ready", flush=True)
            while not interrupts.count:
                signal.sigtimedwait([], 0.05)
        sys.exit(130)
    print("ready", flush=True)
    while True:
        signal.pause()
except KeyboardInterrupt:
    sys.exit(130)
"""


@pytest.mark.parametrize("kind", ["command", "flight"])
@pytest.mark.parametrize(
    ("ignored", "sent", "ends"),
    [
        (signal.SIGHUP, signal.SIGHUP, False),
        (signal.SIGTERM, signal.SIGTERM, False),
        (None, signal.SIGHUP, True),
        (signal.SIGINT, signal.SIGINT, True),  # as a shell starts what runs in its background
    ],
)
def test_nohup_and_trap_are_kept(kind, ignored, sent, ends):
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, kind],
        stdout=subprocess.PIPE,
        env={"PYTHONPATH": str(Path(__file__).parents[1])},
        preexec_fn=lambda: ignored and signal.signal(ignored, signal.SIG_IGN),
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == b"ready\n"
        process.send_signal(sent)
        if ends:
            assert process.wait(10) == 130
        else:
            with pytest.raises(subprocess.TimeoutExpired):
                process.wait(0.3)
            ignored_mask = int(
                Path(f"/proc/{process.pid}/status").read_text().split("SigIgn:")[1].split()[0], 16
            )
            assert ignored_mask >> (sent - 1) & 1
    finally:
        process.kill()
        process.communicate()


def raise_in_a_held_block(number, done):
    with held_interrupts():
        signal.raise_signal(number)
        done.append("block")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_held_signal_ends_the_command_only_after_the_block(number, keep_signal_handlers):
    make_signals_interrupt()
    done: list[Any] = []
    with pytest.raises(Interrupted):
        raise_in_a_held_block(number, done)
    assert done == ["block"]
    with pytest.raises(Interrupted):
        signal.raise_signal(number)


def test_interrupts_count_and_give_the_handlers_back():
    before = signal.getsignal(signal.SIGTERM)
    with Interrupts() as interrupts:
        signal.raise_signal(signal.SIGTERM)
        assert (interrupts.count, interrupts.is_hurried) == (1, False)
        signal.raise_signal(signal.SIGINT)
        assert (interrupts.count, interrupts.is_hurried) == (2, True)
    assert signal.getsignal(signal.SIGTERM) is before
