"""raylex.Atlas: layers, bright words and suggestions after the render, equal to the program's and to rendered ones."""

import unittest

import numpy as np

import raylex
from support import CORNELL, Case, run_program, white_furnace

SETTINGS = dict(spp=8, resolution=(20, 14), max_depth=4)
SPLIT = {"direct": "C<RD>L", "indirect": "C<RD>[DS]+L"}
ROUNDING = 2.0 ** -23  # a word, their sum and the rendered layer are rounded to float once each, at most 2^-24


class Asked(Case):
    def render(self, name="a.atlas.exr", **more):
        """An image and its atlas."""
        file = self.folder / name
        scene = raylex.Scene(CORNELL).label("light", "area:0", "key")
        image = raylex.render(scene, **{**SETTINGS, "atlas": {"file": str(file), "length": 6}, **more})
        return image, raylex.Atlas(more["atlas"]["file"] if "atlas" in more else file)

    def test_layers_equal_rendered_ones(self):
        image, atlas = self.render(lpe=SPLIT, shipped=True, light_groups=True)
        asked = atlas.ask(SPLIT, shipped=True, light_groups=True)
        self.assertEqual(asked.names, image.names)
        self.assertEqual(asked.partitions, image.partitions)
        self.assertTrue(all(asked.verify()))
        self.assertSameBits(asked["beauty"], image["beauty"])
        whole = sum(np.abs(image[name].astype(float)) for name in image.names if name not in ("beauty", "alpha"))
        for name in image.names:
            if name != "alpha":
                difference = np.abs(asked[name].astype(float) - image[name])
                self.assertTrue((difference <= ROUNDING * whole).all(), name)
        # The program gives the same for this file.
        layers = self.folder / "layers.exr"
        done = run_program("ask", atlas.path, "--lpe", "direct=C<RD>L", "-o", layers)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertSameBits(np.ascontiguousarray(raylex.read(layers)["direct"]), asked["direct"])
        asked.write(self.folder / "written.exr")
        self.assertEqual(run_program("verify", self.folder / "written.exr").returncode, 0)

    def test_beauty_has_the_same_bits_and_the_words_sum_to_it(self):
        image, atlas = self.render()
        self.assertSameBits(image["beauty"], raylex.render(raylex.Scene(CORNELL), **SETTINGS)["beauty"])
        verdict = atlas.verify()
        self.assertTrue(verdict)
        self.assertLessEqual(verdict.largest_relative, ROUNDING)
        self.assertEqual((atlas.width, atlas.height, atlas.length, atlas.by), (20, 14, 6, "label,lobe,group"))

    def test_brightest_words_of_a_pixel(self):
        image, atlas = self.render()
        pixel = atlas.at(9, 7, top=3)
        self.assertEqual(len(pixel), 3)
        self.assertTrue(np.allclose(pixel.rgba[:3], image["beauty"][7, 9]))
        self.assertEqual(pixel.samples, 8)
        light = [word.mean for _, word in pixel]
        self.assertEqual(light, sorted(light, reverse=True))
        self.assertTrue(all(text.startswith("C ") for text, _ in pixel))
        self.assertIn(" R,D", repr(pixel))
        self.assertIn("<code>C ", pixel._repr_html_())
        everything = atlas.at(9, 7, top=100000)
        self.assertEqual(everything.more, 0)
        self.assertTrue(np.isclose(sum(w.mean for _, w in everything), everything.mean, rtol=1e-5))
        self.assertRaylexError("outside the image", atlas.at, 20, 0)
        self.assertRaylexError("expected 1 or more", atlas.at, 0, 0, 0)

    def test_errors_and_suggestions(self):
        _, atlas = self.render()
        asked = atlas.ask({"direct": "C<RD>L"}, errors=True)
        self.assertEqual(asked["direct_error"].shape, (14, 20))
        layers = atlas.suggest(2)
        self.assertEqual((len(layers), layers[-1].name, layers[-1].expression), (3, "rest", ""))
        self.assertTrue(np.isclose(sum(each.noise for each in layers), 1))
        self.assertTrue(np.isclose(sum(each.light for each in layers), 1, rtol=1e-5))
        split = atlas.ask({each.name: each.expression for each in layers if each.expression})
        self.assertTrue(all(split.verify()))

    def test_entries(self):
        image, atlas = self.render()
        entries = atlas.entries()
        pixels = np.repeat(np.arange(14 * 20), np.diff(entries["begin"]))
        sums = np.zeros((14 * 20, 3))
        np.add.at(sums, pixels, entries["rgb"].astype(float))
        bound = ROUNDING * (sums + image["beauty"].reshape(-1, 3))
        self.assertTrue((np.abs(sums - image["beauty"].reshape(-1, 3)) <= bound).all())
        self.assertLess(entries["word"].max(), len(atlas.words))
        self.assertEqual(entries["samples"].sum(), 8 * 14 * 20)

    def test_merging(self):
        self.render("a.atlas.exr", seed=1)
        self.render("b.atlas.exr", seed=2)
        files = [self.folder / "a.atlas.exr", self.folder / "b.atlas.exr"]
        both = raylex.atlases.merge(files, self.folder / "both.atlas.exr")
        self.assertTrue(both.verify())
        self.assertEqual(both.at(3, 3).samples, 16)
        self.assertRaylexError("both have seed 1", raylex.atlases.merge, [files[0], files[0]], self.folder / "c.exr")
        self.assertRaylexError("would be overwritten", raylex.atlases.merge, files, files[0])

    def test_requests_that_cannot_be_answered(self):
        _, atlas = self.render(atlas={"file": str(self.folder / "g.atlas.exr"), "by": "group", "length": 1})
        error = self.assertRaylexError("cannot be computed exactly", atlas.ask, {"two": "CDDL"})
        self.assertIn("lpe 'two'", error.file)
        between = atlas.ask({"two": "CDDL"}, intervals=True)
        self.assertTrue((between["two_least"] <= between["two_most"]).all())
        self.assertRaylexError("found 'X'", atlas.ask, {"bad": "C<RX>L"})
        self.assertRaylexError("no layer is requested", atlas.ask)
        self.assertRaylexError("do not distinguish techniques", atlas.ask, {"t": "s1t3;C.*"})
        self.assertRaylexError("not a path atlas", raylex.Atlas, self.rendered_file())
        self.assertRaylexError("no-such", raylex.Atlas, "no-such.exr")
        self.assertRaylexError("without an atlas|beauty", raylex.render, CORNELL, spp=1, beauty=False,
                               lpe={"a": "CDL"}, atlas=self.folder / "n.atlas.exr")

    def test_what_if_and_mix_equal_the_program(self):
        file = self.folder / "a.atlas.exr"
        image = raylex.render(white_furnace(), spp=4, max_depth=3, light_groups=True, atlas=file,
                              output=self.folder / "in.exr")
        atlas, lights = raylex.Atlas(file), {"walls": (2, 0.5, 0.25)}
        asked = atlas.ask(light_groups=True, what_if={"wall.D": 0.5}, light=lights, errors=True)
        self.assertTrue(all(asked.verify()))
        self.assertIn("wall.D=0.5,0.5,0.5", asked.attributes["raylex/what_if"])
        (self.folder / "mix.toml").write_text('[light]\nwalls = [2, 0.5, 0.25]\n[what_if]\n"wall.D" = 0.5\n')
        done = run_program("ask", atlas.path, "--mix", self.folder / "mix.toml", "-o", self.folder / "asked.exr")
        self.assertEqual(done.returncode, 0, done.stderr)
        same = atlas.ask(mix=self.folder / "mix.toml")
        self.assertSameBits(np.ascontiguousarray(raylex.read(self.folder / "asked.exr")["beauty"]), same["beauty"])
        mixed = raylex.mix(self.folder / "in.exr", self.folder / "mixed.exr", lights)
        self.assertTrue(np.allclose(mixed["beauty"], atlas.ask(light=lights)["beauty"], rtol=1e-5, atol=1e-7))
        self.assertSameBits(mixed["light_walls"], image["light_walls"] * np.float32([2, 0.5, 0.25]))
        self.assertRaylexError("is a colour of an object", raylex.mix, self.folder / "in.exr", self.folder / "o.exr",
                               mix=self.folder / "mix.toml")
        self.assertRaylexError("expected a name that ends in .exr", raylex.mix, self.folder / "in.exr",
                               self.folder / "out.png", lights)
        self.assertRaylexError("would be overwritten", raylex.mix, self.folder / "in.exr", self.folder / "in.exr",
                               lights)
        self.assertRaylexError("unknown object", atlas.ask, what_if={"nothing.D": 2})
        self.assertRaylexError("'-1.0' is not a factor", atlas.ask, light={"walls": -1})

    def rendered_file(self):
        file = self.folder / "plain.exr"
        raylex.render(CORNELL, spp=1, resolution=(8, 8), output=file)
        return file


if __name__ == "__main__":
    unittest.main()
