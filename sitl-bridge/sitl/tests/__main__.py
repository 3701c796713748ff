"""`python -m sitl.tests`: all tests, with a closing line like cargo's, which the test run counts."""

import logging
import sys
import unittest
from pathlib import Path


def main() -> int:
    """Runs them; returns the exit status."""
    logging.disable()
    here = Path(__file__).parent
    suite = unittest.defaultTestLoader.discover(str(here), top_level_dir=str(here.parent.parent))
    runner = unittest.TextTestRunner(stream=sys.stdout, verbosity=2)
    result = runner.run(suite)
    failed = len(result.failures) + len(result.errors) + len(result.unexpectedSuccesses)
    passed = result.testsRun - failed - len(result.skipped) - len(result.expectedFailures)
    word = "FAILED" if failed else "ok"
    print(f"test result: {word}. {passed} passed; {failed} failed; {len(result.skipped)} ignored")
    return 1 if failed or not passed else 0


if __name__ == "__main__":
    sys.exit(main())
