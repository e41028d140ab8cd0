"""The includes of src, include and python against the column "may include" of docs/architecture.md.

Usage: layers_test.py PROJECT_FOLDER
"""

import os
import re
import sys

INCLUDE = re.compile(r'\s*#\s*include\s+["<]([^">]+)[">]')


def layers(page):
    """The folders of the table, in its order, and which others each may include."""
    table = page.split("| may include |\n", 1)[1].split("\n\n", 1)[0]
    rows = re.findall(r"^\| `([a-z/]+)`.*\| ([^|]+) \|$", table, re.MULTILINE)
    folders = [folder for folder, _ in rows]
    allowed = {}
    for i, (folder, may) in enumerate(rows):
        everything, _, exceptions = may.partition(" but ")
        if everything == "all above":
            names = set(folders[:i])
        elif everything == "all":
            names = set(folders)
        else:
            names = set(re.findall(r"[a-z/]+", everything))
            for name in tuple(names):
                names |= allowed[name]  # what a folder may include its users may, too
        names -= set(re.findall(r"[a-z/]+", exceptions.replace(" and ", " ")))
        if "viewer" not in names:
            names.discard("viewer/gui")
        allowed[folder] = names
    return allowed


def folder_of(path, folders):
    """The longest of the folders that has this path."""
    return max((f for f in folders if path.startswith(f + "/")), key=len, default=None)


def main(project):
    with open(os.path.join(project, "docs", "architecture.md"), encoding="utf-8") as file:
        allowed = layers(file.read())
    assert {"core", "mesh", "cli", "viewer/gui", "python"} <= set(allowed), allowed
    roots = {"src": "", "include/tetraction": "", "python/src": "python/"}
    wrong, seen = [], 0
    for root, prefix in roots.items():
        for directory, _, names in os.walk(os.path.join(project, root)):
            for name in names:
                if not name.endswith((".h", ".cc")):
                    continue
                path = os.path.join(directory, name)
                own = prefix + os.path.relpath(path, os.path.join(project, root))
                folder = folder_of(own, allowed)
                assert folder, f"docs/architecture.md does not name the folder of {own}"
                with open(path, encoding="utf-8") as file:
                    included = [m.group(1) for m in map(INCLUDE.match, file) if m]
                for header in included:
                    header = header.removeprefix("tetraction/")
                    other = folder_of(header, allowed)
                    if other is None or other == folder:
                        continue
                    seen += 1
                    if other not in allowed[folder]:
                        wrong.append(f"{own}: {folder} must not include {header}")
    assert seen > 300, seen
    print("\n".join(wrong) or f"{seen} includes of other folders, all as the table says")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
