"""A reader of durations: a first line `# durations`, then a label and its seconds in each line."""

from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "durations, a label and its seconds in each line"
HEADER = "# durations"


def recognizes(source: AlignmentFile) -> bool:
    """Whether the first line is the header."""
    return source.text.startswith(HEADER)


def read(source: AlignmentFile) -> Recording:
    """One tier, from 0 s. Raises AlignmentError for a line that is not a label and a number."""
    intervals: list[Interval] = []
    end = 0.0
    for number, line in enumerate(source.text.splitlines()[1:], 2):
        try:
            label, seconds = line.split()
            start, end = end, end + float(seconds)
        except ValueError as error:
            raise source.error(f"line {number} is {line!r}; write a label and its seconds") from error
        intervals.append(Interval(label, start, end))
    return Recording((Tier("phones", tuple(intervals)),), 0.0, end)
