"""The environment of a command that joins a run: domain, discovery range, quick discovery."""

from __future__ import annotations

import os

from auv_bag.writer import BagError
from auv_bringup.launching.domains import DomainError, asked_domain
from auv_bringup.launching.ros_environment import check_ros_environment
from auv_core.params import ConfigError


def prepare_environment(discovery: str) -> None:
    """Give this process the environment of a run's nodes: discovery range and quick discovery.

    Call it before ROS starts.

    Parameters
    ----------
    discovery
        ``localhost`` or ``subnet``.

    Raises
    ------
    BagError
        If $ROS_DOMAIN_ID has no valid domain, or another variable cannot be satisfied.
    """
    from auv_bringup.launching.node_start import node_environment

    try:
        check_ros_environment(os.environ)
        domain_id = asked_domain(os.environ)
    except (ConfigError, DomainError) as error:
        raise BagError(str(error)) from None
    environment = node_environment(os.environ, domain_id=domain_id, discovery=discovery)
    os.environ.clear()
    os.environ.update(environment)
