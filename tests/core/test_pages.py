import base64
import hashlib
import json
import re

import pytest
from animations import line

from phonanim.core.pages import fill_page, page_policy, script_data
from phonanim.exporters import save

LABELS = ["<!--<script>", "{{script}}", "</script><script>alert(1)</script>", "]]>", "a & b > c"]


def data_of(page):
    return json.loads(re.search(r'<script[^>]*id="data"[^>]*>(.*?)</script>', page, re.DOTALL)[1])


def policy_of(page):
    return re.search(r'<meta http-equiv="Content-Security-Policy" content="([^"]*)">', page)[1]


def test_fields_are_filled_in_one_pass():
    page = fill_page("<p>{{a}} {{b}}</p>", {"a": "{{b}}", "b": "{{policy}}"})
    assert page == "<p>{{b}} {{policy}}</p>"


def test_pages_have_one_head(root):
    page = fill_page("{{head}}\n<body></body>", {"title": "{{head}}", "style": "p {}"})
    assert page.startswith('<!doctype html>\n<html lang="en">\n<head>\n')
    assert "<title>{{head}}</title>\n<style>\np {}\n</style>\n</head>\n<body></body>" in page
    assert "script-src 'none'" in policy_of(page)
    templates = sorted((root / "phonanim").rglob("*.html"))
    assert len(templates) == 5
    assert all(one.read_text(encoding="utf-8").startswith("{{head}}\n<body>\n") for one in templates)


@pytest.mark.parametrize("label", LABELS)
def test_data_cannot_begin_a_tag(label):
    text = script_data({"label": label})
    assert "<" not in text
    assert json.loads(text) == {"label": label}


def test_the_policy_lets_the_one_script_run_and_nothing_be_fetched():
    page = fill_page('<meta content="{{policy}}"><script>\n{{script}}\n</script>', {"script": "run()"})
    digest = base64.b64encode(hashlib.sha256(b"\nrun()\n").digest()).decode()
    assert f"script-src 'sha256-{digest}'" in page
    assert "connect-src data: blob:;" in page
    assert "default-src 'none'; script-src 'none'" in page_policy()
    assert "connect-src data: blob: https://a.example;" in page_policy("", "https://a.example")


def test_the_viewer_says_labels_as_they_are(tmp_path):
    from dataclasses import replace

    from phonanim.speech.alignment import Interval

    animation = line()
    phones = tuple(Interval(label, n * 0.1, (n + 1) * 0.1) for n, label in enumerate(LABELS))
    save(replace(animation, phones=phones, provenance={"input": "{{data}}<b>"}), tmp_path / "a.html")
    page = (tmp_path / "a.html").read_text()
    assert [phone[0] for phone in data_of(page)["takes"][0]["phones"]] == LABELS
    assert "<title>{{data}}&lt;b&gt;</title>" in page
    script = re.search(r"<script>(.*?)</script>", page, re.DOTALL)[1]
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}'" in policy_of(page)
