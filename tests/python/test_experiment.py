"""raylex.experiment: a study is run, read and judged; the mistake of a Python integrator is found."""

import contextlib
import io
import sys
import unittest
from unittest import mock

import raylex
import test_plugins  # registers test_path
from support import CORNELL, Case, run_program

CONFIG = """
replicates = 2
[[scene]]
name = "box"
file = "{scene}"
resolution = [16, 16]
[[method]]
name = "path"
[[method]]
name = "lights"
integrator = {{ type = "path", strategy = "light" }}
[budget]
samples = [2, 4]
[reference]
method = "path"
spp = 32
[[channel]]
name = "direct"
lpe = "CDL"
"""


def rows(table):
    return table.to_dict("records") if hasattr(table, "to_dict") else table


class Studies(Case):
    def write(self, text):
        config = self.folder / "study.toml"
        config.write_text(text)
        return config

    def test_run_and_read(self):
        config = self.write(CONFIG.format(scene=CORNELL))
        results = raylex.experiment.run(config, self.folder / "out")
        cells = rows(results.cells())
        self.assertEqual(len(cells), 2 * 2 * 2)
        self.assertEqual({row["method"] for row in cells}, {"path", "lights"})
        self.assertFalse(any(row["failed"] for row in cells))
        errors = rows(results.errors())
        self.assertEqual(len(errors), len(cells) * 3)  # beauty, direct and rest
        self.assertTrue(all(row["relmse_mean"] > 0 for row in errors))
        self.assertEqual(results.mean(cells[0]["id"]).shape, (16, 16, 3))
        self.assertEqual({row["variant"] for row in rows(results.bias())}, {"path", "lights"})
        # The cells have the bits of the program's cells.
        done = run_program("experiment", "run", config, "-o", self.folder / "program")
        self.assertEqual(done.returncode, 0, done.stderr)
        theirs = raylex.experiment.Results(self.folder / "program")
        for row in cells:
            self.assertSameBits(results.mean(row["id"]), theirs.mean(row["id"]))
        # A second run is refused, and a resumed one has nothing left to do.
        self.assertRaylexError("resume", raylex.experiment.run, config, self.folder / "out")
        raylex.experiment.run(config, self.folder / "out", resume=True)

    def test_rows_are_named_and_results_print_a_summary(self):
        results = raylex.experiment.run(self.write(CONFIG.format(scene=CORNELL)), self.folder / "out")
        with mock.patch.dict(sys.modules, {"pandas": None}):  # as without pandas
            bias = results.bias()
            self.assertEqual(bias["variant"], [row["variant"] for row in bias])
            self.assertEqual(bias[0].variant, "path")
            self.assertIn(bias[0].convicts, (True, False))
            with self.assertRaisesRegex(AttributeError, "no column 'convict'.*convicts"):
                bias[0].convict
            header, first, *_ = str(bias).splitlines()
            self.assertIn("detectable_whole", header)
            self.assertIn("path", first)
            self.assertEqual(len(results.cells()), 8)
        summary = str(results)
        self.assertIn("8 cells done", summary)
        self.assertRegex(summary, r"path on box: error [0-9.]+ % in [0-9.e-]+ cpu seconds")
        self.assertRegex(summary, r"lights on box: .*bias")

    def test_plots(self):
        try:
            import matplotlib  # noqa: F401
        except ImportError:
            self.skipTest("python3-matplotlib is not installed")
        results = raylex.experiment.run(self.write(CONFIG.format(scene=CORNELL)), self.folder / "out")
        figure = results.plot()
        self.assertEqual(len(figure.axes[0].lines), 2)
        figure.savefig(self.folder / "plot.png")
        self.assertGreater((self.folder / "plot.png").stat().st_size, 1000)
        self.assertRaylexError("nothing was measured", results.plot, scene="no-such")

    def test_bad_configs(self):
        config = self.write(CONFIG.format(scene=CORNELL).replace("replicates", "replicate"))
        error = self.assertRaylexError("did you mean 'replicates'", raylex.experiment.run, config, self.folder / "out")
        self.assertEqual((error.file, error.line), (str(config), 2))
        self.assertRaylexError("no-such", raylex.experiment.run, "no-such.toml", self.folder / "out")
        self.assertRaylexError("no-such", raylex.experiment.Results(self.folder / "no-such").cells)


class Verdicts(Case):
    def test_a_mistake_is_found_and_named_and_a_correct_integrator_passes(self):
        judged = dict(resolution=(32, 32), spp=(16,), replicates=8, reference_spp=4096, max_depth=3)
        told = io.StringIO()
        with contextlib.redirect_stdout(told):
            right = raylex.experiment.verdict(CORNELL, "test_path", self.folder / "right", **judged)
        self.assertRegex(told.getvalue(), r"^test_path on scene: [^\n]+\n$")
        self.assertNotIn("BIASED", told.getvalue())
        self.assertFalse(any(row["convicts"] for row in rows(right.bias()) if row["variant"] == "judged"), right.bias())
        mistaken = {"type": "test_path", "mistake": True}
        told = io.StringIO()
        with contextlib.redirect_stdout(told):
            wrong = raylex.experiment.verdict(CORNELL, mistaken, self.folder / "wrong", **judged)
            raylex.experiment.verdict(CORNELL, "path", self.folder / "quiet", resolution=(8, 8), spp=(2,), replicates=2,
                                      reference_spp=4, quiet=True)
        self.assertRegex(told.getvalue(), r"^test_path on scene: BIASED[^\n]+bounce2[^\n]*\n$")
        found = {row["channel"] for row in rows(wrong.bias()) if row["variant"] == "judged" and row["convicts"]}
        self.assertIn("bounce2", found)  # a tenth of the light with two scattering events is missing
        self.assertNotIn("bounce1", found)
        self.assertEqual(rows(wrong.first_words())[0]["channel"], "bounce2")

    def test_an_integrator_that_fails_fails_the_study(self):
        @raylex.integrator("test_fails_in_study")
        class Fails:
            def integrate(self, batch):
                raise ZeroDivisionError("in a study")

        with self.assertRaisesRegex(ZeroDivisionError, "in a study"):
            raylex.experiment.verdict(CORNELL, "test_fails_in_study", self.folder, resolution=(8, 8), spp=(2,),
                                      reference_spp=4, replicates=2)


if __name__ == "__main__":
    unittest.main()
