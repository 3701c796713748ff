"""Cases: bring-up, orders of the operator, and the ways in which a node ends."""

import math

from sitl.acceptance.bench import Bench
from sitl.acceptance.case import ARDUCOPTER, PX4, Case, expect
from sitl.acceptance.modes import controlled
from sitl.acceptance.node import Node
from sitl.acceptance.rig import Rig

_FAST_MPS = {ARDUCOPTER: 4.3, PX4: 3.6}
"""PX4's own velocity control is slower: from 5 m/s asked for in a step of 2 s it makes about 4 (SIH)."""
_STANDING_S = 14.0
_RASH = ("--lead-ms", "0")
"""Without a lead a single UAV darts to and fro at full speed."""


def _bring_up(bench: Bench) -> str:
    with Rig(bench) as rig:
        node = rig.flying()
        rig.spend(10)
        expect(rig.is_in(controlled(rig.autopilot)), f"mode {rig.mode}")
        # UAV 0 flies in the lowest layer, 20 m.
        expect(abs(rig.height - 20.0) < 2.0, f"height {rig.height:.1f} m, its layer is at 20 m")
        expect("no setpoints" not in node.text.split("the actor flies")[-1], "it stopped after a while")
        return f"{controlled(rig.autopilot)}, {rig.height:.1f} m, {rig.speed:.1f} m/s"


def _fast(rig: Rig) -> None:
    fast = _FAST_MPS[rig.autopilot]
    rig.until(lambda: rig.speed >= fast, f"a speed of {fast} m/s", limit_s=400)


def _order(bench: Bench, line: str, mode: str) -> str:
    with Rig(bench) as rig:
        node = rig.flying(*_RASH)
        _fast(rig)
        node.type(line)
        rig.until(lambda: rig.is_in(mode), f"{mode} after `{line}`", node, limit_s=10)
        ordered = rig.clock_ms
        rig.until(lambda: not rig.observer.armed, "it lands and disarms", node, limit_s=240)
        took = (rig.clock_ms - ordered) / 1000
        node.end()
        unix_s = _unix_of(rig, ordered)
        late = [at for at, _ in node.sent() if at > unix_s + 2.0]
        expect(not late, f"{len(late)} setpoints after {mode}")
        return f"{mode}, on the ground and disarmed after {took:.0f} s"


def _unix_of(rig: Rig, boot_ms: float) -> float:
    """The host's Unix time at a time of the vehicle's clock; both run equally fast here."""
    import time

    return time.time() - (rig.clock_ms - boot_ms) / 1000


def _let_go(bench: Bench, act: str) -> str:
    with Rig(bench) as rig:
        node = rig.flying(*_RASH)
        _fast(rig)
        if act == "release":
            node.type("release")
        else:
            node.interrupt()
        far = rig.farthest(_STANDING_S)
        expect(rig.speed < 0.5, f"still {rig.speed:.1f} m/s after {_STANDING_S:.0f} s")
        expect(far <= 12.0, f"{far:.1f} m")
        return f"stands after {far:.1f} m"


def _kill(bench: Bench, timeout_s: float, limit_m: float) -> str:
    name = "GUID_TIMEOUT" if bench.autopilot == ARDUCOPTER else "COM_OF_LOSS_T"
    with Rig(bench, parameters={name: timeout_s}) as rig:
        node = rig.flying(*_RASH)
        _fast(rig)
        speed = rig.speed
        node.kill()
        far = rig.farthest(_STANDING_S)
        expect(far <= limit_m, f"{far:.1f} m from {speed:.1f} m/s")
        return f"{far:.1f} m from {speed:.1f} m/s, then {rig.mode} at {rig.speed:.1f} m/s"


def _killed_watched(bench: Bench, system: int) -> str:
    """Whether ArduPilot's ground-station failsafe returns a vehicle whose node is killed."""
    with Rig(bench, parameters={"FS_GCS_ENABLE": 1}, pilot=False) as rig:
        node = rig.flying("--system", str(system))
        rig.spend(5)
        node.kill()
        rig.spend(12)
        return rig.mode


def _killed_as_255(bench: Bench) -> str:
    mode = _killed_watched(bench, 255)
    expect(mode == "RTL", f"mode {mode}")
    return mode


def _killed_as_self(bench: Bench) -> str:
    mode = _killed_watched(bench, 1)
    expect(mode == "GUIDED", f"mode {mode}")
    return f"{mode}: it hovers"


def _straight(node: Node) -> float:
    """The longest setpoint that a node sent, m/s."""
    return max((math.hypot(message.vx, message.vy) for _, message in node.sent()), default=0.0)


def _limits(bench: Bench) -> str:
    with Rig(bench) as rig:
        node = rig.flying(*_RASH)
        rig.spend(40)
        node.end()
        fastest = _straight(node)
        expect(0.0 < fastest <= 5.01, f"a setpoint of {fastest:.2f} m/s")
        return f"{len(node.sent())} setpoints, the fastest {fastest:.2f} m/s"


CASES = [
    Case("bring-up", "arms, climbs to its layer, the actor flies", _bring_up),
    Case("setpoints for 40 s", "none faster than 5 m/s", _limits),
    Case("`land` at full speed", "LAND, no setpoints after it", lambda bench: _order(bench, "land", "LAND")),
    Case("`return` at full speed", "RTL, no setpoints after it", lambda bench: _order(bench, "return", "RTL")),
    Case("`release` at full speed", "brakes within 12 m", lambda bench: _let_go(bench, "release")),
    Case("Ctrl-C at full speed", "brakes within 12 m", lambda bench: _let_go(bench, "interrupt")),
    Case("SIGKILL at full speed, timeout 1 s", "at most 15 m", lambda bench: _kill(bench, 1.0, 15.0)),
    Case(
        "SIGKILL at full speed, timeout 3 s", "at most 28.5 m", lambda bench: _kill(bench, 3.0, 28.5), (ARDUCOPTER,)
    ),
    Case("SIGKILL, `--system 255`, FS_GCS_ENABLE 1", "RTL", _killed_as_255, (ARDUCOPTER,)),
    Case("SIGKILL, own system, FS_GCS_ENABLE 1", "hovers in GUIDED, as documented", _killed_as_self, (ARDUCOPTER,)),
]
