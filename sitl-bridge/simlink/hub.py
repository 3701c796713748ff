"""The fleet's sockets, its control lines and its wall clock."""

import os
import select
import socket
import time
from typing import Protocol

CONTROL = -1
"""Index of a control line among what was received."""
_MAX_PER_TURN = 64
_BUFFER_BYTES = 1 << 20


class Hub(Protocol):
    """Where a fleet's datagrams go and come from."""

    def now(self) -> float:
        """Wall clock, s."""

    def send(self, index: int, frame: bytes) -> None:
        """Sends a datagram of the vehicle at `index`."""

    def receive(self, timeout_s: float) -> list[tuple[int, bytes | None]]:
        """Received datagrams, by vehicle; waits for at most `timeout_s`. Under CONTROL a line, or None at their end."""


class UdpHub:
    """One UDP socket a vehicle; each sends to its own address and listens to whoever answers."""

    def __init__(self, addresses: list[tuple[str, int]], control: int | None = None, left_over: bytes = b"") -> None:
        self._sockets: list[socket.socket] = []
        self._addresses: list[tuple] = []
        self._by_fd: dict[int, int] = {}
        self._poll = select.epoll()
        for index, address in enumerate(addresses):
            family, kind, _, _, resolved = socket.getaddrinfo(*address, type=socket.SOCK_DGRAM)[0]
            s = socket.socket(family, kind)
            s.setblocking(False)
            s.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER_BYTES)
            self._sockets.append(s)
            self._addresses.append(resolved)
            # Bound at once, so that what is sent to it before its own first datagram is not lost.
            s.bind(("", 0))
            self._by_fd[s.fileno()] = index
            self._poll.register(s, select.EPOLLIN)
        self._control = control
        *self._early, self._line = left_over.split(b"\n")
        if control is not None:
            try:
                self._poll.register(control, select.EPOLLIN)
            except PermissionError:  # a plain file is always ready, epoll does not take it
                self._control = None

    def now(self) -> float:
        """Wall clock, s."""
        return time.monotonic()

    def send(self, index: int, frame: bytes) -> None:
        """Sends a datagram; one that the system refuses is lost, as on any link."""
        try:
            self._sockets[index].sendto(frame, self._addresses[index])
        except OSError:
            pass

    def receive(self, timeout_s: float) -> list[tuple[int, bytes | None]]:
        """Received datagrams and control lines."""
        arrived: list[tuple[int, bytes | None]] = [(CONTROL, line) for line in self._early]
        self._early = []
        for fd, _ in self._poll.poll(max(0.0, timeout_s)):
            if fd == self._control:
                arrived.extend((CONTROL, line) for line in self._control_lines(fd))
                continue
            index = self._by_fd[fd]
            receive = self._sockets[index].recv
            for _ in range(_MAX_PER_TURN):
                try:
                    arrived.append((index, receive(2048)))
                except BlockingIOError:
                    break
                except OSError:
                    continue
        return arrived

    def _control_lines(self, fd: int) -> list[bytes | None]:
        chunk = os.read(fd, 65_536)
        if not chunk:
            self._poll.unregister(fd)
            return [None]
        *lines, self._line = (self._line + chunk).split(b"\n")
        return list(lines)

    def __enter__(self) -> "UdpHub":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Closes all sockets."""
        self._poll.close()
        for s in self._sockets:
            s.close()


def first_line(fd: int) -> tuple[bytes, bytes]:
    """The first line of a file descriptor, and what was read beyond it."""
    text = b""
    while b"\n" not in text:
        chunk = os.read(fd, 65_536)
        if not chunk:
            break
        text += chunk
    line, _, rest = text.partition(b"\n")
    return line, rest
