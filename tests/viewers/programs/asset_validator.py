"""Run by the Python that has omniverse-asset-validator: its findings of stages, as JSON."""

from __future__ import annotations

import json
import sys

from omni.asset_validator import IssueSeverity, ValidationEngine

SERIOUS = (IssueSeverity.FAILURE, IssueSeverity.ERROR)


def main(stages: list[str]) -> None:
    """Print the failures and errors of each stage by its path."""
    engine = ValidationEngine(init_rules=True)
    found = {
        stage: [
            f"{issue.rule.__name__ if issue.rule else '?'}: {issue.message}"
            for issue in engine.validate(stage).issues()
            if issue.severity in SERIOUS
        ]
        for stage in stages
    }
    print(json.dumps(found))


if __name__ == "__main__":
    main(sys.argv[1:])
