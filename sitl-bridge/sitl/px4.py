"""PX4's SITL with its built-in vehicle (SIH): how an instance is started.

Seen on PX4 main of 2025 and 2026. Its own links to offboard computers share one port from the eleventh instance on,
so the node and the observer get links of their own, which PX4's shell clients add once the instance runs.
"""

import subprocess
from pathlib import Path

from sitl.process import Process, SitlError
from sitl.spec import VehicleSpec

_FLEET = {
    # Without a ground station and a remote control these would refuse to arm.
    "NAV_DLL_ACT": 0,
    "COM_RC_IN_MODE": 4,
    # The simulated battery ends an episode early.
    "SIM_BAT_MIN_PCT": 100,
    "SDLOG_MODE": -1,
}
_LOCAL_PORT = 24_600
_RATE = 400_000
_NOT_NEEDED = (13_030, 14_280)
"""Ports of its links to a gimbal and a camera: an instance has no more than six links."""


def folder(path: str) -> Path:
    """A build folder of PX4's SITL."""
    build = Path(path).absolute()
    if not (build / "bin" / "px4").is_file():
        raise SitlError(
            f"{path}: no bin/px4 in there; build PX4's SITL (docs.px4.io, 'Simulation', 'SIH') "
            "and name its folder, such as build/px4_sitl_default"
        )
    return build


def start(
    build: Path,
    spec: VehicleSpec,
    place: Path,
    speed: float = 1.0,
    parameters: dict[str, float] | None = None,
) -> Process:
    """Starts an instance, which has the system id `index` + 1; `Links` gives it its links once it runs."""
    environment = {
        "PX4_SIMULATOR": "sihsim",
        "PX4_SIM_MODEL": "sihsim_quadx",
        "PX4_HOME_LAT": f"{spec.lat:.7f}",
        "PX4_HOME_LON": f"{spec.lon:.7f}",
        "PX4_HOME_ALT": f"{spec.alt:.2f}",
        "PX4_SIM_SPEED_FACTOR": f"{speed:g}",
    }
    values = {**_FLEET, **(parameters or {})}
    environment.update({f"PX4_PARAM_{name}": f"{value:g}" for name, value in values.items()})
    command = [str(build / "bin" / "px4"), "-i", str(spec.index), "-d", str(build / "etc"), "-w", str(place)]
    return Process(command, place, environment)


class Links:
    """The links of an instance to its node and to the observer, which are added once it runs."""

    def __init__(self, build: Path, spec: VehicleSpec) -> None:
        self._shell = [str(build / "bin" / "px4-mavlink"), "--instance", str(spec.index)]
        local = _LOCAL_PORT + 2 * spec.index
        self._not_needed = [port + spec.index for port in _NOT_NEEDED]
        self._missing = [(spec.node_port, "onboard", local), (spec.observer_port, "onboard", local + 1)]
        self._truth = local + 1

    def add(self) -> bool:
        """Tries to add those that are missing; whether there are all."""
        while self._missing:
            for port in self._not_needed:
                self._run("stop", "-u", str(port))
            port, mode, local = self._missing[0]
            # A start that was told to have failed may have left a link behind, which keeps the port.
            self._run("stop", "-u", str(local))
            if not self._run("start", "-x", "-u", str(local), "-r", str(_RATE), "-m", mode, "-o", str(port)):
                return False
            del self._missing[0]
        return self._run("stream", "-r", "20", "-s", "HIL_STATE_QUATERNION", "-u", str(self._truth))

    def _run(self, *arguments: str) -> bool:
        return subprocess.run([*self._shell, *arguments], capture_output=True, check=False).returncode == 0  # noqa: S603
