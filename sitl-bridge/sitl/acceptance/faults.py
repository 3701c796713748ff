"""Cases: reboots, a lost GPS, keys, several vehicles behind one MAVProxy."""

import hashlib
import importlib.util
import os
import sys
import time

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sitl.acceptance.bench import Bench
from sitl.acceptance.case import ARDUCOPTER, Case, NotRun, expect
from sitl.acceptance.rig import Rig, free_port
from sitl.process import Process

_FORCED = 20_190_226
"""ArduPilot reboots in the air with this in parameter 6."""
_SIGNING_EPOCH_S = 1_420_070_400


def _reboot(rig: Rig, limit_s: float = 60) -> None:
    before = rig.clock_ms
    rig.observer.command(mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1, 0, 0, 0, 0, _FORCED)
    rig.until(lambda: 0 < rig.clock_ms < before - 3000, "the autopilot boots again", limit_s=limit_s)


def _reboot_on_the_ground(bench: Bench) -> str:
    with Rig(bench) as rig:
        node = rig.node(takes_off=False)
        rig.until(lambda: node.said(", system 1") and rig.clock_ms > 10_000, "the node hears the vehicle", node)
        heard = len(node.text)
        _reboot(rig)
        rig.spend(20)
        node.type("start")
        rig.until(lambda: node.said("ready to start", heard), "ready to start again", node, limit_s=60)
        return "rates asked for again, ready"


def _reboot_in_flight(bench: Bench) -> str:
    with Rig(bench) as rig:
        node = rig.flying()
        heard = len(node.text)
        _reboot(rig)
        rig.spend(10)
        expect(node.running, "the node ended")
        expect("the actor flies" not in node.text[heard:], "it flew on by itself")
        node.type("start")
        rig.until(lambda: node.said("the actor flies", heard), "the actor flies after `start`", node, limit_s=150)
        return "silent, then flies again by `start`"


def _gps_loss(bench: Bench) -> str:
    with Rig(bench) as rig:
        node = rig.flying()
        heard = len(node.text)
        for name in ("SIM_GPS1_ENABLE", "SIM_GPS_DISABLE"):  # 4.6 and later, earlier
            rig.set_parameter(name, 1.0 if name.endswith("DISABLE") else 0.0)
        rig.until(lambda: node.said("gps_lost", heard), "it stops", node, limit_s=10)
        rig.spend(4)
        for name in ("SIM_GPS1_ENABLE", "SIM_GPS_DISABLE"):
            rig.set_parameter(name, 0.0 if name.endswith("DISABLE") else 1.0)
        rig.until(lambda: node.said("the actor flies", heard), "it flies on", node, limit_s=60)
        return "stops, flies on"


def _teach_key(rig: Rig, key: bytes) -> None:
    stamp = int((time.time() - _SIGNING_EPOCH_S) * 100_000)
    rig.observer.send(mavlink.MAVLink_setup_signing_message(rig.system, 1, list(key), stamp))


def _keyed(bench: Bench, nodes_key: str | None) -> tuple[Rig, list[str]]:
    rig = Rig(bench)
    rig.until(lambda: rig.clock_ms > 8000, "the vehicle runs")
    _teach_key(rig, hashlib.sha256(b"the swarm's passphrase").digest())
    rig.spend(2)
    if nodes_key is None:
        return rig, []
    path = bench.folder / "swarm.key"
    path.touch(mode=0o600)
    path.write_text(nodes_key)
    return rig, ["--signing-key-file", str(path)]


def _right_key(bench: Bench) -> str:
    rig, options = _keyed(bench, "the swarm's passphrase")
    with rig:
        node = rig.flying(*options)
        return "signed, the actor flies" if node.running else "the node ended"


def _wrong_key(bench: Bench) -> str:
    rig, options = _keyed(bench, "another passphrase")
    with rig:
        node = rig.node(*options)
        rig.until(lambda: node.said("signs with another key"), "the wrong key is named", node, limit_s=30)
        expect(not rig.observer.armed, "it was armed")
        return "named at once: signs with another key"


def _no_key(bench: Bench) -> str:
    rig, options = _keyed(bench, None)
    with rig:
        node = rig.node(*options)
        rig.until(lambda: node.said("signs"), "the missing key is told", node, limit_s=30)
        line = next(line for line in node.text.splitlines() if "signs" in line)
        return line.strip()


def _shared_port(bench: Bench) -> str:
    """Three vehicles behind one MAVProxy, which puts every vehicle on every node's port."""
    if importlib.util.find_spec("MAVProxy") is None:
        raise NotRun("MAVProxy is not installed in this Python")
    vehicle_ports, node_ports = [free_port() for _ in range(3)], [free_port() for _ in range(3)]
    links = [f"udpclient:127.0.0.1:{port}" for port in vehicle_ports]
    rigs = [Rig(bench, index=i, node_link=link) for i, link in enumerate(links)]
    script = os.path.join(os.path.dirname(sys.executable), "mavproxy.py")
    command = [sys.executable, script, "--non-interactive", "--daemon", "--default-modules=link"]
    command += [f"--master=udpin:127.0.0.1:{port}" for port in vehicle_ports]
    command += [f"--out=udpout:127.0.0.1:{port}" for port in node_ports]
    proxy = Process(command, bench.folder / "mavproxy")
    try:
        nodes = [rig.node(link=f"udpin:127.0.0.1:{port}") for rig, port in zip(rigs, node_ports, strict=True)]
        started = time.monotonic()
        while not all(node.said("the actor flies") for node in nodes):
            proxy.check()
            expect(time.monotonic() - started < 180, "not all fly: " + " / ".join(n.text[-150:] for n in nodes))
            for rig in rigs:
                rig.until(lambda: True, "")
                rig.turn()
            time.sleep(0.02)
        seen = [sorted({message.target_system for _, message in _ended(node).sent()}) for node in nodes]
        expect(seen == [[1], [2], [3]], f"setpoints of the nodes go to {seen}")
        return "each node flies its own vehicle"
    finally:
        proxy.end()
        for rig in rigs:
            rig.__exit__()


def _ended(node: "object") -> "object":
    node.end()
    return node


CASES = [
    Case("reboot on the ground", "ready for `start` again", _reboot_on_the_ground, (ARDUCOPTER,)),
    Case("reboot in flight", "silent; `start` flies again", _reboot_in_flight, (ARDUCOPTER,)),
    Case("GPS lost for 4 s", "stops, then flies on", _gps_loss, (ARDUCOPTER,)),
    Case("the right key", "flies", _right_key, (ARDUCOPTER,)),
    Case("a wrong key", "named, nothing armed", _wrong_key, (ARDUCOPTER,)),
    Case("no key", "told that the autopilot signs", _no_key, (ARDUCOPTER,)),
    Case("three vehicles behind one MAVProxy", "each node flies its own", _shared_port, (ARDUCOPTER,)),
]
