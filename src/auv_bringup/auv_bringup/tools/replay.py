"""Command `./scripts/replay`: publish a recorded bag again, or run its neighbour filters again."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from auv_bag.bag import Bag
from auv_bag.mend import mend_bag
from auv_bag.writer import BagError
from auv_bringup.launching.domains import DomainError, claim_domain
from auv_bringup.launching.node_start import export_line
from auv_bringup.tools.environment import prepare_environment
from auv_bringup.tools.playback import play, tell
from auv_bringup.tools.replay_arguments import parse
from auv_core.cli.failures import answered
from auv_core.params import ConfigError

if TYPE_CHECKING:
    from auv_experiment.re_estimate import Comparison

EXIT_DONE, EXIT_DIFFERENT, EXIT_INTERNAL = 0, 1, 3


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return its exit status."""
    return answered(
        lambda: _do(parse(argv)),
        (BagError, ConfigError),
        interrupted="interrupted",
        outlives_its_reader=False,
        failed=EXIT_INTERNAL,
    )


def _do(options: argparse.Namespace) -> int:
    for note in mend_bag(options.bag):
        tell(f"note: {note}")
    bag = Bag(options.bag)
    return _re_estimate(bag) if options.re_estimate else _replay(bag, options)


def _re_estimate(bag: Bag) -> int:
    """Run the filters again and report the differences."""
    from auv_core.compiled import use_compiler
    from auv_experiment.compose import agent_configs
    from auv_experiment.re_estimate import re_estimate
    from auv_experiment.scenario.loading import load_scenario
    from auv_flocking.senses import senses_of

    scenario_file = bag.folder.parent / "scenario.yaml"
    if not scenario_file.is_file():
        raise BagError(f"{scenario_file} is missing; --re-estimate reads the filter settings from it")
    scenario = load_scenario(str(scenario_file))
    configs = agent_configs(scenario)
    use_compiler(print)
    result = re_estimate(
        bag,
        [config.vehicle_id for config in configs],
        [senses_of(config) for config in configs],
        scenario.period_s,
    )
    _report_comparison(result, len(configs))
    return EXIT_DONE if result.agrees else EXIT_DIFFERENT


def _report_comparison(result: Comparison, n_vehicles: int) -> None:
    """Print what the comparison found."""
    print(f"{result.estimates} estimates of {n_vehicles} vehicles in {result.ticks} vehicle ticks compared")
    print(f"  position     max difference {result.position_m:.3g} m")
    print(f"  velocity     max difference {result.velocity_mps:.3g} m/s")
    print(f"  covariance   max difference {result.covariance:.3g}")
    if result.unmatched:
        print(f"  {result.unmatched} estimates exist on one side only")
    if result.unused_ticks:
        print(f"  {result.unused_ticks} vehicle ticks left out: the bag lacks packets before them")
    print(
        "the recorded packets give the recorded estimates"
        if result.agrees
        else "they DIFFER by more than 1e-9"
    )


def _replay(bag: Bag, options: argparse.Namespace) -> int:
    """Publish the bag in its own domain, as a run does."""
    try:
        claim = claim_domain(os.environ)
    except DomainError as error:
        raise BagError(str(error)) from None
    with claim:
        if claim.is_moved:
            tell(
                f"ROS domain {claim.asked_id} is in use by another run; this replay takes domain "
                f"{claim.domain_id}; to inspect it:  {export_line(claim.domain_id, options.discovery)}"
            )
        os.environ["ROS_DOMAIN_ID"] = str(claim.domain_id)
        prepare_environment(options.discovery)
        play(bag, options)
    return EXIT_DONE


if __name__ == "__main__":
    sys.exit(main())
