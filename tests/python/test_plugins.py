"""Integrators, textures and sample filters in Python: agreement with C++, and errors."""

import threading
import traceback
import unittest

import numpy as np

import raylex
from support import CORNELL, Case, quad, white_furnace


def over(pdf):
    return np.where(pdf > 0, 1 / np.maximum(pdf, 1e-30), 0)[:, None]


@raylex.integrator("test_path")
class Path:
    """A path tracer with light sampling, in arrays."""

    def __init__(self, maxdepth=5, mistake=False):
        self.maxdepth = maxdepth
        self.mistake = mistake

    def integrate(self, batch):
        throughput = np.ones((len(batch), 3), np.float32)
        specular = np.ones(len(batch), bool)
        points = batch.trace()
        for depth in range(self.maxdepth + 1):
            at = points.rows
            batch.add_emission(points, throughput[at] * specular[at, None])
            batch.add_background(points, throughput[points.missed] * specular[points.missed, None])
            if depth == self.maxdepth or len(points) == 0:
                return
            light = points.sample_light(batch.numbers(5 * depth, at), batch.numbers_2d(5 * depth + 1, at))
            f = points.evaluate(light.wi)
            value = throughput[at] * f.value * light.radiance * over(light.pdf) * light.visible()[:, None]
            batch.add_light(points, f, light, value * (0.9 if self.mistake and depth == 1 else 1))
            sample = points.sample(batch.numbers(5 * depth + 2, at), batch.numbers_2d(5 * depth + 3, at))
            throughput[at] *= sample.weight
            specular[at] = sample.delta
            batch.scatter(points, sample)
            points = points.go_on(sample)


class Integrators(Case):
    def test_every_layer_agrees_with_path(self):
        layers = dict(resolution=(16, 16), max_depth=3, lpe={"one": "C<RD>L", "two": "C<RD>{2}L", "seen": "CL"},
                      aovs=["Nn", "z"])
        mine = raylex.render(CORNELL, spp=256, integrator="test_path", **layers)
        right = raylex.render(CORNELL, spp=4096, integrator="path", **layers)
        # Eight renders of 64 samples give the standard error of a layer's mean; sqrt(64 / 256) times that is the error
        # of 256 samples, and bounds that of the reference (64 / 4096 of the variance, taken as 1 / 16). By chance 6 of
        # them are exceeded in 1 of 2000 cases, by Student's t with 7 degrees of freedom; the seeds are fixed.
        for name in ("beauty", "one", "two"):
            means = [raylex.render(CORNELL, spp=64, seed=9 + i, integrator="test_path", **layers)[name].mean()
                     for i in range(8)]
            error = np.std(means, ddof=1) * np.sqrt(64 / 256 + 1 / 16)
            self.assertLess(abs(mine[name].mean() - right[name].mean()), 6 * error + 1e-6 * right[name].mean(), name)
        self.assertTrue(all(mine.verify()))
        # First hits come from the same camera rays.
        few = [raylex.render(CORNELL, spp=4, integrator=each, **layers) for each in ("path", "test_path")]
        self.assertSameBits(few[0]["z"], few[1]["z"])
        self.assertSameBits(few[0]["Nn"], few[1]["Nn"])
        self.assertSameBits(few[0]["alpha"], few[1]["alpha"])

    def test_same_bits_for_any_threads(self):
        a, b = (raylex.render(CORNELL, spp=8, resolution=(32, 32), threads=threads, integrator="test_path")
                for threads in (1, 2))
        self.assertSameBits(a["beauty"], b["beauty"])

    def test_parameters_and_depth(self):
        scene = white_furnace(0.5)
        for depth, value in ((0, 1), (1, 1.5), (2, 1.75)):
            image = raylex.render(scene, spp=16, integrator={"type": "test_path", "maxdepth": depth})
            # 4 standard errors: light samples inside a sphere vary by less than their mean.
            self.assertLess(abs(image["beauty"].mean() - value), 4 / np.sqrt(16 * 256))
            same = raylex.render(scene, spp=16, integrator="test_path", max_depth=depth)
            self.assertSameBits(image["beauty"], same["beauty"])
        self.assertRaylexError("maxdpth", raylex.render, scene, integrator={"type": "test_path", "maxdpth": 3})
        self.assertRaylexError("mistake", raylex.render, scene, integrator={"type": "test_path", "mistake": 3})

    def test_exceptions_end_the_render(self):
        @raylex.integrator("test_throws")
        class Throws:
            def integrate(self, batch):
                raise ZeroDivisionError("in the batch")

        with self.assertRaisesRegex(ZeroDivisionError, "in the batch"):
            raylex.render(CORNELL, spp=4, resolution=(16, 16), integrator="test_throws")

        @raylex.integrator("test_throws")  # the second registration replaces the first
        class Shape:
            def integrate(self, batch):
                points = batch.trace()
                points.evaluate(np.zeros((3, 2)))

        try:
            raylex.render(CORNELL, spp=4, resolution=(16, 16), integrator="test_throws")
            self.fail("a wrong shape was taken")
        except raylex.RaylexError as error:
            self.assertRegex(str(error), r"wi has shape \(3, 2\); expected \(\d+, 3\)")
            self.assertIn("points.evaluate(np.zeros((3, 2)))", traceback.format_exc())  # the place in Python

    def test_a_constructor_that_fails_is_an_error_of_input(self):
        @raylex.integrator("test_constructor")
        class Refuses:
            def __init__(self, radius=1.0):
                if radius <= 0:
                    raise ValueError("radius must be above 0")

            def integrate(self, batch):
                pass

        self.assertRaylexError("radius must be above 0", raylex.render, CORNELL, spp=1,
                               integrator={"type": "test_constructor", "radius": -1.0})

    def test_objects_are_invalid_after_their_call(self):
        kept = []

        @raylex.integrator("test_keeps")
        class Keeps:
            def integrate(self, batch):
                points = batch.trace()
                count = len(points)
                light = points.sample_light(np.full(count, 0.5), np.full((count, 2), 0.5))
                sample = points.sample(np.full(count, 0.5), np.full((count, 2), 0.5))
                kept.append((batch, points, light, points.evaluate(light.wi), sample))

        raylex.render(CORNELL, spp=1, resolution=(8, 8), integrator="test_keeps", channels={"heat": "float"})
        batch, points, light, f, sample = kept[0]
        count, rows = len(points), points.rows
        none = np.zeros(0, int)
        uses = {
            "__len__": lambda: len(batch), "origins": lambda: batch.origins, "directions": lambda: batch.directions,
            "pixels": lambda: batch.pixels, "samples": lambda: batch.samples, "channels": lambda: batch.channels,
            "numbers": lambda: batch.numbers(0, rows), "numbers_2d": lambda: batch.numbers_2d(0, rows),
            "trace": batch.trace, "live": batch.live, "discard": batch.discard,
            "scatter": lambda: batch.scatter(points, sample), "add_emission": lambda: batch.add_emission(points, 1),
            "add_background": lambda: batch.add_background(points, 1),
            "add_light": lambda: batch.add_light(points, f, light, 1),
            "write": lambda: batch.write("heat", np.ones(count), rows),
            "splat": lambda: batch.splat("heat", np.ones(count), rows),
            "write_distance": lambda: batch.write_distance(np.ones(count), rows),
            "write_opacity": lambda: batch.write_opacity(np.ones(count), rows),
            "add_samples": lambda: batch.add_samples(np.ones(count), np.ones(count), rows),
        }
        self.assertEqual({name for name in dir(batch) if not name.startswith("_")}, set(uses) - {"__len__"})
        uses |= {
            "trace rays": lambda: batch.trace(points.position, points.normal, rows),
            "no distance": lambda: batch.write_distance(none, none),
            "no rows": lambda: batch.add_samples(none, np.zeros((0, 3)), none),
            "emitted": lambda: points.emitted, "albedo": lambda: points.albedo,
            "world_position": lambda: points.world_position, "evaluate": lambda: points.evaluate(light.wi),
            "sample": lambda: points.sample(np.full(count, 0.5), np.full((count, 2), 0.5)),
            "sample_light": lambda: points.sample_light(np.full(count, 0.5), np.full((count, 2), 0.5)),
            "occluded": lambda: points.occluded(points.normal), "go_on": lambda: points.go_on(sample),
            "visible": light.visible,
        }
        for name, use in uses.items():
            with self.subTest(name):
                self.assertRaylexError("this batch is no longer valid", use)
        # The rest is made of numbers of its own.
        arrays = {name: getattr(points, name) for name in ("rows", "missed", "distance", "position", "normal",
                                                           "shading_normal", "wo", "uv")}
        self.assertEqual({name for name in dir(points) if not name.startswith("_")} - set(uses), set(arrays))
        self.assertEqual({len(array) for name, array in arrays.items() if name != "missed"}, {count})

    def test_a_batch_lasts_as_long_as_another_threads_use_of_it(self):
        found = []

        @raylex.integrator("test_leaves")
        class Leaves:
            def integrate(self, batch):
                if found:
                    return
                # Takes much longer than the rest of integrate(); the ray through the middle of the image hits the box.
                rows = np.full(1 << 20, len(batch) * 9 // 16)
                origins, directions = (getattr(batch, name)[rows] for name in ("origins", "directions"))
                begins = threading.Event()

                def use():
                    begins.set()
                    try:
                        found.append(len(batch.trace(origins, directions, rows)))
                    except raylex.RaylexError as error:
                        found.append(error)

                found.append(threading.Thread(target=use))
                found[0].start()
                begins.wait()

        raylex.render(CORNELL, spp=1, resolution=(8, 8), integrator="test_leaves", threads=1)
        found[0].join()
        self.assertEqual(found[1], 1 << 20)

    def test_points_of_another_batch(self):
        kept = []

        @raylex.integrator("test_mixes")
        class Mixes:
            def integrate(self, batch):
                points = batch.trace()
                numbers = np.full(len(points), 0.5), np.full((len(points), 2), 0.5)
                light, sample = points.sample_light(*numbers), points.sample(*numbers)
                kept.append((points, points.evaluate(light.wi), light, sample))
                self.use(batch, *kept[0])

        uses = {
            "add_emission": lambda batch, points, f, light, sample: batch.add_emission(points, 1),
            "add_background": lambda batch, points, f, light, sample: batch.add_background(points, 1),
            "add_light": lambda batch, points, f, light, sample: batch.add_light(points, f, light, 1),
            "scatter": lambda batch, points, f, light, sample: batch.scatter(points, sample),
        }
        for name, use in uses.items():
            with self.subTest(name):
                Mixes.use = staticmethod(use)
                kept.clear()
                self.assertRaylexError("these points belong to another batch", raylex.render, CORNELL, spp=64,
                                       resolution=(16, 16), integrator="test_mixes", threads=1)

    def test_plugins_in_cpp(self):
        right = raylex.render(CORNELL, spp=4, resolution=(16, 16), plugins=["planted_error"],
                              integrator={"type": "plantederror", "mistake": False})
        wrong = raylex.render(CORNELL, spp=4, resolution=(16, 16), integrator="plantederror")
        # The planted mistake: the integrator does not weight surviving paths.
        self.assertLess(wrong["beauty"].mean(), right["beauty"].mean())
        self.assertRaylexError("no-such.so", raylex.load_plugin, self.folder / "no-such.so")
        (self.folder / "text.so").write_text("no library")
        self.assertRaylexError("text.so", raylex.load_plugin, self.folder / "text.so")

    def test_names(self):
        self.assertRaylexError("'path' exists already", raylex.integrator("path"), Path)
        self.assertRaises(TypeError, raylex.integrator("test_none"), object)

        class NoDefault:
            def __init__(self, depth):
                pass

            def integrate(self, batch):
                pass

        self.assertRaises(TypeError, raylex.integrator("test_none"), NoDefault)


@raylex.texture("test_stripes")
class Stripes:
    def __init__(self, count=4):
        self.count = count
        Stripes.sizes = []

    def evaluate(self, at):
        Stripes.sizes.append(len(at))
        on = np.floor(at.uv[:, 0] * self.count) % 2
        return np.stack([on, 1 - on, np.zeros_like(on)], axis=1)


def striped(name, **parameters):
    def material(builder):
        builder.texture("stripes", "spectrum", name, **parameters)
        return builder.material("diffuse", reflectance=("texture", "stripes"))
    return quad(material)


@raylex.integrator("test_calls")
class Calls:
    def integrate(self, batch):
        points = batch.trace()
        batch.write("heat", 2.0)
        batch.splat("heat", np.full(len(batch), 0.5))
        batch.write("number", np.full(len(batch), 7))
        batch.write("nobody_requested_this", 1.0)
        rows = batch.add_samples(points.distance / 2, 0.5, points.rows)
        batch.write("paint", np.ones((len(rows), 3)), rows)
        if "heat" not in batch.channels:
            batch.discard()


@raylex.texture("test_writing")
class Writing:
    def evaluate(self, at):
        at.services.write("paint", np.where(at.services.depth[:, None] == 0, 0.25, 9) * np.ones((len(at), 3)))
        return np.full((len(at), 3), 0.5)


@raylex.sample_filter("test_three")
class Three:
    keeps_splits = True

    def apply(self, samples):
        samples["heat"][:] = 3


class Channels(Case):
    """Values that Python plugins write to declared channels of a render."""
    declared = {"heat": "float", "number": "integer", "paint": "rgb"}

    def test_integrators(self):
        image = raylex.render(quad(), spp=4, integrator="test_calls", channels=self.declared)
        self.assertTrue((image["heat"] == 2.5).all())
        self.assertTrue((image["number"] == 7).all())
        np.testing.assert_array_equal(image["paint"][..., 0], image["alpha"])  # alpha times the written value

    def test_an_image_of_discarded_iterations_is_an_error(self):
        self.assertRaylexError("discarded all", raylex.render, quad(), spp=4, integrator="test_calls")

    def test_textures(self):
        image = raylex.render(striped("test_writing"), spp=4, channels={"paint": "rgb"}, aovs=["a"], beauty=False)
        np.testing.assert_allclose(image["paint"][..., 1], 0.25 * image["a"], rtol=1e-6)

    def test_services_are_invalid_after_the_call(self):
        kept = []

        @raylex.texture("test_keeps")
        class Keeps:
            def evaluate(self, at):
                kept.append(at.services)
                return np.full((len(at), 3), 0.5)

        raylex.render(striped("test_keeps"), spp=4, channels={"paint": "rgb"})
        for use in (lambda: kept[0].seen, lambda: kept[0].depth, lambda: kept[0].write("paint", 1)):
            self.assertRaylexError("these services are no longer valid", use)

    def test_filters(self):
        image = raylex.render(quad(), spp=4, channels={"heat": "float"}, sample_filters=["test_three"])
        self.assertTrue((image["heat"] == 3).all())

    def test_wrong_values(self):
        @raylex.integrator("test_wrong_values")
        class Wrong:
            def integrate(self, batch):
                batch.write("heat", np.zeros(3))

        self.assertRaylexError(r"'heat' has shape \(3,\); expected", raylex.render, quad(), spp=1,
                               integrator="test_wrong_values", channels={"heat": "float"})


class Textures(Case):
    def test_it_evaluates_in_batches(self):
        image = raylex.render(striped("test_stripes", count=2), spp=4, max_depth=1)
        beauty = image["beauty"]
        self.assertTrue(np.all(beauty[..., 2] == 0))
        # u runs from 0 at x = -2 to 1 at x = 2, and stripes change only in the middle of the image; the pixels on both
        # sides of it have samples beyond it.
        left, right = beauty[:, :3], beauty[:, 5:]
        self.assertTrue((left[..., 0] == 0).all() != (left[..., 1] == 0).all())
        self.assertTrue((right[..., 0] == 0).all() != (right[..., 1] == 0).all())
        self.assertNotEqual((left[..., 0] == 0).all(), (right[..., 0] == 0).all())
        self.assertGreater(np.mean(Stripes.sizes), 16)  # whole batches of hits instead of single ones

    def test_wrong_shapes_and_exceptions(self):
        @raylex.texture("test_wrong")
        class Wrong:
            def evaluate(self, at):
                return np.zeros((len(at), 2))

        self.assertRaylexError(r"texture 'test_wrong' has shape \(\d+, 2\); expected \(\d+, 3\)",
                               raylex.render, striped("test_wrong"), spp=1)

        @raylex.texture("test_wrong")
        class Raises:
            def evaluate(self, at):
                raise KeyError("texture")

        with self.assertRaises(KeyError):
            raylex.render(striped("test_wrong"), spp=1)


class Filters(Case):
    def test_samples_are_changed_in_place(self):
        @raylex.sample_filter("test_double")
        class Double:
            keeps_splits = True

            def __init__(self, factor=2.0):
                self.factor = factor

            def apply(self, samples):
                for name in ("beauty", "direct", "rest"):
                    samples[name][...] *= self.factor

        plain = raylex.render(CORNELL, spp=4, resolution=(16, 16), lpe={"direct": "CDL"})
        double = raylex.render(CORNELL, spp=4, resolution=(16, 16), lpe={"direct": "CDL"},
                               sample_filters=["test_double"])
        for name in ("beauty", "direct", "rest"):
            self.assertSameBits(double[name], 2 * plain[name])  # a power of two: exact
        self.assertTrue(all(double.verify()))
        self.assertIn("auto", double.partitions)

    def test_arrays_outlive_the_samples(self):
        kept = []

        @raylex.sample_filter("test_keeps")
        class Keeps:
            def apply(self, samples):
                again = samples["beauty"]
                samples["beauty"][...] = len(kept)
                kept.append((samples, again, again.copy()))

        raylex.render(CORNELL, spp=16, resolution=(32, 32), threads=1, sample_filters=["test_keeps"])
        self.assertGreater(len(kept), 1)
        for number, (_, array, then) in enumerate(kept):
            self.assertTrue((then == number).all())
            self.assertSameBits(array, then)  # the next batch uses other memory
        samples = kept[0][0]
        for use in (lambda: samples["beauty"], lambda: samples.names, lambda: samples.pixels, lambda: len(samples)):
            self.assertRaylexError("these samples are no longer valid", use)

    def test_filters_that_do_not_keep_splits_declare_none(self):
        @raylex.sample_filter("test_red")
        class Red:
            def apply(self, samples):
                samples["beauty"][:, 1:] = 0

        image = raylex.render(CORNELL, spp=4, resolution=(16, 16), lpe={"direct": "CDL"}, sample_filters=["test_red"])
        self.assertEqual(image["beauty"][..., 1:].max(), 0)
        self.assertEqual(image.partitions, {})
        self.assertTrue(any("no longer sum" in each for each in image.warnings))

    def test_errors(self):
        @raylex.sample_filter("test_wrong")
        class Wrong:
            def apply(self, samples):
                samples["beuty"]

        self.assertRaylexError("beuty", raylex.render, CORNELL, spp=1, resolution=(8, 8), sample_filters=["test_wrong"])


if __name__ == "__main__":
    unittest.main()
