// The members of each struct of a checkpoint, for the archives of checkpoint_archive.h. A structured
// binding names all members or does not compile, so that none can be forgotten.
#pragma once

#include "checkpoint_archive.h"
#include "tetraction/io/checkpoint_file.h"

namespace tetraction {

// The members of a struct, all of them in their order.
#define TETRACTION_TRANSFER(Struct, ...)      \
  template <class Archive, Is<Struct> T>      \
  void transfer(Archive& archive, T& value) { \
    auto& [__VA_ARGS__] = value;              \
    transfer_all(archive, __VA_ARGS__);       \
  }

TETRACTION_TRANSFER(BodyIdentity, mesh, regions, densities, force_terms)
TETRACTION_TRANSFER(AppliedEdit, at, time, step, what, energy_jump, warning)
TETRACTION_TRANSFER(StepRange, smallest, largest, last, changes)
TETRACTION_TRANSFER(InvertedElements, now, most, most_step, first, first_time)
TETRACTION_TRANSFER(CriticalModes, stiffness, damping)
TETRACTION_TRANSFER(AutomaticStepMemory, modes, critical_step, rate, last, next, interval, recent,
                    known, largest_change, grows, elastic_energy, elastic_energy_at_estimate,
                    sensitivity)
TETRACTION_TRANSFER(AdaptiveStepMemory, last_error, has_energy, energy, half_work)
TETRACTION_TRANSFER(StepPlan, time_step, segment_time, segment_step, segment_count, automatic,
                    adaptive)
TETRACTION_TRANSFER(StepControl, retried, rejected, failed, above_tolerance, without_solution,
                    last_rejected, last_substeps, last_error, discrete_energy, energy_residual)
template <class Archive, Is<MinimizerReport> T>
void transfer(Archive& archive, T& value) {
  auto& [termination, iterations, factorizations, cg_iterations, linear, residual, residual_limit,
         asked_limit, message, met_negative_curvature] = value;
  transfer_enum(archive, termination, Termination::kInadmissible);
  transfer_all(archive, iterations, factorizations, cg_iterations, linear, residual, residual_limit,
               asked_limit, message, met_negative_curvature);
}

TETRACTION_TRANSFER(ObstacleForce, force, moment)
template <class Archive, Is<RunProgress> T>
void transfer(Archive& archive, T& value) {
  auto& [status, message, plan, first_time_step, steps, next_event, edits, warnings, inverted,
         passed_center, external_force, obstacle_forces, last_report, total_iterations,
         total_factorizations, total_cg_iterations, linear_solver, control] = value;
  transfer_enum(archive, status, RunStatus::kCancelled);
  transfer_all(archive, message, plan, first_time_step, steps, next_event);
  transfer_list(archive, edits);
  transfer_list(archive, warnings);
  transfer_all(archive, inverted, passed_center, external_force);
  transfer_list(archive, obstacle_forces);
  transfer_all(archive, last_report, total_iterations, total_factorizations, total_cg_iterations,
               linear_solver, control);
}

TETRACTION_TRANSFER(State, step, time, position, momentum, velocity)
TETRACTION_TRANSFER(Momenta, linear, angular, linear_scale, angular_scale)
// The first three entries have fixed names.
template <class Archive, Is<Energies> T>
void transfer(Archive& archive, T& value) {
  const std::size_t extra = archive.count(value.extra_count(), 2 * sizeof(double));
  double kinetic = value.kinetic();
  double elastic = value.elastic();
  double environment = value.environment();
  transfer_all(archive, kinetic, elastic, environment);
  if constexpr (Archive::kReads) {
    value.set_kinetic(kinetic);
    value.set_elastic(elastic);
    value.set_environment(environment);
  }
  for (std::size_t i = 0; i < extra; ++i) {
    Energies::Entry entry;
    if constexpr (!Archive::kReads) entry = value.extra(i);
    transfer_all(archive, entry.name, entry.value);
    if constexpr (Archive::kReads) value.set_extra(i, entry.name, entry.value);
  }
}

TETRACTION_TRANSFER(ObstacleImpulse, linear, angular, largest_force, in_step)
template <class Archive, Is<BalanceSums> T>
void transfer(Archive& archive, T& value) {
  auto& [initial_energies, energies, initial_momenta, momenta, external_work, dissipated_energy,
         constraint_work, friction_dissipation, obstacles, edit_work, linear_impulse,
         angular_impulse, residual_angular_impulse, round_off, largest_environment_exchange,
         largest_external_work, largest_constraint_work, largest_spring_energy, sum_of_edits,
         largest_energy_error, largest_linear_drift, largest_angular_drift, linear_scale,
         angular_scale, limited_steps, largest_limited_residual, largest_allowed_residual] = value;
  transfer_all(archive, initial_energies, energies, initial_momenta, momenta, external_work,
               dissipated_energy, constraint_work, friction_dissipation);
  transfer_list(archive, obstacles);
  transfer_all(archive, edit_work, linear_impulse, angular_impulse, residual_angular_impulse,
               round_off, largest_environment_exchange, largest_external_work,
               largest_constraint_work, largest_spring_energy, sum_of_edits, largest_energy_error,
               largest_linear_drift, largest_angular_drift, linear_scale, angular_scale,
               limited_steps, largest_limited_residual, largest_allowed_residual);
}
template <class Archive, Is<PrescribedMotion> T>
void transfer(Archive& archive, T& value) {
  // complete_settings() sets the amplitudes.
  auto& [since, velocity, angular_velocity, center, offset, velocity_amplitude, offset_amplitude] =
      value;
  transfer_all(archive, since, velocity, angular_velocity, center, offset);
}

// complete_settings() sets the names of all constraints.
template <class Archive, Is<PrescribedVertices> T>
void transfer(Archive& archive, T& value) {
  auto& [vertices, components, start, motion, penalty, name] = value;
  transfer_list(archive, vertices);
  transfer(archive, components);
  transfer_columns(archive, start, 3);
  transfer_all(archive, motion, penalty);
}

template <class Archive, Is<GuidedVertices> T>
void transfer(Archive& archive, T& value) {
  auto& [vertices, directions, points, name] = value;
  transfer_list(archive, vertices);
  transfer_columns(archive, directions, 3);
  transfer_columns(archive, points, 3);
}

template <class Archive, Is<FixedDistance> T>
void transfer(Archive& archive, T& value) {
  auto& [a, b, length, name] = value;
  transfer_all(archive, a, b, length);
}

template <class Archive, Is<RigidHandle> T>
void transfer(Archive& archive, T& value) {
  auto& [vertices, shape, name] = value;
  transfer_list(archive, vertices);
  transfer_columns(archive, shape, 3);
}

template <class Archive, Is<ConstraintObject> T>
void transfer(Archive& archive, T& value) {
  auto kind = static_cast<std::uint64_t>(value.index());
  archive.whole(kind);
  if constexpr (Archive::kReads) {
    switch (kind) {
      case 0:
        value = PrescribedVertices{};
        break;
      case 1:
        value = GuidedVertices{};
        break;
      case 2:
        value = FixedDistance{};
        break;
      case 3:
        value = RigidHandle{};
        break;
      default:
        throw BadBytes{"a kind of constraint is not known"};
    }
  }
  std::visit([&](auto& object) { transfer(archive, object); }, value);
}

TETRACTION_TRANSFER(ObstacleFrame, rotation, shift)
TETRACTION_TRANSFER(ObstacleStart, time, frame, way, stiffness)
// complete_settings() sets the rest.
template <class Archive, Is<BodyObstacle> T>
void transfer(Archive& archive, T& value) {
  auto& [settings, removed, start] = value;
  transfer(archive, start);
}

TETRACTION_TRANSFER(Reactions, force, delay, configuration_force)
template <class Archive, Is<Checkpoint> T>
void transfer(Archive& archive, T& value) {
  auto& [body, settings, progress, state, balance, reactions] = value;
  transfer_all(archive, body, progress, state, balance, reactions);
  transfer_list(archive, settings.constraints.fixes);
  transfer_list(archive, settings.constraints.others);
  transfer_list(archive, settings.obstacles);
}

TETRACTION_TRANSFER(PhaseTimes, mesh, setup, stability, stepping, output)
template <class Archive, Is<RecordedFiles> T>
void transfer(Archive& archive, T& value) {
  auto& [history_size, last_row, probes_size, last_probe_row, last_frame, history_sum, probes_sum,
         frame_sizes] = value;
  transfer_all(archive, history_size, last_row, probes_size, last_probe_row, last_frame,
               history_sum, probes_sum);
  transfer_list(archive, frame_sizes);
}

TETRACTION_TRANSFER(RunInputs, scene, numbers, fields, amplitudes, surfaces)
TETRACTION_TRANSFER(StoredCheckpoint, version, is_regular, processes, inputs, times, files,
                    checkpoint)
#undef TETRACTION_TRANSFER

}  // namespace tetraction
