"""The errors that a user can mend. Each ends a command in one line on stderr and exit code 2."""

from __future__ import annotations


class PhonanimError(Exception):
    """Base of every error that bad input can cause; the text names the file, the place and the mend."""


class AlignmentError(PhonanimError):
    """An alignment file that cannot be read, or whose times make no sense."""


class LabelError(PhonanimError):
    """A phone label that the language does not know."""


class ModelError(PhonanimError):
    """A model folder that is missing, damaged, or made for something else."""


class RigError(PhonanimError):
    """A rig, a head or a retargeting map that cannot be used."""


class CorpusError(PhonanimError):
    """Recordings or a training corpus that cannot be used."""


class StudyError(PhonanimError):
    """Films, answers or counts of a user study that cannot be used."""


class StreamError(PhonanimError):
    """Something in a live stream that makes no sense; the stream goes on without it."""


class OutputError(PhonanimError):
    """A destination that cannot be written."""


class AudioError(PhonanimError):
    """A recording that is missing, cannot be read, or does not fit its alignment or text."""


class OptionError(PhonanimError):
    """An option whose value makes no sense; the text says which would."""


class EvaluationError(PhonanimError):
    """Predictions, a reference or a mask that cannot be scored against each other."""


class MissingExtraError(PhonanimError):
    """An optional dependency is absent; the text names the extra that brings it."""


class PluginError(PhonanimError):
    """A plugin of another package that cannot be used; the text names the plugin and its package."""


class ConflictError(PhonanimError):
    """A line that someone else changed meanwhile; the text says who, when and what."""
