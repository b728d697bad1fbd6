"""Kill or stop any process of a run at a random moment: the run names it and leaves nothing behind."""

from collections import Counter
from pathlib import Path

import pytest
from victims import Trial, hit

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.alone]

TRIALS = 34
"""In each of the six cases: 204 in all."""


@pytest.mark.timeout(3600)
@pytest.mark.parametrize("mode", ["lockstep", "realtime"])
@pytest.mark.parametrize("layout", ["node", "vehicle", "single"])
def test_a_hit_run_is_named_and_leaves_nothing(
    mode: str, layout: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    trials = [hit(tmp_path / str(seed), Trial(mode, layout, seed)) for seed in range(TRIALS)]
    counts = Counter(f"{trial.signal_name} {trial.victim}" for trial in trials)
    named_s = [trial.named_after_s for trial in trials if trial.named_after_s is not None]
    failed = [str(trial) for trial in trials if trial.faults]
    with capsys.disabled():
        print(
            f"\n{mode} {layout}: {len(trials)} hits, {len(failed)} with a fault; named after at most "
            f"{max(named_s, default=0.0):.1f} s; "
            + ", ".join(f"{n} x {name}" for name, n in sorted(counts.items()))
        )
    assert not failed, "\n".join(failed)
