"""
Propagation: how long sound takes from one place to another, and what is left of it.

To add one, write one file with ``Params`` (see `auv_core.params.param`) and ``Propagation(params)`` with
``delay_s(source, receiver) -> float`` (s) and ``loss_db(source, receiver, frequency_khz) -> float``, the
transmission loss (dB), for two NED positions (m).  The loss is asked for only by modems that know levels.
A file that calls what is no requirement of the project has ``is_installed() -> bool``, and its
``Propagation`` raises ValueError, ``propagation.kind: ...``, where that is missing.
"""
