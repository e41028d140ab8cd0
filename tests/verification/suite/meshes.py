"""Meshes of the cases: bricks of a lattice, each cut into six tetrahedra and mapped to the body.

A mesh of quadratic tetrahedra has its vertices in the middles of edges where the map takes the middle of
the edge in the lattice. They lie on curved boundaries therefore.
"""

import math
import os
import random
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "..", "data"))

from structured_meshes import cut_prism, write_msh  # noqa: E402


class Lattice:
    """Bricks i, j, k of a lattice, and the map from (i, j, k) to the points of the body.

    `keep(i, j, k)` says whether a brick belongs to the body. With `periodic` the lattice closes upon itself
    along its first direction.
    """

    def __init__(self, cells, place, keep=None, periodic=False):
        self.place, self.turn = place, cells[0] if periodic else None
        self.indices, self.numbers, self.tetrahedra = [], {}, []
        for k in range(cells[2]):
            for j in range(cells[1]):
                for i in range(cells[0]):
                    if keep is None or keep(i, j, k):
                        self.add_brick(i, j, k)
        self.points = [place(*index) for index in self.indices]

    def number(self, i, j, k):
        if self.turn is not None:
            i %= self.turn
        if (i, j, k) not in self.numbers:
            self.numbers[i, j, k] = len(self.indices)
            self.indices.append((i, j, k))
        return self.numbers[i, j, k]

    def add_brick(self, i, j, k):
        a, b, c, d, e, f, g, h = (self.number(i + p, j + q, k + r) for r in (0, 1)
                                  for p, q in ((0, 0), (1, 0), (1, 1), (0, 1)))
        self.tetrahedra += cut_prism((a, b, c, e, f, g))
        self.tetrahedra += cut_prism((a, c, d, e, g, h))

    def add_middles(self, straight=False):
        """The vertices in the middles of the edges, by the ends of the edges."""
        middles = {}
        for t in self.tetrahedra:
            for m in range(4):
                for n in range(m):
                    edge = (min(t[m], t[n]), max(t[m], t[n]))
                    if edge in middles:
                        continue
                    ends = [list(self.indices[v]) for v in edge]
                    if self.turn is not None and abs(ends[0][0] - ends[1][0]) > 1:
                        min(ends)[0] += self.turn
                    middles[edge] = len(self.points)
                    if straight:
                        p, q = (self.points[v] for v in edge)
                        self.points.append(tuple(0.5 * (x + y) for x, y in zip(p, q)))
                    else:
                        self.points.append(self.place(*(0.5 * (x + y) for x, y in zip(*ends))))
        return middles


def arc_beam(cells):
    """The beam of Turek and Hron, 0.02 m high, from the arc of the cylinder to x = 0.6 m."""
    nx, ny, nz = cells

    def place(i, j, k):
        y = 0.02 * (j / ny - 0.5)
        root = 0.2 + math.sqrt(0.05 ** 2 - y ** 2)
        return root + (0.6 - root) * i / nx, 0.2 + y, 0.02 / ny * k

    return Lattice(cells, place), []


def cook(cells):
    """Cook's membrane: 48 long, 44 high on the left and 16 on the right, 4 thick."""
    nx, ny, nz = cells

    def place(i, j, k):
        s = i / nx
        return 48.0 * s, 44.0 * s + (44.0 - 28.0 * s) * j / ny, 4.0 * k / nz

    return Lattice(cells, place), []


def bushing(cells):
    """A tube about the z axis, 8 mm to 20 mm in radius and 30 mm long: cells around, across and along."""
    around, across, along = cells

    def place(i, j, k):
        # Equal ratios of the radii, since shear strains fall with their square.
        radius = 0.008 * (0.020 / 0.008) ** (j / across)
        angle = -2.0 * math.pi * i / around  # so that the bricks are right-handed
        return radius * math.cos(angle), radius * math.sin(angle), 0.030 * k / along

    def on(radius):
        return lambda p: abs(math.hypot(p[0], p[1]) - radius) < 1e-9

    return (Lattice(cells, place, periodic=True),
            [("inner", on(0.008)), ("outer", on(0.020))])


def l_block(cells):
    """The block of Simo and Tarnow, 6 m x 10 m x 3 m with legs of 3 m: cells in 3 m of each direction."""
    n = cells[0]
    lattice = Lattice((2 * n, math.ceil(10 * n / 3), n),
                      lambda i, j, k: (3.0 * i / n, min(3.0 * j / n, 3.0) + 7.0 * max(j - n, 0)
                                       / (math.ceil(10 * n / 3) - n), 3.0 * k / n),
                      keep=lambda i, j, k: i < n or j < n)
    return lattice, [("foot", lambda p: p[0] > 6.0 - 1e-9), ("top", lambda p: p[1] > 10.0 - 1e-9)]


def cross(cells):
    """Four arms of 3 m x 1 m x 1 m around a cube of 1 m: cells in 1 m."""
    n = cells[0]

    def keep(i, j, k):
        return 3 * n <= i < 4 * n or 3 * n <= j < 4 * n

    return Lattice((7 * n, 7 * n, n),
                   lambda i, j, k: (i / n - 3.5, j / n - 3.5, k / n - 0.5), keep), []


def distorted_box(cells):
    """A box of 2 m x 1 m x 1 m; the vertices inside are shaken by a fifth of a cell, the edges straight."""
    noise = random.Random(1)

    def place(i, j, k):
        shaken = [n + noise.uniform(-0.2, 0.2) if 0 < n < count else n
                  for n, count in zip((i, j, k), cells)]
        return 2.0 * shaken[0] / cells[0], shaken[1] / cells[1], shaken[2] / cells[2]

    return Lattice(cells, place), []


def elliptic_plate(cells):
    """A quarter of NAFEMS' thick plate between the ellipses with the half axes 2 m, 1 m and 3.25 m,
    2.75 m, 0.6 m thick: cells across, around and through the thickness."""
    across, around, through = cells

    def place(i, j, k):
        s, angle = i / across, 0.5 * math.pi * j / around
        return ((2.0 + 1.25 * s) * math.cos(angle) if j < around else 0.0,
                (1.0 + 1.75 * s) * math.sin(angle), 0.6 * k / through)

    def outside(p):
        return abs(math.hypot(p[0] / 3.25, p[1] / 2.75) - 1.0) < 1e-9

    return Lattice(cells, place), [("outside", outside)]


def graded_block(cells):
    """A block of 1 m, its top at y = 0, with cells that grow away from the corner at the origin."""
    n = cells[0]

    def graded(s):
        return 0.12 * s + 0.88 * s ** 3

    return Lattice((n, n, n), lambda i, j, k: (graded(i / n), -graded(1.0 - j / n), graded(k / n))), []


def ball(cells):
    """A ball of 0.1 m about the origin: a cube of n cells, whose layers are rounded, with straight edges."""
    n = cells[0]

    def place(i, j, k):
        x, y, z = (2.0 * c / n - 1.0 for c in (i, j, k))
        layer = max(abs(x), abs(y), abs(z))
        if layer == 0.0:
            return 0.0, 0.0, 0.0
        # Equal angles along the faces; the inner layers stay nearer to a cube.
        u = [layer * math.tan(0.25 * math.pi * c / layer) for c in (x, y, z)]
        length = math.sqrt(sum(c * c for c in u))
        part = layer ** 2
        return tuple(0.1 * (part * layer * c / length + (1.0 - part) * 0.57735 * v)
                     for c, v in zip(u, (x, y, z)))

    return Lattice((n, n, n), place), []


SHAPES = {shape.__name__: shape
          for shape in (arc_beam, cook, bushing, l_block, cross, distorted_box, elliptic_plate, graded_block, ball)}


def write_mesh(path, shape, cells, element):
    lattice, groups = SHAPES[shape](cells)
    middles = lattice.add_middles(shape in ("distorted_box", "ball")) if element == "quadratic" else None
    write_msh(path, lattice.points, lattice.tetrahedra, groups, middles)
