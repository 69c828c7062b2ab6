#include "micro/weave/flat_start.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <functional>
#include <numbers>
#include <numeric>
#include <unsupported/Eigen/Splines>

#include "micro/core/name_table.h"
#include "micro/scene/weave.h"
#include "micro/scene/yarn_section.h"

namespace trame::micro {

namespace {

using Curve = std::function<Vec3(double)>;  // of a parameter from 0 to 1

Curve spline_through(const std::vector<Vec3>& points) {
  Eigen::Matrix3Xd columns(3, points.size());
  for (std::size_t i = 0; i < points.size(); ++i) columns.col(static_cast<Eigen::Index>(i)) = points[i];
  const auto degree = std::min<Eigen::Index>(3, columns.cols() - 1);
  const auto spline = Eigen::SplineFitting<Eigen::Spline3d>::Interpolate(columns, degree);
  return [spline](double t) -> Vec3 { return spline(t); };
}

/// Unit vector normal to `direction`, as near as possible to `wanted`.
Vec3 normal_to(const Vec3& direction, const Vec3& wanted) {
  const Vec3 t = direction.normalized();
  const Vec3 n = wanted - wanted.dot(t) * t;
  return n.norm() > 1e-6 * wanted.norm() ? Vec3(n.normalized()) : Vec3(t.unitOrthogonal());
}

/// Appends a fiber along a curve: nodes at equal arc lengths, sections carried along without twist.
void append_fiber(Assembly& assembly, const Curve& curve, Index n_elements, double radius, double axial_stiffness,
                  Index type, const Vec3& section_axis) {
  const Index n_fine = 64 * n_elements;  // chords of the curve for its arc length
  std::vector<Vec3> fine(n_fine + 1);
  std::vector<double> arc(n_fine + 1, 0.0);
  for (Index i = 0; i <= n_fine; ++i) {
    fine[i] = curve(static_cast<double>(i) / n_fine);
    if (i > 0) arc[i] = arc[i - 1] + (fine[i] - fine[i - 1]).norm();
  }
  const Index n_nodes = 2 * n_elements + 1;
  FiberMesh& mesh = assembly.mesh;
  FiberConfiguration& c = assembly.configuration;
  Vec3 tangent_before = Vec3::Zero();
  for (Index i = 0, segment = 0; i < n_nodes; ++i) {
    const double s = arc.back() * i / (n_nodes - 1);
    while (segment < n_fine - 1 && arc[segment + 1] < s) ++segment;
    const double t = (segment + (s - arc[segment]) / (arc[segment + 1] - arc[segment])) / n_fine;
    const double dt = 0.25 / n_fine;  // central difference, one-sided at the ends
    const Vec3 tangent = (curve(std::min(t + dt, 1.0)) - curve(std::max(t - dt, 0.0))).normalized();
    c.r.push_back(curve(std::clamp(t, 0.0, 1.0)));
    c.tangent.push_back(tangent);
    const Vec3 carried =
        i == 0 ? section_axis : Vec3(Eigen::Quaterniond::FromTwoVectors(tangent_before, tangent) * c.g1.back());
    c.g1.push_back(normal_to(tangent, carried));
    c.g2.push_back(tangent.cross(c.g1.back()));
    mesh.arc_length.push_back(s);
    tangent_before = tangent;
  }
  mesh.first_node.push_back(mesh.first_node.back() + n_nodes);
  mesh.radius.push_back(radius);
  mesh.axial_stiffness.push_back(axial_stiffness);
  mesh.yarn_of_fiber.push_back(static_cast<Index>(mesh.yarns.size()) - 1);
  ++mesh.yarns.back().n_fibers;
  assembly.type_of_fiber.push_back(type);
}

void append_fiber(Assembly& assembly, const Scene& scene, const Curve& curve, Index n_elements, Index type,
                  const Vec3& section_axis) {
  const double r = scene.fiber_types[type].radius;
  const double ea = scene.materials[scene.fiber_types[type].material].young_modulus_axial * std::numbers::pi * r * r;
  append_fiber(assembly, curve, n_elements, r, ea, type, section_axis);
}

void begin_yarn(Assembly& assembly, const std::string& name, YarnFamily family) {
  assembly.mesh.yarns.push_back({name, family, assembly.mesh.n_fibers(), 0});
}

void append_bundle(Assembly& assembly, const Scene& scene, const BundleSpec& bundle) {
  begin_yarn(assembly, bundle.name, YarnFamily::free);
  const Curve axis = spline_through(bundle.points);
  const double spacing = 2 * scene.fiber_types[bundle.type].radius * bundle.lattice_spacing;
  // Frame of the axis, carried without twist along fine steps; `twist` turns the section in it.
  const Index n_steps = 64 * bundle.n_elements;
  std::vector<Mat3> frames(n_steps + 1);
  for (Index i = 0; i <= n_steps; ++i) {
    const double t = static_cast<double>(i) / n_steps, dt = 0.5 / n_steps;
    const Vec3 tangent = (axis(std::min(t + dt, 1.0)) - axis(std::max(t - dt, 0.0))).normalized();
    const Vec3 up = i == 0 ? Vec3::UnitZ() : Vec3(frames[i - 1].col(2));
    const Vec3 normal = normal_to(tangent, up);
    frames[i] << tangent, normal.cross(tangent), normal;
  }
  for (const Vec2& centre : hexagonal_section(bundle.n_fibers, bundle.n_layers, spacing)) {
    const Curve fiber = [&, centre](double t) -> Vec3 {
      const double at = std::clamp(t, 0.0, 1.0) * n_steps;
      const auto i = std::min<Index>(static_cast<Index>(at), n_steps - 1);
      const Mat3 frame = (1 - (at - i)) * frames[i] + (at - i) * frames[i + 1];
      const Eigen::Rotation2Dd turn(2 * std::numbers::pi * bundle.twist * t);
      const Vec2 c = turn * centre;
      return axis(t) + frame.col(1) * c[0] + frame.col(2) * c[1];
    };
    append_fiber(assembly, scene, fiber, bundle.n_elements, bundle.type, Vec3::UnitZ());
  }
}

Index add_body(Assembly& assembly, const std::string& name, const Vec3& position) {
  assembly.body_names.push_back(name);
  assembly.body_positions.push_back(position);
  return static_cast<Index>(assembly.body_names.size()) - 1;
}

/// The last fiber comes back to where it starts, a period on: its last node is its first one there.
void close_fiber(Assembly& assembly, const Vec3& period) {
  FiberConfiguration& c = assembly.configuration;
  const Index first = *(assembly.mesh.first_node.end() - 2);
  c.r.back() = c.r[first] + period;
  c.tangent.back() = c.tangent[first];
  c.g1.back() = c.g1[first];
  c.g2.back() = c.g2[first];
}

/// One yarn system of the weave: its yarns, a body at each yarn end, a body at each side of the patch; or, where yarns
/// come back to where they start, one that stands for their period.
void append_yarn_system(Assembly& assembly, const Scene& scene, const Weave& weave, const std::vector<double>& heights,
                        bool is_warp) {
  const YarnSystem &system = is_warp ? weave.warp : weave.weft, &crossing = is_warp ? weave.weft : weave.warp;
  const std::string family = is_warp ? "warp" : "weft";
  const double half_length = 0.5 * weave.yarn_length(system, crossing);
  const Vec3 weft = weave.weft_direction(), warp = Vec3::UnitX(), along = is_warp ? warp : weft,
             across = is_warp ? Vec3::UnitY() : Vec3(weft.y(), -weft.x(), 0);
  // Yarns are laid side by side along those that they cross; fibers in a yarn across it.
  const double pitch = weave.pitch(system);
  for (Index yarn = 0; yarn < system.n_yarns; ++yarn) {
    const Index column = yarn / system.n_layers;
    const Vec3 middle = pitch * (column - 0.5 * (system.n_columns() - 1)) * (is_warp ? weft : warp) +
                        heights[static_cast<std::size_t>(yarn)] * Vec3::UnitZ();
    const auto place = [&](double s, const Vec2& c) -> Vec3 {
      return middle + c[0] * across + s * along + c[1] * Vec3::UnitZ();
    };
    const std::string name = family + "/" + std::to_string(yarn + 1);
    begin_yarn(assembly, name, is_warp ? YarnFamily::warp : YarnFamily::weft);
    const Index first_fiber = assembly.mesh.n_fibers();
    const int period = is_warp ? 0 : 1;
    const YarnKind& kind = system.kind_of(yarn);
    for (const Vec2& c : yarn_section(kind, scene.fiber_types[kind.type].radius, yarn)) {
      const Vec3 from = place(-half_length, c), to = place(half_length, c);
      const Curve straight = [&](double t) -> Vec3 { return from + t * (to - from); };
      // Z twist is a right-handed screw; across and z turn the other way round a weft yarn.
      const double turns = 2 * half_length * kind.twist * (is_warp ? 1 : -1);
      const Curve helix = [&](double t) -> Vec3 {
        return place((2 * t - 1) * half_length, Eigen::Rotation2Dd(2 * std::numbers::pi * turns * t) * c);
      };
      append_fiber(assembly, scene, turns == 0 ? straight : helix, system.n_elements, kind.type, Vec3::UnitZ());
      assembly.mesh.period_of_fiber.push_back(system.periodic ? period : -1);
      if (system.periodic) close_fiber(assembly, 2 * half_length * along);
    }
    if (system.periodic) continue;
    for (const FiberEnd end : {FiberEnd::start, FiberEnd::end}) {
      const bool start = end == FiberEnd::start;
      const Index body = add_body(assembly, name + (start ? "/start" : "/end"),
                                  place(start ? -half_length : half_length, Vec2::Zero()));
      for (Index f = first_fiber; f < assembly.mesh.n_fibers(); ++f)
        assembly.ties.push_back({body, f, end, TieKind::clamped});
    }
  }
  if (system.periodic) {
    assembly.period_bodies[is_warp ? 0 : 1] = add_body(assembly, period_name(is_warp), 2 * half_length * along);
    return;
  }
  add_body(assembly, "side/" + family + "/start", -half_length * along);
  add_body(assembly, "side/" + family + "/end", half_length * along);
}

void append_weave(Assembly& assembly, const Scene& scene, const Weave& weave) {
  const Index first_yarn = static_cast<Index>(assembly.mesh.yarns.size());
  assembly.mesh.period_of_fiber.assign(assembly.mesh.n_fibers(), -1);
  const StartHeights heights = start_heights(scene);
  append_yarn_system(assembly, scene, weave, heights.warp, true);
  append_yarn_system(assembly, scene, weave, heights.weft, false);
  if (weave.is_skew()) {
    assembly.n_skew_bodies = static_cast<Index>(assembly.body_names.size());
    assembly.skew_axes.col(1) = weave.weft_direction();
  }
  for (Index i = 0; i < weave.weft.n_yarns; ++i)
    for (Index j = 0; j < weave.warp.n_yarns; ++j)
      assembly.crossings.push_back({first_yarn + j, first_yarn + weave.warp.n_yarns + i, weave.warp_above[i][j]});
  if (!weave.is_periodic()) assembly.mesh.period_of_fiber.clear();
  assembly.flat_height = heights.deepest;
}

void append_bodies(Assembly& assembly, const Scene& scene) {
  NameTable yarns;
  for (const Yarn& yarn : assembly.mesh.yarns) yarns.add(yarn.name);
  for (const BodySpec& spec : scene.bodies) {
    const Index body = add_body(assembly, spec.name, spec.position);
    for (const Tie& tie : spec.ties)
      for (const Index y : yarns.fitting(tie.fibers)) {
        const Yarn& yarn = assembly.mesh.yarns[y];
        for (Index f = yarn.first_fiber; f < yarn.first_fiber + yarn.n_fibers; ++f)
          assembly.ties.push_back({body, f, tie.end, tie.kind});
      }
  }
}

}  // namespace

Assembly assemble_scene(const Scene& scene) {
  Assembly assembly;
  for (const FiberSpec& fiber : scene.fibers) {
    begin_yarn(assembly, fiber.name, YarnFamily::free);
    append_fiber(assembly, scene, spline_through(fiber.points), fiber.n_elements, fiber.type,
                 fiber.section_axis.value_or(Vec3::UnitZ()));
  }
  for (const BundleSpec& bundle : scene.bundles) append_bundle(assembly, scene, bundle);
  if (scene.weave) append_weave(assembly, scene, *scene.weave);
  append_bodies(assembly, scene);
  return assembly;
}

}  // namespace trame::micro
