"""`python -m warp_softbody` is `warp-softbody`."""

from __future__ import annotations

import sys

from warp_softbody.cli import main

if __name__ == "__main__":
    sys.exit(main())
