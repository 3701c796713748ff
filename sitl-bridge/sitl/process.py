"""A started program with a folder of its own, whose output goes to a file there."""

import ctypes
import os
import signal
import subprocess
from collections.abc import Sequence
from pathlib import Path

_TAIL_BYTES = 4000
_TAIL_LINES = 12
_PR_SET_PDEATHSIG = 1
_LIBC = ctypes.CDLL(None)


class SitlError(Exception):
    """An autopilot cannot be started, or ended; the words are for the user."""


def _end_with_parent() -> None:
    """A fleet that is killed takes its programs along: the kernel sends them SIGKILL when their parent ends."""
    _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


class Process:
    """A running program. It and all that it started end with `end`."""

    def __init__(self, command: Sequence[str], folder: Path, environment: dict[str, str] | None = None) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.folder = folder
        self._log = folder / "output.txt"
        try:
            with self._log.open("wb") as log:
                self._child = subprocess.Popen(  # noqa: S603
                    command,
                    cwd=folder,
                    env={**os.environ, **(environment or {})},
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=subprocess.STDOUT,
                    start_new_session=True,
                    preexec_fn=_end_with_parent,
                )
        except OSError as error:
            raise SitlError(f"{command[0]} does not start: {error.strerror}") from None

    @property
    def pid(self) -> int:
        """Its process id, which is also that of its process group."""
        return self._child.pid

    def check(self) -> None:
        """Raises SitlError with the end of its output if the program has ended."""
        status = self._child.poll()
        if status is not None:
            raise SitlError(f"{self._child.args[0]} ended with status {status}; the end of its output:\n{self.tail()}")

    def tail(self) -> str:
        """The last lines of its output."""
        with self._log.open("rb") as log:
            log.seek(max(0, log.seek(0, os.SEEK_END) - _TAIL_BYTES))
            lines = log.read().decode(errors="replace").splitlines()
        return "\n".join(lines[-_TAIL_LINES:])

    def end(self) -> None:
        """Ends the program and what it started. A simulated vehicle has nothing to save."""
        try:
            os.killpg(self._child.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        self._child.wait()
