// The matrices of a block's elements into a sparse matrix.
#pragma once

#include <functional>

#include "element_blocks.h"
#include "kernels/tangent_kernels.h"
#include "tetraction/fem/sparsity_pattern.h"

namespace tetraction {

/// values += the elements' matrices, in the pattern's order, from a state of the tangent kernels.
/// Elements for which the pattern has no simple place are left to `other`.
void add_block_stiffness(const ElementBlocks& blocks, const ElementBlocks::Block& block,
                         TangentForm form, const double* state, const SparsityPattern& pattern,
                         double* values, const std::function<void(Index)>& other);

}  // namespace tetraction
