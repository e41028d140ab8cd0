// The beam of beam.py with deal.II, assembled as its tutorials do: dealii_beam FILE [ssor | jacobi | amg]
#include <deal.II/base/mpi.h>
#include <deal.II/base/multithread_info.h>
#include <deal.II/base/quadrature_lib.h>
#include <deal.II/dofs/dof_handler.h>
#include <deal.II/dofs/dof_renumbering.h>
#include <deal.II/dofs/dof_tools.h>
#include <deal.II/fe/fe_simplex_p.h>
#include <deal.II/fe/fe_system.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/fe/mapping_fe.h>
#include <deal.II/grid/tria.h>
#include <deal.II/lac/affine_constraints.h>
#include <deal.II/lac/dynamic_sparsity_pattern.h>
#include <deal.II/lac/full_matrix.h>
#include <deal.II/lac/precondition.h>
#include <deal.II/lac/solver_cg.h>
#include <deal.II/lac/sparse_matrix.h>
#include <deal.II/lac/trilinos_precondition.h>
#include <deal.II/lac/vector.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include "../beam.h"

namespace {

using namespace dealii;
using peers::Beam;
using DofIndex = types::global_dof_index;

constexpr unsigned kLocal = 12;  // the coordinates of a tetrahedron's vertices

class Body {
 public:
  Body(const Beam& beam, std::string solver);

  /// Makes a step; returns its iterations of Newton's method.
  int step();
  double tip() const;
  long iterations() const { return iterations_; }

 private:
  void make_mesh();
  void make_masses();
  /// residual_ ← r at u_.
  void assemble_residual();
  /// matrix_ ← the derivative of r at u_.
  void assemble_matrix();
  /// F at the one quadrature point of the cell in values_, whose coordinates' numbers are dofs_.
  Tensor<2, 3> gather();
  void solve(double forcing);
  template <class Preconditioner>
  void solve_with(const Preconditioner& preconditioner, double forcing);

  const Beam& beam_;
  std::string solver_;
  double h_, mu_, lambda_;
  Triangulation<3> mesh_;
  FESystem<3> element_{FE_SimplexP<3>(1), 3};
  MappingFE<3> mapping_{FE_SimplexP<3>(1)};
  DoFHandler<3> numbering_{mesh_};
  FEValues<3> values_{mapping_, element_, QGaussSimplex<3>(1),
                      update_gradients | update_JxW_values};
  std::array<unsigned, kLocal> component_{}, vertex_{};  // of a tetrahedron's coordinates
  std::vector<DofIndex> dofs_ = std::vector<DofIndex>(kLocal);
  std::array<Tensor<1, 3>, 4> gradient_;  // of the shape functions
  std::vector<DofIndex> tip_dofs_;        // along y
  AffineConstraints<double> wall_;
  SparsityPattern pattern_;
  SparseMatrix<double> matrix_;
  Vector<double> mass_, load_, u_, start_, velocity_, earlier_velocity_, residual_, correction_;
  int steps_ = 0;
  double first_forcing_ = 0.01;
  long iterations_ = 0;
};

Body::Body(const Beam& beam, std::string solver)
    : beam_(beam),
      solver_(std::move(solver)),
      h_(beam.step),
      mu_(beam.mu()),
      lambda_(beam.lambda()) {
  make_mesh();
  numbering_.distribute_dofs(element_);
  DoFRenumbering::Cuthill_McKee(numbering_);
  const unsigned count = numbering_.n_dofs();
  for (unsigned i = 0; i < kLocal; ++i) {
    component_[i] = element_.system_to_component_index(i).first;
    vertex_[i] = element_.system_to_component_index(i).second;
  }
  std::vector<std::array<DofIndex, 3>> dof_of(mesh_.n_vertices());
  for (const auto& cell : numbering_.active_cell_iterators()) {
    for (unsigned k = 0; k < 4; ++k) {
      for (unsigned c = 0; c < 3; ++c)
        dof_of[cell->vertex_index(k)][c] = cell->vertex_dof_index(k, c);
    }
  }
  for (const int v : beam.held) {
    for (const DofIndex dof : dof_of[v]) wall_.add_line(dof);
  }
  wall_.close();
  for (const int v : beam.tip) tip_dofs_.push_back(dof_of[v][1]);

  DynamicSparsityPattern entries(count);
  DoFTools::make_sparsity_pattern(numbering_, entries, wall_, false);
  pattern_.copy_from(entries);
  matrix_.reinit(pattern_);
  for (auto* vector :
       {&mass_, &load_, &u_, &start_, &velocity_, &earlier_velocity_, &residual_, &correction_}) {
    vector->reinit(count);
  }
  make_masses();
  for (const auto& dofs : dof_of) load_[dofs[1]] = -beam.gravity * mass_[dofs[1]];
}

void Body::make_mesh() {
  std::vector<Point<3>> points(beam_.vertices.size() / 3);
  for (std::size_t v = 0; v < points.size(); ++v) {
    for (unsigned c = 0; c < 3; ++c) points[v][c] = beam_.vertices[3 * v + c];
  }
  std::vector<CellData<3>> cells(beam_.tetrahedra.size() / 4, CellData<3>(4));
  for (std::size_t e = 0; e < cells.size(); ++e) {
    for (unsigned k = 0; k < 4; ++k) cells[e].vertices[k] = beam_.tetrahedra[4 * e + k];
  }
  mesh_.create_triangulation(points, cells, SubCellData());
}

void Body::make_masses() {
  for (const auto& cell : numbering_.active_cell_iterators()) {
    values_.reinit(cell);
    cell->get_dof_indices(dofs_);
    for (const DofIndex dof : dofs_) mass_[dof] += beam_.density * values_.JxW(0) / 4.0;
  }
}

Tensor<2, 3> Body::gather() {
  Tensor<2, 3> f = unit_symmetric_tensor<3>();
  for (unsigned i = 0; i < kLocal; ++i) {
    if (component_[i] == 0) gradient_[vertex_[i]] = values_.shape_grad(i, 0);
  }
  for (unsigned i = 0; i < kLocal; ++i) f[component_[i]] += u_[dofs_[i]] * gradient_[vertex_[i]];
  return f;
}

void Body::assemble_residual() {
  residual_ = 0.0;
  Vector<double> local(kLocal);
  for (const auto& cell : numbering_.active_cell_iterators()) {
    values_.reinit(cell);
    cell->get_dof_indices(dofs_);
    const Tensor<2, 3> f = gather();
    const Tensor<2, 3> inverse = transpose(invert(f));
    const Tensor<2, 3> stress = mu_ * f + (lambda_ * std::log(determinant(f)) - mu_) * inverse;
    for (unsigned i = 0; i < kLocal; ++i) {
      local[i] = values_.JxW(0) * (stress[component_[i]] * gradient_[vertex_[i]]);
    }
    wall_.distribute_local_to_global(local, dofs_, residual_);
  }
  for (DofIndex i = 0; i < residual_.size(); ++i) {
    residual_[i] += mass_[i] / (h_ * h_) * (u_[i] - start_[i] - h_ * velocity_[i]) - load_[i];
  }
  wall_.set_zero(residual_);
}

void Body::assemble_matrix() {
  matrix_ = 0.0;
  FullMatrix<double> local(kLocal, kLocal);
  for (const auto& cell : numbering_.active_cell_iterators()) {
    values_.reinit(cell);
    cell->get_dof_indices(dofs_);
    const Tensor<2, 3> f = gather();
    const Tensor<2, 3> inverse = transpose(invert(f));
    const double volume = values_.JxW(0);
    const double crossed = volume * (mu_ - lambda_ * std::log(determinant(f)));
    std::array<Tensor<1, 3>, 4> w;  // F⁻ᵀ times the gradients
    std::array<std::array<double, 4>, 4> products;
    for (unsigned a = 0; a < 4; ++a) w[a] = inverse * gradient_[a];
    for (unsigned a = 0; a < 4; ++a) {
      for (unsigned b = 0; b < 4; ++b)
        products[a][b] = volume * mu_ * (gradient_[a] * gradient_[b]);
    }
    for (unsigned i = 0; i < kLocal; ++i) {
      for (unsigned j = 0; j < kLocal; ++j) {
        const unsigned a = vertex_[i], b = vertex_[j], p = component_[i], q = component_[j];
        local(i, j) = (p == q ? products[a][b] : 0.0) + crossed * w[b][p] * w[a][q] +
                      volume * lambda_ * w[a][p] * w[b][q];
      }
    }
    wall_.distribute_local_to_global(local, dofs_, matrix_);
  }
  for (DofIndex i = 0; i < mass_.size(); ++i) matrix_.diag_element(i) += mass_[i] / (h_ * h_);
}

template <class Preconditioner>
void Body::solve_with(const Preconditioner& preconditioner, double forcing) {
  SolverControl control(100000, forcing * residual_.l2_norm());
  SolverCG<Vector<double>> gradients(control);
  correction_ = 0.0;
  gradients.solve(matrix_, correction_, residual_, preconditioner);
  iterations_ += control.last_step();
}

// correction_ ← matrix_⁻¹ residual_, to a relative residual.
void Body::solve(double forcing) {
  if (solver_ == "ssor") {
    PreconditionSSOR<SparseMatrix<double>> ssor;
    ssor.initialize(matrix_, 1.2);
    solve_with(ssor, forcing);
  } else if (solver_ == "jacobi") {
    PreconditionJacobi<SparseMatrix<double>> jacobi;
    jacobi.initialize(matrix_);
    solve_with(jacobi, forcing);
  } else if (solver_ == "amg") {
    TrilinosWrappers::PreconditionAMG::AdditionalData options;
    DoFTools::extract_constant_modes(numbering_, ComponentMask(3, true), options.constant_modes);
    options.elliptic = true;
    options.aggregation_threshold = 0.02;
    TrilinosWrappers::PreconditionAMG amg;
    amg.initialize(matrix_, options);
    solve_with(amg, forcing);
  } else {
    throw std::runtime_error("There is no solver " + solver_ + ": take ssor, jacobi or amg.");
  }
}

int Body::step() {
  constexpr int kMost = 50;
  start_ = u_;
  Vector<double> force(load_);
  for (DofIndex i = 0; i < force.size(); ++i) force[i] += mass_[i] * velocity_[i] / h_;
  wall_.set_zero(force);
  const double limit = beam_.tolerance * force.l2_norm();

  if (steps_ > 0) {
    u_.add(2.0 * h_, velocity_);
    u_.add(-h_, earlier_velocity_);
  }
  assemble_residual();
  double norm = residual_.l2_norm();
  double forcing = first_forcing_;
  int newton = 0;
  while (norm > limit) {
    if (newton == kMost || !std::isfinite(norm))
      throw std::runtime_error("Newton's method failed.");
    assemble_matrix();
    solve(std::max(std::min(forcing, 0.1), 0.3 * limit / norm));
    u_ -= correction_;
    assemble_residual();
    const double reduction = residual_.l2_norm() / norm;
    norm *= reduction;
    forcing = 0.5 * reduction * reduction;
    if (++newton == 1) first_forcing_ = std::clamp(0.5 * reduction, 1e-4, 0.1);
  }
  earlier_velocity_ = velocity_;
  for (DofIndex i = 0; i < u_.size(); ++i) velocity_[i] = (u_[i] - start_[i]) / h_;
  ++steps_;
  return newton;
}

double Body::tip() const {
  double sum = 0.0;
  for (const DofIndex dof : tip_dofs_) sum += u_[dof];
  return sum / static_cast<double>(tip_dofs_.size());
}

void run(const std::string& path, const std::string& solver) {
  const long before = peers::peak_bytes();
  const Beam beam = peers::read_beam(path);
  Body body(beam, solver);
  peers::Report report;
  report.program = "deal.II";
  report.version = DEAL_II_PACKAGE_VERSION;
  report.solver = solver;
  for (int k = 0; k < beam.steps; ++k) {
    const double start = peers::now();
    report.newton += body.step();
    report.seconds.push_back(peers::now() - start);
  }
  report.iterations = body.iterations();
  report.tip = body.tip();
  report.bytes = peers::peak_bytes() - before;
  peers::print(report);
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2 && count != 3) {
    std::fprintf(stderr, "Usage: dealii_beam FILE [ssor | jacobi | amg]\n");
    return 2;
  }
  try {
    const Utilities::MPI::MPI_InitFinalize mpi(count, arguments, 1);  // Trilinos needs it
    MultithreadInfo::set_thread_limit(1);
    run(arguments[1], count == 3 ? arguments[2] : "ssor");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
