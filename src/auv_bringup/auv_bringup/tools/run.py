"""`./scripts/run`: fly a scenario, then report the result."""

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
from auv_bringup.launching.node_start import ONE_THREAD
from auv_bringup.launching.plan import ROS_MODES, Plan, make_plan, start_results
from auv_bringup.launching.ros_environment import check_ros_environment
from auv_bringup.launching.verdict import LOST, verdict
from auv_bringup.tools.run_arguments import parse
from auv_core.cli.failures import DONE, INTERRUPTED, answered, internal_error
from auv_core.cli.one_line_parser import fail
from auv_core.params import ConfigError
from auv_experiment import results

if TYPE_CHECKING:
    from auv_bringup.launching.launcher import Flight
    from auv_experiment.recording import Recording
    from auv_experiment.scenario.schema import Scenario


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    for name, value in ONE_THREAD.items():
        os.environ.setdefault(name, value)  # before numpy is imported, since nodes are forks of this process
    place = _TracebackPlace()
    return answered(
        lambda: _run(parse(arguments), place),
        (ConfigError, DomainError, results.ResultsError),
        interrupted="interrupted",
        explained=lambda error: internal_error(error, place.folder),
    )


def _run(options: argparse.Namespace, place: _TracebackPlace) -> int:
    if options.list:
        return _list()
    _check_own_files()
    if options.report is not None:
        place.folder = options.report / results.LOGS
        return _report_again(options.report, options)
    missing = _missing_of_ros()
    plan = make_plan(
        options.scenario,
        mode=options.mode or ("inprocess" if missing else None),
        layout=options.layout,
        seed=options.seed,
        overrides=options.overrides,
        duration_s=options.duration,
        discovery=options.discovery,
    )
    with ExitStack() as stack:
        claim: DomainClaim | None = None
        if plan.mode in ROS_MODES:
            _check_ros(missing)
            claim = stack.enter_context(claim_domain(os.environ))
        folder = start_results(plan, options.out)
        place.folder = folder / results.LOGS
        try:
            if missing and options.mode is None and plan.scenario.sampling == "sampled":
                print(f"{missing} cannot be imported: this run has no nodes (--mode inprocess)")
            _introduce(plan, folder)
            if claim is None:
                return _fly_in_process(plan, folder, options)
            return _fly_with_nodes(plan, folder, options, claim)
        except KeyboardInterrupt:
            return _interrupted(folder)


def _check_own_files() -> None:
    from auv_experiment.figures.own import own_files_of_figures
    from auv_experiment.metrics.own import own_files_of_metrics

    own_files_of_metrics()
    own_files_of_figures()


def _missing_of_ros() -> str:
    """Return as text which packages of ROS nodes are missing, '' for none."""
    return " and ".join(name for name in ("rclpy", "auv_msgs") if importlib.util.find_spec(name) is None)


def _check_ros(missing: str) -> None:
    if missing:
        raise ConfigError(
            f"{missing} cannot be imported, so no ROS 2 node can run; "
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
        print(f"{folder.with_name(plan.name)} exists and is not changed")
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
            return fail(LOST, f"{error}; nothing was recorded")
        wall_s = time.monotonic() - start_s
    if not options.no_bag:
        print("recording ...", file=sys.stderr, flush=True)
        recording.save(folder / results.RECORDING_FILE)
    factor = float(recording.t_s[-1]) / wall_s
    metrics = _show_results(folder, plan.scenario, recording, plan.mode, factor, options)
    status, _ = verdict(metrics, plan.scenario, plan.mode)
    return status


def _fly_with_nodes(plan: Plan, folder: Path, options: argparse.Namespace, claim: DomainClaim) -> int:
    from auv_bringup.launching.launcher import compile_for_nodes, fly
    from auv_bringup.launching.node_start import export_line, reach_notes
    from auv_core.cli.progress import Progress
    from auv_core.machine.interrupts import Interrupts
    from auv_experiment.run_memory import memory_warning

    domain_id = claim.domain_id
    if claim.is_moved:
        print(f"ROS domain {claim.asked_id} is in use by another run; this one takes domain {domain_id}")
    print(f"to inspect it from another shell:  {export_line(domain_id, options.discovery)}", flush=True)
    for line in reach_notes(os.environ, options.discovery):
        print(line, flush=True)
    if not options.no_bag and (line := memory_warning(plan.scenario)):
        print(f"warning: {line}", file=sys.stderr, flush=True)
    compile_for_nodes(plan.scenario, lambda line: print(line, file=sys.stderr, flush=True))
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
        print(f"lost vehicles: {', '.join(flight.lost_vehicles)}")
    if flight.reason:
        fail(flight.exit_status, f"{flight.reason}{remark}; logs are in {folder / results.LOGS}")
    return status


def _interrupted(folder: Path) -> int:
    """Report what an interrupted run leaves; if no node was started and nothing recorded, leave nothing."""
    if (folder / results.BAG).exists() or (folder / results.RECORDING_FILE).exists():
        return fail(INTERRUPTED, f"interrupted; to report on the recording: ./scripts/run --report {folder}")
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
    """Repair the bag of a results folder if its writer was killed, and report that."""
    from auv_bag.mend import mend_bag
    from auv_bag.writer import BagError

    with suppress(BagError):  # it does not exist or cannot be read; its reader reports that
        for note in mend_bag(folder / results.BAG):
            print(f"note: {note}", file=sys.stderr, flush=True)


def _report_flight(plan: Plan, folder: Path, options: argparse.Namespace, flight: Flight) -> tuple[int, str]:
    """Report on the nodes' recording; return the status of the run, and why a lost run has no report."""
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
        return status, f"; {error}"  # a flight that was stopped early may have no recording yet
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
    """Write metrics, figures and report; print the metrics and the path of the report; return the metrics."""
    from auv_experiment.metrics.safety import warnings
    from auv_experiment.metrics.wording import metrics_table

    metrics = results.write_results(
        folder,
        scenario,
        recording,
        mode=mode,
        real_time_factor=real_time_factor,
        formats=() if options.no_figures else options.formats,
        on_step=lambda step: print(f"{step} ...", file=sys.stderr, flush=True),
        tell=_warn,
    )
    for warning in warnings(metrics):
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
    """The folder of the run's logs, once it exists; the traceback of an internal error goes there."""

    folder: Path | None = None


if __name__ == "__main__":
    sys.exit(main())
