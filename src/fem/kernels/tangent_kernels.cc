#include "tangent_kernels.h"

// Portable, SSE4, AVX2 and AVX-512 (Highway's AVX3).
#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fem/kernels/tangent_kernels.cc"
#include <hwy/foreach_target.h>  // compiles this file once for every instruction set
#include <hwy/highway.h>

#include "simd_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

using D64 = hn::CappedTag<double, 8>;
using V64 = hn::Vec<D64>;

HWY_INLINE void store_number(V64 v, double* to) {
  hn::Store(v, D64(), to);
}
HWY_INLINE void store_number(V64 v, float* to) {
  const hn::Rebind<float, D64> d;
  hn::Store(hn::DemoteTo(d, v), d, to);
}

template <class T>
class StateWriter {
 public:
  explicit StateWriter(T* state) : next_(state) {}
  HWY_INLINE void put(V64 v) {
    store_number(v, next_);
    next_ += kBatchLanes;
  }

 private:
  T* next_;
};

template <MaterialKind kKind, TangentForm kForm, class T>
HWY_NOINLINE void prepare(const BatchView& batches, const IsotropicModuli& constants,
                          const double* HWY_RESTRICT positions, T* HWY_RESTRICT state) {
  const D64 d;
  constexpr size_t kLanes = hn::MaxLanes(D64());
  const V64 mu = hn::Set(d, constants.mu);
  const V64 mu2 = hn::Set(d, constants.mu2);
  const V64 lambda = hn::Set(d, constants.lambda);
  const V64 one = hn::Set(d, 1.0);
  const V64 half = hn::Set(d, 0.5);
  constexpr bool kLogarithmic = kKind != MaterialKind::kStVenantKirchhoff;
  const double* rest = batches.rest;
  const uint16_t* slots = batches.slots;
  for (std::ptrdiff_t b = 0; b < batches.count; ++b) {
    for (size_t lane = 0; lane < kBatchLanes; lane += kLanes) {
      Columns<V64> e;
      RowAccess<D64>::edges(d, positions, slots + lane, kBatchLanes, e);
      Symmetric<V64> vg;
      for (size_t k = 0; k < 6; ++k) vg.m[k] = hn::Load(d, rest + k * kBatchLanes + lane);
      const V64 inverse_six_volume = hn::Load(d, rest + 6 * kBatchLanes + lane);
      const V64 inverse_volume = hn::Mul(inverse_six_volume, hn::Set(d, 6.0));
      const V64 volume = hn::Div(one, inverse_volume);
      Columns<V64> w;
      const V64 det = cofactors(e, w);
      V64 inverse_det = hn::Undefined(d);
      V64 log_j = hn::Zero(d);
      if constexpr (kLogarithmic) {
        log_j = log_and_inverse(d, hn::Mul(det, inverse_six_volume), inverse_det);
        inverse_det = hn::Mul(inverse_det, inverse_six_volume);
      } else {
        inverse_det = hn::Div(one, det);
      }

      Symmetric<V64> stress;
      V64 a1 = hn::Zero(d);
      V64 a2 = hn::Zero(d);
      if constexpr (kKind == MaterialKind::kNeoHookean) {
        for (int k = 0; k < 6; ++k) stress.m[k] = hn::Mul(mu, vg.m[k]);
      } else {
        Symmetric<V64> c;
        metric(e, c);
        Columns<V64> cvg;
        symmetric_times(c, vg, cvg);
        Symmetric<V64> gcg;  // V² G c G
        symmetric_product(vg, cvg, gcg);
        const V64 i1 =
            hn::Mul(hn::Add(cvg.m[0][0], hn::Add(cvg.m[1][1], cvg.m[2][2])), inverse_volume);
        if constexpr (kKind == MaterialKind::kMooneyRivlin) {
          const V64 scale = hn::MulAdd(mu2, i1, mu);
          const V64 back = hn::Mul(mu2, inverse_volume);
          for (int k = 0; k < 6; ++k) {
            stress.m[k] = hn::NegMulAdd(back, gcg.m[k], hn::Mul(scale, vg.m[k]));
          }
          a2 = hn::Mul(mu2, volume);
          a1 = hn::Neg(a2);
        } else {
          // G a G = G c G − G, a:G = I₁ − 3.
          const V64 forward = hn::Mul(mu, inverse_volume);
          const V64 p =
              hn::NegMulAdd(one, mu, hn::Mul(hn::Mul(half, lambda), hn::Sub(i1, hn::Set(d, 3.0))));
          for (int k = 0; k < 6; ++k) {
            stress.m[k] = hn::MulAdd(forward, gcg.m[k], hn::Mul(p, vg.m[k]));
          }
          a1 = hn::Mul(mu, volume);
          a2 = hn::Mul(hn::Mul(half, lambda), volume);
        }
      }
      StateWriter<T> write(state + lane);
      for (int k = 0; k < 6; ++k) write.put(stress.m[k]);
      if constexpr (kForm != TangentForm::kMetric) {
        for (int k = 0; k < 9; ++k) write.put(hn::Mul(w.m[k / 3][k % 3], inverse_det));
        if constexpr (kLogarithmic) {
          const V64 sum = hn::MulAdd(hn::Set(d, 2.0), mu2, mu);
          write.put(hn::Mul(volume, hn::NegMulAdd(lambda, log_j, sum)));
          write.put(hn::Mul(volume, lambda));
        } else {
          write.put(hn::Zero(d));
          write.put(hn::Zero(d));
        }
      }
      if constexpr (kForm != TangentForm::kSpatial) {
        for (int k = 0; k < 9; ++k) write.put(e.m[k / 3][k % 3]);
        for (int k = 0; k < 6; ++k) write.put(hn::Mul(vg.m[k], inverse_volume));
        write.put(a1);
        write.put(a2);
      }
    }
    rest += kRestNumbers * kBatchLanes;
    slots += 4 * kBatchLanes;
    state += tangent_numbers(kForm) * kBatchLanes;
  }
}

// The numbers of the state, lane by lane.
template <class D, TangentForm kForm>
struct State {
  using T = hn::TFromD<D>;
  using V = hn::Vec<D>;
  static constexpr bool kHasSpatial = kForm != TangentForm::kMetric;
  static constexpr bool kHasMetric = kForm != TangentForm::kSpatial;

  Symmetric<V> stress;
  Columns<V> w;
  V k, l;
  Columns<V> e;
  Symmetric<V> g;
  V a1, a2;

  HWY_INLINE State(D d, const T* HWY_RESTRICT at) {
    const auto next = [&]() HWY_ATTR {
      const V v = hn::Load(d, at);
      at += kBatchLanes;
      return v;
    };
    for (int i = 0; i < 6; ++i) stress.m[i] = next();
    if constexpr (kHasSpatial) {
      for (int i = 0; i < 9; ++i) w.m[i / 3][i % 3] = next();
      k = next();
      l = next();
    }
    if constexpr (kHasMetric) {
      for (int i = 0; i < 9; ++i) e.m[i / 3][i % 3] = next();
      for (int i = 0; i < 6; ++i) g.m[i] = next();
      a1 = next();
      a2 = next();
    }
  }
};

template <class V>
HWY_INLINE V dot(const V* a, const V* b) {
  return hn::MulAdd(a[2], b[2], hn::MulAdd(a[1], b[1], hn::Mul(a[0], b[0])));
}

template <TangentForm kForm, class T>
HWY_NOINLINE void apply(const BatchView& batches, const T* HWY_RESTRICT state,
                        const T* HWY_RESTRICT x, T* HWY_RESTRICT result) {
  using D = hn::CappedTag<T, kBatchLanes>;
  using V = hn::Vec<D>;
  const D d;
  constexpr size_t kLanes = hn::MaxLanes(D());
  const uint16_t* slots = batches.slots;
  constexpr size_t kNumbers = tangent_numbers(kForm) * kBatchLanes;
  for (std::ptrdiff_t b = 0; b < batches.count; ++b) {
    prefetch(state + kAhead * kNumbers, kNumbers);
    prefetch(slots + kAhead * 4 * kBatchLanes, 4 * kBatchLanes);
    for (size_t lane = 0; lane < kBatchLanes; lane += kLanes) {
      Columns<V> de;
      RowAccess<D>::edges(d, x, slots + lane, kBatchLanes, de);
      const State<D, kForm> s(d, state + lane);
      Columns<V> force;
      multiply(de, s.stress, force);
      if constexpr (State<D, kForm>::kHasSpatial) {
        for (int j = 0; j < 3; ++j) {
          // k w (deᵀ w) and l (w:de) w: column j takes w_i with the weights (de_i · w_j) k.
          V weight[3];
          for (int i = 0; i < 3; ++i) weight[i] = hn::Mul(s.k, dot(de.m[i], s.w.m[j]));
          for (int i = 0; i < 3; ++i) {
            for (int r = 0; r < 3; ++r) {
              force.m[j][r] = hn::MulAdd(weight[i], s.w.m[i][r], force.m[j][r]);
            }
          }
        }
        const V tr = hn::Add(dot(de.m[0], s.w.m[0]),
                             hn::Add(dot(de.m[1], s.w.m[1]), dot(de.m[2], s.w.m[2])));
        const V p = hn::Mul(s.l, tr);
        for (int j = 0; j < 3; ++j) {
          for (int r = 0; r < 3; ++r) {
            force.m[j][r] = hn::MulAdd(p, s.w.m[j][r], force.m[j][r]);
          }
        }
      }
      if constexpr (State<D, kForm>::kHasMetric) {
        Symmetric<V> dc;
        for (int i = 0; i < 3; ++i) {
          for (int j = i; j < 3; ++j) {
            dc(i, j) = hn::Add(dot(de.m[i], s.e.m[j]), dot(s.e.m[i], de.m[j]));
          }
        }
        Columns<V> dcg;
        symmetric_times(dc, s.g, dcg);
        Symmetric<V> change;
        symmetric_product(s.g, dcg, change);
        const V tr = hn::Add(dcg.m[0][0], hn::Add(dcg.m[1][1], dcg.m[2][2]));
        const V p = hn::Mul(s.a2, tr);
        for (int k = 0; k < 6; ++k) {
          change.m[k] = hn::MulAdd(s.a1, change.m[k], hn::Mul(p, s.g.m[k]));
        }
        Columns<V> more;
        multiply(s.e, change, more);
        for (int k = 0; k < 9; ++k) {
          force.m[k / 3][k % 3] = hn::Add(force.m[k / 3][k % 3], more.m[k / 3][k % 3]);
        }
      }
      RowAccess<D>::add_balanced(d, force, result, slots + lane, kBatchLanes);
    }
    slots += 4 * kBatchLanes;
    state += tangent_numbers(kForm) * kBatchLanes;
  }
}

// With γ the node's column of (−1 1 0 0; −1 0 1 0; −1 0 0 1), its diagonal block is
// (γᵀTγ) I + (k + l) w_γ w_γᵀ + (a₁ + 2a₂) z zᵀ + a₁ (γᵀGγ) e G eᵀ, w_γ = wγ, z = eGγ.
template <TangentForm kForm, class T>
HWY_NOINLINE void diagonal_blocks(const BatchView& batches, const T* HWY_RESTRICT state,
                                  T* HWY_RESTRICT diagonal, T* HWY_RESTRICT off_diagonal) {
  using D = hn::CappedTag<T, kBatchLanes>;
  using V = hn::Vec<D>;
  const D d;
  constexpr size_t kLanes = hn::MaxLanes(D());
  HWY_ALIGN T block[6][kBatchLanes];
  const uint16_t* slots = batches.slots;
  for (std::ptrdiff_t b = 0; b < batches.count; ++b) {
    for (size_t lane = 0; lane < kBatchLanes; lane += kLanes) {
      const State<D, kForm> s(d, state + lane);
      Columns<V> eg;
      Symmetric<V> ege;
      if constexpr (State<D, kForm>::kHasMetric) {
        multiply(s.e, s.g, eg);
        for (int i = 0; i < 3; ++i) {
          for (int j = i; j < 3; ++j) {
            ege(i, j) =
                hn::MulAdd(eg.m[2][i], s.e.m[2][j],
                           hn::MulAdd(eg.m[1][i], s.e.m[1][j], hn::Mul(eg.m[0][i], s.e.m[0][j])));
          }
        }
      }
      const auto total = [&](const Symmetric<V>& m) HWY_ATTR {
        const V off = hn::Add(m.m[1], hn::Add(m.m[2], m.m[4]));
        return hn::Add(hn::Add(m.m[0], hn::Add(m.m[3], m.m[5])), hn::Add(off, off));
      };
      for (int node = 0; node < 4; ++node) {
        V parts[6];
        const V on = node == 0 ? total(s.stress) : s.stress(node - 1, node - 1);
        for (int i = 0; i < 3; ++i) {
          parts[i] = on;
          parts[3 + i] = hn::Zero(d);
        }
        const auto add_outer = [&](const Columns<V>& columns, V factor) HWY_ATTR {
          V v[3];
          for (int i = 0; i < 3; ++i) {
            v[i] = node == 0 ? hn::Add(columns.m[0][i], hn::Add(columns.m[1][i], columns.m[2][i]))
                             : columns.m[node == 0 ? 0 : node - 1][i];
          }
          for (int i = 0; i < 3; ++i) {
            const V scaled = hn::Mul(factor, v[i]);
            parts[i] = hn::MulAdd(scaled, v[i], parts[i]);
            for (int j = i + 1; j < 3; ++j) {
              parts[2 + i + j] = hn::MulAdd(scaled, v[j], parts[2 + i + j]);
            }
          }
        };
        if constexpr (State<D, kForm>::kHasSpatial) add_outer(s.w, hn::Add(s.k, s.l));
        if constexpr (State<D, kForm>::kHasMetric) {
          add_outer(eg, hn::Add(s.a1, hn::Add(s.a2, s.a2)));
          const V factor = hn::Mul(s.a1, node == 0 ? total(s.g) : s.g(node - 1, node - 1));
          for (int i = 0; i < 3; ++i) {
            parts[i] = hn::MulAdd(factor, ege(i, i), parts[i]);
            for (int j = i + 1; j < 3; ++j) {
              parts[2 + i + j] = hn::MulAdd(factor, ege(i, j), parts[2 + i + j]);
            }
          }
        }
        for (int k = 0; k < 6; ++k) hn::Store(parts[k], d, block[k]);
        const uint16_t* slot = slots + static_cast<size_t>(node) * kBatchLanes + lane;
        for (size_t i = 0; i < kLanes; ++i) {
          for (size_t k = 0; k < 3; ++k) {
            diagonal[slot[i] + k] += block[k][i];
            off_diagonal[slot[i] + k] += block[3 + k][i];
          }
        }
      }
    }
    slots += 4 * kBatchLanes;
    state += tangent_numbers(kForm) * kBatchLanes;
  }
}

// The block of nodes a and b is
// (γ_aᵀTγ_b) I + k w_b w_aᵀ + l w_a w_bᵀ + a₁ (z_b z_aᵀ + (γ_aᵀGγ_b) e G eᵀ) + 2a₂ z_a z_bᵀ;
// those of node 0 follow from the others, as rigid translations cost nothing.
template <TangentForm kForm>
HWY_NOINLINE void stiffness(const double* HWY_RESTRICT state, double* HWY_RESTRICT matrices) {
  using D = D64;
  using V = V64;
  const D d;
  constexpr size_t kLanes = hn::MaxLanes(D());
  for (size_t lane = 0; lane < kBatchLanes; lane += kLanes) {
    const State<D, kForm> s(d, state + lane);
    Columns<V> z;
    Symmetric<V> ege;
    if constexpr (State<D, kForm>::kHasMetric) {
      multiply(s.e, s.g, z);
      for (int i = 0; i < 3; ++i) {
        for (int j = i; j < 3; ++j) {
          ege(i, j) =
              hn::MulAdd(z.m[2][i], s.e.m[2][j],
                         hn::MulAdd(z.m[1][i], s.e.m[1][j], hn::Mul(z.m[0][i], s.e.m[0][j])));
        }
      }
    }
    const auto block = [&](int a, int b, V* out) HWY_ATTR {  // nodes a + 1, b + 1
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
          V sum = r == c ? s.stress(a, b) : hn::Zero(d);
          if constexpr (State<D, kForm>::kHasSpatial) {
            sum = hn::MulAdd(hn::Mul(s.k, s.w.m[b][r]), s.w.m[a][c], sum);
            sum = hn::MulAdd(hn::Mul(s.l, s.w.m[a][r]), s.w.m[b][c], sum);
          }
          if constexpr (State<D, kForm>::kHasMetric) {
            const V first = hn::MulAdd(z.m[b][r], z.m[a][c], hn::Mul(s.g(a, b), ege(r, c)));
            sum = hn::MulAdd(s.a1, first, sum);
            sum = hn::MulAdd(hn::Mul(hn::Add(s.a2, s.a2), z.m[a][r]), z.m[b][c], sum);
          }
          out[3 * r + c] = sum;
        }
      }
    };
    const auto store = [&](int number, V v) HWY_ATTR {
      hn::Store(v, d, matrices + static_cast<size_t>(number * kBatchLanes) + lane);
    };
    const auto store_diagonal = [&](int node, const V* b) HWY_ATTR {
      constexpr int kUpper[6] = {0, 1, 2, 4, 5, 8};
      for (int k = 0; k < 6; ++k) store(6 * node + k, b[kUpper[k]]);
    };
    V zero[4][9];  // rows of node 0
    for (auto& row : zero) {
      for (V& v : row) v = hn::Zero(d);
    }
    int pair = 3;
    for (int a = 0; a < 3; ++a) {
      V b[9];
      block(a, a, b);
      store_diagonal(a + 1, b);
      for (int k = 0; k < 9; ++k) zero[a + 1][k] = hn::Sub(zero[a + 1][k], b[k]);
      for (int c = a + 1; c < 3; ++c, ++pair) {
        block(a, c, b);
        for (int k = 0; k < 9; ++k) {
          store(24 + 9 * pair + k, b[k]);
          zero[c + 1][k] = hn::Sub(zero[c + 1][k], b[k]);
          zero[a + 1][k] = hn::Sub(zero[a + 1][k], b[3 * (k % 3) + k / 3]);  // K_ca = K_acᵀ
        }
      }
    }
    for (int c = 1; c < 4; ++c) {
      for (int k = 0; k < 9; ++k) {
        store(24 + 9 * (c - 1) + k, zero[c][k]);
        zero[0][k] = hn::Sub(zero[0][k], zero[c][k]);
      }
    }
    store_diagonal(0, zero[0]);
  }
}

template <TangentForm kForm, class T>
HWY_NOINLINE bool is_safe(const BatchView& batches, const T* HWY_RESTRICT state,
                          const T* HWY_RESTRICT x) {
  using D = hn::CappedTag<T, kBatchLanes>;
  using V = hn::Vec<D>;
  const D d;
  constexpr size_t kLanes = hn::MaxLanes(D());
  const uint16_t* slots = batches.slots;
  const V zero = hn::Zero(d);
  for (std::ptrdiff_t b = 0; b < batches.count; ++b) {
    for (size_t lane = 0; lane < kBatchLanes; lane += kLanes) {
      Columns<V> de;
      RowAccess<D>::edges(d, x, slots + lane, kBatchLanes, de);
      const State<D, kForm> s(d, state + lane);
      Columns<V> p;
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) p.m[i][j] = dot(de.m[i], s.w.m[j]);
      }
      Columns<V> cofactor;
      const V third = cofactors(p, cofactor);
      const V first = hn::Add(p.m[0][0], hn::Add(p.m[1][1], p.m[2][2]));
      const V second = hn::Add(cofactor.m[0][0], hn::Add(cofactor.m[1][1], cofactor.m[2][2]));
      const auto loss = [&](V v) HWY_ATTR {  // NaN stays NaN
        return hn::IfThenElse(hn::Gt(v, zero), zero, v);
      };
      const V least = hn::Add(loss(first), hn::Add(loss(second), loss(third)));
      if (!hn::AllTrue(d, hn::Gt(least, hn::Set(d, T(-0.9))))) return false;
    }
    slots += 4 * kBatchLanes;
    state += tangent_numbers(kForm) * kBatchLanes;
  }
  return true;
}

template <class T>
void prepare_kind(const BatchView& batches, const IsotropicModuli& moduli, TangentForm form,
                  const double* positions, T* state) {
  if (moduli.kind == MaterialKind::kNeoHookean) {
    if (form == TangentForm::kSpatial) {
      prepare<MaterialKind::kNeoHookean, TangentForm::kSpatial>(batches, moduli, positions, state);
    } else {
      prepare<MaterialKind::kNeoHookean, TangentForm::kBoth>(batches, moduli, positions, state);
    }
  } else if (moduli.kind == MaterialKind::kMooneyRivlin) {
    prepare<MaterialKind::kMooneyRivlin, TangentForm::kBoth>(batches, moduli, positions, state);
  } else {
    prepare<MaterialKind::kStVenantKirchhoff, TangentForm::kMetric>(batches, moduli, positions,
                                                                    state);
  }
}

template <class T>
void apply_form(const BatchView& batches, TangentForm form, const T* state, const T* x, T* result) {
  if (form == TangentForm::kSpatial) {
    apply<TangentForm::kSpatial>(batches, state, x, result);
  } else if (form == TangentForm::kMetric) {
    apply<TangentForm::kMetric>(batches, state, x, result);
  } else {
    apply<TangentForm::kBoth>(batches, state, x, result);
  }
}

template <class T>
void diagonal_form(const BatchView& batches, TangentForm form, const T* state, T* diagonal,
                   T* off_diagonal) {
  if (form == TangentForm::kSpatial) {
    diagonal_blocks<TangentForm::kSpatial>(batches, state, diagonal, off_diagonal);
  } else if (form == TangentForm::kMetric) {
    diagonal_blocks<TangentForm::kMetric>(batches, state, diagonal, off_diagonal);
  } else {
    diagonal_blocks<TangentForm::kBoth>(batches, state, diagonal, off_diagonal);
  }
}

template <class T>
bool safe_form(const BatchView& batches, TangentForm form, const T* state, const T* x) {
  return form == TangentForm::kBoth ? is_safe<TangentForm::kBoth>(batches, state, x)
                                    : is_safe<TangentForm::kSpatial>(batches, state, x);
}

void stiffness_form(TangentForm form, const double* state, double* matrices) {
  if (form == TangentForm::kSpatial) {
    stiffness<TangentForm::kSpatial>(state, matrices);
  } else if (form == TangentForm::kMetric) {
    stiffness<TangentForm::kMetric>(state, matrices);
  } else {
    stiffness<TangentForm::kBoth>(state, matrices);
  }
}

// Names without overloads, for dispatch.
void prepare_float(const BatchView& b, const IsotropicModuli& m, TangentForm f, const double* q,
                   float* s) {
  prepare_kind(b, m, f, q, s);
}
void prepare_double(const BatchView& b, const IsotropicModuli& m, TangentForm f, const double* q,
                    double* s) {
  prepare_kind(b, m, f, q, s);
}
void apply_float(const BatchView& b, TangentForm f, const float* s, const float* x, float* y) {
  apply_form(b, f, s, x, y);
}
void apply_double(const BatchView& b, TangentForm f, const double* s, const double* x, double* y) {
  apply_form(b, f, s, x, y);
}
void diagonal_float(const BatchView& b, TangentForm f, const float* s, float* on, float* off) {
  diagonal_form(b, f, s, on, off);
}
void diagonal_double(const BatchView& b, TangentForm f, const double* s, double* on, double* off) {
  diagonal_form(b, f, s, on, off);
}
bool safe_float(const BatchView& b, TangentForm f, const float* s, const float* x) {
  return safe_form(b, f, s, x);
}
bool safe_double(const BatchView& b, TangentForm f, const double* s, const double* x) {
  return safe_form(b, f, s, x);
}

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tetraction {

HWY_EXPORT(prepare_float);
HWY_EXPORT(prepare_double);
HWY_EXPORT(apply_float);
HWY_EXPORT(apply_double);
HWY_EXPORT(diagonal_float);
HWY_EXPORT(diagonal_double);
HWY_EXPORT(stiffness_form);
HWY_EXPORT(safe_float);
HWY_EXPORT(safe_double);

void prepare_tangent(const BatchView& batches, const IsotropicModuli& moduli, TangentForm form,
                     const double* positions, float* state) {
  HWY_DYNAMIC_DISPATCH(prepare_float)(batches, moduli, form, positions, state);
}
void prepare_tangent(const BatchView& batches, const IsotropicModuli& moduli, TangentForm form,
                     const double* positions, double* state) {
  HWY_DYNAMIC_DISPATCH(prepare_double)(batches, moduli, form, positions, state);
}
void apply_tangent(const BatchView& batches, TangentForm form, const float* state, const float* x,
                   float* result) {
  HWY_DYNAMIC_DISPATCH(apply_float)(batches, form, state, x, result);
}
void apply_tangent(const BatchView& batches, TangentForm form, const double* state, const double* x,
                   double* result) {
  HWY_DYNAMIC_DISPATCH(apply_double)(batches, form, state, x, result);
}
void add_tangent_diagonal(const BatchView& batches, TangentForm form, const float* state,
                          float* diagonal, float* off_diagonal) {
  HWY_DYNAMIC_DISPATCH(diagonal_float)(batches, form, state, diagonal, off_diagonal);
}
void add_tangent_diagonal(const BatchView& batches, TangentForm form, const double* state,
                          double* diagonal, double* off_diagonal) {
  HWY_DYNAMIC_DISPATCH(diagonal_double)(batches, form, state, diagonal, off_diagonal);
}
void tangent_stiffness(TangentForm form, const double* state, double* matrices) {
  HWY_DYNAMIC_DISPATCH(stiffness_form)(form, state, matrices);
}
bool tangent_step_is_safe(const BatchView& batches, TangentForm form, const float* state,
                          const float* x) {
  return HWY_DYNAMIC_DISPATCH(safe_float)(batches, form, state, x);
}
bool tangent_step_is_safe(const BatchView& batches, TangentForm form, const double* state,
                          const double* x) {
  return HWY_DYNAMIC_DISPATCH(safe_double)(batches, form, state, x);
}

}  // namespace tetraction
#endif
