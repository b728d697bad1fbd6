"""The launch file, with small stand-ins for `launch` and `launch_ros`, which no package index has."""

import gc
import importlib.util
import json
import os
import sys
from contextlib import ExitStack
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest
import yaml

from auv_bringup.launching.domains import DomainError, claim_domain

LAUNCH_FILE = Path(__file__).parents[1] / "launch" / "flock.launch.py"

DOMAINS = f"test-domain-{os.getpid()}"


class Recorded:
    """Remembers what it was made with; the stand-in for every class of launch."""

    def __init__(self, *arguments, **options):
        self.arguments = arguments
        self.options = options


def class_named(name):
    return type(name, (Recorded,), {})


class LaunchConfiguration(Recorded):
    def perform(self, context):
        return context[self.arguments[0]]


NAMES = {
    "launch": ["Action", "LaunchContext", "LaunchDescription"],
    "launch.actions": [
        "DeclareLaunchArgument",
        "EmitEvent",
        "ExecuteProcess",
        "LogInfo",
        "OpaqueFunction",
        "RegisterEventHandler",
        "SetEnvironmentVariable",
        "UnsetEnvironmentVariable",
    ],
    "launch.event_handlers": ["OnProcessExit", "OnProcessIO", "OnShutdown"],
    "launch.events": ["Shutdown"],
    "launch.events.process": ["ProcessExited", "ProcessIO", "ShutdownProcess"],
    "launch.substitutions": [],
    "launch_ros": [],
    "launch_ros.actions": ["Node"],
}


@pytest.fixture
def launch_file(monkeypatch):
    for module_name, names in NAMES.items():
        module = ModuleType(module_name)
        module.__path__ = []
        for name in names:
            setattr(module, name, class_named(name))
        monkeypatch.setitem(sys.modules, module_name, module)
    substitutions: Any = sys.modules["launch.substitutions"]
    events: Any = sys.modules["launch.events"]
    substitutions.LaunchConfiguration = LaunchConfiguration
    events.matches_action = lambda action: ("matches", action)
    spec = importlib.util.spec_from_file_location("flock_launch", LAUNCH_FILE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def kind(action):
    return type(action).__name__


def of_kind(actions, name):
    return [action for action in actions if kind(action) == name]


def arguments_of(description):
    """Return the declared arguments by name, and the one function that is run."""
    (entities,) = description.arguments
    declared = {e.arguments[0]: e.options for e in of_kind(entities, "DeclareLaunchArgument")}
    (function,) = of_kind(entities, "OpaqueFunction")
    return declared, function.options["function"]


@pytest.fixture
def claims(launch_file, monkeypatch):
    """The domains that the launch file has claimed, none of them a real one; given back after it."""
    found = []

    with ExitStack() as stack:

        def claim(environ):
            found.append(stack.enter_context(claim_domain(environ, DOMAINS)))
            return found[-1]

        monkeypatch.setattr(launch_file, "claim_domain", claim)
        monkeypatch.setenv("ROS_DOMAIN_ID", "7")
        yield found


@pytest.fixture
def cleared(launch_file, monkeypatch):
    """Counts how often shared memory of dead processes is cleared."""
    times: list[Any] = []
    monkeypatch.setattr(launch_file, "clear_shared_memory", lambda: times.append(len(times)))
    return times


@pytest.fixture
def start(launch_file, claims, cleared, tmp_path):
    """Start a flight with some arguments given; return the actions."""
    declared, function = arguments_of(launch_file.generate_launch_description())
    defaults = {name: options["default_value"] for name, options in declared.items()}
    return lambda **given: function({**defaults, "out": str(tmp_path / "results"), **given})


def test_the_arguments_have_defaults_and_descriptions(launch_file):
    declared, _ = arguments_of(launch_file.generate_launch_description())
    assert set(declared) == {"scenario", "mode", "layout", "seed", "set", "bag", "out", "discovery"}
    assert declared["scenario"]["default_value"] == "flock_acoustic"
    assert declared["mode"]["choices"] == ["lockstep", "realtime"]
    for options in declared.values():
        assert options["description"]
        assert options["default_value"] in options.get("choices", [options["default_value"]])


def test_it_starts_the_nodes_of_the_run_command(start, tmp_path):
    nodes = of_kind(start(seed="4"), "Node")
    found = {(n.options["package"], n.options["executable"], n.options["namespace"]) for n in nodes}
    vehicles = [f"/auv_{i}" for i in range(1, 5)]
    assert found == {
        *(("auv_sim", "vehicle_node", namespace) for namespace in vehicles),
        *(("auv_flocking", "agent_node", namespace) for namespace in vehicles),
        ("auv_sim", "acoustic_relay_node", "/"),
        ("auv_bag", "recorder_node", "/"),
    }
    folder = tmp_path / "results" / "flock_acoustic-4-lockstep"
    assert json.loads((folder / "provenance.json").read_text())["seed"] == 4
    assert yaml.safe_load((folder / "scenario.yaml").read_text())["seed"] == 4


def test_every_node_gets_its_parameters(start):
    for node in of_kind(start(), "Node"):
        (path,) = node.options["parameters"]
        ((name, content),) = yaml.safe_load(Path(path).read_text()).items()
        if node.options["executable"] == "acoustic_relay_node":
            assert name == "/**"  # two nodes in one process
            assert "name" not in node.options
        else:
            assert name == f"{node.options['namespace'].rstrip('/')}/{node.options['name']}"
        assert content["ros__parameters"]


@pytest.mark.parametrize(("layout", "sizes"), [("vehicle", [2, 2, 2, 2]), ("single", [10])])
def test_nodes_that_share_a_process_are_in_a_container(start, layout, sizes):
    nodes = of_kind(start(layout=layout), "Node")
    containers = [node for node in nodes if node.options["executable"] == "node_container"]
    words = [container.options["arguments"] for container in containers]
    assert [each.count("--node") for each in words] == sizes
    modules = [word for each in words for word in each[1::4]]
    assert modules.count("auv_flocking.nodes.agent_node") == 4
    for path in (word for each in words for word in each[3::4]):
        assert "ros__parameters" in Path(path).read_text()


@pytest.mark.parametrize("layout", ["node", "vehicle", "single"])
def test_every_node_has_the_time_to_leave(start, layout):
    for node in of_kind(start(layout=layout), "Node"):
        assert (node.options["sigterm_timeout"], node.options["sigkill_timeout"]) == ("30", "30")


def test_overrides_are_separated_by_semicolons(start, tmp_path):
    start(set="acoustics.outage.params.loss_prob=0.5; duration_s=20")
    (folder,) = (tmp_path / "results").iterdir()
    raw = yaml.safe_load((folder / "scenario.yaml").read_text())
    assert raw["duration_s"] == 20
    assert raw["acoustics"]["outage"]["params"]["loss_prob"] == 0.5


def test_without_a_bag_there_is_no_recorder(start):
    assert "recorder_node" not in {n.options["executable"] for n in of_kind(start(bag="false"), "Node")}


@pytest.mark.parametrize(
    "given",
    [
        {"seed": "x"},
        {"scenario": "nonesuch"},
        {"set": "a=1"},
        {"layout": "single", "set": "on_vehicle_loss=continue"},
    ],
)
def test_bad_arguments_start_nothing_and_leave_no_folder(start, tmp_path, given):
    with pytest.raises(ValueError, match="allowed"):
        start(**given)
    assert not (tmp_path / "results").exists()


def test_the_nodes_stay_on_this_machine_unless_told_otherwise(start, monkeypatch):
    monkeypatch.setenv("ROS_STATIC_PEERS", "10.0.0.1")
    for name in ("ROS_AUTOMATIC_DISCOVERY_RANGE", "FASTRTPS_DEFAULT_PROFILES_FILE"):
        monkeypatch.delenv(name, raising=False)
    actions = start()
    given = dict(action.arguments for action in of_kind(actions, "SetEnvironmentVariable"))
    assert given["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "SYSTEM_DEFAULT"
    assert given["FASTRTPS_DEFAULT_PROFILES_FILE"].endswith("fastdds_localhost.xml")
    assert ("ROS_STATIC_PEERS",) in [
        action.arguments for action in of_kind(actions, "UnsetEnvironmentVariable")
    ]
    kinds = [kind(action) for action in actions]
    last_set = max(i for i, name in enumerate(kinds) if name.endswith("EnvironmentVariable"))
    assert last_set < kinds.index("Node")
    actions = start(discovery="subnet")
    assert ("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET") in [
        action.arguments for action in of_kind(actions, "SetEnvironmentVariable")
    ]
    assert not of_kind(actions, "UnsetEnvironmentVariable")


def domain_of(actions):
    """Return the domain that the nodes get, and what the launch file says."""
    (domain,) = {
        value
        for name, value in (action.arguments for action in of_kind(actions, "SetEnvironmentVariable"))
        if name == "ROS_DOMAIN_ID"
    } or {None}  # not set: as in the environment
    return domain, [action.options["msg"] for action in of_kind(actions, "LogInfo")]


def test_the_nodes_get_the_domain_asked_for(start, monkeypatch):
    domain, said = domain_of(start())
    assert domain is None
    assert said[-1].endswith("export ROS_DOMAIN_ID=7 ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST")
    assert not any("in use" in line for line in said)
    monkeypatch.delenv("ROS_DOMAIN_ID")
    assert domain_of(start())[0] == "0"


def test_a_domain_that_another_run_holds_is_left_to_it(start):
    with claim_domain({"ROS_DOMAIN_ID": "7"}, DOMAINS):
        domain, said = domain_of(start(discovery="subnet"))
    assert domain == "8"
    assert said[-2] == "ROS domain 7 is in use by another run; this one takes domain 8"
    assert said[-1].endswith("export ROS_DOMAIN_ID=8 ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET")


def test_the_domain_stays_claimed_when_all_is_started(start, claims):
    start()
    assert [claim.domain_id for claim in claims] == [7]
    claims.clear()
    gc.collect()
    with claim_domain({"ROS_DOMAIN_ID": "7"}, DOMAINS) as other:
        assert other.domain_id == 8


@pytest.mark.parametrize("text", ["abc", "-1", "150"])
def test_a_domain_that_is_none_starts_nothing_and_leaves_no_folder(start, tmp_path, monkeypatch, text):
    monkeypatch.setenv("ROS_DOMAIN_ID", text)
    with pytest.raises(DomainError, match=r"ROS_DOMAIN_ID: .* is not allowed; allowed: ") as refusal:
        start()
    assert len(str(refusal.value).splitlines()) == 1
    assert not (tmp_path / "results").exists()


def handler(actions, name):
    """Return the options of the one event handler of a kind."""
    (found,) = [
        registered.arguments[0].options
        for registered in of_kind(actions, "RegisterEventHandler")
        if kind(registered.arguments[0]) == name
    ]
    return found


class Flight:
    """A flight whose processes end as the test says."""

    def __init__(self, actions):
        self.on_exit = handler(actions, "OnProcessExit")["on_exit"]
        self.on_shutdown = handler(actions, "OnShutdown")["on_shutdown"]
        self.nodes: dict[Any, Any] = {}
        for node in of_kind(actions, "Node"):
            self.nodes.setdefault(node.options["executable"], []).append(node)
        self.others = [*self.nodes.get("vehicle_node", []), *self.nodes.get("agent_node", [])]

    def end(self, process, returncode=0, *, is_shutdown=False):
        """Return what is done at the end of a process."""
        event = SimpleNamespace(action=process, returncode=returncode)
        return self.on_exit(event, SimpleNamespace(is_shutdown=is_shutdown))

    def end_all(self, returncode=0):
        """End the relay, the others and the recorder; return what is done then."""
        (relay,) = self.nodes["acoustic_relay_node"]
        self.end(relay, returncode)
        for node in self.others:
            done = self.end(node)
        for recorder in self.nodes.get("recorder_node", []):
            done = self.end(recorder)
        return done

    def report(self, process, returncode=0, **metrics):
        """End the report, which has written these metrics; return what is done then."""
        folder = Path(process.options["cmd"][-1])
        (folder / "metrics.json").write_text(json.dumps({"duration_s": 650.0, "collision": False, **metrics}))
        return self.end(process, returncode)

    def last_line(self):
        (action,) = self.on_shutdown(None, None)
        return action.options["msg"]


def told(actions):
    """Return the processes that are told to end."""
    events = [action.options["event"] for action in of_kind(actions, "EmitEvent")]
    return {event.options["process_matcher"][1] for event in events if kind(event) == "ShutdownProcess"}


def shuts_down(actions):
    return [kind(action.options["event"]) for action in actions] == ["Shutdown"]


def test_the_flight_ends_in_order(start, tmp_path):
    flight = Flight(start())
    (relay,), (recorder,) = flight.nodes["acoustic_relay_node"], flight.nodes["recorder_node"]
    assert told(flight.end(relay)) == set(flight.others)
    for node in flight.others[:-1]:
        assert flight.end(node) == []
    assert told(flight.end(flight.others[-1])) == {recorder}
    (report,) = flight.end(recorder)
    folder = tmp_path / "results" / "flock_acoustic-1-lockstep"
    assert report.options["cmd"] == [sys.executable, "-m", "auv_bringup.tools.run", "--report", str(folder)]
    assert shuts_down(flight.end(report))
    assert flight.last_line() == f"report: {folder / 'report.html'}"


def test_the_end_of_a_vehicle_is_left_to_the_clock(start):
    flight = Flight(start())
    for node in flight.others:
        assert flight.end(node, -9) == []
    assert told(flight.end(*flight.nodes["acoustic_relay_node"])) == set(flight.nodes["recorder_node"])


def test_the_end_of_the_process_of_all_nodes_ends_the_flight(start):
    flight = Flight(start(layout="single"))
    (report,) = flight.end(*flight.nodes["node_container"])
    assert shuts_down(flight.end(report))


def test_a_flight_without_a_bag_has_no_report(start):
    flight = Flight(start(bag="false"))
    assert shuts_down(flight.end_all())
    assert "no report" in flight.last_line()


def test_a_lost_flight_ends_with_an_exception_after_its_report(start, launch_file, tmp_path):
    flight = Flight(start())
    (report,) = flight.end_all(returncode=3)
    with pytest.raises(launch_file.BadEndError, match=r"acoustic_relay_node .* status 3; its log is /"):
        flight.end(report)
    assert flight.last_line().endswith("report.html")


def test_a_flight_whose_recorder_ends_first_is_lost(start, launch_file):
    flight = Flight(start())
    (relay,) = flight.nodes["acoustic_relay_node"]
    assert told(flight.end(*flight.nodes["recorder_node"])) == {relay, *flight.others}
    assert flight.end(relay, 3) == []  # each process is signalled only once
    for node in flight.others:
        done = flight.end(node)
    with pytest.raises(launch_file.BadEndError, match="recorder_node has ended with status 0"):
        flight.end(*done)


def test_a_report_that_fails_names_its_command(start, launch_file):
    flight = Flight(start())
    (report,) = flight.end_all()
    with pytest.raises(launch_file.BadEndError, match="report could not be made"):
        flight.end(report, 1)
    assert "ros2 run auv_bringup run --report /" in flight.last_line()


def test_after_ctrl_c_nothing_is_started_and_the_last_line_names_the_reports_command(start):
    flight = Flight(start())
    assert flight.on_shutdown(None, None) == []
    *first, last = [node for group in flight.nodes.values() for node in group]
    for node in first:
        assert flight.end(node, is_shutdown=True) == []
    (line,) = flight.end(last, is_shutdown=True)
    assert "ros2 run auv_bringup run --report /" in line.options["msg"]


@pytest.mark.parametrize("layout", ["node", "vehicle", "single"])
def test_what_a_process_says_is_in_the_log_that_the_run_command_gives_it(start, tmp_path, layout):
    actions = start(layout=layout)
    io = handler(actions, "OnProcessIO")
    for number, node in enumerate(of_kind(actions, "Node")):
        io["on_stdout"](SimpleNamespace(action=node, text=b"out %d\n" % number))
        io["on_stderr"](SimpleNamespace(action=node, text=b"err\n"))
    io["on_stdout"](SimpleNamespace(action="the report", text=b"not a node's\n"))
    (folder,) = (tmp_path / "results").iterdir()
    logs = {log.name: log.read_text() for log in (folder / "logs").glob("*.log")}
    assert (
        set(logs)
        == {
            "node": {f"auv_{i}.{role}_node.log" for i in range(1, 5) for role in ("vehicle", "agent")}
            | {"acoustic_relay_node.log", "recorder_node.log"},
            "vehicle": {f"auv_{i}.log" for i in range(1, 5)}
            | {"acoustic_relay_node.log", "recorder_node.log"},
            "single": {"node_container.log"},
        }[layout]
    )
    assert sorted(logs.values()) == sorted(f"out {number}\nerr\n" for number in range(len(logs)))


def ending(tmp_path):
    """Return what the provenance says of the end: status, reason, domain."""
    (folder,) = (tmp_path / "results").iterdir()
    known = json.loads((folder / "provenance.json").read_text())
    return known["exit_status"], known["stopped_because"], known["domain_id"]


def test_the_provenance_keeps_the_status_of_a_flight_that_ended_well(start, tmp_path):
    flight = Flight(start())
    (report,) = flight.end_all()
    assert ending(tmp_path) == (0, None, 7)  # before the report is made, which may show it
    assert shuts_down(flight.report(report))
    assert ending(tmp_path) == (0, None, 7)


def test_the_provenance_keeps_the_status_of_a_lost_flight(start, launch_file, tmp_path):
    flight = Flight(start())
    (report,) = flight.end_all(returncode=3)
    with pytest.raises(launch_file.BadEndError):
        flight.report(report, collision=True)
    status, reason, _ = ending(tmp_path)
    assert status == 3
    assert "acoustic_relay_node has ended with status 3" in reason


def test_the_provenance_keeps_that_a_flight_was_interrupted(start, tmp_path):
    flight = Flight(start())
    for group in flight.nodes.values():
        for node in group:
            flight.end(node, is_shutdown=True)
    assert ending(tmp_path) == (130, "interrupted", 7)


def test_ctrl_c_after_the_flight_has_ended_takes_nothing_from_it(start, tmp_path):
    flight = Flight(start())
    flight.end(*flight.nodes["acoustic_relay_node"])
    for node in [*flight.others, *flight.nodes["recorder_node"]]:
        flight.end(node, is_shutdown=True)
    assert ending(tmp_path) == (0, None, 7)


@pytest.mark.parametrize(
    ("mode", "metrics", "status", "words"),
    [
        ("lockstep", {"collision": True}, 4, "two hulls touched"),
        ("realtime", {"collision": True}, 4, "two hulls touched"),
        ("lockstep", {"duration_s": 649.0}, 3, "the bag holds 649 of 650 s: the recorder fell behind"),
    ],
)
def test_a_flight_that_its_recording_condemns_does_not_end_with_status_0(
    start, launch_file, tmp_path, mode, metrics, status, words
):
    flight = Flight(start(mode=mode))
    (report,) = flight.end_all()
    with pytest.raises(launch_file.BadEndError, match=words):
        flight.report(report, **metrics)
    assert ending(tmp_path)[0] == status
    assert flight.last_line().endswith("report.html")


def test_shared_memory_of_dead_processes_is_cleared_before_and_after_the_flight(start, cleared):
    flight = Flight(start())
    assert cleared == [0]
    flight.end_all()
    assert cleared == [0, 1]
