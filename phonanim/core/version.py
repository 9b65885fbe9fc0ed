"""The version of the package: the newest one in CHANGELOG.md."""

__version__ = "0.1.0"
