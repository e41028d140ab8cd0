#include "mesh_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "cli/console.h"
#include "cli/scene_source.h"
#include "core/quoting.h"
#include "mesh/bounding_box.h"
#include "tetraction/mesh/mesh_checks.h"

namespace tetraction {
namespace {

constexpr std::size_t kBins = 10;

// The width of a bin; 0 if all elements have the same value but for round-off.
double bin_width(const QualityMeasure& measure) {
  constexpr double kRoundOff = 1e-9;
  const double range = measure.max - measure.min;
  return range > kRoundOff * std::abs(measure.max) ? range / static_cast<double>(kBins) : 0.0;
}

std::vector<Index> histogram(const QualityMeasure& measure) {
  std::vector<Index> bins(kBins, 0);
  const double width = bin_width(measure);
  for (const double value : measure.values) {
    const auto bin =
        width > 0.0 ? static_cast<std::size_t>(std::max(0.0, (value - measure.min) / width)) : 0;
    ++bins[std::min(bin, kBins - 1)];
  }
  return bins;
}

// With as many decimals as tell the bins from each other.
void print_histogram(const QualityMeasure& measure) {
  const double width = bin_width(measure);
  if (width == 0.0) {
    print_result("  {}: {:.4g} in every element\n", measure.name, measure.mean);
    return;
  }
  const int decimals = std::max(3, 1 - static_cast<int>(std::floor(std::log10(width))));
  const std::vector<Index> bins = histogram(measure);
  const Index most = *std::max_element(bins.begin(), bins.end());
  print_result("  {}:\n", measure.name);
  for (std::size_t i = 0; i < bins.size(); ++i) {
    const auto length =
        static_cast<std::size_t>(40.0 * static_cast<double>(bins[i]) / static_cast<double>(most));
    print_result("  {0:>{4}.{5}f} – {1:<{4}.{5}f}{2:>9}  {3}\n",
                 measure.min + width * static_cast<double>(i),
                 measure.min + width * static_cast<double>(i + 1), bins[i],
                 std::string(length, '#'), decimals + 5, decimals);
  }
}

std::map<int, Index> region_counts(const TetMesh& mesh) {
  std::map<int, Index> counts;
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) ++counts[mesh.region(e)];
  return counts;
}

nlohmann::ordered_json arrays_json(const std::map<std::string, Matrix>& arrays) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const auto& [name, values] : arrays) {
    json[name] = {{"components", values.rows()},
                  {"min", values.minCoeff<Eigen::PropagateNumbers>()},
                  {"max", values.maxCoeff<Eigen::PropagateNumbers>()}};
  }
  return json;
}

void print_arrays(const std::map<std::string, Matrix>& arrays, const char* what, const char* of) {
  for (const auto& [name, values] : arrays) {
    print_result("  {} \"{}\": {} {}, from {:.6g} to {:.6g}\n", what, printable(name),
                 values.rows() == 1 ? "a number" : fmt::format("{} numbers", values.rows()), of,
                 values.minCoeff<Eigen::PropagateNumbers>(),
                 values.maxCoeff<Eigen::PropagateNumbers>());
  }
}

}  // namespace

std::string size_text(const TetMesh& mesh) {
  return fmt::format("{} vertices, {} {}tetrahedra, volume {:.10g} m3", mesh.vertex_count(),
                     mesh.tetrahedron_count(), mesh.is_quadratic() ? "quadratic " : "",
                     mesh.total_volume());
}

nlohmann::ordered_json mesh_json(const TetMesh& mesh, const std::vector<std::string>& unused,
                                 const std::vector<QualityMeasure>& quality) {
  const BoundingBox box = bounding_box(mesh);
  nlohmann::ordered_json json;
  json["source"] = mesh.source;
  json["vertices"] = mesh.vertex_count();
  json["tetrahedra"] = mesh.tetrahedron_count();
  json["element"] = mesh.is_quadratic() ? "quadratic" : "linear";
  json["volume"] = mesh.total_volume();
  json["bounding_box"] = {{"min", {box.low.x(), box.low.y(), box.low.z()}},
                          {"max", {box.high.x(), box.high.y(), box.high.z()}}};
  json["reoriented_tetrahedra"] = mesh.report.reoriented;
  json["dropped_vertices"] = mesh.report.dropped_vertices;
  json["coincident_vertices"] = coincident_vertices(mesh);
  json["skipped_cells"] = nlohmann::ordered_json::object();
  for (const auto& [type, count] : mesh.report.skipped_cells) {
    json["skipped_cells"][to_string(type)] = count;
  }
  json["not_used"] = unused;
  json["regions"] = nlohmann::ordered_json::object();
  for (const auto& [region, count] : region_counts(mesh)) {
    json["regions"][std::to_string(region)] = count;
  }
  json["groups"] = nlohmann::ordered_json::array();
  for (const Group& group : mesh.groups) {
    json["groups"].push_back({{"name", group.name},
                              {"dimension", group.dimension},
                              {"tag", group.tag},
                              {"vertices", group.vertices.size()},
                              {"triangles", group.triangles.size()},
                              {"tetrahedra", group.tetrahedra.size()}});
  }
  json["point_arrays"] = arrays_json(mesh.point_arrays);
  json["cell_arrays"] = arrays_json(mesh.cell_arrays);
  json["quality"] = nlohmann::ordered_json::array();
  for (const QualityMeasure& measure : quality) {
    json["quality"].push_back({{"measure", measure.name},
                               {"ideal", measure.ideal},
                               {"min", measure.min},
                               {"mean", measure.mean},
                               {"max", measure.max},
                               {"worst_element", measure.worst_element},
                               {"histogram", histogram(measure)}});
  }
  return json;
}

void print_mesh_table(const TetMesh& mesh, const std::vector<std::string>& unused,
                      const std::vector<QualityMeasure>& quality) {
  const BoundingBox box = bounding_box(mesh);
  print_result("mesh: {}\n  {}\n", mesh.source, size_text(mesh));
  print_result("  bounding box [{:.6g}, {:.6g}] x [{:.6g}, {:.6g}] x [{:.6g}, {:.6g}] m\n",
               box.low.x(), box.high.x(), box.low.y(), box.high.y(), box.low.z(), box.high.z());
  if (const std::string remarks = mesh_remarks(mesh, unused); !remarks.empty()) {
    print_result("  {}\n", remarks);
  }
  for (const auto& [region, count] : region_counts(mesh)) {
    print_result("  region {}: {} tetrahedra\n", region, count);
  }
  for (const Group& group : mesh.groups) {
    print_result("  group \"{}\" (dimension {}, tag {}): {} vertices", printable(group.name),
                 group.dimension, group.tag, group.vertices.size());
    if (!group.triangles.empty()) print_result(", {} triangles", group.triangles.size());
    if (group.dimension == 3) print_result(", {} tetrahedra", group.tetrahedra.size());
    write_result("\n");
  }
  print_arrays(mesh.point_arrays, "point array", "a vertex");
  print_arrays(mesh.cell_arrays, "cell array", "a tetrahedron");
  print_result("  {:<24}{:>12}{:>12}{:>12}  {:<16}worst element\n", "quality", "min", "mean", "max",
               "ideal");
  for (const QualityMeasure& m : quality) {
    print_result("  {:<24}{:>12.4g}{:>12.4g}{:>12.4g}  {:<16}{}\n", m.name, m.min, m.mean, m.max,
                 m.ideal, m.worst_element);
  }
  print_histogram(quality.front());
}

}  // namespace tetraction
