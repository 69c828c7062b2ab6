#pragma once
/// \file
/// Fibers as continuous curves over the unknowns of a system, whatever their model.

#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "micro/fiber/element_nodes.h"
#include "micro/fiber/fiber_mesh.h"
#include "micro/fiber/fiber_model.h"
#include "micro/solve/system.h"

namespace trame::micro {

/// Of something in a periodic cell, displaced by so many of each period vector.
using Image = std::array<int, 2>;

/// A point of a centre line, in one image of its fiber in a periodic cell: displaced by whole periods, none along which
/// the fiber itself runs. Along that its arc length has no end.
struct Foot {
  Index fiber = 0;
  double s = 0;
  Image image{};

  void keep(Archive& archive) { archive(fiber, s, image[0], image[1]); }
  /// Whether there is such a place.
  [[nodiscard]] bool is_on(const FiberMesh& mesh) const {
    return fiber >= 0 && fiber < mesh.n_fibers() && std::isfinite(s);
  }
};

/// What stands at the slots of a linear form of a place of a fiber: nodes of the fiber, and after them the period
/// vectors of the cell, of which only the first vector of the node counts.
struct Slots {
  static constexpr int most = 6;
  std::array<Index, most> node{};  ///< of the system
  int n_nodes = 0;                 ///< of the fiber: up to 4 enriched, 2 rod
  int n_slots = 0;                 ///< with the period vectors
  int n_vectors = 0;               ///< of a node of the fiber: 3 enriched, 2 rod

  [[nodiscard]] int vectors(int slot) const { return slot < n_nodes ? n_vectors : 1; }
  [[nodiscard]] bool touches(const Assembler& assembler) const {
    for (int a = 0; a < n_slots; ++a)
      if (assembler.owns(node[a])) return true;
    return false;
  }
};

/// A material point x(s, ξ) as a linear form of the unknowns: x = Σ weight[a][v] q(slot a, vector v). Vectors of a node
/// are (r, g₁, g₂) for enriched beams and (r, dr/ds) for rods; a rod has no ξ.
struct FiberPoint {
  Slots slots;
  std::array<std::array<double, 3>, Slots::most> weight{};

  [[nodiscard]] Vec3 evaluate(const Layout& layout, const State& state) const {
    Vec3 x = Vec3::Zero();
    for (int a = 0; a < slots.n_slots; ++a) {
      const Vec3* q = state.q.data() + layout.first_vector(slots.node[a]);
      for (int v = 0; v < slots.vectors(a); ++v) x += weight[a][v] * q[v];
    }
    return x;
  }
};

/// A place of a fiber as linear forms of its nodes' vectors: the centre line and its derivatives by arc length, and the
/// section vectors of an enriched beam. Weights of the centre line are for r and, in a rod, dr/ds.
struct CurveShape {
  using Weights = std::array<std::array<double, 2>, Slots::most>;
  Slots slots;
  Weights r{}, tangent{}, curvature{};
  std::array<double, Slots::most> section{};
};

/// Centre line at a point, with its derivatives by arc length up to the second.
struct CurveJet {
  Vec3 r, tangent, curvature;
};

/// Where the unknowns of each fiber stand, and the curves that they describe, which all have a continuous tangent: a
/// rod is the cubic through its nodes' vectors; the centre line of an enriched beam is taken through its nodes as
/// cubics with the slope of the parabola through each node and its two neighbours (Catmull, Rom, 1974). Its elements'
/// own parabolas meet at angles, at which contacts would jump. Section vectors are those of the elements, so that an
/// even pressure squeezes sections evenly.
class FiberField {
 public:
  /// Adds the nodes of all fibers to `layout`, fiber by fiber. `models` has one entry per fiber.
  /// `period_nodes`: nodes of `layout` whose first vectors are the period vectors; negative: there is none.
  FiberField(const FiberMesh& mesh, std::vector<FiberModel> models, Layout& layout,
             std::array<Index, 2> period_nodes = {-1, -1});

  [[nodiscard]] const FiberMesh& mesh() const { return *mesh_; }
  [[nodiscard]] const Layout& layout() const { return *layout_; }
  [[nodiscard]] FiberModel model(Index fiber) const { return models_[fiber]; }
  [[nodiscard]] double element_length(Index fiber) const { return element_length_[fiber]; }
  /// System node of the first node of element e of a fiber (3 nodes for enriched beams, 2 for rods).
  [[nodiscard]] Index element_node(Index fiber, Index e) const {
    return first_system_node_[fiber] + (models_[fiber] == FiberModel::enriched ? 2 * e : e);
  }
  /// The last one of its own: a fiber that comes back ends with its first node.
  [[nodiscard]] Index last_node(Index fiber) const { return first_system_node_[fiber + 1] - 1; }
  /// Whether an assembler owns nodes of a fiber, or may own its period.
  [[nodiscard]] bool touches(Index fiber, const Assembler& assembler) const {
    return mesh_->period(fiber) >= 0 || assembler.touches(element_node(fiber, 0), last_node(fiber));
  }
  /// Those of element e of a fiber.
  [[nodiscard]] ElementNodes element(Index fiber, Index e) const;

  [[nodiscard]] const std::array<Index, 2>& period_nodes() const { return period_nodes_; }
  [[nodiscard]] bool is_periodic() const { return period_nodes_[0] >= 0 || period_nodes_[1] >= 0; }
  /// Period vector 0 or 1; zero where there is none.
  [[nodiscard]] Vec3 period(const State& state, int which) const {
    return period_nodes_[which] < 0 ? Vec3::Zero() : state.q[layout_->first_vector(period_nodes_[which])];
  }
  /// Arc lengths between which a fiber is; without end where it comes back.
  struct Ends {
    double start, end;
  };
  [[nodiscard]] Ends ends(Index fiber) const {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    return mesh_->period(fiber) < 0 ? Ends{0, mesh_->length(fiber)} : Ends{-infinite, infinite};
  }
  /// Whether two fibers come back by the same period: then both go on together, and arc lengths of a pair count up to
  /// whole periods of both.
  [[nodiscard]] bool come_back_together(Index a, Index b) const {
    return mesh_->period(a) >= 0 && mesh_->period(a) == mesh_->period(b);
  }

  /// The place at arc length s; beyond an end the curve goes on as the last stretch.
  [[nodiscard]] CurveShape shape(const Foot& foot) const;
  [[nodiscard]] CurveShape shape(Index fiber, double s) const { return shape({fiber, s}); }
  [[nodiscard]] CurveJet curve(const State& state, const Foot& foot) const { return curve(state, shape(foot)); }
  [[nodiscard]] CurveJet curve(const State& state, Index fiber, double s) const {
    return curve(state, shape(fiber, s));
  }
  [[nodiscard]] CurveJet curve(const State& state, const CurveShape& shape) const;
  /// Section vectors at a place of an enriched fiber.
  [[nodiscard]] std::array<Vec3, 2> section(const State& state, const CurveShape& shape) const;
  /// Their derivatives by arc length, as smooth as those of the centre line.
  [[nodiscard]] std::array<Vec3, 2> section_slope(const State& state, const CurveShape& shape) const;
  /// Second derivatives, likewise.
  [[nodiscard]] std::array<Vec3, 2> section_curvature(const State& state, const CurveShape& shape) const;
  /// "fiber 3 of yarn warp/1 at 40 % of its length", for messages.
  [[nodiscard]] std::string describe(Index fiber, double s) const;
  /// The particle (s, ξ) as a linear form; ξ is ignored for rods.
  [[nodiscard]] FiberPoint particle(const Foot& foot, const Vec2& xi) const;
  [[nodiscard]] FiberPoint particle(Index fiber, double s, const Vec2& xi) const { return particle({fiber, s}, xi); }
  /// First and last of the nodes that the place at arc length s depends on, counted along the fiber from its first one.
  [[nodiscard]] std::pair<Index, Index> nodes_at(Index fiber, double s) const;
  /// Node of the system of a node so counted; a fiber that comes back has no last one.
  [[nodiscard]] Index wrapped_node(Index fiber, Index node) const;
  /// Whether nodes so counted are not all on the fiber's course from its start on, but a period `which` farther.
  [[nodiscard]] bool passes_seam(Index fiber, int which, Index first, Index last) const {
    return mesh_->period(fiber) == which && (first < 0 || last > last_node(fiber) - first_system_node_[fiber]);
  }

  /// Unknowns of a configuration, its period vectors with them, and back. The latter fills every node of the mesh;
  /// sections of rods are those that `configuration` holds, turned at each node with the tangent.
  void read_configuration(const FiberConfiguration& configuration, State& state) const;
  void write_configuration(const State& state, FiberConfiguration& configuration) const;

 private:
  /// The stretch between two nodes that s is in: its number, and where in it from 0 to 1.
  struct Stretch {
    Index number;
    double x;
  };
  [[nodiscard]] Stretch stretch(Index fiber, double s) const;
  /// Number of stretches between nodes of the system, and distance of these.
  [[nodiscard]] Index n_stretches(Index fiber) const {
    return last_node(fiber) - first_system_node_[fiber] + (mesh_->period(fiber) < 0 ? 0 : 1);
  }
  [[nodiscard]] double node_spacing(Index fiber) const { return mesh_->length(fiber) / n_stretches(fiber); }
  /// Of an enriched fiber that comes back, all but the last, which is that of the first node.
  void set_tangents(const State& state, Index fiber, FiberConfiguration& configuration) const;

  const FiberMesh* mesh_;
  const Layout* layout_;
  std::array<Index, 2> period_nodes_;
  std::vector<FiberModel> models_;
  std::vector<Index> first_system_node_;
  std::vector<double> element_length_;
};

/// Values and derivatives (by t ∈ [−1, 1]) of the quadratic Lagrange functions at −1, 0, 1.
[[nodiscard]] std::array<double, 3> quadratic_shape(double t);
[[nodiscard]] std::array<double, 3> quadratic_shape_derivative(double t);

/// Cubic Hermite functions of an element of length h for (r₁, r₁', r₂, r₂'), ' by arc length, and their derivatives by
/// arc length.
[[nodiscard]] std::array<double, 4> hermite_shape(double t, double h);
[[nodiscard]] std::array<double, 4> hermite_shape_derivative(double t, double h);
[[nodiscard]] std::array<double, 4> hermite_shape_second_derivative(double t, double h);

}  // namespace trame::micro
