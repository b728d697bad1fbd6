import os
import signal
import subprocess
import sys
import tempfile
import uuid
from pathlib import Path

import pytest

from auv_bringup.launching.domains import SAFE_DOMAIN_IDS, DomainError, asked_domain, claim_domain

HOLDER = """
import sys
from auv_bringup.launching.domains import claim_domain
claim = claim_domain({"ROS_DOMAIN_ID": "7"}, sys.argv[1])
print(claim.domain_id, flush=True)
sys.stdin.read()
"""


@pytest.fixture
def name():
    """Domains of this test alone."""
    return f"test-domain-{uuid.uuid4()}"


def start_holder(name):
    """Start a process that holds a domain; return it and the domain."""
    environ = {"PYTHONPATH": str(Path(__file__).parents[1])}
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLDER, name],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=environ,
    )
    assert holder.stdout is not None
    return holder, int(holder.stdout.readline())


def test_a_run_takes_the_domain_of_the_environment(name):
    with claim_domain({"ROS_DOMAIN_ID": "7"}, name) as claim:
        assert (claim.domain_id, claim.is_moved) == (7, False)


def test_domain_0_is_the_default(name):
    with claim_domain({}, name) as first, claim_domain({"ROS_DOMAIN_ID": ""}, name) as second:
        assert first.domain_id == 0
        assert second.domain_id == 1


def test_a_second_run_takes_the_next_free_domain_and_knows_it(name):
    environ = {"ROS_DOMAIN_ID": "100"}
    with (
        claim_domain(environ, name),
        claim_domain(environ, name) as second,
        claim_domain(environ, name) as third,
    ):
        assert (second.domain_id, second.asked_id, second.is_moved) == (101, 100, True)
        assert third.domain_id == 215  # 102 to 214 share their ports with outgoing connections


def test_a_released_domain_is_free_again(name):
    claim = claim_domain({}, name)
    claim.release()
    claim.release()
    with claim_domain({}, name) as again:
        assert again.domain_id == 0


def test_another_process_holds_its_domain_until_it_is_killed(name):
    holder, domain_id = start_holder(name)
    try:
        assert domain_id == 7
        with claim_domain({"ROS_DOMAIN_ID": "7"}, name) as claim:
            assert claim.domain_id == 8
    finally:
        holder.kill()
        holder.communicate(timeout=10)
    with claim_domain({"ROS_DOMAIN_ID": "7"}, name) as claim:
        assert claim.domain_id == 7


def test_one_error_when_every_domain_is_taken(name):
    claims = [claim_domain({}, name) for _ in SAFE_DOMAIN_IDS]
    assert len({claim.domain_id for claim in claims}) == len(SAFE_DOMAIN_IDS)
    with pytest.raises(DomainError, match="in use"):
        claim_domain({}, name)
    for claim in claims:
        claim.release()


@pytest.mark.parametrize("text", ["-1", "102", "214", "233", "1.0", "x", "0x1", "²", "99999999999999999999"])
def test_a_domain_that_cannot_be_used_is_refused_in_one_line(text):
    with pytest.raises(DomainError) as error:
        asked_domain({"ROS_DOMAIN_ID": text})
    assert text in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.skipif(os.getuid() != 0, reason="only root can be another user")
def test_runs_of_two_users_never_share_a_domain(name):
    hear, tell = os.pipe()
    child = os.fork()
    if child == 0:  # without an exec: another user may not even find the Python of this one
        os.setgid(65534)
        os.setuid(65534)
        claim = claim_domain({"ROS_DOMAIN_ID": "7"}, name)
        os.write(tell, b"%d" % claim.domain_id)
        signal.pause()
    try:
        assert os.read(hear, 10) == b"7"
        with claim_domain({"ROS_DOMAIN_ID": "7"}, name) as claim:
            assert claim.domain_id == 8
    finally:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)


def test_a_claim_depends_on_no_file(name, tmp_path, monkeypatch):
    """Another user may have put anything in the place of a file with a well-known name."""
    (tmp_path / "shoal-domains").mkdir()
    os.mkfifo(tmp_path / "shoal-domains" / "0.lock")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path / "shoal-domains" / "0.lock"))
    with claim_domain({}, name) as claim:
        assert claim.domain_id == 0
    assert [path.name for path in tmp_path.iterdir()] == ["shoal-domains"]
