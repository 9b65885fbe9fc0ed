"""XML of alignments. A document that declares entities is refused, since they can grow without end."""

from __future__ import annotations

import re
from xml.etree import ElementTree

from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

XML_DAMAGE = (*DAMAGE, ElementTree.ParseError)
"""The exceptions that a document of the wrong structure raises."""


def parse_xml(source: AlignmentFile, text: str | None = None) -> ElementTree.Element:
    """The root of a document, whose `text` may have been changed.

    Raises ParseError, and ValueError for a document that declares entities.
    """
    text = (source.text if text is None else text).strip()
    if re.search(r"<!\s*(ENTITY|DOCTYPE)", text, re.IGNORECASE):
        raise ValueError("it declares entities, which an alignment does not need")
    # The text is decoded already, so what the document says of its encoding does not hold.
    return ElementTree.fromstring(re.sub(r"^<\?xml[^>]*\?>", "", text))
