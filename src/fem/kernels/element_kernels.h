// Energy and gradient of isotropic materials. The kernels process several tetrahedra at a time, one
// in each lane of a vector register. They are compiled for several instruction sets, and the
// program chooses one at run time.
//
// The kernels work on the edges of the elements. The current edges are e = [q1−q0, q2−q0, q3−q0],
// the rest edges are D_m = [X1−X0, X2−X0, X3−X0], and V is the rest volume. For isotropic materials
// only G = (D_mᵀ D_m)⁻¹ and det D_m = 6V of the rest state are needed, because F = e D_m⁻¹ gives
//
//     c = eᵀe,   I₁ = c:G,   J = det e/det D_m,   F D_m⁻ᵀ = e G,   F⁻ᵀ D_m⁻ᵀ = e⁻ᵀ
//
// With the derivatives Ψ₁, Ψ₂, Ψ_L of Ψ with respect to I₁, I₂ and ln J (material/laws),
//
//     ∂W/∂e = V [2 Ψ₁ e G + 2 Ψ₂ (I₁ e G − e G c G) + Ψ_L e⁻ᵀ]
//
// and for laws that are defined for any J, with a = c − D_mᵀ D_m,
//
//     ∂W/∂e = 2 V e [(Ψ₁ + (I₁ − 1) Ψ₂) G − Ψ₂ G a G]
//
// Column k of ∂W/∂e is the gradient at node k + 1. The gradients of the four nodes add up to zero.
//
// Names of products in the code follow the formulas: vg = V G, evg = e V G, ag = a G.
#pragma once

#include <cstddef>
#include <cstdint>

#include "tetraction/material/material.h"

namespace tetraction {

/// The number of elements in a batch. It is the same for every instruction set.
constexpr int kBatchLanes = 16;

/// Rest data and nodes of the elements of a block, batch by batch.
struct BatchView {
  /// Six entries of V G (00 01 02 11 12 22) and 1/(6V) of every element: kRestNumbers × kBatchLanes
  /// numbers per batch.
  const double* rest = nullptr;
  /// Slots of the nodes, 4 × kBatchLanes per batch. A slot is the index of the first number of the
  /// node's record among the numbers of the block's records.
  const std::uint16_t* slots = nullptr;
  std::ptrdiff_t count = 0;  ///< number of batches
  /// The parameters of the material in every element, in the order of its kParameters: as many
  /// times kBatchLanes numbers per batch. Null if all elements have those of the material.
  const double* parameters = nullptr;
  /// A tension t of every element, kBatchLanes numbers per batch, or null: gradients and tangents
  /// (tangent_kernels.h) then are those of W + t v at constant t with the present volume v of the
  /// element, Pa. Not for materials that are defined for any J. Energies are those of W.
  const double* tensions = nullptr;
};
/// The number of rest data per element.
constexpr int kRestNumbers = 7;

/// The result of a kernel for one block.
struct BlockSums {
  double energy = 0.0;     ///< J
  bool admissible = true;  ///< whether the energy is defined in every element
};

/// Computes the energy and adds ∂W/∂q of the elements to `gradients`. Records have four numbers
/// (x y z 0) and are aligned to 32 bytes. The nodes are at positions + displacements, or at positions if
/// `displacements` is null. The edges of both are formed separately (tetraction/fem/positions.h).
BlockSums elastic_gradient(const BatchView& batches, const IsotropicModel& material,
                           const double* positions, const double* displacements, double* gradients);
/// Computes the energy alone.
BlockSums elastic_energy(const BatchView& batches, const IsotropicModel& material,
                         const double* positions, const double* displacements);

/// Name of the instruction set in use, e.g. "AVX3" (AVX-512), "AVX2", "SCALAR" (portable).
const char* instruction_set();

}  // namespace tetraction
