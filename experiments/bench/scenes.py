#!/usr/bin/env python3
"""Generates scenes for benchmarks as pbrt files: python3 scenes.py FOLDER NAME...; needs only Python.

    cornell8     a box open to the camera with eight lamps side by side, a glossy and a diffuse box: 50 triangles
    terrain      a displaced grid of 999,698 triangles under a constant sky
    terrain:N    terrain with about N triangles
    lights:N     N emitters, triangles with several powers, above a floor; the total power does not depend on N

Each becomes FOLDER/NAME.pbrt, with - for the colon; large meshes are PLY files beside it. cycles.py builds the same
geometry in Blender.
"""
import array
import dataclasses
import math
import pathlib
import random
import struct
import sys


@dataclasses.dataclass
class Material:
    reflectance: tuple
    roughness: float = None  # alpha of a GGX metal; none: diffuse
    radiance: float = 0.0  # emission of both sides


@dataclasses.dataclass
class Mesh:
    name: str
    material: Material
    vertices: list  # (x, y, z); z is up
    faces: list     # of three or four vertices


@dataclasses.dataclass
class Scene:
    eye: tuple
    target: tuple
    half_tangent: float  # of the field of view, from the middle to the edge
    meshes: list
    sky: float = 0.0
    depth: int = 8
    resolution: int = 400


WHITE = Material((0.73,) * 3)


def quad(name, material, *corners):
    return Mesh(name, material, list(corners), [(0, 1, 2, 3)])


def box(name, material, center, half, turn):
    cosine, sine = math.cos(turn), math.sin(turn)
    vertices = [(center[0] + cosine * x * half[0] - sine * y * half[1], center[1] + sine * x * half[0] + cosine * y * half[1],
                 center[2] + z * half[2]) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    return Mesh(name, material, vertices,
                [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])


def cornell8():
    red, green = Material((0.65, 0.05, 0.05)), Material((0.12, 0.45, 0.15))
    meshes = [
        quad("floor", WHITE, (-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1)),
        quad("ceiling", WHITE, (-1, -1, 1), (-1, 1, 1), (1, 1, 1), (1, -1, 1)),
        quad("back", WHITE, (-1, 1, -1), (1, 1, -1), (1, 1, 1), (-1, 1, 1)),
        quad("left", red, (-1, -1, -1), (-1, 1, -1), (-1, 1, 1), (-1, -1, 1)),
        quad("right", green, (1, -1, -1), (1, -1, 1), (1, 1, 1), (1, 1, -1)),
        box("tall", Material((0.9,) * 3, roughness=0.04), (-0.35, 0.3, -0.4), (0.3, 0.3, 0.6), 0.3),
        box("short", WHITE, (0.35, -0.3, -0.7), (0.3, 0.3, 0.3), -0.3),
    ]
    lamp, width = Material((0, 0, 0), radiance=17), 0.5 / 8
    for i in range(8):
        x = -0.25 + width * i
        meshes.append(quad(f"lamp{i}", lamp, (x, -0.25, 0.999), (x, 0.25, 0.999), (x + width, 0.25, 0.999),
                           (x + width, -0.25, 0.999)))
    return Scene((0, -3.4, 0), (0, 0, 0), 0.42, meshes)


def height(x, y):
    total, amplitude, frequency = 0.0, 1.0, 1.0
    for octave in range(6):
        total += amplitude * math.sin(frequency * 6.8 * x + 1.3 * octave + 2 * math.sin(frequency * 3.6 * y)) * math.cos(
            frequency * 7.6 * y + 0.7 * octave)
        amplitude, frequency = amplitude * 0.5, frequency * 2.03
    return 0.15 * total - 0.3


def terrain(triangles=999_698):
    side = max(1, round(math.sqrt(triangles / 2)))
    steps = [2 * i / side - 1 for i in range(side + 1)]
    vertices = [(x, y, height(x, y)) for y in steps for x in steps]
    faces = []
    for row in range(side):
        for i in range(row * (side + 1), row * (side + 1) + side):
            faces += [(i, i + 1, i + side + 1), (i + 1, i + side + 2, i + side + 1)]
    return Scene((0, -1.5, 0.55), (0, 0, -0.4), 0.5, [Mesh("terrain", WHITE, vertices, faces)], sky=1)


def lights(count):
    chance = random.Random(count)
    size = 0.5 / math.sqrt(count)  # the total area of the emitters does not depend on their number
    groups = [Mesh(f"emitters{k}", Material((0, 0, 0), radiance=4.0 ** k), [], []) for k in range(min(count, 4))]
    for i in range(count):
        center = [chance.uniform(-1.8, 1.8), chance.uniform(-1.8, 1.8), chance.uniform(0.1, 0.6)]
        mesh = groups[i % len(groups)]
        first = len(mesh.vertices)
        for _ in range(3):
            mesh.vertices.append(tuple(c + chance.uniform(-size, size) for c in center))
        mesh.faces.append((first, first + 1, first + 2))
    floor = quad("floor", Material((0.6,) * 3), (-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0))
    return Scene((0, -4.6, 3.4), (0, 0, 0), 0.42, [floor, *groups], depth=1)


def make(name):
    kind, _, number = name.partition(":")
    makers = {"cornell8": cornell8, "terrain": terrain, "lights": lights}
    if kind not in makers or (kind == "lights") > bool(number) or (kind == "cornell8" and number):
        sys.exit(f"scenes.py: unknown scene '{name}'; expected cornell8, terrain, terrain:N or lights:N")
    return makers[kind](int(number)) if number else makers[kind]()


def triangles_of(mesh):
    for face in mesh.faces:
        for i in range(1, len(face) - 1):
            yield face[0], face[i], face[i + 1]


def write_ply(mesh, file):
    count = sum(len(face) - 2 for face in mesh.faces)
    header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(mesh.vertices)}\n"
              "property float x\nproperty float y\nproperty float z\n"
              f"element face {count}\nproperty list uchar int vertex_indices\nend_header\n")
    pack = struct.Struct("<B3i").pack
    with open(file, "wb") as out:
        out.write(header.encode())
        array.array("f", (c for vertex in mesh.vertices for c in vertex)).tofile(out)
        out.writelines(pack(3, *triangle) for triangle in triangles_of(mesh))


def shape(mesh, folder, stem):
    if len(mesh.faces) > 1000:
        ply = f"{stem}-{mesh.name}.ply"
        write_ply(mesh, folder / ply)
        return f'Shape "plymesh" "string filename" "{ply}"'
    indices = " ".join(str(i) for triangle in triangles_of(mesh) for i in triangle)
    points = " ".join(f"{c:.9g}" for vertex in mesh.vertices for c in vertex)
    return f'Shape "trianglemesh" "integer indices" [{indices}] "point3 P" [{points}]'


def rgb(color):
    return "[" + " ".join(f"{c:g}" for c in color) + "]"


def write_pbrt(scene, folder, stem):
    """Writes the scene mirrored, because pbrt's camera space is left-handed and those of others are right-handed; the
    images then coincide."""
    fov = 2 * math.degrees(math.atan(scene.half_tangent))
    look = " ".join(f"{c:g}" for c in (*scene.eye, *scene.target, 0, 0, 1))
    lines = [f'Film "rgb" "string filename" "{stem}.exr" "integer xresolution" {scene.resolution} '
             f'"integer yresolution" {scene.resolution} "bool savefp16" false',
             'PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5',
             'Sampler "zsobol" "integer pixelsamples" 64',
             f'Integrator "path" "integer maxdepth" {scene.depth}',
             "Scale -1 1 1", f"LookAt {look}", f'Camera "perspective" "float fov" {fov:.9g}', "WorldBegin"]
    if scene.sky:
        lines.append(f'LightSource "infinite" "rgb L" {rgb((scene.sky,) * 3)}')
    for mesh in scene.meshes:
        material = mesh.material
        lines.append("AttributeBegin")
        if material.roughness is None:
            lines.append(f'Material "diffuse" "rgb reflectance" {rgb(material.reflectance)}')
        else:
            lines.append(f'Material "conductor" "rgb reflectance" {rgb(material.reflectance)} '
                         f'"float roughness" {material.roughness:g} "bool remaproughness" false')
        if material.radiance:
            lines.append(f'AreaLightSource "diffuse" "rgb L" {rgb((material.radiance,) * 3)} "bool twosided" true')
        lines += [shape(mesh, folder, stem), "AttributeEnd"]
    file = folder / f"{stem}.pbrt"
    file.write_text("\n".join(lines) + "\n")
    return file


def generate(folder, name):
    """Returns FOLDER/NAME.pbrt, and generates it if it does not exist."""
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    stem = name.replace(":", "-")
    file = folder / f"{stem}.pbrt"
    return file if file.exists() else write_pbrt(make(name), folder, stem)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    for each in sys.argv[2:]:
        print(generate(sys.argv[1], each))
