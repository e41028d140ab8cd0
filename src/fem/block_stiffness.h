// Assembly of the stiffness matrices of a block's elements into a sparse matrix.
#pragma once

#include "element_blocks.h"
#include "element_sums.h"
#include "kernels/tangent_kernels.h"
#include "tetraction/fem/sparsity_pattern.h"

namespace tetraction {

/// values += the stiffness matrices of the block's elements, in the pattern's order. They are
/// computed from a state of the tangent kernels.
void add_block_stiffness(const ElementBlocks& blocks, const ElementBlocks::Block& block,
                         TangentForm form, const double* state, const SparsityPattern& pattern,
                         double* values);

/// The matrix of one lane from those that tangent_stiffness() has written.
LinearTetrahedron::DofMatrix lane_matrix(const double* matrices, int lane);

/// The stiffness matrix of a quadratic element, the first of whose four points is in this lane.
ElementMatrix quadratic_stiffness(const double* matrices, int lane);

}  // namespace tetraction
