import numpy as np
import pytest

import tetraction as tt


@pytest.fixture
def beam():
    """A soft beam of 96 tetrahedra under gravity, held at x = 0."""
    return tt.Scene(
        mesh={"generate": {"kind": "beam", "size": [1.0, 0.2, 0.2], "cells": [4, 2, 2]}},
        material=tt.Material(model="neo-hookean", youngs_modulus=1e5, poissons_ratio=0.3, density=1000),
        time=tt.Time(integrator="midpoint", step=2e-3, end=0.2),
        environment=tt.Environment(kind="gravity"),
        fix=[tt.Fix(select={"plane": {"axis": "x", "at": 0.0}})],
    )


@pytest.fixture
def cube():
    """Points and tetrahedra of a unit cube of six tetrahedra."""
    points = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)], dtype=float)
    tetrahedra = np.array(
        [[0, 4, 6, 7], [0, 6, 2, 7], [0, 2, 3, 7], [0, 3, 1, 7], [0, 1, 5, 7], [0, 5, 4, 7]])
    edges = points[tetrahedra[:, 1:]] - points[tetrahedra[:, :1]]
    assert (np.linalg.det(edges) > 0).all()
    return points, tetrahedra
