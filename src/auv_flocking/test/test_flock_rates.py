"""Three ways to one step of the thesis's flock: by agents, in continuous time, all vehicles at once."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_control.controllers import velocity_direct
from auv_control.references import PathPoint
from auv_core.messages import VehicleState
from auv_core.pairs import near_pairs
from auv_flocking.consensus import thesis
from auv_flocking.flock_rates import KNOWS_PATH, Instant, NearPairs, Paths, Scene, flock_law, flock_rates
from auv_flocking.flock_task import FlockTask
from auv_flocking.flocking import Member, potential
from auv_flocking.neighbours.estimates import NeighbourEstimate
from auv_flocking.separation import fuzzy, mathematical

MODERATE = settings(max_examples=60, deadline=None)
PERIOD_S = 0.1
LEVEL, STILL = (1.0, 0.0, 0.0, 0.0), (0.0,) * 6
POINTS = st.tuples(*[st.floats(-8.0, 8.0)] * 3)
MEMBERS = st.lists(st.tuples(POINTS, POINTS, st.booleans()), min_size=1, max_size=6)
LAWS = st.builds(
    potential.Params,
    spacing_m=st.floats(0.5, 6.0),
    bandwidth_ratio=st.floats(0.1, 1.0),
    followers=st.sampled_from(["printed", "blind"]),
    correction_limit_mps=st.floats(0.1, 1e9),
)
REACHES = st.one_of(st.none(), st.floats(1.0, 10.0))
SEPARATIONS = [mathematical.Separation(mathematical.Params()), fuzzy.Separation(fuzzy.Params())]


class _Flock:
    """A flock at one instant, and what each way makes of it: velocities and rates of the centres."""

    def __init__(self, members, law_params, reach_m, separation, path):
        self.points, self.centres, leads = zip(*members, strict=True)
        self.path = PathPoint(path, (0.1, -0.05, 0.02))
        self.obstacles = (((1.0, 2.0, 3.0), 4.0),)
        self._params, self._separation = law_params, separation
        self._filter = thesis.Params(rate_ps=0.7, reach_m=reach_m)
        self._laws = [potential.Flocking(law_params, separation, Member(is_leader)) for is_leader in leads]

    def _task(self, index):
        consensus = thesis.Consensus(self._filter, len(self.points))
        consensus.centre(self.centres[index], ())  # the first estimate is the first position
        controller = velocity_direct.Controller(velocity_direct.Params(), PERIOD_S)
        return FlockTask(self._laws[index], consensus, controller, self.obstacles, PERIOD_S, is_leader=True)

    def _others(self, index):
        return [other for other in range(len(self.points)) if other != index]

    def by_agents(self):
        for index, own in enumerate(self.points):
            task = self._task(index)
            estimates = [
                NeighbourEstimate(
                    other + 1,
                    self.points[other],
                    (0.0,) * 3,
                    np.eye(6),
                    0.0,
                    self.centres[other],
                    (0.0,) * 3,
                    shared=(0.0,) * 3,
                )
                for other in self._others(index)
            ]
            nav = VehicleState(0, own, LEVEL, STILL)
            task.step(0.0, nav, self.path, estimates, is_waiting=False)
            yield task.reference.velocity, task.centre_rate

    def in_continuous_time(self):
        for index, own in enumerate(self.points):
            others = [(self.points[other], self.centres[other]) for other in self._others(index)]
            yield self._task(index).rates(self.path, own, self.centres[index], others)

    def all_at_once(self, *, listed):
        count, points = len(self.points), np.array(self.points)
        consensus = thesis.Consensus(self._filter, count)
        law = flock_law(self._laws, self._params, self._separation, consensus, self.obstacles)
        row = (*self.path.position, *self.path.velocity, 1.0, 0.0)
        scene = Scene(
            points,
            np.array(self.centres),
            Paths(np.array([[row]]), np.zeros(count, np.int64), np.full(count, KNOWS_PATH)),
        )
        near = NearPairs(listed, *near_pairs(points, max(law.numbers.push_m, law.numbers.talk_m, 1.0)))
        velocities, rates = np.zeros((count, 3)), np.zeros((4, count, 3))
        laws = law.numbers, law.strength, law.obstacle_strength
        flock_rates(scene, near, Instant(0, 0), *laws, velocities, rates)
        return zip(map(tuple, velocities.tolist()), map(tuple, rates[0].tolist()), strict=True)


@pytest.mark.parametrize("separation", SEPARATIONS, ids=["mathematical", "fuzzy"])
@MODERATE
@given(members=MEMBERS, law_params=LAWS, reach_m=REACHES, path=POINTS)
def test_a_step_is_the_same_to_the_last_bit_in_all_three(separation, members, law_params, reach_m, path):
    flock = _Flock(members, law_params, reach_m, separation, path)
    agents = list(flock.by_agents())
    assert list(flock.in_continuous_time()) == agents
    assert list(flock.all_at_once(listed=False)) == agents


@MODERATE
@given(members=MEMBERS, law_params=LAWS, reach_m=st.floats(1.0, 10.0), path=POINTS)
def test_a_list_of_near_pairs_leaves_no_pair_out(members, law_params, reach_m, path):
    flock = _Flock(members, law_params, reach_m, SEPARATIONS[0], path)
    assert list(flock.all_at_once(listed=True)) == list(flock.all_at_once(listed=False))
