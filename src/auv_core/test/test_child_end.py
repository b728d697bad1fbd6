"""The log and the end of a child process."""

from auv_core.machine.child_end import last_lines


def test_last_lines_of_a_log(tmp_path):
    log = tmp_path / "log"
    log.write_bytes(b"\n".join(b"line %d" % i for i in range(5000)) + b"\n\n\xff\n")
    assert last_lines(log, 3) == ["line 4998", "line 4999", "�"]
    assert last_lines(tmp_path / "none") == []
