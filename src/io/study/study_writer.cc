#include "tetraction/io/study_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/quoting.h"
#include "study_answer.h"
#include "study_fields.h"
#include "study_grid.h"
#include "study_names.h"
#include "study_row_json.h"
#include "tetraction/core/version.h"
#include "tetraction/io/text_file.h"

namespace tetraction {
namespace {

// A cell of a CSV table as in RFC 4180. Arguments and names of files need not be UTF-8, which the table is.
std::string csv_text(const std::string& any_text) {
  const std::string text = printable(any_text);
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

std::string csv_cell(const nlohmann::ordered_json& value) {
  if (value.is_null()) return {};
  if (value.is_string()) return csv_text(value.get<std::string>());
  return value.is_number_float() ? fmt::format("{:.10g}", value.get<double>()) : value.dump();
}

// The stability limits of the explicit rules that have a row of the variant, "h_crit = 1e-3 s
// (explicit), 1.2e-3 s (verlet)". They differ if there is damping. Without such a row it is the
// limit of the variant's first row, or of the study if it has no rows, which are those of `explicit`.
std::string limits_text(const StudyResult& result, const std::string& variant) {
  std::vector<std::pair<double, std::string>> limits;  // with the names of their rules
  const StudyRow* first = nullptr;
  for (const StudyRow& row : result.rows) {
    if (row.variant != variant) continue;
    if (first == nullptr) first = &row;
    if (is_implicit(row.integrator)) continue;
    const std::string name = to_string(row.integrator);
    const auto known = std::find_if(limits.begin(), limits.end(), [&](const auto& limit) {
      // Lanczos iterations find a limit to 1e-4.
      return std::abs(limit.first - row.stable_step) <= 1e-3 * row.stable_step ||
             limit.first == row.stable_step;
    });
    if (known == limits.end()) {
      limits.emplace_back(row.stable_step, name);
    } else if (known->second.find(name) == std::string::npos) {
      known->second += " and " + name;
    }
  }
  if (limits.empty()) {
    limits.emplace_back(first != nullptr ? first->stable_step : result.stable_step,
                        to_string(Integrator::kExplicit));
  }
  if (!std::isfinite(limits.front().first)) return "none";
  std::string text = "h_crit = ";
  for (const auto& [limit, names] : limits) {
    text += fmt::format("{}{:.4g} s ({})", text.back() == ' ' ? "" : ", ", limit, names);
  }
  return text;
}

nlohmann::ordered_json variants_json(const StudyResult& result) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const VariantValues& variant : result.variants) {
    nlohmann::ordered_json values = nlohmann::ordered_json::object();
    for (const VariedValue& varied : variant.values) values[varied.key] = varied.value;
    json.push_back({{"name", variant.name}, {"values", std::move(values)}});
  }
  return json;
}

nlohmann::ordered_json references_json(const StudyResult& result) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const VariantReference& reference : result.references) {
    json.push_back({{"variants", reference.variants},
                    {"status", to_string(reference.status)},
                    {"directory", reference.directory},
                    {"estimated_error", json_number(reference.error)},
                    {"position_difference", json_number(reference.difference.position)},
                    {"position_difference_rms", json_number(reference.difference.position_rms)},
                    {"probe_difference", json_number(reference.difference.probe)}});
    if (reference.extrapolation) {
      json.back()["extrapolation"] = extrapolation_json(*reference.extrapolation);
    }
  }
  return json;
}

// "midpoint with h = 1e-3 s (ok), whose own error is estimated at 2e-5."
std::string reference_text(const StudyResult& result) {
  return fmt::format("{} ({}){}.\n", reference_name(result), to_string(result.reference_status),
                     std::isfinite(result.reference_error)
                         ? fmt::format(", whose own error is estimated at {}",
                                       short_number(result.reference_error))
                         : "");
}

// The errors of a variant other than the first one. `places`: references_of_variants().
std::string errors_of_variant(const StudyResult& result, const StudyRow& row,
                              const std::map<std::string, std::size_t>& places) {
  const auto own = places.find(row.variant);
  const std::string& first =
      own != places.end() ? result.references[own->second].variant : result.rows.front().variant;
  if (row.variant != first) {
    return fmt::format("; pos.error and pos.rms are differences from another variant, {}", first);
  }
  return row.variant == result.rows.front().variant ? "" : "; with a reference of its own";
}

StudyGrid grid_of_runs(const StudyResult& result) {
  const std::map<std::string, std::size_t> places = references_of_variants(result);
  std::vector<const StudyField*> fields = shown_fields(kInTable);
  std::erase_if(fields, [&](const StudyField* field) {
    const std::string_view name = field->name;
    return (name == "probe_error" && result.error_probe.empty()) ||
           (name == "probe_value" && value_name(result).empty()) ||
           (name == "settings" &&
            std::all_of(result.rows.begin(), result.rows.end(),
                        [](const StudyRow& row) { return row.settings.empty(); }));
  });
  StudyGrid grid;
  for (const StudyField* field : fields) {
    grid.column(heading_of(*field, result), !field->is_number());
  }
  for (std::size_t i = 0; i < result.rows.size(); ++i) {
    const StudyRow& row = result.rows[i];
    const bool is_other_variant = i == 0 || result.rows[i - 1].variant != row.variant;
    if (i > 0 && (is_other_variant || result.rows[i - 1].integrator != row.integrator)) {
      grid.line("");
    }
    if (is_other_variant && !row.variant.empty()) {
      grid.line(fmt::format("{}: {}{}", row.variant, limits_text(result, row.variant),
                            errors_of_variant(result, row, places)));
    }
    grid.row();
    for (const StudyField* field : fields) add_field(grid, *field, row);
  }
  return grid;
}

nlohmann::ordered_json plan_json(const PlannedSteps& plan) {
  nlohmann::ordered_json json{{"budget", plan.budget}, {"rules", nlohmann::ordered_json::array()}};
  for (const PlannedSteps::Rule& rule : plan.rules) {
    json["rules"].push_back({{"rule", to_string(rule.rule)},
                             {"steps", rule.steps},
                             {"how", rule.is_chosen ? "chosen" : "asked"}});
  }
  json["seconds_per_step"] = nlohmann::ordered_json::object();
  for (const auto& [rule, seconds] : plan.seconds_per_step) {
    json["seconds_per_step"][to_string(rule)] = seconds;
  }
  json["digest"] = plan.digest;
  return json;
}

}  // namespace

std::string study_csv(const StudyResult& result, const StudyProvenance& provenance) {
  const std::map<std::string, std::size_t> places = references_of_variants(result);
  const std::vector<StudyResult> parts = parts_of_study(result);
  std::string text;
  for (const StudyField& field : study_fields()) {
    if (field.is_in(kInCsv)) text += (text.empty() ? "" : ",") + std::string(field.name);
  }
  for (const StudyRow& row : result.rows) {
    const auto own = places.find(row.variant);
    const StudyResult& part = own != places.end() ? parts[own->second] : result;
    const std::map<std::string, nlohmann::ordered_json> of_study{
        {"version", provenance.version.empty() ? version() : provenance.version},
        {"command", provenance.command},
        {"reference", reference_name(part)},
        {"reference_error", json_number(part.reference_error)}};
    text += '\n' + to_string(row.integrator);
    for (const StudyField& field : study_fields().subspan(1)) {
      if (!field.is_in(kInCsv)) continue;
      const auto found = of_study.find(field.name);
      text += ',' + (field.is_step() ? fmt::format("{}", row.step)
                                     : csv_cell(found != of_study.end() ? found->second
                                                                        : field_value(field, row)));
    }
  }
  return text + '\n';
}

std::string study_json(const StudyResult& result, const std::string& scene_name,
                       const StudyProvenance& provenance) {
  nlohmann::ordered_json json;
  json["version"] = version();
  json["command"] = provenance.command;
  json["date"] = provenance.date;
  json["scene"] = scene_name;
  json["interrupted"] = result.is_interrupted;
  json["stable_step"] = json_number(result.stable_step);
  json["end"] = result.end;
  json["reference"] = {{"integrator", to_string(result.reference_integrator)},
                       {"step", result.reference_step},
                       {"status", to_string(result.reference_status)},
                       {"directory", result.reference_directory},
                       {"estimated_error", json_number(result.reference_error)}};
  if (result.extrapolation) {
    json["reference"]["extrapolation"] = extrapolation_json(*result.extrapolation);
  }
  if (!result.variants.empty()) json["variants"] = variants_json(result);
  if (!result.references.empty()) json["references"] = references_json(result);
  json["remarks"] = result.remarks;
  json["error"] = error_word(result);
  json["target"] = result.target ? nlohmann::ordered_json(*result.target) : nullptr;
  if (!result.findings.empty()) json["searched"] = findings_json(result);
  if (result.plan) json["choice"] = plan_json(*result.plan);
  if (const auto& check = result.mesh_check) {
    json["mesh_check"] = {{"integrator", to_string(check->integrator)},
                          {"step", check->step},
                          {"vertices", check->vertices},
                          {"tetrahedra", check->tetrahedra},
                          {"status", to_string(check->status)},
                          {"directory", check->directory},
                          {"difference", json_number(check->difference)},
                          {"estimated_error", json_number(check->estimated_error())}};
  }
  json["probes"] = nlohmann::ordered_json::array();
  for (const ProbeColumns& probe : result.probes) {
    json["probes"].push_back({{"name", probe.name},
                              {"quantity", to_string(probe.quantity)},
                              {"unit", quantity_of(probe.quantity).unit},
                              {"columns", probe.columns}});
  }
  json["runs"] = nlohmann::ordered_json::array();
  for (const StudyRow& row : result.rows) json["runs"].push_back(study_row_json(row));
  if (!provenance.plan.empty()) {
    json["plan"] = nlohmann::ordered_json::parse(provenance.plan);
  }
  json["answer"] = answer_json(study_answer(result));
  json["conclusions"] = nlohmann::ordered_json::array();
  for (const StudyConclusion& conclusion : study_conclusions(result)) {
    json["conclusions"].push_back(
        {{"topic", conclusion.topic}, {"sentences", conclusion.sentences}});
  }
  // The names of files, which stand in messages as well, need not be UTF-8, which JSON must be.
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string study_table(const StudyResult& result) {
  std::string references = "Reference: " + reference_text(result);
  if (!result.references.empty()) {
    references = fmt::format("There are {} references.\n", result.references.size());
    const std::vector<StudyResult> parts = parts_of_study(result);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      references += fmt::format("Reference of {}: {}", enumeration(result.references[i].variants),
                                reference_text(parts[i]));
    }
  }
  std::string text = grid_of_runs(result).terminal();
  text += fmt::format(
      "\nStability limit: {}. {}"
      "energy: the largest energy error, divided by the energy that entered.\n"
      "lin.mom., ang.mom.: the change of the momentum that no impulse of a force explains.\n"
      "pos.error: |q - q_ref| at the end, divided by the displacement |q_ref - X| of the "
      "reference.\n"
      "pos.rms: the same, as root mean squares over the whole time.\n",
      limits_text(result, result.rows.empty() ? "" : result.rows.front().variant), references);
  if (std::any_of(result.rows.begin(), result.rows.end(),
                  [](const StudyRow& row) { return row.shares_machine; })) {
    text +=
        "wall [s] with *: the run shared the cores of the machine with others, or had more threads "
        "than cores, so that its time does not count. --jobs 1 with fewer --threads measures it.\n";
  }
  if (result.error_kind == ErrorKind::kEnergy) {
    text += fmt::format(
        "probe.err: the largest |E - E_ref| of the {} over time, divided by the largest |E_ref - "
        "E_ref(0)|; the order is that of this error.\n",
        series_name(result));
  } else if (!result.error_probe.empty()) {
    text += fmt::format("probe.err: {} of the probe {}; the order is that of this error.\n",
                        result.error_kind == ErrorKind::kPeak ? "the relative error of the peak"
                        : result.error_kind == ErrorKind::kFrequency
                            ? "the relative error of the frequency"
                            : "the largest |s - s_ref| over time, divided by the largest |s_ref|,",
                        result.error_probe);
  }
  return text;
}

void write_study(const StudyResult& result, const std::string& scene_name,
                 const std::string& directory, const StudyProvenance& provenance) {
  write_text_file(directory + "/study.csv", study_csv(result, provenance));
  write_text_file(directory + "/study.json", study_json(result, scene_name, provenance));
}

}  // namespace tetraction
