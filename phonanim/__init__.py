"""Speech animation from phone alignments: a Praat TextGrid and a rig in, moving lips out.

What `__all__` lists is the public interface; it is imported on first use, so that `import phonanim` is fast.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from phonanim.core.version import __version__ as __version__

if TYPE_CHECKING:
    from phonanim.animation.animation import Animation
    from phonanim.evaluation.evaluate import evaluate
    from phonanim.exporters import save
    from phonanim.inputs.alignment import read_alignment
    from phonanim.options import Options
    from phonanim.pipeline import animate, load_model
    from phonanim.regressors import Model
    from phonanim.rig import Rig, load_rig
    from phonanim.speech.alignment import Alignment

__all__ = [
    "Alignment",
    "Animation",
    "Model",
    "Options",
    "Rig",
    "animate",
    "evaluate",
    "load_model",
    "load_rig",
    "read_alignment",
    "save",
]

_MODULES = {
    "Alignment": "speech.alignment",
    "Animation": "animation.animation",
    "Model": "regressors",
    "Options": "options",
    "Rig": "rig",
    "animate": "pipeline",
    "evaluate": "evaluation.evaluate",
    "load_model": "pipeline",
    "load_rig": "rig",
    "read_alignment": "inputs.alignment",
    "save": "exporters",
}
"""Where each public name is defined."""


def __getattr__(name: str) -> Any:
    """Import a public name on first use. Raises AttributeError for any other."""
    if name not in _MODULES:
        raise AttributeError(f"module 'phonanim' has no attribute {name!r}; it has {', '.join(__all__)}")
    from importlib import import_module

    found = getattr(import_module(f"phonanim.{_MODULES[name]}"), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    """The public names and what a module always has."""
    return sorted({*globals(), *__all__})
