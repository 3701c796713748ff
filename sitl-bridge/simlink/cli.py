"""The command line: a fleet from one line of JSON, or from options."""

import argparse
import json
import logging
import sys

from simlink import config
from simlink.events import EventLog
from simlink.fleet import Fleet
from simlink.hub import UdpHub, first_line
from simlink.signing import KeyFileError, read_key


def main(arguments: list[str] | None = None) -> int:
    """Runs a fleet until it is stopped; returns the exit status."""
    logging.basicConfig(level=logging.INFO, stream=sys.stderr, format="simlink: %(message)s")
    try:
        line, rest = first_line(sys.stdin.fileno())
        fleet_config = config.read(json.loads(line))
        key = read_key(fleet_config.signing_key_file) if fleet_config.signing_key_file else None
    except (config.ConfigError, json.JSONDecodeError, KeyFileError) as error:
        print(f"simlink: {error}", file=sys.stderr)
        return 2
    hub = UdpHub([(v.host, v.port) for v in fleet_config.vehicles], control=sys.stdin.fileno(), left_over=rest)
    try:
        Fleet(fleet_config, hub, EventLog(sys.stdout), key).run()
    except (KeyboardInterrupt, BrokenPipeError):
        pass
    finally:
        hub.close()
    return 0
