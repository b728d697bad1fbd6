"""Running the neighbour filters again from the packets in a bag."""

from dataclasses import replace

import numpy as np
import pytest
import synthetic_bag as synthetic

from auv_bag.bag import Bag
from auv_bringup.tools import replay
from auv_experiment.re_estimate import re_estimate
from auv_experiment.scenario.loading import load_scenario, scenario_to_yaml
from auv_flocking.agent_config import NO_TRACKER
from auv_flocking.input_limits import InputLimits
from auv_flocking.neighbours.table import NeighbourConfig, NeighbourTable
from auv_flocking.report import Report
from auv_flocking.reports import exact
from auv_flocking.senses import Senses
from auv_flocking.trackers import make_tracker

CONFIG = NeighbourConfig()
LIMITS = InputLimits()
PERIOD_S = 0.1
FORMAT = exact.Format(exact.Params(), ())


class Filtered(synthetic.SyntheticRun):
    """A run whose recorded estimates are made from its recorded packets."""

    def __init__(self, n, n_ticks, *, config=CONFIG, missing=frozenset()):
        super().__init__(n, n_ticks)
        self.nav[..., 13:] = 0.0
        self.tables = [NeighbourTable(config) for _ in range(n)]
        self.missing = missing

    def write_decision(self, recorder, k, i):
        header, t_ns = synthetic.header(self.time_ns(k), "map_ned"), self.time_ns(k)
        receptions = [self.reception(k, j) for j in range(self.n) if j != i and (k + j) % 4 == 0]
        for reception in receptions:
            if len(reception.packet.payload) > 1:
                self.tables[i].receive(self.report(k, reception.packet.source - 1))
        inbox = synthetic.make(
            "auv_msgs/msg/AcousticInbox",
            header=header,
            tick=k,
            transmit_ready=False,
            receptions=receptions,
            contacts=[],
        )
        if (k, i) not in self.missing:
            recorder.write(f"/auv_{i + 1}/acoustic/rx", inbox, t_ns)
        estimates = [self.message(each) for each in self.tables[i].estimates(k * PERIOD_S)]
        neighbours = synthetic.make(
            "auv_msgs/msg/NeighbourEstimates", header=header, tick=k, neighbours=estimates
        )
        recorder.write(f"/auv_{i + 1}/neighbours", neighbours, t_ns)

    def report(self, k, j):
        position, velocity = (
            tuple(self.state[k, j, at : at + 3].astype(np.float32).tolist()) for at in (0, 7)
        )
        zero = (0.0, 0.0, 0.0)
        return Report(j + 1, max(k - 2, 0) * PERIOD_S, position, velocity, zero, zero)

    def reception(self, k, j):
        payload = b"?" if k == 8 else FORMAT.encode(self.report(k, j))  # once, a packet that is not a report
        packet = synthetic.make(
            "auv_msgs/msg/AcousticPacket",
            tick=k,
            source=j + 1,
            destination=0,
            sequence=k,
            payload=np.frombuffer(payload, np.uint8),
        )
        return synthetic.make(
            "auv_msgs/msg/AcousticReception",
            packet=packet,
            sent=synthetic.time(0),
            arrival=synthetic.time(10**8),
            snr_db=float("nan"),
        )

    @staticmethod
    def message(estimate):
        return synthetic.make(
            "auv_msgs/msg/NeighbourEstimate",
            address=estimate.address,
            position=synthetic.point(estimate.position),
            velocity=synthetic.vector(estimate.velocity),
            covariance=np.asarray(estimate.covariance).reshape(-1).copy(),
            age_s=estimate.age_s,
            sonar_age_s=estimate.sonar_age_s,
        )


IDS = [f"auv_{i + 1}" for i in range(4)]


def senses(config, n=4):
    return [
        Senses(config, LIMITS, FORMAT, address, n, PERIOD_S, make_tracker(NO_TRACKER, ()))
        for address in range(1, n + 1)
    ]


def written(tmp_path, run):
    recorder = synthetic.Recorder(tmp_path / "bag")
    run.write(recorder)
    recorder.writer.close()
    return Bag(tmp_path)


def test_the_packets_give_the_estimates(tmp_path):
    result = re_estimate(written(tmp_path, Filtered(4, 40)), IDS, senses(CONFIG), PERIOD_S)
    assert result.agrees
    assert result.ticks == 4 * 40
    assert result.estimates > 300
    assert (result.position_m, result.velocity_mps, result.covariance) == (0.0, 0.0, 0.0)


def test_other_filters_do_not(tmp_path):
    other = replace(CONFIG, acceleration_psd=2.0 * CONFIG.acceleration_psd)
    result = re_estimate(written(tmp_path, Filtered(4, 40)), IDS, senses(other), PERIOD_S)
    assert not result.agrees
    assert result.covariance > 1e-6
    assert result.unmatched == 0


def test_estimates_on_one_side_only_are_a_difference(tmp_path):
    forgetful = replace(CONFIG, timeout_s=0.2)
    result = re_estimate(written(tmp_path, Filtered(4, 40)), IDS, senses(forgetful), PERIOD_S)
    assert result.unmatched > 0
    assert not result.agrees


def test_after_a_missing_inbox_nothing_is_claimed(tmp_path):
    bag = written(tmp_path, Filtered(4, 40, missing={(25, 2)}))
    result = re_estimate(bag, IDS, senses(CONFIG), PERIOD_S)
    assert result.agrees
    assert result.unused_ticks == 15
    assert result.ticks == 4 * 40 - 15


def test_a_bag_without_packets_does_not_agree(tmp_path):
    bag = written(tmp_path, synthetic.SyntheticRun(1, 2))
    result = re_estimate(bag, ["auv_9"], senses(CONFIG, 1), PERIOD_S)
    assert not result.agrees


@pytest.mark.parametrize(("change", "status"), [(1.0, 0), (3.0, 1)])
def test_the_command_takes_the_scenario_beside_the_bag(tmp_path, capsys, change, status):
    scenario = load_scenario("flock_acoustic", overrides=["agent.report={kind: exact}"])
    settings = scenario.agent.neighbours
    config = replace(settings, position_std_m=change * settings.position_std_m)
    written(tmp_path, Filtered(4, 20, config=config))
    (tmp_path / "scenario.yaml").write_text(scenario_to_yaml(scenario))
    assert replay.main([str(tmp_path), "--re-estimate"]) == status
    said = capsys.readouterr()
    assert "max difference" in said.out
    assert ("give the recorded estimates" in said.out) == (status == 0)
    assert said.err == ""


def test_the_command_says_what_is_missing(tmp_path, capsys):
    written(tmp_path, Filtered(4, 2))
    assert replay.main([str(tmp_path), "--re-estimate"]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert replay.main([str(tmp_path / "nowhere")]) == 2
    assert "no such folder" in capsys.readouterr().err


@pytest.mark.parametrize(
    "options", [["--rate", "0"], ["--rate", "nan"], ["--start", "-1"], ["--clock", "x"], ["--loop"]]
)
def test_impossible_options_are_refused(options, tmp_path, capsys):
    with pytest.raises(SystemExit) as caught:
        replay.main([str(tmp_path), *options])
    assert caught.value.code == 2
    assert "Traceback" not in capsys.readouterr().err
