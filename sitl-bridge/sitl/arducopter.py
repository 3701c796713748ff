"""ArduCopter's SITL: how an instance is started.

Seen on ArduCopter 4.7-dev. The parameters are those without which the simulated vehicle does not arm (frame, RC and
sensor calibration), and those of a fleet: a battery that lasts, no log files.
"""

import shutil
from pathlib import Path

from sitl.process import Process, SitlError
from sitl.spec import VehicleSpec

_CALIBRATED = {
    "FRAME_CLASS": 1,
    "FRAME_TYPE": 0,
    # A sensor without offsets counts as one that was never calibrated.
    **{f"INS_ACC{n}OFFS_{axis}": 0.001 for n in ("", "2") for axis in "XYZ"},
    **{f"INS_ACC{n}SCAL_{axis}": 1.001 for n in ("", "2") for axis in "XYZ"},
    **{f"COMPASS_OFS{n}_{axis}": value for n in ("", "2", "3") for axis, value in (("X", 5), ("Y", 13), ("Z", -18))},
    **{f"RC{n}_{end}": value for n in range(1, 9) for end, value in (("MIN", 1000), ("MAX", 2000), ("TRIM", 1500))},
}
_FLEET = {
    "BATT_MONITOR": 4,
    # The default, 3.3 Ah, reads 25 % after 300 s of flight.
    "BATT_CAPACITY": 100_000,
    "LOG_BACKEND_TYPE": 0,
}


def program(path: str) -> Path:
    """The program of a path or a name in PATH."""
    found = shutil.which(path)
    if found is None:
        raise SitlError(
            f"{path}: no such program; build ArduPilot's SITL for Copter (ardupilot.org, 'Setting up SITL') "
            "and name its build/sitl/bin/arducopter"
        )
    return Path(found).absolute()


def start(
    path: Path,
    spec: VehicleSpec,
    folder: Path,
    speed: float = 1.0,
    parameters: dict[str, float] | None = None,
) -> Process:
    """Starts an instance whose first link is the node's and whose second one is the observer's."""
    folder.mkdir(parents=True, exist_ok=True)
    defaults = folder / "covey.parm"
    values = {**_CALIBRATED, **_FLEET, **(parameters or {})}
    defaults.write_text("".join(f"{name} {value}\n" for name, value in values.items()))
    command = [str(path), "--model", "quad", "--speedup", f"{speed:g}", f"-I{spec.index}", "--sysid", str(spec.system)]
    command += ["--home", f"{spec.lat:.7f},{spec.lon:.7f},{spec.alt:.2f},0", "--defaults", str(defaults)]
    command += ["--serial0", spec.link, "--serial1", f"udpclient:127.0.0.1:{spec.observer_port}", "--serial2", "none:0"]
    return Process(command, folder)
