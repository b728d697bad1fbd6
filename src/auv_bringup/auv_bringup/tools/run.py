"""`./scripts/run`: fly a scenario, then say what came of it."""

from __future__ import annotations

import argparse
import importlib.util
import math
import os
import shutil
import sys
import time
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from auv_bringup.launching.domains import DomainClaim, DomainError, claim_domain
from auv_bringup.launching.layout import LAYOUTS
from auv_bringup.launching.node_start import ONE_THREAD
from auv_bringup.launching.plan import DEFAULT_SCENARIO, MODES, ROS_MODES, Plan, make_plan, start_results
from auv_bringup.launching.ros_environment import check_ros_environment
from auv_bringup.launching.verdict import LOST, verdict
from auv_core.cli.failures import DONE, INTERRUPTED, answered, internal_error
from auv_core.cli.one_line_parser import OneLineParser, fail
from auv_core.params import ConfigError
from auv_experiment import results
from auv_ros.leaving import leave_if_kept

if TYPE_CHECKING:
    from auv_bringup.launching.launcher import Flight
    from auv_experiment.recording import Recording
    from auv_experiment.scenario.schema import Scenario

_HELP = """\
Fly a flock of autonomous underwater vehicles, and say in numbers and figures what came
of it.

SCENARIO is a name of --list or the path of a YAML file; without one, flock_acoustic is
flown: four vehicles that share what they know only through an acoustic channel that
delays and loses packets.
"""

_EPILOG = """\
three ways to fly the same scenario:
  lockstep    every vehicle is two ROS 2 nodes, and time advances when all have
              answered: one seed, one result, to the last bit
  realtime    the same nodes run freely on the wall clock, as on vehicles: every run is
              a little different
  inprocess   the same objects in one process, without ROS: the numbers of lockstep,
              much faster
  A scenario with `sampling: continuous` is flown `inprocess` unless --mode says
  otherwise; in lockstep or realtime its laws are held over the control period
  (sampling: sampled).

three layouts of the nodes of lockstep and realtime, with the same names, topics and
numbers; only the processes differ:
  node        a process per node: what you would see on vehicles, and the slowest
  vehicle     a process per vehicle, with its simulator and its agent; one more for
              relay and clock, one for the recorder
  single      one process for all nodes: the fastest, and for many vehicles; a node
              that fails ends the run, so not with on_vehicle_loss: continue; up to
              128 vehicles, and above 31 their nodes have no services of parameters

results:
  DIR/<scenario>-<seed>-<mode>, with -<hash of the overrides> when --set or --duration
  is given, and with -2, -3, ... when that exists: nothing is ever overwritten. In it:
  scenario.yaml (resolved), provenance.json, bag/ (or recording.npz), logs/,
  metrics.json, figures/ and report.html; --report makes the last three again from what
  was recorded.

ROS 2:
  The run uses $ROS_DOMAIN_ID (0 if unset), or the next domain that no other run holds,
  and says which. Traffic stays on this machine; --discovery subnet lets it out, and
  only then are ROS_STATIC_PEERS and ROS_DISCOVERY_SERVER heeded. Look in from another
  shell with `ros2 topic list`, `ros2 topic echo /auv_1/odom`, ... or, where there is no
  ros2 command, `./scripts/topic list`.

Ctrl-C once ends every node in order and closes the bag; twice hurries it. What was flown
until then is in the bag: --report shows it.

exit status:
  0    done (also where the scenario lets a flight go on without a lost vehicle)
  1    internal error; the traceback is in the logs
  2    bad input; nothing was started, nothing was written
  3    a vehicle or node was lost, and the flight was stopped; or the results cannot be
       written (full disk, folder moved)
  4    two hulls touched; the flight was completed
  130  Ctrl-C
  A touch of hulls is found in the recording. With --no-bag a run with nodes has none:
  the touch is not noticed, and the status is not 4. provenance.json keeps the status of
  a run with nodes.

examples:
  ./scripts/run                                  the main job: 650 s, four vehicles
  ./scripts/run --list                           what else there is
  ./scripts/run --seed 7 --set acoustics.outage.params.loss_prob=0.5
  ./scripts/run --set 'environment.current_ned_mps=[0.2, 0, 0]' --duration 60
  ./scripts/run ch5_one_leader                   a table of the thesis, in one process
  ./scripts/run my_scenario.yaml --mode inprocess --out /tmp/results
  ./scripts/run --report results/flock_acoustic-1-lockstep
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    for name, value in ONE_THREAD.items():
        os.environ.setdefault(name, value)  # before numpy is imported; nodes are forks of this process
    place = _TracebackPlace()
    status = answered(
        lambda: _run(_parser().parse_args(arguments), place),
        (ConfigError, DomainError, results.ResultsError),
        interrupted="interrupted",
        explained=lambda error: internal_error(error, place.folder),
    )
    return leave_if_kept(status)


def _parser() -> argparse.ArgumentParser:
    parser = OneLineParser(
        prog="./scripts/run",
        description=_HELP,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "scenario",
        nargs="?",
        default=DEFAULT_SCENARIO,
        metavar="SCENARIO",
        help=f"name or YAML file (default: {DEFAULT_SCENARIO})",
    )
    parser.add_argument(
        "--mode",
        choices=MODES,
        help="how to fly it (default: lockstep; inprocess for a scenario with sampling: continuous)",
    )
    parser.add_argument(
        "--layout",
        choices=LAYOUTS,
        help="which nodes share a process, in lockstep and realtime (default: node)",
    )
    parser.add_argument(
        "--seed", type=int, metavar="N", help="seed of every random number (default: the scenario's)"
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="PATH=VALUE",
        dest="overrides",
        help="override a key of the scenario, with its dotted path; the value is YAML; may be repeated",
    )
    parser.add_argument(
        "--duration", type=float, metavar="S", help="length of the flight (s), instead of duration_s"
    )
    parser.add_argument(
        "--out", default="results", metavar="DIR", type=Path, help="folder of the results (default: results)"
    )
    parser.add_argument(
        "--no-bag",
        action="store_true",
        help="store no recording; a run with nodes then has no metrics or figures: they are made from it",
    )
    parser.add_argument("--no-figures", action="store_true", help="metrics and a report of them, no figures")
    parser.add_argument(
        "--discovery",
        choices=("localhost", "subnet"),
        default="localhost",
        help="who may see the nodes: this machine only (default), or the network it is in",
    )
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--list", action="store_true", help="list the scenarios, one line each, and stop")
    group.add_argument(
        "--report", metavar="DIR", type=Path, help="make metrics, figures and report of a finished run again"
    )
    return parser


def _run(options: argparse.Namespace, place: _TracebackPlace) -> int:
    if options.list:
        return _list()
    if options.report is not None:
        place.folder = options.report / results.LOGS
        return _report_again(options.report, options)
    plan = make_plan(
        options.scenario,
        mode=options.mode,
        layout=options.layout,
        seed=options.seed,
        overrides=options.overrides,
        duration_s=options.duration,
        discovery=options.discovery,
    )
    with ExitStack() as stack:
        claim: DomainClaim | None = None
        if plan.mode in ROS_MODES:
            _check_ros()
            claim = stack.enter_context(claim_domain(os.environ))
        folder = start_results(plan, options.out)
        place.folder = folder / results.LOGS
        try:
            _introduce(plan, folder)
            if claim is None:
                return _fly_in_process(plan, folder, options)
            return _fly_with_nodes(plan, folder, options, claim)
        except KeyboardInterrupt:
            return _interrupted(folder)


def _check_ros() -> None:
    missing = [name for name in ("rclpy", "auv_msgs") if importlib.util.find_spec(name) is None]
    if missing:
        raise ConfigError(
            f"{' and '.join(missing)} cannot be imported, so no ROS 2 node can run; "
            "start this through ./scripts/run, "
            "source the workspace (install/setup.bash), or use --mode inprocess"
        )
    check_ros_environment(os.environ)


def _introduce(plan: Plan, folder: Path) -> None:
    scenario = plan.scenario
    count = len(scenario.vehicles)
    print(f"{scenario.name}: {scenario.title}")
    print(
        f"{count} vehicle{'s' if count > 1 else ''}, {scenario.duration_s:g} s, "
        f"seed {scenario.seed}, {plan.mode}"
    )
    if plan.is_switched:
        print(f"nodes sample, so the laws are held over {scenario.period_s:g} s (sampling: sampled)")
    if folder.name != plan.name:
        print(f"{folder.with_name(plan.name)} exists and is left alone")
    print(f"results go to {folder}", flush=True)


def _fly_in_process(plan: Plan, folder: Path, options: argparse.Namespace) -> int:
    from auv_core.cli.progress import Progress
    from auv_core.compiled import use_compiler
    from auv_experiment.inprocess.sampled import run_in_process
    from auv_sim.vehicle import DivergedError

    use_compiler(tell=lambda line: print(line, flush=True))
    with Progress(plan.scenario.duration_s) as progress:
        start_s = time.monotonic()
        try:
            recording = run_in_process(plan.scenario, on_progress=progress.update)
        except DivergedError as error:
            return fail(LOST, f"{error}; nothing is recorded")
        wall_s = time.monotonic() - start_s
    if not options.no_bag:
        recording.save(folder / results.RECORDING_FILE)
    factor = float(recording.t_s[-1]) / wall_s
    metrics = _show_results(folder, plan.scenario, recording, plan.mode, factor, options)
    status, _ = verdict(metrics, plan.scenario, plan.mode)
    return status


def _fly_with_nodes(plan: Plan, folder: Path, options: argparse.Namespace, claim: DomainClaim) -> int:
    from auv_bringup.launching.launcher import fly
    from auv_bringup.launching.node_start import export_line, reach_notes
    from auv_core.cli.progress import Progress
    from auv_core.machine.processes import Interrupts
    from auv_experiment.run_memory import memory_warning

    domain_id = claim.domain_id
    if claim.is_moved:
        print(f"ROS domain {claim.asked_id} is in use by another run; this one takes domain {domain_id}")
    print(f"to look in from another shell:  {export_line(domain_id, options.discovery)}", flush=True)
    for line in reach_notes(os.environ, options.discovery):
        print(line, flush=True)
    if not options.no_bag and (line := memory_warning(plan.scenario)):
        print(f"warning: {line}", file=sys.stderr, flush=True)
    with Interrupts() as interrupts, Progress(plan.scenario.duration_s) as progress:
        flight = fly(
            plan.scenario,
            mode=plan.mode,
            layout=plan.layout,
            results_dir=folder,
            with_bag=not options.no_bag,
            domain_id=domain_id,
            discovery=options.discovery,
            interrupts=interrupts,
            progress=progress,
        )
    claim.release()
    _mend(folder)
    _remember_flight(folder, flight, domain_id)
    if flight.exit_status == INTERRUPTED:
        print(f"flown for {flight.simulated_s:.1f} s of {plan.scenario.duration_s:g} s")
        return _interrupted(folder)
    status, remark = _report_flight(plan, folder, options, flight)
    if status != flight.exit_status:
        results.write_ending(folder, exit_status=status)
    if flight.lost_vehicles:
        print(f"lost on the way: {', '.join(flight.lost_vehicles)}")
    if flight.reason:
        fail(flight.exit_status, f"{flight.reason}{remark}; logs are in {folder / results.LOGS}")
    return status


def _interrupted(folder: Path) -> int:
    """Say what an interrupted run leaves; where no node was started and nothing recorded, nothing at all."""
    if (folder / results.BAG).exists() or (folder / results.RECORDING_FILE).exists():
        return fail(INTERRUPTED, f"interrupted; what was recorded: ./scripts/run --report {folder}")
    if any((folder / results.LOGS).iterdir()):
        return fail(INTERRUPTED, f"interrupted; logs are in {folder / results.LOGS}")
    shutil.rmtree(folder)  # made by this run, and empty
    return fail(INTERRUPTED, "interrupted before anything was recorded")


def _remember_flight(folder: Path, flight: Flight, domain_id: int) -> None:
    results.write_ending(
        folder,
        domain_id=domain_id,
        exit_status=flight.exit_status,
        stopped_because=flight.reason or None,
        lost_vehicles=list(flight.lost_vehicles),
        strangers=list(flight.strangers),
        simulated_s=flight.simulated_s,
        real_time_factor=flight.real_time_factor,
        start_up_s=flight.start_up_s,
    )


def _mend(folder: Path) -> None:
    """Give the bag of a results folder the end that its writer could not give it, and say so."""
    from auv_bag.mend import mend_bag
    from auv_bag.writer import BagError

    with suppress(BagError):  # there is none, or it cannot be read: what reads it says so
        for note in mend_bag(folder / results.BAG):
            print(f"note: {note}", file=sys.stderr, flush=True)


def _report_flight(plan: Plan, folder: Path, options: argparse.Namespace, flight: Flight) -> tuple[int, str]:
    """Report on what the nodes recorded; return the status of the run, and why a lost one has no report."""
    status = flight.exit_status
    if options.no_bag:
        print("nothing was recorded (--no-bag), so there are no metrics and no figures")
        return status, ""
    print("reading the bag ...", file=sys.stderr, flush=True)
    try:
        recording = results.load_recording(folder, plan.scenario, _warn)
    except results.ResultsError as error:
        if status == DONE:
            raise RuntimeError(str(error)) from None
        return status, f"; {error}"  # a flight that was stopped early may have recorded nothing yet
    metrics = _show_results(folder, plan.scenario, recording, plan.mode, flight.real_time_factor, options)
    if status != DONE:
        return status, ""
    status, why = verdict(metrics, plan.scenario, plan.mode)
    return (fail(LOST, why) if status == LOST else status), ""


def _warn(line: str) -> None:
    print(f"warning: {line}", file=sys.stderr, flush=True)


def _report_again(folder: Path, options: argparse.Namespace) -> int:
    """Make metrics, figures and report of a results folder again."""
    from auv_experiment.scenario.loading import load_scenario

    if not (folder / results.SCENARIO_FILE).is_file():
        raise results.ResultsError(
            f"--report {str(folder)!r}: no {results.SCENARIO_FILE} in it; allowed: a folder of results"
        )
    scenario = load_scenario(str(folder / results.SCENARIO_FILE))
    known = {
        **results.read_json(folder / results.PROVENANCE_FILE),
        **results.read_json(folder / results.METRICS_FILE),
    }
    factor = known.get("real_time_factor")
    factor = float(factor) if isinstance(factor, int | float) else math.nan
    if not (folder / results.RECORDING_FILE).is_file():
        _mend(folder)
    recording = results.load_recording(folder, scenario, _warn)
    _show_results(folder, scenario, recording, str(known.get("mode", "lockstep")), factor, options)
    return DONE


def _show_results(
    folder: Path,
    scenario: Scenario,
    recording: Recording,
    mode: str,
    real_time_factor: float,
    options: argparse.Namespace,
) -> dict[str, Any]:
    """Write metrics, figures and report; print the metrics and where the report is; return the metrics."""
    from auv_experiment.metrics.surface import surface_warning
    from auv_experiment.metrics.table import metrics_table

    metrics = results.write_results(
        folder,
        scenario,
        recording,
        mode=mode,
        real_time_factor=real_time_factor,
        with_figures=not options.no_figures,
        on_step=lambda step: print(f"{step} ...", file=sys.stderr, flush=True),
    )
    warning = surface_warning(metrics)
    if warning:
        print(f"warning: {warning}", file=sys.stderr, flush=True)
    print(f"\n{metrics_table(metrics)}\n\nreport: {folder / results.REPORT_FILE}", flush=True)
    return metrics


def _list() -> int:
    from auv_experiment.scenario.loading import list_scenarios

    scenarios = list_scenarios()
    width = max(len(name) for name, _ in scenarios)
    for name, title in scenarios:
        print(f"{name:<{width}}  {title}")
    return DONE


@dataclass
class _TracebackPlace:
    """The run's logs, once there are any: where an internal error's traceback goes."""

    folder: Path | None = None


if __name__ == "__main__":
    sys.exit(main())
