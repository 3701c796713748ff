"""The fleet's events, one JSON object a line."""

import json
from typing import Any, TextIO


class EventLog:
    """Writes events as JSON lines."""

    def __init__(self, out: TextIO | None) -> None:
        self._out = out

    def __call__(self, event: str, **fields: Any) -> None:
        """Writes one event."""
        if self._out is not None:
            line = json.dumps({"event": event, **fields}, separators=(",", ":"))
            self._out.write(line + "\n")
            self._out.flush()
