"""The studies of torpedoes: which cells each has, and what they must keep."""

from __future__ import annotations

from auv_thesis.torpedoes.cells import Cell, in_still_water, losing_one
from auv_thesis.torpedoes.limits import Limit

SLOTS_S = (2.0, 8.0)
APART = Limit("pair_distance_min_m", 5.0)
_FLEET = "agent.fleet.params"
_WIDE = f"{_FLEET}.path={{kind: racetrack, params: {{straight_m: 400.0, radius_m: 250.0}}}}"
_SHAPES = {
    "line of 3": ("vehicles.count=3",),
    "line of 5": (),
    "line of 8, curves of 250 m": ("vehicles.count=8", _WIDE),
    "wedge of 5": (f"{_FLEET}.shape=wedge",),
    "column of 5": (f"{_FLEET}.shape=column", f"{_FLEET}.spacing_m=20.0"),
    "diamond of 4": ("vehicles.count=4", f"{_FLEET}.shape=diamond"),
}
_LOST_S = (750.0, 850.0)
"""When a vehicle in formation is lost: later than nearly all fleets need to form."""
_LOST_DURATION_S = 950.0
_FORMED_WITHIN_S = {2.0: 620.0, 8.0: 700.0}


def _slot(slot_s: float) -> str:
    return f"acoustics.mac.params.slot_s={slot_s}"


def _name(what: str, slot_s: float, loss_prob: float = 0.3) -> str:
    return f"{what}, slots of {slot_s:g} s, {100.0 * loss_prob:.0f} % lost"


def _distances() -> tuple[Cell, ...]:
    cells = []
    for shape, changes in _SHAPES.items():
        for slot_s in SLOTS_S:
            is_main = shape == "line of 5"
            limits: tuple[Limit, ...] = (
                APART,
                Limit("cross_track_rms_m", 0.1),
                Limit("cross_track_max_m", 0.7),
            )
            if is_main:
                limits += (
                    Limit("packets_per_minute_after_700s", 6.0, most=0.5),
                    Limit("fleet_formed_at_s", _FORMED_WITHIN_S[slot_s], most=0.05),
                )
            cells.append(
                Cell(
                    _name(shape, slot_s),
                    "torpedo_fleet_modem",
                    (*changes, _slot(slot_s)),
                    limits,
                    is_first_look=is_main,
                )
            )
    return tuple(cells)


def _coordination() -> tuple[Cell, ...]:
    cells = []
    for kind, limit_m in (("event", 1.0), ("periodic", 0.5)):
        for count in (3, 5):
            for slot_s in (0.5, *SLOTS_S):
                for loss_prob in (0.0, 0.3, 0.6):
                    cells.append(
                        Cell(
                            _name(f"line of {count}, {kind}", slot_s, loss_prob),
                            "torpedo_fleet_modem",
                            (
                                f"vehicles.count={count}",
                                f"{_FLEET}.broadcast.kind={kind}",
                                f"acoustics.outage.params.loss_prob={loss_prob}",
                                _slot(slot_s),
                            ),
                            (Limit("coordination_error_after_700s_p95_m", limit_m), APART),
                            duration_s=1200.0,
                            every=3,
                            is_first_look=(count, slot_s, loss_prob) == (5, 2.0, 0.3) and kind == "event",
                        )
                    )
    return tuple(cells)


def _slow() -> tuple[Cell, ...]:
    return tuple(
        Cell(
            _name("line of 5, one limited to 806 rpm", slot_s),
            "torpedo_slow",
            (_slot(slot_s),),
            (Limit("coordination_error_after_700s_p95_m", limit_m), APART),
            per_seed=in_still_water,
            every=3,
            is_first_look=slot_s == SLOTS_S[0],
        )
        for slot_s, limit_m in zip(SLOTS_S, (10.0, 15.0), strict=True)
    )


def _losses() -> tuple[Cell, ...]:
    live, wreck = Limit("pair_distance_working_min_m", 5.0), Limit("wreck_distance_min_m", 5.0)
    shapes = ("line of 5", "wedge of 5", "column of 5", "diamond of 4")
    cells = []
    for slot_s in SLOTS_S:
        for shape in shapes:
            changes = tuple(each for each in _SHAPES[shape] if not each.startswith("vehicles"))
            cells.append(
                Cell(
                    _name(f"{shape}, one lost in formation", slot_s),
                    "torpedo_lost",
                    (*changes, _slot(slot_s)),
                    (live, wreck),
                    duration_s=_LOST_DURATION_S,
                    per_seed=losing_one(4 if shape == "diamond of 4" else 5, *_LOST_S),
                    is_first_look=(shape, slot_s) == ("column of 5", 2.0),
                )
            )
        cells.append(
            Cell(
                _name("line of 5, one lost on the way to its lane", slot_s),
                "torpedo_lost",
                (_slot(slot_s),),
                (live, Limit("wreck_distance_min_m", 1.6), Limit("wreck_distance_min_m", 5.0, most=0.06)),
                per_seed=losing_one(5, 20.0, 250.0),
            )
        )
    return tuple(cells)


def _silences() -> tuple[Cell, ...]:
    return tuple(
        Cell(
            _name(f"line of 5, silent for {silent_s:g} s", slot_s),
            "torpedo_silent",
            (f"acoustics.silence.until_s={600.0 + silent_s}", _slot(slot_s)),
            (APART, Limit("coordination_error_after_700s_p95_m", 0.6)),
            duration_s=900.0,
            is_first_look=(silent_s, slot_s) == (300.0, 2.0),
        )
        for slot_s in SLOTS_S
        for silent_s in (60.0, 180.0, 300.0)
    )


_ONE_DEPTH = ()
_DIVING = (f"{_FLEET}.layers=both", "random_starts.centre_ned_m.2=5.0")
_TURN_AWAY = f"{_FLEET}.turn_away.kind=intent_vo"


def _turning_away() -> tuple[Cell, ...]:
    return tuple(
        Cell(
            _name(f"line of 5, {words}, {_TURN_AWAY.rpartition('=')[2]}", slot_s),
            "torpedo_unsafe",
            (*changes, _TURN_AWAY, _slot(slot_s)),
            (Limit("pair_distance_min_m", 5.0, most=0.06),),
            is_first_look=(changes, slot_s) == (_ONE_DEPTH, 2.0),
        )
        for words, changes in (("at one depth", _ONE_DEPTH), ("diving from 5 m", _DIVING))
        for slot_s in SLOTS_S
    )


def _controls() -> tuple[Cell, ...]:
    cells = []
    for slot_s in SLOTS_S:
        near = Limit("pair_distance_min_m", 5.0, least=0.15)
        cells += [
            Cell(
                _name("line of 5 at one depth, no turning away", slot_s),
                "torpedo_unsafe",
                (_slot(slot_s),),
                (near,),
                is_first_look=slot_s == SLOTS_S[0],
            ),
            Cell(
                _name("line of 5 diving from 5 m, no turning away", slot_s),
                "torpedo_unsafe",
                (*_DIVING, _slot(slot_s)),
                (Limit("pair_distance_min_m", 5.0, least=0.1),),
            ),
            Cell(
                _name("column of 5 at one depth, one lost in formation", slot_s),
                "torpedo_column_flat",
                (_slot(slot_s),),
                (Limit("wreck_distance_min_m", 5.0, least=0.25),),
                duration_s=_LOST_DURATION_S,
                per_seed=losing_one(5, *_LOST_S),
                is_first_look=slot_s == SLOTS_S[0],
            ),
        ]
    return tuple(cells)


DISTANCES = _distances()
COORDINATION = _coordination()
SLOW = _slow()
LOSSES = _losses()
SILENCES = _silences()
TURNING_AWAY = _turning_away()
CONTROLS = _controls()
STUDIES = (DISTANCES, COORDINATION, SLOW, LOSSES, SILENCES, TURNING_AWAY, CONTROLS)
