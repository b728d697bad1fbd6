"""Claims about the lines of a problem: one when it begins, one when it is over."""

from auv_core.alarm import Alarm


class Logger:
    """Keeps what is logged."""

    def __init__(self):
        self.lines = []

    def error(self, line, **_):
        self.lines.append(f"ERROR {line}")

    def info(self, line, **_):
        self.lines.append(f"INFO {line}")


def test_a_trouble_is_one_line_and_its_end_another():
    logger = Logger()
    alarm = Alarm(logger, "holds", "acts again")
    told = [
        alarm.note(kind, words, t_s)
        for t_s, (kind, words) in enumerate(
            [(0, ""), (1, "stale: 0.6 s"), (1, "stale: 1.6 s"), (2, "silent"), (0, ""), (0, "")]
        )
    ]
    assert told == [False, True, False, True, True, False]
    assert logger.lines == [
        "ERROR holds: stale: 0.6 s",
        "ERROR holds: silent",
        "INFO acts again after 3.0 s; it was: silent",
    ]
