// Templates of the tangent kernels, for one instruction set. Included by Highway once for each.
#if defined(TETRACTION_FEM_TANGENT_KERNELS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_FEM_TANGENT_KERNELS_INL_H_
#undef TETRACTION_FEM_TANGENT_KERNELS_INL_H_
#else
#define TETRACTION_FEM_TANGENT_KERNELS_INL_H_
#endif

#include "material/laws/laws-inl.h"
#include "simd_records-inl.h"
#include "tangent_kernels.h"

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

// The form of a material alone.
template <class M>
constexpr TangentForm form_of() {
  using Terms = TermsOf<M>;
  if constexpr (Terms::kStrain) {
    return TangentForm::kMetric;
  } else {
    TangentForm form = TangentForm::kSpatial;
    if (Terms::kI2) form = form | TangentForm::kMetric;
    if (Terms::kI1Coupled) form = form | TangentForm::kCoupled;
    if (Terms::kI2Coupled) form = form | TangentForm::kCoupledI2;
    return form;
  }
}

// factor × volume × derivative.
template <class N, class T>
HWY_INLINE N scaled(double factor, N volume, T derivative) {
  if constexpr (kIsZero<T>) {
    return N(0.0);
  } else {
    return volume * (N(factor) * derivative);
  }
}

template <class M, TangentForm kForm, class T>
HWY_NOINLINE void prepare(const BatchView& batches, const M& constants,
                          const double* HWY_RESTRICT positions, T* HWY_RESTRICT state) {
  using N = Number<D64>;
  using Terms = TermsOf<M>;
  const D64 d;
  const M material = constants;
  for_each_vector<D64>(batches, [&](size_t b, size_t lane, const double* HWY_RESTRICT rest,
                                    const uint16_t* HWY_RESTRICT slots) TETRACTION_LOOP_BODY {
    Columns<V64> e;
    RecordAccess<D64>::edges(d, positions, slots, kBatchLanes, e);
    Symmetric<V64> vg;
    for (size_t k = 0; k < 6; ++k) vg.m[k] = hn::Load(d, rest + k * kBatchLanes);
    const V64 inverse_six_volume = hn::Load(d, rest + 6 * kBatchLanes);
    const V64 inverse_volume = hn::Mul(inverse_six_volume, hn::Set(d, 6.0));
    const N volume(hn::Div(hn::Set(d, 1.0), inverse_volume));
    Symmetric<V64> c;
    metric(e, c);
    Columns<V64> cvg;
    symmetric_times(c, vg, cvg);
    Symmetric<V64> gcg;  // V² G c G
    symmetric_product(vg, cvg, gcg);
    const V64 i1 = hn::Mul(hn::Add(cvg.m[0][0], hn::Add(cvg.m[1][1], cvg.m[2][2])), inverse_volume);

    StateWriter<T> write(state + tangent_numbers(kForm) * kBatchLanes * b + lane);
    Symmetric<V64> stress;
    N a1 = 0.0;
    N a2 = 0.0;
    const auto write_metric = [&]() HWY_ATTR {
      for (int k = 0; k < 9; ++k) write.put(e.m[k / 3][k % 3]);
      for (int k = 0; k < 6; ++k) write.put(hn::Mul(vg.m[k], inverse_volume));
      write.put(a1.v);
      write.put(a2.v);
    };
    if constexpr (Terms::kStrain) {
      const StrainMeasures<N> given{N(i1) - N(3.0), N(0.0)};
      const N twice_i2 = N(2.0) * Law<M>::first(material, given).i2;
      // G a G = G c G − G.
      const V64 forward = hn::Mul((-twice_i2).v, inverse_volume);
      const V64 p = (N(2.0) * Law<M>::spherical(material, given) + twice_i2).v;
      for (int k = 0; k < 6; ++k) {
        stress.m[k] = hn::MulAdd(forward, gcg.m[k], hn::Mul(p, vg.m[k]));
      }
      a1 = -twice_i2 * volume;
      a2 = (twice_i2 + N(2.0) * Law<M>::second(material, given).i1_i1) * volume;
      for (int k = 0; k < 6; ++k) write.put(stress.m[k]);
      write_metric();
    } else {
      Columns<V64> w;
      const V64 det = cofactors(e, w);
      const V64 j = hn::Mul(det, inverse_six_volume);
      V64 inverse_det;
      const N log_j(log_and_inverse(d, j, inverse_det));
      inverse_det = hn::Mul(inverse_det, inverse_six_volume);
      V64 square = hn::Zero(d);  // V² tr C²
      if constexpr (Terms::kI2) square = trace_of_square(d, cvg);
      const V64 i2 =
          hn::Mul(hn::Set(d, 0.5),
                  hn::NegMulAdd(square, hn::Mul(inverse_volume, inverse_volume), hn::Mul(i1, i1)));
      const Invariants<N> given{N(i1),
                                N(i1) - mul_add(N(2.0), log_j, N(3.0)),
                                N(i2) - mul_add(N(4.0), log_j, N(3.0)),
                                log_j,
                                N(j),
                                N(j) - N(1.0)};
      const auto first = Law<M>::first(material, given);
      const auto second = Law<M>::second(material, given);
      const N twice_i1 = N(2.0) * first.i1;
      if constexpr (Terms::kI2) {
        const N twice_i2 = N(2.0) * first.i2;
        const V64 scale = hn::MulAdd(twice_i2.v, i1, twice_i1.v);
        const V64 back = hn::Mul(twice_i2.v, inverse_volume);
        for (int k = 0; k < 6; ++k) {
          stress.m[k] = hn::NegMulAdd(back, gcg.m[k], hn::Mul(scale, vg.m[k]));
        }
        a1 = -(twice_i2 * volume);
        a2 = twice_i2 * volume + scaled(2.0, volume, second.i1_i1);
      } else {
        for (int k = 0; k < 6; ++k) stress.m[k] = hn::Mul(twice_i1.v, vg.m[k]);
      }
      for (int k = 0; k < 6; ++k) write.put(stress.m[k]);
      for (int k = 0; k < 9; ++k) write.put(hn::Mul(w.m[k / 3][k % 3], inverse_det));
      write.put((-(volume * first.log_j)).v);
      write.put(scaled(1.0, volume, second.log_j_log_j).v);
      if constexpr (has(kForm, TangentForm::kMetric)) write_metric();
      if constexpr (has(kForm, TangentForm::kCoupled)) {
        Columns<V64> z;
        multiply(e, vg, z);
        for (int k = 0; k < 9; ++k) write.put(hn::Mul(z.m[k / 3][k % 3], inverse_volume));
        if constexpr (Terms::kI2) {
          write.put(hn::Zero(d));  // Ψ₁₁ is in a₂
        } else {
          write.put(scaled(4.0, volume, second.i1_i1).v);
        }
        write.put(scaled(2.0, volume, second.i1_log_j).v);
      }
      if constexpr (has(kForm, TangentForm::kCoupledI2)) {
        Symmetric<V64> inner;  // I₁ G − G c G
        for (int k = 0; k < 6; ++k) {
          inner.m[k] = hn::Mul(inverse_volume,
                               hn::NegMulAdd(inverse_volume, gcg.m[k], hn::Mul(i1, vg.m[k])));
        }
        Columns<V64> gradient;
        multiply(e, inner, gradient);
        for (int k = 0; k < 9; ++k) write.put(gradient.m[k / 3][k % 3]);
        write.put(scaled(4.0, volume, second.i2_i2).v);
        write.put(scaled(4.0, volume, second.i1_i2).v);
        write.put(scaled(2.0, volume, second.i2_log_j).v);
      }
    }
  });
}

// The numbers of the state, lane by lane.
template <class D, TangentForm kForm>
struct State {
  using T = hn::TFromD<D>;
  using V = hn::Vec<D>;
  static constexpr bool kHasSpatial = has(kForm, TangentForm::kSpatial);
  static constexpr bool kHasMetric = has(kForm, TangentForm::kMetric);
  static constexpr bool kHasCoupled = has(kForm, TangentForm::kCoupled);
  static constexpr bool kHasCoupledI2 = has(kForm, TangentForm::kCoupledI2);

  Symmetric<V> stress;
  Columns<V> w;
  V k, l;
  Columns<V> e;
  Symmetric<V> g;
  V a1, a2;
  Columns<V> z;
  V s_zz, s_zw;
  Columns<V> b;
  V s_bb, s_zb, s_wb;

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
    if constexpr (kHasCoupled) {
      for (int i = 0; i < 9; ++i) z.m[i / 3][i % 3] = next();
      s_zz = next();
      s_zw = next();
    }
    if constexpr (kHasCoupledI2) {
      for (int i = 0; i < 9; ++i) b.m[i / 3][i % 3] = next();
      s_bb = next();
      s_zb = next();
      s_wb = next();
    }
  }
};

template <class V>
HWY_INLINE V dot(const V* a, const V* b) {
  return hn::MulAdd(a[2], b[2], hn::MulAdd(a[1], b[1], hn::Mul(a[0], b[0])));
}

// force += factor v.
template <class V>
HWY_INLINE void add_scaled(V factor, const Columns<V>& v, Columns<V>& force) {
  for (int k = 0; k < 9; ++k) {
    force.m[k / 3][k % 3] = hn::MulAdd(factor, v.m[k / 3][k % 3], force.m[k / 3][k % 3]);
  }
}

template <class V>
HWY_INLINE V inner_product(const Columns<V>& a, const Columns<V>& b) {
  return hn::Add(dot(a.m[0], b.m[0]), hn::Add(dot(a.m[1], b.m[1]), dot(a.m[2], b.m[2])));
}

template <TangentForm kForm, class T>
HWY_NOINLINE void apply(const BatchView& batches, const T* HWY_RESTRICT state,
                        const T* HWY_RESTRICT x, T* HWY_RESTRICT result) {
  using D = hn::CappedTag<T, kBatchLanes>;
  using V = hn::Vec<D>;
  using S = State<D, kForm>;
  const D d;
  constexpr size_t kNumbers = tangent_numbers(kForm) * kBatchLanes;
  const auto ahead = [&](size_t b)
                         HWY_ATTR { prefetch(state + (b + kAhead) * kNumbers, kNumbers); };
  for_each_vector<D>(
      batches, ahead,
      [&](size_t b, size_t lane, const double*, const uint16_t* HWY_RESTRICT slots)
          TETRACTION_LOOP_BODY {
            Columns<V> de;
            RecordAccess<D>::edges(d, x, slots, kBatchLanes, de);
            const S s(d, state + b * kNumbers + lane);
            Columns<V> force;
            multiply(de, s.stress, force);
            if constexpr (S::kHasSpatial) {
              for (int j = 0; j < 3; ++j) {
                // k w (deᵀ w): column j takes w_i with the weights (de_i · w_j) k.
                V weight[3];
                for (int i = 0; i < 3; ++i) weight[i] = hn::Mul(s.k, dot(de.m[i], s.w.m[j]));
                for (int i = 0; i < 3; ++i) {
                  for (int r = 0; r < 3; ++r) {
                    force.m[j][r] = hn::MulAdd(weight[i], s.w.m[i][r], force.m[j][r]);
                  }
                }
              }
              // The couplings, v_i with the weight Σ_j s_ij (v_j:de).
              const V along_w = inner_product(de, s.w);
              V w_weight = hn::Mul(s.l, along_w);
              if constexpr (S::kHasCoupled) {
                const V along_z = inner_product(de, s.z);
                w_weight = hn::MulAdd(s.s_zw, along_z, w_weight);
                V z_weight = hn::MulAdd(s.s_zw, along_w, hn::Mul(s.s_zz, along_z));
                if constexpr (S::kHasCoupledI2) {
                  const V along_b = inner_product(de, s.b);
                  w_weight = hn::MulAdd(s.s_wb, along_b, w_weight);
                  z_weight = hn::MulAdd(s.s_zb, along_b, z_weight);
                  const V b_weight = hn::MulAdd(
                      s.s_wb, along_w, hn::MulAdd(s.s_zb, along_z, hn::Mul(s.s_bb, along_b)));
                  add_scaled(b_weight, s.b, force);
                }
                add_scaled(z_weight, s.z, force);
              }
              add_scaled(w_weight, s.w, force);
            }
            if constexpr (S::kHasMetric) {
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
            RecordAccess<D>::add_balanced(d, force, result, slots, kBatchLanes);
          });
}

// With γ the node's column of (−1 1 0 0; −1 0 1 0; −1 0 0 1), its diagonal block is
// (γᵀTγ) I + k w_γ w_γᵀ + Σ s_ij v_i v_jᵀ + (a₁ + 2a₂) z zᵀ + a₁ (γᵀGγ) e G eᵀ, v_γ = vγ, z = eGγ.
template <TangentForm kForm, class T>
HWY_NOINLINE void diagonal_blocks(const BatchView& batches, const T* HWY_RESTRICT state,
                                  T* HWY_RESTRICT diagonal, T* HWY_RESTRICT off_diagonal) {
  using D = hn::CappedTag<T, kBatchLanes>;
  using V = hn::Vec<D>;
  const D d;
  constexpr size_t kLanes = hn::MaxLanes(D());
  constexpr size_t kNumbers = tangent_numbers(kForm) * kBatchLanes;
  HWY_ALIGN T block[6][kBatchLanes];
  for_each_vector<D>(
      batches, [](size_t) {},
      [&](size_t b, size_t lane, const double*,
          const uint16_t* HWY_RESTRICT slots) TETRACTION_LOOP_BODY {
        const State<D, kForm> s(d, state + b * kNumbers + lane);
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
          // factor (u vᵀ + v uᵀ)
          const auto add_mixed = [&](const Columns<V>& left, const Columns<V>& right,
                                     V factor) HWY_ATTR {
            V u[3];
            V v[3];
            for (int i = 0; i < 3; ++i) {
              const auto of_node = [&](const Columns<V>& m) HWY_ATTR {
                return node == 0 ? hn::Add(m.m[0][i], hn::Add(m.m[1][i], m.m[2][i]))
                                 : m.m[node == 0 ? 0 : node - 1][i];
              };
              u[i] = of_node(left);
              v[i] = of_node(right);
            }
            for (int i = 0; i < 3; ++i) {
              const V first = hn::Mul(factor, u[i]);
              const V second = hn::Mul(factor, v[i]);
              parts[i] = hn::MulAdd(hn::Add(first, first), v[i], parts[i]);
              for (int j = i + 1; j < 3; ++j) {
                V& part = parts[2 + i + j];
                part = hn::MulAdd(first, v[j], hn::MulAdd(second, u[j], part));
              }
            }
          };
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
          if constexpr (State<D, kForm>::kHasCoupled) {
            add_outer(s.z, s.s_zz);
            add_mixed(s.w, s.z, s.s_zw);
          }
          if constexpr (State<D, kForm>::kHasCoupledI2) {
            add_outer(s.b, s.s_bb);
            add_mixed(s.z, s.b, s.s_zb);
            add_mixed(s.w, s.b, s.s_wb);
          }
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
          const uint16_t* slot = slots + static_cast<size_t>(node) * kBatchLanes;
          for (size_t i = 0; i < kLanes; ++i) {
            for (size_t k = 0; k < 3; ++k) {
              diagonal[slot[i] + k] += block[k][i];
              off_diagonal[slot[i] + k] += block[3 + k][i];
            }
          }
        }
      });
}

// The block of nodes a and b is
// (γ_aᵀTγ_b) I + k w_b w_aᵀ + Σ s_ij v_i,a v_j,bᵀ + a₁ (z_b z_aᵀ + (γ_aᵀGγ_b) e G eᵀ) + 2a₂ z_a
// z_bᵀ; the blocks of node 0 follow from the others, because rigid translations cause no force.
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
          const auto add_mixed = [&](V factor, const Columns<V>& u, const Columns<V>& v) HWY_ATTR {
            sum = hn::MulAdd(hn::Mul(factor, u.m[a][r]), v.m[b][c], sum);
            sum = hn::MulAdd(hn::Mul(factor, v.m[a][r]), u.m[b][c], sum);
          };
          if constexpr (State<D, kForm>::kHasCoupled) {
            sum = hn::MulAdd(hn::Mul(s.s_zz, s.z.m[a][r]), s.z.m[b][c], sum);
            add_mixed(s.s_zw, s.w, s.z);
          }
          if constexpr (State<D, kForm>::kHasCoupledI2) {
            sum = hn::MulAdd(hn::Mul(s.s_bb, s.b.m[a][r]), s.b.m[b][c], sum);
            add_mixed(s.s_zb, s.z, s.b);
            add_mixed(s.s_wb, s.w, s.b);
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

template <class T>
HWY_NOINLINE bool is_safe(const BatchView& batches, TangentForm form, const T* HWY_RESTRICT state,
                          const T* HWY_RESTRICT x) {
  using D = hn::CappedTag<T, kBatchLanes>;
  using V = hn::Vec<D>;
  const D d;
  const V zero = hn::Zero(d);
  const auto numbers = static_cast<size_t>(tangent_numbers(form)) * kBatchLanes;
  bool safe = true;
  for_each_vector<D>(
      batches, [](size_t) {},
      [&](size_t b, size_t lane, const double*, const uint16_t* HWY_RESTRICT slots)
          TETRACTION_LOOP_BODY {
            if (!safe) return;
            Columns<V> de;
            RecordAccess<D>::edges(d, x, slots, kBatchLanes, de);
            const T* w = state + b * numbers + lane + 6 * kBatchLanes;
            Columns<V> p;
            for (int j = 0; j < 3; ++j) {
              V column[3];
              for (int i = 0; i < 3; ++i) column[i] = hn::Load(d, w + (3 * j + i) * kBatchLanes);
              for (int i = 0; i < 3; ++i) p.m[i][j] = dot(de.m[i], column);
            }
            Columns<V> cofactor;
            const V third = cofactors(p, cofactor);
            const V first = hn::Add(p.m[0][0], hn::Add(p.m[1][1], p.m[2][2]));
            const V second = hn::Add(cofactor.m[0][0], hn::Add(cofactor.m[1][1], cofactor.m[2][2]));
            const auto loss = [&](V v) HWY_ATTR {  // NaN stays NaN
              return hn::IfThenElse(hn::Gt(v, zero), zero, v);
            };
            const V least = hn::Add(loss(first), hn::Add(loss(second), loss(third)));
            safe = hn::AllTrue(d, hn::Gt(least, hn::Set(d, T(-0.9))));
          });
  return safe;
}

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
