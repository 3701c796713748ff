"""A fleet of simulated autopilots that speak MAVLink, written with pymavlink.

`python -m simlink` runs the fleet, `python -m simlink.neighbours` listens to what the
UAVs of a swarm tell each other, or plays ghosts among them. `docs/simlink.md` says
what is simulated and how to talk to it.
"""
