"""
Runs of the consensus filters alone: four vehicles hear each other through a modem and do not steer.

Vehicles, agents, packets, neighbour filters and medium are those of every other run. The gains of the
flocking law are zero, so that the vehicles stay where they start, or all move with the flock's velocity. The
estimates of the flocking centre then depend on the filters only.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from auv_core.messages import Outcome
from auv_experiment.recording import FloatArray
from auv_thesis.items import Run, RunSpec

N_VEHICLES = 4
DURATION_S = 600.0
LAST_S = 60.0
SETTLED_SHARE = 0.05
LOSSES = (0.0, 0.3, 0.6, 0.9)
SEEDS = (301, 302, 303)

THESIS, HELD, PI, PUSH_SUM, MEAN = (
    "thesis",
    "thesis, without extrapolation by its rate",
    "PI",
    "push-sum",
    "mean of neighbours",
)
FILTERS = {
    THESIS: "{kind: thesis}",
    HELD: "{kind: thesis, params: {carried_by: flock}}",
    PI: "{kind: pi}",
    PUSH_SUM: "{kind: push_sum}",
    MEAN: "{kind: neighbour_mean}",
}
VARIANTS = {
    "slots of 0.5 s": (0.5, ()),
    "reports in floating point": (2.0, ("agent.report={kind: exact}",)),
    "neighbours forgotten after 30 s": (2.0, ("agent.neighbours.timeout_s=30.0",)),
}
EXACT_PUSH_SUM = "{kind: push_sum, params: {quantise: false}}"

_AT_REST = (
    "sampling=sampled",
    "period_s=0.5",
    "dt_s=0.5",
    "agent.flocking.params.cohesion_gain_ps=0.0",
    "agent.flocking.params.path_gain_ps=0.0",
    "agent.report={kind: compact}",
    "agent.neighbours.timeout_s=300.0",
)


def _water(slot_s: float, loss_prob: float) -> str:
    slots = f"mac: {{kind: tdma, params: {{slot_s: {slot_s}}}}}"
    losses = f"outage: {{kind: bernoulli, params: {{loss_prob: {loss_prob}}}}}"
    return f"acoustics={{preset: lossy, modem: {{params: {{max_payload_bytes: 256}}}}, {slots}, {losses}}}"


def at_rest(
    consensus: str,
    loss_prob: float,
    seed: int,
    slot_s: float = 2.0,
    extra: tuple[str, ...] = (),
    duration_s: float = DURATION_S,
) -> RunSpec:
    """Return a run of four vehicles that stay where they start."""
    changes = (f"agent.consensus={consensus}", _water(slot_s, loss_prob), f"seed={seed}")
    return RunSpec(
        "ch5_one_leader_blind", (*_AT_REST, "reference.params.rate_radps=0.0", *changes, *extra), duration_s
    )


def moving(consensus: str, loss_prob: float, seed: int) -> RunSpec:
    """
    Return a run of four vehicles that all move with their estimate of the flock's velocity: 0.1 m/s, turning.
    """
    changes = (f"agent.consensus={consensus}", _water(2.0, loss_prob), f"seed={seed}")
    return RunSpec(
        "ch5_one_leader_blind", (*_AT_REST, "agent.flocking.params.feedforward=flock", *changes), DURATION_S
    )


STATIC = {
    (name, loss): tuple(at_rest(consensus, loss, seed) for seed in SEEDS)
    for name, consensus in FILTERS.items()
    for loss in LOSSES
}
LONG_S = 3000.0
LONG = {name: at_rest(FILTERS[name], 0.9, SEEDS[0], duration_s=LONG_S) for name in (PI, PUSH_SUM, MEAN)}
VARIED = {
    (name, variant): at_rest(
        EXACT_PUSH_SUM if name == PUSH_SUM and "floating" in variant else consensus,
        0.6,
        SEEDS[0],
        slot_s,
        extra,
    )
    for name, consensus in FILTERS.items()
    for variant, (slot_s, extra) in VARIANTS.items()
}
_FOLLOWING = {
    HELD: "{{kind: thesis, params: {{carried_by: flock, follow_flock: {0}}}}}",
    PI: "{{kind: pi, params: {{follow_flock: {0}}}}}",
    PUSH_SUM: "{{kind: push_sum, params: {{follow_flock: {0}}}}}",
    MEAN: "{{kind: neighbour_mean, params: {{follow_flock: {0}}}}}",
}
MOVING = {
    (name, follows): moving(consensus.format(str(follows).lower()), 0.3, SEEDS[0])
    for name, consensus in _FOLLOWING.items()
    for follows in (False, True)
}
_WITH_VELOCITY = (
    "sampling=sampled",
    "agent.flocking.params.feedforward=flock",
    "agent.consensus.params.follow_flock=true",
)
LAG = {
    "blind followers, as the thesis's text has it": RunSpec("ch5_one_leader_blind", (), 300.0),
    "the same with velocity consensus": RunSpec("ch5_one_leader_blind", _WITH_VELOCITY, 300.0),
    "and a leader that steers the centre": RunSpec(
        "ch5_one_leader_blind", (*_WITH_VELOCITY, "agent.flocking.params.leader_steers=centre"), 300.0
    ),
}
FLYING = {
    name: RunSpec("flock_modem", (f"agent.consensus={consensus}", _water(2.0, 0.6), f"seed={SEEDS[0]}"))
    for name, consensus in FILTERS.items()
}


@dataclass(frozen=True)
class Numbers:
    """
    Summary of one run of a filter, over its last minute.

    bias_m: largest |mean of the estimates - mean of the positions|; disagreement_m: largest distance of an
    estimate from the mean of the estimates; error_rms_m: root mean square of |estimate - mean of the
    positions|; settled_s: first time after which every error stays within 5 % of the largest initial error,
    None if there is no such time; rate_ps: rate of the exponential that comes as near to the final estimates
    in the same time, whether these are right or wrong, None if the estimates do not settle.
    """

    bias_m: float
    disagreement_m: float
    error_rms_m: float
    settled_s: float | None
    rate_ps: float | None


def errors_ned_m(run: Run) -> FloatArray:
    """Return estimate minus mean of the true positions (K, N, 3) (m; NED)."""
    truth = run.recording.position_ned_m[:-1].mean(axis=1, keepdims=True)
    errors: FloatArray = run.recording.centre_ned_m - truth
    return errors


def numbers(run: Run) -> Numbers:
    """Return the numbers of one run."""
    t_s, error = run.recording.t_s[:-1], errors_ned_m(run)
    last = error[t_s >= t_s[-1] - LAST_S]
    mean = last.mean(axis=1)
    reached_s = _settled_s(t_s, error - last.mean(axis=0))
    return Numbers(
        float(np.linalg.norm(mean, axis=-1).max()),
        float(np.linalg.norm(last - mean[:, np.newaxis], axis=-1).max()),
        float(np.sqrt(np.square(last).sum(axis=-1).mean())),
        _settled_s(t_s, error),
        -math.log(SETTLED_SHARE) / reached_s if reached_s else None,
    )


def _settled_s(t_s: FloatArray, away_m: FloatArray) -> float | None:
    """
    Return the time after which all distances (K, N, 3) stay within 5 % of the largest initial one (s), or
    None.
    """
    sizes_m = np.linalg.norm(away_m, axis=-1).max(axis=1)
    outside = np.flatnonzero(sizes_m > SETTLED_SHARE * sizes_m[0])
    if not outside.size:
        return 0.0
    return float(t_s[outside[-1] + 1]) if outside[-1] + 1 < len(t_s) else None


def worst(runs: list[Run]) -> Numbers:
    """Return the worst value of each number over the runs."""
    found = [numbers(run) for run in runs]
    times_s, rates_ps = [item.settled_s for item in found], [item.rate_ps for item in found]
    return Numbers(
        max(item.bias_m for item in found),
        max(item.disagreement_m for item in found),
        max(item.error_rms_m for item in found),
        None if None in times_s else max(time_s for time_s in times_s if time_s is not None),
        None if None in rates_ps else min(rate_ps for rate_ps in rates_ps if rate_ps is not None),
    )


def payload(run: Run) -> tuple[int, float]:
    """Return the size of a report (bytes), and the bytes per second that all modems together transmit."""
    events = run.recording.events
    sent = events[events[:, 1] == int(Outcome.SENT)]
    return int(sent[:, 5].max()), float(sent[:, 5].sum() / run.recording.t_s[-1])
