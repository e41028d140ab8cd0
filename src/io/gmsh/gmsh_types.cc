#include "gmsh_types.h"

#include <map>

namespace tetraction {

const GmshType* find_gmsh_type(std::int64_t number) {
  static const std::map<std::int64_t, GmshType> types{
      {1, {CellType::kLine, 2, 1}},
      {2, {CellType::kTriangle, 3, 2}},
      {3, {CellType::kQuadrilateral, 4, 2}},
      {4, {CellType::kTetrahedron, 4, 3}},
      {5, {CellType::kHexahedron, 8, 3}},
      {6, {CellType::kWedge, 6, 3}},
      {7, {CellType::kPyramid, 5, 3}},
      {8, {CellType::kLine, 3, 1}},
      {9, {CellType::kTriangle, 6, 2}},
      {10, {CellType::kQuadrilateral, 9, 2}},
      {11, {CellType::kQuadraticTetrahedron, 10, 3}},
      {12, {CellType::kHexahedron, 27, 3}},
      {13, {CellType::kWedge, 18, 3}},
      {14, {CellType::kPyramid, 14, 3}},
      {15, {CellType::kVertex, 1, 0}},
      {16, {CellType::kQuadrilateral, 8, 2}},
      {17, {CellType::kHexahedron, 20, 3}},
      {18, {CellType::kWedge, 15, 3}},
      {19, {CellType::kPyramid, 13, 3}},
      {20, {CellType::kTriangle, 9, 2}},
      {21, {CellType::kTriangle, 10, 2}},
      {22, {CellType::kTriangle, 12, 2}},
      {23, {CellType::kTriangle, 15, 2}},
      {26, {CellType::kLine, 4, 1}},
      {27, {CellType::kLine, 5, 1}},
      {28, {CellType::kLine, 6, 1}},
      {29, {CellType::kQuadraticTetrahedron, 20, 3}},
      {30, {CellType::kQuadraticTetrahedron, 35, 3}},
      {31, {CellType::kQuadraticTetrahedron, 56, 3}}};
  const auto found = types.find(number);
  return found != types.end() ? &found->second : nullptr;
}

}  // namespace tetraction
