# SPDX-License-Identifier: MIT
"""How long the page of `pysprings explore` takes in Chromium: ``python -m benchmarks.page [RUN]``, else on an atlas.

First page: from the request to the first answer, of a server that has just begun. Answer: from a key on a slider to the
change of the page, median and largest of twelve. Seconds depend on the machine, and on what else it does.
"""

import shutil
import statistics
import subprocess
import sys
import time
from collections.abc import Sequence

SLIDERS = ("D", "su", "H", "arm")
KEYS = 6  # to the right, and back
WATCH = """() => {
    window.begun = 0; window.took = [];
    document.addEventListener('keydown', () => { window.begun = performance.now(); }, true);
    new MutationObserver(() => {
        if (window.begun) { window.took.push(performance.now() - window.begun); window.begun = 0; }
    }).observe(document.querySelector('#command'), {childList: true, subtree: true, characterData: true});
}"""


def main(argv: Sequence[str] | None = None) -> int:
    """Print the times of a page."""
    from playwright.sync_api import sync_playwright

    given = list(sys.argv[1:] if argv is None else argv) or ["--atlas", "clay"]
    line = [sys.executable, "-m", "pysprings", "explore", *given, "--port", "0"]
    start = time.perf_counter()
    with subprocess.Popen(line, stdout=subprocess.PIPE, text=True) as server, sync_playwright() as play:
        assert server.stdout is not None
        address = server.stdout.readline().strip()
        print(f"address     {time.perf_counter() - start:.2f} s after the command")
        page = play.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"]).new_page()
        start = time.perf_counter()
        page.goto(address)
        page.wait_for_selector("#number-u")
        print(f"first page  {time.perf_counter() - start:.2f} s")
        page.wait_for_timeout(2000)
        page.evaluate(WATCH)
        for name in SLIDERS:
            if not page.query_selector(f"#{name}-slider"):
                continue
            page.evaluate("() => { window.took = []; }")
            page.focus(f"#{name}-slider")
            for key in ("ArrowRight", "ArrowLeft"):
                for _ in range(KEYS):
                    page.keyboard.press(key)
                    page.wait_for_timeout(800)
            took = page.evaluate("window.took")
            print(f"answer {name:4s} {statistics.median(took):.0f} ms, at most {max(took):.0f} ms ({len(took)} keys)")
        server.terminate()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
