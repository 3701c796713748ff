"""`python -m simlink.neighbours listen …` and `… play …`."""

import argparse
import json
import logging
import sys
import time

from simlink.neighbours.checker import Checker
from simlink.neighbours.ghosts import KINDS, Ghost
from simlink.neighbours.link import EXAMPLES, AddressError, SwarmAddress, SwarmSocket
from simlink.neighbours.message import Beacon, Message
from simlink.signing import KeyFileError, read_key

logger = logging.getLogger(__name__)
_TURN_S = 0.25


def main(arguments: list[str] | None = None) -> int:
    """Listens or plays until its time is over; returns the exit status."""
    logging.basicConfig(level=logging.INFO, stream=sys.stderr, format="neighbours: %(message)s")
    logging.getLogger("pymavlink").setLevel(logging.WARNING)  # it logs every rejected signature
    options = _parser().parse_args(arguments)
    try:
        key = read_key(options.key_file) if options.key_file else None
        link = SwarmSocket(SwarmAddress.read(options.swarm))
    except (AddressError, KeyFileError) as error:
        print(f"neighbours: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"neighbours: cannot listen on {options.swarm}: {error}", file=sys.stderr)
        return 2
    logger.info("listening on udp %s:%d", *link.listens_on)
    try:
        return options.run(options, link, key)
    finally:
        link.close()


def _listen(options: argparse.Namespace, link: SwarmSocket, key: bytes | None) -> int:
    checker = Checker(key, options.step_ms)
    heard = 0
    try:
        for datagram in _datagrams(link, options.seconds):
            for message in checker.check(datagram):
                heard += 1
                if options.verbose:
                    print(describe(message), flush=True)
            if options.messages is not None and heard >= options.messages:
                break
    except KeyboardInterrupt:
        pass
    report = checker.report()
    print(json.dumps(report, indent=None if options.json else 2))
    if not heard:
        logger.error("heard no neighbour message; is the swarm on %s?", options.swarm)
    return 0 if report["sound"] and heard else 1


def _play(options: argparse.Namespace, link: SwarmSocket, key: bytes | None) -> int:
    x, y = options.at
    ghost = Ghost(options.ghost, options.id, (x, y), options.velocity, options.actor, key, options.seed)
    sent = 0
    try:
        for datagram in _datagrams(link, options.seconds):
            for answer in ghost.receive(datagram):
                link.send(answer)
                sent += 1
    except KeyboardInterrupt:
        pass
    print(json.dumps({"ghost": options.ghost, "sent": sent}))
    return 0 if sent else 1


def _datagrams(link: SwarmSocket, seconds: float | None):
    """Received datagrams, for this many seconds."""
    end = None if seconds is None else time.monotonic() + seconds
    while end is None or time.monotonic() < end:
        datagram = link.receive(_TURN_S)
        if datagram is not None:
            yield datagram


def describe(message: Message) -> str:
    """A message as a line."""
    who = f"UAV {message.id:3} step {message.step} #{message.sequence}"
    if isinstance(message, Beacon):
        x, y, vx, vy = (value / 1024 for value in (message.x, message.y, message.vx, message.vy))
        return (
            f"{who} beacon  ({x:.2f}, {y:.2f}) u, ({vx:.2f}, {vy:.2f}) u/step, tie {message.tie}, {message.time_ms} ms"
        )
    return f"{who} feature degree {message.degree}, actor {message.actor:08x}, {len(message.values)} values"


def _pair(text: str) -> tuple[float, float]:
    x, y = (float(part) for part in text.split(","))
    return x, y


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m simlink.neighbours",
        description="Checks what the UAVs of a swarm tell each other, or plays neighbours that are not there.",
    )
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument("swarm", help=EXAMPLES)
    common.add_argument("--seconds", type=float, metavar="S", help="stop after so long (until interrupted)")
    common.add_argument("--key-file", metavar="FILE", help="key of the signatures")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    listen = commands.add_parser(
        "listen", parents=[common], help="judge every message, print a report; exit status 1 when something is wrong"
    )
    listen.add_argument("--messages", type=int, metavar="N", help="stop after so many messages")
    listen.add_argument("--step-ms", type=int, metavar="MS", help="length of a step: checks the clocks too")
    listen.add_argument("--verbose", action="store_true", help="print each message")
    listen.add_argument("--json", action="store_true", help="the report on one line")
    listen.set_defaults(run=_listen)
    kinds = "\n".join(f"  {kind:<14} {what}" for kind, what in KINDS.items())
    play = commands.add_parser(
        "play",
        parents=[common],
        help="send what a swarm must bear",
        epilog=f"ghosts:\n{kinds}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    play.add_argument("--ghost", choices=list(KINDS), default="ghost", help="which (ghost)")
    play.add_argument("--id", type=int, default=200, help="its id (200)")
    play.add_argument("--at", type=_pair, default=(100.0, 100.0), metavar="X,Y", help="where it begins, u (100,100)")
    play.add_argument("--velocity", type=_pair, default=(1.0, 0.0), metavar="X,Y", help="u/step (1,0)")
    play.add_argument("--actor", type=lambda t: int(t, 16), metavar="HEX", help="actor hash in its features")
    play.add_argument("--seed", type=int, default=1, help="of its random numbers (1)")
    play.set_defaults(run=_play)
    return parser


if __name__ == "__main__":
    sys.exit(main())
