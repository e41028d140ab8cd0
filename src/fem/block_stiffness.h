// Assembly of the stiffness matrices of a block's elements into a sparse matrix.
#pragma once

#include <functional>

#include "element_blocks.h"
#include "kernels/tangent_kernels.h"
#include "tetraction/fem/sparsity_pattern.h"

namespace tetraction {

/// values += the stiffness matrices of the block's elements, in the pattern's order. They are
/// computed from a state of the tangent kernels. For elements without
/// SparsityPattern::element_entries() it calls other(element) instead.
void add_block_stiffness(const ElementBlocks& blocks, const ElementBlocks::Block& block,
                         TangentForm form, const double* state, const SparsityPattern& pattern,
                         double* values, const std::function<void(Index)>& other);

}  // namespace tetraction
