"""`python -m sitl`: a fleet of real autopilots."""

import sys

from sitl.fleet import main

sys.exit(main())
