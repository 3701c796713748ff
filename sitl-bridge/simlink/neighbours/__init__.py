"""A second implementation of neighbour messages: it checks those of a swarm, or plays neighbours.

`message.py` is written from docs/messages.md and shares nothing with the on-board code.
"""
