#include "micro/fiber/fiber_loads.h"

#include <set>

namespace trame::micro {

namespace {

/// ∫ N ds of the vectors of an element, in their order.
using Weights = std::array<double, 9>;

Weights weights(FiberModel model, double h) {
  if (model == FiberModel::enriched) return {h / 6, 0, 0, 4 * h / 6, 0, 0, h / 6, 0, 0};
  return {h / 2, h * h / 12, h / 2, -h * h / 12};
}

}  // namespace

FiberLoads::FiberLoads(const FiberField& field, std::vector<FiberLoadTerm> terms)
    : field_(field), terms_(std::move(terms)) {
  std::set<Index> loaded;
  for (const FiberLoadTerm& term : terms_) loaded.insert(term.fiber);
  loaded_.assign(loaded.begin(), loaded.end());
}

std::vector<Vec3> FiberLoads::forces(double stage_time) const {
  std::vector<Vec3> force(static_cast<std::size_t>(field_.mesh().n_fibers()), Vec3::Zero());
  for (const FiberLoadTerm& term : terms_) force[term.fiber] += term.at(stage_time);
  return force;
}

void FiberLoads::begin_step(const State& start, double stage_time) {
  q_n_ = start.q;
  time_ = stage_time;
  force_n_ = forces(time_n_);
  force_ = forces(time_);
}

void FiberLoads::add(const State&, Assembler& assembler) const {
  for (const Index f : loaded_) {
    if (!field_.touches(f, assembler)) continue;
    const Weights weight = weights(field_.model(f), field_.element_length(f));
    for (Index e = 0; e < field_.mesh().n_elements(f); ++e) {
      const ElementNodes nodes = field_.element(f, e);
      if (!nodes.touches(assembler)) continue;
      for (int i = 0; i < nodes.n_nodes * nodes.n_vectors; ++i)
        if (weight[i] != 0)
          nodes.add_force(i / nodes.n_vectors, i % nodes.n_vectors, -weight[i] * force_[f], assembler);
    }
  }
}

Vec3 FiberLoads::integral(Index fiber, const std::vector<Vec3>& q) const {
  const Weights weight = weights(field_.model(fiber), field_.element_length(fiber));
  Vec3 sum = Vec3::Zero();
  ElementNodes::Buffer buffer;
  for (Index e = 0; e < field_.mesh().n_elements(fiber); ++e) {
    const ElementNodes nodes = field_.element(fiber, e);
    const Vec3* of_element = nodes.gather(field_.layout(), q.data(), buffer);
    for (int i = 0; i < nodes.n_nodes * nodes.n_vectors; ++i) sum += weight[i] * of_element[i];
  }
  return sum;
}

double FiberLoads::work(const std::vector<Vec3>& force, const State& state) const {
  std::vector<Vec3> motion(state.q.size());
  for (std::size_t v = 0; v < motion.size(); ++v) motion[v] = state.q[v] - q_n_[v];
  double sum = 0;
  for (const Index f : loaded_) sum += force[f].dot(integral(f, motion));
  return sum;
}

double FiberLoads::energy(const State& state) const { return -work(force_, state); }

Ledger FiberLoads::ledger(const State&) const {
  Ledger ledger;
  ledger[Source::fiber_loads] = work_;
  return ledger;
}

void FiberLoads::commit(const State& state) {
  work_ += 0.5 * (work(force_n_, state) + work(force_, state));
  time_n_ = time_;
}

std::vector<Vec3> FiberLoads::moments(const State& state) const {
  std::vector<Vec3> all;
  all.reserve(loaded_.size());
  for (const Index f : loaded_) all.push_back(integral(f, state.q).cross(force_[f]));
  return all;
}

}  // namespace trame::micro
