"""A second implementation of what UAVs of a swarm tell each other: it listens and checks, or plays neighbours.

`message.py` is written from docs/messages.md and shares nothing with the on-board code.
"""
