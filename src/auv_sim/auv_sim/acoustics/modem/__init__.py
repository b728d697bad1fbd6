"""
Modems: how long a packet is on the air, how it is heard, and how much it holds.

To add one, write one file with ``Params`` and ``Modem(params)`` with

* ``max_payload_bytes: int``, ``airtime_s(payload_bytes) -> float`` and ``preamble_s: float``, the part of the
  airtime before the first bit;
* ``max_range_m: float``, beyond which there is no signal at all (``math.inf`` for none);
* ``captures: bool``: whether a receiver that has locked on to a packet keeps it when another one comes, or
  loses both to any overlap with a signal that it could have acquired;
* ``frequency_khz: float | None``: the carrier, for the transmission loss; None for a modem that knows no
  levels, recognises whatever is in range, has no bit errors, and needs nothing of what follows;
* ``snr_ratio(loss_db) -> float``: signal to ambient noise in the band, as a ratio of powers, after that loss;
* ``acquires(snr_ratio) -> bool``: whether the start of a packet is recognised; ``snr_ratio`` is that to noise
  and interference;
* ``bit_error_prob(snr_ratio) -> float``: likewise, for one bit.
"""
