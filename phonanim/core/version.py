"""The version of the package: that on top of CHANGELOG.md."""

__version__ = "0.1.0"
