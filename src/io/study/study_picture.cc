// The picture beside the answer: errors over costs, with logarithmic axes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "study_answer.h"
#include "study_grid.h"
#include "study_names.h"
#include "study_page.h"

namespace tetraction {
namespace {

constexpr double kLeft = 70.0;
constexpr double kRight = 460.0;
constexpr double kTop = 15.0;
constexpr double kBottom = 330.0;

// A logarithmic axis over whole decades.
struct Axis {
  double from;  // place on the page
  double to;
  double low = 1e9;  // decades
  double high = -1e9;

  void add(double value) {
    low = std::min(low, std::floor(std::log10(value) + 1e-9));
    high = std::max(high, std::ceil(std::log10(value) - 1e-9));
    if (high <= low) high = low + 1.0;
  }
  double at(double value) const {
    return from + (to - from) * (std::log10(value) - low) / (high - low);
  }
};

struct PicturePoint {
  double x;
  double y;
  std::string title;
};

struct PictureCurve {
  std::string rule;
  std::string color;
  std::vector<PicturePoint> points;
};

// "10^-3", with few enough decades for their labels.
std::string ticks(const Axis& axis, bool is_vertical) {
  std::string text;
  const double every = std::ceil((axis.high - axis.low) / 6.0);
  for (double decade = axis.low; decade <= axis.high; decade += every) {
    const double at = axis.at(std::pow(10.0, decade));
    const std::string label =
        fmt::format("10<tspan dy=\"-6\" font-size=\"11\">{:.0f}</tspan>", decade);
    text += is_vertical
                ? fmt::format(
                      "<path class=\"grid\" d=\"M{} {:.1f}H{}\"/><text x=\"{}\" y=\"{:.1f}\" "
                      "text-anchor=\"end\">{}</text>\n",
                      kLeft, at, kRight, kLeft - 6, at + 5, label)
                : fmt::format(
                      "<path class=\"grid\" d=\"M{:.1f} {}V{}\"/><text x=\"{:.1f}\" y=\"{}\" "
                      "text-anchor=\"middle\">{}</text>\n",
                      at, kTop, kBottom, at, kBottom + 20, label);
  }
  return text;
}

}  // namespace

std::string study_picture(const StudyResult& result) {
  const StudyAnswer answer = study_answer(result);
  const bool has_probe = !result.error_probe.empty();
  const bool has_costs =
      answer.has_comparable_costs && (answer.shared == 0 || answer.uses_processor_time);
  Axis across{kLeft, kRight};
  Axis up{kBottom, kTop};
  std::vector<PictureCurve> curves;
  for (const StudyRow& row : result.rows) {
    const double error = has_probe ? row.probe_error : row.position_error;
    const double cost = answer.uses_processor_time ? row.processor_seconds : row.wall_seconds;
    const double x = has_costs ? cost : row.step;
    if (row.variant != result.rows.front().variant || row.role != StudyRole::kRun ||
        row.status != RunStatus::kFinished || !(error > 0.0) || !std::isfinite(error) ||
        !(x > 0.0)) {
      continue;
    }
    if (curves.empty() || curves.back().rule != rule_name(row)) {
      curves.push_back({rule_name(row), to_string(row.integrator), {}});
    }
    across.add(x);
    up.add(error);
    curves.back().points.push_back(
        {x, error,
         fmt::format("{}, h = {} s{}: error {}{}", rule_name(row), short_number(row.step),
                     in_limits(row), short_number(error),
                     has_costs ? fmt::format(", {} s", short_number(cost)) : "")});
  }
  if (curves.empty()) return {};
  std::string text = fmt::format(
      "<svg class=\"picture\" viewBox=\"0 0 640 375\" role=\"img\" aria-label=\"{}\">\n",
      has_costs ? "Error over cost" : "Error over step");
  text += ticks(across, false) + ticks(up, true);
  text += fmt::format(
      "<text x=\"{}\" y=\"370\" text-anchor=\"middle\">{}</text>\n<text transform=\"translate(18 "
      "{}) rotate(-90)\" text-anchor=\"middle\">error</text>\n",
      0.5 * (kLeft + kRight),
      !has_costs                   ? "step [s]"
      : answer.uses_processor_time ? "processor time [s]"
                                   : "wall time [s]",
      0.5 * (kTop + kBottom));
  // The names stand beside the picture at the heights of their last points, with a line of text between them.
  std::vector<std::pair<double, const PictureCurve*>> names;
  const auto begin_group = [&](const PictureCurve& curve) {
    text += fmt::format("<g data-rule=\"{}\" style=\"--c: var(--{}, var(--other))\">",
                        escaped_html(curve.rule), curve.color);
  };
  for (const PictureCurve& curve : curves) {
    begin_group(curve);
    std::string path;
    const PicturePoint* last = &curve.points.front();
    for (const PicturePoint& point : curve.points) {
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? 'M' : 'L', across.at(point.x),
                          up.at(point.y));
      if (point.x > last->x) last = &point;
    }
    text += fmt::format("<path class=\"curve\" d=\"{}\"/>", path);
    for (const PicturePoint& point : curve.points) {
      text +=
          fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4.5\"><title>{}</title></circle>",
                      across.at(point.x), up.at(point.y), escaped_html(point.title));
    }
    text += "</g>\n";
    names.emplace_back(up.at(last->y) + 5.0, &curve);
  }
  std::sort(names.begin(), names.end());
  double height = kTop;
  for (const auto& [wanted, curve] : names) {
    height = std::max(height, wanted);
    begin_group(*curve);
    text += fmt::format("<text class=\"name\" x=\"{}\" y=\"{:.0f}\">{}</text></g>\n", kRight + 8.0,
                        height, escaped_html(curve->rule));
    height += 18.0;
  }
  return text + "</svg>\n";
}

}  // namespace tetraction
