#pragma once
/// \file
/// What of a tangent is not symmetric: friction goes with the normal force, but not the other way round.

#include <span>
#include <vector>

#include "micro/core/types.h"

namespace trame::micro {

/// A sum of products p qᵀ of sparse vectors of unknowns, by their 3-vectors.
class UnsymmetricTerms {
 public:
  /// `add_left` and `add_right` fill p and q of this term, up to the next one.
  void begin_term() { terms_.push_back({left_.size(), right_.size()}); }
  void add_left(Index vector, const Vec3& value) { left_.push_back({vector, value}); }
  void add_right(Index vector, const Vec3& value) { right_.push_back({vector, value}); }
  void append(const UnsymmetricTerms& others) {
    for (const Term& term : others.terms_) terms_.push_back({left_.size() + term.left, right_.size() + term.right});
    left_.insert(left_.end(), others.left_.begin(), others.left_.end());
    right_.insert(right_.end(), others.right_.begin(), others.right_.end());
  }
  void clear() {
    terms_.clear();
    left_.clear();
    right_.clear();
  }
  [[nodiscard]] bool empty() const { return terms_.empty(); }

  /// Takes each value of each vector to change(vector, value).
  template <class Change>
  void change_each(const Change& change) {
    for (auto* parts : {&left_, &right_})
      for (Part& part : *parts) part.value = change(part.vector, part.value);
  }
  /// Rows of dofs that are not free vanish.
  void leave_out(std::span<const char> fixed) {
    for (Part& part : left_)
      for (int c = 0; c < 3; ++c)
        if (fixed[3 * static_cast<std::size_t>(part.vector) + c]) part.value[c] = 0;
  }
  /// y += Σ p (q·x)
  void add_product(std::span<const double> x, std::span<double> y) const {
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      const Term begin = terms_[t], end = t + 1 < terms_.size() ? terms_[t + 1] : Term{left_.size(), right_.size()};
      double sum = 0;
      for (std::size_t k = begin.right; k < end.right; ++k)
        sum += right_[k].value.dot(Eigen::Map<const Vec3>(x.data() + 3 * right_[k].vector));
      for (std::size_t k = begin.left; k < end.left; ++k)
        Eigen::Map<Vec3>(y.data() + 3 * left_[k].vector) += sum * left_[k].value;
    }
  }

 private:
  struct Part {
    Index vector;
    Vec3 value;
  };
  /// Where its parts begin.
  struct Term {
    std::size_t left, right;
  };
  std::vector<Term> terms_;
  std::vector<Part> left_, right_;
};

}  // namespace trame::micro
