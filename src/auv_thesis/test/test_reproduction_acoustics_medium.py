"""Claims about the studies of the medium: their formulas, and one cell of each."""

import math

import pytest

from auv_core.messages import AcousticEvent, Outcome
from auv_sim.acoustics.modem.noise_limited import Modem
from auv_sim.acoustics.propagation.straight import Propagation
from auv_thesis.acoustics import medium as sweep
from auv_thesis.acoustics import medium_access as access


@pytest.mark.parametrize("preset", ["micromodem_fsk", "micromodem_psk", "micromodem_fdp", "evologics_s2c"])
def test_the_analytic_value_is_what_the_plugins_make(preset):
    config = sweep.medium_config(preset, fleet_size=2)
    modem, propagation = Modem(config.modem.params), Propagation(config.propagation.params)
    for range_m in (50.0, 3000.0, 3450.0, 3510.0, 4900.0, 5140.0, 5300.0, 6700.0, 6780.0, 7000.0):
        loss_db = propagation.loss_db((0.0, 0.0, 0.0), (range_m, 0.0, 0.0), modem.frequency_khz)
        snr = modem.snr_ratio(loss_db)
        share = math.exp(modem.log_success(snr, 32)) if modem.acquires(snr) else 0.0
        assert sweep.expected_delivery(config, range_m) == pytest.approx(share, abs=1e-9)


def test_a_relay_without_levels_delivers_what_outage_leaves_within_its_range():
    config = sweep.medium_config("lossy", fleet_size=2)
    assert [sweep.expected_delivery(config, range_m) for range_m in (1.0, 1000.0, 1001.0)] == [0.8, 0.8, 0.0]


def test_a_cell_of_the_sweep_is_measured():
    cell = sweep.measured("evologics_s2c", 3500.0, 3)
    assert cell.sent >= sweep.PACKETS
    assert cell.violations == 0
    low, high = cell.band
    assert low < cell.delivered / cell.sent < high
    assert high - low < 0.1


def _heard(source, destination, sequence, end_s):
    return AcousticEvent(
        Outcome.DELIVERED, source, destination, sequence, end_s - 0.1, end_s, math.nan, 32
    )  # fmt: skip


def test_the_age_of_information_is_a_saw_tooth():
    made_s = {(source, second): float(second) for source in (1, 2) for second in range(1, 100)}
    events = [_heard(source, 3 - source, second, second + 0.5) for source, second in made_s]
    # Every second a report half a second old: from 0.5 s to 1.5 s, for all but the last half second.
    assert access.mean_age_s(access.Log(events, made_s, 2, 100.0)) == pytest.approx(1.0, abs=0.01)
    deaf = access.Log(events[:99], made_s, 2, 100.0)
    assert access.mean_age_s(deaf) == math.inf, "one link heard nothing"


def test_schemes_offer_what_the_study_says():
    for scheme in access.SCHEMES:
        for fleet in access.FLEETS:
            config = sweep.medium_config(
                access.PRESET, fleet_size=fleet, mac=access.scheme_section(scheme, fleet)
            )
            assert config.mac.kind == scheme
    assert pytest.approx(0.3623, abs=1e-4) == access.AIRTIME_S
    assert max(math.dist(a, b) for a in access.places(16, 1) for b in access.places(16, 1)) < 433.1


def test_a_cell_of_the_comparison_is_measured(monkeypatch):
    monkeypatch.setattr(access, "DURATION_S", 84.0)
    monkeypatch.setattr(access, "SEEDS", (4,))
    cell = access.measured("tdma", 4)
    assert cell.shares[Outcome.DELIVERED] == 1.0
    assert cell.fairness == pytest.approx(1.0, abs=1e-3)
    assert cell.violations == 0
    assert 0.0 < cell.delay_s < 0.6
    # Three of four reports of a cycle of 2.8 s; the last ones are still in the water.
    assert cell.throughput_bps == pytest.approx(3 * 256 / 2.8, rel=0.05)
