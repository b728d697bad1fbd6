"""Claims about silent nodes in real time."""

from auv_sim.relay.silences import Silences


def test_a_node_is_silent_after_the_limit_and_not_once_its_vehicle_is_left_out():
    silences = Silences(2, 3.0)
    assert silences.silent(100.0, without=()) == []
    silences.begin(100.0)
    silences.hear("agent_node", 0, 102.0)
    silences.hear("vehicle_node", 1, 102.0)
    assert silences.silent(103.0, without=()) == []
    assert silences.silent(104.0, without=()) == [("agent_node", 1), ("vehicle_node", 0)]
    assert silences.silent(104.0, without={1}) == [("vehicle_node", 0)]
