"""Real autopilot firmware in simulation (ArduPilot's SITL, PX4's SITL with its built-in vehicle) as a fleet.

`python -m sitl` starts one process of the user's own build for each vehicle, observes them over a second MAVLink link
of each, and speaks the line protocol of simlink (docs/simlink.md). `python -m sitl.acceptance` flies the acceptance
suite. The builds are the user's: nothing of the autopilots is kept here.
"""
