"""The site of the documentation: it is built without a warning, and its links lead somewhere.

Usage: python3 site_test.py SOURCE_TREE [unittest arguments]

Without the packages of `scripts/setup --docs` the test is skipped (exit code 77).
"""

import glob
import html.parser
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
import urllib.parse

TREE = os.path.abspath(sys.argv[1])


class Page(html.parser.HTMLParser):
    """The links of a page, what it loads, and the places in it."""

    def __init__(self, path):
        super().__init__()
        self.links, self.loaded, self.places = [], [], set()
        with open(path, encoding="utf-8") as file:
            self.feed(file.read())

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        if attributes.get("id"):
            self.places.add(attributes["id"])
        if tag == "a" and attributes.get("href"):
            self.links.append(attributes["href"])
        elif tag in ("link", "script", "img"):
            source = attributes.get("href") or attributes.get("src")
            if source and not source.startswith("data:"):
                self.loaded.append(source)


class Site(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="tetraction-site-")
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        cls.result = subprocess.run([os.path.join(TREE, "scripts", "docs"), cls.folder],
                                    capture_output=True, encoding="utf-8", timeout=600)  # fmt: skip
        cls.html = os.path.join(cls.folder, "html")
        cls.pages = {path: Page(path)
                     for path in glob.glob(os.path.join(cls.html, "**", "*.html"), recursive=True)}  # fmt: skip

    def test_no_warnings(self):
        self.assertEqual(self.result.returncode, 0, self.result.stdout + self.result.stderr)
        self.assertEqual(self.result.stderr, "")
        self.assertTrue(os.path.exists(os.path.join(self.html, "index.html")))

    def test_every_document_is_a_page(self):
        docs = os.path.join(TREE, "docs")
        for path in glob.glob(os.path.join(docs, "**", "*.md"), recursive=True):
            if os.path.relpath(path, docs).startswith("images"):
                continue  # how the pictures are made
            page = os.path.relpath(path, docs)[: -len(".md")] + ".html"
            self.assertIn(os.path.join(self.html, page), self.pages)

    def test_links_lead_somewhere(self):
        for path, page in self.pages.items():
            for link in page.links:
                parts = urllib.parse.urlsplit(link)
                if parts.scheme:
                    continue
                target = path
                if parts.path:
                    target = os.path.normpath(
                        os.path.join(os.path.dirname(path), urllib.parse.unquote(parts.path))
                    )
                self.assertTrue(os.path.exists(target), f"{path}: {link}")
                place = urllib.parse.unquote(parts.fragment)
                if place and target in self.pages:
                    self.assertIn(place, self.pages[target].places, f"{path}: {link}")

    def test_nothing_is_loaded_from_the_network(self):
        for path, page in self.pages.items():
            for source in page.loaded:
                parts = urllib.parse.urlsplit(source)
                self.assertEqual((parts.scheme, parts.netloc), ("", ""), f"{path}: {source}")
                file = os.path.join(os.path.dirname(path), urllib.parse.unquote(parts.path))
                self.assertTrue(os.path.exists(os.path.normpath(file)), f"{path}: {source}")

    def test_the_reference_has_every_header(self):
        headers = os.path.join(TREE, "include", "tetraction")
        for folder in os.listdir(headers):
            with open(os.path.join(self.html, "api", folder + ".html"), encoding="utf-8") as file:
                text = file.read()
            for inner, _, names in os.walk(os.path.join(headers, folder)):
                for name in names:
                    self.assertIn(os.path.relpath(os.path.join(inner, name), os.path.dirname(headers)), text)
        with open(os.path.join(self.html, "api", "mesh.html"), encoding="utf-8") as file:
            self.assertIn("generate_box", file.read())


if __name__ == "__main__":
    modules = ("sphinx", "myst_parser", "breathe", "furo")
    missing = [name for name in modules if importlib.util.find_spec(name) is None]
    if missing or not shutil.which("doxygen"):
        print("skipped: scripts/setup --docs installs what is missing", *missing)
        sys.exit(77)
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
