// The edges of the quadrature points of quadratic elements (quadratic_points.h), vectorised: one
// vector has the numbers of one record.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "mesh/quadratic_points.h"

namespace tetraction {

/// The records of the nodes of one quadratic element, counted from the first record of its block.
using NodeRecords = std::array<std::uint16_t, QuadraticPoints::kNodes>;

/// Sets `edges`, QuadraticPoints::kEdges records for each element, from the records of the nodes:
/// e_k = s ∂x/∂ξ_k. Values are taken relative to the first corner of each element, which keeps their
/// digits. All records have 4 numbers and begin at a multiple of their size.
void form_edges(std::span<const NodeRecords> elements, const double* nodes, double* edges);
void form_edges(std::span<const NodeRecords> elements, const float* nodes, float* edges);

/// The transpose: adds to the records of the nodes what forces on the edges amount to.
void add_edge_forces(std::span<const NodeRecords> elements, const double* edges, double* nodes);
void add_edge_forces(std::span<const NodeRecords> elements, const float* edges, float* nodes);

/// The number of numbers that quadratic_diagonal() writes for an element: (xx yy zz 0) and
/// (xy xz yz 0) of each node.
constexpr int kDiagonalNumbers = 8 * QuadraticPoints::kNodes;
/// Computes the diagonal blocks of the nodes of the kBatchLanes / 4 quadratic elements of a batch from
/// the matrices of its points (tangent_stiffness()). The block of node a is Σ_kl c_ka c_la K_kl, with
/// the coefficients c of quadratic_points.h and the blocks K of the edges of all points.
void quadratic_diagonal(const double* matrices, double* diagonal);

}  // namespace tetraction
