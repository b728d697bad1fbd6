"""From a bag to the arrays of a run."""

import dataclasses
import re

import numpy as np
import pytest
import synthetic_bag as synthetic
from numpy.testing import assert_array_equal
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from auv_bag.definitions import MessageType
from auv_bag.writer import BagError, Topic
from auv_experiment.metrics.safety import safe_command_metrics
from auv_experiment.recording_from_bag import read_recording


def written(tmp_path, run, **options):
    recorder = synthetic.Recorder(tmp_path / "bag")
    run.write(recorder, **options)
    recorder.writer.close()
    return tmp_path / "bag"


def check_states(recording, run, k=slice(None)):
    assert_array_equal(recording.position_ned_m[k], run.state[k, :, :3])
    assert_array_equal(recording.attitude_quat_wxyz[k], run.state[k, :, 3:7])
    assert_array_equal(recording.velocity_body[k], run.state[k, :, 7:])


@pytest.mark.parametrize(("epoch_ns", "period_s"), [(0, 0.1), (1_700_000_000_123_456_789, 0.05)])
def test_every_array_holds_what_was_recorded(tmp_path, epoch_ns, period_s):
    run = synthetic.SyntheticRun(3, 12, epoch_ns=epoch_ns, period_s=period_s)
    recording = read_recording(written(tmp_path, run, extras=True), synthetic.scenario(3, period_s))
    assert recording.vehicle_ids == ("auv_1", "auv_2", "auv_3")
    assert_array_equal(recording.t_s, np.arange(13) * period_s)
    check_states(recording, run)
    assert_array_equal(recording.command, run.command)
    assert_array_equal(recording.reference_velocity_ned_mps, run.reference[..., :3])
    assert_array_equal(recording.centre_ned_m, run.centre[..., :3])
    assert_array_equal(recording.centre_velocity_ned_mps, run.centre[..., 3:])
    others = ~np.eye(3, dtype=bool)
    for k in range(12):
        assert_array_equal(recording.neighbour_position_ned_m[k][others], run.neighbours[k][others][:, :3])
        assert_array_equal(recording.neighbour_velocity_ned_mps[k][others], run.neighbours[k][others][:, 3:6])
        covariance = recording.neighbour_covariance[k][others].reshape(-1, 36)
        assert_array_equal(covariance, run.neighbours[k][others][:, 6:42])
        assert_array_equal(recording.neighbour_age_s[k][others], run.neighbours[k][others][:, 42])
        assert_array_equal(recording.neighbour_sonar_age_s[k][others], run.neighbours[k][others][:, 43])
        assert np.isnan(recording.neighbour_position_ned_m[k][~others]).all()
    assert np.isnan(recording.lost_at_s).all()


def test_navigation_contacts_and_the_acoustic_log_are_read(tmp_path):
    run = synthetic.SyntheticRun(3, 12)
    recording = read_recording(written(tmp_path, run), synthetic.scenario(3))
    assert_array_equal(recording.nav_position_ned_m, run.nav[:-1, :, :3])
    assert_array_equal(recording.nav_position_sd_m, run.nav[:-1, :, 13])
    seen = [(k, i) for k in range(12) for i in range(3) if run.heard[k, i]]
    assert_array_equal(recording.contacts, [(k, i + 1) for k, i in seen])
    assert_array_equal(recording.contact_values, [run.nav[k, i, :3] for k, i in seen])
    assert_array_equal(recording.events, [(k, 0, i + 1, 0, k, 2) for k in range(12) for i in range(3)])
    np.testing.assert_allclose(recording.event_values[:, 0], np.repeat(np.arange(12) * 0.1, 3))
    assert np.isnan(recording.event_values[:, 2]).all()


def test_packets_are_listed_by_tick_and_vehicle(tmp_path):
    run = synthetic.SyntheticRun(3, 12)
    recording = read_recording(written(tmp_path, run), synthetic.scenario(3))
    assert_array_equal(recording.sent, [(k, i + 1, k) for k in range(12) for i in range(3)])
    expected = [(k, (i + 1) % 3 + 1, i + 1, k - 1) for k in range(1, 12) for i in range(3) if run.heard[k, i]]
    assert_array_equal(recording.received, expected)
    np.testing.assert_allclose(recording.delay_s, 0.075)


class Gappy(synthetic.SyntheticRun):
    """A run that misses some ticks."""

    missing_states = frozenset({(3, 0), (4, 0)})
    missing_decisions = frozenset({(0, 1), (5, 1), (9, 0)})

    def write_state(self, recorder, k, i):
        if (k, i) not in self.missing_states:
            super().write_state(recorder, k, i)

    def write_decision(self, recorder, k, i):
        if (k, i) not in self.missing_decisions:
            super().write_decision(recorder, k, i)


def test_missed_ticks_hold_the_tick_before(tmp_path):
    run = Gappy(2, 10)
    recording = read_recording(written(tmp_path, run), synthetic.scenario(2))
    assert_array_equal(recording.position_ned_m[3:5, 0], run.state[[2, 2], 0, :3])
    assert_array_equal(recording.position_ned_m[5:, 0], run.state[5:, 0, :3])
    assert np.isnan(recording.command[0, 1]).all()
    assert_array_equal(recording.command[5, 1], run.command[4, 1])
    assert_array_equal(recording.command[9, 0], run.command[8, 0])


class Silent(synthetic.SyntheticRun):
    """A run in which the agent of vehicle 2 says nothing from tick 10 to 24."""

    def write_decision(self, recorder, k, i):
        if i != 1 or not 10 <= k < 25:
            super().write_decision(recorder, k, i)


def test_a_vehicle_without_a_fresh_command_rests_and_that_is_counted(tmp_path):
    run = Silent(2, 30)
    recording = read_recording(written(tmp_path, run), synthetic.scenario(2))
    assert_array_equal(recording.command[9:15, 1], run.command[[9] * 6, 1])
    assert not recording.command[15:25, 1].any()
    assert_array_equal(recording.command[25:, 1], run.command[25:, 1])
    assert_array_equal(recording.command[:, 0], run.command[:, 0])
    assert safe_command_metrics(recording)["safe_commands_stale_command"] == 10


class Losing(synthetic.SyntheticRun):
    """A run in which the computer of vehicle 2 is lost in tick 6."""

    def write_decision(self, recorder, k, i):
        if k < 6 or i != 1:
            super().write_decision(recorder, k, i)

    def write(self, recorder, **options):
        super().write(recorder, **options)
        for tick, lost in ((4, ["auv_1"]), (8, ["auv_2"])):  # the first is forged: it is not repeated
            status = synthetic.make(
                "auv_msgs/msg/FlockStatus",
                header=synthetic.header(self.time_ns(tick), ""),
                state="running",
                tick=tick,
                time_s=0.1 * tick,
                duration_s=1.0,
                waiting_for=[],
                lost_vehicles=lost,
                detail="",
            )
            recorder.write("/flock/status", status, self.time_ns(tick))


def test_a_lost_vehicle_has_no_commands_from_its_loss_on(tmp_path):
    run = Losing(2, 10)
    recording = read_recording(written(tmp_path, run), synthetic.scenario(2))
    assert_array_equal(recording.lost_at_s, [np.nan, 6 * 0.1])
    assert_array_equal(recording.command[:6, 1], run.command[:6, 1])
    assert np.isnan(recording.command[6:, 1]).all()
    assert np.isnan(recording.neighbour_position_ned_m[6:, 1]).all()
    check_states(recording, run)


def test_a_vehicle_that_is_commanded_to_the_end_is_not_lost_whatever_a_status_says(tmp_path, monkeypatch):
    monkeypatch.setattr(Losing, "write_decision", synthetic.SyntheticRun.write_decision)
    run = Losing(2, 10)
    recording = read_recording(written(tmp_path, run), synthetic.scenario(2))
    assert np.isnan(recording.lost_at_s).all()
    assert_array_equal(recording.command[:, 1], run.command[:, 1])


def test_an_unfinished_bag_gives_the_ticks_that_all_vehicles_have(tmp_path):
    run = synthetic.SyntheticRun(2, 60)
    path = written(tmp_path, run) / "bag_0.mcap"
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    recording = read_recording(tmp_path, synthetic.scenario(2))
    assert 5 < recording.n_ticks < 60
    check_states(recording, run, slice(recording.n_ticks + 1))


class Kinematic(synthetic.SyntheticRun):
    """A run whose vehicles take velocities."""

    def write_decision(self, recorder, k, i):
        twist = synthetic.twist([*self.command[k, i, :3], 0.0, 0.0, self.command[k, i, 5]])
        header = synthetic.header(self.time_ns(k), "map_ned")
        message = synthetic.make("geometry_msgs/msg/TwistStamped", header=header, twist=twist)
        recorder.write(f"/auv_{i + 1}/cmd_vel", message, self.time_ns(k))


def test_a_kinematic_vehicle_is_commanded_by_velocity_and_yaw_rate(tmp_path):
    run = Kinematic(2, 5)
    recording = read_recording(written(tmp_path, run), synthetic.scenario(2))
    assert_array_equal(recording.command[..., :3], run.command[..., :3])
    assert_array_equal(recording.command[..., 3:5], 0.0)
    assert_array_equal(recording.command[..., 5], run.command[..., 5])
    assert recording.sent.shape == (0, 3)
    assert np.isnan(recording.centre_ned_m).all()


def test_a_bag_of_other_vehicles_is_refused(tmp_path):
    bag_dir = written(tmp_path, synthetic.SyntheticRun(2, 3))
    with pytest.raises(BagError, match="holds no state of auv_3"):
        read_recording(bag_dir, synthetic.scenario(3))


def with_times_in_seconds(text):
    """Return a definition as it was when messages held scenario times as float64 seconds."""
    return re.sub(r"builtin_interfaces/Time (sent|arrival|start|end)\b", r"float64 \1_s", text)


def test_a_bag_of_before_the_times_were_stamps_reads_the_same(tmp_path, monkeypatch):
    run = synthetic.SyntheticRun(2, 6)
    new = synthetic.Recorder(tmp_path / "new")
    run.write(new)
    new.writer.close()

    store, make = get_typestore(Stores.ROS2_JAZZY), synthetic.make
    texts = {path.stem: with_times_in_seconds(path.read_text()) for path in synthetic.AUV_MSGS.glob("*.msg")}
    types = [get_types_from_msg(text, f"auv_msgs/msg/{name}") for name, text in texts.items()]
    store.register({name: kind for each in types for name, kind in each.items()})

    def make_old(name, /, **fields):
        if name in ("auv_msgs/msg/AcousticReception", "auv_msgs/msg/AcousticEvent"):
            for key in {"sent", "arrival", "start", "end"} & set(fields):
                stamp = fields.pop(key)
                fields[f"{key}_s"] = (stamp.sec * 10**9 + stamp.nanosec) * 1e-9
        return make(name, **fields)

    synthetic.message_type.cache_clear()
    monkeypatch.setattr(synthetic, "typestore", lambda: store)
    monkeypatch.setattr(synthetic, "make", make_old)
    old = synthetic.Recorder(tmp_path / "old")
    run.write(old)
    old.writer.close()
    monkeypatch.undo()
    synthetic.message_type.cache_clear()

    ours, theirs = (read_recording(tmp_path / name, synthetic.scenario(2)) for name in ("old", "new"))
    assert len(ours.delay_s) > 0
    np.testing.assert_allclose(ours.delay_s, theirs.delay_s, atol=1e-12)
    np.testing.assert_allclose(ours.event_values, theirs.event_values, atol=1e-12)
    assert b"sent_s" in next((tmp_path / "old").glob("*.mcap")).read_bytes()


class OldRealTimeRun(synthetic.SyntheticRun):
    """A run in real time in an older recording: tick 0 has the stamp 0."""

    def time_ns(self, tick):
        return super().time_ns(tick) if tick else 0


def test_an_old_bag_of_real_time_whose_first_stamps_are_0_is_read(tmp_path):
    run = OldRealTimeRun(2, 12, epoch_ns=1_700_000_000_123_456_789)
    recording = read_recording(written(tmp_path, run), synthetic.scenario(2))
    check_states(recording, run)
    assert_array_equal(recording.command[1:], run.command[1:])


class TwoEpochs(synthetic.SyntheticRun):
    """A bag into which a state of another time has come."""

    def time_ns(self, tick):
        return super().time_ns(tick) + (tick == 7) * 3 * 10**9


def test_a_state_that_is_not_of_the_runs_time_line_is_left_out_and_named(tmp_path):
    run = TwoEpochs(2, 12)
    said: list[str] = []
    recording = read_recording(written(tmp_path, run), synthetic.scenario(2), said.append)
    assert_array_equal(recording.position_ned_m[7], run.state[6, :, :3])
    (line,) = said
    assert "1 of /auv_1/state" in line
    assert line.endswith("/auv_1/state of tick 7 is stamped 3.000 s late")


def test_a_recording_is_no_longer_than_its_scenario(tmp_path):
    run = synthetic.SyntheticRun(2, 12)
    recorder = synthetic.Recorder(tmp_path / "bag")
    run.write(recorder)
    zero, far_ns = (0.0,) * 6, 5 * 10**17
    for i in range(2):
        state = synthetic.make(
            "auv_msgs/msg/VehicleState",
            header=synthetic.header(far_ns, "map_ned"),
            tick=5_000_000_000,
            pose=synthetic.pose(zero[:3], (1.0, 0.0, 0.0, 0.0)),
            twist=synthetic.twist(zero),
            valid=True,
            bounded=True,
            position_sd_m=0.0,
            heading_sd_rad=0.0,
        )
        recorder.write(f"/auv_{i + 1}/state", state, far_ns)
    recorder.writer.close()
    scenario = dataclasses.replace(synthetic.scenario(2), ticks=12)
    assert len(read_recording(tmp_path / "bag", scenario).t_s) == 13


@pytest.mark.parametrize("definition", ["no { definition", "foo/NotThere it", "wstring word", ""])
def test_a_topic_of_a_type_that_cannot_be_read_hides_no_other(tmp_path, definition):
    run = synthetic.SyntheticRun(2, 6)
    recorder = synthetic.Recorder(tmp_path / "bag")
    for topic in ("/elsewhere", "/auv_1/nav"):
        channel = recorder.writer.add_topic(Topic(topic, MessageType("foo/msg/X", definition, "")))
        recorder.writer.write(channel, b"\0\1\0\0" + bytes(40), 0)
    run.write(recorder)
    recorder.writer.close()
    said: list[str] = []
    recording = read_recording(tmp_path / "bag", synthetic.scenario(2), said.append)
    check_states(recording, run)
    assert_array_equal(recording.nav_position_ned_m, run.nav[:-1, :, :3])
    assert said == ["messages left out, which are not of this run: 1 of /auv_1/nav"]


class Haunted(synthetic.SyntheticRun):
    """
    A run whose bag has foreign messages: ticks and vehicles that the run does not have, and malformed bytes.
    """

    def write(self, recorder, **options):
        super().write(recorder, **options)
        rng, t_ns = np.random.default_rng(3), self.time_ns(3)
        for address in (0, 200):
            message = synthetic.random_message("auv_msgs/msg/NeighbourEstimates", rng)
            estimate = synthetic.random_message("auv_msgs/msg/NeighbourEstimate", rng)
            message.tick, message.neighbours, estimate.address = 3, [estimate], address
            recorder.write("/auv_1/neighbours", message, t_ns)
        for i in range(self.n):
            state = synthetic.random_message("auv_msgs/msg/VehicleState", rng)
            state.tick = 5_000_000_000
            recorder.write(f"/auv_{i + 1}/state", state, t_ns)
        channel = recorder.writer.add_topic(
            Topic("/auv_1/acoustic/tx", synthetic.message_type("auv_msgs/msg/AcousticOutbox"))
        )
        recorder.writer.write(channel, bytes(range(90)), t_ns)


def test_what_is_not_of_the_run_is_left_out_and_counted(tmp_path):
    run = Haunted(2, 12)
    said: list[str] = []
    recording = read_recording(written(tmp_path, run), synthetic.scenario(2), said.append)
    assert recording.n_ticks == 12
    check_states(recording, run)
    (line,) = said
    assert line == (
        "messages left out, which are not of this run: 1 of /auv_1/acoustic/tx, 2 of /auv_1/neighbours, "
        "1 of /auv_1/state, 1 of /auv_2/state"
    )
