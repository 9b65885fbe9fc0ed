"""The text in the bytes of a file whose encoding is not known."""

from __future__ import annotations

import codecs
import re

LOOKED_AT = 4000
"""Bytes that tell UTF-16 without a byte-order mark."""

_DECLARED = re.compile(rb"""<\?xml[^>]{0,200}?encoding\s*=\s*["']([A-Za-z0-9._-]{1,40})""")
_EIGHT_BIT = re.compile(r"(iso-?8859|windows|cp|koi8|shift|euc|gb|big5|latin|mac|us-ascii)", re.IGNORECASE)
_KANA = re.compile("[\u3041-\u30fe]")
JAPANESE = ("cp932", "euc_jp")
"""Encodings of Japanese programs, such as UTAU and Julius."""


def decode_text(data: bytes) -> str:
    """Text in UTF-8, UTF-16, the encoding that an XML document declares, Shift-JIS, EUC-JP, or Latin-1."""
    if data[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
        return data.decode("utf-16", errors="replace")
    if wide := _wide(data[:LOOKED_AT]):
        return data.decode(wide, errors="replace")
    declared = _DECLARED.match(data.lstrip()[:400])
    if declared and _EIGHT_BIT.match(name := declared[1].decode()):
        try:
            return data.decode(name)
        except (LookupError, UnicodeDecodeError):
            pass  # it is in another encoding than it says
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return _old(data)


def _wide(head: bytes) -> str:
    """UTF-16 without a mark: nearly every other byte is 0. "" for anything else."""
    half = len(head) // 2
    if half < 8:
        return ""
    odd, even = head[1::2].count(0), head[0::2].count(0)
    if odd > 0.4 * half and even < 0.05 * half:
        return "utf-16-le"
    return "utf-16-be" if even > 0.4 * half and odd < 0.05 * half else ""


def _old(data: bytes) -> str:
    """Text in an encoding of one or two bytes: Japanese where it has kana so, else Latin-1."""
    for name in JAPANESE:
        try:
            text = data.decode(name)
        except UnicodeDecodeError:
            continue
        if _KANA.search(text):
            return text
    return data.decode("latin-1")
