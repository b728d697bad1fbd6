"""
Traffic of a run stays on this machine: the addresses of its sockets, and discovery from another network.
"""

import os
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

pytest.importorskip("rclpy")

from ros_desk import desk, domain_id

from auv_bringup.launching.node_start import node_environment

pytestmark = pytest.mark.ros

PATIENCE_S = 30.0
HERE, THERE = "192.168.77.1", "192.168.77.2"
TALK = """
import sys, time, rclpy
from std_msgs.msg import Int64
rclpy.init(args=[])
node = rclpy.create_node(sys.argv[1])
publisher = node.create_publisher(Int64, sys.argv[1], 10)
print("up", flush=True)
sys.stdin.read()
"""
LOOK = """
import sys, time, rclpy
from std_msgs.msg import Int64
rclpy.init(args=[])
node = rclpy.create_node("looker")
deadline_s = time.monotonic() + float(sys.argv[1])
while time.monotonic() < deadline_s and not node.count_publishers("/open"):
    time.sleep(0.05)
print(node.count_publishers("/open"), node.count_publishers("/closed"))
"""


def addresses_of_sockets():
    """Return the local addresses of the UDP sockets of this process."""
    inodes = set()
    for descriptor in Path("/proc/self/fd").iterdir():
        with suppress(OSError):
            inodes.add(str(descriptor.readlink()).removeprefix("socket:[").rstrip("]"))
    rows = [line.split() for line in Path("/proc/self/net/udp").read_text().splitlines()[1:]]
    return {bytes.fromhex(row[1].split(":")[0])[::-1] for row in rows if row[9] in inodes}


def test_every_socket_of_a_node_is_bound_to_the_loopback_interface():
    before = addresses_of_sockets()
    with desk():
        assert addresses_of_sockets() - before == {bytes([127, 0, 0, 1])}


@contextmanager
def networks():
    """Yield two network namespaces that reach each other; skip if that is not allowed."""
    names = [f"shoal{os.getpid()}{side}" for side in "ab"]
    try:
        for command in (
            *(f"netns add {name}" for name in names),
            f"link add {names[0]} netns {names[0]} type veth peer name {names[1]} netns {names[1]}",
            *(
                f"-n {name} address add {at}/24 dev {name}"
                for name, at in zip(names, (HERE, THERE), strict=True)
            ),
            *(f"-n {name} link set {device} up" for name in names for device in ("lo", name)),
        ):
            try:
                subprocess.run(["ip", *command.split()], check=True, capture_output=True)
            except (OSError, subprocess.CalledProcessError) as error:
                pytest.skip(f"no network namespaces here: {error}")
        # Fast DDS takes two machines without an address for one and the same.
        deadline_s = time.monotonic() + PATIENCE_S
        while not all(is_up(name) for name in names):
            assert time.monotonic() < deadline_s, "the networks do not come up"
            time.sleep(0.02)
        yield names
    finally:
        for name in names:
            with suppress(OSError):
                subprocess.run(["ip", "netns", "delete", name], check=False, capture_output=True)


def is_up(name):
    """Return whether the link into a network carries something."""
    asked = ["ip", "-n", name, "-br", "link", "show", "dev", name]
    return "UP" in subprocess.run(asked, check=True, capture_output=True, text=True).stdout.split()


OWN_MACHINE = """
set -e
mount -t tmpfs tmpfs /dev/shm
if [ -e /etc/machine-id ]; then
  printf '%s' "$0" | md5sum | cut -c 1-32 > /dev/shm/machine-id
  mount --bind /dev/shm/machine-id /etc/machine-id
fi
exec "$@"
"""
"""Make a network another machine: it has its own shared memory and, where machines have one, its own id."""


def inside(network, code, argument, environ):
    """Start Python code in a network, as on a machine of its own."""
    shell = ["unshare", "--mount", "sh", "-c", OWN_MACHINE, network]
    return subprocess.Popen(
        ["ip", "netns", "exec", network, *shell, sys.executable, "-c", code, argument],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=environ,
    )


def test_a_process_on_another_network_that_names_this_machine_finds_no_run():
    closed = node_environment(os.environ, domain_id=domain_id(), discovery="localhost")
    plain = {name: value for name, value in closed.items() if "FASTRTPS" not in name}
    with networks() as (here, there):
        nodes = [
            inside(here, TALK, "closed", closed),
            inside(here, TALK, "open", {**plain, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}),
        ]
        try:
            for node in nodes:
                assert node.stdout.readline() == "up\n"
            stranger = {**plain, "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "ROS_STATIC_PEERS": HERE}
            began_s = time.monotonic()
            look = inside(there, LOOK, f"{PATIENCE_S:g}", stranger)
            nodes.append(look)
            found, _ = look.communicate(timeout=2.0 * PATIENCE_S)
        finally:
            for node in nodes:
                node.kill()
                node.communicate()
    assert found.split() == ["1", "0"], f"after {time.monotonic() - began_s:.1f} s"
