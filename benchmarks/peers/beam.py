"""The beam that all programs of this folder compute, and the file that tells them of it.

A beam of 4 × 1 × 1 m hangs in a wall at x = 0 and falls from rest under gravity. It is neo-Hookean,

    Ψ = μ/2 (I₁ − 3 − 2 ln J) + λ/2 (ln J)²,

with linear tetrahedra and lumped masses (a quarter of a tetrahedron's mass at each of its vertices).

A step of backward Euler has the residual r(u) = M (u − u_k − h v_k)/h² + ∇W(u) − f over the free coordinates. Every
program makes the step in the same way, so that only the cost of its parts is compared:

- Newton's method with the exact derivative ends at |r| ≤ tolerance · |M v_k/h + f|.
- It solves its linear systems by conjugate gradients to the relative residual ζ = ½ (|r_i|/|r_{i−1}|)², at most 0.1,
  and no closer than the end of the step needs, 0.3 of its limit. The first ζ of a step is half the first reduction in
  the step before, between 1e-4 and 0.1, and 0.01 in the first step (Eisenstat & Walker 1996).
- The programs of the peers begin at u_k + h (2 v_k − v_{k−1}). Ours chooses among several guesses, of which that is
  one. Only ours searches along a line and looks for saddles; the others take whole Newton steps.
"""

CELLS = {"S": (20, 4, 4), "M": (40, 9, 9), "L": (76, 18, 18), "XL": (152, 36, 36)}
LENGTHS = (4.0, 1.0, 1.0)  # m
NUMBERS = {
    "youngs_modulus": 1e6,  # Pa
    "poissons_ratio": 0.4,
    "density": 1000.0,  # kg/m³
    "gravity": 9.81,  # m/s², along −y
    "step": 0.01,  # s
    "tolerance": 1e-8,
}

# The ways along the axes from the corner (0, 0, 0) of a cell to (1, 1, 1). Each is a tetrahedron; the volumes of
# the last three are negative unless two vertices are exchanged.
WAYS = [(0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (1, 0, 2), (2, 1, 0)]


def tetrahedron_count(cells):
    return len(WAYS) * cells[0] * cells[1] * cells[2]


def vertices(cells):
    """The vertices, numbered along x first, then y, then z."""
    for k in range(cells[2] + 1):
        for j in range(cells[1] + 1):
            for i in range(cells[0] + 1):
                yield tuple(length * (n / all_) for length, n, all_ in zip(LENGTHS, (i, j, k), cells))


def tetrahedra(cells):
    """Six in each cell, around its diagonal from (0, 0, 0) to (1, 1, 1)."""
    strides = (1, cells[0] + 1, (cells[0] + 1) * (cells[1] + 1))
    ways = []
    for number, (a, b, _) in enumerate(WAYS):
        corners = [0, strides[a], strides[a] + strides[b], sum(strides)]
        if number >= 3:
            corners[2], corners[3] = corners[3], corners[2]
        ways.append(corners)
    for k in range(cells[2]):
        for j in range(cells[1]):
            for i in range(cells[0]):
                first = i + strides[1] * j + strides[2] * k
                for corners in ways:
                    yield tuple(first + corner for corner in corners)


def write(path, cells, steps):
    """Writes the problem: names with a number, then names of tables with their length and rows."""
    points = list(vertices(cells))
    tables = [
        ("vertices", points),
        ("tetrahedra", list(tetrahedra(cells))),
        ("held", [(v,) for v, point in enumerate(points) if point[0] == 0.0]),
        ("tip", [(v,) for v, point in enumerate(points) if point[0] == LENGTHS[0]]),
    ]
    with open(path, "w", encoding="ascii") as file:
        for name, value in {**NUMBERS, "steps": steps}.items():
            file.write(f"{name} {value!r}\n")
        for name, rows in tables:
            file.write(f"{name} {len(rows)}\n")
            file.writelines(" ".join(map(repr, row)) + "\n" for row in rows)
