#include "study_names.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tetraction/simulation/quantities.h"

namespace tetraction {

std::map<std::string, std::size_t> references_of_variants(const StudyResult& result) {
  std::map<std::string, std::size_t> places;
  for (std::size_t i = 0; i < result.references.size(); ++i) {
    for (const std::string& variant : result.references[i].variants) places.emplace(variant, i);
  }
  return places;
}

std::vector<StudyResult> parts_of_study(const StudyResult& result) {
  StudyResult empty;
  empty.end = result.end;
  empty.reference_integrator = result.reference_integrator;
  empty.reference_step = result.reference_step;
  empty.is_interrupted = result.is_interrupted;
  empty.error_probe = result.error_probe;
  empty.error_kind = result.error_kind;
  empty.probes = result.probes;
  empty.stable_step = std::numeric_limits<double>::quiet_NaN();  // that of the first variant
  std::vector<StudyResult> parts(result.references.size(), empty);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const VariantReference& reference = result.references[i];
    parts[i].reference_status = reference.status;
    parts[i].reference_directory = reference.directory;
    parts[i].reference_error = reference.error;
    parts[i].extrapolation = reference.extrapolation;
  }
  const std::map<std::string, std::size_t> places = references_of_variants(result);
  for (const StudyRow& row : result.rows) {
    const auto found = places.find(row.variant);
    if (found != places.end()) parts[found->second].rows.push_back(row);
  }
  return parts;
}

bool is_extrapolated(const StudyResult& result) {
  return result.extrapolation && result.extrapolation->is_valid_for(!result.error_probe.empty());
}

std::string enumeration(const std::vector<std::string>& words, std::size_t most) {
  std::vector<std::string> named = words;
  named.resize(std::min(words.size(), most));
  if (words.size() > most) named.push_back(fmt::format("{} more", words.size() - most));
  if (named.size() < 2) return fmt::format("{}", fmt::join(named, ""));
  const std::string last = named.back();
  named.pop_back();
  return fmt::format("{} and {}", fmt::join(named, ", "), last);
}

void SharedSentences::add(const std::string& before, const std::string& name,
                          const std::string& after) {
  for (Shared& each : sentences_) {
    if (each.before == before && each.after == after) return each.names.push_back(name);
  }
  sentences_.push_back({before, {name}, after});
}

std::vector<std::string> SharedSentences::all() const {
  std::vector<std::string> all;
  for (const auto& [before, names, after] : sentences_) {
    all.push_back(before + enumeration(names, kMostNamed) + after);
  }
  return all;
}

std::string percent(double share) {
  return short_number(100.0 * share) + " %";
}

std::string short_number(double value) {
  const bool is_small = value != 0.0 && std::abs(value) < 0.01;
  std::string text = is_small ? fmt::format("{:.2e}", value) : fmt::format("{:.3g}", value);
  const auto exponent = text.find('e');
  if (exponent == std::string::npos) return text;
  // "7.20e-05" becomes "7.2e-5", and "3e+15" becomes "3e15".
  std::string digits = text.substr(0, exponent);
  if (digits.find('.') != std::string::npos) {
    digits.erase(digits.find_last_not_of('0') + 1);
    if (digits.back() == '.') digits.pop_back();
  }
  std::size_t power = exponent + 2;
  while (power + 1 < text.size() && text[power] == '0') ++power;
  return digits + 'e' + (text[exponent + 1] == '-' ? "-" : "") + text.substr(power);
}

std::string two_digits(double ratio) {
  const double unit = std::pow(10.0, std::floor(std::log10(ratio)) - 1.0);
  return short_number(std::round(ratio / unit) * unit);
}

std::string with_article(const std::string& error) {
  return (error.front() == 'e' ? "an " : "a ") + error;
}

std::string capitalised(std::string text) {
  if (!text.empty() && text.front() >= 'a' && text.front() <= 'z') {
    text.front() = static_cast<char>(text.front() - 'a' + 'A');
  }
  return text;
}

std::string rule_name(const StudyRow& row) {
  std::string rule = to_string(row.integrator);
  if (!row.settings.empty()) rule += ", " + row.settings;
  return row.compares_solver ? rule + " (" + row.solver + ")" : rule;
}

std::string rule_name(const RuleFinding& finding) {
  StudyRow row;
  row.integrator = finding.rule;
  row.settings = to_string(finding.settings);
  return rule_name(row);
}

std::string run_label(const StudyRow& row) {
  StudyRow rule = row;
  rule.compares_solver = false;
  std::vector<std::string> tags{row.variant, row.compares_solver ? row.solver : ""};
  std::erase(tags, "");
  return rule_name(rule) + (tags.empty() ? "" : fmt::format(" ({})", fmt::join(tags, ", ")));
}

std::string in_limits(const StudyRow& row) {
  const double ratio = row.step / row.stable_step;
  if (!std::isfinite(ratio) || !(ratio > 0.0)) return {};
  return fmt::format(" ({} h_crit)",
                     ratio < 1e3 ? short_number(ratio) : fmt::format("{:.0f}", ratio));
}

std::string step_text(const StudyRow& row) {
  return short_number(row.step) + " s" + in_limits(row);
}

std::string reason_of(const StudyRow& row) {
  std::string reason = row.message;
  const auto step = reason.starts_with("step ") ? reason.find(": ") : std::string::npos;
  if (step != std::string::npos) reason.erase(0, step + 2);
  // Details follow after a colon, in parentheses, or in further sentences.
  for (const char* end : {": ", " (", ". ", "\n"}) {
    reason.erase(std::min(reason.size(), reason.find(end)));
  }
  if (reason.ends_with('.')) reason.pop_back();
  return reason;
}

std::string error_word(const StudyResult& result) {
  return result.error_probe.empty()
             ? "position"
             : to_string(ErrorMeasure{result.error_kind, result.error_probe});
}

std::string error_name(const StudyResult& result) {
  if (result.error_probe.empty()) return "position error";
  return "error of the " + quantity_name(result);
}

std::string value_name(const StudyResult& result) {
  return result.error_kind == ErrorKind::kPeak        ? "peak"
         : result.error_kind == ErrorKind::kFrequency ? "frequency"
                                                      : "";
}

std::string value_unit(const StudyResult& result) {
  if (result.error_kind == ErrorKind::kFrequency) return "Hz";
  for (const ProbeColumns& probe : result.probes) {
    if (probe.name == result.error_probe) return quantity_of(probe.quantity).unit;
  }
  return {};
}

std::string value_heading(const StudyResult& result) {
  const std::string name = value_name(result);
  if (name.empty() || value_unit(result).empty()) return name;
  return fmt::format("{} [{}]", name, value_unit(result));
}

std::string quantity_name(const StudyResult& result) {
  const std::string name = value_name(result);
  return name.empty() ? series_name(result)
                      : fmt::format("{} of the {}", name, series_name(result));
}

std::string series_name(const StudyResult& result) {
  if (result.error_kind != ErrorKind::kEnergy) return "probe " + result.error_probe;
  std::string name = result.error_probe;
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

std::string reference_name(const StudyResult& result) {
  const bool has_two = is_extrapolated(result);
  return fmt::format("{}{} with h = {}{} s", has_two ? "Richardson extrapolation of " : "",
                     to_string(result.reference_integrator),
                     has_two ? short_number(result.extrapolation->step) + " s and " : "",
                     short_number(result.reference_step));
}

bool is_above_stability_limit(const StudyRow& row) {
  return row.step > row.stable_step;
}

double round_off_level(const StudyRow& row) {
  return std::numeric_limits<double>::epsilon() * (10.0 + static_cast<double>(row.steps));
}

}  // namespace tetraction
