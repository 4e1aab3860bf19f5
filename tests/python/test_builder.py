"""SceneBuilder: parameters of every kind, media, objects, motion, errors, and scenes equal to those of pbrt-v4
files."""

import re
import unittest

import numpy as np

import raylex
from support import Case


def moved(x, y, z):
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def camera(builder, **more):
    builder.film("rgb", xresolution=8, yresolution=8)
    builder.camera("perspective", eye=(0, 0, -4), look=(0, 0, 0), fov=40, **more)


def centre(scene):
    return float(raylex.render(scene, spp=16)["beauty"][3:5, 3:5].mean())


class Written(Case):
    def text(self, builder):
        path = self.folder / "scene.pbrt"
        self.scene = builder.finish()
        self.scene.write(path)
        return path.read_text()


class Parameters(Written):
    def test_numbers_are_written_as_pbrt_reads_them(self):
        builder = raylex.SceneBuilder()
        builder.film("rgb", xresolution=np.int64(8), yresolution=8, cropwindow=[0, 1, 0, 1])
        builder.camera("perspective", eye=(0, 0, -4), look=(0, 0, 0), fov=40)
        builder.integrator("path", maxdepth=3.0)
        builder.material("dielectric", eta="glass-BK7")
        builder.light("distant", L=2, parameters={"from": (0, 4, -4), "to": [0, 0, 0]})
        grey = builder.material("diffuse", reflectance=0.5)
        metal = builder.material("conductor", eta="metal-Au-eta", k="metal-Au-k")
        builder.shape("sphere", radius=1, alpha=1, material=grey)
        builder.shape("trianglemesh", P=[[5, 0, 0], [6, 0, 0], [5, 1, 0]], indices=[0, 1, 2], material=metal)
        text = self.text(builder)
        for part in ('"float fov" [ 40 ]', '"integer xresolution" [ 8 ]', '"float cropwindow" [ 0 1 0 1 ]',
                     '"integer maxdepth" [ 3 ]', '"spectrum eta" [ "glass-BK7" ]', '"rgb L" [ 2 2 2 ]',
                     '"point3 from" [ 0 4 -4 ]', '"point3 to" [ 0 0 0 ]',
                     '"rgb reflectance" [ 0.5 0.5 0.5 ]', '"spectrum eta" [ "metal-Au-eta" ]'):
            self.assertIn(part, text)
        self.assertIsNone(re.search(r'"integer (fov|radius|alpha)"|"float (L|reflectance)"', text), text)
        again = raylex.Scene(self.folder / "scene.pbrt")
        self.assertSameBits(raylex.render(again, spp=4)["beauty"], raylex.render(self.scene, spp=4)["beauty"])

    def test_argument_names_of_the_method_can_be_parameters(self):
        builder = raylex.SceneBuilder()
        builder.texture("by position", "float", "constant", value=0.25)
        builder.texture(name="by keyword", value="float", type="constant", parameters={"value": 0.75})
        builder.shape("curve", type="ribbon", P=np.zeros((4, 3)) + [[0], [1], [2], [3]],
                      N=[[0, 0, 1], [0, 0, 1]], width=0.1)
        builder.shape(type="sphere", parameters={"radius": 2.0}, zmin=-1)
        skin = builder.material("subsurface", parameters={"name": "Skin1"}, name="skin")
        builder.shape("disk", material=skin)
        text = self.text(builder)
        for part in ('"by position" "float" "constant" "float value" [ 0.25 ]', '"by keyword" "float" "constant" '
                     '"float value" [ 0.75 ]', '"curve" "string type" "ribbon"', '"float radius" 2 "float zmin" -1',
                     'MakeNamedMaterial "skin" "string type" "subsurface" "string name" [ "Skin1" ]'):
            self.assertIn(part, text)

    def test_a_measured_medium_as_a_materials_name_is_refused(self):
        builder = raylex.SceneBuilder()
        error = self.assertRaylexError("name='Skin1' would name the material", builder.material, "subsurface",
                                       name="Skin1")
        self.assertIn("parameters={'name': 'Skin1'}", error.hint)
        builder.material("subsurface", name="my skin", sigma_a=1.0)
        builder.material("diffuse", name="Skin1")

    def test_lists_of_text(self):
        for number, names in enumerate((["red", "blue"], ("red", "blue"), ("string", ["red", "blue"]),
                                        np.array(["red", "blue"]))):
            builder = raylex.SceneBuilder()
            camera(builder)
            builder.light("infinite", L=(1, 1, 1))
            builder.material("diffuse", name="red", reflectance=(0.5, 0, 0))
            builder.material("diffuse", name="blue", reflectance=(0, 0, 0.5))
            builder.shape("sphere", material=builder.material("mix", materials=names, amount=0.25))
            image = raylex.render(builder.finish(), spp=256)["beauty"][3:5, 3:5].mean(axis=(0, 1))
            # Three quarters of the hits are red: 1024 samples in each of four pixels, five standard deviations.
            share = image[0] / (image[0] + image[2])
            self.assertLess(abs(share - 0.75), 5 * np.sqrt(0.75 * 0.25 / 1024), number)
            self.assertEqual(image[1], 0)

    def test_booleans_of_numpy(self):
        for value in (True, np.bool_(True), ("bool", True), ("bool", np.bool_(True)), np.array(True)):
            builder = raylex.SceneBuilder()
            builder.area_light(L=1, twosided=value)
            self.assertIn('"bool twosided" [ true ]', self.text(builder))


class Refused(Case):
    def setUp(self):
        super().setUp()
        self.builder = raylex.SceneBuilder()

    def refuses(self, pattern, call, *arguments, **named):
        error = self.assertRaylexError(pattern, call, *arguments, **named)
        self.assertTrue(error.file.endswith(".py"), error.file)
        self.assertGreater(error.line, 0)

    def test_invalid_parameter_values(self):
        b = self.builder
        self.refuses("parameter 'radius' is None; expected a bool, int, float or str", b.shape, "sphere", radius=None)
        self.refuses("parameter 'radius' is not a number", b.shape, "sphere", radius=float("nan"))
        self.refuses("parameter 'power' is not a number", b.area_light, power=np.nan)
        self.refuses("parameter 'fov' is infinite", b.camera, "perspective", eye=(0, 0, 1), look=(0, 0, 0), fov=np.inf)
        self.refuses("parameter 'I' is 1j", b.light, "point", I=1j)
        self.refuses("parameter 'I' is {}", b.light, "point", I={})
        self.refuses("of type bool is 1 .*; expected True or False", b.area_light, twosided=("bool", 1))
        self.refuses("of type float is 'x' .*; expected numbers", b.shape, "sphere", radius=("float", "x"))
        self.refuses("of type float is True .*; expected numbers", b.shape, "sphere", radius=("float", True))
        self.refuses("of type texture is 1 .*; expected the texture's name", b.material, "diffuse",
                     reflectance=("texture", 1))
        self.refuses("has the type 'colour'; expected one of bool", b.material, "diffuse",
                     reflectance=("colour", (1, 1, 1)))
        self.refuses("'pixelsamples' is 2.5 .*; expected integers", b.sampler, "halton", pixelsamples=2.5)
        self.refuses("'materials' has no values", b.material, "mix", materials=[])
        self.refuses("'roughness' is 'map' .*; expected a number", b.material, "conductor", roughness="map")
        error = self.assertRaylexError("'reflectance' is 'checks' .*; expected a colour", b.material, "diffuse",
                                       reflectance="checks")
        self.assertIn("('texture', 'checks')", error.hint)
        self.refuses("'parameters' is 5", b.film, "rgb", parameters=5)
        self.refuses("a parameter name is 5", b.film, "rgb", parameters={5: 1})
        self.refuses("'iso' is given in `parameters` and as a keyword", b.film, "rgb", parameters={"iso": 1}, iso=2)

    def test_invalid_handles(self):
        b = self.builder
        light, grey, fog = b.area_light(L=1), b.material("diffuse"), b.medium("fog", "homogeneous")
        self.refuses("material is 5 .*; expected a Material", b.shape, "sphere", material=5)
        self.refuses("material is .*AreaLight.*; expected a Material", b.shape, "sphere", material=light)
        self.refuses("area_light is 'key' .*; expected an AreaLight", b.shape, "sphere", area_light="key")
        self.refuses("area_light is .*Material.*; expected an AreaLight", b.shape, "sphere", area_light=grey)
        self.refuses("inside is .*Material.*; expected a Medium", b.shape, "sphere", inside=grey)
        self.refuses("outside is 1 .*; expected a Medium", b.shape, "sphere", outside=1)
        self.refuses("object is .*Medium.*; expected an Object", b.shape, "sphere", object=fog)
        self.refuses("object is None; expected an Object", b.instance, None)
        self.refuses("medium is 1 .*; expected a Medium", b.camera, "perspective", eye=(0, 0, 1), look=(0, 0, 0),
                     medium=1)

    def test_handles_of_another_builder(self):
        other, b = raylex.SceneBuilder(), self.builder
        for _ in range(50):
            material = other.material("diffuse")
        self.refuses("the material belongs to another scene builder", b.shape, "sphere", material=material)
        self.refuses("the area light belongs to another", b.shape, "sphere", area_light=other.area_light(L=1))
        self.refuses("the object belongs to another", b.instance, other.object("thing"))
        self.refuses("the medium inside belongs to another", b.mesh, np.eye(3), [[0, 1, 2]],
                     inside=other.medium("fog", "homogeneous"))
        b.finish()

    def test_arrays_of_meshes(self):
        triangle, mesh = np.eye(3), self.builder.mesh
        self.refuses("indices has 1.5; expected integers", mesh, triangle, [[0, 1.5, 2]])
        self.refuses("indices has nan; expected integers", mesh, triangle, [[0, np.nan, 2]])
        self.refuses("indices has 9223372036854775808, and there are 3", mesh, triangle, [[0, 1, 2**63]])
        self.refuses("indices has -1, and there are 3", mesh, triangle, [[0, 1, -1]])
        self.refuses(r"to_world has shape \(3, 3\)", mesh, triangle, [[0, 1, 2]], to_world=np.eye(3))
        self.refuses("indices is an array of bool", mesh, triangle, np.array([[True, False, True]]))
        self.refuses("indices is an array of complex128", mesh, triangle, [[0, 1j, 2]])
        self.refuses("positions is an array of complex128", mesh, triangle * 1j, [[0, 1, 2]])
        self.refuses("positions is an array of bool", mesh, triangle > 0, [[0, 1, 2]])
        self.refuses("positions is None", mesh, None, [[0, 1, 2]])
        self.refuses("position 1 of the mesh is not finite", mesh, [[0, 0, 0], [1, np.nan, 0], [0, 1, 0]], [[0, 1, 2]])
        self.refuses("to_world has nan", mesh, triangle, [[0, 1, 2]], to_world=np.eye(4) * np.nan)
        mesh(triangle, [[0.0, 1.0, 2.0]], uvs=[[0, np.nan], [1, 1], [0, 1]])
        self.assertTrue(any("texture coordinates" in each for each in self.builder.finish().warnings))

    def test_settings(self):
        b = self.builder
        self.refuses("missing_files is 'skip'", raylex.SceneBuilder, missing_files="skip")
        self.refuses("color_space is 'rgb'", raylex.SceneBuilder, color_space="rgb")
        self.refuses("position is missing or given twice", b.camera, "perspective")
        self.refuses("position is missing or given twice", b.camera, "perspective", eye=(0, 0, 1))
        self.refuses("position is missing or given twice", b.camera, "perspective", eye=(0, 0, 1), look=(0, 0, 0),
                     world_to_camera=np.eye(4))
        self.refuses("expected finite ones", b.transform_times, -np.inf, 1)
        self.refuses("expected the earlier one first", b.transform_times, 1, 0)
        self.refuses("is not above 0", b.scale_displacement_edges, 0)
        self.refuses("eye has nan", b.camera, "perspective", eye=(0, np.nan, 0), look=(0, 1, 0))
        self.refuses("'up' is parallel", b.look_at, (0, 0, 0), (0, 1, 0))

    def test_a_builder_that_failed_cannot_be_used_again(self):
        self.builder.shape("sphere", material="nobody")
        self.assertRaylexError("nobody", self.builder.finish)
        self.refuses("finished; expected a new SceneBuilder", self.builder.finish)

    def test_labels_by_materials_without_names(self):
        self.builder.shape("sphere", material=self.builder.material("diffuse"))
        error = self.assertRaylexError("no shape of the scene has a material with a name",
                                       self.builder.finish().label, "material", "*", "zz")
        self.assertIn("MakeNamedMaterial", error.hint)


class Worlds(Written):
    def test_media(self):
        # Through the middle of a ball of radius 1 that only absorbs, before a sky of 1: exp(-sigma chord). The four
        # pixels in the middle see chords from 2 down to those at their corners, at most 0.53 off the axis.
        def through(inside):
            builder = raylex.SceneBuilder()
            camera(builder)
            builder.light("infinite", L=1)
            made = builder.medium("ink", "homogeneous", sigma_a=(0.5, 0.5, 0.5), sigma_s=0)
            builder.shape("sphere", material=builder.material("interface"), inside=made if inside is None else inside)
            return centre(builder.finish())
        self.assertGreater(through(None), np.exp(-1))
        self.assertLess(through(None), np.exp(-np.sqrt(1 - 0.53**2)))
        self.assertEqual(through("ink"), through(None))

    def test_the_cameras_medium(self):
        # A camera in an absorbing medium that ends at a ball of radius 0.5 around it.
        builder = raylex.SceneBuilder()
        builder.film("rgb", xresolution=8, yresolution=8)
        ink = builder.medium("ink", "homogeneous", sigma_a=1, sigma_s=0)
        builder.camera("perspective", eye=(0, 0, 0), look=(0, 0, 1), fov=40, medium=ink)
        builder.light("infinite", L=1)
        builder.shape("sphere", radius=0.5, material=builder.material("interface"), inside=ink)
        self.assertLess(abs(centre(builder.finish()) - np.exp(-0.5)), 1e-4)

    def test_a_mediums_and_a_textures_place(self):
        builder = raylex.SceneBuilder()
        builder.medium("cloud", "cloud", to_world=moved(1, 2, 3))
        builder.texture("t", "float", "checkerboard", mapping="planar", to_world=moved(4, 5, 6))
        text = self.text(builder)
        self.assertIn("Transform [ 1 0 0 0 0 1 0 0 0 0 1 0 1 2 3 1 ]", text)
        self.assertIn("Transform [ 1 0 0 0 0 1 0 0 0 0 1 0 4 5 6 1 ]", text)

    def test_objects_and_instances(self):
        builder = raylex.SceneBuilder()
        ball = builder.object("ball")
        builder.shape("sphere", radius=0.5, object=ball)
        builder.mesh(np.eye(3), [[0, 1, 2]], object="ball")
        builder.instance(ball, to_world=moved(1, 0, 0))
        builder.instance("ball", to_world=moved(2, 0, 0))
        text = self.text(builder)
        self.assertEqual(text.count('ObjectInstance "ball"'), 2)
        begin, end = text.index("ObjectBegin"), text.index("ObjectEnd")
        self.assertIn('Shape "sphere"', text[begin:end])
        self.assertIn('Shape "trianglemesh"', text[begin:end])
        builder = raylex.SceneBuilder()
        builder.instance("bal")
        self.assertRaylexError("no object is called 'bal'", builder.finish)

    def test_motion_is_written_and_seen(self):
        def scene(**motion):
            builder = raylex.SceneBuilder()
            camera(builder)
            builder.light("infinite", L=1)
            builder.transform_times(0.25, 0.75)
            black = builder.material("diffuse", reflectance=0.0)
            builder.mesh([[-9, -9, 0], [0, -9, 0], [0, 9, 0], [-9, 9, 0]], [[0, 1, 3, 2]], material=black, **motion)
            return builder
        # The left half is black. A quad that has moved away when the shutter is three quarters open hides it half the
        # time.
        still, moving = centre(scene().finish()), scene(moved_to=moved(-40, 0, 0))
        text = self.text(moving)
        self.assertIn("TransformTimes 0.25 0.75", text)
        self.assertIn("ActiveTransform EndTime", text)
        self.assertGreater(centre(self.scene), still + 0.2)

    def test_moving_cameras_and_instances(self):
        builder = raylex.SceneBuilder()
        first = raylex.SceneBuilder.look_at((0, 0, -4), (0, 0, 0))
        last = raylex.SceneBuilder.look_at((1, 0, -4), (1, 0, 0))
        self.assertEqual((first.shape, first.dtype), ((4, 4), np.float64))
        np.testing.assert_allclose(first @ (0, 0, 0, 1), (0, 0, 4, 1))
        builder.camera("perspective", world_to_camera=first, moved_to=last, fov=30)
        builder.shape("sphere", object=builder.object("ball"))
        builder.instance("ball", to_world=moved(0, 0, 1), moved_to=moved(0, 1, 1))
        text = self.text(builder)
        self.assertEqual(text.count("ActiveTransform EndTime"), 2)
        self.assertIn("Translate -1", text)

    def test_a_camera_by_matrix_is_the_one_by_points(self):
        def image(**place):
            builder = raylex.SceneBuilder()
            builder.film("rgb", xresolution=8, yresolution=8)
            builder.camera("perspective", fov=40, **place)
            builder.light("point", I=30, parameters={"from": (0, 5, -5)})
            builder.shape("sphere")
            return raylex.render(builder.finish(), spp=4)["beauty"]
        matrix = raylex.SceneBuilder.look_at((1, 2, -4), (0, 0, 0))
        np.testing.assert_allclose(image(world_to_camera=matrix), image(eye=(1, 2, -4), look=(0, 0, 0)), rtol=1e-4)

    def test_colour_space(self):
        builder = raylex.SceneBuilder(color_space="rec2020")
        self.assertIn('ColorSpace "rec2020"', self.text(builder))

    def test_folder_and_missing_files(self):
        builder = raylex.SceneBuilder(folder=self.folder)
        (self.folder / "flat.spd").write_text("300 0.5\n900 0.5\n")
        builder.material("conductor", eta=("spectrum", "flat.spd"))
        self.assertRaylexError("no-such.png", builder.texture, "t", "spectrum", "imagemap", filename="no-such.png")
        builder = raylex.SceneBuilder(missing_files="placeholders")
        builder.texture("t", "spectrum", "imagemap", filename="no-such.png")
        self.assertTrue(any("magenta" in each for each in builder.finish().warnings))

    def test_filtering_and_displacement(self):
        (self.folder / "quad.ply").write_text(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
            "property float u\nproperty float v\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
            "0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n4 0 1 2 3\n")
        builder = raylex.SceneBuilder(folder=str(self.folder))
        builder.texture("up", "float", "constant", value=0.1)
        builder.shape("plymesh", filename="quad.ply", displacement="up", edgelength=0.5)
        builder.scale_displacement_edges(0.5)
        builder.disable_texture_filtering()
        self.assertIn('"texture displacement" "up" "float edgelength" 0.25', self.text(builder))

    def test_curves(self):
        builder = raylex.SceneBuilder()
        points = np.zeros((8, 3), np.float32)
        points[:, 0] = np.arange(8)
        builder.curves(points, [0, 4], [[0.1, 0.2], [0.3, 0.4]], type="cylinder")
        self.assertRaylexError("expected flat, cylinder or ribbon", builder.curves, points, [0, 4], [[1, 1], [1, 1]],
                               type="round")
        self.assertRaylexError(r"first_points has shape \(1, 2\)", builder.curves, points, [[0, 4]], [[1, 1], [1, 1]])
        text = self.text(builder)
        self.assertEqual(text.count('"curve" "string type" "cylinder"'), 2)
        self.assertIn('"float width1" [ 0.4 ]', text)


if __name__ == "__main__":
    unittest.main()
