// Decides when a coarse space saves more time in conjugate gradients than it costs.
#pragma once

namespace tetraction {

/// Decides when to make a coarse space (coarse_space.h), when to renew it, and when to do without
/// it. The decisions depend on numbers of iterations only, so that a repeated run is bitwise the
/// same.
///
/// A coarse space is made as soon as the iterations without it have cost as much as making it. So
/// the total cost is never more than twice that of the best choice. It is given up if it saves less
/// than a fifth of the iterations; then the next attempt waits eight times as long. It is renewed
/// when the iterations in excess of the rate of its first solve have cost as much as a new one.
class CoarseChoice {
 public:
  /// The cost of making a coarse space, in iterations of conjugate gradients.
  static constexpr double kPrice = 25.0;

  bool in_use() const { return in_use_; }
  /// Whether to make or renew a coarse space now, after `iterations` iterations of a solve.
  bool should_make(int iterations) const {
    return in_use_ ? iterations == 0 && excess_ > kPrice : spent_ + iterations > patience_ * kPrice;
  }
  /// To be called after a coarse space was made. `usable` is false if its matrix could not be
  /// factorised. `iterations` and `digits` are those of the solve so far.
  void made(bool usable, int iterations, double digits) {
    if (!in_use_) solved(iterations, digits);
    in_use_ = usable;
    proven_ = false;
    excess_ = 0.0;
    if (!usable) give_up();
  }
  /// To be called after a solve, or after its part with the coarse space. `digits` is the number of
  /// decimal digits by which it reduced the residual.
  void solved(int iterations, double digits) {
    if (!in_use_) {
      spent_ += iterations;
      iterations_ += iterations;
      digits_ += digits;
      return;
    }
    constexpr double kEnough = 0.3;  // digits that tell something
    if (digits < kEnough) return;
    if (!proven_) {
      rate_ = iterations / digits;
      proven_ = true;
      if (1.25 * rate_ * digits_ > iterations_) give_up();
      return;
    }
    excess_ += iterations > kSlack * rate_ * digits ? iterations - kSlack * rate_ * digits : 0.0;
  }

 private:
  static constexpr double kSlack = 1.2;

  void give_up() {
    in_use_ = false;
    patience_ *= 8.0;
    spent_ = iterations_ = digits_ = 0.0;
  }

  bool in_use_ = false;
  bool proven_ = false;      // its first solve is over
  double rate_ = 0.0;        // iterations a digit of that solve
  double iterations_ = 0.0;  // without one …
  double digits_ = 0.0;      // … for so many digits
  double spent_ = 0.0;       // the same since the last choice
  double excess_ = 0.0;      // iterations above the rate of its first solve
  double patience_ = 1.0;
};

}  // namespace tetraction
