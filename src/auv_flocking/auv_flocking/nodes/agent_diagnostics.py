"""Diagnostics of an agent's node on `/diagnostics`."""

from __future__ import annotations

import math

from diagnostic_msgs.msg import DiagnosticStatus

from auv_core.words import listed
from auv_flocking.agent import Agent
from auv_flocking.agent_config import AgentConfig
from auv_flocking.mail import Mail
from auv_flocking.neighbours.estimates import AGE
from auv_flocking.packet_judge import refusal_words, vehicle_name
from auv_ros.wire.diagnostics import Status

_OLD_S = 10.0


def agent_statuses(agent: Agent, config: AgentConfig, mail: Mail, malformed: int, t_s: float) -> list[Status]:
    """Return the status of neighbours, inputs and control law of an agent at the scenario time `t_s` (s)."""
    name = config.vehicle_id
    return [
        _neighbours(agent, config, t_s),
        Status(
            level=DiagnosticStatus.ERROR if agent.holding else DiagnosticStatus.OK,
            name=f"{name}/agent_node: control law",
            message=f"safe command: {agent.holding}" if agent.holding else "acts",
            hardware_id=name,
        ),
        _inputs(agent, config, mail, malformed),
    ]


def _neighbours(agent: Agent, config: AgentConfig, t_s: float) -> Status:
    name, others = config.vehicle_id, config.fleet_size - 1
    oldest_s = max(agent.neighbours.column(AGE), default=math.inf)
    refused = refusal_words(agent.refusals, config.fleet_ids, t_s)
    words = list(refused)
    if len(agent.neighbours) < others:
        words.append(_not_heard(agent, config))
    if agent.saturated:
        words.append(f"{agent.saturated} values did not fit a report and were sent as its bound")
    is_quiet = bool(words) or (others > 0 and oldest_s > _OLD_S)
    return Status(
        level=DiagnosticStatus.WARN if is_quiet else DiagnosticStatus.OK,
        name=f"{name}/agent_node: neighbours",
        message="; ".join(words) or f"oldest packet {oldest_s:.1f} s",
        hardware_id=name,
        values=[
            ("neighbours", str(len(agent.neighbours))),
            ("oldest_packet_s", f"{oldest_s:.3f}"),
            ("packets_rejected", str(agent.rejected)),
            ("packets_outdated", str(agent.outdated)),
            ("values_saturated", str(agent.saturated)),
            ("reports_unsent", str(agent.unsent)),
            *(("refused", line) for line in refused),
        ],
    )


def _not_heard(agent: Agent, config: AgentConfig) -> str:
    """Return the number of neighbours that are not heard, and the names of the first few."""
    heard = {config.address, *agent.neighbours.addresses}
    silent = [address for address in range(1, config.fleet_size + 1) if address not in heard]
    names = [vehicle_name(address, config.fleet_ids) for address in silent]
    return f"{len(silent)} not heard: {listed(names)}"


def _inputs(agent: Agent, config: AgentConfig, mail: Mail, malformed: int) -> Status:
    """Return text about inputs that the agent did not use."""
    name = config.vehicle_id
    left_out = {
        "navigations_dropped": mail.navs.dropped,
        "inboxes_dropped": mail.inboxes.dropped,
        "contacts_refused": agent.contacts_refused,
        "messages_malformed": malformed,
    }
    last = [
        f"{what} of {newest.dropped_words}"
        for what, newest in (("navigation", mail.navs), ("inbox", mail.inboxes))
        if newest.dropped
    ]
    return Status(
        level=DiagnosticStatus.WARN if any(left_out.values()) else DiagnosticStatus.OK,
        name=f"{name}/agent_node: inputs",
        message="left out, last: " + "; ".join(last) if last else f"{sum(left_out.values())} left out",
        hardware_id=name,
        values=[(key, str(count)) for key, count in left_out.items()],
    )
