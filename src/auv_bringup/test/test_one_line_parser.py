"""Claims about replay and topic with arguments that are not allowed: one line, and exit status 2."""

import pytest

from auv_bringup.tools import replay, topic

REFUSED = [
    (replay, ["x", "--rate", "abc"], "--rate: 'abc' is not allowed; allowed: a number from 0.001 to 1e+06"),
    (replay, ["x", "--rate", "0"], "--rate: '0' is not allowed; allowed: a number from 0.001 to 1e+06"),
    (replay, ["x", "--clock", "inf"], "--clock: 'inf' is not allowed; allowed: a number from 0.01 to 10000"),
    (replay, ["x", "--start", "-1"], "--start: '-1' is not allowed; allowed: a number from 0 to 1e+09"),
    (replay, ["x", "--delay", "a\nb"], "--delay: 'a\\nb' is not allowed; allowed: a number from 0 to 3600"),
    (replay, [], "the following arguments are required: BAG"),
    (replay, ["x", "y\nz"], "unrecognized arguments: y z"),
    (
        topic,
        ["hz", "/t", "--window", "x"],
        "--window: 'x' is not allowed; allowed: a whole number of at least 1",
    ),
    (
        topic,
        ["hz", "/t", "--window", "0"],
        "--window: '0' is not allowed; allowed: a whole number of at least 1",
    ),
    (topic, ["echo", "/t", "-n", "1.5"], "-n/--count: '1.5' is not allowed; allowed: a whole number"),
    (topic, ["--wait", "x", "list"], "--wait: 'x' is not allowed; allowed: a number of seconds above 0"),
    (topic, ["--wait", "nan", "list"], "--wait: 'nan' is not allowed; allowed: a number of seconds above 0"),
    (topic, ["fly"], "invalid choice: 'fly'"),
]


@pytest.mark.parametrize(("command", "arguments", "said"), REFUSED, ids=[said for _, _, said in REFUSED])
def test_arguments_are_refused_in_one_line(command, arguments, said, capsys):
    with pytest.raises(SystemExit) as end:
        command.main(arguments)
    assert end.value.code == 2
    output = capsys.readouterr()
    assert output.out == ""
    (line,) = output.err.splitlines()
    assert line.startswith("error: ")
    assert said in line
    assert line.endswith(" --help says more)")
    assert "usage" not in line
    assert "_positive" not in line


def test_the_help_named_is_that_of_the_subcommand(capsys):
    with pytest.raises(SystemExit):
        topic.main(["hz", "/t", "--window", "x"])
    assert "(./scripts/topic hz --help says more)" in capsys.readouterr().err
