// When a second level pays for itself in conjugate gradients.
#pragma once

namespace tetraction {

/// Decides when to make a coarse space (coarse_space.h), when to make it anew, and when to do without,
/// from numbers of iterations only, so that a run repeats itself bitwise.
///
/// One is made as soon as the iterations without it have cost as much as it does (so that waiting
/// never costs more than twice the best choice), and given up if it spares less than a fifth of them:
/// then the next try waits eight times as long. It is made anew when the iterations beyond the rate
/// of its first solve have cost as much as a new one.
class CoarseChoice {
 public:
  /// What making a coarse space costs, in iterations of conjugate gradients.
  static constexpr double kPrice = 25.0;

  bool in_use() const { return in_use_; }
  /// Whether to make one (anew) now, `iterations` into a solve.
  bool should_make(int iterations) const {
    return in_use_ ? iterations == 0 && regret_ > kPrice : spent_ + iterations > patience_ * kPrice;
  }
  /// One was made; false: its matrix has no factor. `iterations` and `digits` of the solve so far.
  void made(bool usable, int iterations, double digits) {
    if (!in_use_) solved(iterations, digits);
    in_use_ = usable;
    proven_ = false;
    regret_ = 0.0;
    if (!usable) give_up();
  }
  /// After a solve (or the part of it with the coarse space) that gained so many decimal digits.
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
    regret_ += iterations > kSlack * rate_ * digits ? iterations - kSlack * rate_ * digits : 0.0;
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
  double regret_ = 0.0;
  double patience_ = 1.0;
};

}  // namespace tetraction
