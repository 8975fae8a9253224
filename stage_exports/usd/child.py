"""A stage from elsewhere is opened in this process: an order as JSON in, a pickle out."""

from __future__ import annotations

import json
import os
import pickle
import resource
import sys

from warp_softbody.errors import InputError
from warp_softbody.stage_exports.usd import watchdog
from warp_softbody.stage_exports.usd.isolation import guarded

HANDING_OVER = 600.0
"""s for the parent to take the answer."""


def main(order: str) -> None:
    """Do what the order says within its limits, and answer on what was standard output."""
    answer = os.dup(1)
    # libraries print; only the answer may reach the parent
    os.dup2(2, 1)
    wanted = json.loads(order)
    watchdog.start(wanted["seconds"])
    _limit(resource.RLIMIT_AS, wanted["memory"])
    _limit(resource.RLIMIT_CORE, 0)
    try:
        result = "done", guarded(wanted["task"], *wanted["arguments"])
    except InputError as error:
        result = "refused", str(error)
    except OSError as error:
        result = "failed", error.strerror or str(error)
    watchdog.start(HANDING_OVER)
    with os.fdopen(answer, "wb") as stream:
        pickle.dump(result, stream, protocol=pickle.HIGHEST_PROTOCOL)
    # what USD still holds of a damaged file need not be taken down
    os._exit(0)


def _limit(kind: int, value: int) -> None:
    """Lower a limit, never raise it."""
    _, hard = resource.getrlimit(kind)
    value = value if hard == resource.RLIM_INFINITY else min(value, hard)
    resource.setrlimit(kind, (value, hard))


if __name__ == "__main__":
    main(sys.argv[1])
