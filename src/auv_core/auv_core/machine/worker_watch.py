"""Check whether a busy process still runs, by its processor time."""

from __future__ import annotations

import psutil

_STOPPED = {psutil.STATUS_STOPPED, psutil.STATUS_TRACING_STOP}
_LOOKS_STOPPED = 4
_LOOKS_IDLE = 120


class Watch:
    """
    Checks a process once a second.

    It counts checks and not seconds, so that the pause between Ctrl-Z and `fg` does not count.
    """

    def __init__(self, pid: int | None) -> None:
        self._process = psutil.Process(pid)
        self._cpu_s = -1.0
        self._looks = 0

    def look(self) -> str:
        """Return the fault of the process, '' if there is none."""
        try:
            times = self._process.cpu_times()
            is_stopped = self._process.status() in _STOPPED
        except psutil.NoSuchProcess:
            return ""
        cpu_s = times.user + times.system
        self._looks = self._looks + 1 if cpu_s == self._cpu_s else 0
        self._cpu_s = cpu_s
        if is_stopped and self._looks >= _LOOKS_STOPPED:
            return f"has been stopped for {self._looks} s"
        if self._looks >= _LOOKS_IDLE:
            return f"has taken no processor time for {self._looks} s"
        return ""
