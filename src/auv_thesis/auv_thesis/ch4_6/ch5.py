"""
Chapter 5: flocking with mathematical potentials, thesis Figs 5.5-5.12, without and with modems.

Runs without communication limits are continuous in time, as the thesis integrates them.
"""

from __future__ import annotations

from matplotlib.figure import Figure as Canvas

from auv_thesis.ch4_6.ch5_claims import CLAIMS
from auv_thesis.ch4_6.ch5_tables import TABLES
from auv_thesis.ch4_6.flock_drawing import Limits, distance_panels, draw_distances, draw_tracks, legend_of
from auv_thesis.ch4_6.flock_runs import FOUR_LEADERS, OBSTACLES, ON_A_MODEM, ON_A_MODEM_OBSTACLES, ONE_LEADER
from auv_thesis.items import Figure, Run

__all__ = ["CLAIMS", "FIGURES", "TABLES"]

_WHOLE_S: Limits = (0.0, 700.0)
_WIDE: Limits = (-20.0, 20.0)
_SPACE = (_WIDE, _WIDE, (0.0, 12.0))
_ROUND: Limits = (-15.0, 15.0)


def _draw_5_5(canvas: Canvas, runs: list[Run]) -> None:
    draw_tracks(canvas, runs[0], _SPACE, (_ROUND, _ROUND))


def _draw_5_6(canvas: Canvas, runs: list[Run]) -> None:
    whole, close, start, first = distance_panels(canvas, 4)
    canvas.set_size_inches(10.0, 3.6)
    draw_distances(whole, runs[0], _WHOLE_S, (0.0, 20.0))
    draw_distances(close, runs[0], _WHOLE_S, (1.55, 1.64))
    draw_distances(start, runs[0], (0.0, 3.0), (1.2, 1.7))
    draw_distances(first, runs[0], (0.0, 100.0), (1.55, 1.64), pairs=(0,))
    legend_of(canvas, whole)


def _draw_5_8(canvas: Canvas, runs: list[Run]) -> None:
    close, start = distance_panels(canvas, 2)
    draw_distances(close, runs[0], _WHOLE_S, (1.58, 1.62))
    draw_distances(start, runs[0], (0.0, 3.0), (1.0, 3.0))
    legend_of(canvas, close)


def _draw_5_9(canvas: Canvas, runs: list[Run]) -> None:
    draw_tracks(canvas, runs[0], _SPACE, ((-15.0, 20.0), _ROUND))


def _draw_5_10(canvas: Canvas, runs: list[Run]) -> None:
    (axes,) = distance_panels(canvas, 1)
    draw_distances(axes, runs[0], _WHOLE_S, (0.0, 25.0))
    legend_of(canvas, axes)


def _draw_5_11(canvas: Canvas, runs: list[Run]) -> None:
    draw_tracks(canvas, runs[0], ((-10.0, 20.0), (-10.0, 20.0), (0.0, 12.0)), ((-10.0, 20.0), (-10.0, 15.0)))


def _draw_5_12(canvas: Canvas, runs: list[Run]) -> None:
    draw_tracks(canvas, runs[0], (_WIDE, (-10.0, 20.0), (0.0, 12.0)), ((-15.0, 20.0), (-10.0, 15.0)))


_STARTS = "The thesis prints no starts; ours are (-8, 4, 2), (8, 2, 1), (-4, -8, 0) and (6, 12, 4) m."
_CHANNEL = (
    "The thesis does not print the rate, delay or loss of its channel. In ours each vehicle sends 2.5 "
    "reports per second, 30 % are lost, and sound takes time to travel. One extended Kalman filter "
    "estimates each neighbour. Followers are attracted to the path, as printed. "
)

FIGURES = (
    Figure(
        "5.5",
        "Four leaders flock round the circle, (a) in space, (b) in the plane",
        (FOUR_LEADERS,),
        _draw_5_5,
        f"In both, four vehicles gather from their starts and go round together. {_STARTS}",
    ),
    Figure(
        "5.6",
        "Distances among four leaders, (a) whole run, (b) enlarged with its first 3 s, (c) one pair",
        (FOUR_LEADERS,),
        _draw_5_6,
        "The thesis's distances vary between 1.575 and 1.616 m about 1.595 m; ours settle at 1.595 m. The "
        "thesis's inset begins near the final state; our flock starts metres away and enters the window "
        "later.",
    ),
    Figure(
        "5.7",
        "One leader and three followers, (a) in space, (b) in the plane",
        (ONE_LEADER,),
        _draw_5_5,
        "As Fig. 5.5. The followers stay with the leader, since the printed law gives them the path as well.",
    ),
    Figure(
        "5.8",
        "Distances among one leader and three followers, (a) enlarged, (b) the first 3 s",
        (ONE_LEADER,),
        _draw_5_8,
        "The thesis's distances vary between 1.584 and 1.611 m, ours in a band of nearly that width. Ours "
        "oscillate once per round because only the leader receives the path's velocity.",
    ),
    Figure(
        "5.9",
        "One leader, three followers, two obstacles, (a) in space, (b) in the plane",
        (OBSTACLES,),
        _draw_5_9,
        "Both flocks avoid two obstacles beside the circle; ours are at (8, 5, 10) and (-9, -5, 10) m.",
    ),
    Figure(
        "5.10",
        "Distances while the flock passes obstacles",
        (OBSTACLES,),
        _draw_5_10,
        "Both have two short disturbances, at the obstacles, after the approach.",
    ),
    Figure(
        "5.11",
        "One obstacle and an acoustic channel, (a) in space, (b) in the plane",
        (ON_A_MODEM,),
        _draw_5_11,
        f"{_CHANNEL}Both flocks pass the obstacle.",
    ),
    Figure(
        "5.12",
        "Two obstacles and an acoustic channel, (a) in space, (b) in the plane",
        (ON_A_MODEM_OBSTACLES,),
        _draw_5_12,
        f"{_CHANNEL}Both flocks pass both obstacles. At the rates of real modems the same law causes "
        "collisions: Table 5.B.",
    ),
)
