#include "micro/rigid/rigid_body.h"

#include <algorithm>
#include <set>

namespace trame::micro {

namespace {

/// Adds a 3 × 3 matrix to the block of vectors (v of node i, w of node j); the half below the diagonal is what counts.
void add_vector_block(Index i, int v, Index j, int w, const Mat3& m, Assembler& assembler) {
  if (i < j) {
    add_vector_block(j, w, i, v, m.transpose(), assembler);
    return;
  }
  if (!assembler.owns(j)) return;
  const auto block = assembler.block(i, j);
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) block.data[static_cast<std::size_t>(3 * w + c) * block.stride + 3 * v + r] += m(r, c);
}

/// Tangent contributions of one pair of vectors, both halves of a diagonal node block included.
void add_pair(Index i, int v, Index j, int w, const Mat3& m, Assembler& assembler) {
  add_vector_block(i, v, j, w, m, assembler);
  if (i == j && v != w) add_vector_block(j, w, i, v, m.transpose(), assembler);
}

/// Hessian at δθ = 0 of e·(exp(δθ) Y) for a fixed e.
Mat3 rotation_hessian(const Vec3& e, const Vec3& arm) {
  return 0.5 * (e * arm.transpose() + arm * e.transpose()) - e.dot(arm) * Mat3::Identity();
}

}  // namespace

RigidBodies::RigidBodies(Index n_bodies, Layout& layout, Index n_skew, const Mat3& axes)
    : n_bodies_(n_bodies), n_skew_(n_skew), axes_(axes) {
  assert(layout.n_nodes() == 0);
  for (Index b = 0; b < n_bodies; ++b) {
    const Index n = layout.add_node(2);
    layout.add_rotation(layout.first_vector(n) + 1);
  }
  layout.set_axes(n_skew, axes);
}

Ties::Ties(const Layout& layout, const RigidBodies& bodies, std::vector<TieTerm> terms)
    : layout_(layout), bodies_(bodies), terms_(std::move(terms)),
      frozen_rotation_(bodies.n_bodies(), Mat3::Identity()) {}

void Ties::begin_step(const State& start, double) {
  for (Index b = 0; b < bodies_.n_bodies(); ++b) frozen_rotation_[b] = bodies_.pose(start, b).rotation;
}

Vec3 Ties::mean(const Vec3* vectors, const TieTerm& term) const {
  Vec3 sum = Vec3::Zero();
  for (const auto& [node, v] : term.members) sum += vectors[layout_.first_vector(node) + v];
  return sum / static_cast<double>(term.members.size());
}

Ties::Deviation Ties::deviation(const State& state, const TieTerm& term) const {
  return deviation(mean(state.q.data(), term), bodies_.pose(state, term.body), term);
}

Vec3 Ties::expected(const State& state, const Vec3* last_step, const TieTerm& term) const {
  const Vec3 by_mean = mean(last_step, term);
  const Deviation d =
      deviation(mean(state.q.data(), term) - by_mean, bodies_.pose_before(state, last_step, term.body), term);
  Vec3 by_body = bodies_.turn(last_step, term.body).cross(d.arm);
  if (term.holds == TieTerm::Holds::point) by_body += bodies_.shift(last_step, term.body);
  return d.e + d.by_mean * by_mean - d.projector * by_body;
}

Ties::Deviation Ties::deviation(const Vec3& mean, const Pose& pose, const TieTerm& term) const {
  const Mat3& r = frozen_rotation_[term.body];
  Deviation d;
  d.arm = pose.rotation * term.reference;
  d.projector = d.by_mean = r * term.projector * r.transpose();
  d.unit = Vec3::Zero();
  if (term.holds == TieTerm::Holds::direction) {
    const double length = mean.norm();
    d.unit = mean / length;
    d.by_mean -= d.projector * d.arm * d.unit.transpose();
    d.arm *= length;
  }
  d.e = d.projector * (mean - d.arm - (term.holds == TieTerm::Holds::point ? pose.position : Vec3::Zero()));
  return d;
}

void Ties::add_sparsity(Pattern::Builder& builder) const {
  std::vector<Index> nodes;
  for (const TieTerm& term : terms_) {
    nodes.assign(1, bodies_.node(term.body));
    for (const auto& [node, v] : term.members) nodes.push_back(node);
    builder.add_clique(nodes);
  }
}

double Ties::energy(const State& state) const {
  double sum = 0;
  for (const TieTerm& term : terms_)
    sum += 0.5 * term.stiffness * static_cast<double>(term.members.size()) * deviation(state, term).e.squaredNorm();
  return sum;
}

void Ties::add(const State& state, Assembler& assembler) const {
  for (const TieTerm& term : terms_) {
    const auto n = static_cast<double>(term.members.size());
    const double k = term.stiffness * n;
    const Deviation d = deviation(state, term);
    // P is a projector, so P e = e.
    const Vec3 expected = k * (assembler.last_step() ? this->expected(state, assembler.last_step(), term) : d.e);
    const Vec3 f = assembler.expects_forces() ? expected : Vec3(k * d.e);
    const Vec3 by_mean = d.by_mean.transpose() * f;
    const bool is_point = term.holds == TieTerm::Holds::point, is_direction = term.holds == TieTerm::Holds::direction;
    const Index body = bodies_.node(term.body);
    for (const auto& [node, v] : term.members) assembler.add_force(node, v, by_mean / n);
    if (is_point) assembler.add_force(body, 0, -f);
    assembler.add_force(body, 1, -d.arm.cross(f));
    if (!assembler.wants_tangent()) continue;

    // k Jᵀ J, J = ∂e/∂(v̄, c, θ) = (by_mean, −P, P skew(arm)), and with the exact tangent the second derivatives of e.
    const Mat3 p = k * d.projector, arm = skew(d.arm);
    Mat3 mean_mean = k * d.by_mean.transpose() * d.by_mean, mean_rotation = k * d.by_mean.transpose() * arm,
         rotation = arm.transpose() * p * arm;
    if (assembler.tangent() == Assembler::Tangent::exact) {
      rotation -= rotation_hessian(expected, d.arm);
      if (is_direction) {
        // arm = |v̄| R X: its second derivatives are (R X) (1 − uuᵀ)/|v̄| by v̄, and uᵀ ⊗ (δθ × R X) by v̄ and θ.
        const double squared_length = d.arm.squaredNorm();
        mean_mean -= expected.dot(d.arm) / squared_length * (Mat3::Identity() - d.unit * d.unit.transpose());
        mean_rotation -= d.unit * d.arm.cross(expected).transpose() / std::sqrt(squared_length);
      }
    }
    for (std::size_t i = 0; i < term.members.size(); ++i) {
      const auto [node, v] = term.members[i];
      for (std::size_t j = 0; j <= i; ++j)
        add_pair(node, v, term.members[j].first, term.members[j].second, mean_mean / (n * n), assembler);
      if (is_point) add_pair(node, v, body, 0, -p / n, assembler);
      add_pair(node, v, body, 1, mean_rotation / n, assembler);
    }
    if (is_point) {
      add_pair(body, 0, body, 0, p, assembler);
      add_pair(body, 1, body, 0, -arm.transpose() * p, assembler);
    }
    add_pair(body, 1, body, 1, rotation, assembler);
  }
}

std::pair<Vec3, Vec3> Ties::pull(const State& state, Index body) const {
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
  for (const TieTerm& term : terms_) {
    if (term.body != body) continue;
    const Deviation d = deviation(state, term);
    const Vec3 f = -term.stiffness * static_cast<double>(term.members.size()) * d.e;
    if (term.holds == TieTerm::Holds::point) force += f;
    moment += d.arm.cross(f);
  }
  return {force, moment};
}

Follow::Deviation Follow::deviation(const State& state, const FollowTerm& term) const {
  return deviation(bodies_.pose(state, term.leader), bodies_.pose(state, term.follower), term);
}

double Follow::expected(const State& state, const Vec3* last_step, const FollowTerm& term) const {
  const Deviation d = deviation(bodies_.pose_before(state, last_step, term.leader),
                                bodies_.pose_before(state, last_step, term.follower), term);
  return d.e + bodies_.unit_force(term.follower, term.axis)
                   .dot(bodies_.shift(last_step, term.follower) - bodies_.shift(last_step, term.leader) -
                        bodies_.turn(last_step, term.leader).cross(d.arm));
}

Follow::Deviation Follow::deviation(const Pose& leader, const Pose& follower, const FollowTerm& term) const {
  const Vec3 arm =
      leader.rotation * term.leader_start.rotation.transpose() * (term.follower_start - term.leader_start.position);
  return {bodies_.unit_force(term.follower, term.axis).dot(follower.position - leader.position - arm), arm};
}

void Follow::add_sparsity(Pattern::Builder& builder) const {
  for (const FollowTerm& term : terms_)
    builder.add_clique(std::array{bodies_.node(term.follower), bodies_.node(term.leader)});
}

double Follow::energy(const State& state) const {
  double sum = 0;
  for (const FollowTerm& term : terms_) {
    const double e = deviation(state, term).e;
    sum += 0.5 * term.stiffness * e * e;
  }
  return sum;
}

void Follow::add(const State& state, Assembler& assembler) const {
  for (const FollowTerm& term : terms_) {
    const Index f = bodies_.node(term.follower), l = bodies_.node(term.leader);
    const Deviation d = deviation(state, term);
    const Vec3 axis = bodies_.unit_force(term.follower, term.axis), turn = d.arm.cross(axis);  // −∂e/∂θ of the leader
    const double k = term.stiffness;
    const double expected = k * (assembler.last_step() ? this->expected(state, assembler.last_step(), term) : d.e);
    const double force = assembler.expects_forces() ? expected : k * d.e;
    assembler.add_force(f, 0, force * axis);
    assembler.add_force(l, 0, -force * axis);
    assembler.add_force(l, 1, -force * turn);
    if (!assembler.wants_tangent()) continue;
    add_pair(f, 0, f, 0, k * axis * axis.transpose(), assembler);
    add_pair(l, 0, l, 0, k * axis * axis.transpose(), assembler);
    add_pair(l, 0, f, 0, -k * axis * axis.transpose(), assembler);
    add_pair(l, 1, f, 0, -k * turn * axis.transpose(), assembler);
    add_pair(l, 1, l, 0, k * turn * axis.transpose(), assembler);
    Mat3 rotation = k * turn * turn.transpose();
    if (assembler.tangent() == Assembler::Tangent::exact) rotation -= rotation_hessian(expected * axis, d.arm);
    add_pair(l, 1, l, 1, rotation, assembler);
  }
}

std::pair<Vec3, Vec3> Follow::pull(const State& state, Index leader) const {
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
  for (const FollowTerm& term : terms_) {
    if (term.leader != leader) continue;
    const Deviation d = deviation(state, term);
    const Vec3 f = -term.stiffness * d.e * bodies_.unit_force(term.follower, term.axis);
    force += f;
    moment += d.arm.cross(f);
  }
  return {force, moment};
}

std::vector<FollowTerm> Follow::outermost_first() const {
  std::vector<FollowTerm> sorted, open = terms_;
  while (!open.empty()) {  // no body follows itself
    std::set<Index> leaders;
    for (const FollowTerm& term : open) leaders.insert(term.leader);
    const auto ready = std::stable_partition(open.begin(), open.end(),
                                             [&](const FollowTerm& term) { return leaders.contains(term.follower); });
    if (ready == open.end()) break;
    sorted.insert(sorted.end(), ready, open.end());
    open.erase(ready, open.end());
  }
  return sorted;
}

void BodyLoads::add(const State&, Assembler& assembler) const {
  for (const LoadTerm& term : terms_) {
    const int d = static_cast<int>(term.dof);
    assembler.add_force(bodies_.node(term.body), d / 3, -value(term) * bodies_.unit_force(term.body, d % 3));
  }
}

double BodyLoads::energy(const State& state) const {
  double sum = 0;
  for (const LoadTerm& term : terms_)
    if (static_cast<int>(term.dof) < 3)
      sum -=
          value(term) * bodies_.in_dofs(term.body, bodies_.pose(state, term.body).position)[static_cast<int>(term.dof)];
  return sum;
}

}  // namespace trame::micro
