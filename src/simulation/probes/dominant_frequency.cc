// The frequency of the largest part of a spectrum.
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>

#include "core/not_known.h"
#include "tetraction/simulation/probe.h"

namespace tetraction {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

// Values with weights that add up to 1, and whose weighted mean is 0.
class WeightedTrace {
 public:
  WeightedTrace(const std::vector<double>& times, const std::vector<double>& values)
      : times_(times), values_(values), weights_(times.size()) {
    const std::size_t n = times.size();
    const double spacing = duration() / static_cast<double>(n - 1);
    double sum = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const double place = (times[i] - times[0] + 0.5 * spacing) / (duration() + spacing);
      const double sine = std::sin(std::numbers::pi * place);
      const double before = i > 0 ? times[i] - times[i - 1] : spacing;
      const double after = i + 1 < n ? times[i + 1] - times[i] : spacing;
      weights_[i] = sine * sine * (before + after);
      sum += weights_[i];
    }
    double mean = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      weights_[i] /= sum;
      mean += weights_[i] * values[i];
    }
    for (std::size_t i = 0; i < n; ++i) {
      values_[i] -= mean;
      variance_ += weights_[i] * values_[i] * values_[i];
    }
  }

  double duration() const { return times_.back() - times_.front(); }
  double variance() const { return variance_; }

  // How much of the variance a + b cos 2πft + c sin 2πft explains, between 0 and 1.
  double explained(double frequency) const {
    const double omega = kTurn * frequency;
    double c = 0.0;
    double s = 0.0;
    double cc = 0.0;
    double cs = 0.0;
    double yc = 0.0;
    double ys = 0.0;
    // The phase is turned from time to time. Every 64 times it is computed anew, so that round-off
    // does not accumulate.
    std::complex<double> phase;
    std::complex<double> turn;
    double last_spacing = -1.0;
    for (std::size_t i = 0; i < times_.size(); ++i) {
      if (i % 64 == 0) {
        phase = std::polar(1.0, omega * (times_[i] - times_[0]));
      } else {
        const double spacing = times_[i] - times_[i - 1];
        if (std::abs(spacing - last_spacing) > 1e-9 * spacing) {
          turn = std::polar(1.0, omega * spacing);
          last_spacing = spacing;
        }
        phase = {phase.real() * turn.real() - phase.imag() * turn.imag(),
                 phase.real() * turn.imag() + phase.imag() * turn.real()};
      }
      const double wc = weights_[i] * phase.real();
      const double ws = weights_[i] * phase.imag();
      c += wc;
      s += ws;
      cc += wc * phase.real();
      cs += wc * phase.imag();
      yc += wc * values_[i];
      ys += ws * values_[i];
    }
    const double ss = 1.0 - cc - s * s;
    cc -= c * c;
    cs -= c * s;
    const double determinant = cc * ss - cs * cs;
    if (!(determinant > 0.0)) return 0.0;
    return (ss * yc * yc + cc * ys * ys - 2.0 * cs * yc * ys) / (variance_ * determinant);
  }

  // The frequency with the largest Fourier coefficient of the weighted values, up to half the mean
  // sampling rate. Values between the times are interpolated linearly.
  double largest_coefficient() const {
    const std::size_t n = times_.size();
    const double spacing = duration() / static_cast<double>(n - 1);
    std::size_t length = 4;
    while (length < 2 * n) length *= 2;
    std::vector<double> padded(length, 0.0);
    std::size_t right = 1;
    for (std::size_t i = 0; i < n; ++i) {
      const double t = times_[0] + static_cast<double>(i) * spacing;
      while (right + 1 < n && times_[right] < t) ++right;
      const double share =
          std::clamp((t - times_[right - 1]) / (times_[right] - times_[right - 1]), 0.0, 1.0);
      const double place = (static_cast<double>(i) + 0.5) / static_cast<double>(n);
      const double sine = std::sin(std::numbers::pi * place);
      padded[i] = sine * sine * ((1.0 - share) * values_[right - 1] + share * values_[right]);
    }
    Eigen::FFT<double> transform;
    transform.SetFlag(Eigen::FFT<double>::HalfSpectrum);
    std::vector<std::complex<double>> spectrum;
    transform.fwd(spectrum, padded);
    std::size_t best = 1;
    for (std::size_t k = 1; k < spectrum.size(); ++k) {
      if (std::norm(spectrum[k]) > std::norm(spectrum[best])) best = k;
    }
    return static_cast<double>(best) / (static_cast<double>(length) * spacing);
  }

 private:
  const std::vector<double>& times_;
  std::vector<double> values_;
  std::vector<double> weights_;
  double variance_ = 0.0;
};

}  // namespace

double dominant_frequency(const std::vector<double>& times, const std::vector<double>& values,
                          double round_off) {
  constexpr double kFewestPeriods = 2.0;
  if (times.size() < 5 || !(times.back() > times.front())) return kNotKnown;
  const WeightedTrace trace(times, values);
  if (!(trace.variance() > round_off * round_off) || !std::isfinite(trace.variance()))
    return kNotKnown;
  const double highest = 0.5 * static_cast<double>(times.size() - 1) / trace.duration();
  double best = trace.largest_coefficient();
  // Parabolas through three points find the maximum. The first spacing is a quarter of the half
  // width of the peak. The error of a parabola falls with the third power of the spacing, so that
  // four of them suffice.
  double spacing = 0.5 / trace.duration();
  for (int i = 0; i < 12 && spacing > 2e-4 / trace.duration(); ++i) {
    const double low = std::max(best - spacing, 1e-3 / trace.duration());
    const double high = std::min(best + spacing, highest);
    const double left = trace.explained(low);
    const double middle = trace.explained(best);
    const double right = trace.explained(high);
    if (left > middle || right > middle) {
      best = left > right ? low : high;  // the peak is further away
      continue;
    }
    const double slope_left = (middle - left) / (best - low);
    const double slope_right = (right - middle) / (high - best);
    if (!(best > low) || !(high > best) || !(slope_left > slope_right)) break;
    // The derivative is slope_left at the centre of the left interval and slope_right at that of the
    // right one.
    const double share = slope_left / (slope_left - slope_right);
    const double peak = 0.5 * (low + best) + share * 0.5 * (high - low);
    best = std::clamp(peak, low, high);
    spacing *= 0.125;
  }
  const double periods = best * trace.duration();
  return periods >= kFewestPeriods * (1.0 - 1e-6) ? best : kNotKnown;
}

}  // namespace tetraction
