"""What ./scripts/replay refuses before it starts."""

import tempfile

import pytest

from auv_bringup.tools import replay


@pytest.mark.parametrize(
    "arguments",
    [
        ("--rate", "1e-12"),
        ("--rate", "1e300"),
        ("--rate", "0"),
        ("--rate", "nan"),
        ("--start", "1e300"),
        ("--start", "-1"),
        ("--start", "inf"),
        ("--delay", "1e10"),
        ("--clock", "1e-9"),
        ("--clock", "1e9"),
        ("--clock", "x"),
    ],
)
def test_an_absurd_number_is_one_line_and_status_2(tmp_path, capsys, keep_signal_handlers, arguments):
    with pytest.raises(SystemExit) as end:
        replay.main([str(tmp_path), *arguments])
    assert end.value.code == 2
    errors = capsys.readouterr().err
    assert errors.count("\n") == 1
    assert f"argument {arguments[0]}" in errors
    assert "allowed: a number from " in errors


def test_an_internal_error_has_another_status_than_a_difference(
    tmp_path, capsys, monkeypatch, keep_signal_handlers
):
    def broken(_):
        raise ZeroDivisionError

    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(replay, "mend_bag", broken)
    assert replay.main([str(tmp_path)]) == replay.EXIT_INTERNAL != replay.EXIT_DIFFERENT
    assert "ZeroDivisionError" in capsys.readouterr().err
