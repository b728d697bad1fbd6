"""
Metrics: numbers that describe a run, all from its recording.

`MEANINGS` of `auv_experiment.metrics.descriptions` describes each of them.

A file ``metrics/<name>.py`` in a folder of ``SHOAL_PLUGINS`` adds metrics of your own: to metrics.json, to
the report, and to the table of a sweep. It is an `OwnMetrics`: it describes each metric and computes them
all. `auv_experiment.metrics.own` describes what happens if it fails. docs/how_to/own_metrics.md
has an example.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from auv_experiment.recording import Recording
    from auv_experiment.scenario.schema import Scenario


@dataclass(frozen=True)
class Meaning:
    """
    Unit and meaning of a metric.

    Attributes
    ----------
    unit : str
        Its unit, '' for none.
    words : str
        Its meaning, so that a reader needs no other text.
    digits : int
        How many digits after the point are shown.
    is_share : bool
        Whether it lies between 0 and 1 in every run, so that the interval of its mean does, too.

    """

    unit: str
    words: str
    digits: int = 3
    is_share: bool = False


class OwnMetrics(Protocol):
    """
    The contract of a file of own metrics.

    Attributes
    ----------
    MEANINGS : mapping of str to Meaning
        The metrics by key. A key is a word of lower-case letters, digits and underscores, with its unit at
        the end: ``depth_rms_m``. No key of Shoal's own metrics is allowed.

    """

    @property
    def MEANINGS(self) -> Mapping[str, Meaning]: ...  # noqa: D102, N802  a name in the file

    def compute(self, recording: Recording, scenario: Scenario) -> Mapping[str, Any]:
        """
        Return the metrics of a run.

        Parameters
        ----------
        recording : Recording
            The recording of the run, as NumPy arrays that cannot be changed.
        scenario : Scenario
            The resolved scenario.

        Returns
        -------
        metrics : mapping
            Values by keys of `MEANINGS`: numbers, truth values, texts, or lists of these. A key that is left
            out, None and a number that is not finite mean that this run has no such value.

        """
        ...
