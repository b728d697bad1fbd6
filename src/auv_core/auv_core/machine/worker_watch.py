"""Whether a busy process still runs, judged by its processor time."""

from __future__ import annotations

import psutil

_STOPPED = {psutil.STATUS_STOPPED, psutil.STATUS_TRACING_STOP}
_LOOKS_STOPPED = 4
_LOOKS_IDLE = 120


class Watch:
    """
    Looks at a process once a second.

    It counts looks and not seconds: after Ctrl-Z and `fg` nobody is blamed for the time in between.
    """

    def __init__(self, pid: int | None) -> None:
        self._process = psutil.Process(pid)
        self._cpu_s = -1.0
        self._looks = 0

    def look(self) -> str:
        """Return what is wrong with the process, '' if nothing is."""
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
