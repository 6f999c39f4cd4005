# SPDX-License-Identifier: MIT
"""What a run takes: increments of its paths and wall time, from counts and step sizes alone, by fitted laws."""

from fe_engine.linear.backends import available_backends
from fe_engine.solve.stepping import fewest_increments
from pysprings.model.stages import imposed_motion, path_stages
from pysprings.scene.model import Scene
from pysprings.scene.sections import Path, Springs
from pysprings.scene.soils import SOIL_LAWS

# Drained, to 2.5 mm, CPU seconds with SuperLU and with Pardiso: `coarse` (4,631 unknowns) 11.9 and 4.1, `medium`
# (13,863) 81.6 and 13.8; peak memory 0.45 and 0.38 GB, 1.08 and 0.59 GB. Power laws through both.
_UNKNOWNS, _TIME, _TIME_EXPONENT = 4631.0, 2.9, 0.65
_BYTES, _BYTES_EXPONENT = 0.07e9, 1.77
_RSLAB_EXPONENT = 0.16  # of the time with rslab over that with Pardiso: 0.9, 1.2, on `paper` (52,099) 1.4 to 1.5


def linear_solver(scene: Scene) -> str:
    """Return what factorises the matrices of a scene of bricks; of a series, which has small ones of its own, ""."""
    if scene.discretisation == "fourier":
        return ""
    return available_backends()[0] if scene.solver.linear == "auto" else scene.solver.linear


def uses_superlu(scene: Scene) -> bool:
    """Return whether SuperLU factorises the matrices of a scene."""
    return linear_solver(scene) == "superlu"


def superlu_time(unknowns: int) -> float:
    """Return the time of an increment with SuperLU over that with Pardiso, at least 1."""
    return max(1.0, _TIME * (unknowns / _UNKNOWNS) ** _TIME_EXPONENT)


def superlu_bytes(unknowns: int) -> float:
    """Return the memory that SuperLU needs beyond Pardiso's, in bytes."""
    return _BYTES * (unknowns / _UNKNOWNS) ** _BYTES_EXPONENT


# Seconds of a run, and of an increment of a pull to 2.5 mm, by the number of unknowns and its square
_START, _PER_UNKNOWN, _PER_SQUARE = 1.0, 1.25e-5, 9.1e-11
_WATER = 1.85
_SYMMETRIC = 0.77  # 1/1.3 of docs/evidence/omissions.md on `coarse`: the least, since factors grow faster than the rest
# The lid of the paper's caisson (diameter 7.8 m) begins to lift off at 7 to 8 mm: with a share s of the motion beyond
# that, 28 increments become 28 (1 + s), with 1 - s + 4.3 s times the time of an increment (`paper` to 20 mm).
_LIFT_OFF, _LIFT_OFF_INCREMENTS, _LIFT_OFF_TIME = 1.0e-3, 2.0, 4.3
PICTURE_SECONDS = {"none": 0.0, "report": 3.0, "all": 10.0}  # of a run, by how many are asked for
# The same of series, by a power of the unknowns; with water; and of the runs on a coarser section: all paths with N,
# with two harmonics more four at most, of clay all (full_model.accuracy.own_estimate).
_SERIES_START, _SERIES_PER_UNKNOWN, _SERIES_EXPONENT = 1.0, 9.0e-7, 1.2
_WHOLE = 2.7  # of an increment of the whole caisson beside one of its half, N 3 (2.2 to 3.1 for N 2 to 5)
_SERIES_WATER, _SERIES_COARSER, _SERIES_RICHER, _RICHER_PATHS = 1.5, 0.35, 0.5, 4
_FIT, _FIT_IN_SPACE = 7.0, 18.0  # of springs with memory, of each vertical load and rate; of those in space
# Of series an increment beyond lift-off takes this times a power of the unknowns as long as one before: on finer
# sections stations of the inner wall flip more often, and sand localises.
_SERIES_LIFT_OFF, _SERIES_LIFT_OFF_EXPONENT = 0.024, 0.5


def least_increments(scene: Scene) -> list[int]:
    """Return the number of increments that each path needs when every one converges at once."""
    return [
        sum(fewest_increments(stage) for stage in path_stages(scene, path, 0.0, undrained_time=1.0))
        for path in scene.all_paths
    ]


def likely_increments(scene: Scene) -> list[float]:
    """Return the number of increments that each path is likely to take: more once the lid lifts off."""
    least = least_increments(scene)
    return [
        number * (1.0 + (_LIFT_OFF_INCREMENTS - 1.0) * _lifted(scene, path))
        for number, path in zip(least, scene.all_paths, strict=True)
    ]


def seconds(
    scene: Scene, unknowns: int, water: bool | None = None, symmetric: bool = False, superlu: bool | None = None
) -> float:
    """Return the estimated wall time of a run on two cores with compiled code at hand, in s: an order of magnitude.

    Each increment takes a N + b N^2 for N unknowns. Fitted on the default scene without pictures, drained, to 2.5 mm:
    `coarse` 2.4 s, `medium` 5.2 s, `paper` 21 to 23 s, `fine` 264 s; to 20 mm `paper` 80 s. The law gives 2.4, 5.4,
    21.7, 265 and 77 s. Coupled: `medium` 13.7 s, `paper` to 1 mm 53 s; law 12.7 and 56 s. `coarse` to 20 mm takes 45
    increments, as in the law. The motion under an imposed force is unknown: lift-off of the lid is not counted.

    Series take c N^1.2 an increment, d N^0.5 times as long beyond lift-off, and half as much again for their estimate.
    Measured without the estimate, CPU seconds of one thread, N 3 at the default tolerance: to 2.5 mm 0.49 with 4,153
    unknowns, 0.70 with 6,290, 0.83 with 7,243, coupled 0.91 with 4,776 and 1.43 with 7,183; to 20 mm 2.1 with 6,290 and
    2.45 with 7,243; four paths of the default scene to 20 mm, at its tolerance of 1e-4, 5.5 (`coarse`), 12 (`medium`)
    and 21 s (`paper`). The law gives 0.45, 0.75, 0.89; 0.81, 1.32; 1.4, 1.8; 7, 14, 19 s. Increments that are cut where
    sand localises (`fine`) are left out.

    ``water``: pressures are among the unknowns; ``superlu``: SuperLU factorises bricks (None: as in the scene, here).
    """
    paths, pictures = sum(path_seconds(scene, unknowns, water)), PICTURE_SECONDS[scene.output.pictures]
    if scene.discretisation == "fourier":
        share = 1.0 if scene.ground.total_stress else min(1.0, _RICHER_PATHS / max(len(scene.load_paths), 1))
        runs = (1.0 + _SERIES_COARSER + _SERIES_RICHER * share) * paths
        return pictures + _SERIES_START + runs + _fit_seconds(scene.springs)
    if uses_superlu(scene) if superlu is None else superlu:
        paths *= superlu_time(unknowns)
    elif superlu is None and linear_solver(scene) == "rslab":
        paths *= max(1.0, (unknowns / _UNKNOWNS) ** _RSLAB_EXPONENT)  # over the time with Pardiso
    return pictures + _START + (_SYMMETRIC if symmetric else 1.0) * paths


def _fit_seconds(springs: Springs) -> float:
    """Return the time of the fits of springs with memory, in s."""
    if springs.reach is None or not springs.memory:
        return 0.0
    sets = (1 + len(springs.vertical_loads)) * max(1, len(springs.rates))
    return _FIT * sets + _FIT_IN_SPACE * springs.directions


def path_seconds(scene: Scene, unknowns: int, water: bool | None = None) -> list[float]:
    """Return the likely time of each path of a run, in s, by the law of `seconds`; by Pardiso for bricks."""
    each, lift_off, slower = _PER_UNKNOWN * unknowns + _PER_SQUARE * unknowns**2, _LIFT_OFF_TIME, _WATER
    if scene.discretisation == "fourier":
        each, slower = _SERIES_PER_UNKNOWN * unknowns**_SERIES_EXPONENT, _SERIES_WATER
        lift_off = _SERIES_LIFT_OFF * unknowns**_SERIES_LIFT_OFF_EXPONENT
    wet = scene.drainage.mode != "drained" if water is None else water
    each *= slower if wet else 1.0
    lifted = [_lifted(scene, path) for path in scene.all_paths]
    whole = [_WHOLE if path.in_space else 1.0 for path in scene.all_paths]
    return [
        each * slow * n * (1.0 - share + lift_off * share)
        for n, share, slow in zip(least_increments(scene), lifted, whole, strict=True)
    ]


def _lifted(scene: Scene, path: Path) -> float:
    """Return the share of the motion of a path in which the lid lifts off; elastic soil has no trouble with that."""
    displacement, rotation = imposed_motion(path)
    reach = max(displacement, rotation * scene.caisson.skirt_length)
    limit = _LIFT_OFF * scene.caisson.outer_diameter
    stiff = not any(SOIL_LAWS[each.law].yields for each in scene.ground.strata)
    return 0.0 if stiff or reach <= limit else 1.0 - limit / reach
