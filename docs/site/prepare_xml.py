"""Changes what doxygen wrote so that Breathe can make a section of each header of it.

- Doxygen describes functions, enumerations and variables of a namespace in the file of the namespace only. They are
  moved to the files of the headers that declare them.
- Designated initialisers are left out, because Sphinx 5 does not parse them.

Usage: python3 prepare_xml.py FOLDER      (of doxygen's XML)
"""

import glob
import os
import re
import sys
import xml.etree.ElementTree as ElementTree


def drop_designated_initializers(compound):
    """Returns whether there were any."""
    found = False
    for member in compound.iter("memberdef"):
        for part in ("initializer", "argsstring"):
            element = member.find(part)
            if element is not None and re.search(r"\{\s*\.", "".join(element.itertext())):
                member.remove(element)
                found = True
    return found


def section_of(compound, kind):
    """The section of a file's members of one kind, which is made if it is missing."""
    for section in compound.findall("sectiondef"):
        if section.get("kind") == kind:
            return section
    section = ElementTree.Element("sectiondef", kind=kind)
    # Sections stand before the descriptions.
    compound.insert(list(compound).index(compound.find("briefdescription")), section)
    return section


def main(folder):
    trees, headers, namespaces, changed = {}, {}, [], set()
    for path in glob.glob(os.path.join(folder, "*.xml")):
        trees[path] = ElementTree.parse(path)
        compound = trees[path].getroot().find("compounddef")
        if compound is None:
            continue
        if drop_designated_initializers(compound):
            changed.add(path)
        if compound.get("kind") == "file":
            headers[compound.find("location").get("file")] = (path, compound)
            for inner in compound.findall("innernamespace"):
                compound.remove(inner)
                changed.add(path)
        elif compound.get("kind") == "namespace":
            namespaces.append(compound)
    for namespace in namespaces:
        for section in namespace.findall("sectiondef"):
            for member in section.findall("memberdef"):
                path, compound = headers[member.find("location").get("file")]
                section_of(compound, section.get("kind")).append(member)
                changed.add(path)
    for path in changed:
        trees[path].write(path, encoding="utf-8", xml_declaration=True)


main(sys.argv[1])
