"""Claims about losses in bursts."""

from itertools import groupby, pairwise

import pytest

from auv_core.params import ConfigError, load_section
from auv_sim.acoustics.medium import OUTAGE
from auv_sim.acoustics.outage.gilbert_elliott import Outage, Params

BURSTS = Params(p_gb=0.05, p_bg=0.2, loss_good_prob=0.0, loss_bad_prob=1.0)


def _losses(params, count, *, seed=3, destination=2):
    outage = Outage(params, seed)
    return [outage.lost(1, destination, sequence) for sequence in range(1, count + 1)]


def test_the_share_of_losses_is_that_of_the_long_run():
    losses = _losses(BURSTS, 8000)
    assert BURSTS.loss_prob == pytest.approx(0.2)
    assert sum(losses) / len(losses) == pytest.approx(0.2, rel=0.15)


def test_bursts_last_as_long_as_the_bad_state():
    runs = [(lost, len(list(group))) for lost, group in groupby(_losses(BURSTS, 8000))]
    for state, mean in ((True, 5.0), (False, 20.0)):
        lengths = [length for lost, length in runs if lost is state]
        assert sum(lengths) / len(lengths) == pytest.approx(mean, rel=0.15)


def test_both_states_lose_their_share():
    params = Params(p_gb=0.1, p_bg=0.1, loss_good_prob=0.1, loss_bad_prob=0.7)
    outage = Outage(params, 4)
    for is_bad, share in ((False, 0.1), (True, 0.7)):
        sequences = [n for n in range(1, 5000) if outage.is_bad(1, 2, n) is is_bad]
        lost = sum(outage.lost(1, 2, n) for n in sequences)
        assert lost / len(sequences) == pytest.approx(share, rel=0.15)


def test_a_memoryless_chain_is_a_coin():
    losses = _losses(Params(p_gb=0.3, p_bg=0.7, loss_good_prob=0.0, loss_bad_prob=1.0), 10000)
    assert sum(losses) / len(losses) == pytest.approx(0.3, rel=0.06)
    after = [later for earlier, later in pairwise(losses) if earlier]
    assert sum(after) / len(after) == pytest.approx(0.3, rel=0.1)


def test_what_was_asked_before_does_not_matter():
    forward = _losses(BURSTS, 300)
    outage = Outage(BURSTS, 3)
    asked = [*range(300, 0, -7), *range(2, 300, 11), *range(1, 301)]
    assert [outage.lost(1, 2, n) for n in asked] == [forward[n - 1] for n in asked]


def test_links_and_seeds_have_their_own_luck():
    assert len({tuple(_losses(BURSTS, 200, seed=s, destination=d)) for s in (3, 4) for d in (2, 3)}) == 4


def test_a_large_sequence_number_costs_no_more_than_the_memory():
    rare = Params(p_gb=1e-3, p_bg=1e-3)
    assert Outage(rare, 3).lost(1, 2, 2**40) in (True, False)


def test_a_chain_that_would_rather_change_than_stay_is_refused():
    with pytest.raises(ConfigError, match=r"^x\.params\.p_gb: 0\.6 is not allowed; allowed: at most"):
        load_section({"kind": "gilbert_elliott", "params": {"p_gb": 0.6, "p_bg": 0.7}}, "x", OUTAGE)
