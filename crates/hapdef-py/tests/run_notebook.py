"""Runs a notebook from top to bottom; what its cells print must be what the file has.

    python run_notebook.py NOTEBOOK            fails at the first cell that prints something else
    python run_notebook.py NOTEBOOK --write    writes what they print and draw into the file

Printed text is compared, and how many pictures there are; pixels depend on Matplotlib's version.
"""

import copy
import sys
from pathlib import Path

import nbformat
from nbclient import NotebookClient

# Seconds that a cell may take: the limb is solved in one of them.
PATIENCE_S = 1200


def shown(cell):
    """What a cell has printed, and how many pictures it has drawn."""
    text = "".join(o.text for o in cell.outputs if o.output_type == "stream")
    pictures = [o for o in cell.outputs if "image/png" in o.get("data", {})]
    return text, len(pictures)


def code(notebook):
    """The notebook's cells with code."""
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def main():
    """Runs the notebook in its own folder."""
    path = Path(sys.argv[1]).resolve()
    committed = nbformat.read(path, as_version=4)
    fresh = copy.deepcopy(committed)
    client = NotebookClient(
        fresh,
        timeout=PATIENCE_S,
        kernel_name="python3",
        record_timing=False,
        coalesce_streams=True,
        resources={"metadata": {"path": str(path.parent)}},
    )
    client.execute()
    fresh.metadata = committed.metadata
    if "--write" in sys.argv[2:]:
        nbformat.write(fresh, path)
    else:
        for number, (old, new) in enumerate(zip(code(committed), code(fresh)), start=1):
            if shown(old) != shown(new):
                sys.exit(
                    f"{path.name}: cell {number} shows {shown(new)}, expected {shown(old)}"
                )
    print(f"{path.name}: {len(code(fresh))} cells run")


if __name__ == "__main__":
    main()
