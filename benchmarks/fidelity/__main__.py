"""``python -m benchmarks.fidelity``."""

import sys

from benchmarks.fidelity.command import main

sys.exit(main())
