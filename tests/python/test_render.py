"""raylex.render: the program's bits, layers by name, callbacks that stop and fail."""

import _thread
import signal
import subprocess
import sys
import threading
import time
import unittest

import numpy as np

import raylex
from raylex.rendering import job_text
from support import CORNELL, SCENES, Case, run_program, white_furnace


DAEMON = """
import sys, threading, time
import raylex
def forever():
    while True:
        raylex.render(sys.argv[1], spp=100000, resolution=(64, 64), progress=lambda progress: True)
threading.Thread(target=forever, daemon=True).start()
time.sleep(1)
"""


# At the end of the interpreter, both daemon threads are in raylex calls made by callbacks, or make such calls
# afterwards.
DAEMON_CALLBACKS = """
import sys, threading, time
import raylex
@raylex.integrator("slow")
class Slow:
    def integrate(self, batch):
        time.sleep(0.05)
        points = batch.trace()
        batch.add_emission(points, 1)
def look(progress):
    time.sleep(0.05)
    progress.image()
size = dict(spp=100000, resolution=(128, 128), threads=2)
for more in (dict(integrator="slow"), dict(progress=look)):
    threading.Thread(target=lambda more=more: raylex.render(sys.argv[1], **size, **more), daemon=True).start()
time.sleep(1)
"""

# Runs in a second interpreter. Other tests load plugins into this one, and a guide file records the loaded plugins.
GUIDE = """
import sys
import raylex
scene, guide, image = sys.argv[1:]
raylex.render(scene, spp=16, resolution=(24, 20), integrator={"type": "path", "guide": "on", "guidesamples": 4},
              guide_file=guide).write(image)
"""

# Functions that Python runs at its end, after raylex's own, may still render on threads that call Python.
AT_THE_END = """
import atexit, sys
import numpy
atexit.register(lambda: print(raylex.render(sys.argv[1], integrator="late", spp=1, resolution=(8, 8)).complete))
import raylex
@raylex.integrator("late")
class Late:
    def integrate(self, batch):
        batch.add_emission(batch.trace(), 1)
"""


class Endings(Case):
    def test_a_render_in_a_daemon_thread_ends_with_the_interpreter(self):
        # Without a stop and a wait, the thread would be ended in the middle of C++ code: "terminate called", signal 6.
        self.assertEqual(self.run_to_its_end(DAEMON), "")

    def test_callbacks_of_a_daemon_threads_render_end_with_the_interpreter(self):
        self.assertEqual(self.run_to_its_end(DAEMON_CALLBACKS), "")

    def test_renders_at_the_end_of_the_interpreter(self):
        self.assertEqual(self.run_to_its_end(AT_THE_END), "True\n")

    def run_to_its_end(self, script):
        done = subprocess.run([sys.executable, "-c", script, CORNELL], capture_output=True, text=True, check=False,
                              timeout=60)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout


class SameAsTheProgram(Case):
    def test_every_layer_has_the_bits_of_the_programs_file(self):
        file = self.folder / "program.exr"
        done = run_program("render", CORNELL, "-o", file, "--spp", 8, "--seed", 7, "--resolution", "48x40", "--lpe",
                           "direct=CDL", "--aov", "Nn", "--aov", "z", "--partition", "shipped")
        self.assertEqual(done.returncode, 0, done.stderr)
        theirs = raylex.read(file)
        ours = raylex.render(CORNELL, spp=8, seed=7, resolution=(48, 40), lpe={"direct": "CDL"}, aovs=["Nn", "z"],
                             shipped=True)
        self.assertEqual(ours.names, theirs.names)
        self.assertEqual(ours.partitions, theirs.partitions)
        for name in ("beauty", "alpha", "direct", "rest", "z", "directDiffuse"):
            self.assertSameBits(ours[name], theirs[name])
        # The file written later equals it too, pixel by pixel.
        ours.write(self.folder / "python.exr")
        again = raylex.read(self.folder / "python.exr")
        for name in theirs.names:
            self.assertSameBits(again[name], theirs[name])

    def test_the_program_reads_the_guide_that_python_wrote(self):
        guide, job, file = self.folder / "its.guide", self.folder / "job.toml", self.folder / "program.exr"
        ours = self.folder / "python.exr"
        done = subprocess.run([sys.executable, "-c", GUIDE, CORNELL, guide, ours], capture_output=True, text=True,
                              check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        job.write_text(f"[scene]\nfile = '{CORNELL}'\n[render]\nspp = 16\nresolution = '24x20'\n"
                       "guide_file = 'its.guide'\n[integrator]\ntype = 'path'\nguide = 'on'\nguidesamples = 4\n")
        done = run_program("render", job, "-o", file)
        self.assertIn("for training (read from a file)", done.stdout, done.stderr)
        self.assertSameBits(raylex.read(ours)["beauty"], raylex.read(file)["beauty"])
        self.assertRaylexError("its.guide: cannot use this guide file(.|\n)*\n  seed: 0 there, 5 here", raylex.render,
                               CORNELL, spp=16, seed=5, resolution=(24, 20), guide_file=str(guide),
                               integrator={"type": "path", "guide": "on", "guidesamples": 4})

    def test_a_closed_form(self):
        image = raylex.render(white_furnace(0.5), spp=64, max_depth=3, lpe={"two": "CDDL"}, integrator="path")
        # 1 + 1/2 + 1/4 + 1/8. 4 standard errors of the mean of 16 x 16 x 64 samples: the deviation of a sample is below
        # 1, because light samples inside a sphere vary by less than their mean and half the light needs none.
        self.assertLess(abs(image["beauty"].mean() - 1.875), 4 / np.sqrt(16 * 16 * 64))
        self.assertLess(abs(image["two"].mean() - 0.25), 4 / np.sqrt(16 * 16 * 64))
        self.assertTrue(all(image.verify()))

    def test_passes_sum(self):
        passes = [{"method": "path", "takes": "rest"},
                  {"method": "bdpt", "takes": "CD.*", "spp": 16, "roulette": False}]
        progress = []
        image = raylex.render(white_furnace(0.5), spp=64, max_depth=3, passes=passes, layer_passes=True,
                              progress=lambda now: progress.append(now.fraction))
        self.assertLess(abs(image["beauty"].mean() - 1.875), 6 / np.sqrt(16 * 16 * 16))
        self.assertLess(abs(image["pass_path"].mean() - 1), 1e-3)
        self.assertIn("passes", image.partitions)
        self.assertTrue(all(image.verify()))
        self.assertTrue(all(0 <= each <= 1 for each in progress))
        with self.assertRaisesRegex(raylex.RaylexError, "no pass takes camera, light"):
            raylex.render(white_furnace(), passes=passes[1:])

    def test_output_is_written_too(self):
        file = self.folder / "out.exr"
        image = raylex.render(white_furnace(), spp=4, output=file)
        self.assertSameBits(raylex.read(file)["beauty"], image["beauty"])

    def test_a_gbuffer_film_has_its_layers_here_too(self):
        builder = raylex.SceneBuilder("gbuffer")
        builder.film("gbuffer", xresolution=4, yresolution=4)
        builder.camera("perspective", eye=(0, 0, 0), look=(0, 0, 1), fov=40)
        builder.light("infinite", L=(1.0, 1.0, 1.0))
        image = raylex.render(builder.finish(), spp=1)
        for name in ("albedo", "P", "Ngn", "Nn", "st"):
            self.assertIn(name, image.names)

    def test_threads_of_python_render_at_once(self):
        scene = white_furnace()
        images = [None] * 4

        def work(i):
            images[i] = raylex.render(scene, spp=4, threads=1)["beauty"]

        threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
        for each in threads:
            each.start()
        for each in threads:
            each.join()
        for each in images[1:]:
            self.assertSameBits(images[0], each)


class Asking(Case):
    def test_partitions_and_rests(self):
        image = raylex.render(CORNELL, spp=4, resolution=(16, 16), lpe={"a": "CDL", "b": "osl:CL"},
                              partitions={"mine": {"channels": ["a", "b"], "rest": "c"}})
        self.assertEqual(image.partitions["mine"], ("beauty", ["a", "b", "c"]))
        self.assertTrue(all(image.verify()))
        self.assertEqual(image.expressions["a"], "CDL")

    def test_a_partition_that_does_not_hold_is_refused_before_a_ray(self):
        error = self.assertRaylexError("C,- L,-|camera, light", raylex.render, CORNELL, lpe={"a": "CDL"},
                                       partitions={"mine": ["a"]})
        self.assertIn("nothing was rendered", str(error))

    def test_further_tables_of_a_job(self):
        scene = str(SCENES / "still-life" / "scene.pbrt")
        image = raylex.render(scene, spp=2, lpe={"ground": "C<.D'ground'>.*"},
                              job={"render": {"resolution": [20, 10]},
                                   "label": [{"material": "floor", "label": "ground"}],
                                   "display_filter": [{"type": "grade", "exposure": 1}]})
        plain = raylex.render(scene, spp=2, resolution=(20, 10), lpe={"ground": "C<.D'floor'>.*"})
        self.assertGreater(plain["ground"].max(), 0)
        for name in ("beauty", "ground"):
            self.assertSameBits(image[name], 2 * plain[name])

    def test_numbers_of_numpy_are_numbers_of_a_job(self):
        text = job_text("a.pbrt", spp=np.int64(4), until_error=np.float64(0.1), crop=np.array([0, 0, 2, 2]))
        for line in ('"spp" = 4', '"error" = 0.1', '"crop" = [0, 0, 2, 2]'):
            self.assertIn(line, text.splitlines())

    def test_bad_arguments(self):
        error = self.assertRaylexError("spp", raylex.render, CORNELL, spp=-3)
        self.assertEqual(error.file, "render()")
        self.assertEqual(error.excerpt.strip(), '"spp" = -3')
        self.assertRaylexError("did you mean", raylex.render, CORNELL, aovs=["albdo"])
        self.assertRaylexError("did you mean 'spp'", raylex.render, CORNELL, job={"render": {"sp": 3}})
        self.assertRaylexError("integrator", raylex.render, CORNELL, integrator="pathh")
        self.assertRaylexError("no-such", raylex.render, "no-such.pbrt")
        self.assertRaylexError("column|:", raylex.render, CORNELL, lpe={"a": "C<"})
        self.assertRaylexError("checkpoint", raylex.render, CORNELL, job={"render": {"checkpoint": "60s"}})
        self.assertRaises(TypeError, raylex.render, CORNELL, progress=3)
        self.assertRaises(TypeError, raylex.render, CORNELL, spp=object())
        self.assertRaises(TypeError, raylex.render, CORNELL, samples=3)
        self.assertRaisesRegex(TypeError, "no argument 'sp'; did you mean 'spp'", raylex.render, CORNELL, sp=3)
        self.assertRaisesRegex(TypeError, "expected {name: expression", raylex.render, CORNELL, lpe=["CDL"])
        self.assertRaisesRegex(TypeError, "expected {name: expression", raylex.render, CORNELL, lpe={"a": 5})
        self.assertRaisesRegex(TypeError, "expected {name: expression", raylex.render, CORNELL, lpe=["ab"])

    def test_one_name_is_a_list_of_one(self):
        image = raylex.render(CORNELL, spp=1, resolution=(4, 4), aovs="Nn", lpe=[("direct", "CDL")])
        self.assertEqual(image["Nn"].shape[:2], (4, 4))
        self.assertEqual(image["direct"].shape[:2], (4, 4))


class WhileItGoesOn(Case):
    def test_an_early_stop_returns_the_partial_image(self):
        seen = []

        def stop(now):
            seen.append((now.fraction, now.seconds, now.samples, now.image().shape, now.standard_error().shape))
            return now.samples == 0

        image = raylex.render(CORNELL, spp=1 << 20, resolution=(32, 24), progress=stop)
        self.assertFalse(image.complete)
        self.assertGreater(image["beauty"].max(), 0)
        self.assertEqual(seen[-1][3:], ((24, 32, 3), (24, 32, 3)))

    def test_an_exception_of_a_callback_has_the_image(self):
        def fails(now):
            if now.samples > 0:
                raise ZeroDivisionError("mine")

        with self.assertRaisesRegex(ZeroDivisionError, "mine") as caught:
            raylex.render(CORNELL, spp=1 << 20, resolution=(16, 16), progress=fails)
        self.assertEqual(caught.exception.image["beauty"].shape, (16, 16, 3))
        self.assertFalse(caught.exception.image.complete)

    def test_control_c_ends_it_with_the_image(self):
        # A process that a shell starts in the background ignores Ctrl-C and would render to the end.
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        self.addCleanup(signal.signal, signal.SIGINT, before)
        timer = threading.Timer(0.3, _thread.interrupt_main)
        timer.start()
        with self.assertRaises(KeyboardInterrupt) as caught:
            raylex.render(CORNELL, spp=1 << 20, resolution=(16, 16))
        timer.join()
        self.assertGreater(caught.exception.image["beauty"].max(), 0)

    def test_other_threads_run_meanwhile(self):
        counted = [0]
        over = threading.Event()

        def count():
            while not over.is_set():
                counted[0] += 1
                time.sleep(0.001)

        thread = threading.Thread(target=count)
        thread.start()
        before = counted[0]
        raylex.render(CORNELL, resolution=(16, 16), spp=1 << 20, time=0.5)
        over.set()
        thread.join()
        self.assertGreater(counted[0] - before, 10)  # of some hundred; with the lock held it would be one or two

    def test_the_error_image_is_the_spread_of_renders(self):
        errors = []

        def watch(now):
            errors[:] = [now.standard_error().copy(), now.image().copy()]

        raylex.render(CORNELL, spp=64, resolution=(16, 16), progress=watch)
        means = np.stack([raylex.render(CORNELL, spp=64, seed=1 + i, resolution=(16, 16))["beauty"] for i in range(16)])
        spread = means.std(axis=0, ddof=1).mean()
        # Means over 768 deviations, each known from 16 renders to 18 %: below 2 %. Samples of a (0, 2)-sequence vary
        # less than independent ones, which the error image assumes: it is an upper bound, at most ten times too large.
        self.assertLess(spread, 1.1 * errors[0].mean())
        self.assertGreater(spread, 0.1 * errors[0].mean())

    def test_progress_is_invalid_after_the_call(self):
        kept = []
        raylex.render(white_furnace(), spp=4, progress=kept.append)
        self.assertTrue(kept)
        self.assertRaylexError("no longer valid", lambda: kept[0].fraction)

    def test_progress_is_invalid_after_a_failed_call(self):
        kept = []

        def fails(now):
            kept.append(now)
            raise ZeroDivisionError

        self.assertRaises(ZeroDivisionError, raylex.render, white_furnace(), spp=4, progress=fails)
        for use in (lambda: kept[0].fraction, kept[0].image, kept[0].standard_error):
            self.assertRaylexError("this progress is no longer valid", use)


if __name__ == "__main__":
    unittest.main()
