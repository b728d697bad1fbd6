"""A flock in continuous time: vehicles, velocity controllers and consensus filters as one system."""

from __future__ import annotations

from collections.abc import Sequence

from auv_control.controllers import ContinuousVelocityController, VelocityReference, make_controller
from auv_core.geometry import Vec3, heading_from_quaternion
from auv_core.integrate import State
from auv_core.messages import Vec6
from auv_core.models import HULL, ContinuousModel, make_continuous_model
from auv_experiment.recording import Recording
from auv_experiment.scenario.schema import Scenario
from auv_flocking.agent import Agent
from auv_flocking.flock_rates import KNOWS_PATH, guides
from auv_flocking.flock_task import FlockTask
from auv_sim.vehicle import check_finite


class _Point:
    """A vehicle that has the commanded velocity at once."""

    def __init__(self, start: Vec3) -> None:
        self.start: State = start

    def rate(self, state: State, reference: VelocityReference, current: Vec3) -> State:
        """Return the rate of its position (m/s; NED)."""
        return reference.velocity

    def heading_rad(self, state: State) -> float:
        """Return its heading (rad): north, which it keeps."""
        return 0.0

    def settled(self, state: State) -> State:
        """Return `state` itself."""
        return state

    def record(
        self, recording: Recording, at: tuple[int, int], state: State, reference: VelocityReference
    ) -> None:
        """Write attitude and velocity."""
        recording.attitude_quat_wxyz[at] = (1.0, 0.0, 0.0, 0.0)
        recording.velocity_body[at] = (*reference.velocity, 0.0, 0.0, 0.0)


class _Hull:
    """A vehicle with a velocity controller; the state is that of the plant and the integral."""

    def __init__(
        self,
        model: ContinuousModel,
        controller: ContinuousVelocityController,
        plant: State,
    ) -> None:
        self._model = model
        self._controller = controller
        self._plant = len(plant)
        self.start: State = (*plant, 0.0, 0.0, 0.0)

    def rate(self, state: State, reference: VelocityReference, current: Vec3) -> State:
        """Return the rates of plant and integral."""
        tau, growth = self._control(state, reference)
        given = self._model.limited_command(tau)
        return (*self._model.derivative(state[: self._plant], given, current), *growth)

    def heading_rad(self, state: State) -> float:
        """Return its heading (rad)."""
        qw, qx, qy, qz = state[3:7]
        return heading_from_quaternion((qw, qx, qy, qz))

    def settled(self, state: State) -> State:
        """Return `state` with a quaternion of length 1."""
        return (*self._model.normalised(state[: self._plant]), *state[self._plant :])

    def record(
        self, recording: Recording, at: tuple[int, int], state: State, reference: VelocityReference
    ) -> None:
        """Write attitude, velocity and wrench."""
        recording.attitude_quat_wxyz[at] = state[3:7]
        recording.velocity_body[at] = state[7:HULL]
        if at[0] < recording.n_ticks:
            recording.command[at], _ = self._control(state, reference)

    def _control(self, state: State, reference: VelocityReference) -> tuple[Vec6, Vec3]:
        qw, qx, qy, qz = state[3:7]
        (u, v, w), (p, q, r), (x, y, z) = state[7:10], state[10:HULL], state[self._plant :]
        return self._controller.evaluate((qw, qx, qy, qz), (u, v, w, p, q, r), (x, y, z), reference)


class FlockSystem:
    """
    The state is that of all vehicles, one after the other, then their estimates of the centre (m; NED). An
    estimate starts at its vehicle's position.
    """

    def __init__(self, scenario: Scenario, agents: Sequence[Agent]) -> None:
        self._tasks = [agent.task for agent in agents if isinstance(agent.task, FlockTask)]
        paths = [scenario.reference_of(index) for index in range(len(agents))]
        self._paths = [path for path in paths if path is not None]
        self._guides = guides([vehicle.id in scenario.leaders for vehicle in scenario.vehicles])
        self._current = scenario.environment.current_ned_mps
        self._vehicles = _vehicles(scenario)
        starts = [vehicle.start for vehicle in self._vehicles]
        self._size = len(starts[0])
        self.start: State = tuple(x for start in (*starts, *(start[:3] for start in starts)) for x in start)

    def derivative(self, t_s: float, state: State) -> State:
        """Return the rates of the vehicles and of the estimates."""
        vehicles, centres = self._parts(state)
        references, rates = self._rates(t_s, vehicles, centres)
        motions = [
            vehicle.rate(own, reference, self._current)
            for vehicle, own, reference in zip(self._vehicles, vehicles, references, strict=True)
        ]
        return tuple([x for vector in (*motions, *rates) for x in vector])

    def settled(self, state: State) -> State:
        """Return `state` with quaternions of length 1."""
        vehicles, centres = self._parts(state)
        settled = [vehicle.settled(own) for vehicle, own in zip(self._vehicles, vehicles, strict=True)]
        return tuple([x for vector in (*settled, *centres) for x in vector])

    def record(self, recording: Recording, tick: int, t_s: float, state: State) -> None:
        """Write vehicles, estimates and the law's velocities into row `tick`."""
        vehicles, centres = self._parts(state)
        references, rates = self._rates(t_s, vehicles, centres)
        for index, own in enumerate(vehicles):
            check_finite(own, recording.vehicle_ids[index], t_s)
            recording.position_ned_m[tick, index] = own[:3]
            self._vehicles[index].record(recording, (tick, index), own, references[index])
        if tick < recording.n_ticks:
            recording.centre_ned_m[tick] = centres
            recording.centre_velocity_ned_mps[tick] = rates
            recording.reference_velocity_ned_mps[tick] = [reference.velocity for reference in references]

    def _parts(self, state: State) -> tuple[list[State], list[Vec3]]:
        end = self._size * len(self._tasks)
        vehicles = [state[i : i + self._size] for i in range(0, end, self._size)]
        return vehicles, [(state[i], state[i + 1], state[i + 2]) for i in range(end, len(state), 3)]

    def _rates(
        self, t_s: float, vehicles: list[State], centres: list[Vec3]
    ) -> tuple[list[VelocityReference], list[Vec3]]:
        points = [(state[0], state[1], state[2]) for state in vehicles]
        known = list(zip(points, centres, strict=True))
        references, rates = [], []
        for index, task in enumerate(self._tasks):
            path, others = self._paths[index].at(t_s), [*known[:index], *known[index + 1 :]]
            velocity, rate = task.rates(path, points[index], centres[index], others)
            guide = self._guides[index]
            heading_rad = (
                path.heading_rad
                if guide == KNOWS_PATH
                else self._vehicles[guide].heading_rad(vehicles[guide])
            )
            references.append(VelocityReference(velocity, heading_rad))
            rates.append(rate)
        return references, rates


def _vehicles(scenario: Scenario) -> list[_Point | _Hull]:
    vehicles: list[_Point | _Hull] = []
    for vehicle in scenario.vehicles:
        start = vehicle.position_ned_m or (0.0, 0.0, 0.0)
        if scenario.kinematic:
            vehicles.append(_Point(start))
            continue
        controller = make_controller(scenario.agent.controller, scenario.period_s)
        if not isinstance(controller, ContinuousVelocityController):
            raise TypeError("a controller without a continuous form")
        model = make_continuous_model(vehicle.model)
        plant = model.initial_state(start, vehicle.heading_rad, vehicle.speed_mps)
        vehicles.append(_Hull(model, controller, plant))
    return vehicles
