#!/usr/bin/env python3
"""Writes the structured meshes of data/: thick_sphere.msh, bushing.msh, tuning_fork.msh, l_block.msh
and ball.msh (Gmsh 2.2, ASCII).

All but the ball are made of prisms or bricks that are cut into tetrahedra. Every prism is cut along the
diagonals that start at its vertices with the smallest numbers, so that neighbours fit together.
"""
import itertools
import math
import os

HERE = os.path.dirname(os.path.abspath(__file__))


def cut_prism(prism):
    """The three tetrahedra of a prism (a, b, c below d, e, f)."""
    # The prism is turned until its smallest number comes first (Dompierre et al. 1999).
    first = prism.index(min(prism))
    a, b, c, d, e, f = prism
    turns = [
        (a, b, c, d, e, f), (b, c, a, e, f, d), (c, a, b, f, d, e),
        (d, f, e, a, c, b), (e, d, f, b, a, c), (f, e, d, c, b, a)]
    a, b, c, d, e, f = turns[first]
    if min(b, f) < min(c, e):
        return [(a, b, c, f), (a, b, f, e), (a, e, f, d)]
    return [(a, b, c, e), (a, e, c, f), (a, e, f, d)]


def faces_of(tetrahedra):
    """The boundary triangles, as sorted tuples."""
    count = {}
    for t in tetrahedra:
        for i in range(4):
            face = tuple(sorted(t[:i] + t[i + 1:]))
            count[face] = count.get(face, 0) + 1
    return [face for face, times in count.items() if times == 1]


def write_msh(path, points, tetrahedra, groups, middles=None):
    """`groups`: (name, test of a point), for the triangles of the boundary with three such points.

    `middles`: the vertex in the middle of each edge (a, b) with a < b, for quadratic tetrahedra.
    """
    def nodes(cell, edges):
        if middles:
            cell = cell + tuple(middles[min(cell[i], cell[j]), max(cell[i], cell[j])]
                                for i, j in edges)
        return ' '.join(str(v + 1) for v in cell)

    triangle, tetrahedron = (9, 11) if middles else (2, 4)  # Gmsh's types
    lines = ['$MeshFormat', '2.2 0 8', '$EndMeshFormat', '$PhysicalNames', str(len(groups) + 1)]
    for tag, (group, _) in enumerate(groups, 1):
        lines.append('2 %d "%s"' % (tag, group))
    lines += ['3 %d "body"' % (len(groups) + 1), '$EndPhysicalNames', '$Nodes', str(len(points))]
    for number, point in enumerate(points, 1):
        lines.append('%d %.17g %.17g %.17g' % ((number,) + tuple(point)))
    lines += ['$EndNodes', '$Elements']
    elements = []
    for face in faces_of(tetrahedra) if groups else []:
        for tag, (_, test) in enumerate(groups, 1):
            if all(test(points[v]) for v in face):
                elements.append('%d 2 %d %d ' % (triangle, tag, tag)
                                + nodes(face, ((0, 1), (1, 2), (2, 0))))
    for t in tetrahedra:
        elements.append('%d 2 %d 1 ' % (tetrahedron, len(groups) + 1)
                        + nodes(t, ((0, 1), (1, 2), (2, 0), (0, 3), (2, 3), (1, 3))))
    lines.append(str(len(elements)))
    lines += ['%d %s' % (i, e) for i, e in enumerate(elements, 1)]
    lines.append('$EndElements')
    with open(path, 'w') as file:
        file.write('\n'.join(lines) + '\n')


def write_shipped(name, points, tetrahedra, groups):
    write_msh(os.path.join(HERE, name), points, tetrahedra, groups)
    print('%s: %d vertices, %d tetrahedra' % (name, len(points), len(tetrahedra)))


def thick_sphere(inner, outer, edge, layers):
    """An eighth of a hollow sphere; `edge` triangles along each of its sides."""
    number = {}
    directions = []
    for i in range(edge + 1):
        for j in range(edge + 1 - i):
            k = edge - i - j
            # Great circles through the corners are divided into equal angles.
            x, y, z = (math.tan(0.5 * math.pi * 0.5 * n / edge) for n in (i, j, k))
            length = math.sqrt(x * x + y * y + z * z)
            number[i, j] = len(directions)
            directions.append((x / length, y / length, z / length))
    radii = [inner * (outer / inner) ** (n / layers) for n in range(layers + 1)]
    points = [tuple(r * c for c in d) for r in radii for d in directions]
    size = len(directions)
    triangles = []
    for i in range(edge):
        for j in range(edge - i):
            triangles.append((number[i, j], number[i + 1, j], number[i, j + 1]))
            if i + j + 1 < edge:
                triangles.append((number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]))
    tetrahedra = []
    for layer in range(layers):
        for triangle in triangles:
            low = [v + layer * size for v in triangle]
            tetrahedra += cut_prism(tuple(low + [v + size for v in low]))

    def on_sphere(radius):
        return lambda p: abs(math.sqrt(sum(c * c for c in p)) - radius) < 1e-9 * radius

    write_shipped('thick_sphere.msh', points, tetrahedra,
                  [('inner', on_sphere(inner)), ('outer', on_sphere(outer)),
                   ('x0', lambda p: abs(p[0]) < 1e-9), ('y0', lambda p: abs(p[1]) < 1e-9),
                   ('z0', lambda p: abs(p[2]) < 1e-9)])


def bushing(inner, outer, length, around, across, along):
    """A tube about the z axis, glued to a pin inside and to a sleeve outside."""
    points = []
    for k in range(along + 1):
        for i in range(across + 1):
            radius = inner + (outer - inner) * i / across
            for j in range(around):
                angle = 2.0 * math.pi * j / around
                points.append((radius * math.cos(angle), radius * math.sin(angle), length * k / along))

    def at(i, j, k):
        return (k * (across + 1) + i) * around + j % around

    tetrahedra = []
    for k in range(along):
        for i in range(across):
            for j in range(around):
                corners = [at(i, j, k), at(i + 1, j, k), at(i + 1, j + 1, k), at(i, j + 1, k)]
                up = [v + (across + 1) * around for v in corners]
                tetrahedra += cut_prism((corners[0], corners[1], corners[2], up[0], up[1], up[2]))
                tetrahedra += cut_prism((corners[0], corners[2], corners[3], up[0], up[2], up[3]))

    def on_cylinder(radius):
        return lambda p: abs(math.hypot(p[0], p[1]) - radius) < 1e-9 * radius

    write_shipped('bushing.msh', points, tetrahedra,
                  [('inner', on_cylinder(inner)), ('outer', on_cylinder(outer))])


def tuning_fork(cells, name='tuning_fork.msh'):
    """A tuning fork in mm, `cells` bricks across the thickness of a prong.

    Two prongs of 4 mm x 4 mm and a length of 87 mm point along y and swing along x. They stand on a
    yoke of 14 mm x 8 mm x 4 mm, and this on a stem of 6 mm x 24 mm x 4 mm.
    """
    def ticks(*intervals):
        values = [intervals[0][0]]
        for begin, end, count in intervals:
            values += [begin + (end - begin) * i / count for i in range(1, count + 1)]
        return values

    half = math.ceil(0.75 * cells)  # between the middle and a prong
    x = ticks((-7.0, -3.0, cells), (-3.0, 3.0, 2 * half), (3.0, 7.0, cells))
    # The bricks of the prongs are twice as long as wide.
    y = ticks((-32.0, -8.0, 3 * cells), (-8.0, 0.0, 2 * cells), (0.0, 87.0, 11 * cells))
    z = ticks((0.0, 4.0, cells))
    number = {}
    points = []
    tetrahedra = []

    def at(i, j, k):
        if (i, j, k) not in number:
            number[i, j, k] = len(points)
            points.append((x[i], y[j], z[k]))
        return number[i, j, k]

    def is_solid(i, j):
        if j >= 5 * cells:  # prongs
            return not -3.0 < 0.5 * (x[i] + x[i + 1]) < 3.0
        return j >= 3 * cells or abs(x[i] + x[i + 1]) < 6.0

    for k in range(cells):
        for j in range(len(y) - 1):
            for i in range(len(x) - 1):
                if not is_solid(i, j):
                    continue
                a, b, c, d = (at(i + p, j + q, k) for p, q in ((0, 0), (1, 0), (1, 1), (0, 1)))
                e, f, g, h = (at(i + p, j + q, k + 1) for p, q in ((0, 0), (1, 0), (1, 1), (0, 1)))
                tetrahedra += cut_prism((a, b, c, e, f, g))
                tetrahedra += cut_prism((a, c, d, e, g, h))
    write_shipped(name, points, tetrahedra,
                  [('stem', lambda p: p[1] == y[0]),
                   ('left', lambda p: p[1] == y[-1] and p[0] < 0.0),
                   ('right', lambda p: p[1] == y[-1] and p[0] > 0.0)])


def l_block(cells):
    """The L-shaped block of Simo and Tarnow (1992), 6 m x 10 m x 3 m, with `cells` bricks per metre."""
    number = {}
    points = []
    tetrahedra = []

    def at(i, j, k):
        if (i, j, k) not in number:
            number[i, j, k] = len(points)
            points.append((i / cells, j / cells, k / cells))
        return number[i, j, k]

    for k in range(3 * cells):
        for j in range(10 * cells):
            for i in range((6 if j < 3 * cells else 3) * cells):
                a, b, c, d = (at(i + p, j + q, k) for p, q in ((0, 0), (1, 0), (1, 1), (0, 1)))
                e, f, g, h = (at(i + p, j + q, k + 1) for p, q in ((0, 0), (1, 0), (1, 1), (0, 1)))
                tetrahedra += cut_prism((a, b, c, e, f, g))
                tetrahedra += cut_prism((a, c, d, e, g, h))
    write_shipped('l_block.msh', points, tetrahedra,
                  [('foot', lambda p: p[0] == 6.0), ('top', lambda p: p[1] == 10.0)])


def ball(radius, edge):
    """A ball about the origin: an octahedron, whose eight octants are divided and rounded.

    An octant x + y + z <= edge is cut as Freudenthal's triangulation cuts u >= v >= w >= 0 with u = x + y + z,
    v = y + z and w = z. All faces of octants are divided in the same way, so that octants fit together.
    """
    number = {}
    points = []
    tetrahedra = []

    def at(signs, x, y, z):
        place = tuple(s * c for s, c in zip(signs, (x, y, z)))
        if place not in number:
            number[place] = len(points)
            whole = x + y + z
            # As in thick_sphere(), great circles are divided into equal angles.
            d = [s * math.tan(0.25 * math.pi * c / whole) if whole else 0.0 for s, c in zip(signs, (x, y, z))]
            length = math.sqrt(sum(c * c for c in d)) or 1.0
            points.append(tuple(radius * whole / edge * c / length for c in d))
        return number[place]

    for signs in itertools.product((1, -1), repeat=3):
        for corner in itertools.product(range(edge), repeat=3):
            for order in itertools.permutations(range(3)):
                path = [list(corner)]
                for axis in order:
                    path.append(list(path[-1]))
                    path[-1][axis] += 1
                if any(not u >= v >= w for u, v, w in path):
                    continue
                cell = tuple(at(signs, u - v, v - w, w) for u, v, w in path)
                a, b, c, d = (points[v] for v in cell)
                e, f, g = ([q - p for p, q in zip(a, other)] for other in (b, c, d))
                volume = (e[0] * (f[1] * g[2] - f[2] * g[1]) + e[1] * (f[2] * g[0] - f[0] * g[2])
                          + e[2] * (f[0] * g[1] - f[1] * g[0]))
                tetrahedra.append(cell if volume > 0.0 else (cell[0], cell[2], cell[1], cell[3]))
    write_shipped('ball.msh', points, tetrahedra, [])


if __name__ == '__main__':
    thick_sphere(inner=1.0, outer=2.0, edge=16, layers=12)
    bushing(inner=0.010, outer=0.022, length=0.030, around=36, across=4, along=6)
    tuning_fork(cells=2)
    l_block(cells=1)
    ball(radius=0.1, edge=6)
