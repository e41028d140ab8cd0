"""The laws of materials by themselves.

Each function takes deformation gradients F of the shape (3, 3) or (n, 3, 3), and the keys of [material] as
keyword arguments::

    tt.material.stress(F, model="neo-hookean", youngs_modulus=1e6, poissons_ratio=0.3)
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, _scene


def energy_density(F: ArrayLike, **keys: Any) -> float | NDArray[np.float64]:
    """Ψ(F), J/m³: a number, or an array (n,)."""
    return _evaluate(F, keys)[0]


def stress(F: ArrayLike, **keys: Any) -> NDArray[np.float64]:
    """P = ∂Ψ/∂F, the first Piola-Kirchhoff stress, Pa: (3, 3) or (n, 3, 3)."""
    return _evaluate(F, keys)[1]


def cauchy_stress(F: ArrayLike, **keys: Any) -> NDArray[np.float64]:
    """σ = P Fᵀ/det F, Pa: (3, 3) or (n, 3, 3)."""
    F = np.asarray(F, dtype=float)
    return stress(F, **keys) @ np.swapaxes(F, -1, -2) / np.linalg.det(F)[..., None, None]


def stiffness(F: ArrayLike, **keys: Any) -> NDArray[np.float64]:
    """∂P/∂F, Pa, with the indices [i, J, k, L] = ∂P_iJ/∂F_kL: (3, 3, 3, 3) or (n, 3, 3, 3, 3)."""
    return _evaluate(F, keys)[2]


def _evaluate(F: Any, keys: dict[str, Any]) -> Any:
    F = np.asarray(F, dtype=float)
    if F.ndim not in (2, 3) or F.shape[-2:] != (3, 3):
        raise _core.InputError(f"F must have the shape (3, 3) or (n, 3, 3), not {F.shape}.")
    scene = _scene.Scene(material=keys)._compiled(has_mesh=True)
    results = _core.evaluate_material(scene, F.reshape(-1, 3, 3))
    if F.ndim == 2:
        return tuple(float(result[0]) if result.ndim == 1 else result[0] for result in results)
    return results
