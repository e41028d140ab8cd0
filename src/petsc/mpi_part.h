// The part of a mesh that one process of an MPI run holds.
#pragma once

#include <mpi.h>

#include <cstdint>
#include <vector>

#include "part_data.h"
#include "processes.h"
#include "solver/linear/body_preconditioner.h"
#include "tetraction/mesh/mesh_part.h"

namespace tetraction::petsc {

class MpiPart : public MeshPart, public PreconditionerSource {
 public:
  MpiPart(const Processes& processes, PartData&& data);
  MpiPart(const MpiPart&) = delete;
  MpiPart& operator=(const MpiPart&) = delete;

  int rank() const override { return rank_; }
  int count() const override { return count_; }
  void begin_adding(const double* values, Index width) const override;
  void end_adding(double* values, Index width) const override;
  void sum(double* values, Index count) const override;
  void largest(double* values, Index count) const override;
  void gather(const double* own, const std::vector<Index>& counts, double* all) const override;
  void broadcast(std::string& text, int from) const override;
  Vector collect(const Vector& values, Index width) const override;
  Vector scatter(const Vector& whole_values, Index width) const override;
  std::unique_ptr<BodyPreconditioner> make_preconditioner(
      const MechanicalSystem& system, BodyPreconditioner::Kind kind) const override;

 private:
  int rank_;
  int count_;
  std::vector<Neighbor> neighbors_;
  mutable std::vector<std::vector<double>> sent_;
  mutable std::vector<std::vector<double>> received_;
  mutable std::vector<MPI_Request> requests_;
  mutable std::vector<double> own_;
  mutable std::vector<double> gathered_;
};

}  // namespace tetraction::petsc
