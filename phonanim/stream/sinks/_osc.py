"""Bundles of Open Sound Control messages."""

from __future__ import annotations

from collections.abc import Sequence

from pythonosc.osc_bundle_builder import IMMEDIATELY, OscBundleBuilder
from pythonosc.osc_message_builder import OscMessageBuilder

Message = tuple[str | float, ...]  # the path, then the values


def bundle(messages: Sequence[Message]) -> bytes:
    """Pack messages into one packet."""
    built = OscBundleBuilder(IMMEDIATELY)
    for path, *values in messages:
        message = OscMessageBuilder(str(path))
        for value in values:
            message.add_arg(value)
        built.add_content(message.build())
    return built.build().dgram
