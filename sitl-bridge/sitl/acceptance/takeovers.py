"""Cases: a pilot takes over, in every stage."""

import time

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sitl.acceptance.bench import Bench
from sitl.acceptance.case import ARDUCOPTER, Case, expect
from sitl.acceptance.modes import controlled
from sitl.acceptance.node import Node
from sitl.acceptance.rig import Rig

_WATCHED_S = 8.0
_SETTLED_S = 1.5


def _pilots_mode(rig: Rig) -> str:
    return "LOITER" if rig.autopilot == ARDUCOPTER else "POSCTL"


def _stays(rig: Rig, node: Node, mode: str) -> str:
    """The vehicle stays in the pilot's mode, and the node neither commands nor sends setpoints."""
    rig.spend(_SETTLED_S)
    since = time.time()
    rig.spend(_WATCHED_S)
    expect(rig.is_in(mode), f"mode {rig.mode} after the pilot's {mode}")
    running = node.running
    node.end()
    late = [at for at, _ in node.sent() if at > since]
    expect(not late, f"{len(late)} setpoints while the pilot flies")
    commands = [message.command for at, message in node.sent("COMMAND_LONG") if at > since]
    flown = {mavlink.MAV_CMD_DO_SET_MODE, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, mavlink.MAV_CMD_NAV_TAKEOFF}
    expect(not flown.intersection(commands), f"commands {sorted(flown.intersection(commands))} while the pilot flies")
    expect(running, "the node ended: " + node.text[-200:])
    return f"stays in {mode}, nothing sent for {_WATCHED_S:.0f} s"


def _in_climb(bench: Bench) -> str:
    with Rig(bench) as rig:
        node = rig.node()
        rig.until(lambda: rig.observer.armed and rig.height > 3.0, "it climbs", node)
        mode = _pilots_mode(rig)
        rig.switch(mode)
        return _stays(rig, node, mode)


def _in_flight(bench: Bench) -> str:
    with Rig(bench) as rig:
        node = rig.flying()
        rig.spend(4)
        mode = _pilots_mode(rig)
        rig.switch(mode)
        return _stays(rig, node, mode)


def _back_by_start(bench: Bench) -> str:
    with Rig(bench) as rig:
        node = rig.flying()
        mode = _pilots_mode(rig)
        rig.switch(mode)
        rig.spend(4)
        heard = len(node.text)
        node.type("start")
        rig.until(lambda: node.said("the actor flies", heard), "the actor flies after `start`", node, limit_s=30)
        # The node's HEARTBEATs and these need not come at the same time.
        rig.until(lambda: rig.is_in(controlled(rig.autopilot)), "the mode is the node's", node, limit_s=10)
        return f"{mode}, then {rig.mode} by `start`"


def _pilot_takes_off(rig: Rig, mode: str) -> None:
    """The pilot is in the air before a node comes."""
    rig.until(lambda: "GLOBAL_POSITION_INT" in rig.observer.last and rig.clock_ms > 15_000, "the vehicle is ready")
    climb = rig.clock_ms
    asked = 0.0
    if rig.autopilot == ARDUCOPTER:
        rig.switch("GUIDED")

    def up() -> bool:
        nonlocal asked
        if time.monotonic() - asked > 2:
            asked = time.monotonic()
            if rig.observer.armed:
                height = (10.0,) if rig.autopilot == ARDUCOPTER else (488.0 + 10.0,)
                nan = float("nan")
                where = (0, 0, 0) if rig.autopilot == ARDUCOPTER else (nan, nan, nan)
                rig.observer.command(mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, *where, *height)
            else:
                rig.observer.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)
        return rig.height > 8.0

    rig.until(up, f"the pilot takes off ({climb:.0f} ms)", limit_s=90)
    rig.switch(mode)


def _at_start(bench: Bench) -> str:
    with Rig(bench) as rig:
        mode = _pilots_mode(rig)
        _pilot_takes_off(rig, mode)
        node = rig.node()
        rig.until(lambda: node.said(f", system {rig.system}"), "the node hears the vehicle", node)
        rig.spend(8)
        return _stays(rig, node, mode)


def _on_the_ground(bench: Bench) -> str:
    """The pilot arms in another mode on the ground before the node commands."""
    with Rig(bench) as rig:
        node = rig.node()
        rig.until(lambda: rig.is_in(controlled(rig.autopilot)) or rig.observer.armed, "the node begins", node)
        rig.switch("LOITER")
        return _stays(rig, node, "LOITER")


def _follows(bench: Bench) -> str:
    """Without --takeoff: the pilot takes off and hands over."""
    with Rig(bench) as rig:
        _pilot_takes_off(rig, _pilots_mode(rig))
        node = rig.node(takes_off=False)
        rig.until(lambda: node.said(f", system {rig.system}"), "the node hears the vehicle", node)
        rig.spend(5)
        expect("airborne" not in node.text, "it took the pilot's LOITER for its own flight")
        rig.switch("GUIDED")
        rig.until(lambda: node.said("the actor flies"), "the actor flies", node, limit_s=90)
        return "the actor flies from the pilot's GUIDED on"


CASES = [
    Case("pilot flies at the node's start", "the node keeps away until `start`", _at_start),
    Case("pilot takes over before takeoff", "the node keeps away", _on_the_ground, (ARDUCOPTER,)),
    Case("pilot takes over in the climb", "the node keeps away", _in_climb),
    Case("pilot takes over in flight", "the node keeps away", _in_flight),
    Case("`start` after the pilot", "the node flies again", _back_by_start),
    Case("pilot takes off and hands over", "the node flies from GUIDED on", _follows, (ARDUCOPTER,)),
]
