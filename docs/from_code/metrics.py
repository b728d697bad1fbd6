"""Every metric of a run."""

from __future__ import annotations

import re

from auv_experiment.metrics import Meaning
from auv_experiment.metrics.descriptions import FAMILIES, MEANINGS, OF_LAWS
from from_code.markdown import code, table

_GROUP = re.compile(r"\(\?P<(\w+)>[^()]*\)")


def metrics() -> str:
    """Return all metrics."""
    usual = {key: meaning for key, meaning in MEANINGS.items() if key not in OF_LAWS}
    families = {_shown(pattern): meaning for pattern, meaning in FAMILIES.items()}
    return "\n".join(
        [
            _table(usual),
            "## Of some laws only\n",
            _table(OF_LAWS),
            "## With a name or a number of the scenario in the key\n",
            _table(families),
        ]
    )


def _shown(pattern: str) -> str:
    """Return the pattern of a family as a key: what varies is in capitals, what may be absent in brackets."""
    named = _GROUP.sub(lambda group: group[1].upper(), pattern)
    return re.sub(r"\((\w+)\)\?", r"[\1]", named).replace("FLOCK?", "[flock_]")


def _table(meanings: dict[str, Meaning]) -> str:
    rows = [(code(key), meaning.unit or "–", _words(meaning)) for key, meaning in meanings.items()]
    return table(("metric", "unit", "meaning"), rows)


def _words(meaning: Meaning) -> str:
    return re.sub(r"{(\w+)}", lambda name: name[1].upper(), meaning.words)
