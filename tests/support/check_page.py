# SPDX-License-Identifier: BSD-3-Clause
"""check_page.py FILE.html...: a report is well-formed XML, needs no network and no script, is smaller than 2 MB, links
only to files that are there, and says in words what its pictures show."""
import os
import sys
import urllib.parse
import xml.dom.minidom

SPACE = "http://www.w3.org/1999/xhtml"


def check(path):
    with open(path, encoding="utf-8") as file:
        text = file.read()
    assert len(text.encode()) < 2_000_000, "it is larger than 2 MB"
    assert text.replace(SPACE, "").find("http") < 0, "it names an address of the network"
    tree = xml.dom.minidom.parseString(text)
    assert tree.documentElement.getAttribute("lang") == "en", "its language is not given"
    ids = [e.getAttribute("id") for e in tree.getElementsByTagName("*") if e.hasAttribute("id")]
    assert len(ids) == len(set(ids)), "two elements have one id"
    for element in tree.getElementsByTagName("*"):
        name = element.tagName
        assert name not in ("script", "link", "iframe", "object", "embed", "base"), name
        for key, value in element.attributes.items():
            assert not key.lower().startswith("on"), key
            if key in ("src", "href") and not value.startswith("data:image/png;base64,"):
                assert ":" not in value, value
                there = os.path.join(os.path.dirname(path), urllib.parse.unquote(value))
                assert os.path.isfile(there), f"{value} is not there"
        if name == "img":
            assert element.getAttribute("alt"), "a picture without words"
        if name == "svg" and element.parentNode.tagName != "svg":
            words = [c for c in element.childNodes if getattr(c, "tagName", "") == "title"]
            assert element.hasAttribute("aria-hidden") or words, "a plot without words"


for name in sys.argv[1:]:
    try:
        check(name)
    except Exception as error:  # whatever it is, the page is to be named
        sys.exit(f"{name}: {error!r}")
