// Materials and force terms that are written in Python.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <string>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/terms/force_term.h"
#include "tetraction/material/custom_material.h"

namespace tetraction::python {

/// A material of three Python functions, which are attributes of `functions`, of deformation gradients F,
/// an array of the shape (n, 3, 3):
/// energy(F) → Ψ (n), J/m³; stress(F) → P = ∂Ψ/∂F (n, 3, 3), Pa; stiffness(F) → ∂P/∂F (n, 3, 3, 3, 3)
/// with [i, J, k, L] = ∂P_iJ/∂F_kL, Pa. `admissible`, which may be None, says where Ψ is defined (n);
/// by default that is where det F > 0. The element loops call each function once for a block of elements.
/// With places all functions get two further arrays: the numbers of the elements (n) and the rest positions
/// (n, 3), m. `functions` must live as long as the material is used; the material does not keep it.
/// Throws InputError unless the functions give arrays of these shapes and are derivatives of each other
/// (by differences at some F, to 1e-5). With places check_placed_material() does this.
CustomMaterial make_material(const std::string& name, double mu, double lambda,
                             const pybind11::object& functions, bool with_places);

/// Throws InputError unless the functions of a material with places are derivatives of each other at the
/// centres of some elements of this region, and give the same for many F at once as for each of them alone.
/// Does nothing for other materials.
void check_placed_material(const CustomMaterial& material, const MechanicalSystem& system,
                           Index region);
/// The same for all regions of a body.
void check_placed_materials(const MechanicalSystem& system);

/// A potential of single vertices made of three Python functions of masses m (n), kg, and positions q
/// (n, 3), m: energy(m, q) → U (n), J; gradient(m, q) → ∂U/∂q (n, 3), N; hessian(m, q) → ∂²U/∂q² (n, 3, 3),
/// N/m. `defined`, which may be None, says where U is defined: of q, a truth value for each vertex (n).
/// `admissible_fraction`, which may be None, is a function of q and d (n, 3): the largest t of each vertex (n) for
/// which U is defined from q to q + t d. All are attributes of `functions`, which must live as long as the field
/// is used. Throws InputError unless the name is one of lower-case letters, digits and underscores.
std::shared_ptr<const ForceTerm> make_force_field(const std::string& name,
                                                  const pybind11::object& functions);

}  // namespace tetraction::python
