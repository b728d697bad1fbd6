"""When messages of a bag are due."""

import pytest

from auv_bringup.tools.playback import Pace


def test_a_silence_that_no_run_has_is_left_out(capsys):
    pace = Pace(0, rate=10.0)
    began_s = pace.due_s(0)
    pace.leave_out_gap(2_000_000_000)
    assert pace.due_s(2_000_000_000) == pytest.approx(began_s + 0.2)
    pace.leave_out_gap(1_790_000_000_000_000_000)
    assert pace.due_s(1_790_000_000_000_000_000) == pytest.approx(began_s + 0.2)
    pace.leave_out_gap(1_790_000_001_000_000_000)
    assert pace.due_s(1_790_000_001_000_000_000) == pytest.approx(began_s + 0.3)
    assert capsys.readouterr().err.count("the bag has no messages for 1789999998.0 s") == 1
