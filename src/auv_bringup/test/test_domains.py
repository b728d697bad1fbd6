import subprocess
import sys
from pathlib import Path

import pytest

from auv_bringup.domains import SAFE_DOMAIN_IDS, DomainError, asked_domain, claim_domain

HOLDER = """
import sys
from pathlib import Path
from auv_bringup.domains import claim_domain
print(claim_domain({"ROS_DOMAIN_ID": "7"}, Path(sys.argv[1])).domain_id, flush=True)
sys.stdin.read()
"""


def start_holder(lock_dir):
    """Start a process that holds a domain; return it and the domain."""
    environ = {"PYTHONPATH": str(Path(__file__).parents[1])}
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(lock_dir)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=environ,
    )
    return holder, int(holder.stdout.readline())


def test_a_run_takes_the_domain_of_the_environment(tmp_path):
    with claim_domain({"ROS_DOMAIN_ID": "7"}, tmp_path) as claim:
        assert (claim.domain_id, claim.is_moved) == (7, False)


def test_domain_0_is_the_default(tmp_path):
    with claim_domain({}, tmp_path) as first, claim_domain({"ROS_DOMAIN_ID": ""}, tmp_path) as second:
        assert first.domain_id == 0
        assert second.domain_id == 1


def test_a_second_run_takes_the_next_free_domain_and_knows_it(tmp_path):
    environ = {"ROS_DOMAIN_ID": "100"}
    with (
        claim_domain(environ, tmp_path),
        claim_domain(environ, tmp_path) as second,
        claim_domain(environ, tmp_path) as third,
    ):
        assert (second.domain_id, second.asked_id, second.is_moved) == (101, 100, True)
        assert third.domain_id == 215  # 102 to 214 share their ports with outgoing connections


def test_a_released_domain_is_free_again(tmp_path):
    claim = claim_domain({}, tmp_path)
    claim.release()
    claim.release()
    with claim_domain({}, tmp_path) as again:
        assert again.domain_id == 0


def test_another_process_holds_its_domain_until_it_is_killed(tmp_path):
    holder, domain_id = start_holder(tmp_path)
    try:
        assert domain_id == 7
        with claim_domain({"ROS_DOMAIN_ID": "7"}, tmp_path) as claim:
            assert claim.domain_id == 8
    finally:
        holder.kill()
        holder.communicate(timeout=10)
    with claim_domain({"ROS_DOMAIN_ID": "7"}, tmp_path) as claim:
        assert claim.domain_id == 7


def test_one_error_when_every_domain_is_taken(tmp_path):
    claims = [claim_domain({}, tmp_path) for _ in SAFE_DOMAIN_IDS]
    assert len({claim.domain_id for claim in claims}) == len(SAFE_DOMAIN_IDS)
    with pytest.raises(DomainError, match="in use"):
        claim_domain({}, tmp_path)
    for claim in claims:
        claim.release()


@pytest.mark.parametrize("text", ["-1", "102", "214", "233", "1.0", "x", "0x1", "²", "99999999999999999999"])
def test_a_domain_that_cannot_be_used_is_refused_in_one_line(text):
    with pytest.raises(DomainError) as error:
        asked_domain({"ROS_DOMAIN_ID": text})
    assert text in str(error.value)
    assert "\n" not in str(error.value)


def test_a_lock_folder_that_cannot_be_made_is_said(tmp_path):
    blocker = tmp_path / "file"
    blocker.write_text("")
    with pytest.raises(DomainError, match="cannot be made"):
        claim_domain({}, blocker / "locks")
