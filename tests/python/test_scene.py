"""Scenes: loading, inspection, building from arrays, and errors."""

import json
import unittest

import numpy as np

import raylex
from support import CORNELL, Case, quad, run_program, white_furnace


class Loaded(Case):
    def test_info_equals_the_programs(self):
        scene = raylex.Scene(CORNELL)
        facts = scene.info()
        told = self.folder / "info.json"
        done = run_program("scene", "info", CORNELL, "--json", told)
        self.assertEqual(done.returncode, 0, done.stderr)
        theirs = json.loads(told.read_text())
        self.assertEqual(set(facts), set(theirs))
        for key in set(facts) - {"read_seconds", "build_seconds", "peak_bytes"}:
            self.assertEqual(facts[key], theirs[key], key)
        self.assertEqual(facts["labels"], scene.info(build=False)["labels"])

    def test_labels_make_another_scene(self):
        scene = raylex.Scene(CORNELL)
        grouped = scene.label("light", "area:0", "key")
        self.assertEqual(grouped.words().terminals[0].labels, ("key",))
        self.assertEqual(scene.words().terminals[0].labels, ("",))
        image = raylex.render(grouped, spp=4, resolution=(16, 16), light_groups=True)
        # The only light is in its group, so the layer equals the beauty, bit for bit.
        self.assertSameBits(image["light_key"], image["beauty"])

    def test_errors_have_file_and_line(self):
        file = self.folder / "bad.pbrt"
        file.write_text('Camera "perspective" "float fov" 40\nWorldBegin\nShape "spere" "float radius" 1\n')
        error = self.assertRaylexError("spere", raylex.Scene, str(file))
        self.assertEqual((error.file, error.line), (str(file), 3))
        self.assertIn("sphere", error.hint)
        self.assertRaylexError("no-such.pbrt", raylex.Scene, "no-such.pbrt")
        self.assertRaylexError("no-such", raylex.Scene(CORNELL).label, "material", "no-such", "x")
        self.assertRaylexError("selects nothing", raylex.Scene(CORNELL).label, "colour", "x", "y")


class Built(Case):
    def test_a_mesh_from_arrays_has_the_right_radiance(self):
        # A diffuse plane at distance 1 below a point light of intensity I at the camera: radiance albedo / pi I cos^3.
        image = raylex.render(quad(), spp=256, resolution=(9, 9), max_depth=1)
        centre = image["beauty"][4, 4]
        # In the middle pixel cos^3 falls from 1 by at most 3/2 tan^2(half pixel) with tan = tan(20 deg) / 9.
        slack = 1.5 * 2 * (np.tan(np.radians(20)) / 9) ** 2
        self.assertTrue(np.all(np.abs(centre / (0.5 / np.pi * 10) - 1) < slack), centre)

    def test_float64_and_fortran_arrays_are_converted(self):
        builder = raylex.SceneBuilder()
        positions = np.asfortranarray(np.array([[0, 0, 1], [1, 0, 1], [0, 1, 1]], np.float64))
        builder.mesh(positions, [[0, 1, 2]])
        self.assertEqual(builder.finish().info()["primitives"], quad_of_one().info()["primitives"])

    def test_the_scene_as_a_file_is_the_same_scene(self):
        scene = white_furnace()
        path = str(self.folder / "furnace.pbrt")
        # pbrt has no light groups, and a note reports that
        self.assertTrue(any("group" in each for each in scene.write(path)))
        a = raylex.render(scene, spp=4)
        b = raylex.render(path, spp=4)
        self.assertSameBits(a["beauty"], b["beauty"])

    def test_parameters_by_type(self):
        builder = raylex.SceneBuilder()
        builder.texture("checks", "spectrum", "checkerboard", tex1=(1.0, 0.0, 0.0), tex2=("rgb", (0, 0, 1)), uscale=4.0)
        builder.material("diffuse", name="floor", reflectance=("texture", "checks"))
        builder.shape("sphere", radius=2.0, material="floor", to_world=np.diag([1, 2, 1, 1]))
        builder.light("distant", **{"from": ("point3", (0, 0, 1)), "to": ("point3", (0, 0, 0))})
        self.assertIn("sphere", str(builder.finish().info()))

    def test_errors_have_their_place(self):
        builder = raylex.SceneBuilder()
        error = self.assertRaylexError("reflectence", builder.material, "diffuse", reflectence=0.5)
        self.assertTrue(error.file.endswith("support.py") or error.file.endswith("test_scene.py"), error.file)
        self.assertGreater(error.line, 0)
        triangle = np.zeros((3, 3))
        self.assertRaylexError(r"positions has shape \(3, 2\); expected \(3, 3\)", builder.mesh, np.zeros((3, 2)),
                               [[0, 1, 2]])
        self.assertRaylexError("indices has 3", builder.mesh, triangle, [[0, 1, 3]])
        self.assertRaylexError(r"indices has shape \(1, 2\)", builder.mesh, triangle, [[0, 1]])
        self.assertRaylexError("not an array of numbers", builder.mesh, "mesh", [[0, 1, 2]])
        self.assertRaylexError("no inverse", builder.shape, "sphere", to_world=np.zeros((4, 4)))
        self.assertRaylexError("'up' is parallel", builder.camera, "perspective", eye=(0, 0, 0), look=(0, 1, 0))
        self.assertRaylexError("expected one of bool, integer, float", builder.material, "diffuse",
                               reflectance=("colour", (1, 1, 1)))
        builder.shape("sphere", material="nobody")
        self.assertRaylexError("nobody", builder.finish)

    def test_a_finished_builder_cannot_be_used_again(self):
        builder = raylex.SceneBuilder()
        builder.finish()
        self.assertRaylexError("finished", builder.shape, "sphere")


def quad_of_one():
    builder = raylex.SceneBuilder()
    builder.mesh(np.array([[0, 0, 1], [1, 0, 1], [0, 1, 1]], np.float32), [[0, 1, 2]])
    return builder.finish()


if __name__ == "__main__":
    unittest.main()
