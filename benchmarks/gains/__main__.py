"""``python -m benchmarks.gains``."""

import sys

from benchmarks.gains.command import main

sys.exit(main())
