#!/usr/bin/env python3
"""Makes the meshes and textures of this scene: python3 make.py, in this folder; needs only Python.

Vessels are surfaces of revolution about y: a profile of (radius, height) points, joined by a Catmull-Rom spline, written
as binary PLY with normals. The textures are sums of value noise. Lengths are decimetres.
"""
import gzip, math, struct, zlib


def catmull_rom(points, per_segment):
    padded = [points[0]] + points + [points[-1]]
    curve = []
    for i in range(1, len(padded) - 2):
        p0, p1, p2, p3 = padded[i - 1:i + 3]
        for k in range(per_segment):
            t = k / per_segment
            curve.append(tuple(0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t * t +
                                      (3 * b - a - 3 * c + d) * t ** 3)
                               for a, b, c, d in zip(p0, p1, p2, p3)))
    return curve + [points[-1]]


def revolve(name, profile, per_segment=6, around=72):
    """Makes a surface of revolution. profile: (radius, height) in order, with the outside on the right; radius 0 closes
    an end."""
    curve = [(max(r, 0.0), y) for r, y in catmull_rom(profile, per_segment)]
    vertices, faces = [], []
    for i, (r, y) in enumerate(curve):
        before, after = curve[max(i - 1, 0)], curve[min(i + 1, len(curve) - 1)]
        dr, dy = after[0] - before[0], after[1] - before[1]
        length = math.hypot(dr, dy) or 1.0
        normal_r, normal_y = dy / length, -dr / length
        if r == 0.0:
            normal_r, normal_y = 0.0, math.copysign(1.0, normal_y)
        for k in range(around):
            c, s = math.cos(2 * math.pi * k / around), math.sin(2 * math.pi * k / around)
            vertices.append((r * c, y, r * s, normal_r * c, normal_y, normal_r * s))
    for i in range(len(curve) - 1):
        for k in range(around):
            a, b = i * around + k, i * around + (k + 1) % around
            c, d = a + around, b + around
            if curve[i][0] > 0.0:
                faces.append((a, c, b))
            if curve[i + 1][0] > 0.0:
                faces.append((b, c, d))
    header = ("ply\nformat binary_little_endian 1.0\nelement vertex %d\n" % len(vertices) +
              "".join("property float %s\n" % p for p in ("x", "y", "z", "nx", "ny", "nz")) +
              "element face %d\nproperty list uchar int vertex_indices\nend_header\n" % len(faces))
    data = header.encode() + b"".join(struct.pack("<6f", *v) for v in vertices)
    data += b"".join(struct.pack("<B3i", 3, *f) for f in faces)
    with open(name, "wb") as file:
        file.write(gzip.compress(data, 9, mtime=0))


def hashed(x, y, seed):
    n = (x * 374761393 + y * 668265263 + seed * 2246822519) & 0xffffffff
    n = ((n ^ (n >> 13)) * 1274126177) & 0xffffffff
    return ((n ^ (n >> 16)) & 0xffff) / 65535.0


def noise(x, y, period_x, period_y, seed):
    """Smooth, tiling value noise."""
    xi, yi = math.floor(x), math.floor(y)
    fx, fy = x - xi, y - yi
    fx, fy = fx * fx * (3 - 2 * fx), fy * fy * (3 - 2 * fy)
    corner = lambda i, j: hashed((xi + i) % period_x, (yi + j) % period_y, seed)
    low = corner(0, 0) * (1 - fx) + corner(1, 0) * fx
    high = corner(0, 1) * (1 - fx) + corner(1, 1) * fx
    return low * (1 - fy) + high * fy


def write_png(name, width, height, pixel):
    rows = bytearray()
    for j in range(height):
        rows.append(0)
        for i in range(width):
            rows += bytes(min(255, max(0, round(255 * c))) for c in pixel(i / width, j / height))
    chunk = lambda kind, data: (struct.pack(">I", len(data)) + kind + data +
                                struct.pack(">I", zlib.crc32(kind + data) & 0xffffffff))
    with open(name, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
                   chunk(b"IDAT", zlib.compress(bytes(rows), 9)) + chunk(b"IEND", b""))


def planks(u, v):
    """Five boards along u, with rings cut lengthwise and dark joints; sRGB."""
    board = int(v * 5)
    across = v * 5 - board
    shift = hashed(board, 7, 1)
    bend = noise(u * 4 + 9 * shift, v * 10, 4, 10, 2) - 0.5
    rings = (across + 0.25 * bend + 3 * shift) * (5 + 3 * shift)
    ring = 0.5 + 0.5 * math.sin(2 * math.pi * (rings + 0.7 * noise(u * 6, v * 40, 6, 40, 3)))
    fibre = noise(u * 24, v * 320, 24, 320, 4)
    tone = 0.62 + 0.10 * ring + 0.10 * fibre + 0.16 * (shift - 0.5)
    joint = min(across, 1 - across)
    tone *= 0.35 + 0.65 * min(1.0, joint / 0.018)
    return 0.86 * tone, 0.60 * tone + 0.01, 0.40 * tone + 0.01


def main():
    # A glass carafe with an inside: from the middle of its foot up the outside, over the lip and down the inside.
    revolve("carafe.ply.gz", [(0, 0), (0.45, 0.0), (0.78, 0.04), (0.92, 0.35), (0.95, 0.8), (0.80, 1.35), (0.42, 1.85), (0.33, 2.3),
                              (0.36, 2.75), (0.46, 3.0), (0.43, 3.03), (0.40, 3.0), (0.29, 2.72), (0.26, 2.3), (0.34, 1.87),
                              (0.71, 1.33), (0.85, 0.8), (0.82, 0.38), (0.68, 0.16), (0.3, 0.12), (0, 0.12)])
    revolve("jug.ply.gz", [(0, 0), (0.55, 0.0), (0.62, 0.06), (0.86, 0.45), (0.93, 0.85), (0.72, 1.3), (0.50, 1.62), (0.55, 1.95), (0.72, 2.15),
                           (0.70, 2.17), (0.51, 1.96), (0.45, 1.62), (0.67, 1.27), (0.87, 0.85), (0.80, 0.47), (0.5, 0.15), (0, 0.1)])
    revolve("bowl.ply.gz", [(0, 0), (0.40, 0.0), (0.45, 0.10), (0.80, 0.22), (1.12, 0.52), (1.25, 0.86), (1.22, 0.89), (1.17, 0.86), (1.04, 0.56),
                            (0.74, 0.30), (0.3, 0.2), (0, 0.19)])
    write_png("planks.png", 640, 320, planks)


main()
