// Volumes of tetrahedra and their gradients, several elements at a time (element_kernels.h). With the
// current edges e, 6v = det e, and ∂(6v)/∂e is the cofactor matrix of e.
#pragma once

#include "element_kernels.h"

namespace tetraction {

/// six_volumes ← 6v of all elements, kBatchLanes numbers per batch. Positions and displacements are
/// those of elastic_gradient().
void element_volumes(const BatchView& batches, const double* positions, const double* displacements,
                     double* six_volumes);

/// gradients ← ∂(6v)/∂x of the nodes of all elements: a record (x y z 0) for each of the four nodes.
/// Those of lane l of batch b are the records of element l × batches + b, in the order in which neighbours
/// follow one another (fem/element_blocks.h).
void element_volume_gradients(const BatchView& batches, const double* positions,
                              const double* displacements, float* gradients);
void element_volume_gradients(const BatchView& batches, const double* positions,
                              const double* displacements, double* gradients);

/// forces += t ∂v/∂q of all elements, with their tensions t (BatchView::tensions).
void add_volume_gradient(const BatchView& batches, const double* positions,
                         const double* displacements, double* forces);

}  // namespace tetraction
