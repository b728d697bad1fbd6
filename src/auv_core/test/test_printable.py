"""Text from other programs cannot control the terminal."""

import io

from auv_core.cli.one_line_parser import fail
from auv_core.cli.printable import printable
from auv_core.cli.progress import Progress

HOSTILE = "/auv_1\x1b[2J\x9b31m\rgone\x07"
WRITTEN_OUT = r"/auv_1\x1b[2J\x9b31m\rgone\x07"


def test_control_characters_are_written_out():
    assert printable(HOSTILE) == WRITTEN_OUT
    assert printable("1.5 µm\tä\n") == "1.5 µm\tä\n"


def test_the_launcher_prints_no_control_characters(capsys):
    said = io.StringIO()
    Progress(1.0, said).message(HOSTILE)
    assert said.getvalue() == WRITTEN_OUT + "\n"
    fail(3, HOSTILE)
    assert capsys.readouterr().err == f"error: {WRITTEN_OUT}\n"
