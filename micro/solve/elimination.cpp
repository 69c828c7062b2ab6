#include "micro/solve/elimination.h"

#include <cholmod.h>

#include <algorithm>
#include <memory>
#include <stdexcept>

namespace trame::micro {

namespace {

/// Calls visit(i) for the nodes i that are coupled to column node j and kept.
template <typename Visit>
void for_each_kept(const Pattern& pattern, std::span<const char> kept, Index j, Visit&& visit) {
  std::size_t coupling = pattern.coupling_start(j);
  for (const Index i : pattern.rows(j))
    if (kept[coupling++]) visit(i);
}

/// Fill-reducing order and supernodes of a graph, by CHOLMOD.
class Analysis {
 public:
  Analysis(const Pattern& pattern, std::span<const char> kept) {
    cholmod_start(&common_);
    common_.print = 0;
    common_.supernodal = CHOLMOD_SUPERNODAL;
    common_.nmethods = 1;
    common_.method[0].ordering = CHOLMOD_METIS;
    common_.postorder = 1;
    // Limits up to which supernodes are merged at the price of some zeros, in nodes: CHOLMOD's own are meant for scalar
    // columns.
    common_.nrelax[0] = 2;
    common_.nrelax[1] = 6;
    common_.nrelax[2] = 12;

    const Index n = pattern.n_nodes();
    std::vector<int> start(n + 1, 0), rows;
    for (Index j = 0; j < n; ++j) {
      for_each_kept(pattern, kept, j, [&](Index i) { rows.push_back(i); });
      start[j + 1] = static_cast<int>(rows.size());
    }
    cholmod_sparse graph{};
    graph.nrow = graph.ncol = n;
    graph.nzmax = rows.size();
    graph.p = start.data();
    graph.i = rows.data();
    graph.stype = -1;
    graph.itype = CHOLMOD_INT;
    graph.xtype = CHOLMOD_PATTERN;
    graph.dtype = CHOLMOD_DOUBLE;
    graph.sorted = graph.packed = 1;
    factor_ = cholmod_analyze(&graph, &common_);
    if (factor_ == nullptr)
      throw std::runtime_error("CHOLMOD failed to analyse the matrix, status " + std::to_string(common_.status) +
                               " (is there enough memory?)");
  }
  ~Analysis() {
    cholmod_free_factor(&factor_, &common_);
    cholmod_finish(&common_);
  }
  Analysis(const Analysis&) = delete;
  Analysis& operator=(const Analysis&) = delete;

  [[nodiscard]] Index n_supernodes() const { return static_cast<Index>(factor_->nsuper); }
  [[nodiscard]] std::span<const int> order() const { return {static_cast<const int*>(factor_->Perm), factor_->n}; }
  [[nodiscard]] int first_position(Index s) const { return static_cast<const int*>(factor_->super)[s]; }
  [[nodiscard]] std::span<const int> rows(Index s) const {
    const int* start = static_cast<const int*>(factor_->pi);
    const int* all = static_cast<const int*>(factor_->s);
    return {all + start[s], all + start[s + 1]};
  }

 private:
  cholmod_common common_{};
  cholmod_factor* factor_ = nullptr;
};

}  // namespace

Elimination::Elimination(const Pattern& pattern, std::span<const char> kept) {
  const Analysis analysis(pattern, kept);
  const Index n = pattern.n_nodes(), n_super = analysis.n_supernodes();
  node.assign(analysis.order().begin(), analysis.order().end());
  std::vector<Index> position(n);
  first_dof.assign(1, 0);
  for (Index k = 0; k < n; ++k) {
    position[node[k]] = k;
    dof.push_back(pattern.first_dof(node[k]));
    first_dof.push_back(first_dof.back() + pattern.width(node[k]));
  }

  row_start.assign(1, 0);
  value_start.assign(1, 0);
  front_start.assign(1, 0);
  parent.assign(n_super, -1);
  first_descendant.resize(n_super);
  subtree_flops.resize(n_super);
  std::vector<Index> supernode_of(n);
  for (Index s = 0; s <= n_super; ++s) first.push_back(s < n_super ? analysis.first_position(s) : n);
  for (Index s = 0; s < n_super; ++s)
    for (Index k = first[s]; k < first[s + 1]; ++k) supernode_of[k] = s;
  for (Index s = 0; s < n_super; ++s) {
    first_descendant[s] = s;
    Index h = 0;
    for (const int k : analysis.rows(s)) {
      rows.push_back(k);
      row_dof.push_back(h);
      h += width(k);
    }
    height.push_back(h);
    front_start.push_back(front_start.back() + h);
    row_start.push_back(rows.size());
    if (const auto all = row_positions(s); static_cast<Index>(all.size()) > n_column_positions(s))
      parent[s] = supernode_of[all[n_column_positions(s)]];
    value_start.push_back(value_start.back() + static_cast<std::size_t>(h) * n_columns(s));
    for (Index c = 0; c < n_columns(s); ++c) subtree_flops[s] += double(h - c) * (h - c);
  }
  child_start.assign(n_super + 1, 0);
  for (Index s = 0; s < n_super; ++s) {
    if (parent[s] < 0) continue;
    ++child_start[parent[s] + 1];
    subtree_flops[parent[s]] += subtree_flops[s];
    first_descendant[parent[s]] = std::min(first_descendant[parent[s]], first_descendant[s]);
  }
  for (Index s = 0; s < n_super; ++s) {
    child_start[s + 1] += child_start[s];
    if (parent[s] < 0) n_flops += subtree_flops[s];
  }
  children.resize(child_start[n_super]);
  std::vector<Index> filled(child_start.begin(), child_start.end() - 1);
  for (Index s = 0; s < n_super; ++s)
    if (parent[s] >= 0) children[filled[parent[s]]++] = s;

  block_start.assign(n + 1, 0);
  const auto column_of = [&](Index i, Index j) { return std::min(position[i], position[j]); };
  for (Index j = 0; j < n; ++j) for_each_kept(pattern, kept, j, [&](Index i) { ++block_start[column_of(i, j) + 1]; });
  for (Index k = 0; k < n; ++k) block_start[k + 1] += block_start[k];
  blocks.resize(block_start[n]);
  std::vector<std::size_t> at(block_start.begin(), block_start.end() - 1);
  for (Index j = 0; j < n; ++j) {
    std::size_t value = pattern.value_start(j), coupling = pattern.coupling_start(j);
    for (const Index i : pattern.rows(j)) {
      if (kept[coupling++])
        blocks[at[column_of(i, j)]++] = {std::max(position[i], position[j]), position[i] < position[j],
                                         pattern.column_height(j), value};
      value += pattern.width(i);
    }
  }
  for (Index k = 0; k < n; ++k)
    std::sort(blocks.begin() + block_start[k], blocks.begin() + block_start[k + 1],
              [](const Block& a, const Block& b) { return a.row_position < b.row_position; });
}

}  // namespace trame::micro
