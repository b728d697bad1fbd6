"""Every way in which a flight ends, without a process."""

import math
from pathlib import Path

import pytest

from auv_bringup.launching import layout, supervision
from auv_bringup.launching.flight_status import Status
from auv_bringup.launching.launcher import Flight, of_asked_length
from auv_bringup.launching.layout import process_specs
from auv_bringup.launching.node_specs import node_specs
from auv_bringup.launching.supervision import Supervisor
from auv_core.machine.child_end import Exit
from auv_experiment.scenario.loading import load_scenario

SCENARIO = load_scenario("flock_acoustic")
AGENT_2, VEHICLE_2 = "/auv_2/agent_node", "/auv_2/vehicle_node"
RELAY, RECORDER = "/acoustic_relay_node", "/recorder_node"


@pytest.fixture(params=["stop", "continue"])
def policy(request):
    return request.param


def processes(bag_dir, layout="node", mode="lockstep"):
    return process_specs(node_specs(SCENARIO, mode=mode, bag_dir=bag_dir), layout)


def make(policy="stop", tmp_dir="bag", layout="node"):
    supervisor = Supervisor(processes(tmp_dir, layout), on_vehicle_loss=policy)
    supervisor.status_arrived(running(1.0), 100.0)
    return supervisor


def status(state, time_s, *, duration_s=650.0, epoch_s=1.0, **more):
    return Status(state, time_s, duration_s, epoch_s, **more)


def running(time_s, **more):
    return status("running", time_s, **more)


def stalled(*names):
    return status("stalled", 5.0, waiting_for=names)


def waiting(*names):
    return status("waiting", 0.0, epoch_s=0.0, waiting_for=names)


FINISHED = status("finished", 650.0)


def stands_by(supervisor, claim, most_s=5.0):
    """Let the clock repeat a status until the supervisor takes it up; return after how long (s)."""
    stood_s = 0.0
    while not (supervisor.is_over or supervisor.lost_vehicles) and stood_s < most_s:
        supervisor.status_arrived(claim, 104.0)
        supervisor.time_passed(0.25)
        stood_s += 0.25
    return stood_s


def finish(supervisor, wall_s=165.0):
    supervisor.status_arrived(FINISHED, wall_s)
    end(supervisor, RELAY, 0)


def end(supervisor, name, returncode=1):
    supervisor.process_ended(Exit(name, returncode), ["Traceback", "ValueError: no"], "logs/x.log")


def test_a_flight_that_finishes_is_over_with_status_0(policy):
    supervisor = make(policy)
    finish(supervisor)
    assert (supervisor.is_over, supervisor.is_finished, supervisor.exit_status) == (True, True, 0)
    assert supervisor.simulated_s == 650.0


def test_the_rate_counts_the_flight_only():
    supervisor = make()
    supervisor.status_arrived(running(11.0), 101.0)
    supervisor.status_arrived(FINISHED, 110.0)
    supervisor.time_passed(0.5)
    end(supervisor, RELAY, 0)
    assert supervisor.real_time_factor == pytest.approx(64.9)


def test_the_rate_of_a_flight_of_one_look_is_unknown():
    assert math.isnan(make().real_time_factor)


@pytest.mark.parametrize("name", [AGENT_2, VEHICLE_2])
@pytest.mark.parametrize(
    ("returncode", "words"), [(1, "exit status 1"), (0, "exit status 0"), (-9, "SIGKILL")]
)
def test_a_vehicle_process_that_ends_stops_the_flight_and_is_named(name, returncode, words):
    supervisor = make("stop")
    end(supervisor, name, returncode)
    assert (supervisor.is_over, supervisor.exit_status) == (True, 3)
    assert name in supervisor.reason
    messages = "\n".join(supervisor.take_messages())
    assert name in messages
    assert words in messages
    assert "ValueError: no" in messages
    assert "logs/x.log" in messages


def test_a_flight_that_may_go_on_ends_both_processes_of_a_lost_vehicle():
    supervisor = make("continue")
    end(supervisor, AGENT_2)
    assert not supervisor.is_over
    assert supervisor.lost_vehicles == ["auv_2"]
    assert sorted(supervisor.take_processes_to_end()) == [AGENT_2, VEHICLE_2]
    assert supervisor.take_processes_to_end() == []
    end(supervisor, VEHICLE_2, -9)
    supervisor.status_arrived(running(5.0, lost_vehicles=("auv_2",)), 104.0)
    assert supervisor.lost_vehicles == ["auv_2"]
    assert not supervisor.is_over
    assert "auv_2 is lost" in "\n".join(supervisor.take_messages())


def test_a_vehicle_that_the_clock_gave_up_is_lost_too():
    supervisor = make("continue")
    stands_by(supervisor, running(5.0, lost_vehicles=("auv_3",), detail="/auv_3/agent_node: no answer"))
    assert supervisor.lost_vehicles == ["auv_3"]
    assert sorted(supervisor.take_processes_to_end()) == ["/auv_3/agent_node", "/auv_3/vehicle_node"]
    assert "/auv_3/agent_node: no answer" in "\n".join(supervisor.take_messages())


def test_a_process_of_two_nodes_that_ends_is_the_loss_of_its_vehicle():
    supervisor = make("continue", layout="vehicle")
    end(supervisor, "/auv_2")
    assert (supervisor.is_over, supervisor.lost_vehicles) == (False, ["auv_2"])
    assert supervisor.take_processes_to_end() == ["/auv_2"]
    assert "ValueError: no: auv_2 is lost" in "\n".join(supervisor.take_messages())


def test_a_vehicle_that_the_clock_gave_up_loses_the_process_of_both_nodes():
    supervisor = make("continue", layout="vehicle")
    stands_by(supervisor, running(5.0, lost_vehicles=("auv_3",)))
    assert supervisor.take_processes_to_end() == ["/auv_3"]


@pytest.mark.parametrize("lost", ["auv_3", "auv_9"])
def test_a_forged_loss_ends_no_process_and_is_said_once(lost):
    supervisor = make("continue")
    for tenths in range(10, 100):
        supervisor.status_arrived(running(0.1 * tenths), 100.0)
        supervisor.status_arrived(running(0.1 * tenths, lost_vehicles=(lost,)), 100.0)
        supervisor.time_passed(0.2)
    assert (supervisor.lost_vehicles, supervisor.take_processes_to_end()) == ([], [])
    said = [line for line in supervisor.take_messages() if "ignored" in line]
    assert len(said) == (1 if lost == "auv_3" else 0)


def test_a_clock_that_may_not_go_on_without_a_vehicle_gives_up_none():
    supervisor = make("stop")
    stands_by(supervisor, running(5.0, lost_vehicles=("auv_3",)))
    assert (supervisor.lost_vehicles, supervisor.take_processes_to_end()) == ([], [])


@pytest.mark.parametrize("forged_first", [True, False])
def test_a_loss_that_is_forged_into_the_end_is_not_believed(forged_first):
    supervisor = make("continue")
    ends = [FINISHED, status("finished", 650.0, lost_vehicles=("auv_2",))]
    for claim in reversed(ends) if forged_first else ends:
        supervisor.status_arrived(claim, 165.0)
    end(supervisor, RELAY, 0)
    assert (supervisor.is_finished, supervisor.lost_vehicles) == (True, [])


def test_a_loss_just_before_the_end_is_believed_with_it():
    supervisor = make("continue")
    supervisor.status_arrived(status("finished", 650.0, lost_vehicles=("auv_2",)), 165.0)
    end(supervisor, RELAY, 0)
    assert (supervisor.is_finished, supervisor.lost_vehicles) == (True, ["auv_2"])


def test_a_process_of_all_nodes_that_ends_stops_the_flight_and_says_which_node_failed():
    supervisor = make("stop", layout="single")
    supervisor.process_ended(Exit("/node_container", 1), [f"{AGENT_2}: ValueError: no"], "logs/x.log")
    assert (supervisor.is_over, supervisor.exit_status) == (True, 3)
    assert f"(exit status 1): {AGENT_2}: ValueError: no" in supervisor.reason


def test_a_stalled_node_of_a_process_of_all_nodes_stops_the_flight():
    supervisor = make("stop", layout="single")
    stands_by(supervisor, stalled(AGENT_2))
    assert (supervisor.exit_status, supervisor.reason) == (3, f"{AGENT_2} stopped answering")


def test_losing_the_recorder_always_stops_the_flight(policy):
    supervisor = make(policy)
    end(supervisor, RECORDER)
    assert (supervisor.is_over, supervisor.exit_status) == (True, 3)
    assert RECORDER in supervisor.reason


def test_losing_the_relay_always_stops_the_flight(policy):
    supervisor = make(policy)
    end(supervisor, RELAY, -11)
    assert (supervisor.is_over, supervisor.exit_status) == (True, 3)
    assert "SIGSEGV" in supervisor.reason


def test_the_last_status_of_a_relay_may_arrive_after_its_end():
    supervisor = make()
    end(supervisor, RELAY, 0)
    assert not supervisor.is_over
    supervisor.time_passed(0.5)
    supervisor.status_arrived(FINISHED, 165.0)
    assert (supervisor.is_over, supervisor.exit_status) == (True, 0)
    assert supervisor.take_messages() == []


def test_a_relay_that_ends_before_the_flight_does_stops_it():
    for returncode in (0, 3):
        supervisor = make()
        end(supervisor, RELAY, returncode)
        for _ in range(3):
            supervisor.time_passed(0.5)
        assert supervisor.exit_status == 3
        assert RELAY in supervisor.reason
        assert "ValueError: no" in "\n".join(supervisor.take_messages())


@pytest.mark.parametrize("is_seen_first", [False, True])
def test_an_aborted_flight_says_why(policy, is_seen_first):
    supervisor = make(policy)
    if is_seen_first:
        end(supervisor, RELAY, 3)
    supervisor.status_arrived(status("aborted", 5.0, detail=f"{AGENT_2}: no answer within 3 s"), 104.0)
    if not is_seen_first:
        assert not supervisor.is_over
        end(supervisor, RELAY, 3)
    assert supervisor.exit_status == 3
    assert supervisor.reason == f"{AGENT_2}: no answer within 3 s"
    assert supervisor.take_messages() == []


def test_a_stall_is_named_and_does_not_last():
    supervisor = make()
    for _ in range(30):
        supervisor.status_arrived(stalled(AGENT_2), 104.0)
        supervisor.time_passed(0.2)
    assert supervisor.exit_status == 3
    assert AGENT_2 in supervisor.reason
    assert len([line for line in supervisor.take_messages() if AGENT_2 in line]) == 1


def test_a_stall_that_passes_is_forgotten():
    supervisor = make()
    for _ in range(10):
        supervisor.status_arrived(stalled(AGENT_2), 104.0)
        supervisor.time_passed(0.4)
        supervisor.status_arrived(running(5.1), 105.0)
    assert not supervisor.is_over


def test_a_stalled_recorder_stops_the_flight_soon(policy):
    supervisor = make(policy)
    assert stands_by(supervisor, stalled(RECORDER)) <= supervision.CLAIM_S + 0.5
    assert supervisor.exit_status == 3
    assert RECORDER in supervisor.reason


def test_a_forged_stall_stops_nothing_and_is_said_once(policy):
    supervisor = make(policy)
    for tenths in range(10, 100):
        supervisor.status_arrived(running(0.1 * tenths), 100.0)
        supervisor.status_arrived(status("stalled", 0.1 * tenths, waiting_for=(RECORDER,)), 100.0)
        supervisor.time_passed(0.2)
    assert not supervisor.is_over
    assert len(supervisor.take_messages()) == 1


def test_a_silent_clock_is_named_within_5_s(policy):
    supervisor = make(policy)
    silent_s = 0.0
    while not supervisor.is_over:
        supervisor.time_passed(0.1)
        silent_s += 0.1
    assert silent_s < 5.0
    assert "/clock_node" in supervisor.reason


@pytest.mark.parametrize("layout", ["node", "vehicle", "single"])
@pytest.mark.parametrize("heard", [None, waiting(), running(1.0)])
def test_a_stopped_process_is_named_within_5_s_from_the_start_on(layout, heard):
    for process in processes("bag", layout):
        supervisor = Supervisor(processes("bag", layout), on_vehicle_loss="stop")
        if heard is not None:
            supervisor.status_arrived(heard, 100.0)
        passed_s = 0.0
        while not supervisor.is_over:
            supervisor.processes_stopped({process.name: ""}, 0.25)
            passed_s += 0.25
        assert passed_s < 3.0
        assert process.name in supervisor.reason
        assert "stopped by a signal" in supervisor.reason
        assert supervisor.exit_status == 3


def test_what_a_process_has_started_is_named_with_it():
    supervisor = make(layout="single")
    for _ in range(3):
        supervisor.processes_stopped({"/node_container": "auv_bag.process"}, 1.0)
    assert supervisor.reason == "auv_bag.process, started by /node_container, is stopped by a signal"


def test_a_process_that_goes_on_soon_is_not_lost():
    supervisor = make()
    for _ in range(20):
        supervisor.processes_stopped({AGENT_2: ""}, 1.5)
        supervisor.processes_stopped({}, 0.25)
    assert not supervisor.is_over


def test_a_stopped_vehicle_may_be_left_behind():
    supervisor = make("continue")
    supervisor.processes_stopped({AGENT_2: ""}, 1.5)
    supervisor.processes_stopped({AGENT_2: ""}, 1.5)
    supervisor.processes_stopped({AGENT_2: ""}, 1.5)
    assert not supervisor.is_over
    assert supervisor.lost_vehicles == ["auv_2"]
    assert set(supervisor.take_processes_to_end()) == {AGENT_2, VEHICLE_2}


def test_no_word_at_all_ends_the_wait():
    supervisor = Supervisor(processes(None), on_vehicle_loss="stop")
    waited_s = 0.0
    while not supervisor.is_over:
        supervisor.time_passed(0.5)
        waited_s += 0.5
    assert supervision.NO_STATUS_S <= waited_s <= supervision.NO_STATUS_S + 1.0
    assert supervisor.exit_status == 3


def test_a_slow_start_says_once_for_whom_it_waits():
    supervisor = Supervisor(processes(None), on_vehicle_loss="stop")
    for _ in range(100):
        supervisor.status_arrived(waiting(AGENT_2), 1.0)
        supervisor.time_passed(0.2)
    assert supervisor.take_messages() == [f"still waiting for {AGENT_2}"]
    assert not supervisor.is_over


def test_nodes_that_end_well_after_the_finish_are_no_loss(policy):
    supervisor = make(policy)
    supervisor.status_arrived(FINISHED, 165.0)
    end(supervisor, VEHICLE_2, 0)
    supervisor.time_passed(5.0)
    end(supervisor, RELAY, 0)
    end(supervisor, AGENT_2, 0)
    supervisor.time_passed(10.0)
    assert supervisor.exit_status == 0
    assert supervisor.take_messages() == []


def test_a_large_fleet_is_given_more_time_for_start_and_ticks():
    """Its vehicles have more pairs to work on in each tick, and more nodes to make."""
    fleet = load_scenario("swarm", overrides=["vehicles.count=128", "random_starts.radius_m=60"])
    specs = process_specs(node_specs(fleet, mode="lockstep", bag_dir=Path("bag")), "single")
    small, large = make(layout="single"), Supervisor(specs, on_vehicle_loss="stop")
    large.status_arrived(running(1.0, duration_s=fleet.duration_s), 100.0)
    for supervisor in (small, large):
        supervisor.time_passed(supervision.SILENCE_S + 1.0)
    assert (small.is_over, large.is_over) == (True, False)
    large.time_passed(layout.patience_s(128))
    assert large.is_over
    waiting = Supervisor(specs, on_vehicle_loss="stop")
    waiting.time_passed(supervision.NO_STATUS_S + 1.0)
    assert not waiting.is_over
    relay = specs[0].nodes[0].params
    assert relay["answer_timeout_s"] == fleet.answer_timeout_s + layout.patience_s(128)
    assert relay["start_timeout_s"] > supervision.NO_STATUS_S


@pytest.mark.parametrize(
    "foreign",
    [
        running(0.5),
        running(4.0, duration_s=30.0, lost_vehicles=("auv_2",)),
        running(4.0, epoch_s=7.0),
        running(650.0),
        running(math.nan),
        waiting(),
        status("stalled", 4.0, epoch_s=1.8e9, waiting_for=(RECORDER,)),
        status("finished", 5.0),
        status("finished", 30.0, duration_s=30.0),
        status("aborted", 0.2),
        status("aborted", 4.0, duration_s=30.0),
    ],
)
def test_a_status_of_another_run_or_that_goes_back_is_not_believed(foreign):
    supervisor = make("continue")
    before = supervisor.status
    supervisor.status_arrived(foreign, 101.0)
    supervisor.status_arrived(foreign, 102.0)
    end(supervisor, RELAY, {"finished": 0}.get(foreign.state, 3))
    assert (supervisor.is_over, supervisor.status) == (False, before)
    (line,) = supervisor.take_messages()
    assert "another run publishes it; ignored" in line


def test_in_real_time_the_first_tick_tells_the_epoch():
    supervisor = Supervisor(processes("bag", mode="realtime"), on_vehicle_loss="stop")
    supervisor.status_arrived(waiting(), 100.0)
    supervisor.status_arrived(running(0.0, epoch_s=1.8e9), 101.0)
    supervisor.status_arrived(running(1.0, epoch_s=1.8e9), 102.0)
    assert supervisor.take_messages() == []
    supervisor.status_arrived(running(2.0, epoch_s=1.8e9 + 5.0), 103.0)
    assert supervisor.simulated_s == 1.0


@pytest.mark.parametrize("forged", [FINISHED, status("aborted", 40.0, detail="all is lost")])
def test_an_end_after_which_the_run_goes_on_is_said_once_and_not_believed(forged):
    supervisor = make()
    for time_s in (1.5, 2.0, 2.5):
        supervisor.status_arrived(forged, 100.0)
        supervisor.status_arrived(running(time_s), 100.0)
    assert (supervisor.is_over, supervisor.simulated_s) == (False, 2.5)
    (line,) = supervisor.take_messages()
    assert f"says {forged.state}" in line
    assert "the run's own process goes on" in line
    finish(supervisor)
    assert supervisor.exit_status == 0


def test_an_end_holds_whatever_is_said_after_it_if_the_clock_leaves_with_it():
    supervisor = make()
    supervisor.status_arrived(FINISHED, 165.0)
    supervisor.status_arrived(running(649.0), 165.0)  # forged
    end(supervisor, RELAY, 0)
    assert (supervisor.is_finished, supervisor.simulated_s, supervisor.exit_status) == (True, 650.0, 0)


def test_a_contradicted_end_is_forgotten_in_time():
    supervisor = make()
    supervisor.status_arrived(FINISHED, 101.0)
    for tenths in range(20, 20 + 5 * int(supervision.LEAVE_S) + 5):
        supervisor.time_passed(0.2)
        supervisor.status_arrived(running(0.1 * tenths), 101.0)
    end(supervisor, RELAY, 0)
    supervisor.time_passed(1.5)
    assert supervisor.exit_status == 3


@pytest.mark.parametrize("layout", ["node", "single"])
def test_an_end_that_the_process_of_the_clock_does_not_follow_by_leaving_is_not_believed(layout):
    supervisor = make(layout=layout)
    supervisor.status_arrived(FINISHED, 101.0)
    waited_s = 0.0
    while not (said := supervisor.take_messages()):
        assert not supervisor.is_over
        supervisor.time_passed(0.5)
        waited_s += 0.5
    limit_s = supervision.LEAVE_RECORDING_S if layout == "single" else supervision.LEAVE_S
    assert limit_s <= waited_s <= limit_s + 2.0
    assert "the run's own process goes on" in said[0]
    while not supervisor.is_over:  # the clock has been silent all the time
        supervisor.time_passed(0.5)
    assert "/clock_node" in supervisor.reason


def test_a_clock_that_dies_after_a_forged_end_is_a_loss():
    for returncode in (-9, 1, 3):
        supervisor = make()
        supervisor.status_arrived(FINISHED, 101.0)
        end(supervisor, RELAY, returncode)
        supervisor.time_passed(2.0)
        assert supervisor.exit_status == 3
        assert f"{RELAY} has ended early" in supervisor.reason


def test_a_forged_tick_far_ahead_does_not_silence_the_clock():
    supervisor = make()
    supervisor.status_arrived(running(649.0), 101.0)
    for tenths in range(20, 300):
        supervisor.time_passed(0.5)
        supervisor.status_arrived(running(0.1 * tenths), 101.0 + tenths)
    assert not supervisor.is_over
    finish(supervisor)
    assert supervisor.exit_status == 0


@pytest.mark.parametrize(
    ("mode", "flown_s", "is_good"),
    [
        ("lockstep", 30.0, True),
        ("lockstep", 2.6, False),
        ("lockstep", 30.2, False),
        ("realtime", 31.0, True),
        ("realtime", 29.8, False),
        ("realtime", 200.0, False),
    ],
)
def test_a_length_that_is_not_the_asked_one_is_no_good_flight(mode, flown_s, is_good):
    scenario = load_scenario("flock_acoustic", duration_s=30.0)
    flight = of_asked_length(Flight(0, "", (), flown_s, 1.0, 1.0), scenario, mode)
    assert flight.exit_status == (0 if is_good else 3)
    assert ("not at the requested 30 s" in flight.reason) != is_good
    lost = Flight(3, "auv_1 is lost", (), 2.0, 1.0, 1.0)
    assert of_asked_length(lost, scenario, mode) == lost
