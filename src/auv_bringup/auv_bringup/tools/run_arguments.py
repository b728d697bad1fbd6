"""The command line of `./scripts/run` and its --help."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from auv_bringup.launching.layout import LAYOUTS
from auv_bringup.launching.plan import DEFAULT_SCENARIO, MODES
from auv_core.cli.one_line_parser import OneLineParser
from auv_experiment.figures.formats import add_format_option

_HELP = """\
Fly a flock of autonomous underwater vehicles, and report the result in numbers and
figures.

SCENARIO is a name from --list or the path of a YAML file; the default is flock_acoustic:
four vehicles that exchange information only through an acoustic channel that delays and
loses packets.
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

three layouts of the nodes in lockstep and realtime, with the same names, topics and
numbers; only the processes differ:
  node        a process per node: as on real vehicles, and the slowest
  vehicle     a process per vehicle, with its simulator and its agent; one more for
              relay and clock, one for the recorder
  single      one process for all nodes: the fastest, for many vehicles; a node
              that fails ends the run, so not with on_vehicle_loss: continue; up to
              128 vehicles, and above 31 their nodes have no services of parameters

results:
  DIR/<scenario>-<seed>-<mode>, with -<hash of the overrides> when --set or --duration
  is given, and with -2, -3, ... if that exists: nothing is ever overwritten. It has:
  scenario.yaml (resolved), provenance.json, bag/ (or recording.npz), logs/,
  metrics.json, figures/ and report.html; --report makes the last three again from the
  recording.

ROS 2:
  The run uses $ROS_DOMAIN_ID (0 if unset), or the next domain that no other run uses,
  and prints it. Traffic stays on this machine; --discovery subnet opens it to the
  network, and only then are ROS_STATIC_PEERS and ROS_DISCOVERY_SERVER used. Inspect the
  run from another shell with `ros2 topic list`, `ros2 topic echo /auv_1/odom`, ... or,
  without the ros2 command, with `./scripts/topic list`.

Ctrl-C once ends every node cleanly and closes the bag; twice hurries it. The flight up to
then is in the bag: --report shows it.

exit status:
  0    done (also if the scenario lets a flight go on without a lost vehicle)
  1    internal error; the traceback is in the logs
  2    bad input; nothing was started, nothing was written
  3    a vehicle or node was lost, and the flight was stopped; or the results cannot be
       written (full disk, folder moved)
  4    two hulls touched; the flight was completed
  130  Ctrl-C
  Contact of hulls is detected in the recording. With --no-bag a run with nodes has no
  recording, so contact is not detected and the status is not 4. provenance.json keeps the
  status of a run with nodes.

examples:
  ./scripts/run                                  the main job: 650 s, four vehicles
  ./scripts/run --list                           list all scenarios
  ./scripts/run --seed 7 --set acoustics.outage.params.loss_prob=0.5
  ./scripts/run --set 'environment.current_ned_mps=[0.2, 0, 0]' --duration 60
  ./scripts/run ch5_one_leader                   a table of the thesis, in one process
  ./scripts/run my_scenario.yaml --mode inprocess --out /tmp/results
  ./scripts/run --report results/flock_acoustic-1-lockstep --format pdf,svg
"""


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
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
        help="how to fly it (default: lockstep; inprocess without ROS 2 and for a "
        "scenario with sampling: continuous)",
    )
    parser.add_argument(
        "--layout",
        choices=LAYOUTS,
        help="how nodes are grouped into processes, in lockstep and realtime (default: node)",
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
        help="override a key of the scenario, with its dotted path; the value is YAML; repeatable",
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
        help="store no recording; a run with nodes then has no metrics or figures, which need it",
    )
    add_format_option(parser)
    parser.add_argument("--no-figures", action="store_true", help="make metrics and a report without figures")
    parser.add_argument(
        "--discovery",
        choices=("localhost", "subnet"),
        default="localhost",
        help="which machines can see the nodes: this one (default), or its network",
    )
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--list", action="store_true", help="list the scenarios, one line each, and stop")
    group.add_argument(
        "--report", metavar="DIR", type=Path, help="make metrics, figures and report of a finished run again"
    )
    return parser.parse_args(arguments)
