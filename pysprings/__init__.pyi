# SPDX-License-Identifier: MIT
from .core import errors as errors
from .core.version import __version__ as __version__
from .full_model.compute import run as run
from .macro.batch import predict_batch as predict_batch
from .macro.comparison import compare as compare
from .macro.predict import (
    curve as curve,
    impose as impose,
    model_of as model_of,
    predict as predict,
    sequence as sequence,
)
from .macro.space import sequence_in_space as sequence_in_space
from .macro.stiffness import stiffness as stiffness, stiffness_six as stiffness_six
from .memory.space_model import SpaceStepper as SpaceStepper
from .memory.stepper import MemoryStepper as MemoryStepper
from .results import exporters as exporters, plots as plots
from .results.exporters.beam import beam as beam
from .results.layout import open_result as open_result
from .results.tables import open_table as open_table
from .scene.load import load_scene as load_scene
from .scene.model import Scene as Scene
from .springs.checks import extract_springs as extract_springs, open_springs as open_springs
from .springs.springs import Springs as Springs
from .springs.tip_zone import reslice as reslice
from .studies.atlas.model import open_atlas as open_atlas
from .studies.sweep.dataset import open_study as open_study
