"""`python -m simlink`."""

import sys

from simlink.cli import main

if __name__ == "__main__":
    sys.exit(main())
