# SPDX-License-Identifier: MIT
"""Long texts that users see, beside the tests that make them: every line, as somebody has read it.

``RENEW_TEXTS=1 pytest FILE`` writes them anew. What has changed is in the diff of the commit, to be read there.
"""

import os
from collections.abc import Iterable
from difflib import unified_diff
from pathlib import Path

RENEW = "RENEW_TEXTS"


def compare(lines: Iterable[str], file: Path, about: str) -> None:
    """Compare lines with a file whose first line says what it holds; fail with the lines that differ."""
    made = [f"# {about}; renewed by {RENEW}=1 pytest, then read", *"\n".join(lines).split("\n")]
    made = [line.rstrip() for line in made]
    if os.environ.get(RENEW):
        file.parent.mkdir(exist_ok=True)
        file.write_text("\n".join(made) + "\n", encoding="utf-8")
    kept = file.read_text(encoding="utf-8").splitlines()
    assert len(kept) > 1
    different = list(unified_diff(kept, made, "stored", "made", lineterm="", n=0))
    assert not different, "\n".join([str(file), *different[:40]])
