# SPDX-License-Identifier: MIT
"""Scene files: TOML text -> `Scene`, or every problem at once with file, line, column and key."""

import copy
import hashlib
import os
import re
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath
from stat import S_ISREG
from typing import Any, NoReturn, Self

import numpy as np
from pydantic import ValidationError

from pysprings.core.errors import Problem, UserInputError
from pysprings.core.text import suggestion
from pysprings.core.units import quoted
from pysprings.core.words import ESTIMATES
from pysprings.scene import sections
from pysprings.scene.by_depth import STRONGER, WEAKER, ByDepth, disordered, incomplete, picked, ranges_in, take_estimate
from pysprings.scene.changes import OPTION, Change, applied, named, names_of, read_changes
from pysprings.scene.checks import dotted
from pysprings.scene.design_load import Design, take_cases
from pysprings.scene.fields import FROM_TOML
from pysprings.scene.layers import untaken
from pysprings.scene.model import Scene
from pysprings.scene.positions import KeyPath, Place, TooDeep, locate, nearest, refuse_depth
from pysprings.scene.profile_table import key_of, read_layers
from pysprings.scene.soils.cyclic import CYCLIC, read_files, titled

MAX_BYTES = 256 * 1024

SECTIONS: dict[str, type[sections.Section]] = {
    "caisson": sections.Caisson,
    "domain": sections.Domain,
    "soil": sections.Soil,
    "interface": sections.Interface,
    "drainage": sections.Drainage,
    "springs": sections.Springs,
    "path": sections.Path,
    "mesh": sections.Mesh,
    "solver": sections.Solver,
    "limit": sections.Limit,
    "design": Design,
    "output": sections.Output,
}


@dataclass(frozen=True)
class Fault:
    """Something wrong at the first of these key paths; the others are involved too."""

    paths: tuple[KeyPath, ...]
    message: str
    at_key: bool = False  # the place to show is that of the key, not of its value
    meant: str = ""  # the key that was probably meant by an unknown one


def load_scene(path: str | os.PathLike[str], changes: Sequence[str] = ()) -> Scene:
    """Read a scene file; changes, such as `soil.young_modulus="80 MPa"`, replace values of it.

    Raises
    ------
    UserInputError
        One problem per thing that is wrong with the file, in the order of the file.
    """
    return parse_scene(read_text(FilePath(path)), str(path), changes)


def parse_scene(text: str, file: str | None = None, changes: Sequence[str] = ()) -> Scene:
    """Read a scene from TOML text; `file` is its name in messages, `changes` are those of `load_scene`."""
    return SceneText(text, file).scene(read_changes(changes))


class SceneText:
    """The text of a scene file, read once: `scene` returns it with values changed, as often as asked.

    Raises UserInputError where the text is no TOML.
    """

    def __init__(self, text: str, file: str | None = None) -> None:
        self.text, self.file = text, file
        self._data, self._places = toml_of(text, file)
        self._profile, self._in_table = _read_profile(self._data, self._places, file)

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Self:
        """Return the text of a scene file."""
        return cls(read_text(FilePath(path)), str(path))

    @property
    def has_ranges(self) -> bool:
        """Whether a value of the scene, or of its table of layers, has a range."""
        return any(ranges_in(self._data))

    @property
    def layers(self) -> list[str]:
        """Names of the layers, as changes have them; none of a scene without layers."""
        soil = self._data.get("soil")
        tables = soil.get("layer") if isinstance(soil, dict) else None
        return names_of(tables) if isinstance(tables, list) else []

    @property
    def ranges(self) -> list[tuple[tuple[str, ...], dict[str, Any]]]:
        """Keys and tables of the ranges, keys as changes name them. Raises UserInputError, see `changes.named`."""
        return [(named(self._data, keys), table) for keys, table in ranges_in(self._data)]

    def scene(self, changes: Sequence[Change] = ()) -> Scene:
        """Return the scene with values changed; its title names an estimate that is chosen.

        Raises UserInputError with every problem.
        """
        data = copy.deepcopy(self._data)
        changed = applied(data, changes)
        if not data:
            _refuse(self.file, "the file is empty; `pysprings init` writes a commented scene")
        folder = FilePath(self.file).parent if self.file else FilePath()
        if self.has_ranges and not any(ranges_in(data)) and isinstance(data.get("soil"), dict):
            data["soil"].pop("estimate", None)  # changes have taken the place of all ranges
        from_files, problems = read_files(data.get("soil"), folder)
        of_cases, in_cases = take_cases(data, folder)
        in_tables = [*self._in_table, *problems, *in_cases]
        estimates, wrong = take_estimate(data, Scene.model_fields["title"].default)
        faults = {Fault((keys,), message): "" for keys, message in (*incomplete(data), *disordered(data), *of_cases)}
        if wrong and not in_tables:
            faults[Fault((("soil", "estimate"),), wrong)] = ""
        scenes = []
        for estimate in estimates:
            try:
                values = picked(data, estimate)
                scenes.append(Scene.model_validate(values, context=FROM_TOML, by_alias=True, by_name=False))
            except ValidationError as error:
                found = _faults_of_values(error) if in_tables else _all_faults(values, error)
                faults |= {fault: estimate for fault in found if fault not in faults}
        if len(scenes) == len(ESTIMATES) and not faults:
            faults = dict.fromkeys(_crossed(data, dict(zip(estimates, scenes, strict=True))), "")
        if faults:
            problems = [
                _problem(fault, self._places, self.file, changed, "" if estimate in ("", estimates[0]) else estimate)
                for fault, estimate in faults.items()
            ]
            problems = sorted(problems, key=lambda each: (each.line or 0, each.col or 0))
            raise UserInputError([*problems, *in_tables])
        if in_tables:
            raise UserInputError(in_tables)
        scene = scenes[0]
        _refuse_without_effect(scene, changed)
        cyclic = [stratum.tables.get(CYCLIC) for stratum in scene.ground.strata]
        scene = scene.model_copy(update={"title": titled(scene.title, [each for each in cyclic if each])})
        if len(scenes) > 1:
            scene._of_ranges, scene._estimate = _digest(scenes), estimates[0]
        # a scene of a profile, contours or load cases is written with their values: it needs no other file then
        if not (self._profile or from_files or changed or scene.design.cases):
            scene._source = (self.text, scene.sha256)
        return scene


def _refuse_without_effect(scene: Scene, changed: Sequence[KeyPath]) -> None:
    """Refuse changed values of [soil] that no layer takes: the scene would be that without them."""
    idle = untaken(scene.soil)
    lost = [keys for keys in changed if keys[0] == "soil" and {*keys[1:2]} & idle]
    if lost:
        text = "no layer takes it: each has its own; change that of a layer, soil.layer.NAME.{}"
        names = [str(_LAW.get(str(keys[1]), keys[1])) for keys in lost]
        problems = zip(lost, names, strict=True)
        raise UserInputError([Problem(OPTION, key=dotted(keys), message=text.format(name)) for keys, name in problems])


def _digest(scenes: Sequence[Scene]) -> str:
    """Return the digest of estimates, whichever is chosen; titles, which name it, and what is written do not count."""
    plain = [each.model_copy(update={"title": "", "output": sections.Output()}).sha256 for each in scenes]
    return hashlib.sha256(" ".join(sorted(plain)).encode()).hexdigest()


def _crossed(data: dict[str, Any], scenes: dict[str, Scene]) -> Iterator[Fault]:
    """Yield the ranges by depth that are in order at the top of a layer (see `disordered`), but not at its bottom.

    ``scenes`` are by estimate. Values by stress have their order from their reference alone.
    """
    strata = [[each for each in scenes[name].ground.strata if not each.like] for name in ESTIMATES]
    for keys, _ in ranges_in(data):
        key = next((str(each) for each in reversed(keys) if each in (*WEAKER, *STRONGER)), "")
        for k, layers in enumerate(zip(*strata, strict=False)):
            values = [each.values.get(key) for each in layers]
            depths = [each for each in values if isinstance(each, ByDepth)]
            other = keys[1:2] == ("layer",) and keys[2] != k
            if other or None in values or not depths or any(each.reference_stress is not None for each in depths):
                continue
            end = min(each.bottom for each in layers)
            found = [float(each.value(key, np.array(end))) for each in layers]
            if found != sorted(found, reverse=key in WEAKER):
                shown = ", ".join(f"{each:g}" for each in found)
                yield Fault((keys,), f"low, best and high cross in the layer: {shown} (SI) at {end:g} m below mudline")
                break


def _read_profile(
    data: dict[str, Any], places: dict[KeyPath, Place], file: str | None
) -> tuple[bool, Sequence[Problem]]:
    """Put the layers of `soil.profile` into the data; return whether there is one, and what is wrong with its table.

    Its path is relative to the file.
    """
    soil = data.get("soil")
    if not isinstance(soil, dict) or "profile" not in soil:
        return False, ()
    name, at = soil.pop("profile"), places[("soil", "profile")].value
    if not isinstance(name, str) or "layer" in soil:
        wrong = "give soil.profile or [[soil.layer]], not both" if "layer" in soil else "expected the name of a table"
        raise UserInputError([Problem(file, *at, "soil.profile", wrong)])
    folder = FilePath(file).parent if file else FilePath()
    try:
        soil["layer"] = read_layers(folder / name, soil)
    except UserInputError as error:
        return True, error.problems
    return True, ()


def _refuse(file: str | None, message: str, line: int | None = None, col: int | None = None) -> NoReturn:
    raise UserInputError([Problem(file, line, col, message=message)]) from None


def toml_of(text: str, file: str | None) -> tuple[dict[str, Any], dict[KeyPath, Place]]:
    """Return the data of TOML text, and the places of its keys. Raises UserInputError."""
    try:
        refuse_depth(text)
        return _parse_toml(text, file), locate(text)
    except TooDeep as error:
        _refuse(file, str(error), *error.place)
    except RecursionError:
        _refuse(file, "lists or tables are nested too deeply")


def read_text(path: FilePath, what: str = "scene") -> str:
    """Read a small regular UTF-8 file, a scene or ``what``; raise UserInputError for any other."""
    name = str(path)
    try:
        status = path.stat()
        if path.is_dir():
            _refuse(name, f"is a folder, not a {what} file")
        if not S_ISREG(status.st_mode):
            _refuse(name, "is not a regular file")
        if status.st_size > MAX_BYTES:
            _refuse(name, f"is too large for a {what} (more than {MAX_BYTES // 1024} KiB)")
        return path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        _refuse(name, "no such file")
    except UnicodeDecodeError as error:
        start = error.object[: error.start].rfind(b"\n") + 1
        line = error.object.count(b"\n", 0, error.start) + 1
        col = len(error.object[start : error.start].decode("utf-8", "replace")) + 1
        _refuse(name, f"is not UTF-8 text (byte 0x{error.object[error.start]:02x})", line, col)
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        _refuse(name, f"cannot be read ({getattr(error, 'strerror', None) or error})")


def _parse_toml(text: str, file: str | None) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except ValueError as error:  # TOMLDecodeError, and that of int() for thousands of digits
        message = str(error)
    match = re.search(r" \(at (?:line (\d+), column (\d+)|end of document)\)$", message)
    if match is None:
        _refuse(file, f"not valid TOML: {message.split(';')[0]}", 1, 1)
    lines = text.split("\n")
    line, col = (int(match[1]), int(match[2])) if match[1] else (len(lines), len(lines[-1]) + 1)
    _refuse(file, f"not valid TOML: {message[: match.start()]}{_quotes_hint(lines[line - 1])}", line, col)


def _quotes_hint(line: str) -> str:
    """Return a hint when a line holds a quantity without quotes."""
    bare = re.fullmatch(r"[^=\"']*=\s*([+-]?[0-9.]+(?:e[+-]?[0-9]+)?\s*[A-Za-z°][^\"'#]*?)\s*(?:#.*)?", line.strip())
    return f' (a quantity needs quotes: "{bare[1]}")' if bare else ""


def _all_faults(data: dict[str, Any], error: ValidationError) -> list[Fault]:
    """Collect wrong fields, and then what clashes among the fields that are right."""
    faults = list(_faults(error))
    dropped = {path for fault in faults for path in _spoiled(fault, data)}
    if any(_is_clash(item) for item in error.errors()):
        return faults
    try:
        Scene.model_validate(_without(data, faults), context=FROM_TOML, by_alias=True, by_name=False)
    except ValidationError as second:
        for fault in _faults(second):
            if not any(key[: len(path)] == path for key in fault.paths for path in dropped):
                faults.append(fault)
    return faults


def _faults_of_values(error: ValidationError) -> list[Fault]:
    """Return what is wrong with single values: what goes together is open where the layers are not known."""
    return [] if any(_is_clash(item) for item in error.errors()) else [*_faults(error)]


def _is_clash(item: Any) -> bool:
    return "clashes" in item.get("ctx", {})


def _faults(error: ValidationError) -> Iterator[Fault]:
    """Translate pydantic's errors."""
    for item in error.errors(include_url=False):
        path: KeyPath = tuple(item["loc"])
        context = item.get("ctx", {})
        if "clashes" in context:
            yield from (Fault(clash.keys, clash.message) for clash in context["clashes"])
        elif "entries" in context:
            yield from (Fault(((*path, index),), message) for index, message in context["entries"])
        elif item["type"] == "extra_forbidden":
            yield _unknown_key(path)
        elif item["type"] == "missing":
            yield Fault((path,), f"missing; every {_header(path)} needs it", at_key=True)
        elif item["type"] == "scene":
            yield Fault((path,), context["message"])
        else:
            lists: dict[KeyPath, str] = {("path",): "[[path]]", ("soil", "layer"): "[[soil.layer]]"}
            expected = f"{lists[path]} sections (double brackets)" if path in lists else f"a table {_header(path)}"
            yield Fault((path,), f"expected {expected}")


def _header(path: KeyPath) -> str:
    if path[:2] == ("soil", "layer"):
        return "[[soil.layer]]"
    return "[[path]]" if path[0] == "path" else f"[{dotted(path)}]"


def _keys(section: type[sections.Section]) -> list[str]:
    """Return the keys of a table as TOML has them."""
    return [str(info.validation_alias or name) for name, info in section.model_fields.items()]


_LAW = {"law": "yield_surface", "yield_surface": "law"}  # of [soil] and of a layer


def _unknown_key(path: KeyPath) -> Fault:
    """Return the message on an unknown key, with the most similar valid one."""
    if path == ("soil", "profile"):  # `_read_profile` has taken that of the file
        return Fault((path,), "names a table that is read with the file: give it there, or values of its layers here")
    name = str(path[-1])
    section = sections.Layer if path[:2] == ("soil", "layer") else SECTIONS.get(str(path[0]))
    known = _keys(section) if len(path) > 1 and section else ["title", *SECTIONS]
    homes = [_header((section,)) for section, model in SECTIONS.items() if name in _keys(model)]
    same = key_of(name) or _LAW.get(name) if path[0] == "soil" else None
    meant = f" (did you mean '{same}'?)" if same in known else suggestion(name, known)
    near = re.search(r"'(.*)'", meant)
    hint = f" (it belongs in {' or '.join(homes)})" if homes and same not in known else meant
    return Fault((path,), f"unknown key{hint}", at_key=True, meant=near[1] if near else "")


def _spoiled(fault: Fault, data: dict[str, Any]) -> Iterator[KeyPath]:
    """Give the key paths whose value is not known because of a fault: of a layer or law, ground and contact."""
    path = fault.paths[0]
    layer = path[:2] == ("soil", "layer")
    if (layer and (len(path) < 4 or path[3] in ("top", "law"))) or path == ("soil", "yield_surface"):
        yield from (("soil",), ("interface",))
    entry = len(path) == (4 if path[0] == "path" else 3) and isinstance(path[-1], int)  # it spoils its list
    yield path[:-1] if entry else path
    if fault.meant and fault.meant not in _table(data, path[:-1]):
        yield (*path[:-1], fault.meant)


def _table(data: dict[str, Any], path: KeyPath) -> Any:
    """Return the table at a key path."""
    table: Any = data
    for part in path:
        table = table[part]
    return table


def _without(data: dict[str, Any], faults: list[Fault]) -> dict[str, Any]:
    """Copy the data without its wrong keys (their defaults step in), so that the rest can be checked."""
    rest = copy.deepcopy(data)
    for fault in faults:
        path = fault.paths[0]
        if path[:2] == ("soil", "layer"):
            _without_layer_key(rest["soil"], path)
            continue
        path = path[: 3 if path[0] == "path" else 2]
        table = _table(rest, path[:-1])
        if path[0] == "path" and len(path) == 2:
            table[path[1]] = {"name": f"unnamed{path[1]}", "kind": "pull"}
        elif path[0] == "path" and path[-1] in ("name", "kind"):
            table[path[-1]] = f"unnamed{path[1]}" if path[-1] == "name" else "pull"
        else:
            table.pop(path[-1], None)
    return rest


def _without_layer_key(soil: dict[str, Any], path: KeyPath) -> None:
    """Drop a wrong key of a layer; all layers where the fault leaves the order of them open."""
    if len(path) < 4 or path[3] == "top":
        soil.pop("layer", None)
    elif "layer" in soil:
        soil["layer"][path[2]].pop(path[3], None)


def _problem(
    fault: Fault, places: dict[KeyPath, Place], file: str | None, changed: Sequence[KeyPath] = (), estimate: str = ""
) -> Problem:
    """Give a fault its place: that of the first of its keys that stands in the file, or the option that changed it.

    ``estimate`` is the one of a range that has the fault, where it is not that of the scene.
    """
    message = f"{fault.message} (estimate {quoted(estimate)})" if estimate else fault.message
    if any(fault.paths[0][: len(keys)] == keys for keys in changed):
        return Problem(OPTION, key=dotted(fault.paths[0]), message=message)
    there = next((path for path in fault.paths if path in places), fault.paths[0])
    place = nearest(places, there)
    line, col = place.key if fault.at_key else place.value
    return Problem(file, line, col, dotted(fault.paths[0]), message)
