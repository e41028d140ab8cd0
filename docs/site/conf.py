"""Settings of Sphinx for the site that scripts/docs builds from the Markdown files in docs/.

The files are written for readers of the source tree, so that their links are paths within it. Three things are done
to each of them when it is read:

- A link to a file of docs/ stays, one to another file of the source tree becomes a copy of that file in the site, and
  one to a folder becomes its path in text.
- A comment <!-- page: README.md --> is replaced by that file of the source tree.
- Comments become directives: <!-- toctree CAPTION ... --> lists the pages of the navigation, and
  <!-- headers: FOLDER --> is the reference of the public headers in include/tetraction/FOLDER. <!-- python --> is
  that of the Python package, if it is built.
"""

import importlib.util
import os
import re
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
DOCS = os.path.join(ROOT, "docs")
# Files of the source tree that are pages of the site.
PAGES = {
    "README.md": "site/readme",
    "CONTRIBUTING.md": "site/contributing",
    "CHANGELOG.md": "site/changelog",
}

project = "Tetraction"
author = "The Tetraction developers"
with open(os.path.join(ROOT, "CITATION.cff"), encoding="utf-8") as file:
    version = release = re.search(r"^version: (\S+)", file.read(), re.MULTILINE)[1]

extensions = ["myst_parser", "breathe", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
source_suffix = {".md": "markdown"}
root_doc = "index"
exclude_patterns = ["images"]

# Anchors of headings as they are in other viewers of Markdown, and <img> tags.
myst_heading_anchors = 4
myst_enable_extensions = ["html_image"]

# scripts/docs has doxygen write this folder.
breathe_projects = {"tetraction": os.environ["TETRACTION_DOXYGEN_XML"]}
breathe_default_project = "tetraction"
breathe_default_members = ("members",)
breathe_show_include = False
primary_domain = "cpp"
highlight_language = "none"

PYTHON = os.environ.get("TETRACTION_PYTHON", os.path.join(ROOT, "build", "release", "python"))
sys.path.insert(0, PYTHON)
autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_ivar = True

html_theme = "furo"
html_title = f"Tetraction {version}"
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
# Nothing is loaded from the network: Furo's own fonts are those of the system.
html_static_path = []

LINK = re.compile(r"(\]\()([^()\s]+)(\))")
IMAGE = re.compile(r'(<img src=")([^"]+)(")')
FOLDER = re.compile(r"\[([^\[\]]*)\] \(`([^`]*)`\)")
PAGE = re.compile(r"<!-- page: (\S+) -->")
TOCTREE = re.compile(r"<!-- toctree ([^\n]+)\n(.*?)-->", re.DOTALL)
PYTHON_PACKAGE = "<!-- python -->"
HEADERS = re.compile(r"<!-- headers: (\S+) -->")
FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)


def target_of(link, origin, page):
    """What a link in the file `origin` is in `page`, both as folders: a path, or None for a folder."""
    path, mark, anchor = link.partition("#")
    file = os.path.normpath(os.path.join(origin, path))
    if os.path.isdir(file):
        return None
    name = os.path.relpath(file, ROOT)
    if name in PAGES:
        file = os.path.join(DOCS, PAGES[name] + ".md")
    return os.path.relpath(file, page) + mark + anchor


def with_links(text, origin, page):
    """The text of a file in the folder `origin`, with links for a page in the folder `page`."""

    def replaced(match):
        link = match[2]
        if re.match(r"[a-z]+:|#", link):
            return match[0]
        target = target_of(link, origin, page)
        if target is None:
            return f"] (`{os.path.relpath(os.path.join(origin, link), ROOT)}`)"
        return match[1] + target + match[3]

    text = IMAGE.sub(replaced, LINK.sub(replaced, text))
    # What was a link to a folder is plain text, and only the path if the text was the path, too.
    return FOLDER.sub(lambda m: f"`{m[2]}`" if m[1].strip("/") == m[2] else f"{m[1]} (`{m[2]}`)", text)


def outside_fences(text, change):
    """The text with `change` made in all of it but fenced code."""
    parts, end = [], 0
    for fence in FENCE.finditer(text):
        parts += [change(text[end : fence.start()]), fence[0]]
        end = fence.end()
    return "".join(parts) + change(text[end:])


def toctree(match):
    return f"```{{toctree}}\n:hidden:\n:caption: {match[1]}\n\n{match[2]}```\n"


def reference(match):
    """The directives of Breathe for the headers of a folder and of the folders inside it."""
    folder = os.path.join(ROOT, "include", "tetraction", match[1])
    lines = []
    for inner, folders, headers in os.walk(folder):
        folders.sort()
        for header in sorted(headers):
            if not header.endswith(".h"):
                continue
            path = os.path.relpath(os.path.join(inner, header), folder)
            name = f"tetraction/{match[1]}/{path}"
            lines += [f"## {path}", "", f"    #include \"{name}\"", "",
                      f"```{{doxygenfile}} {name}", ":sections: briefdescription detaileddescription "
                      "innerclass innernamespace enum func define typedef var "
                      "public-type public-func public-static-func public-attrib public-static-attrib "
                      "protected-func protected-attrib user-defined", "```", ""]  # fmt: skip
    return "\n".join(lines)


def python_reference():
    """The directives of autodoc for the public names of the Python package."""
    if importlib.util.find_spec("tetraction") is None:
        return "The package was not built when this site was made."
    import tetraction as package

    names = {"Runs": ["run", "static", "modes", "study", "read_study", "Session", "Modes", "Study",
                      "Motion", "ProbeSeries"],
             "Scenes": ["read_scene", "Scene", "CustomMaterial", "ForceField"],
             "Meshes": ["read_mesh", "Mesh"]}  # fmt: skip
    kinds = {name: getattr(package, name) for name in package.__all__}
    classes = {name: kind for name, kind in kinds.items() if isinstance(kind, type)}
    names["Edits"] = [n for n, kind in classes.items() if issubclass(kind, package.Edit)]
    names["Settings"] = [n for n, kind in classes.items() if issubclass(kind, package.Material.__base__)]
    names["Errors"] = [n for n, kind in classes.items() if issubclass(kind, package.Error)]
    named = sum(names.values(), [])
    names["Others"] = [n for n in package.__all__ if n not in named and n != "material"]
    lines = []
    for heading, entries in names.items():
        lines += [f"## {heading}", "", "```{eval-rst}"]
        for name in entries:
            directive = "autofunction" if name not in classes else "autoclass"
            if name in classes and issubclass(classes[name], package.Error):
                directive = "autoexception"
            lines.append(f".. {directive}:: tetraction.{name}")
            # The members of settings are the keys, which the text of the class lists.
            if directive == "autoclass" and name not in names["Settings"] + names["Edits"]:
                lines.append("   :members:")
            lines.append("")
        lines += ["```", ""]
    lines += ["## Laws of materials", "", "```{eval-rst}", ".. automodule:: tetraction.material", "   :members:",
              "```", ""]  # fmt: skip
    return "\n".join(lines)


def read(app, name, source):
    origin = page = os.path.dirname(os.path.join(DOCS, name))
    text = source[0]
    stub = PAGE.search(text)
    if stub:
        with open(os.path.join(ROOT, stub[1]), encoding="utf-8") as file:
            text = file.read()
        origin = os.path.dirname(os.path.join(ROOT, stub[1]))
    text = outside_fences(text, lambda part: with_links(part, origin, page))
    text = HEADERS.sub(reference, TOCTREE.sub(toctree, text))
    if PYTHON_PACKAGE in text and page.endswith("api"):
        text = text.replace(PYTHON_PACKAGE, python_reference())
    source[0] = text


def setup(app):
    app.connect("source-read", read)
