#include "micro/fiber/rod_space.h"

namespace trame::micro {

namespace {

class Builder {
 public:
  Builder(const FiberField& field, const State& state) : field_(field), state_(state) {
    const FiberMesh& mesh = field.mesh();
    Index n_parts = 0;
    for (Index j = 0; j < field.element_node(0, 0); ++j) add_as_it_is(j, n_parts++);
    for (Index f = 0; f < mesh.n_fibers(); ++f, ++n_parts) {
      if (field.model(f) == FiberModel::enriched)
        add_beam(f, n_parts);
      else
        for (Index j = field.element_node(f, 0); j <= field.last_node(f); ++j) add_as_it_is(j, n_parts);
    }
  }
  CoarseSpace space;

 private:
  [[nodiscard]] Index add_coarse_node(Index width) {
    space.first_dof.push_back(space.first_dof.back() + width);
    return space.n_coarse_nodes() - 1;
  }
  /// Space for the weights of a node that follows a coarse one.
  [[nodiscard]] Eigen::Map<Eigen::MatrixXd> link(Index coarse_node, Index height) {
    const Index width = space.width(coarse_node);
    space.links.push_back({coarse_node, space.weights.size()});
    space.weights.resize(space.weights.size() + static_cast<std::size_t>(height) * width, 0.0);
    return {space.weights.data() + space.links.back().weight, height, width};
  }
  void end_node(Index part) {
    space.part.push_back(part);
    space.link_start.push_back(space.links.size());
  }
  void add_as_it_is(Index node, Index part) {
    const Index width = 3 * field_.layout().n_vectors(node);
    link(add_coarse_node(width), width).setIdentity();
    end_node(part);
  }

  void add_beam(Index fiber, Index part) {
    const Index n = field_.mesh().n_nodes(fiber);
    const double h = field_.element_length(fiber);
    const auto cubic = hermite_shape(0, h), slope = hermite_shape_derivative(0, h);
    const auto tangent = [&](Index i) { return field_.curve(state_, fiber, 0.5 * h * static_cast<double>(i)).tangent; };
    Index joint = add_coarse_node(6);
    for (Index i = 0; i < n; ++i) {
      const Vec3* q = state_.q.data() + field_.layout().first_vector(field_.element_node(fiber, 0) + i);
      const auto follow = [&](Index coarse_node, double position, const Mat3& position_by_turn,
                              const Mat3& turn_by_position, const Mat3& turn) {
        auto w = link(coarse_node, 9);
        w.diagonal().head<3>().setConstant(position);
        w.block<3, 3>(0, 3) = position_by_turn;
        for (int a = 1; a < 3; ++a) {
          w.block<3, 3>(3 * a, 0) = -skew(q[a]) * turn_by_position;
          w.block<3, 3>(3 * a, 3) = -skew(q[a]) * turn;
        }
      };
      if (i % 2 == 0) {
        follow(joint, 1, Mat3::Zero(), Mat3::Zero(), Mat3::Identity());
      } else {
        const double stretch = tangent(i).norm();
        const Vec3 t = tangent(i) / stretch;
        const Mat3 turn_by_slope = skew(t) / stretch, twist = 0.5 * t * t.transpose();
        for (int side = 0; side < 2; ++side) {
          const Mat3 slope_by_turn = -skew(tangent(side == 0 ? i - 1 : i + 1));
          follow(side == 0 ? joint : add_coarse_node(6), 0.5, cubic[2 * side + 1] * slope_by_turn,
                 slope[2 * side] * turn_by_slope, slope[2 * side + 1] * turn_by_slope * slope_by_turn + twist);
        }
        ++joint;
      }
      end_node(part);
    }
  }

  const FiberField& field_;
  const State& state_;
};

}  // namespace

CoarseSpace rod_space(const FiberField& field, const State& state) { return Builder(field, state).space; }

}  // namespace trame::micro
