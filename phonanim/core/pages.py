"""Write HTML pages: fill fields in one pass, embed data that cannot run as code, and set a content policy."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from typing import Any

FIELD = re.compile(r"\{\{(\w+)\}\}")
HEAD = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{{policy}}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{{title}}</title>
<style>
{{style}}
</style>
</head>"""
SCRIPT = re.compile(r"<script>(.*?)</script>", re.DOTALL)


def fill_page(
    page: str, fields: dict[str, str], connect: str = "", frames: str = "", scripts: str = ""
) -> str:
    """A page with its fields, filled in one pass: markers inside a field's text are left unchanged.

    A page that begins with `{{head}}` has the head of all pages, with the fields `title` and `style`. The
    field `policy` allows only the page's own script to run, and no connections except to the origins
    `connect`; `frames` are the origins of pages that may be shown within it, `scripts` those of scripts in
    files.
    """
    page = page.replace("{{head}}", HEAD, 1)
    script = SCRIPT.search(page)
    run = _filled(script[1], fields) if script else ""
    return _filled(page, {**fields, "policy": page_policy(run, connect, frames, scripts)})


def page_policy(script: str = "", connect: str = "", frames: str = "", scripts: str = "") -> str:
    """A content security policy: styles and data of the page, this script, and these origins."""
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")
    run = " ".join(filter(None, [f"'sha256-{digest}'" if script else "", scripts])) or "'none'"
    return "; ".join(
        [
            "default-src 'none'",
            f"script-src {run}",
            "style-src 'unsafe-inline'",
            "img-src data: blob:",
            "media-src data: blob:",
            f"connect-src data: blob: {connect}".rstrip(),
            *([f"frame-src {frames}"] if frames else []),
            "base-uri 'none'",
            "form-action 'none'",
        ]
    )


def script_data(data: Any) -> str:
    """JSON that is safe inside a page: no text in it can begin a tag."""
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _filled(page: str, fields: dict[str, str]) -> str:
    return FIELD.sub(lambda match: fields[match[1]], page)
