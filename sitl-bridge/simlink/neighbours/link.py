"""The swarm's datagrams: by multicast, by broadcast, or to a list of peers."""

import socket
import struct
from dataclasses import dataclass

_BUFFER_BYTES = 1 << 21
EXAMPLES = "multicast:239.86.67.1:14600, broadcast:192.168.4.255:14600 or peers:0.0.0.0:14600,192.168.4.3:14600"


class AddressError(ValueError):
    """An address that names no swarm; the message shows one that does."""


@dataclass(frozen=True)
class SwarmAddress:
    """Where to listen, and where to send."""

    kind: str
    listen: tuple[str, int]
    to: tuple[tuple[str, int], ...]
    interface: str = "0.0.0.0"

    @classmethod
    def read(cls, text: str) -> "SwarmAddress":
        """From `multicast:GROUP:PORT[@OWN-ADDRESS]`, `broadcast:ADDRESS:PORT` or `peers:LISTEN,PEER,…`."""
        kind, _, rest = text.partition(":")
        rest = rest.removeprefix("//")
        if kind == "multicast":
            group, _, interface = rest.partition("@")
            address = _address(group, text)
            if not 224 <= int(address[0].split(".")[0]) <= 239:
                raise AddressError(f"{text!r}: {address[0]} is no multicast address")
            return cls(kind, address, (address,), interface or "0.0.0.0")
        if kind == "broadcast":
            address = _address(rest, text)
            return cls(kind, ("0.0.0.0", address[1]), (address,))
        if kind == "peers":
            listen, *peers = [_address(part.strip(), text) for part in rest.split(",")]
            return cls(kind, listen, tuple(peers))
        raise AddressError(f"{text!r} is no swarm; write {EXAMPLES}")


def _address(text: str, whole: str) -> tuple[str, int]:
    host, _, port = text.rpartition(":")
    try:
        socket.inet_aton(host)
        number = int(port)
    except (OSError, ValueError):
        number = -1
    if not 0 <= number <= 65_535:
        raise AddressError(f"{whole!r}: {text!r} is no address with a port; write {EXAMPLES}")
    return host, number


class SwarmSocket:
    """One end of the swarm link. Its own datagrams come back by multicast and broadcast."""

    def __init__(self, address: SwarmAddress) -> None:
        self._to = address.to
        self._socket = s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        s.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER_BYTES)
        if address.kind != "peers":
            s.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        s.bind(address.listen)
        if address.kind == "multicast":
            interface = socket.inet_aton(address.interface)
            s.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(address.listen[0]) + interface)
            s.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, interface)
            s.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_LOOP, 1)
            s.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, struct.pack("b", 1))
        elif address.kind == "broadcast":
            s.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)

    @property
    def listens_on(self) -> tuple[str, int]:
        """With the port that was given for 0."""
        return self._socket.getsockname()

    def send(self, datagram: bytes) -> None:
        """To all; one that cannot be reached does not keep it from the others."""
        for to in self._to:
            try:
                self._socket.sendto(datagram, to)
            except OSError:
                pass

    def receive(self, timeout_s: float) -> bytes | None:
        """The next datagram; None when none comes within `timeout_s`."""
        self._socket.settimeout(max(timeout_s, 1e-6))
        try:
            return self._socket.recv(2048)
        except (TimeoutError, BlockingIOError, ConnectionRefusedError):
            return None

    def close(self) -> None:
        """Leaves the swarm."""
        self._socket.close()
