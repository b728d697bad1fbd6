"""Claims about the line along which the speed changes in steps."""

import math

import pytest

from auv_control.references.line_of_speeds import Params, Reference
from auv_core.params import ConfigError, load

PATH = Reference(
    Params((1.0, 2.0, 3.0), 0.5 * math.pi, speeds_mps=(0.0, 0.3, 0.5), from_s=(0.0, 40.0, 100.0))
)


@pytest.mark.parametrize(
    ("t_s", "way_m", "speed_mps"),
    [
        (0.0, 0.0, 0.0),
        (39.9, 0.0, 0.0),
        (40.0, 0.0, 0.3),
        (50.0, 3.0, 0.3),
        (100.0, 18.0, 0.5),
        (110.0, 23.0, 0.5),
    ],
)
def test_each_speed_counts_from_its_time(t_s, way_m, speed_mps):
    point = PATH.at(t_s)
    assert point.position == pytest.approx((1.0, 2.0 + way_m, 3.0))
    assert point.velocity == pytest.approx((0.0, speed_mps, 0.0))
    assert PATH.reach(110.0).holds(point.position)


@pytest.mark.parametrize("times", [[1.0, 2.0], [0.0, 0.0], [0.0]])
def test_times_that_do_not_fit_the_speeds_are_refused(times):
    with pytest.raises(ConfigError, match=r"^reference\.from_s: .* is not allowed; allowed: ascending times"):
        load(Params, {"speeds_mps": [0.0, 0.3], "from_s": times}, "reference")
