"""A node under test: a process of `sitl-bridge fly`."""

import os
import signal
import subprocess
import threading
from collections.abc import Sequence
from pathlib import Path

from pymavlink import mavutil

_SETPOINT = "SET_POSITION_TARGET_LOCAL_NED"


class Node:
    """A running `sitl-bridge fly`, its notices, the operator's keyboard, and its recording."""

    def __init__(self, bridge: Path, arguments: Sequence[str], recording: Path) -> None:
        self.recording = recording
        command = [str(bridge), "fly", *arguments, "--simulated", "--tlog", str(recording)]
        self._child = subprocess.Popen(  # noqa: S603
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
            env={**os.environ, "NO_COLOR": "1"},
        )
        self._lines: list[str] = []
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        self._lines.extend(iter(self._child.stderr.readline, ""))

    @property
    def text(self) -> str:
        """All that it has said."""
        return "".join(self._lines)

    def said(self, words: str, after: int = 0) -> bool:
        """Whether it has said this, at or after a position in `text`."""
        return words in self.text[after:]

    def type(self, line: str) -> None:
        """The operator types a line."""
        self._child.stdin.write(line + "\n")
        self._child.stdin.flush()

    def interrupt(self) -> None:
        """Ctrl-C."""
        self._child.send_signal(signal.SIGINT)

    def kill(self) -> None:
        """SIGKILL: the node dies without a word."""
        self._child.kill()
        self._child.wait()

    @property
    def running(self) -> bool:
        """Whether the process lives."""
        return self._child.poll() is None

    def end(self) -> None:
        """Ends it, if it lives, and waits for its last words."""
        if self.running:
            self._child.kill()
        self._child.wait()
        self._reader.join(timeout=5)

    def sent(self, kind: str = _SETPOINT) -> list[tuple[float, object]]:
        """What it sent of a kind of message, by its recording: Unix time in s, message. The node must have ended."""
        log = mavutil.mavlink_connection(str(self.recording), dialect="ardupilotmega")
        found = []
        while (message := log.recv_match(type=kind)) is not None:
            found.append((message._timestamp, message))
        return found
