#include "outer_products.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/nodal_volume/nodal_volume.h"

namespace tetraction {
namespace {

constexpr Index kGrain = 256;

}  // namespace

template <class T>
OuterProducts<T>::OuterProducts(const VertexGroups& groups, const NodalVolume* volume)
    : groups_(groups), volume_(volume) {
  if (volume_ != nullptr) gradients_ = std::make_unique<PatchGradients<T>>(volume_->patches());
}

template <class T>
bool OuterProducts<T>::has_pattern_of(const HessianBlocks& terms) const {
  const auto same_begin = [](std::size_t begin, const HessianBlocks::Outer& outer) {
    return begin == outer.begin;
  };
  return has_pattern_ && terms.outer_vertices() == term_vertices_ &&
         std::equal(term_begin_.begin(), term_begin_.end(), terms.outers().begin(),
                    terms.outers().end(), same_begin);
}

template <class T>
void OuterProducts<T>::make_pattern(const HessianBlocks& terms) {
  has_pattern_ = true;
  term_vertices_ = terms.outer_vertices();
  term_begin_.clear();
  for (const HessianBlocks::Outer& outer : terms.outers()) term_begin_.push_back(outer.begin);
  const auto vertex_count = groups_.order().size();
  std::vector<std::int32_t> place_of(vertex_count);
  for (std::size_t i = 0; i < vertex_count; ++i) {
    place_of[static_cast<std::size_t>(groups_.order()[i])] = static_cast<std::int32_t>(i);
  }
  begin_.assign(1, 0);
  place_.clear();
  const auto add = [&](std::span<const Index> vertices) {
    for (const Index v : vertices) place_.push_back(place_of[static_cast<std::size_t>(v)]);
    begin_.push_back(place_.size());
  };
  const Index patches = volume_ == nullptr ? 0 : volume_->patch_count();
  for (Index p = 0; p < patches; ++p) add(volume_->patch_vertices(p));
  for (const HessianBlocks::Outer& outer : terms.outers()) {
    add(std::span(terms.outer_vertices()).subspan(outer.begin, outer.end - outer.begin));
  }
  place_begin_.assign(vertex_count + 1, 0);
  for (const std::int32_t i : place_) ++place_begin_[static_cast<std::size_t>(i) + 1];
  std::partial_sum(place_begin_.begin(), place_begin_.end(), place_begin_.begin());
  std::vector<std::size_t> next(place_begin_.begin(), place_begin_.end() - 1);
  other_.resize(place_.size());
  number_.resize(place_.size());
  for (std::size_t n = 0; n + 1 < begin_.size(); ++n) {
    for (std::size_t k = begin_[n]; k < begin_[n + 1]; ++k) {
      const std::size_t at = next[static_cast<std::size_t>(place_[k])]++;
      other_[k] = static_cast<std::int32_t>(at);
      number_[at] = static_cast<std::int32_t>(n);
    }
  }
  roots_.resize(static_cast<std::size_t>(patches));
  vectors_.resize(4 * place_.size());
  at_place_.resize(vectors_.size());
  signs_.resize(begin_.size() - 1);
  along_.resize(begin_.size() - 1);
}

template <class T>
void OuterProducts<T>::set(const Positions& x, HessianForm form, const HessianBlocks& terms) {
  if (!has_pattern_of(terms)) make_pattern(terms);
  if (volume_ != nullptr) {
    const Vector& factors = volume_->outer_factors(x, form);
    for (std::size_t p = 0; p < roots_.size(); ++p) {
      const double factor = factors[static_cast<Index>(p)];
      roots_[p] = static_cast<T>(std::sqrt(std::abs(factor)));
      signs_[p] = factor < 0.0 ? T(-1) : T(1);
    }
    gradients_->set(x);
    gradients_->for_each([&](Index patch, Index entry, const Record& b) {
      store(static_cast<std::size_t>(entry), roots_[static_cast<std::size_t>(patch)] * b);
    });
  }
  if (!terms.outers().empty()) set_terms(terms);
}

template <class T>
void OuterProducts<T>::set_terms(const HessianBlocks& terms) {
  std::size_t number = roots_.size();
  for (const HessianBlocks::Outer& outer : terms.outers()) {
    signs_[number] = outer.factor < 0.0 ? T(-1) : T(1);
    const double root = std::sqrt(std::abs(outer.factor));
    for (std::size_t k = outer.begin; k < outer.end; ++k) {
      const Vector3 v = root * terms.outer_vectors()[k];
      store(begin_[number] + (k - outer.begin),
            Eigen::Vector4d(v[0], v[1], v[2], 0.0).template cast<T>());
    }
    ++number;
  }
}

template <class T>
void OuterProducts<T>::multiply(const AlignedVector<T>& x) {
  parallel_for(count(), kGrain, [&](Index begin, Index end) {
    for (Index number = begin; number < end; ++number) {
      const auto i = static_cast<std::size_t>(number);
      Record sum = Record::Zero();
      for (std::size_t k = begin_[i]; k < begin_[i + 1]; ++k) {
        sum += record(vectors_, k).cwiseProduct(record(x, static_cast<std::size_t>(place_[k])));
      }
      along_[i] = signs_[i] * sum.sum();
    }
  });
}

template <class T>
Matrix3 OuterProducts<T>::block(Index place) const {
  Eigen::Matrix<T, 4, 3> columns = Eigen::Matrix<T, 4, 3>::Zero();
  for_place(place, [&](std::size_t number, const auto& v) {
    const Record signed_v = signs_[number] * v;
    for (int i = 0; i < 3; ++i) columns.col(i) += signed_v[i] * v;
  });
  return columns.template topRows<3>().template cast<double>();
}

template class OuterProducts<float>;
template class OuterProducts<double>;

}  // namespace tetraction
