"""raylex.lpe: proofs, counterexamples as objects, errors with columns."""

import unittest

import raylex
from raylex import lpe
from support import CORNELL, Case


class Proofs(Case):
    def test_a_hole_is_a_path(self):
        check = lpe.check({"direct": "C<RD>L", "indirect": "C<RD>[DS]+L"})
        self.assertFalse(check)
        self.assertEqual(check.verdict, "missed")
        self.assertEqual(check.channels, [])
        path = check.counterexample
        self.assertEqual(str(path), "C,- L,-")
        self.assertEqual([event.type for event in path.events], ["C", "L"])
        self.assertEqual(len(path), 2)
        # The counterexample is correct: neither channel accepts it.
        self.assertFalse(lpe.match("C<RD>L", path))
        self.assertFalse(lpe.match("C<RD>[DS]+L", path))

    def test_an_overlap_names_its_channels(self):
        check = lpe.check({"a": "CD+L", "b": "CDL", "c": "CL"}, what="disjoint")
        self.assertEqual(check.verdict, "counted_twice")
        self.assertEqual(check.channels, ["a", "b"])
        self.assertTrue(lpe.match("CD+L", check.counterexample) and lpe.match("CDL", check.counterexample))

    def test_the_shipped_partition_is_one(self):
        for dialect in ("renderman", "osl"):
            check = lpe.check(lpe.shipped(dialect), dialect=dialect)
            self.assertTrue(check, check.summary)
            self.assertIsNone(check.counterexample)

    def test_relative_to_a_scene(self):
        # Nothing in this scene is specular, and it has neither media nor background, so two channels are enough.
        channels = {"seen": "CL", "diffuse": "CD+L"}
        self.assertFalse(lpe.check(channels))
        self.assertTrue(lpe.check(channels, scene=CORNELL))
        self.assertTrue(lpe.check(channels, scene=raylex.Scene(CORNELL)))
        self.assertTrue(lpe.check(channels, words=lpe.words_of(CORNELL)))

    def test_relations(self):
        self.assertTrue(lpe.equal("CD+L", "CDD*L"))
        self.assertFalse(lpe.equal("CDL", "CD+L"))
        self.assertTrue(lpe.contains("CD+L", "CDL"))
        self.assertFalse(lpe.contains("CDL", "CD+L"))
        self.assertTrue(lpe.empty("CDL - CD+L"))
        self.assertEqual(lpe.empty("CDL").counterexample.events[1].scatter, "D")
        self.assertTrue(lpe.equal("osl:C<RD>L", "renderman:C<RD>L", words=lpe.Words(background=False, straight=False)))

    def test_paths_and_meaning(self):
        found = lpe.paths("C[DS]{1,2}L", "CSL", operation="difference", samples=3)
        self.assertEqual(len(found.samples), 3)
        self.assertEqual(found.longest, 4)
        self.assertTrue(all(lpe.match("C[DS]{1,2}L", path) for path in found.samples))
        self.assertIn("diffuse", str(lpe.explain("C<RD>L")))
        self.assertTrue(lpe.explain("C.*").is_beauty)
        why = lpe.why_not("C<RD>L", "C,- R,G L,-")
        self.assertFalse(why)
        self.assertEqual(why.live_events, 1)

    def test_overview(self):
        told = lpe.overview({"a": "CDL", "b": "C[DG]L"})
        self.assertEqual([(first, second) for first, second, _ in told["overlaps"]], [("a", "b")])
        self.assertTrue(any(kind == "seen directly" for kind, _, _ in told["holes"]))

    def test_channel_files(self):
        file = self.folder / "show.toml"
        file.write_text('[[channel]]\nname = "caustics"\nlpe = "CDS+L"\n')
        self.assertEqual(lpe.read(file), [("caustics", "CDS+L", "renderman")])
        file.write_text('[[channel]]\nname = "caustics"\nlpe = "CDS+"L"\n')
        self.assertEqual(self.assertRaylexError("show.toml", lpe.read, file).line, 3)


class BadInput(Case):
    def test_column_of_an_invalid_expression(self):
        error = self.assertRaylexError("expected", lpe.parse, "C<RD")
        self.assertEqual(error.column, 5)
        self.assertEqual(error.excerpt, "C<RD")
        error = self.assertRaylexError("channel 'b'", lpe.check, {"a": "CL", "b": "C]L"})
        self.assertEqual((error.file, error.column), ("channel 'b'", 2))

    def test_other_mistakes(self):
        self.assertRaylexError("expected 'partition', 'disjoint' or 'covers'", lpe.check, {"a": "CL"}, what="all")
        self.assertRaylexError("dialect", lpe.check, {"a": "CL"}, dialect="arnold")
        self.assertRaylexError("", lpe.Path, "C,- Q,-")
        self.assertRaylexError("'minus' is not an operation", lpe.paths, "CL", operation="minus")
        self.assertRaises(TypeError, lpe.check, {"a": 3})
        self.assertRaises(TypeError, lpe.equal, "CL", "CB", words=lpe.Words(), scene=CORNELL)
        self.assertRaylexError("no-such", lpe.check, {"a": "CL"}, scene="no-such.pbrt")


if __name__ == "__main__":
    unittest.main()
