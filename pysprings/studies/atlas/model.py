# SPDX-License-Identifier: MIT
"""`Atlas`: springs of any caisson of its family, with their predicted standard deviation and marks outside its hull."""

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from pysprings.core.arguments import check_numbers
from pysprings.core.arrays import Array
from pysprings.core.errors import Problem, UserInputError, refused
from pysprings.core.storage import read_tree, write_tree
from pysprings.core.text import suggestion
from pysprings.core.units import quoted
from pysprings.core.version import __version__
from pysprings.scene.changes import Change
from pysprings.scene.load import SceneText
from pysprings.scene.model import Scene
from pysprings.studies.atlas.between import Process
from pysprings.studies.atlas.families import FAMILIES, Family
from pysprings.studies.atlas.samples import FORCES, MOMENTS, ROWS, stiffness_of

_ROUNDING = 1e-6
STIFFNESS_FLOOR = 1e-3  # standard deviation over the stiffness at the least: numbers of cells change with L/D


@dataclass(frozen=True)
class Estimate:
    """What is expected of a scene: values (ray, row, X), modes (m, ray, row, X) of one standard deviation each.

    stiffness : (3, 3) initial stiffness.
    stiffness_error : standard deviations of the logarithms of K_V, K_H, K_M.
    settled : w at rest [m].
    outside : why the scene is at the edge of what is covered; none inside the hull of the full models.
    """

    values: Array
    modes: Array
    stiffness: Array
    stiffness_error: Array
    settled: float
    outside: tuple[str, ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class Atlas:
    """Springs of any caisson between the full models of a study.

    Gaussian processes over the principal components of the springs.

    family : what decides.
    text : the base scene.
    inputs : (n, d) of the full models.
    rays, angles, X : grid of the springs: names and directions [rad] of the rays, motions.
    reach : largest rho over D.
    rest : (2, ray, X) standard deviation of H over F h and M over F L h that `Estimate.modes` do not hold.
    factor : of all standard deviations, such that 95 % of the cases left out lie in the band of 95 %.
    fan : standard deviations of what rays leave open of pulls where the soil has failed: over the load, and over the
        rotation. From held-back pulls (`pysprings.studies.atlas.build`); 0 where there were none.
    about : where it comes from: words for files and reports.
    mean, modes : (ray, row, X) and (m, ray, row, X): principal components.
    processes : of the components; of the four numbers of the stiffness; of the settlement.
    """

    family: Family
    text: SceneText
    inputs: Array
    rays: tuple[str, ...]
    angles: Array
    X: Array
    reach: float
    rest: Array
    mean: Array
    modes: Array
    processes: tuple[Process, ...]
    stiffness: tuple[Process, ...]
    settlement: Process
    factor: float = 1.0
    fan: tuple[float, float] = (0.0, 0.0)
    about: Mapping[str, str] = field(default_factory=dict)

    @property
    def source(self) -> str:
        """Where springs come from: for files and remarks."""
        return f"atlas {self.family.name}"

    @cached_property
    def base(self) -> Scene:
        """The base scene."""
        return self.text.scene()

    @cached_property
    def box(self) -> Array:
        """Least and largest inputs (2, d) of the full models."""
        return np.stack([self.inputs.min(axis=0), self.inputs.max(axis=0)])

    @cached_property
    def _scale(self) -> tuple[Array, Array]:
        return scale_of(self.family.even(self.inputs))

    def point(self, inputs: Array) -> Array:
        """Return inputs (..., d) in their even form, 0 to 1 between the full models."""
        low, span = self._scale
        return np.asarray((self.family.even(inputs) - low) / span)

    def scene(self, D: float | None = None, L: float | None = None, changes: Sequence[Change] = ()) -> Scene:
        """Return the base scene with another diameter and skirt length [m] and other values.

        Short names of the family stand for keys. What is covered in proportion follows, where it is not given.
        """
        check_numbers(D=D, L=L)
        given = [self.named(change) for change in changes]
        sizes = {"outer_diameter": D, "skirt_length": L}
        given += [Change(("caisson", key), f"{value:.12g} m") for key, value in sizes.items() if value is not None]
        scene, there = self.text.scene(given), {change.keys for change in given}
        more = [
            Change((each.section, each.key), f"{each.value(self.base) * each.size(scene) / each.unit[1]:.12g} "
                                             f"{each.unit[0]}")
            for each in self.family.scaled
            if (each.section, each.key) not in there
        ]  # fmt: skip
        return self.text.scene([*given, *more])

    def named(self, change: Change, text: SceneText | None = None) -> Change:
        """Return a change with its key in full where it has a short name of the family, for a scene or the base scene.

        A value of the ground is that of the first layer of the scene, or of its one soil.
        """
        name, text = ".".join(change.keys), self.text if text is None else text
        section, *keys = self.family.short.get(name, name).split(".")
        if section == "soil" and name in self.family.short:
            own = keys[2:] if keys[0] == "layer" else keys
            keys = ["layer", text.layers[0], *own] if text.layers else own
        return Change((section, *keys), change.value)

    def estimate(self, scene: Scene, extrapolate: bool = False) -> Estimate:
        """Return what is expected of a scene.

        Raises UserInputError: the scene is none of the family, or outside the box of the full models, unless
        ``extrapolate``.
        """
        self.family.check(scene, self.base)
        inputs = self.family.read(scene)
        outside = [*self._outside_box(inputs)]
        if outside and not extrapolate:
            raise UserInputError([Problem(key=key, message=text) for key, text in outside])
        texts = [f"{key}: {text}" for key, text in outside] or [*self._outside_hull(inputs)]
        return self._expected(scene, inputs, tuple(texts))

    def beyond(self, scene: Scene) -> list[tuple[str, str]]:
        """Return inputs of a scene outside the box of the full models, and why; UserInputError: another family."""
        self.family.check(scene, self.base)
        return self._outside_box(self.family.read(scene))

    def springs(self, scene: Scene, extrapolate: bool = False) -> xr.DataTree:
        """Return springs of a scene, as `pysprings.extract_springs` does for a full model; see `estimate`."""
        from pysprings.studies.atlas.springs import spring_tree

        return spring_tree(self, scene, self.estimate(scene, extrapolate))

    def _outside_box(self, inputs: Array) -> list[tuple[str, str]]:
        low, high = self.box
        slack = _ROUNDING * np.maximum(high - low, np.abs(high))  # an input that is the same in all is no point
        return [
            (label, f"{value:.4g} is outside the atlas ({a:.4g} to {b:.4g})")
            for label, value, a, b, room in zip(self.family.labels, inputs, low, high, slack, strict=True)
            if not a - room <= value <= b + room
        ]

    def _outside_hull(self, inputs: Array) -> list[str]:
        """Return a sentence for inputs that no mixture of the full models has; none inside their convex hull."""
        from scipy.optimize import linprog

        known, point = self.point(self.inputs), self.point(inputs)
        rows = np.vstack([known.T, np.ones(len(known))])
        inside = linprog(np.zeros(len(known)), A_eq=rows, b_eq=np.append(point, 1.0), method="highs").status == 0
        text = "in a corner of the atlas, outside the convex hull of its full models: the standard deviation is larger"
        return [] if inside else [text]

    def _expected(self, scene: Scene, inputs: Array, outside: tuple[str, ...]) -> Estimate:
        """Return the estimate of a scene that is covered."""
        point, sizes = self.point(inputs), self.family.sizes(scene)
        means, errors = (np.array(each) for each in zip(*(one.at(point) for one in self.processes), strict=True))
        values = self.mean + np.tensordot(means, self.modes, axes=1)
        modes = self.factor * errors[:, None, None, None] * self.modes
        factor, spread = (np.array(each) for each in zip(*(one.at(point) for one in self.stiffness), strict=True))
        D, L = scene.caisson.outer_diameter, scene.caisson.skirt_length
        matrix = stiffness_of(factor, sizes.force, sizes.ratio, D, L)
        settled = self.settlement.at(point)[0] * D / sizes.ratio
        if self.family.at_rest is not None:  # from V = 0 on as the full models, and to there by the weight of the scene
            unloaded = self.settlement.at(self.point(np.append(inputs[:-1], 0.0)))[0] * D / sizes.ratio
            settled -= unloaded + self.family.at_rest(scene) / matrix[1, 1]
        return Estimate(values, modes, matrix, _log_errors(factor, spread), settled, outside)


def scale_of(even: Array) -> tuple[Array, Array]:
    """Return the least of inputs (n, d) in their even form, and their span: 1 of an input that does not vary."""
    span = np.ptp(even, axis=0)
    return even.min(axis=0), np.where(span > 0.0, span, 1.0)


def _log_errors(factor: Array, spread: Array) -> Array:
    """Return standard deviations of log K_V, log K_H and log K_M by those of `factors`."""
    inner = np.exp(2.0 * factor[1]) * factor[2] ** 2
    outer = np.exp(2.0 * factor[3])
    share_ = inner / (inner + outer)
    slope = 2.0 * np.exp(2.0 * factor[1]) * factor[2] / (inner + outer)
    moment = np.sqrt((2 * share_ * spread[1]) ** 2 + (slope * spread[2]) ** 2 + (2 * (1 - share_) * spread[3]) ** 2)
    return np.hypot(np.array([spread[0], 2.0 * spread[1], moment]), STIFFNESS_FLOOR)


def sums(values: Array) -> tuple[Array, Array]:
    """Return H over F h and M over F L h (..., X) of rows (..., row, X)."""
    n = sum(name.startswith("p") for name in FORCES)
    middle = (np.arange(n) + 0.5) / n
    row = {name: ROWS.index(name) for name in ("H_tip", "H_lid")}
    p, tip, lid = values[..., :n, :], values[..., row["H_tip"], :], values[..., row["H_lid"], :]
    moments = values[..., len(FORCES) : len(FORCES) + len(MOMENTS), :]
    M = moments.sum(axis=-2) - (middle[:, None] * p).sum(axis=-2) - tip
    return p.sum(axis=-2) + tip + lid, M


SUFFIX = ".nc"
SHIPPED = Path(__file__).parent / "shipped"

SCHEMA = "pysprings-atlas-2"


def write_atlas(atlas: Atlas, file: str | os.PathLike[str]) -> Path:
    """Write an atlas; return its path. Components have single precision."""
    processes = [*atlas.processes, *atlas.stiffness, atlas.settlement]
    data: dict[str, Any] = {
        "inputs": (("case", "input"), atlas.inputs), "points": (("case", "input"), processes[0].points),
        "angle": ("ray", atlas.angles), "X": ("X", atlas.X),
        "mean": (("ray", "row", "X"), atlas.mean.astype(np.float32)),
        "modes": (("component", "ray", "row", "X"), atlas.modes.astype(np.float32)),
        "rest": (("load", "ray", "X"), atlas.rest.astype(np.float32)),
        "values": (("process", "case"), np.stack([each.values for each in processes])),
        "lengths": (("process", "input"), np.stack([each.lengths for each in processes])),
    }  # fmt: skip
    for name in ("mean", "size", "variance", "noise"):
        data[f"process_{name}"] = ("process", np.array([getattr(each, name) for each in processes]))
    coords = {"ray": list(atlas.rays), "row": list(ROWS), "input": list(atlas.family.labels), "load": ["H", "M"]}
    attrs = {
        "schema": SCHEMA, "family": atlas.family.name, "scene_toml": atlas.text.text, "factor": atlas.factor,
        "reach_over_diameter": atlas.reach, "fan": list(atlas.fan), "about": json.dumps(dict(atlas.about)),
        "source": f"pysprings {__version__}",
    }  # fmt: skip
    return write_tree(xr.DataTree(xr.Dataset(data, coords, attrs)), file)


def read_atlas(file: Path) -> Atlas:
    """Read an atlas. Raises UserInputError for another or a broken file."""
    tree = read_tree(file)
    if tree.attrs.get("schema") != SCHEMA:
        raise refused(None, f"is no atlas ({SCHEMA}); `pysprings atlas` makes one of a study", file)
    data = tree.to_dataset()
    if tuple(data["row"].values) != ROWS:
        raise refused(None, "an atlas of another version: its rows differ", file)
    values = {str(name): np.asarray(each.values) for name, each in data.variables.items()}
    count = data.sizes["component"]
    processes = [
        Process(
            values["points"], values["values"][k], float(values["process_mean"][k]), float(values["process_size"][k]),
            float(values["process_variance"][k]), values["lengths"][k], float(values["process_noise"][k]),
        )
        for k in range(data.sizes["process"])
    ]  # fmt: skip
    attrs = data.attrs
    text = SceneText(str(attrs["scene_toml"]), f"base scene of {file.name}")
    return Atlas(
        family=FAMILIES.find(str(attrs["family"]), "family"), text=text, inputs=values["inputs"],
        rays=tuple(str(name) for name in data["ray"].values), angles=values["angle"], X=values["X"],
        reach=float(attrs["reach_over_diameter"]), rest=values["rest"].astype(float), factor=float(attrs["factor"]),
        fan=(float(attrs["fan"][0]), float(attrs["fan"][1])), about=json.loads(str(attrs["about"])),
        mean=values["mean"].astype(float), modes=values["modes"].astype(float), processes=tuple(processes[:count]),
        stiffness=tuple(processes[count:-1]), settlement=processes[-1],
    )  # fmt: skip


def shipped() -> list[str]:
    """Return the names of the atlases of this package."""
    return sorted(file.stem for file in SHIPPED.glob(f"*{SUFFIX}"))


def open_atlas(source: str | os.PathLike[str]) -> Atlas:
    """Open an atlas: a file, or the name of one that comes with the package ("clay").

    Raises UserInputError for another file, or a broken one.
    """
    names = shipped()
    if str(source) in names:
        return read_atlas(SHIPPED / f"{source}{SUFFIX}")
    if not Path(source).exists() and Path(source).suffix != SUFFIX:
        meant = suggestion(str(source), names)
        raise refused(
            "--atlas", f"no atlas {quoted(str(source))}{meant}; there are: {', '.join(names) or 'none'}, or a file"
        )
    return read_atlas(Path(source))
