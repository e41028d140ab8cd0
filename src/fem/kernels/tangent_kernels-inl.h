// Templates of the tangent kernels. Highway includes this file once for each instruction set.
#if defined(TETRACTION_FEM_TANGENT_KERNELS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_FEM_TANGENT_KERNELS_INL_H_
#undef TETRACTION_FEM_TANGENT_KERNELS_INL_H_
#else
#define TETRACTION_FEM_TANGENT_KERNELS_INL_H_
#endif

#include "tangent_state-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

// The state of the elements in the lanes, with the names of tangent_kernels.h.
template <class Tag, TangentForm kForm>
struct State {
  using T = hn::TFromD<Tag>;
  using Vec = hn::Vec<Tag>;
  static constexpr bool kHasSpatial = has(kForm, TangentForm::kSpatial);
  static constexpr bool kHasMetric = has(kForm, TangentForm::kMetric);
  static constexpr bool kHasCoupled = has(kForm, TangentForm::kCoupled);
  static constexpr bool kHasCoupledI2 = has(kForm, TangentForm::kCoupledI2);
  static constexpr bool kHasPrincipal = has(kForm, TangentForm::kPrincipal);

  Symmetric<Vec> stress;
  Columns<Vec> w;
  Vec k, l;
  Columns<Vec> e;
  Symmetric<Vec> g;
  Vec a1, a2;
  Columns<Vec> z;
  Vec s_zz, s_zw;
  Columns<Vec> b;
  Vec s_bb, s_zb, s_wb;
  Columns<Vec> y_i;  // yᵢ, bᵢ
  Columns<Vec> b_i;
  PrincipalTangent<Number<Tag>> principal;  // times V

  HWY_INLINE State(Tag tag, const T* HWY_RESTRICT at) {
    const auto next = [&]() HWY_ATTR {
      const Vec v = hn::Load(tag, at);
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
    if constexpr (kHasPrincipal) {
      for (int i = 0; i < 9; ++i) y_i.m[i / 3][i % 3] = next();
      for (int i = 0; i < 9; ++i) b_i.m[i / 3][i % 3] = next();
      for (Number<Tag>& theta : principal.theta) theta = Number<Tag>(next());
      for (int i = 0; i < 3; ++i) {
        for (int j = i; j < 3; ++j) principal.h[i][j] = principal.h[j][i] = Number<Tag>(next());
      }
    }
  }
};

// force += factor v.
template <class Vec>
HWY_INLINE void add_scaled(Vec factor, const Columns<Vec>& v, Columns<Vec>& force) {
  for (int k = 0; k < 9; ++k) {
    force.m[k / 3][k % 3] = hn::MulAdd(factor, v.m[k / 3][k % 3], force.m[k / 3][k % 3]);
  }
}

// a:b = Σ a_ij b_ij.
template <class Vec>
HWY_INLINE Vec inner_product(const Columns<Vec>& a, const Columns<Vec>& b) {
  return hn::Add(dot(a.m[0], b.m[0]), hn::Add(dot(a.m[1], b.m[1]), dot(a.m[2], b.m[2])));
}

// result += K x.
template <TangentForm kForm, class T>
HWY_NOINLINE void apply(const BatchView& batches, const T* HWY_RESTRICT state,
                        const T* HWY_RESTRICT x, T* HWY_RESTRICT result) {
  using Tag = hn::CappedTag<T, kBatchLanes>;
  using Vec = hn::Vec<Tag>;
  using LoadedState = State<Tag, kForm>;
  const Tag tag;
  constexpr size_t kNumbers = tangent_numbers(kForm) * kBatchLanes;
  const auto ahead = [&](size_t b) HWY_ATTR {
    prefetch(state + (b + kPrefetchDistance) * kNumbers, kNumbers);
  };
  for_each_vector<Tag>(
      batches, ahead,
      [&](size_t b, size_t lane, const double*, const uint16_t* HWY_RESTRICT slots)
          TETRACTION_LOOP_BODY {
            Columns<Vec> de;
            RecordAccess<Tag>::edges(tag, x, slots, kBatchLanes, de);
            const LoadedState s(tag, state + b * kNumbers + lane);
            Columns<Vec> force;
            multiply(de, s.stress, force);
            if constexpr (LoadedState::kHasSpatial) {
              for (int j = 0; j < 3; ++j) {
                // Adds k w (deᵀ w). Its column j is Σ_i k (de_i · w_j) w_i.
                Vec weight[3];
                for (int i = 0; i < 3; ++i) weight[i] = hn::Mul(s.k, dot(de.m[i], s.w.m[j]));
                for (int i = 0; i < 3; ++i) {
                  for (int r = 0; r < 3; ++r) {
                    force.m[j][r] = hn::MulAdd(weight[i], s.w.m[i][r], force.m[j][r]);
                  }
                }
              }
              // Adds the couplings Σ_i [Σ_j s_ij (v_j:de)] v_i.
              const Vec along_w = inner_product(de, s.w);
              Vec w_weight = hn::Mul(s.l, along_w);
              if constexpr (LoadedState::kHasCoupled) {
                const Vec along_z = inner_product(de, s.z);
                w_weight = hn::MulAdd(s.s_zw, along_z, w_weight);
                Vec z_weight = hn::MulAdd(s.s_zw, along_w, hn::Mul(s.s_zz, along_z));
                if constexpr (LoadedState::kHasCoupledI2) {
                  const Vec along_b = inner_product(de, s.b);
                  w_weight = hn::MulAdd(s.s_wb, along_b, w_weight);
                  z_weight = hn::MulAdd(s.s_zb, along_b, z_weight);
                  const Vec b_weight = hn::MulAdd(
                      s.s_wb, along_w, hn::MulAdd(s.s_zb, along_z, hn::Mul(s.s_bb, along_b)));
                  add_scaled(b_weight, s.b, force);
                }
                add_scaled(z_weight, s.z, force);
              }
              add_scaled(w_weight, s.w, force);
            }
            if constexpr (LoadedState::kHasMetric) {
              Symmetric<Vec> dc;
              for (int i = 0; i < 3; ++i) {
                for (int j = i; j < 3; ++j) {
                  dc(i, j) = hn::Add(dot(de.m[i], s.e.m[j]), dot(s.e.m[i], de.m[j]));
                }
              }
              Columns<Vec> dcg;
              symmetric_times(dc, s.g, dcg);
              Symmetric<Vec> metric_terms;
              symmetric_product(s.g, dcg, metric_terms);
              const Vec tr = hn::Add(dcg.m[0][0], hn::Add(dcg.m[1][1], dcg.m[2][2]));
              const Vec p = hn::Mul(s.a2, tr);
              for (int k = 0; k < 6; ++k) {
                metric_terms.m[k] = hn::MulAdd(s.a1, metric_terms.m[k], hn::Mul(p, s.g.m[k]));
              }
              Columns<Vec> more;
              multiply(s.e, metric_terms, more);
              for (int k = 0; k < 9; ++k) {
                force.m[k / 3][k % 3] = hn::Add(force.m[k / 3][k % 3], more.m[k / 3][k % 3]);
              }
            }
            if constexpr (LoadedState::kHasPrincipal) add_principal(s, de, force);
            RecordAccess<Tag>::add_balanced(tag, force, result, slots, kBatchLanes);
          });
}

// Adds the diagonal blocks of the nodes. The edges are e = q Γ with the columns q of node positions,
// and γ is the column of Γᵀ = (−1 1 0 0; −1 0 1 0; −1 0 0 1) that belongs to the node. Its block is
//
//     (γᵀSγ) I + k (wγ)(wγ)ᵀ + Σ s_ij (v_iγ)(v_jγ)ᵀ + (a₁ + 2a₂) (eGγ)(eGγ)ᵀ + a₁ (γᵀGγ) e G eᵀ
template <TangentForm kForm, class T>
HWY_NOINLINE void diagonal_blocks(const BatchView& batches, const T* HWY_RESTRICT state,
                                  T* HWY_RESTRICT diagonal, T* HWY_RESTRICT off_diagonal) {
  using Tag = hn::CappedTag<T, kBatchLanes>;
  using Vec = hn::Vec<Tag>;
  const Tag tag;
  constexpr size_t kLanes = hn::MaxLanes(Tag());
  constexpr size_t kNumbers = tangent_numbers(kForm) * kBatchLanes;
  HWY_ALIGN T block[6][kBatchLanes];
  for_each_vector<Tag>(
      batches, [](size_t) {},
      [&](size_t b, size_t lane, const double*,
          const uint16_t* HWY_RESTRICT slots) TETRACTION_LOOP_BODY {
        const State<Tag, kForm> s(tag, state + b * kNumbers + lane);
        Columns<Vec> eg;
        Symmetric<Vec> ege;
        if constexpr (State<Tag, kForm>::kHasMetric) {
          multiply(s.e, s.g, eg);
          for (int i = 0; i < 3; ++i) {
            for (int j = i; j < 3; ++j) {
              ege(i, j) =
                  hn::MulAdd(eg.m[2][i], s.e.m[2][j],
                             hn::MulAdd(eg.m[1][i], s.e.m[1][j], hn::Mul(eg.m[0][i], s.e.m[0][j])));
            }
          }
        }
        const auto total = [&](const Symmetric<Vec>& m) HWY_ATTR {
          const Vec off = hn::Add(m.m[1], hn::Add(m.m[2], m.m[4]));
          return hn::Add(hn::Add(m.m[0], hn::Add(m.m[3], m.m[5])), hn::Add(off, off));
        };
        for (int node = 0; node < 4; ++node) {
          Vec parts[6];
          const Vec on = node == 0 ? total(s.stress) : s.stress(node - 1, node - 1);
          for (int i = 0; i < 3; ++i) {
            parts[i] = on;
            parts[3 + i] = hn::Zero(tag);
          }
          // factor (u vᵀ + v uᵀ)
          const auto add_mixed = [&](const Columns<Vec>& left, const Columns<Vec>& right,
                                     Vec factor) HWY_ATTR {
            Vec u[3];
            Vec v[3];
            for (int i = 0; i < 3; ++i) {
              const auto of_node = [&](const Columns<Vec>& m) HWY_ATTR {
                return node == 0 ? hn::Add(m.m[0][i], hn::Add(m.m[1][i], m.m[2][i]))
                                 : m.m[node == 0 ? 0 : node - 1][i];
              };
              u[i] = of_node(left);
              v[i] = of_node(right);
            }
            for (int i = 0; i < 3; ++i) {
              const Vec first = hn::Mul(factor, u[i]);
              const Vec second = hn::Mul(factor, v[i]);
              parts[i] = hn::MulAdd(hn::Add(first, first), v[i], parts[i]);
              for (int j = i + 1; j < 3; ++j) {
                Vec& part = parts[2 + i + j];
                part = hn::MulAdd(first, v[j], hn::MulAdd(second, u[j], part));
              }
            }
          };
          const auto add_outer = [&](const Columns<Vec>& columns, Vec factor) HWY_ATTR {
            Vec v[3];
            for (int i = 0; i < 3; ++i) {
              v[i] = node == 0 ? hn::Add(columns.m[0][i], hn::Add(columns.m[1][i], columns.m[2][i]))
                               : columns.m[node == 0 ? 0 : node - 1][i];
            }
            for (int i = 0; i < 3; ++i) {
              const Vec scaled = hn::Mul(factor, v[i]);
              parts[i] = hn::MulAdd(scaled, v[i], parts[i]);
              for (int j = i + 1; j < 3; ++j) {
                parts[2 + i + j] = hn::MulAdd(scaled, v[j], parts[2 + i + j]);
              }
            }
          };
          if constexpr (State<Tag, kForm>::kHasSpatial) add_outer(s.w, hn::Add(s.k, s.l));
          if constexpr (State<Tag, kForm>::kHasCoupled) {
            add_outer(s.z, s.s_zz);
            add_mixed(s.w, s.z, s.s_zw);
          }
          if constexpr (State<Tag, kForm>::kHasCoupledI2) {
            add_outer(s.b, s.s_bb);
            add_mixed(s.z, s.b, s.s_zb);
            add_mixed(s.w, s.b, s.s_wb);
          }
          if constexpr (State<Tag, kForm>::kHasMetric) {
            add_outer(eg, hn::Add(s.a1, hn::Add(s.a2, s.a2)));
            const Vec factor = hn::Mul(s.a1, node == 0 ? total(s.g) : s.g(node - 1, node - 1));
            for (int i = 0; i < 3; ++i) {
              parts[i] = hn::MulAdd(factor, ege(i, i), parts[i]);
              for (int j = i + 1; j < 3; ++j) {
                parts[2 + i + j] = hn::MulAdd(factor, ege(i, j), parts[2 + i + j]);
              }
            }
          }
          if constexpr (State<Tag, kForm>::kHasPrincipal) {
            using Real = Number<Tag>;
            Real at[3];
            for (int i = 0; i < 3; ++i) {
              const Vec* own = s.b_i.m[i];
              at[i] = Real(node == 0 ? hn::Add(own[0], hn::Add(own[1], own[2]))
                                     : own[node == 0 ? 0 : node - 1]);
            }
            Real factors[3][3];
            s.principal.factors(at, at, factors);
            for (int i = 0; i < 3; ++i) {
              parts[i] = entry_of(factors, s.y_i, i, i, parts[i]);
              for (int j = i + 1; j < 3; ++j) {
                parts[2 + i + j] = entry_of(factors, s.y_i, i, j, parts[2 + i + j]);
              }
            }
          }
          for (int k = 0; k < 6; ++k) hn::Store(parts[k], tag, block[k]);
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

// Computes the element matrices. With γ_a as above and z_a = eGγ_a, the block of nodes a and b is
//
//     (γ_aᵀSγ_b) I + k (wγ_b)(wγ_a)ᵀ + Σ s_ij (v_iγ_a)(v_jγ_b)ᵀ
//       + a₁ (z_b z_aᵀ + (γ_aᵀGγ_b) e G eᵀ) + 2a₂ z_a z_bᵀ
//
// The blocks of node 0 follow from the others, because a translation of the element causes no force.
template <TangentForm kForm>
HWY_NOINLINE void stiffness(const double* HWY_RESTRICT state, double* HWY_RESTRICT matrices) {
  using Tag = DoubleTag;
  using Vec = DoubleVec;
  const Tag tag;
  constexpr size_t kLanes = hn::MaxLanes(Tag());
  for (size_t lane = 0; lane < kBatchLanes; lane += kLanes) {
    const State<Tag, kForm> s(tag, state + lane);
    Columns<Vec> z;
    Symmetric<Vec> ege;
    if constexpr (State<Tag, kForm>::kHasMetric) {
      multiply(s.e, s.g, z);
      for (int i = 0; i < 3; ++i) {
        for (int j = i; j < 3; ++j) {
          ege(i, j) =
              hn::MulAdd(z.m[2][i], s.e.m[2][j],
                         hn::MulAdd(z.m[1][i], s.e.m[1][j], hn::Mul(z.m[0][i], s.e.m[0][j])));
        }
      }
    }
    const auto block = [&](int a, int b, Vec* out) HWY_ATTR {  // of the nodes a + 1 and b + 1
      [[maybe_unused]] Number<Tag> factors[3][3];
      if constexpr (State<Tag, kForm>::kHasPrincipal) {
        using Real = Number<Tag>;
        const auto& m = s.b_i.m;
        const Real at_a[3] = {Real(m[0][a]), Real(m[1][a]), Real(m[2][a])};
        const Real at_b[3] = {Real(m[0][b]), Real(m[1][b]), Real(m[2][b])};
        s.principal.factors(at_a, at_b, factors);
      }
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
          Vec sum = r == c ? s.stress(a, b) : hn::Zero(tag);
          if constexpr (State<Tag, kForm>::kHasSpatial) {
            sum = hn::MulAdd(hn::Mul(s.k, s.w.m[b][r]), s.w.m[a][c], sum);
            sum = hn::MulAdd(hn::Mul(s.l, s.w.m[a][r]), s.w.m[b][c], sum);
          }
          const auto add_mixed = [&](Vec factor, const Columns<Vec>& u, const Columns<Vec>& v)
                                     HWY_ATTR {
                                       sum = hn::MulAdd(hn::Mul(factor, u.m[a][r]), v.m[b][c], sum);
                                       sum = hn::MulAdd(hn::Mul(factor, v.m[a][r]), u.m[b][c], sum);
                                     };
          if constexpr (State<Tag, kForm>::kHasCoupled) {
            sum = hn::MulAdd(hn::Mul(s.s_zz, s.z.m[a][r]), s.z.m[b][c], sum);
            add_mixed(s.s_zw, s.w, s.z);
          }
          if constexpr (State<Tag, kForm>::kHasCoupledI2) {
            sum = hn::MulAdd(hn::Mul(s.s_bb, s.b.m[a][r]), s.b.m[b][c], sum);
            add_mixed(s.s_zb, s.z, s.b);
            add_mixed(s.s_wb, s.w, s.b);
          }
          if constexpr (State<Tag, kForm>::kHasMetric) {
            const Vec first = hn::MulAdd(z.m[b][r], z.m[a][c], hn::Mul(s.g(a, b), ege(r, c)));
            sum = hn::MulAdd(s.a1, first, sum);
            sum = hn::MulAdd(hn::Mul(hn::Add(s.a2, s.a2), z.m[a][r]), z.m[b][c], sum);
          }
          if constexpr (State<Tag, kForm>::kHasPrincipal) sum = entry_of(factors, s.y_i, r, c, sum);
          out[3 * r + c] = sum;
        }
      }
    };
    const auto store = [&](int number, Vec v) HWY_ATTR {
      hn::Store(v, tag, matrices + static_cast<size_t>(number * kBatchLanes) + lane);
    };
    const auto store_diagonal = [&](int node, const Vec* b) HWY_ATTR {
      constexpr int kUpper[6] = {0, 1, 2, 4, 5, 8};
      for (int k = 0; k < 6; ++k) store(6 * node + k, b[kUpper[k]]);
    };
    Vec node0[4][9];  // blocks of node 0 with each node
    for (auto& block_of_pair : node0) {
      for (Vec& v : block_of_pair) v = hn::Zero(tag);
    }
    int pair = 3;
    for (int a = 0; a < 3; ++a) {
      Vec b[9];
      block(a, a, b);
      store_diagonal(a + 1, b);
      for (int k = 0; k < 9; ++k) node0[a + 1][k] = hn::Sub(node0[a + 1][k], b[k]);
      for (int c = a + 1; c < 3; ++c, ++pair) {
        block(a, c, b);
        for (int k = 0; k < 9; ++k) {
          store(24 + 9 * pair + k, b[k]);
          node0[c + 1][k] = hn::Sub(node0[c + 1][k], b[k]);
          node0[a + 1][k] = hn::Sub(node0[a + 1][k], b[3 * (k % 3) + k / 3]);  // K_ca = K_acᵀ
        }
      }
    }
    for (int c = 1; c < 4; ++c) {
      for (int k = 0; k < 9; ++k) {
        store(24 + 9 * (c - 1) + k, node0[c][k]);
        node0[0][k] = hn::Sub(node0[0][k], node0[c][k]);
      }
    }
    store_diagonal(0, node0[0]);
  }
}

// Whether det(1 + t p) > 0.1 for all t in [0, 1] and p = deᵀw, shown by the lower bound
// 1 + min(I₁(p), 0) + min(I₂(p), 0) + min(I₃(p), 0) with the principal invariants of p.
template <class T>
HWY_NOINLINE bool is_safe(const BatchView& batches, TangentForm form, const T* HWY_RESTRICT state,
                          const T* HWY_RESTRICT x) {
  using Tag = hn::CappedTag<T, kBatchLanes>;
  using Vec = hn::Vec<Tag>;
  const Tag tag;
  const Vec zero = hn::Zero(tag);
  const auto numbers = static_cast<size_t>(tangent_numbers(form)) * kBatchLanes;
  bool safe = true;
  for_each_vector<Tag>(
      batches, [](size_t) {},
      [&](size_t b, size_t lane, const double*,
          const uint16_t* HWY_RESTRICT slots) TETRACTION_LOOP_BODY {
        if (!safe) return;
        Columns<Vec> de;
        RecordAccess<Tag>::edges(tag, x, slots, kBatchLanes, de);
        const T* w = state + b * numbers + lane + 6 * kBatchLanes;
        Columns<Vec> p;
        for (int j = 0; j < 3; ++j) {
          Vec column[3];
          for (int i = 0; i < 3; ++i) column[i] = hn::Load(tag, w + (3 * j + i) * kBatchLanes);
          for (int i = 0; i < 3; ++i) p.m[i][j] = dot(de.m[i], column);
        }
        Columns<Vec> cofactor;
        const Vec third = cofactors(p, cofactor);
        const Vec first = hn::Add(p.m[0][0], hn::Add(p.m[1][1], p.m[2][2]));
        const Vec second = hn::Add(cofactor.m[0][0], hn::Add(cofactor.m[1][1], cofactor.m[2][2]));
        const auto loss = [&](Vec v) HWY_ATTR {  // min(v, 0); NaN stays NaN
          return hn::IfThenElse(hn::Gt(v, zero), zero, v);
        };
        const Vec least = hn::Add(loss(first), hn::Add(loss(second), loss(third)));
        safe = hn::AllTrue(tag, hn::Gt(least, hn::Set(tag, T(-0.9))));
      });
  return safe;
}

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
