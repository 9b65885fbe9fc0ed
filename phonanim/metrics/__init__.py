"""Distances between predicted and captured motion: each measure with its unit, its equation and its source.

`arrays` compares arrays of any kind (parameters, shapes, pixels, controls, sensors), `vertices` meshes,
`controls` rigs, `lips` lip gaps and closures, `curves` single curves over time, `timing` their extrema,
`sequences` what was read; `phones` gives errors by phone. docs/evaluation.md says which measure to use when.
"""

from phonanim.metrics.arrays import (
    absolute_error,
    euclidean_error,
    squared_error,
    summed_absolute_error,
)
from phonanim.metrics.controls import control_diversity, control_dynamics_deviation
from phonanim.metrics.curves import (
    band_energies,
    correlation,
    derivative_error,
    jerk,
    lag,
    log_spectral_distance,
    regression_slope,
    sd_ratio,
)
from phonanim.metrics.lips import closure_error, least_gaps, lip_gap
from phonanim.metrics.phones import (
    PHONE_CLASSES,
    PhoneError,
    by_class,
    by_phone,
    merge_tables,
    phone_middles,
    speech_mask,
)
from phonanim.metrics.sequences import edit_distance
from phonanim.metrics.timing import temporal_misalignment
from phonanim.metrics.vertices import (
    distances,
    diversity,
    dynamics_deviation,
    lip_vertex_error,
    mean_vertex_error,
    temporal_mean_vertex_error,
    vertex_error,
)

__all__ = [
    "PHONE_CLASSES",
    "PhoneError",
    "absolute_error",
    "band_energies",
    "by_class",
    "by_phone",
    "closure_error",
    "control_diversity",
    "control_dynamics_deviation",
    "correlation",
    "derivative_error",
    "distances",
    "diversity",
    "dynamics_deviation",
    "edit_distance",
    "euclidean_error",
    "jerk",
    "lag",
    "least_gaps",
    "lip_gap",
    "lip_vertex_error",
    "log_spectral_distance",
    "mean_vertex_error",
    "merge_tables",
    "phone_middles",
    "regression_slope",
    "sd_ratio",
    "speech_mask",
    "squared_error",
    "summed_absolute_error",
    "temporal_mean_vertex_error",
    "temporal_misalignment",
    "vertex_error",
]
