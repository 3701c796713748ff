"""What an instance is told of its vehicle."""

from dataclasses import dataclass


@dataclass(frozen=True)
class VehicleSpec:
    """One vehicle of a fleet; `lat`, `lon` in degrees, `alt` in m above the sea, are its home."""

    index: int
    system: int
    lat: float
    lon: float
    alt: float
    node_port: int
    """UDP port of the node on this computer."""
    observer_port: int
    """UDP port of the observer on this computer."""
    node_link: str = ""
    """Another link to the node than UDP to `node_port`, in the autopilot's own notation."""

    @property
    def link(self) -> str:
        """The link to the node, in ArduPilot's notation."""
        return self.node_link or f"udpclient:127.0.0.1:{self.node_port}"
