"""Runs a notebook from top to bottom; what its cells print must be what the file has.

    python run_notebook.py NOTEBOOK            fails at the first cell that prints something else
    python run_notebook.py NOTEBOOK --write    writes what they print into the file

Only printed text counts, which is all that the notebook's cells make.
"""

import contextlib
import io
import json
import os
import sys
from pathlib import Path


def outputs(text):
    """A cell's outputs in the notebook's form."""
    if not text:
        return []
    lines = text.splitlines(keepends=True)
    return [{"name": "stdout", "output_type": "stream", "text": lines}]


def printed(cell, scope):
    """Runs a cell and returns what it prints."""
    text = io.StringIO()
    with contextlib.redirect_stdout(text):
        exec(compile("".join(cell["source"]), "cell", "exec"), scope)
    return text.getvalue()


def main():
    """Runs the notebook in its own folder."""
    path = Path(sys.argv[1]).resolve()
    is_writing = "--write" in sys.argv[2:]
    notebook = json.loads(path.read_text(encoding="utf-8"))
    os.chdir(path.parent)
    scope = {"__name__": "__main__"}
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    for number, cell in enumerate(cells, start=1):
        found = outputs(printed(cell, scope))
        if not is_writing and found != cell["outputs"]:
            expected = json.dumps(cell["outputs"], ensure_ascii=False)
            sys.exit(
                f"{path.name}: cell {number} printed {json.dumps(found, ensure_ascii=False)}, "
                f"expected {expected}"
            )
        cell["outputs"], cell["execution_count"] = found, number
    if is_writing:
        text = json.dumps(notebook, indent=1, ensure_ascii=False)
        path.write_text(text + "\n", encoding="utf-8")
    print(f"{path.name}: {len(cells)} cells run")


if __name__ == "__main__":
    main()
