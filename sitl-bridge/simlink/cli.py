"""The command line: a fleet from one line of JSON, or from options."""

import argparse
import json
import logging
import os
import signal
import sys
from typing import Any

from simlink import config, extras
from simlink.config import ConfigError, FleetConfig
from simlink.events import EventLog
from simlink.fleet import Fleet
from simlink.hub import UdpHub, first_line
from simlink.signing import KeyFileError, read_key
from simlink.status import EventLines, StatusLine

logger = logging.getLogger(__name__)

EPILOG = """\
without options it reads the fleet as one line of JSON on stdin, then commands, one JSON object a line, and writes
events as JSON lines to stdout; docs/simlink.md lists the fields.

examples:
  python -m simlink --count 3                  three ArduCopters for 14550, 14560 and 14570, in real time
  python -m simlink --dialect px4 --wind 4,0   one PX4 for 14540 in 4 m/s of wind towards the east
  python -m simlink --fault '{"id": 1, "kind": "gps_lost", "phase": "transit", "for_ms": 5000}'
"""

PORTS = {"ardupilot": (14_550, 10), "px4": (14_540, 1)}
"""First port and distance to the next, as the autopilots' own simulators have them."""


def main(arguments: list[str] | None = None) -> int:
    """Runs a fleet until it is stopped; returns the exit status."""
    logging.basicConfig(level=logging.INFO, stream=sys.stderr, format="simlink: %(message)s")
    logging.getLogger("pymavlink").setLevel(logging.WARNING)  # it logs every rejected signature
    for number in (signal.SIGINT, signal.SIGTERM):  # also where whoever started it ignores them
        signal.signal(number, signal.default_int_handler)
    arguments = sys.argv[1:] if arguments is None else arguments
    try:
        return _from_options(_parser().parse_args(arguments)) if arguments else _from_stdin()
    except (ConfigError, KeyFileError) as error:
        print(f"simlink: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 0
    except BrokenPipeError:  # whoever read the events has gone
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def _from_stdin() -> int:
    fd = sys.stdin.fileno()
    if os.isatty(fd):
        raise ConfigError("stdin is a terminal and no options are given; try --count 3, or --help")
    line, rest = first_line(fd)
    try:
        raw = json.loads(line)
    except ValueError as error:
        raise ConfigError(f"the first line of stdin is no JSON: {error}") from None
    fleet_config = config.read(raw)
    with _hub(fleet_config, control=fd, left_over=rest) as hub:
        Fleet(fleet_config, hub, EventLog(sys.stdout), _key(fleet_config)).run()
    return 0


def _from_options(options: argparse.Namespace) -> int:
    fleet_config = config.read(_raw(options))
    log = EventLog(sys.stdout) if options.json else EventLines(logger)
    with _hub(fleet_config) as hub:
        fleet = Fleet(fleet_config, hub, log, _key(fleet_config), StatusLine(sys.stderr, hub.now))
        for vehicle in fleet_config.vehicles:
            logger.info(
                "vehicle %d: %s, system %d, sends to udp %s:%d",
                vehicle.id,
                vehicle.dialect,
                vehicle.system,
                vehicle.host,
                vehicle.port,
            )
        fleet.run()
    return 0


def _hub(fleet: FleetConfig, **options: Any) -> UdpHub:
    try:
        return UdpHub([(vehicle.host, vehicle.port) for vehicle in fleet.vehicles], **options)
    except OSError as error:
        raise ConfigError(f"cannot open the sockets: {error}") from None


def _key(fleet: FleetConfig) -> bytes | None:
    return read_key(fleet.signing_key_file) if fleet.signing_key_file else None


def _raw(options: argparse.Namespace) -> dict[str, Any]:
    """The same JSON object that would come on stdin."""
    port, apart = PORTS[options.dialect]
    port = options.port or port
    apart = apart if options.port_step is None else options.port_step
    side = max(1, round(options.count**0.5))
    vehicles = [
        {
            "id": options.first_id + i,
            "host": options.host,
            "port": port + apart * i,
            "dialect": options.dialect,
            "alt": options.origin[2],
            "start_u": [100 + options.spacing * (i % side), 100 + options.spacing * (i // side)],
        }
        for i in range(options.count)
    ]
    try:
        faults = [json.loads(fault) for fault in options.fault]
    except ValueError as error:
        raise ConfigError(f"--fault is no JSON: {error}") from None
    raw = {
        "vehicles": vehicles,
        "origin": dict(zip(("lat", "lon", "alt"), options.origin, strict=True)),
        "scale_m": options.scale_m,
        "step_ms": options.step_ms,
        "rate_hz": options.rate,
        "dynamics": options.dynamics,
        "lockstep": options.lockstep,
        "speed": options.speed,
        "wind": list(options.wind),
        "gps_noise_m": options.gps_noise,
        "guided_timeout_s": options.guided_timeout,
        "parameters": dict(options.parameter),
        "seed": options.seed,
        "signing_key_file": options.key_file,
        "faults": faults,
        "extra": options.extra,
        "shared_ports": options.shared_ports,
    }
    return {name: value for name, value in raw.items() if value is not None}


def _numbers(count: int, example: str):
    def read(text: str) -> tuple[float, ...]:
        try:
            numbers = tuple(float(part) for part in text.split(","))
        except ValueError:
            numbers = ()
        if len(numbers) != count:
            raise argparse.ArgumentTypeError(f"{count} numbers such as {example}, not {text!r}")
        return numbers

    return read


def _parameter(text: str) -> tuple[str, float]:
    name, _, value = text.partition("=")
    try:
        return name, float(value)
    except ValueError:
        raise argparse.ArgumentTypeError(f"a name and a number such as FS_GCS_ENABLE=1, not {text!r}") from None


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m simlink",
        description="A fleet of simulated autopilots that speak MAVLink over UDP.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    place = config.Place()
    add = parser.add_argument
    add("--count", type=int, default=1, metavar="N", help="vehicles (1)")
    add("--dialect", choices=config.DIALECTS, default="ardupilot", help="what they claim to be (ardupilot)")
    add("--first-id", type=int, default=1, metavar="ID", help="id and MAVLink system of the first (1)")
    add("--host", default="127.0.0.1", help="where the telemetry goes (127.0.0.1)")
    add("--port", type=int, help="port of the first vehicle (ardupilot 14550, px4 14540)")
    add("--port-step", type=int, metavar="N", help="distance to the next vehicle's port (ardupilot 10, px4 1)")
    add(
        "--origin",
        type=_numbers(3, "47.4,8.5,400"),
        default=(place.lat, place.lon, place.alt),
        metavar="LAT,LON,ALT",
        help="the map's south-west corner; the vehicles stand in its middle (ArduPilot's usual field)",
    )
    add("--spacing", type=float, default=4.0, metavar="U", help="distance between vehicles, map units (4)")
    add("--scale-m", type=float, default=2.5, metavar="M", help="metres in a map unit (2.5)")
    add("--step-ms", type=int, default=2000, metavar="MS", help="length of a step (2000)")
    add("--rate", type=int, default=5, metavar="HZ", help="ticks a second: the fastest telemetry (5)")
    add("--dynamics", choices=config.DYNAMICS, default="point", help="how they move (point)")
    add("--speed", type=float, default=1.0, metavar="X", help="times real time (1)")
    add(
        "--lockstep", action="store_true", help="wait for a setpoint after each position, and go as fast as that allows"
    )
    add("--wind", type=_numbers(2, "4,-1"), default=(0.0, 0.0), metavar="E,N", help="m/s towards east and north")
    add("--gps-noise", type=float, default=0.0, metavar="M", help="standard deviation of the position (0)")
    add("--guided-timeout", type=float, metavar="S", help="stops after so long without setpoints (ardupilot 3, px4 1)")
    add(
        "--parameter",
        action="append",
        default=[],
        type=_parameter,
        metavar="NAME=VALUE",
        help="a parameter of the autopilots, such as FS_GCS_ENABLE=1; may be repeated",
    )
    add("--seed", type=int, default=1, help="of the noise (1)")
    add("--key-file", metavar="FILE", help="sign with this key, and take only what is signed with it")
    add("--fault", action="append", default=[], metavar="JSON", help="something that goes wrong; may be repeated")
    add(
        "--extra",
        action="append",
        default=[],
        choices=extras.NAMES,
        help="somebody else on every vehicle's port, or one more battery; may be repeated",
    )
    add("--shared-ports", action="store_true", help="every vehicle on every port, as behind one MAVProxy")
    add("--json", action="store_true", help="events as JSON lines on stdout")
    return parser
