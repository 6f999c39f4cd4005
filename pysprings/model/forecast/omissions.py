# SPDX-License-Identifier: MIT
"""What a scene does not need and its model does not carry: what, why, and what that saves.

`build` decides; this lists it. A saving is what the model would have, take and keep with it, by the counts of the
scene's own mesh and the fitted laws of `resources` and `run_time`; docs/evidence/omissions.md has the same
measured with models that carry it. Idealisations (what no setting brings back) are listed, too, and save nothing that
could be counted.
"""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, Self

from fe_engine.linear.backends import available_backends
from pysprings.model.forecast.resources import memory_bytes, size_of, steps_bytes
from pysprings.model.forecast.run_time import PICTURE_SECONDS, seconds
from pysprings.model.soil_laws import engine_laws
from pysprings.scene.interface import holds_suction, uses_adhesion
from pysprings.scene.model import Scene
from pysprings.scene.sections import Soil
from pysprings.scene.soils import SOIL_LAWS

COUNTS, LAWS, MEASURED = "counts of this mesh", "counts of this mesh and fitted laws", "measured on coarse meshes"

_COPIES_OF_HISTORY = 3  # committed, trial, and the last step for a checkpoint
_SHEAR_SHARE = 0.001  # of the time of a run without friction that shear of the stations would take


@dataclass(frozen=True)
class Saved:
    """What an omission saves: unknowns, bytes of memory and disk, share of the time it would take with it.

    0 is what is not affected, or unknown; ``basis`` is the source of the figures.
    """

    basis: str
    unknowns: int = 0
    memory_bytes: int = 0
    disk_bytes: int = 0
    time_share: float = 0.0


@dataclass(frozen=True)
class Omission:
    """One thing that is left out; ``saved`` is None for an idealisation."""

    what: str
    why: str
    saved: Saved | None = None

    def record(self) -> dict[str, Any]:
        """Return what, why and saved as `check` and run.json have it; an idealisation has an empty ``saved``."""
        return {"what": self.what, "why": self.why, "saved": {} if self.saved is None else asdict(self.saved)}


@dataclass(frozen=True)
class _Load:
    """What decides the cost of a model: number of unknowns, pressures among them, symmetric factors."""

    unknowns: int
    water: bool
    symmetric: bool

    def saves(self, scene: Scene, other: Self) -> Saved:
        """Return the saving of this load beside another one that carries more."""
        memory = memory_bytes(other.unknowns, other.water, other.symmetric)
        time = seconds(scene, other.unknowns, other.water, other.symmetric)
        return Saved(
            LAWS,
            unknowns=other.unknowns - self.unknowns,
            memory_bytes=round(memory - memory_bytes(self.unknowns, self.water, self.symmetric)),
            time_share=_share(1.0 - seconds(scene, self.unknowns, self.water, self.symmetric) / time),
        )


def left_out(scene: Scene) -> list[Omission]:
    """List what the scene does not need and the model does not carry; the laws of savings are those of bricks."""
    if scene.discretisation == "fourier":
        bricks = left_out(_with(scene, "mesh", discretisation="hex8", harmonics=None))
        return [replace(omission, saved=None) for omission in bricks]
    return [
        *_steel(scene),
        _half(scene),
        *_water(scene),
        *_soil(scene),
        *_friction(scene),
        *_symmetry_of_factors(scene),
        *_outputs(scene),
    ]


def symmetric_factors(scene: Scene) -> bool:
    """Return whether half of each factorisation is left out: see `Model.symmetric`; only Pardiso can."""
    soil = all(law.symmetric for law in engine_laws(scene)) and scene.discretisation == "hex8"
    symmetric = soil and scene.drainage.mode == "drained" and _smooth(scene)
    return symmetric and scene.solver.linear in ("auto", "pardiso") and "pardiso" in available_backends()


def _smooth(scene: Scene) -> bool:
    return scene.interface.friction_coefficient == 0.0 and not uses_adhesion(scene)


def _load(scene: Scene) -> _Load:
    """Return the load of the model as it runs."""
    return _Load(size_of(scene).unknowns, scene.drainage.mode != "drained", symmetric_factors(scene))


def _with(scene: Scene, table: str, **values: Any) -> Scene:
    """Return the scene with other values, not validated: it is counted, not run."""
    return scene.model_copy(update={table: getattr(scene, table).model_copy(update=values)})


def _steel(scene: Scene) -> list[Omission]:
    if scene.caisson.behaviour == "elastic":
        return [
            Omission("yield and buckling of the steel", "it is linear elastic, displacements are small"),
            Omission("bending of the lid within a quarter of its radius", "the load acts on a stiff patch there"),
        ]
    now = _load(scene)
    elastic = _Load(size_of(_with(scene, "caisson", behaviour="elastic")).unknowns, now.water, now.symmetric)
    why = "the caisson is rigid: three degrees of freedom stand for it (the lid's thickness is only drawn)"
    what = "steel elements (caisson.young_modulus, caisson.poisson_ratio)"
    return [Omission(what, why, now.saves(scene, elastic))]


def _half(scene: Scene) -> Omission:
    now = _load(scene)
    whole = _Load(size_of(scene, whole=True).unknowns, now.water, now.symmetric)
    beyond = any(path.in_space for path in scene.all_paths)
    why = f"symmetry about the loading plane{'; paths that leave it have the whole' if beyond else ''}"
    return Omission("half of the domain", why, now.saves(scene, whole))


_PORE_KEYS = (
    "soil.hydraulic_conductivity", "domain.side_drainage", "drainage.porosity", "drainage.water_bulk_modulus",
    "drainage.water_unit_weight", "drainage.water_depth", "drainage.stabilisation",
)  # fmt: skip
_FILM_KEYS = ("interface.transversal_conductivity", "interface.residual_aperture", "drainage.water_viscosity")


def _water(scene: Scene) -> list[Omission]:
    if scene.drainage.mode == "drained":
        return _all_water(scene)
    now, film = _load(scene), size_of(scene).film_pressures
    saved = now.saves(scene, _Load(now.unknowns + film, True, False))
    out = [Omission("water pressure on the caisson's side of the interface", "the caisson is impervious", saved)]
    if scene.drainage.water_depth is None:
        out.append(Omission("check of suction against cavitation", "drainage.water_depth is not given"))
    if scene.drainage.mode == "undrained":
        keys = "path: rate, duration, times in then; soil.hydraulic_conductivity, domain.side_drainage"
        out.append(Omission(f"time ({keys})", "undrained: the fast limit, nothing flows"))
    return out


def _all_water(scene: Scene) -> list[Omission]:
    """Return the pressures of soil and film; those of the film count beside a model that has the soil's."""
    dry, wet = _load(scene), size_of(_with(scene, "drainage", mode="coupled"))
    pores = _Load(dry.unknowns + wet.pore_pressures, True, False)
    both = _Load(pores.unknowns + wet.film_pressures, True, False)
    kinds = {
        "drained": "drained: no excess pressure",
        "total-stress": "undrained clay in total stress: its strength does not depend on the pore pressure",
    }
    why = "; ".join(kinds[each] for each in scene.layer_drainage.split(", "))
    used = ("drainage.water_unit_weight", "drainage.water_depth") if holds_suction(scene) else ()
    keys = ", ".join(key for key in _PORE_KEYS if key not in used)
    return [
        Omission(f"pore pressure of the soil ({keys})", why, dry.saves(scene, pores)),
        Omission(f"film of water in the interface ({', '.join(_FILM_KEYS)})", why, pores.saves(scene, both)),
    ]


def _soil(scene: Scene) -> list[Omission]:
    if any(SOIL_LAWS[each.law].yields for each in scene.ground.strata):
        return []
    default = SOIL_LAWS[Soil().yield_surface]  # what would be there instead
    variables = len(default.engine(scene.ground.strata[0]).history)
    history = _COPIES_OF_HISTORY * 8 * 8 * variables * size_of(scene).elements
    strength = ", ".join(default.keys)
    what = f"plastic strain and its history (soil: {strength})"
    return [Omission(what, "the soil is elastic", Saved(COUNTS, memory_bytes=history))]


def _friction(scene: Scene) -> list[Omission]:
    if not _smooth(scene):
        return []
    what = "shear of the interface, its tangent and its stiffness (interface.shear_stiffness)"
    why = "interface.friction_coefficient = 0: smooth"
    return [Omission(what, why, Saved(MEASURED, time_share=_SHEAR_SHARE))]


def _symmetry_of_factors(scene: Scene) -> list[Omission]:
    if not symmetric_factors(scene):
        return []
    now = _load(scene)
    saved = now.saves(scene, _Load(now.unknowns, now.water, False))
    why = "the tangent is symmetric: elastic soil, no friction, drained"
    return [Omission("lower triangle of matrix and factors", why, saved)]


def _outputs(scene: Scene) -> list[Omission]:
    """Return what is computed but not kept, with the pictures that need it."""
    output, out = scene.output, []
    if not output.interface_fields:
        fields = "contact stresses and gaps of the skirt by azimuth and depth, their pictures, the check of rings"
        out.append(_output_omission(scene, fields, "interface_fields"))
    if not output.section:
        out.append(_output_omission(scene, "displacements of the symmetry plane and their pictures", "section"))
    if not output.paraview:
        out.append(_output_omission(scene, "the whole model at every step, and its ParaView files", "paraview"))
    if not output.figures:
        time = PICTURE_SECONDS["report"]
        now = _load(scene)
        rest = seconds(scene, now.unknowns, now.water, now.symmetric)
        saved = Saved(LAWS, time_share=_share(time / (time + rest)))
        out.append(Omission("all pictures", "output.figures = false", saved))
    return out


def _output_omission(scene: Scene, what: str, key: str) -> Omission:
    with_output = _with(scene, "output", **{key: True})
    more = steps_bytes(with_output, size_of(with_output))[1] - steps_bytes(scene, size_of(scene))[1]
    return Omission(what, f"output.{key} = false", Saved(COUNTS, memory_bytes=round(more), disk_bytes=round(more)))


def _share(value: float) -> float:
    """Round a share of the time to two digits, the accuracy of the laws."""
    return float(f"{value:.2g}")


# --- what an omission saves, in words; takes any record, also one that somebody else has written ---

_BYTES = (("GB", 1e9), ("MB", 1e6), ("kB", 1e3))
_BYTES_OF = {"memory_bytes": "of memory", "disk_bytes": "on disk"}


def saved_text(saved: Any) -> str:
    """Return one line, "1,234 unknowns, 0.30 GB of memory, 62 % of the time (fitted laws)"; "" for nothing."""
    if not isinstance(saved, Mapping):
        return ""
    parts = []
    if unknowns := _positive(saved.get("unknowns")):
        parts.append(f"{unknowns:,.0f} unknowns")
    parts += [f"{_size(value)} {where}" for key, where in _BYTES_OF.items() if (value := _positive(saved.get(key)))]
    if share := _positive(saved.get("time_share")):
        parts.append(f"{100.0 * share:.2g} % of the time")
    return f"{', '.join(parts)} ({saved.get('basis', '')})" if parts else ""


def _positive(value: Any) -> float:
    """Return a finite number above 0, else 0."""
    plain = isinstance(value, int | float) and not isinstance(value, bool)
    return float(value) if plain and abs(value) < 1e300 and math.isfinite(value) and value > 0 else 0.0


def _size(value: float) -> str:
    for unit, size in _BYTES:
        if value >= size:
            return f"{value / size:.2g} {unit}" if value < 10 * size else f"{value / size:,.0f} {unit}"
    return f"{value:.0f} bytes"
