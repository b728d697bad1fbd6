"""Claims about a run's state: which nodes are overdue, when a run continues without them, and how it ends."""

import pytest

from auv_sim.run_state import RECORDER_LEAD_TICKS, STATUS_TICKS, RunState, WatchConfig

RECORDER, AGENT = "/recorder_node", "/auv_1/agent_node"
ANSWER_S, START_S = 3.0, 60.0


def made(*, policy="stop", lockstep=True, recorder=RECORDER):
    watch = WatchConfig(duration_ticks=1000, on_vehicle_loss=policy)
    return RunState(watch, lockstep=lockstep, recorder=recorder, now_s=0.0)


def flying(**options):
    run = made(**options)
    run.begin_tick(0, 10.0)
    run.begin_tick(1, 11.0)
    return run


def owes():
    return [AGENT]


def none_owes():
    return []


def test_ticks_make_a_run_and_the_last_one_finishes_it():
    run = made()
    assert run.state == "waiting"
    news = [tick for tick in range(1000) if run.begin_tick(tick, 0.1 * tick)]
    assert news == list(range(0, 1000, STATUS_TICKS))
    assert (run.state, run.done) == ("running", False)
    assert run.begin_tick(1000, 100.0)
    assert (run.state, run.done, run.exit_code) == ("finished", True, 0)


@pytest.mark.parametrize(("lockstep", "tick_s"), [(True, ANSWER_S), (False, 0.0)])
def test_an_answer_is_overdue_after_its_time_and_in_real_time_when_the_relay_says_so(lockstep, tick_s):
    run = flying(lockstep=lockstep)
    assert run.overdue(owes, 11.0 + tick_s) == [AGENT]
    assert run.overdue(none_owes, 11.0 + tick_s) == []
    if lockstep:
        assert run.overdue(owes, 11.0 + tick_s - 0.01) == []


def test_before_the_first_tick_a_node_has_longer_and_the_relay_is_named_if_all_are_there():
    run = made()
    assert run.overdue(owes, START_S - 0.01) == []
    assert run.overdue(owes, START_S) == [AGENT]
    assert run.overdue(none_owes, START_S) == ["/acoustic_relay_node"]


def test_a_recorder_that_falls_silent_or_behind_is_overdue():
    run = flying(policy="continue")
    run.hear_recorder(1, 11.0)
    assert run.overdue(none_owes, 11.0 + ANSWER_S + 0.01) == [RECORDER]
    behind = flying()
    behind.begin_tick(RECORDER_LEAD_TICKS + 1, 11.0)
    assert not behind.has_room
    assert behind.silent(owes) == [RECORDER]
    assert behind.hear_recorder(1, 12.0)
    assert behind.has_room
    assert not behind.hear_recorder(2, 13.0)


@pytest.mark.parametrize("options", [{"lockstep": False}, {"recorder": ""}])
def test_without_a_recorder_or_in_real_time_there_is_always_room(options):
    run = flying(**options)
    run.begin_tick(900, 20.0)
    assert run.has_room


@pytest.mark.parametrize(
    ("options", "names"),
    [({"policy": "stop"}, [AGENT]), ({"policy": "continue"}, [AGENT, RECORDER])],
)
def test_a_run_that_may_not_go_on_is_aborted_with_the_reason(options, names):
    run = flying(**options)
    words = run.stall(names)
    assert (run.state, run.detail) == ("stalled", words)
    assert f"{AGENT}" in words
    assert "no answer for tick 1 within 3 s" in words
    assert not run.goes_on_without(names)
    assert (run.state, run.detail, run.exit_code) == ("aborted", words, 3)


def test_a_run_may_go_on_without_a_vehicle_but_not_without_all():
    run = flying(policy="continue")
    run.stall([AGENT])
    assert run.goes_on_without([AGENT])
    run.lose(["auv_1"], 2, 15.0)
    assert (run.state, run.lost, run.done) == ("running", ["auv_1"], False)
    assert run.overdue(owes, 15.0 + ANSWER_S - 0.01) == []
    run.lose(["auv_2"], 2, 20.0)
    assert (run.state, run.detail, run.exit_code) == ("aborted", "every vehicle is lost", 3)


def test_before_the_first_tick_no_run_goes_on():
    run = made(policy="continue")
    run.stall([AGENT])
    assert not run.goes_on_without([AGENT])
