"""The runs of chapters 5 and 6, defined once for figures, tables and claims."""

from __future__ import annotations

from auv_thesis.items import RunSpec

COARSE = ("dt_s=0.02", "period_s=0.1")
"""Gives the same numbers to four digits as steps of 0.01 s; recorded ten times per second."""

FOUR_LEADERS = RunSpec("ch5_four_leaders", COARSE)
ONE_LEADER = RunSpec("ch5_one_leader", COARSE)
BLIND = RunSpec("ch5_one_leader_blind", COARSE)
OBSTACLES = RunSpec("ch5_obstacles", COARSE)
ON_A_MODEM = RunSpec("ch5_communication")
ON_A_MODEM_OBSTACLES = RunSpec("ch5_communication_obstacles")

FUZZY_FOUR_LEADERS = RunSpec("ch6_four_leaders", COARSE)
FUZZY_ONE_LEADER = RunSpec("ch6_one_leader", COARSE)
FUZZY_OBSTACLES = RunSpec("ch6_obstacles", COARSE)
FUZZY_PRINTED_OBSTACLES = RunSpec(
    "ch6_obstacles", (*COARSE, "agent.separation.params.obstacles=printed"), 200.0
)

_AT_REST = "reference.params.rate_radps=0.0"
RESTING = RunSpec("ch5_four_leaders", (*COARSE, _AT_REST), 60.0)
RESTING_BLIND = RunSpec("ch5_one_leader_blind", (*COARSE, _AT_REST), 60.0)

CHANNEL_S = 200.0
SLOTS_S = (0.1, 0.5, 2.0)
LOSSES = (0.0, 0.3, 0.6)
MATCHED = (
    "agent.flocking.params.bandwidth_ratio=0.05",
    "agent.consensus.params.rate_ps=0.05",
    "agent.neighbours.timeout_s=300.0",
)
"""Feedback and consensus twenty times slower, and neighbour estimates kept through minutes of silence."""


def on_channel(slot_s: float, loss: float, changes: tuple[str, ...] = ()) -> RunSpec:
    """Return the flock without obstacles on a TDMA channel with this slot length and loss."""
    return RunSpec(
        "ch5_communication",
        (
            "environment.obstacles=[]",
            f"acoustics.mac.params.slot_s={slot_s:g}",
            f"acoustics.outage.params.loss_prob={loss:g}",
            "agent.hold_s=60.0",
            *changes,
        ),
        CHANNEL_S,
    )


AS_PRINTED_ON = {(slot_s, loss): on_channel(slot_s, loss) for slot_s in SLOTS_S for loss in LOSSES}
MATCHED_ON = {(slot_s, loss): on_channel(slot_s, loss, MATCHED) for slot_s in SLOTS_S[1:] for loss in LOSSES}
