"""Executes the notebooks of docs/notebooks; a cell that raises fails. Usage: notebooks.py FOLDER [NAME]"""

import os
import sys
import tempfile

try:
    import ipykernel  # noqa: F401
    import nbclient
    import nbformat
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)


def main(folder, names):
    for name in names or sorted(os.listdir(folder)):
        if not name.endswith(".ipynb"):
            continue
        notebook = nbformat.read(os.path.join(folder, name), as_version=4)
        nbformat.validate(notebook)
        with_output = [c for c in notebook.cells if c.cell_type == "code" and c.outputs]
        assert not with_output, f"{name}: clear the outputs before it is stored"
        with tempfile.TemporaryDirectory() as work:
            client = nbclient.NotebookClient(
                notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": work}})
            client.execute()
        print(name, "ran")


main(sys.argv[1], sys.argv[2:])
