# SPDX-License-Identifier: MIT
"""Where the project and its scenes are."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCENES = sorted((ROOT / "data" / "scenes").glob("*.toml"))
assert SCENES
