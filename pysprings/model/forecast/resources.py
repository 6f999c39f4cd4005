# SPDX-License-Identifier: MIT
"""What a scene needs of the machine, from its counts alone: memory and disk; refused before anything is built.

The laws of memory are fitted (see the constants); the refusal compares them with what this process may ever have: the
machine's memory, or less under a control group or a limit of the shell.
"""

import math
import os
import shutil
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fe_engine.assembly.fourier_pattern import held_coefficients, held_pressures
from fe_engine.assembly.harmonic_factors import KEPT_BYTES, LANES
from fe_engine.elements.fourier import numbers
from fe_engine.errors import MeshError
from fe_engine.memory import address_space, left as memory_left, limit as memory_limit
from pysprings.core.errors import ResourceError, refused
from pysprings.core.path_kinds import MEMORY
from pysprings.core.workers import cores, in_worker
from pysprings.model.build import counts_of, geometry_of
from pysprings.model.forecast.run_time import (
    least_increments,
    likely_increments,
    path_seconds,
    superlu_bytes,
    uses_superlu,
)
from pysprings.model.fourier import azimuths_of, fixed_directions, section_counts_of, section_of
from pysprings.model.fourier_mesh import CaissonSection
from pysprings.model.mesh import Counts, core_square, counted
from pysprings.model.steel import make_steel_rings, patch, with_rings
from pysprings.model.water import drained_corners, film_corners, fixed_film
from pysprings.scene.model import Scene

# Fitted on the presets coarse, medium and paper (4,600 to 52,000 unknowns, 71,000 with water) with Pardiso on two
# cores: entries of the LU factors; water has more of them for each unknown, and scaled copies of its matrix. Given
# forces need that much; earlier factors, in single precision, less (pulls: `paper` 0.94 GB for 1.1, `fine` 5 for 8.1).
_FACTOR_ENTRIES, _FACTOR_EXPONENT = 10.3, 1.44
_BASE_BYTES, _BYTES_PER_UNKNOWN, _BYTES_PER_ENTRY = 0.37e9, 3.0e3, 9.0
_WATER_FACTOR, _WATER_BYTES_PER_UNKNOWN = 1.75, 4.0e3
_SYMMETRIC_ENTRIES = 0.55  # measured (docs/evidence/omissions.md)
# Entries of the factors of one harmonic by the number of elements, fitted on 59 to 638 of them; numbers that a point of
# the soil law keeps: a tangent, and stress, history and their copies.
_SERIES_ENTRIES, _SERIES_EXPONENT, _BYTES_OF_A_POINT = 194.0, 1.256, 60.0
# With water: blocks of the factors over those without, and time steps whose factors are kept at most.
_SERIES_WATER, _SERIES_STEPS = 2.2, 24
# Fit of the elements of springs with memory (11,000 columns are offered), behind the model of 21 paths on `coarse`.
_CALIBRATION_BYTES = 0.6e9
# A recorded step stands in memory as it came, in its dataset, and in what tables and pictures make of it.
_COPIES_OF_A_STEP = 3.0
# NetCDF compresses fields of steps that move to about this share at best.
_BEST_COMPRESSION = 0.2

# Address space beyond the memory that is used: what the process has mapped when its modules are loaded (NumPy, SciPy,
# Numba), libraries that load later (MKL, netCDF, Matplotlib), and stack and heap of each thread. Measured on x86-64.
_MAPPED_AT_START, _MAPPED_LATER, _MAPPED_PER_THREAD = 0.57e9, 0.40e9, 0.072e9


@dataclass(frozen=True)
class Size:
    """Counts of the model of a scene before it is built: nodes, elements, unknowns, bytes of a step.

    Of the unknowns ``pore_pressures`` are pressures of the soil, ``film_pressures`` those of the interface.
    """

    nodes: int
    elements: int
    unknowns: int
    step_bytes: int
    pore_pressures: int = 0
    film_pressures: int = 0


def size_of(scene: Scene, whole: bool = False) -> Size:
    """Return the counts of a scene's model, or of one of the ``whole`` domain, both halves; builds nothing."""
    if scene.discretisation == "fourier":
        return _series_size(scene)
    counts = counted(geometry_of(scene), counts_of(scene))
    n, rings = counts.azimuth, counts.plug + counts.tip + counts.outer
    levels = counts.skirt + counts.below + 1
    around, core, halves = _plan(n, whole)
    plan = core + rings * around
    nodes = plan * levels - (counts.tip - 1) * around * counts.skirt
    elements = halves * (((n // 2) * (n // 4) + rings * n) * (levels - 1) - counts.tip * n * counts.skirt)
    plane = n // 2 + 1 + 2 * rings  # nodes of a level on the plane of symmetry
    unknowns = 3 * (nodes - plan) - ((0 if whole else plane) + around) * (levels - 1) + 3
    pores = film = 0
    if scene.drainage.mode != "drained":
        # all layers count: those without water make an upper bound of it
        film = around * (2 * counts.skirt + counts.tip - 1) + core + counts.plug * around  # without the rim outside
        pores = nodes - around * (counts.outer + 1)
        pores -= around * (levels - 1) if scene.domain.side_drainage == "drained" else 0
    if scene.caisson.behaviour == "elastic":
        steel_nodes, steel_unknowns = _steel(counts, whole)
        nodes, unknowns = nodes + steel_nodes, unknowns + steel_unknowns
    volume = 4 * (4 * nodes + 7 * elements) if scene.output.paraview else 0
    depths, patches = counts.skirt + 1, n**2 // 8 + (n + 1) * (counts.plug + counts.tip + 1)
    step = _step_bytes(scene, depths, patches, n + 1, plane * (depths + counts.below))
    return Size(nodes, elements, unknowns + pores + film, step + volume, pores, film)


def _series_size(scene: Scene) -> Size:
    """Return the counts of a Fourier model; nodes and elements are those of its section, which is built."""
    counts = section_counts_of(scene)
    try:
        section, waves = section_of(scene, counts), counts.harmonics + 1
        counts = counted(geometry_of(scene), counts)
    except MeshError as error:
        raise refused("mesh", str(error)) from error
    mesh, steel_corners, steel_elements = section.mesh, 0, 0
    fixed = fixed_directions(scene, mesh)
    if scene.caisson.behaviour == "elastic":
        steel = make_steel_rings(section, scene.caisson.lid_thickness)
        mesh, fixed = with_rings(mesh, fixed, steel)
        steel_corners, steel_elements = len(np.unique(steel.quads[:, :4])), steel.n_elements
    held = held_coefficients(mesh, fixed, counts.harmonics)
    corners = mesh.corners
    patches, plane = waves * (len(section.lid) + len(section.tip) - 2), 2 * len(corners)
    step = _step_bytes(scene, counts.skirt, patches, 2 * waves + 1, plane - int(mesh.on_axis[corners].sum()))
    m = counts.harmonics + 3
    cells = 4 * (len(corners) + steel_corners) * (m + 1) + 7 * (mesh.n_elements + steel_elements) * m
    volume = 4 * cells if scene.output.paraview else 0
    pores, film = (0, 0) if scene.drainage.mode == "drained" else _series_pressures(scene, section, counts.harmonics)
    unknowns = int(np.count_nonzero(~held)) + 3 + pores + film
    return Size(mesh.n_nodes, mesh.n_elements, unknowns, step + volume, pores, film)


def _series_pressures(scene: Scene, section: CaissonSection, harmonics: int) -> tuple[int, int]:
    """Return the unknown pressures of the soil and of the film of a Fourier model."""
    mesh, fixed = section.mesh, drained_corners(scene, section)
    slots = harmonics + 1
    held = held_pressures(fixed, mesh.on_axis[mesh.corners], slots)
    film = fixed_film(scene, section, fixed)
    on_axis = mesh.on_axis[film_corners(section)]
    return int(np.count_nonzero(~held)), int(np.count_nonzero(~held_pressures(film, on_axis, slots)))


def model_bytes(scene: Scene, symmetric: bool = False) -> float:
    """Return the estimated peak memory of a run of this scene, in bytes, without its recorded steps."""
    size = size_of(scene)
    if scene.discretisation != "fourier":
        more = superlu_bytes(size.unknowns) if uses_superlu(scene) else 0.0
        return memory_bytes(size.unknowns, scene.drainage.mode != "drained", symmetric) + more
    sides = {False} | {path.in_space for path in scene.all_paths}  # half of the caisson, and the whole
    fitted = _CALIBRATION_BYTES if any(path.role == MEMORY for path in scene.all_paths) else 0.0
    return _BASE_BYTES + fitted + sum(_series_bytes(scene, size, whole) for whole in sides)


def _series_bytes(scene: Scene, size: Size, whole: bool) -> float:
    """Return the estimated memory of a Fourier model in bytes; the whole circle shares the factors of its families."""
    counts = counted(geometry_of(scene), section_counts_of(scene))
    waves, (m, _) = counts.harmonics + 1, azimuths_of(counts.harmonics, whole)
    slots, lanes = len(numbers(counts.harmonics, whole)), LANES * math.ceil(waves / LANES)
    interface = 3 * slots * 2 * (2 * counts.skirt + counts.plug + counts.tip) + size.film_pressures * slots / waves
    factors, steel = 8.0 * lanes * _SERIES_ENTRIES * float(size.elements) ** _SERIES_EXPONENT, 0.0
    if size.pore_pressures:
        factors *= 1.5 * _SERIES_WATER  # in both precisions
        factors += min(_SERIES_STEPS * factors, KEPT_BYTES)
    if scene.caisson.behaviour == "elastic":
        steel = 2.0 * interface**2 + 2.0 * slots * (2.0 * interface / slots) ** 2
    return factors + 8.0 * 4 * m * size.elements * _BYTES_OF_A_POINT + 8.0 * (4.0 * interface**2 + steel)


def _plan(n: int, whole: bool) -> tuple[int, int, int]:
    """Return nodes of a ring and of the square core, and number of halves, for n cells around half of the caisson."""
    return (2 * n, (n // 2 + 1) ** 2, 2) if whole else (n + 1, (n // 2 + 1) * (n // 4 + 1), 1)


def _steel(counts: Counts, whole: bool) -> tuple[int, int]:
    """Return the nodes and unknowns of an elastic caisson."""
    n = counts.azimuth
    around, core, halves = _plan(n, whole)
    lid = core + (counts.plug + 1) * around  # out to the skirt's outer edge
    nodes = 2 * lid + 2 * around * counts.skirt
    plane = 2 * (n // 2 + 1 + 2 * (counts.plug + 1)) + 4 * counts.skirt
    points, _, _ = core_square(n, 0.5)  # of a skirt with an inner radius of 1
    in_patch = patch(np.hypot(points[:, 0], points[:, 1]), 1.0)
    held, on_plane = int(in_patch.sum()), int((in_patch & (np.abs(points[:, 1]) < 1e-12)).sum())
    if whole:
        return nodes, 3 * nodes - 2 * 3 * (halves * held - on_plane)
    return nodes, 3 * nodes - plane - 2 * (3 * held - on_plane)


def _step_bytes(scene: Scene, depths: int, patches: int, around: int, plane: int) -> int:
    """Return the bytes of what a path keeps of one step: scalars, reactions by depth, lid and tip, fields, section.

    patches : points under lid and tip; around : azimuths of fields; plane : nodes of the section.
    """
    values = 60 + (14 if scene.caisson.behaviour == "elastic" else 12) * depths + 2 * patches
    if scene.output.interface_fields:
        values += 5 * 2 * around * depths
    if scene.output.section:
        values += (2 if scene.drainage.mode == "drained" else 3) * plane
    return 8 * values


def memory_bytes(unknowns: int, water: bool = False, symmetric: bool = False) -> float:
    """Return the estimated peak memory of a run, in bytes, without its recorded steps."""
    entries = _FACTOR_ENTRIES * float(unknowns) ** _FACTOR_EXPONENT
    entries *= (_WATER_FACTOR if water else 1.0) * (_SYMMETRIC_ENTRIES if symmetric else 1.0)
    per_unknown = _WATER_BYTES_PER_UNKNOWN if water else _BYTES_PER_UNKNOWN
    return _BASE_BYTES + per_unknown * unknowns + _BYTES_PER_ENTRY * entries


def steps_bytes(scene: Scene, size: Size) -> tuple[float, float]:
    """Return the bytes of all recorded steps of a run: the least, and what is likely."""
    return size.step_bytes * float(sum(least_increments(scene))), size.step_bytes * sum(likely_increments(scene))


def refuse_what_cannot_fit(scene: Scene) -> None:
    """Raise ResourceError, with the figures, where a run needs more memory than this process may ever have."""
    size, limit = size_of(scene), memory_limit()
    model = model_bytes(scene)
    if model > limit:
        raise ResourceError(
            f"the model needs about {gigabytes(model)} of memory ({size.nodes:,} nodes, {size.unknowns:,} unknowns), "
            f"{gigabytes(limit)} are there: choose a smaller mesh.preset, mesh.refinement or mesh.azimuth"
        )
    _refuse_small_address_space(model)
    needed = _COPIES_OF_A_STEP * steps_bytes(scene, size)[0]
    if model + needed > limit:
        raise ResourceError(
            f"{_increments(scene)}, which need {gigabytes(needed)} of memory beside {gigabytes(model)} of the model, "
            f"{gigabytes(limit)} are there: {_FEWER}"
        )


def jobs_for(scene: Scene, asked: int | None, times: Sequence[float] | None = None) -> int:
    """Return the number of worker processes for the paths of a scene, or for runs of such scenes; 1: none.

    ``times`` are those of the tasks in s (None: of the paths). With None asked: the cores of the machine, where the
    tasks take long enough, and none of them has a use for more than one core. No more than there are tasks, and no more
    than fit into the memory.
    """
    if in_worker() or asked == 1:
        return 1
    times = path_seconds(scene, size_of(scene).unknowns) if times is None else times
    if asked is None:
        asked = cores() if scene.discretisation == "fourier" and sum(times) > WORTH_WORKERS else 1
    fitting = int(_SHARE_OF_WORKERS * memory_left() / model_bytes(scene))
    return max(1, min(asked, len(times), fitting))


WORTH_WORKERS = 10.0  # s of all paths in this process; workers take about two to start
_SHARE_OF_WORKERS = 0.8  # of the memory that is left


def _refuse_small_address_space(model: float) -> None:
    """Raise ResourceError where libraries could not be loaded beside the model: they end the process, or never return.

    ``model`` is the memory that a run needs, in bytes. The libraries need address space that they never use.
    """
    allowed = address_space()
    if math.isinf(allowed):
        return
    import psutil
    from numba import get_num_threads

    libraries = max(float(psutil.Process().memory_info().vms), _MAPPED_AT_START)
    if "pypardiso" not in sys.modules:  # a run before this one has loaded them
        libraries += _MAPPED_LATER + _MAPPED_PER_THREAD * get_num_threads()
    needed = libraries + model - _BASE_BYTES
    if needed > allowed:
        raise ResourceError(
            f"the run needs about {gigabytes(needed)} of address space ({gigabytes(libraries)} for libraries), "
            f"{gigabytes(allowed)} are allowed (`ulimit -v`): raise it, or choose a smaller mesh or fewer threads"
        )


_FEWER = "take a larger solver.max_step_fraction, fewer paths, or less of [output]"


def _increments(scene: Scene) -> str:
    number, paths = sum(least_increments(scene)), len(scene.all_paths)
    return f"{paths} path{'s' if paths > 1 else ''} of {number:.6g} increments at least"


def refuse_full_disk(scene: Scene, folder: str | os.PathLike[str]) -> None:
    """Raise ResourceError, with the figures, where the results cannot fit on the disk of a folder (or its parent)."""
    least = _BEST_COMPRESSION * steps_bytes(scene, size_of(scene))[0]
    place = Path(folder).absolute()
    while not place.exists() and place != place.parent:
        place = place.parent
    try:
        free = shutil.disk_usage(place).free
    except OSError:  # a file system without this figure
        return
    if least > free:
        raise ResourceError(
            f"{_increments(scene)}, {gigabytes(least)} in full_model.nc; {place} has {gigabytes(free)} free: {_FEWER}"
        )


def gigabytes(value: float) -> str:
    """Return bytes for people: "2.3 GB"."""
    size = value / 1e9
    return f"{size:,.0f} GB" if 1e3 <= size < 1e9 else f"{size:.3g} GB"
