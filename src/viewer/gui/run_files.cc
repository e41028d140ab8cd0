#include "run_files.h"

#include <fmt/format.h>

#include "io/text_file.h"

namespace tetraction::viewer {
namespace {

Matrix columns(const Vector& field) {
  return field.reshaped(3, field.size() / 3);
}

}  // namespace

const char* cell_array_name(ColorField field) {
  switch (field) {
    case ColorField::kVonMises:
      return "von_mises";
    case ColorField::kEnergyDensity:
      return "energy_density";
    case ColorField::kJacobian:
      return "jacobian";
    case ColorField::kRegion:
      return "region";
    default:
      return nullptr;
  }
}

RunFiles::RunFiles(const TetMesh& mesh, const std::string& directory)
    : directory_(directory), rest_(mesh.rest_positions()), frames_(mesh, directory) {}

void RunFiles::write(const Snapshot& snapshot) {
  Frame frame;
  frame.time = snapshot.time;
  frame.step = snapshot.step;
  Matrix fixed(1, static_cast<Index>(snapshot.fixed.size()));
  for (Index v = 0; v < fixed.cols(); ++v)
    fixed(0, v) = snapshot.fixed[static_cast<std::size_t>(v)];
  frame.point_fields = {{"displacement", columns(snapshot.position - rest_)},
                        {"velocity", columns(snapshot.velocity)},
                        {"momentum", columns(snapshot.momentum)},
                        {"external_force", columns(snapshot.external_force)},
                        {"reaction_force", columns(snapshot.reaction_force)},
                        {"fixed", std::move(fixed), true}};
  if (const char* name = cell_array_name(snapshot.field);
      name != nullptr && snapshot.field_on_cells) {
    Matrix values(1, static_cast<Index>(snapshot.field_values.size()));
    for (Index e = 0; e < values.cols(); ++e) {
      values(0, e) = static_cast<double>(snapshot.field_values[static_cast<std::size_t>(e)]);
    }
    frame.cell_fields = {{name, std::move(values), snapshot.field == ColorField::kRegion}};
  }
  frames_.write(frame);
}

void RunFiles::write_history(const std::vector<HistoryRow>& rows) const {
  write_text_file(directory_ + "/history.csv", history_text(rows));
}

std::string history_text(const std::vector<HistoryRow>& rows) {
  std::string text =
      "step,time,kinetic_energy,elastic_energy,environment_energy,total_energy,external_work,"
      "dissipated_energy,constraint_work,edit_work,energy_error,px,py,pz,lx,ly,lz,iterations\n";
  for (const HistoryRow& r : rows) {
    text += fmt::format("{}", r.step);
    for (const double value :
         {r.time, r.kinetic, r.elastic, r.environment, r.total, r.external_work,
          r.dissipated_energy, r.constraint_work, r.edit_work, r.energy_error,
          r.linear_momentum.x(), r.linear_momentum.y(), r.linear_momentum.z(),
          r.angular_momentum.x(), r.angular_momentum.y(), r.angular_momentum.z()}) {
      text += fmt::format(",{:.17g}", value);
    }
    text += fmt::format(",{}\n", r.iterations);
  }
  return text;
}

}  // namespace tetraction::viewer
