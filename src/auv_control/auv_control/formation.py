"""
Formation by distances: a vehicle moves its own path point because of its neighbours.

Thesis Eq. (3.2) wants neighbours to keep one distance, |p_1 - p_2| = |p_2 - p_3| = d, and Section 1.3 lets a
vehicle know positions only. The law of chapter 3 uses neither: every vehicle follows its own path. Here the
path point p_d of a vehicle at p becomes

    p_t = p_d + w mean_j (1 - d / r_j) (p_j - p),      r_j = |p_j - p| <= reach

so that springs of rest length d act between neighbours. The shift is at most `shift_limit_m`. The path
anchors the formation and gives it its direction. With w = 0 the formation is that of chapter 3.

Under a law that brings a vehicle to its point at the rate lambda, small errors e_i along the line of a
formation obey e_i' = -lambda (e_i + w mean_j (e_i - e_j)). The matrix of this system is diagonally dominant
for every w >= 0, so that errors decay.
"""

from __future__ import annotations

from dataclasses import dataclass

from auv_control.body_regressor import Vec4
from auv_control.controllers import MotionView
from auv_control.path_motion import Motion, motion_of
from auv_control.references import PathPoint
from auv_control.start_blend import wrapped
from auv_core.geometry import Vec3, added, clipped, distance, heading_from_quaternion, limited
from auv_core.integrate import State
from auv_core.messages import Vec6
from auv_core.params import param

_NO_DIRECTION_M = 1e-9


@dataclass(frozen=True)
class FormationParams:
    """
    What every formation law has: springs, the model of its hull, start blend and force limit.

    Four-vectors are in the order surge, sway, heave, yaw. The defaults are the formation of thesis Section
    3.5 and the vehicle of Table 3.1.
    """

    frame: str = param("axes of nu and forces", default="body", choices=("body",))
    coupling_weight: float = param(
        "weight w of the neighbours; 0: every vehicle follows its own path", default=0.5, minimum=0.0
    )
    spacing_m: float = param("distance d of neighbours (m)", default=10.0, above=0.0)
    reach_m: float = param(
        "largest distance at which a vehicle counts as a neighbour (m)", default=15.0, above=0.0
    )
    shift_limit_m: float = param(
        "largest shift of the path point by the neighbours (m)", default=1.0, above=0.0
    )
    inertia: Vec4 = param(
        "masses (kg) and moment of inertia (kg m^2) of the model",
        default=(99.0, 108.5, 126.5, 29.1),
        above=0.0,
    )
    linear_damping: Vec4 = param(
        "d_L of the model (N s/m, N m s/rad)", default=(10.0, 0.0, 10.0, 1.603), minimum=0.0
    )
    quadratic_damping: Vec4 = param(
        "d_Q of the model (N s^2/m^2, N m s^2/rad^2)",
        default=(227.18, 405.42, 227.18, 12.937),
        minimum=0.0,
    )
    blend_s: float = param(
        "time in which the reference moves from the start to the path (s)", default=40.0, minimum=0.0
    )
    max_force_n: float | None = param("force limit per axis (N); null: none", default=None, above=0.0)

    @property
    def model(self) -> tuple[float, ...]:
        """The twelve constants of the hull, as `body_regressor` orders them."""
        return (*self.inertia, *self.linear_damping, *self.quadratic_damping)


def blend_start(view: MotionView, params: FormationParams) -> State:
    """Return the time (s) and the offset (m, rad; NED) where the blend starts, () without a blend."""
    if params.blend_s == 0.0:
        return ()
    path = path_of(view)
    x, y, z = view.nav.position
    px, py, pz = path.position
    turn_rad = wrapped(heading_from_quaternion(view.nav.attitude) - path.heading_rad)
    return view.t_s, x - px, y - py, z - pz, turn_rad


def motion_about_target(view: MotionView, params: FormationParams, start: State) -> Motion:
    """Return the vehicle's motion about its path point with springs; `start` is that of `blend_start`."""
    path = path_of(view)
    point = path._replace(position=added(path.position, spring_shift(view, params)))
    return motion_of(view, point, is_flat=False, start=start, blend_s=params.blend_s)


def spring_shift(view: MotionView, params: FormationParams) -> Vec3:
    """Return the shift of the path point by the neighbours within reach (m; NED)."""
    own, total, count = view.nav.position, (0.0, 0.0, 0.0), 0
    for other in view.neighbours:
        range_m = distance(own, other)
        if not _NO_DIRECTION_M < range_m <= params.reach_m:
            continue
        pull = 1.0 - params.spacing_m / range_m
        total = added(
            total, (pull * (other[0] - own[0]), pull * (other[1] - own[1]), pull * (other[2] - own[2]))
        )
        count += 1
    share = params.coupling_weight / max(count, 1)
    return limited((share * total[0], share * total[1], share * total[2]), params.shift_limit_m)


def path_of(view: MotionView) -> PathPoint:
    """Return the path point of a view; a formation law needs one."""
    if view.path is None:
        raise ValueError(
            "formation: a view without a path is not allowed; allowed: a view of a vehicle with a reference"
        )
    return view.path


def limited_wrench(forces: Vec4, max_force_n: float | None) -> tuple[Vec6, bool]:
    """Return the wrench of surge, sway, heave and yaw (N, N m; body), and whether a limit cut its forces."""
    x, y, z, n = forces
    if max_force_n is None:
        return (x, y, z, 0.0, 0.0, n), False
    fx, fy, fz = (clipped(force, max_force_n) for force in (x, y, z))
    return (fx, fy, fz, 0.0, 0.0, n), (fx, fy, fz) != (x, y, z)
