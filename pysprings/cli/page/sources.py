# SPDX-License-Identifier: MIT
"""What the page explores: a run, whose caisson and ground are fixed, or an atlas with inputs for both."""

from __future__ import annotations

import math
import shlex
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pysprings.core.errors import PyspringsError
from pysprings.core.text import number

if TYPE_CHECKING:
    import xarray as xr

    from pysprings.scene.model import Scene
    from pysprings.studies.atlas.model import Atlas

Values = Mapping[str, float | None]  # of inputs, in the units that they show; None: blank

DIAMETERS = (2.0, 20.0)  # m, of the slider
SPAN = 5.0  # factor from the start of a slider to its ends; what the atlas does not cover is refused


@dataclass(frozen=True)
class Field:
    """An input: name, unit, tip, value at the start (None: blank), ends of its slider (None: it has none).

    `pause` : time [s] for which the slider rests before it is answered.
    """

    name: str
    unit: str
    tip: str
    start: float | None
    ends: tuple[float, float] | None = None
    pause: float = 0.1

    @property
    def step(self) -> float:
        """Step of the slider: a power of ten, at least 100 of them."""
        low, high = self.ends or (0.0, 1.0)
        return 10.0 ** math.floor(math.log10(max(high - low, 1e-9) / 100.0))

    def text(self, value: float) -> str:
        """Return a value with its unit, as options and scenes take it."""
        return f"{value:.12g} {self.unit}".strip()


H = Field("H", "MN", "lateral load; at first half of the largest known one", None, (0.0, 1.0), 0.02)
ARM = Field("arm", "m", "its height above mudline", 10.0, (0.0, 100.0), 0.02)
M = Field("M", "MN m", "moment about the lid centre, in place of the height; blank: H times the height", None)
V = Field("V", "MN", "vertical load, down; blank: that of the springs", None)
RATE = Field("rate", "mm/s", "of rho = |(u, rotation*L)|, between those of the springs", None)


@dataclass(frozen=True)
class RunSource:
    """A folder of a run, or a file of springs: caisson and ground are fixed.

    Methods take the values of all inputs: `key` is what the springs depend on, `facts` are names and texts beside the
    inputs, `options` the arguments of `pysprings predict` before the load. `read` is None for a scene that this version
    cannot read.
    """

    place: Path
    tree: xr.DataTree
    read: Scene | None
    title: str
    fields: tuple[Field, ...] = ()
    load_fields: tuple[Field, ...] = (H, ARM, M, V)

    @classmethod
    def of(cls, place: Path) -> RunSource:
        """Open the springs of a run. Raises UserInputError."""
        from pysprings.cli.inputs import springs_of
        from pysprings.scene.load import parse_scene
        from pysprings.springs.springs import Springs

        tree = springs_of(place)
        rates = [float(f"{1e3 * each.rate:.4g}") for each in Springs.of(tree).rate_sets]
        fields = (replace(RATE, start=rates[0], ends=(rates[0], rates[-1])),) if len(rates) > 1 else ()
        try:
            scene = parse_scene(str(tree.attrs["scene_toml"]))
        except (KeyError, PyspringsError):
            scene = None
        return cls(place, tree, scene, str(tree.attrs.get("title", place.name)), fields)

    def key(self, values: Values) -> tuple[Any, ...]:
        """Return the rate of springs at several."""
        return tuple(values[each.name] for each in self.fields)

    def springs(self, values: Values) -> xr.DataTree:
        """Return the springs of the run, of several rates those at the rate asked for."""
        from pysprings.springs.springs import Springs

        (rate,) = self.key(values) or (None,)
        return self.tree if rate is None else Springs.of(self.tree).at_rate(1e-3 * rate).tree

    def scene(self, values: Values) -> Scene | None:
        """Return the scene of the run."""
        return self.read

    def facts(self, values: Values) -> list[tuple[str, str]]:
        """Return caisson and ground of the run, and its end where that is not that of its paths."""
        from pysprings.full_model.run_record import RunRecord

        attrs = self.tree.attrs
        lengths = {"D": "outer_diameter_m", "L": "skirt_length_m", "t": "skirt_thickness_m"}
        facts = [(name, f"{float(attrs[key]):.4g} m") for name, key in lengths.items()]
        facts += [
            ("drainage", str(attrs["drainage"])),
            ("V of the springs", f"{1e-6 * attrs['vertical_load_N']:.4g} MN"),
        ]
        record = RunRecord.read(self.place) if self.place.is_dir() else None
        facts += [("run", "; ".join([record.status, *record.failures]))] if record and not record.complete else []
        strata = self.read.ground.strata if self.read is not None else ()
        return facts + [(f"ground at {each.top:.3g} m", each.name) for each in strata if not each.like]

    def options(self, values: Values) -> list[str]:
        """Return the folder or file, and the rate of springs at several."""
        given = zip(self.fields, self.key(values), strict=True)
        return [str(self.place), *(text for each, x in given if x is not None for text in ("--rate", each.text(x)))]


@dataclass(frozen=True)
class AtlasSource:
    """An atlas: `fields` are D, L and the values of the ground that have short names. Methods as of `RunSource`."""

    name: str
    atlas: Atlas
    title: str
    fields: tuple[Field, ...]
    load_fields: tuple[Field, ...]
    _scenes: dict[tuple[Any, ...], Scene] = field(default_factory=dict)

    @classmethod
    def of(cls, name: str) -> AtlasSource:
        """Open an atlas. Raises UserInputError."""
        from pysprings.studies.atlas.model import open_atlas

        atlas = open_atlas(name)
        ratios, caisson = [float(end) for end in atlas.box[:, 0]], atlas.base.caisson
        lengths = (_round(DIAMETERS[0] * ratios[0]), _round(DIAMETERS[1] * ratios[1]))
        sizes = (
            Field("D", "m", "outer diameter", caisson.outer_diameter, DIAMETERS),
            Field("L", "m", "skirt length", _round(caisson.outer_diameter * math.sqrt(math.prod(ratios))), lengths),
        )
        data = tomllib.loads(atlas.text.text)
        covered = {label: (float(a), float(b)) for label, (a, b) in zip(atlas.family.labels, atlas.box.T, strict=True)}
        short = {name: keys for name, keys in atlas.family.short.items() if name != "V"}
        ground = [_ground_field(name, keys, data, covered.get(name)) for name, keys in short.items()]
        at_rest = caisson.vertical_load
        start = None if isinstance(at_rest, str) else 1e-6 * at_rest
        down = replace(V, tip="vertical load, down; blank: that of the base scene", start=start,
                       ends=(0.0, SPAN * (start or 1.0)))  # fmt: skip
        title = f"{atlas.about.get('title', '')} ({atlas.source})"
        return cls(name, atlas, title, (*sizes, *ground), (H, ARM, M, down))

    def _changes(self, values: Values) -> tuple[str, ...]:
        """Return the values of the ground that are not those of the base scene, as `--set` has them."""
        given = [(each, value) for each in self.fields[2:] if (value := values[each.name]) is not None]
        changed = [(each, each.text(value)) for each, value in given if value != each.start]
        return tuple(f'{each.name}="{text}"' if each.unit else f"{each.name}={text}" for each, text in changed)

    def key(self, values: Values) -> tuple[Any, ...]:
        """Return all inputs but the lateral load."""
        return tuple(values[each.name] for each in (*self.fields, V))

    def springs(self, values: Values) -> xr.DataTree:
        """Return the springs of the atlas."""
        return self.atlas.springs(self.scene(values))

    def scene(self, values: Values) -> Scene:
        """Return the base scene of the atlas with these inputs."""
        from pysprings.cli.atlas import Asked, scene_of

        key = self.key(values)
        if key not in self._scenes:
            V_ = None if values["V"] is None else 1e6 * values["V"]
            asked = Asked(self.name, None, values["D"], values["L"], self._changes(values), V=V_)
            self._scenes.clear()
            self._scenes[key] = scene_of(self.atlas, asked)
        return self._scenes[key]

    def facts(self, values: Values) -> list[tuple[str, str]]:
        """Return the numbers that decide, each with what the full models of the atlas cover."""
        here, (low, high) = self.atlas.family.read(self.scene(values)), self.atlas.box
        rows = zip(self.atlas.family.labels, here, low, high, strict=True)
        return [(name, "{} ({} to {})".format(*(number(float(x)) for x in three))) for name, *three in rows]

    def options(self, values: Values) -> list[str]:
        """Return the atlas, the caisson, and values that are not those of its base scene."""
        given = [(f"--{each.name}", each, values[each.name]) for each in self.fields[:2]]
        sizes = [text for name, each, value in given if value is not None for text in (name, each.text(value))]
        return ["--atlas", self.name, *sizes, *(text for each in self._changes(values) for text in ("--set", each))]


def _ground_field(name: str, keys: str, data: Mapping[str, Any], covered: tuple[float, float] | None) -> Field:
    """Return the input of a value of the ground; its start and unit are those of the base scene."""
    given: Any = data
    for key in keys.split("."):
        given = given[key] if isinstance(given, dict) else next(each for each in given if each.get("name") == key)
    value, _, unit = str(given).partition(" ")
    start = float(value)
    low, high = covered or (start / SPAN, start * SPAN)
    ends = _round(low, 3, ROUND_CEILING), _round(high, 3, ROUND_FLOOR)  # within what the atlas covers
    return Field(name, unit, keys.replace(".", " ").replace("_", " "), start, ends)


def _round(value: float, digits: int = 2, to: str = ROUND_HALF_EVEN) -> float:
    return float(Context(digits, to).create_decimal(str(value)))


Source = RunSource | AtlasSource


def command_line(arguments: list[str]) -> str:
    """Return a command as a shell takes it."""
    return shlex.join(["pysprings", *arguments])
