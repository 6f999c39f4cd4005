# SPDX-License-Identifier: MIT
"""Size of the packages beside its bounds, which may only fall: ``python -m tools.ratchet [--lower]`` (`make lint`).

`ratchet.toml` holds the bounds. ``--lower`` writes today's sizes where they are smaller. Who raises a bound adds a line
with the reason under `raised`.
"""

import argparse
import ast
import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BOUNDS = Path(__file__).with_name("ratchet.toml")


def sources(folder: str) -> dict[Path, str]:
    """Return the Python files of a folder with their texts."""
    return {file: file.read_text(encoding="utf-8") for file in sorted((ROOT / folder).rglob("*.py"))}


def body(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Return the lines of a function without signature and docstring."""
    first = node.body[1:] if ast.get_docstring(node) is not None else node.body
    return (node.end_lineno or 0) - first[0].lineno + 1 if first else 0


def sizes() -> dict[str, float]:
    """Return today's sizes, by the names of `ratchet.toml`."""
    tool, engine = sources("pysprings"), sources("fe_engine")
    lines = [line for text in tool.values() for line in text.splitlines()]
    imports = sum(bool(re.match(r"\s*(import|from) ", line)) for line in lines)
    functions = [
        body(node) for text in (*tool.values(), *engine.values()) for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    ]  # fmt: skip
    documents = [file for file in (ROOT / "docs").rglob("*.md") if not {"gallery", "api"} & set(file.parts)]

    def count(*folders: str) -> int:
        return sum(len(text.splitlines()) for folder in folders for text in sources(folder).values())

    return {
        "pysprings_lines": len(lines), "pysprings_files": len(tool), "fe_engine_lines": count("fe_engine"),
        "import_share_pct": round(100.0 * imports / len(lines), 2), "longest_function": max(functions),
        "tests_lines": count("tests"), "benchmarks_and_tools_lines": count("benchmarks", "tools"),
        "docs_lines": sum(len(file.read_text(encoding="utf-8").splitlines()) for file in documents),
        "changelog_lines": len((ROOT / "CHANGELOG.md").read_text(encoding="utf-8").splitlines()),
    }  # fmt: skip


def main() -> int:
    """Print sizes and bounds; return 1 where one is exceeded."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--lower", action="store_true", help="lower the bounds to today's sizes")
    given, text, now = parser.parse_args(), BOUNDS.read_text(encoding="utf-8"), sizes()
    bounds = tomllib.loads(text)["bounds"]
    over = [name for name, bound in bounds.items() if now[name] > bound]
    for name, bound in bounds.items():
        print(f"{name:28} {now[name]:>8,} of {bound:,}{'  EXCEEDED' if name in over else ''}")
        if given.lower and now[name] < bound:
            text = re.sub(rf"(?m)^{name} = .*$", f"{name} = {now[name]}", text)
    if given.lower:
        BOUNDS.write_text(text, encoding="utf-8")
    return 1 if over else 0


if __name__ == "__main__":
    sys.exit(main())
