"""Common part of all schemes with slots."""


def check_slot(slot_s: float, airtime_s: float) -> None:
    """Raise ValueError if a transmission is longer than the slot."""
    if airtime_s >= slot_s:
        raise ValueError(
            f"slot_s: {slot_s!r} is not allowed; allowed: longer than a report's airtime of {airtime_s:.3f} s"
        )
