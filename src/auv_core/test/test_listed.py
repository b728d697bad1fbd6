"""Claim: many names become a line that people read."""

from auv_core.words import listed


def test_the_first_names_of_many_are_named_and_the_rest_counted():
    names = [f"auv_{k}" for k in range(1, 13)]
    assert listed([]) == ""
    assert listed(names[:10]).endswith("auv_9, auv_10")
    assert listed(names) == f"{', '.join(names[:10])} and 2 more"
