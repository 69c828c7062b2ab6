#pragma once
/// \file
/// Unknowns, sparsity pattern and assembly. The unknowns are 3-vectors (positions, section vectors, rotations)
/// grouped in nodes; the matrix is the lower triangle of K in compressed columns, addressed by pairs of nodes.

#include <array>
#include <cassert>
#include <cmath>
#include <span>
#include <vector>

#include "micro/core/archive.h"

namespace trame::micro {

/// Nodes and their vectors. Bodies come first, so that their couplings stand in their own columns.
class Layout {
 public:
  /// Adds a node of `n_vectors` unknown 3-vectors; returns its index.
  Index add_node(int n_vectors) {
    first_vector_.push_back(first_vector_.back() + n_vectors);
    return n_nodes() - 1;
  }
  /// Declares that `vector` holds rotation increments: it turns `State::rotations[i]` instead of adding. Returns i.
  Index add_rotation(Index vector) {
    rotation_vectors_.push_back(vector);
    return static_cast<Index>(rotation_vectors_.size()) - 1;
  }

  /// The dofs of the first n nodes count along these axes, the columns, instead of x, y and z; their vectors in a state
  /// do not.
  void set_axes(Index n_nodes, const Mat3& axes) {
    n_skew_nodes_ = n_nodes;
    skew_axes_ = axes;
  }
  [[nodiscard]] Index n_skew_nodes() const { return n_skew_nodes_; }
  [[nodiscard]] const Mat3& skew_axes() const { return skew_axes_; }
  /// What `dofs` change a vector by.
  [[nodiscard]] Vec3 change(Index vector, const Vec3& dofs) const {
    return vector < first_vector_[n_skew_nodes_] ? Vec3(skew_axes_ * dofs) : dofs;
  }
  /// What a force on a vector is for its dofs.
  [[nodiscard]] Vec3 force_on_dofs(Index vector, const Vec3& force) const {
    return vector < first_vector_[n_skew_nodes_] ? Vec3(skew_axes_.transpose() * force) : force;
  }

  [[nodiscard]] Index n_nodes() const { return static_cast<Index>(first_vector_.size()) - 1; }
  [[nodiscard]] Index n_vectors() const { return first_vector_.back(); }
  [[nodiscard]] Index n_vectors(Index node) const { return first_vector_[node + 1] - first_vector_[node]; }
  [[nodiscard]] Index n_dofs() const { return 3 * n_vectors(); }
  [[nodiscard]] Index first_vector(Index node) const { return first_vector_[node]; }
  [[nodiscard]] Index first_dof(Index node) const { return 3 * first_vector_[node]; }
  [[nodiscard]] const std::vector<Index>& rotation_vectors() const { return rotation_vectors_; }

 private:
  std::vector<Index> first_vector_ = {0};
  std::vector<Index> rotation_vectors_;
  Index n_skew_nodes_ = 0;
  Mat3 skew_axes_ = Mat3::Identity();
};

/// Values of all unknowns.
struct State {
  std::vector<Vec3> q;          ///< n_vectors; meaningless at rotation vectors
  std::vector<Mat3> rotations;  ///< of the rigid bodies

  void keep(Archive& archive) { archive(q, rotations); }
};

/// Rotation matrix of a rotation vector (Rodrigues).
[[nodiscard]] Mat3 rotation_matrix(const Vec3& rotation_vector);
/// Skew matrix: skew(a) b = a × b.
[[nodiscard]] Mat3 skew(const Vec3& a);

/// state ⊕ α·step: vectors add, rotations turn by the rotation vector of their step.
void retract(const Layout& layout, const State& state, std::span<const double> step, double alpha, State& result);

/// Nodes that are free while all others are held where they are; all of them where nothing else is said.
class Region {
 public:
  Region() = default;
  explicit Region(std::vector<char> is_free) : is_free_(std::move(is_free)) {}
  [[nodiscard]] bool is_everywhere() const { return is_free_.empty(); }
  [[nodiscard]] bool has(Index node) const { return is_everywhere() || is_free_[node]; }

 private:
  std::vector<char> is_free_;
};
inline const Region everywhere;

/// Lower-triangular sparsity by node pairs. Column j holds node j itself and its coupled nodes i > j, ascending.
class Pattern {
 public:
  /// Collects cliques of nodes that an effect couples.
  class Builder {
   public:
    explicit Builder(const Region& region = everywhere) : region_(&region) {}
    void add_clique(std::span<const Index> nodes);
    friend class Pattern;

   private:
    void compact();
    const Region* region_;              // couplings to nodes outside of it are left out
    std::vector<std::uint64_t> pairs_;  // (lower node << 32) | higher node
    std::size_t compact_at_ = 1u << 22;
  };

  Pattern() = default;
  Pattern(const Layout& layout, Builder builder);
  /// Of nodes whose dofs begin at `first_dof`; one more entry for the end.
  Pattern(std::vector<Index> first_dof, Builder builder);

  /// True if every coupling of `builder` is in this pattern already.
  [[nodiscard]] bool covers(Builder& builder) const;

  [[nodiscard]] Index n_nodes() const { return static_cast<Index>(column_start_.size()) - 1; }
  [[nodiscard]] std::size_t n_values() const { return n_values_; }
  [[nodiscard]] Index first_dof(Index node) const { return first_dof_[node]; }
  /// Number of dofs of a node.
  [[nodiscard]] Index width(Index node) const { return first_dof_[node + 1] - first_dof_[node]; }
  [[nodiscard]] std::span<const Index> rows(Index column_node) const {
    return {row_nodes_.data() + column_start_[column_node], row_nodes_.data() + column_start_[column_node + 1]};
  }
  /// Where the couplings of a column node begin among all, in the order of `rows`.
  [[nodiscard]] std::size_t coupling_start(Index column_node) const { return column_start_[column_node]; }
  /// Number of scalar rows in each column of node j.
  [[nodiscard]] Index column_height(Index j) const { return column_height_[j]; }
  /// Where the values of node j's first scalar column start.
  [[nodiscard]] std::size_t value_start(Index j) const { return value_start_[j]; }
  /// Scalar row, within a column of node j, at which node i starts.
  [[nodiscard]] Index row_offset(Index i, Index j) const;

 private:
  std::vector<Index> first_dof_;
  std::vector<std::size_t> column_start_ = {0};
  std::vector<Index> row_nodes_, row_offsets_;
  std::vector<Index> column_height_;
  std::vector<std::size_t> value_start_;
  std::size_t n_values_ = 0;
};

/// What one thread assembles: forces of, and matrix columns of, the nodes that it owns. An effect visits every item
/// that touches an owned node, in an order of its own that does not depend on the number of threads: so neither do the
/// sums.
class Assembler {
 public:
  enum class Tangent : std::uint8_t { none, exact, projected };

  /// `magnitude` gets, for each vector, the sum of the sizes of what is added to it from now on.
  Assembler(const Layout& layout, const Pattern* pattern, Index node_begin, Index node_end, double* force,
            double* magnitude, double* values, Tangent tangent, const Region& region = everywhere)
      : layout_(layout), pattern_(pattern), region_(region), begin_(node_begin), end_(node_end), force_(force),
        magnitude_(magnitude), values_(values), tangent_(tangent) {}

  void set_magnitude(double* magnitude) { magnitude_ = magnitude; }

  /// Stresses of fibers and ties, either those of the state, or those that were to be expected from the strains at the
  /// start of the last step and how they changed with it to first order.
  enum class Stress : std::uint8_t { actual, expected };
  /// The last step, as it was made, of each vector. With it the tangent is that at the expected stresses, and forces
  /// are of the given ones. Without it, all are actual.
  void set_last_step(const Vec3* step, Stress of_forces) {
    last_step_ = step;
    stress_of_forces_ = of_forces;
  }
  /// nullptr where there is none.
  [[nodiscard]] const Vec3* last_step() const { return last_step_; }
  [[nodiscard]] bool expects_forces() const { return last_step_ && stress_of_forces_ == Stress::expected; }

  [[nodiscard]] const Region& region() const { return region_; }
  [[nodiscard]] Tangent tangent() const { return tangent_; }
  [[nodiscard]] bool wants_tangent() const { return tangent_ != Tangent::none; }
  [[nodiscard]] bool owns(Index node) const { return node >= begin_ && node < end_ && region_.has(node); }
  /// True if the node range [first, last] of a fiber has an owned node. Fibers are free as a whole.
  [[nodiscard]] bool touches(Index first, Index last) const {
    return first < end_ && last >= begin_ && region_.has(first);
  }

  /// Adds `f` to the gradient of the energy at vector `v` of `node`, if owned.
  void add_force(Index node, int v, const Vec3& f) {
    if (!owns(node)) return;
    const Index dof = layout_.first_dof(node) + 3 * v;
    for (int c = 0; c < 3; ++c) force_[dof + c] += f[c];
    magnitude_[dof / 3] += f.norm();
  }
  /// Where the block (node i, node j), i ≥ j, starts in the matrix values, and the stride between its columns.
  struct Block {
    double* data;
    Index stride;
  };
  [[nodiscard]] Block block(Index i, Index j) const {
    assert(i >= j && owns(j));
    if (!region_.has(i)) return {unused_.data(), max_width};
    return {values_ + pattern_->value_start(j) + pattern_->row_offset(i, j), pattern_->column_height(j)};
  }

 private:
  static constexpr Index max_width = 9;  // dofs of a node

  const Layout& layout_;
  const Pattern* pattern_;
  const Region& region_;
  mutable std::array<double, static_cast<std::size_t>(max_width* max_width)> unused_{};  // couplings to what is held
  Index begin_, end_;
  double *force_, *magnitude_, *values_;
  Tangent tangent_;
  const Vec3* last_step_ = nullptr;
  Stress stress_of_forces_ = Stress::actual;
};

}  // namespace trame::micro
