"""The pages of the documentation and their fenced blocks."""

import glob
import os
import re

COMMAND = re.compile(r"^(\$ )?(tetraction|scripts/|cmake|ctest|cpack|build/|python3?|pip|git|apt(-get)?|sudo) ?")
MARK = re.compile(
    r"<!-- (not run|shortened|before it|added to|file|file scope|only compiled):\s+(.*?)\s*-->", re.DOTALL)


def pages_of(tree):
    """README.md and the pages in docs/, relative to the source tree."""
    found = glob.glob(os.path.join(tree, "docs", "**", "*.md"), recursive=True)
    return ["README.md"] + sorted(os.path.relpath(path, tree) for path in found)


class Block:
    def __init__(self, page, line, language, text, marks):
        self.page, self.line, self.language = page, line, language
        self.text, self.marks = text, marks

    def __str__(self):
        return f"{self.page}:{self.line}"


def blocks_of(tree, page):
    """The fenced blocks of a page, and the lines at which indented blocks begin with a command."""
    with open(os.path.join(tree, page), encoding="utf-8") as file:
        lines = file.read().split("\n")
    blocks, indented = [], []
    n = 0
    while n < len(lines):
        fence = re.match(r"^(`{3,})(.*)$", lines[n])
        if fence:
            end = next(k for k in range(n + 1, len(lines)) if lines[k].startswith(fence[1]))
            # The comments right before the block, which may have several lines.
            before, marks = n, {}
            while before > 0 and lines[before - 1].endswith("-->"):
                start = next(k for k in range(before - 1, -1, -1) if lines[k].startswith("<!--"))
                mark = MARK.fullmatch("\n".join(lines[start:before]))
                if mark:
                    marks[mark[1]] = mark[2].strip()
                before = start
            text = "\n".join(lines[n + 1 : end]) + "\n"
            blocks.append(Block(page, n + 1, fence[2].strip(), text, marks))
            n = end + 1
            continue
        begins = lines[n].startswith("    ") and (n == 0 or not lines[n - 1].strip())
        if begins and COMMAND.match(lines[n].strip()):
            indented.append(n + 1)
        n += 1
    return blocks, indented
