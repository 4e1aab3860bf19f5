"""Shared code of the tests of `import raylex`."""

import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy as np

import raylex

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENES = ROOT / "experiments" / "scenes"
CORNELL = str(SCENES / "cornell-grey" / "scene.pbrt")
FULL = os.environ.get("RAYLEX_FULL") == "1"
PROGRAM = os.environ.get("RAYLEX_PROGRAM", str(ROOT / "build" / "release" / "raylex"))


def run_program(*arguments):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, check=False)


def white_furnace(albedo=0.5, radiance=1.0):
    """Writes the inside of a sphere that emits and scatters: each pixel is radiance * sum of albedo^k over scattering
    events k."""
    builder = raylex.SceneBuilder("furnace")
    builder.film("rgb", xresolution=16, yresolution=16)
    builder.camera("perspective", eye=(0, 0, 0), look=(0, 0, 1), fov=60)
    wall = builder.material("diffuse", name="wall", reflectance=(albedo,) * 3)
    light = builder.area_light(L=(radiance,) * 3, group="walls")
    builder.shape("sphere", radius=1.0, material=wall, area_light=light, reverse_orientation=True)
    return builder.finish()


def quad(material=None, **more):
    """Writes a square in the plane z = 1 before a camera at the origin, under one point light."""
    builder = raylex.SceneBuilder("quad")
    builder.film("rgb", xresolution=8, yresolution=8)
    builder.camera("perspective", eye=(0, 0, 0), look=(0, 0, 1), fov=40)
    made = material(builder) if material else builder.material("diffuse", name="quad", reflectance=(0.5, 0.5, 0.5))
    builder.light("point", I=(10.0, 10.0, 10.0))
    positions = np.array([[-2, -2, 1], [2, -2, 1], [2, 2, 1], [-2, 2, 1]], np.float32)
    uvs = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    builder.mesh(positions, np.array([[0, 1, 2], [0, 2, 3]]), uvs=uvs, material=made, **more)
    return builder.finish()


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def assertRaylexError(self, pattern, call, *arguments, **named):
        with self.assertRaisesRegex(raylex.RaylexError, pattern) as caught:
            call(*arguments, **named)
        return caught.exception

    def assertSameBits(self, a, b):
        self.assertEqual(a.shape, b.shape)
        self.assertEqual(a.tobytes(), b.tobytes())
