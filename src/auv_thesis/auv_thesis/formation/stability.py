"""
String, mesh and leader-to-formation stability of a formation under the law of chapter 3.

The thesis defines these notions (Section 1.11) and applies none of them. The expected numbers are those of a
separate study with its own program; they hold to 0.005 m and to 0.01 in gamma.
"""

from __future__ import annotations

from collections.abc import Sequence

from auv_control.controllers.adaptive import Params
from auv_thesis.formation.cases import (
    AMPLITUDES_MPS,
    adaptations,
    decay_rates_ps,
    leader_numbers,
    meshes,
    strings,
    told_accelerations_m,
)
from auv_thesis.items import (
    AGREES,
    AGREES_IN_PART,
    DIFFERS,
    DOES_NOT_HOLD,
    HOLDS,
    HOLDS_IN_PART,
    Claim,
    Row,
    Run,
    Table,
    Verdict,
)

TITLE = "Chapter 1: formations, their stability, switching and repair"
TOLERANCE_M, TOLERANCE = 0.005, 0.01
STRONG = 1.01
_EXPECTED_ERRORS_M = {
    "predecessor": (0.061, 0.063, 0.066, 0.068, 0.071, 0.074, 0.077),
    "l-p 0.5/0.5": (0.061, 0.032, 0.016, 0.008, 0.004, 0.002, 0.001),
    "l-p 0.8/0.2": (0.061, 0.013, 0.003),
    "l-n": (0.086, 0.024, 0.007, 0.002),
    "l-p-n": (0.079, 0.045, 0.026, 0.015, 0.008, 0.005, 0.002),
    "p-n": (0.103, 0.104, 0.107, 0.111, 0.113, 0.106, 0.066),
    "neighbour": (0.301, 0.280, 0.250, 0.210, 0.159, 0.099, 0.034),
    "leader": (0.061,),
}
_EXPECTED_GAMMA = {
    "predecessor": 1.045,
    "l-p 0.5/0.5": 0.52,
    "l-p 0.8/0.2": 0.21,
    "l-n": 0.28,
    "l-p-n": 0.57,
    "p-n": 1.03,
    "neighbour": 0.93,
}
_EXPECTED_UNIFORM_M = {"neighbour": (0.219, 0.301, 0.314), "predecessor": (0.065, 0.077, 0.092)}
_EXPECTED_GAIN = {
    "predecessor": (0.48, 0.41),
    "leader": (0.48, 0.41),
    "l-p 0.5/0.5": (0.48, 0.41),
    "neighbour": (0.25, 0.22),
}
_EXPECTED_AMPLITUDE_M = {
    "predecessor": (0.209, 0.255),
    "leader": (0.209, 0.217),
    "l-p 0.5/0.5": (0.209, 0.226),
    "neighbour": (0.209, 0.406),
}
_EXPECTED_RATE_PS = {
    ("leader", 4): 0.449,
    ("leader", 8): 0.449,
    ("predecessor", 4): 0.46,
    ("predecessor", 8): 0.46,
    ("l-p 0.5/0.5", 4): 0.47,
    ("l-p 0.5/0.5", 8): 0.47,
    ("neighbour", 4): 0.180,
    ("neighbour", 8): 0.044,
}


def _words(values: Sequence[float], digits: int = 3) -> str:
    return " ".join(f"{value:.{digits}f}" for value in values)


def _agreement(expected: Sequence[float], ours: Sequence[float], tolerance: float) -> str:
    """Return the verdict on numbers; the rounding of the expected ones counts for them."""
    near = [abs(a - b) <= tolerance + 0.5e-3 for a, b in zip(expected, ours, strict=False)]
    return AGREES if all(near) else AGREES_IN_PART if any(near) else DIFFERS


def _string_rows(runs: list[Run]) -> list[Row]:
    rows = []
    for name, expected_m in _EXPECTED_ERRORS_M.items():
        ours = strings()[name, 8]
        rows.append(
            Row(
                f"{name}: sup E_1 ... (m)",
                _words(expected_m),
                _words(ours.errors_m),
                _agreement(expected_m, ours.errors_m, TOLERANCE_M),
            )
        )
        gamma, expected = ours.gamma, _EXPECTED_GAMMA.get(name)
        if gamma is None or ours.gamma_l2 is None or expected is None:
            continue
        is_strong = gamma <= STRONG
        rows.append(
            Row(
                f"{name}: largest gamma_j, j >= 2",
                f"{expected:.3g}",
                f"{gamma:.3f} (L2: {ours.gamma_l2:.3f})",
                _agreement((expected,), (gamma,), TOLERANCE),
                "string stable"
                if is_strong
                else f"not string stable: {100.0 * (gamma - 1.0):.0f} % per vehicle",
            )
        )
    for name, expected_m in _EXPECTED_UNIFORM_M.items():
        ours_m = [max(strings()[name, count].errors_m) for count in (4, 8, 12)]
        rows.append(
            Row(
                f"{name}: A(N) for N = 4, 8, 12 (m)",
                _words(expected_m),
                _words(ours_m),
                _agreement(expected_m, ours_m, TOLERANCE_M),
                "uniform" if ours_m[2] <= 1.05 * ours_m[0] else "not uniform: grows with N",
            )
        )
    return rows


def _mesh_rows(runs: list[Run]) -> list[Row]:
    rows = []
    for weight, expected in ((0.0, (1.03, 1.045)), (0.5, (0.52, 0.52))):
        ratios = meshes()[weight]
        ours = (min(ratios), max(ratios))
        rows.append(
            Row(
                f"5 x 5, weight {weight:g} on the leader: ratios of following layers",
                f"{expected[0]:g} to {expected[1]:g}",
                f"{ours[0]:.3f} to {ours[1]:.3f}",
                _agreement(expected, ours, TOLERANCE),
                "mesh stable" if ours[1] <= STRONG else "not mesh stable",
            )
        )
    return rows


def _leader_rows(runs: list[Run]) -> list[Row]:
    rows = []
    for name, each in leader_numbers().items():
        expected = _EXPECTED_GAIN[name]
        ends = (each.gains[0], each.gains[-1])
        rows.append(
            Row(
                f"{name}: g(a), a = {AMPLITUDES_MPS[0]:g} to {AMPLITUDES_MPS[-1]:g} m/s (m per m/s)",
                f"{expected[0]:.2f} to {expected[1]:.2f}",
                f"{ends[0]:.3f} to {ends[1]:.3f}; tail {each.tail_m:.1e} m",
                _agreement(expected, ends, TOLERANCE),
                "finite and falling" if sorted(each.gains, reverse=True) == each.gains else "",
            )
        )
        rows.append(
            Row(
                f"{name}: 40 N, period 20 s, on the leader: amplitude of vehicles 1 and 6 (m)",
                _words(_EXPECTED_AMPLITUDE_M[name]),
                _words((each.first_m, each.last_m)),
                _agreement(_EXPECTED_AMPLITUDE_M[name], (each.first_m, each.last_m), TOLERANCE_M),
            )
        )
    for (name, count), (rate_ps, overshoot) in decay_rates_ps().items():
        expected_ps = _EXPECTED_RATE_PS[name, count]
        rows.append(
            Row(
                f"{name}, N = {count}: decay from 1 m offsets (1/s)",
                f"{expected_ps:.3f}",
                f"{rate_ps:.3f}; overshoot {overshoot:.2f}",
                _agreement((expected_ps,), (rate_ps,), 0.02),
                _note_on_decay(name),
            )
        )
    return rows


def _note_on_decay(name: str) -> str:
    if name == "leader":
        rate_ps = Params().error_rate_ps[0]
        return f"LAM = {rate_ps:g} 1/s is the exact rate; a fit to 80 s reaches the rounding of numbers"
    if name == "neighbour":
        return "several slow modes: the fit depends on the interval and on the offsets"
    return ""


def _adaptation_rows(runs: list[Run]) -> list[Row]:
    fixed, adaptive = adaptations()[False], adaptations()[True]
    lag_m, tail_m = fixed.final_m[-1], sum(fixed.final_m)
    told_m = told_accelerations_m()
    peaks_m = (min(adaptive.largest_m), max(adaptive.largest_m))
    return [
        Row(
            "parameters 0.7 of the true ones, fixed: lag per vehicle, and of the last (m)",
            "0.275 2.200",
            _words((lag_m, tail_m)),
            _agreement((0.275, 2.2), (lag_m, tail_m), TOLERANCE_M),
            "at 0.8 m/s, predecessor, 8 vehicles",
        ),
        Row(
            "the same with adaptation: lag per vehicle at the end (m)",
            "0",
            f"{max(adaptive.final_m):.4f}",
            _agreement((0.0,), (max(adaptive.final_m),), TOLERANCE_M),
        ),
        Row(
            "with adaptation: peak errors (m)",
            "0.061 to 0.096",
            f"{peaks_m[0]:.3f} to {peaks_m[1]:.3f}",
            _agreement((0.061, 0.096), peaks_m, TOLERANCE_M),
        ),
        Row(
            "accelerations communicated: peak of the first follower (m)",
            "0.007",
            f"{told_m[1]:.3f}",
            _agreement((0.007,), (told_m[1],), TOLERANCE_M),
            "exact parameters, accelerations one stage old",
        ),
    ]


def _judge_string(runs: list[Run]) -> Verdict:
    gammas = {name: strings()[name, 8].gamma for name in _EXPECTED_GAMMA}
    stable = [name for name, gamma in gammas.items() if gamma is not None and gamma <= STRONG]
    words = ", ".join(f"{name} {gamma:.3f}" for name, gamma in gammas.items())
    verdict = HOLDS_IN_PART if stable else DOES_NOT_HOLD
    return Verdict(verdict, f"largest gamma of a column of 8 after a step of the leader's speed: {words}")


def _judge_mesh(runs: list[Run]) -> Verdict:
    pure, led = max(meshes()[0.0]), max(meshes()[0.5])
    evidence = (
        f"largest ratio of layers: {pure:.3f} with look-ahead alone, {led:.3f} with half the weight on the "
        "leader"
    )
    return Verdict(HOLDS if pure <= STRONG else HOLDS_IN_PART if led <= STRONG else DOES_NOT_HOLD, evidence)


def _judge_leader(runs: list[Run]) -> Verdict:
    numbers = leader_numbers()
    bounded = all(max(each.gains) < 1.0 and each.tail_m < 1e-3 for each in numbers.values())
    words = ", ".join(f"{name} {max(each.gains):.2f}" for name, each in numbers.items())
    return Verdict(
        HOLDS if bounded else DOES_NOT_HOLD, f"largest g(a) in m per m/s: {words}; all errors decay"
    )


TABLES = (
    Table("1.A", "String stability of a column of 8", (), _string_rows, "expected"),
    Table("1.B", "Mesh stability", (), _mesh_rows, "expected"),
    Table("1.C", "Leader-to-formation stability of a column of 6", (), _leader_rows, "expected"),
    Table("1.D", "Adaptation and communicated accelerations in a column", (), _adaptation_rows, "expected"),
)

CLAIMS = (
    Claim(
        "1.11.1",
        "A formation of vehicles that steer by others is string stable (1.22)-(1.23): the answer depends on "
        "the reference type.",
        (),
        _judge_string,
    ),
    Claim(
        "1.11.2",
        "Systems that obey the look-ahead condition attenuate errors from layer to layer (1.25).",
        (),
        _judge_mesh,
    ),
    Claim(
        "1.11.3",
        "A bounded motion of the leader gives a bounded error of the formation, with a finite gain.",
        (),
        _judge_leader,
    ),
)
