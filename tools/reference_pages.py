# SPDX-License-Identifier: MIT
"""Make the generated pages of docs/reference: ``python -m tools.reference_pages`` (`make pages`).

Commands come from the command-line program, outputs and pictures from the registries, scene keys from the JSON
schema, variables from `pysprings.core.variables`.
"""

import inspect
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal, get_args, get_origin, get_type_hints

from typer.models import ArgumentInfo, OptionInfo

from pysprings.cli.app import application
from pysprings.core.storage import write_text
from pysprings.core.text import markdown_table
from pysprings.core.variables import GROUPS
from pysprings.core.version import __version__
from pysprings.results.exporters import EXPORTERS
from pysprings.results.plots import PICTURES
from pysprings.results.report.page import REPORT_TABLES
from pysprings.scene.template import scene_schema

PAGES = Path(__file__).resolve().parents[1] / "docs" / "reference"
MARK = f"<!-- Made by `make pages` from version {__version__} of the program. Do not edit. -->\n\n"
COMMON = 3  # commands with the same option, which the page of commands states once
GROUP_TITLES = {
    "result_root": "full_model.nc, root",
    "result_path": "full_model.nc, paths/NAME",
    "extrapolated": "full_model.nc, paths/NAME/extrapolated",
    "space_path": "full_model.nc, space/NAME",
    "section": "full_model.nc, section",
    "volume": "full_model.nc, volume",
    "convergence": "full_model.nc, paths/NAME/convergence",
    "springs_root": "springs.nc, root",
    "springs_path": "springs.nc, paths/NAME",
    "prediction": "answers of predict, curve, impose, sequence",
    "space_prediction": "answers of springs in space",
}


def commands_page() -> str:
    """Return the page of the commands with all options, from the signatures of their functions."""
    pages, every = [], Counter[tuple[str, str]]()
    for command in application().registered_commands:
        assert command.callback is not None
        name = command.name or command.callback.__name__.replace("_", "-")
        hints = get_type_hints(command.callback, include_extras=True)
        own = inspect.signature(command.callback).parameters.values()
        given = [
            (each.default, _spelling(each.name, *(found := _annotation(hints[each.name]))), found[1]) for each in own
        ]
        arguments = [word for _, word, info in given if isinstance(info, ArgumentInfo)]
        rows = [(f"`{word}`", _words(info.help or "") + _preset(default)) for default, word, info in given]
        every.update(row for row in rows if row[0].startswith("`--"))
        pages.append((name, " ".join(["pysprings", name, *arguments]), inspect.getdoc(command.callback) or "", rows))
    common = {row: None for row, count in every.items() if count >= COMMON}
    parts = [
        MARK,
        "# Commands\n\nData go to stdout, messages to stderr. `--json` prints one JSON document. "
        "[Exit codes](exit-codes.md) are the same for all commands. Options of several commands:\n\n",
        markdown_table(["option", "meaning"], [*common]),
    ]
    for name, line, words, rows in pages:
        shared = ", ".join(row[0] for row in rows if row in common)
        parts.append(f"\n## {name}\n\n`{line} [OPTIONS]`\n\n{_words(words)}\n\n")
        parts.append(markdown_table(["option", "meaning"], [row for row in rows if row not in common]))
        parts.append(f"\nAlso {shared}.\n" if shared else "")
    return "".join(parts)


def scene_page() -> str:
    """Return the page of the keys of a scene file."""
    parts = [
        MARK,
        "# Scene keys\n\nDimensional values are strings with a unit; ranges are in brackets. "
        "[Scene file](../guide/scene.md) explains the format.\n",
    ]
    schema = scene_schema()["properties"]
    for name, table in schema.items():
        if "properties" not in table.get("items", table):
            rows = [[f"`{name}`", _words(table["description"]), _type(table), _default(table)]]
            parts.append(f"\n## Top level\n\n{markdown_table(_HEADS, rows)}")
            continue
        heading = f"[[{name}]]" if table.get("type") == "array" else f"[{name}]"
        own = table.get("items", table)
        parts.append(f"\n## {heading}\n\n{_section(own)}")
        for inner, each in table.get("properties", {}).items():
            if "properties" in each.get("items", {}):
                parts.append(f"\n## [[{name}.{inner}]]\n\n{_section(each['items'], {heading: own})}")
    return "".join(parts)


def variables_page() -> str:
    """Return the page of the variables of all datasets."""
    parts = [
        MARK,
        "# Variables\n\nUnits are UDUNITS texts as in the files. A variable marked * is optional. "
        "[Axes and signs](../theory/axes.md) defines the axes.\n",
    ]
    first: dict[Any, str] = {}
    for name, group in GROUPS.items():
        rows, known, title = [], {}, GROUP_TITLES.get(name, name)
        for each in group.values():
            said, star = (each.name, each.long_name, each.units, each.dims, each.comment), "" if each.required else " *"
            if said in first:
                known.setdefault(first[said], []).append(f"`{each.name}`{star}")
            else:
                first[said] = title
                rows.append(
                    [f"`{each.name}`{star}", each.long_name, f"`{each.units}`", ", ".join(each.dims), each.comment]
                )
        parts.append(f"\n## {title}\n\n")
        if rows:
            parts.append(
                markdown_table(["variable", "meaning", "unit", "dimensions", "sign, remark"], rows) + "\n" * bool(known)
            )
        parts += [f"As in {where}: {', '.join(names)}.\n" for where, names in known.items()]
    return "".join(parts)


def outputs_page() -> str:
    """Return the page of the exporters, with their options, and of tables of the report."""
    rows = [
        [f"`{each.name}`", _words(each.description), f"`{each.file}`" if each.file else "several",
         ", ".join(f"`{suffix}`" for suffix in each.suffixes), each.needs]
        for each in EXPORTERS
    ]  # fmt: skip
    parts = [
        MARK,
        "# Outputs\n\nOther packages can add to each of these tables; [Extend](../develop/extend.md) shows how.\n",
        "\n## Exports\n\n`pysprings export RESULT --to NAME`, and `pysprings springs RESULT --format NAME` for the "
        f"files of springs.\n\n{markdown_table(['name', 'content', 'file', 'endings', 'needs'], rows)}",
    ]
    options: dict[tuple[str, str], list[str]] = {}
    for each in EXPORTERS:
        for option in each.options:
            words = f"`{each.name}`{_preset(None if option.default == '' else option.default)}"
            options.setdefault((f"`{option.name}`", _words(option.help)), []).append(words)
    own = [[*option, ", ".join(names)] for option, names in options.items()]
    parts.append(f"\n### Options of exports\n\n{markdown_table(['option', 'meaning', 'of'], own)}")
    sections: dict[str, list[str]] = {}
    for table in REPORT_TABLES:
        sections.setdefault(table.section, []).append(f"`{table.name}`")
    listed = "; ".join(f"{section}: {', '.join(names)}" for section, names in sections.items())
    parts.append(f"\n## Tables of the report\n\nBy section. {listed}.\n")
    return "".join(parts)


PICTURES_HEAD = """# Pictures

`tree` is a result (`pysprings.run`, `open_result`) or springs (`extract_springs`, `open_springs`, `open_table`). Each
call returns a figure, and takes `figure=`: a figure, or a part of one, to draw on. `plots.draw(tree, NAME, ...)` is the
same by name. [Notebooks](../start/notebook.md) has examples.

Panels on axes of yours: `plots.draw_py(axes, path)`, `draw_profile`, `draw_secant`, `draw_tilt`, `draw_paths`. Runs
over each other: `plots.overlay({"a": tree, "b": other}, path)`, and `pysprings diff --out`.

A run writes them into `figures/`, where the data are there. STATE is `last`, or `2.5mm` for the step at u = 2.5 mm.
`--figures report`, the default, draws those that the report shows, of the path that stands for all and its last state;
`all` draws every path of a few, of many the first of each kind and role. PNG, 100 dots an inch; `--figure-format` has
others.
"""


def pictures_page() -> str:
    """Return the page of the pictures: a small picture where there is one, caption, call, and function."""
    rows = []
    for each in PICTURES:
        function, fixed = getattr(each.function, "func", each.function), getattr(each.function, "keywords", {})
        scope = {"run": [], "path": ["path"], "state": ["path", "step=...", "displacement=..."]}[each.scope]
        own = [
            f"{key}=..." for key, value in inspect.signature(function).parameters.items()
            if value.default is not inspect.Parameter.empty and key not in ("step", "displacement", *fixed)
        ]  # fmt: skip
        shown = f"![{each.name}](pictures/{each.name}.png)" if (PAGES / f"pictures/{each.name}.png").exists() else ""
        drawn = f"{_SCOPES[each.scope].replace('NAME', each.name)}, by `{'report' if each.section else 'all'}`"
        call = f"`tree.pysprings.plot.{each.name}({', '.join([*scope, *own])})`; `plots.{function.__name__}`"
        about = _words(inspect.getdoc(function) or "").split(" Parameters ---")[0]
        rows.append([shown, f"**{each.name}**: {each.caption.rstrip('.')}. {drawn}. {call}: {about}"])
    return f"{MARK}{PICTURES_HEAD}\n{markdown_table(['picture', 'name, file, call, content'], rows)}"


_SCOPES = {"run": "`NAME.png`", "path": "`PATH_NAME.png`", "state": "`PATH_NAME_STATE.png`"}
_HEADS = ["key", "meaning", "value", "default"]


def _section(table: Mapping[str, Any], above: Mapping[str, Any] | None = None) -> str:
    """Return the words and keys of one table of the scene; keys that are those of a table above by their names."""
    rows, words = _keys(table), ""
    for heading, other in (above or {}).items():
        same = [row[0] for row in rows if row in _keys(other)]
        rows = [row for row in rows if row[0] not in same]
        words = f"\nAs in {heading}: {', '.join(same)}.\n"
    return f"{_words(table['description'])}\n\n{markdown_table(_HEADS, rows)}{words}"


def _keys(table: Mapping[str, Any]) -> list[list[str]]:
    """Return key, meaning, value and default of the keys of a table of the scene."""
    required = table.get("required", [])
    return [
        [f"`{key}`", _words(value.get("description", "")), _type(value),
         "required" if key in required else _default(value)]
        for key, value in table["properties"].items()
        if "properties" not in value.get("items", {})
    ]  # fmt: skip


def _type(value: Mapping[str, Any]) -> str:
    """Return what a key may hold: choices, an example of a quantity, or the type."""
    return " or ".join(dict.fromkeys(_types(value)))


def _types(value: Mapping[str, Any]) -> Iterator[str]:
    if "const" in value:
        yield f'`"{value["const"]}"`'
    elif "enum" in value:
        yield ", ".join(f'`"{each}"`' if isinstance(each, str) else f"`{each}`" for each in value["enum"])
    elif "anyOf" in value:
        for each in value["anyOf"]:
            yield from _types({**each, **({"examples": value["examples"]} if "examples" in value else {})})
    elif value.get("type") == "string" and value.get("examples"):
        yield f'such as `"{value["examples"][0]}"`'
    else:
        kind = value.get("type", "value")
        yield {"array": "list", "boolean": "`true`, `false`"}.get(kind, kind)


def _default(value: Mapping[str, Any]) -> str:
    if "default" not in value:
        return ""
    default = value["default"]
    if isinstance(default, bool):
        return f"`{str(default).lower()}`"
    return f'`"{default}"`' if isinstance(default, str) else f"`{default}`"


def _annotation(hint: Any) -> tuple[Any, Any]:
    """Return the type of a parameter and what Typer was given for it."""
    kind, *extras = get_args(hint)
    return kind, next(each for each in extras if isinstance(each, ArgumentInfo | OptionInfo))


def _spelling(name: str, kind: Any, info: Any) -> str:
    """Return how an argument or option is written, with what it takes."""
    if isinstance(info, ArgumentInfo):
        return str(info.metavar or name.upper())
    given = [each for each in (info.default, *(info.param_decls or ())) if isinstance(each, str)]
    option = next((each for each in given if each.startswith("--")), f"--{name.replace('_', '-')}")
    parts = (kind, *get_args(kind))
    kinds = [each for each in parts if isinstance(each, type)]
    if bool in kinds:
        return str(option)
    words = next((get_args(each) for each in parts if get_origin(each) is Literal), ())
    taken = "|".join(words) if words else (info.metavar or kinds[0].__name__.upper()).strip("[]")
    return f"{option} {taken}"


def _preset(default: Any) -> str:
    """Return the default of an option as a remark; nothing for a flag, or without one."""
    if default is inspect.Parameter.empty or default is None or isinstance(default, bool | list):
        return ""
    return f" (default `{default}`)"


def _words(text: str) -> str:
    """Return a help text in one line; angle brackets and brackets stay text in Markdown."""
    return " ".join(text.replace("\\[", "[").split()).replace("<", "&lt;")


def pages() -> dict[str, str]:
    """Return file name -> text of the generated pages."""
    return {
        "commands.md": commands_page(),
        "outputs.md": outputs_page(),
        "pictures.md": pictures_page(),
        "scene-keys.md": scene_page(),
        "variables.md": variables_page(),
    }


if __name__ == "__main__":
    for name, text in pages().items():
        print(write_text(text, PAGES / name))
