# SPDX-License-Identifier: MIT
"""`pysprings init`: a commented scene from a template, and the JSON schema beside it."""

from __future__ import annotations

import json
from pathlib import Path

from pysprings.core.errors import Problem, UserInputError
from pysprings.scene.fields import suggestion
from pysprings.scene.schema import FILE_NAME, scene_schema
from pysprings.scene.template_names import FOLDER, template_names


def template_text(name: str) -> str:
    """Return the text of a template, or refuse an unknown name."""
    known = template_names()
    if name not in known:
        hint = suggestion(name, known) or f" (there is: {', '.join(known)})"
        raise UserInputError([Problem(key="--template", message=f"no template '{name}'{hint}")])
    return (FOLDER / f"{name}.toml").read_text(encoding="utf-8")


def write_scene(file: Path, template: str, force: bool = False) -> list[Path]:
    """Write a scene and its schema; an existing scene is refused, an existing schema kept, unless `force`.

    Returns the files written.
    """
    text = template_text(template)
    schema = file.with_name(FILE_NAME)
    if file == schema:
        raise UserInputError([Problem(str(file), message="is the name of the schema; choose another for the scene")])
    if (file.exists() or file.is_symlink()) and not force:
        raise UserInputError(
            [Problem(str(file), message="exists already; choose another name, or --force to replace it")]
        )
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with file.open("w" if force else "x", encoding="utf-8", newline="\n") as stream:
            stream.write(text)
        if schema.exists() and not force:
            return [file]
        schema.write_text(
            json.dumps(scene_schema(), indent=2, ensure_ascii=False) + "\n", encoding="utf-8", newline="\n"
        )
    except OSError as error:
        message = f"cannot be written ({error.strerror})"
        raise UserInputError([Problem(str(error.filename or file), message=message)]) from None
    return [file, schema]
