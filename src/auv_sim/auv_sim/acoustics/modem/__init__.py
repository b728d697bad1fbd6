"""
Modems: how long a packet is on the air, how far it carries and how much it holds.

To add one, write one file with ``Params`` and ``Modem(params)`` with ``airtime_s(payload_bytes) -> float``,
``max_range_m: float`` and ``max_payload_bytes: int``.
"""
