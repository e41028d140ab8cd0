// The kernels of the element loop for isotropic materials: many tetrahedra at a time, one in each
// lane of a vector register, compiled for several instruction sets and chosen at run time.
//
// They work on edges. The current edges are e = [q1−q0, q2−q0, q3−q0], the rest edges are D, and
// G = (DᵀD)⁻¹. The tensors of an isotropic material, pulled back to the edges, need only G and
// det D = 6V of the rest state:
//
//     c = eᵀe,  I₁ = c:G,  J = det e/det D,  F F⁻ᵀ-terms: F D⁻ᵀ = e G,  F⁻ᵀ D⁻ᵀ = e⁻ᵀ
//
// With Ψ₁, Ψ₂, Ψ_L the derivatives of Ψ with respect to I₁, I₂ and ln J (material/laws),
//
//     ∂W/∂e = V [2 Ψ₁ e G + 2 Ψ₂ (I₁ e G − e G c G) + Ψ_L e⁻ᵀ]
//
// and for laws that are defined for any J, with a = c − DᵀD,
//
//     ∂W/∂e = 2 V e [(Ψ₁ + (I₁ − 1) Ψ₂) G − Ψ₂ G a G]
//
// Column k of ∂W/∂e is the gradient at node k + 1; the four nodes' gradients add up to zero.
#pragma once

#include <cstddef>
#include <cstdint>

#include "tetraction/material/material.h"

namespace tetraction {

/// The number of elements in a batch. It is the same for every instruction set.
constexpr int kBatchLanes = 16;

/// Rest data and nodes of the elements of a block, batch by batch.
struct BatchView {
  /// Six entries of V G (00 01 02 11 12 22) and 1/(6V): 7 × kBatchLanes numbers a batch.
  const double* rest = nullptr;
  /// Slots of the nodes, 4 × kBatchLanes a batch: where the node's record begins in the block's
  /// records.
  const std::uint16_t* slots = nullptr;
  std::ptrdiff_t count = 0;
};
constexpr int kRestNumbers = 7;

/// The result of a kernel for one block.
struct BlockSums {
  double energy = 0.0;     ///< J
  bool admissible = true;  ///< J > 0 in every element, all numbers finite
};

/// Computes the energy and adds ∂W/∂q of the elements to `gradients`. Records have four numbers
/// (x y z 0) and are aligned to 32 bytes. The nodes are at positions + changes, or at positions if
/// `changes` is null. The edges of the two are formed separately (tetraction/fem/positions.h).
BlockSums elastic_gradient(const BatchView& batches, const IsotropicModel& material,
                           const double* positions, const double* changes, double* gradients);
/// Computes the energy alone.
BlockSums elastic_energy(const BatchView& batches, const IsotropicModel& material,
                         const double* positions, const double* changes);

/// Name of the instruction set in use, e.g. "AVX3" (AVX-512), "AVX2", "SCALAR" (portable).
const char* instruction_set();

}  // namespace tetraction
