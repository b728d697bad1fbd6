"""
Propagation: how long sound takes from one place to another.

To add one, write one file with ``Params`` (see `auv_core.params.param`) and ``Propagation(params)`` with
``delay_s(source, receiver) -> float`` (s) for two NED positions (m).
"""
