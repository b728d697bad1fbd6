"""A wait for messages is reported every few seconds, and is limited."""

from auv_bringup.tools.silence import SAY_S, Silence


def test_a_silence_is_said_every_few_seconds_until_it_is_too_long():
    now_s = [100.0]
    silence = Silence(12.0, lambda: now_s[0])
    said_s = []
    while not silence.is_too_long:
        now_s[0] += 0.5
        if silence.is_to_be_said():
            said_s.append(silence.lasts_s)
    assert said_s == [SAY_S, 2.0 * SAY_S, 12.0]


def test_a_message_ends_a_silence():
    now_s = [100.0]
    silence = Silence(12.0, lambda: now_s[0])
    for _ in range(10):
        now_s[0] += 4.0
        assert not silence.is_to_be_said()
        silence.end()
