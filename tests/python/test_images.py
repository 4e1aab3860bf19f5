"""Images: arrays without copies, views with names, checks, metrics, display in notebooks."""

import html.parser
import json
import unittest

import numpy as np

import raylex
from support import CORNELL, Case, run_program, white_furnace


class Arrays(Case):
    @classmethod
    def setUpClass(cls):
        cls.image = raylex.render(CORNELL, spp=4, resolution=(24, 16), lpe={"direct": "CDL"}, aovs=["Nn", "z", "id"])

    def test_names_and_shapes(self):
        self.assertEqual(self.image.names, ["beauty", "alpha", "direct", "rest", "Nn", "z", "id"])
        self.assertEqual(list(self.image), self.image.names)
        for name in self.image:
            shape = (16, 24, 3) if name in ("beauty", "direct", "rest", "Nn") else (16, 24)
            self.assertEqual(self.image[name].shape, shape, name)
            self.assertEqual(self.image[name].dtype, np.float32)
        self.assertIn("direct", self.image)
        self.assertNotIn("direkt", self.image)
        self.assertIn("did you mean 'direct'", str(self.assertRaylexError("direkt", lambda: self.image["direkt"])))

    def test_layers_have_the_names_of_the_command_line(self):
        file = self.folder / "prefix.exr"
        raylex.render(CORNELL, spp=1, resolution=(24, 16), lpe={"ViewLayer.DiffDir": "CDL"}, output=file)
        image = raylex.read(file)
        self.assertIn("ViewLayer.DiffDir", image.names)
        self.assertIn("DiffDir", image)
        self.assertSameBits(image["DiffDir"], image["ViewLayer.DiffDir"])
        self.assertEqual(image.view("DiffDir").coords["component"], ["R", "G", "B"])
        self.assertSameBits(raylex.picture(image, "DiffDir"), raylex.picture(image, "ViewLayer.DiffDir"))
        self.assertSameBits(raylex.picture(image), raylex.picture(image, "beauty"))
        self.assertRaylexError("did you mean 'ViewLayer.DiffDir'|did you mean 'DiffDir'", lambda: image["DiffDri"])

    def test_no_number_is_copied(self):
        first, again = self.image["beauty"], self.image["beauty"]
        self.assertEqual(first.ctypes.data, again.ctypes.data)
        self.assertTrue(np.shares_memory(first, self.image.view("beauty").values))
        self.assertEqual(np.from_dlpack(first).ctypes.data, first.ctypes.data)
        self.assertEqual(np.from_dlpack(self.image.view("beauty")).ctypes.data, first.ctypes.data)
        self.assertEqual(memoryview(first).nbytes, 16 * 24 * 3 * 4)

    def test_torch_uses_them_without_a_copy(self):
        try:
            import torch
        except ImportError:
            self.skipTest("python3-torch is not installed")
        tensor = torch.from_dlpack(self.image["beauty"])
        self.assertEqual(tensor.data_ptr(), self.image["beauty"].ctypes.data)

    def test_arrays_outlive_the_image(self):
        array = raylex.render(white_furnace(), spp=1)["beauty"]
        copy = array.copy()
        for _ in range(4):  # these would reuse freed memory
            raylex.render(white_furnace(0.25), spp=1)
        self.assertSameBits(array, copy)

    def test_views(self):
        layer = self.image.view("direct")
        self.assertEqual(layer.dims, ("y", "x", "component"))
        self.assertEqual(layer.coords["component"], ["R", "G", "B"])
        self.assertEqual((layer.coords["y"][0], layer.coords["x"][-1]), (0.5, 23.5))
        self.assertEqual(layer.attrs, {"lpe": "CDL"})
        self.assertSameBits(layer.sel("G"), self.image["direct"][..., 1])
        self.assertRaises(KeyError, layer.sel, "Q")
        self.assertEqual(self.image.view("z").dims, ("y", "x"))

    def test_xarray(self):
        try:
            import xarray  # noqa: F401
        except ImportError:
            self.skipTest("python3-xarray is not installed")
        data = self.image.to_xarray()
        self.assertSameBits(np.ascontiguousarray(data["direct"].values), self.image["direct"])
        self.assertEqual(dict(data["z"].sizes), {"y": 16, "x": 24})
        self.assertEqual(data["direct"].attrs["lpe"], "CDL")



class Denoising(Case):
    def test_denoised_layers_sum(self):
        image = raylex.render(CORNELL, spp=8, resolution=(24, 16), lpe={"direct": "CDL"}, denoise=True)
        self.assertTrue(all(verdict.holds for verdict in image.verify()))
        self.assertIn("direct_error", image.names)
        self.assertNotIn("direct_mse", image.names)
        image.write(self.folder / "denoised.exr")
        written = raylex.read(self.folder / "denoised.exr")
        self.assertSameBits(written["direct"], image["direct"])
        self.assertSameBits(written["beauty"], image["beauty"])

    def test_a_rebuild_reports_what_the_layers_lack(self):
        image = raylex.render(CORNELL, spp=4, resolution=(24, 16), lpe={"direct": "CDL"})
        rebuild, = image.rebuild(sums=["direct"])
        lacks = image["beauty"] - image["direct"]
        self.assertAlmostEqual(rebuild.unassigned, lacks.sum() / image["beauty"].sum(), places=5)
        self.assertEqual((rebuild.doubled, rebuild.negative, rebuild.lost), (0, {}, {}))
        self.assertTrue(np.allclose(rebuild.difference, lacks, atol=1e-5))
        self.assertIn("unassigned light (beauty minus sum)", str(rebuild))
        self.assertIn("equals the layer 'rest'", rebuild.lines[0])
        twice, = image.rebuild(sums=["direct + direct + rest"])
        self.assertGreater(twice.doubled, 0)
        self.assertEqual(image.rebuild()[0].lines, [])

    def test_a_set_of_files_is_denoised_but_not_written(self):
        files = [self.folder / "beauty.exr", self.folder / "other.exr"]
        raylex.render(CORNELL, spp=4, resolution=(24, 16), output=files[0])
        raylex.render(CORNELL, spp=4, resolution=(24, 16), statistics={"beauty": ["mse"]}, output=files[1])
        noisy = raylex.read(*files)  # the variance of the beauty is in the second file
        denoised = noisy.denoise()
        self.assertFalse(np.array_equal(denoised["beauty"], noisy["beauty"]))
        self.assertRaylexError("comes from 2 files", denoised.write, self.folder / "o.exr")

    def test_a_crop_is_denoised_as_in_its_file(self):
        file = self.folder / "crop.exr"
        image = raylex.render(CORNELL, spp=8, resolution=(24, 16), crop=(3, 2, 20, 12), denoise=True, output=file)
        self.assertSameBits(np.ascontiguousarray(raylex.read(file)["beauty"]), image["beauty"])

    def test_an_image_with_statistics_is_denoised_later(self):
        names = ["beauty", "direct", "rest"]
        noisy = raylex.render(CORNELL, spp=8, resolution=(24, 16), lpe={"direct": "CDL"},
                              statistics={name: ["mse"] for name in names})
        denoised = noisy.denoise(keep_noisy=True)
        self.assertSameBits(denoised["direct_noisy"], noisy["direct"])
        self.assertLess(np.square(np.diff(denoised["beauty"], axis=1)).sum(),
                        np.square(np.diff(noisy["beauty"], axis=1)).sum())
        plain = raylex.render(CORNELL, spp=1, resolution=(24, 16))
        self.assertRaylexError("no layer of light has statistics", plain.denoise)


class Judging(Case):
    def test_verdicts(self):
        image = raylex.render(CORNELL, spp=4, resolution=(16, 16), shipped=True)
        verdict, = image.verify()
        self.assertTrue(verdict)
        self.assertLessEqual(verdict.largest_relative, verdict.bound)
        self.assertEqual(verdict.residual.shape, (16, 16))
        # Arrays are the image's own memory, so changes in them affect the check.
        image["directDiffuse"][3, 5] += 1
        verdict, = image.verify()
        self.assertFalse(verdict)
        self.assertEqual(verdict.exceeding, 1)
        self.assertEqual(np.unravel_index(verdict.residual.argmax(), (16, 16)), (3, 5))
        self.assertIn("DOES NOT HOLD", str(verdict))

    def test_sums_by_name(self):
        image = raylex.render(CORNELL, spp=4, resolution=(8, 8), lpe={"a": "CDL"})
        self.assertTrue(image.verify(sums=["a", "rest"])[0])
        self.assertFalse(image.verify(sums=["a"])[0])
        self.assertRaylexError("declares no partition", raylex.render(white_furnace(), spp=1).verify)
        self.assertRaylexError("tolerance", image.verify, tolerance=(-1, 0))

    def test_images_without_pixels_have_no_metric(self):
        for shape in ((0, 0, 3), (0, 4, 3), (4, 0, 3), (0, 0)):
            empty = np.zeros(shape, np.float32)
            for metric in raylex.metrics():
                self.assertRaylexError("no pixels", raylex.compare, empty, empty, metric)
            self.assertRaylexError("no pixels", raylex.error_image, empty, empty, "mse")

    def test_metrics_are_the_programs(self):
        files = [self.folder / name for name in ("a.exr", "b.exr")]
        images = [raylex.render(CORNELL, spp=4, seed=seed, resolution=(16, 16), output=file)
                  for seed, file in enumerate(files)]
        for metric in ("relmse", "mse", "smape", "ssim", "flip"):
            said = run_program("compare", *files, "--metric", metric, "--json")
            value = json.loads(said.stdout)["metrics"][metric]
            self.assertEqual(raylex.compare(*images, metric), value)
        arrays = [each["beauty"] for each in images]
        self.assertEqual(raylex.compare(*images, "mse"), raylex.compare(*arrays, "mse"))
        difference = images[0]["beauty"].astype(float) - images[1]["beauty"]
        mean = (difference ** 2).mean()
        # Sums of 768 doubles in another order: each rounding is below 2^-53, 768 of them below 1e-13.
        self.assertTrue(np.isclose(raylex.compare(*images, "mse"), mean, rtol=1e-12))
        self.assertTrue(np.isclose(raylex.error_image(*images, "mse").mean(), mean, rtol=1e-12))
        self.assertIn("relmse", raylex.metrics())

    def test_bad_input(self):
        image = raylex.render(white_furnace(), spp=1)
        self.assertRaylexError("did you mean 'mse'", raylex.compare, image, image, "msee")
        self.assertRaylexError(r"shape \(2, 2, 2\)", raylex.compare, np.zeros((2, 2, 2)), np.zeros((2, 2, 3)))
        self.assertRaylexError("has 16 x 16", raylex.compare, image, np.zeros((2, 2, 3)))
        self.assertRaylexError("no-such", raylex.read, "no-such.exr")
        (self.folder / "broken.exr").write_bytes(b"no image")
        self.assertRaylexError("broken.exr", raylex.read, self.folder / "broken.exr")
        self.assertRaylexError(r"\.exr", image.write, str(self.folder / "image.png"))
        self.assertRaylexError("No such file|cannot", image.write, str(self.folder / "none" / "image.exr"))


class Shown(Case):
    def test_pictures(self):
        image = raylex.render(white_furnace(), spp=4, aovs=["Nn"])
        self.assertEqual(raylex.picture(image).shape, (16, 16, 3))
        self.assertEqual(raylex.picture(image, "Nn").dtype, np.uint8)
        dark, bright = (raylex.picture(image, exposure=stops).mean() for stops in (-4, 0))
        self.assertLess(dark, bright)
        # Arrays of light are pictures too; other values give an error with the expected type.
        np.testing.assert_array_equal(raylex.picture(image["beauty"]), raylex.picture(image))
        np.testing.assert_array_equal(raylex.picture(image.view("beauty")), raylex.picture(image))
        self.assertEqual(raylex.picture(np.ones((4, 6))).shape, (4, 6, 3))
        self.assertRaylexError(r"shape \(4, 6, 2\); expected \(height, width, 3\)", raylex.picture, np.ones((4, 6, 2)))
        self.assertRaylexError("image is str, which is not an array of numbers", raylex.picture, "image.exr")

    def test_html_has_a_tab_for_each_layer_and_the_verdict(self):
        image = raylex.render(CORNELL, spp=4, resolution=(16, 16), lpe={"direct": "CDL"})
        page = image._repr_html_()
        found = []

        class Reader(html.parser.HTMLParser):
            open = 0

            def handle_starttag(self, tag, attributes):
                found.append((tag, dict(attributes)))
                Reader.open += tag in ("div", "label")

            def handle_endtag(self, tag):
                Reader.open -= tag in ("div", "label")

        Reader().feed(page)
        self.assertEqual(Reader.open, 0)
        pictures = [a for tag, a in found if tag == "img"]
        self.assertEqual(len(pictures), 3 * 3)  # beauty, direct and rest at three exposures
        self.assertTrue(all(each["src"].startswith("data:image/png;base64,") for each in pictures))
        self.assertIn("auto: 2 layers sum to beauty", page)
        self.assertIn("CDL", page)
        names = [a["id"] for tag, a in found if tag == "input"]
        self.assertEqual(len(names), len(set(names)))
        self.assertNotEqual(page, image._repr_html_())  # two outputs in one notebook have different ids

    def test_html_of_proofs(self):
        self.assertIn("C,- L,-", raylex.lpe.check({"a": "CDL"})._repr_html_())


if __name__ == "__main__":
    unittest.main()
