"""Runs every cell of the notebooks and checks their output. Only with --full: each takes a minute."""

import json
import subprocess
import sys
import unittest

from support import FULL, ROOT, Case

NOTEBOOKS = ROOT / "experiments" / "notebooks"


def has_nbconvert():
    asked = [sys.executable, "-m", "nbconvert", "--version"]
    return subprocess.run(asked, capture_output=True, check=False).returncode == 0


@unittest.skipUnless(FULL, "of --full")
class Notebooks(Case):
    def outputs(self, name):
        """Executes a notebook. Returns [[output as text and HTML] for each cell with code]."""
        if not has_nbconvert():
            self.skipTest("jupyter-nbconvert is not installed")
        done = subprocess.run([sys.executable, "-m", "nbconvert", "--to", "notebook", "--execute",
                               "--ExecutePreprocessor.timeout=600", "--output-dir", self.folder, NOTEBOOKS / name],
                              capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        cells = []
        for cell in json.loads((self.folder / name).read_text())["cells"]:
            if cell["cell_type"] != "code":
                continue
            text = ""
            for output in cell["outputs"]:
                text += "".join(output.get("text", ""))
                text += " ".join(output.get("data", {}))  # kinds of output
                for kind in ("text/plain", "text/html"):
                    text += "".join(output.get("data", {}).get(kind, ""))
            cells.append(text)
        return cells

    def test_split_a_scene(self):
        cells = self.outputs("split-a-scene.ipynb")
        self.assertIn("fails", cells[1])  # the split that misses a path, and the path
        self.assertIn("C,-", cells[1])
        self.assertIn("data:image/png;base64,", cells[3])
        self.assertIn("auto:", cells[3])
        self.assertIn("holds", cells[4])
        self.assertNotIn("DOES NOT HOLD", cells[4])

    def test_compare_two_integrators(self):
        cells = self.outputs("compare-two-integrators.ipynb")
        self.assertIn("lights", cells[1])
        self.assertIn("image/png", cells[2])
        self.assertIn("False", cells[3])
        self.assertNotIn("True", cells[3])  # neither is biased

    def test_your_own_integrator(self):
        cells = self.outputs("your-own-integrator.ipynb")
        self.assertIn("samples a second", cells[1])
        self.assertNotIn("True", cells[2])
        self.assertIn("bounce2", cells[3])

    def test_ask_later(self):
        cells = self.outputs("ask-later.ipynb")
        self.assertIn("True", cells[0])
        self.assertIn("C R,D", cells[1])
        self.assertIn("data:image/png;base64,", cells[2])
        self.assertIn("auto:", cells[2])
        self.assertIn("&plusmn;", cells[3])
        self.assertIn("rest", cells[4])
        self.assertIn("holds", cells[5])
        self.assertIn("cannot be computed exactly", cells[7])
        self.assertIn("at least", cells[7])


class Kept(Case):
    def test_without_outputs(self):
        for notebook in NOTEBOOKS.glob("*.ipynb"):
            for cell in json.loads(notebook.read_text())["cells"]:
                self.assertFalse(cell.get("outputs"), notebook.name)


if __name__ == "__main__":
    unittest.main()
