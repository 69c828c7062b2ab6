#include "micro/scene/test_stages.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <initializer_list>

#include "micro/core/wildcard.h"
#include "micro/scene/stages.h"
#include "micro/scene/weave.h"

namespace trame::micro {

namespace {

/// Bodies of the planes that press on fibers, from above and from below.
constexpr std::array<std::string_view, 2> plate_names = {"plate/upper", "plate/lower"};

BodyDof axis_of(bool warp) { return warp ? BodyDof::x : BodyDof::y; }
BodyDof rotation(BodyDof axis) { return static_cast<BodyDof>(static_cast<int>(axis) + 3); }
const char* family_of(bool warp) { return warp ? "warp" : "weft"; }
bool along_warp(const NamedTest& test) { return test.along_warp.value_or(true); }

/// Of a weave's plan, yarns × spacing of both systems, m².
double area_of(const Weave& weave) {
  return cell_width(weave, true) * cell_width(weave, false) / weave.weft_direction().y();
}

/// A stage under construction, all of whose drives go the same way.
class StageBuilder {
 public:
  StageBuilder(const NamedTest& test, const Scene& scene) : weave_(scene.weave ? &*scene.weave : nullptr) {
    stage_.name = name_of(test.kind);
    const Index n_ways = std::max(1, 2 * test.n_cycles);
    stage_.n_increments = n_ways * test.n_increments;
    for (Index way = 1; way <= n_ways && test.n_cycles > 0; ++way)
      amplitude_.points.push_back({static_cast<double>(way) / n_ways, way % 2 == 1 ? 1.0 : 0.0});
  }
  void strain(const std::string& bodies, BodyDof dof, double value) {
    stage_.drives.push_back({bodies, dof, DriveMode::strain, value, "", amplitude_});
  }
  /// Or turn, by an angle.
  void move(const std::string& bodies, BodyDof dof, double value) {
    stage_.drives.push_back({bodies, dof, DriveMode::displacement, value, "", amplitude_});
  }
  void release(const std::string& bodies, std::initializer_list<BodyDof> dofs) {
    for (const BodyDof dof : dofs) stage_.drives.push_back({bodies, dof, DriveMode::force, 0, "", {}});
  }
  void follow(const std::string& bodies, std::initializer_list<BodyDof> dofs, const std::string& leader) {
    for (const BodyDof dof : dofs) stage_.drives.push_back({bodies, dof, DriveMode::follow, 0, leader, {}});
  }
  void slide(const std::string& bodies) { stage_.sliding_ends = bodies; }
  [[nodiscard]] bool is_periodic(bool warp) const { return weave_ && (warp ? weave_->warp : weave_->weft).periodic; }
  /// Ends of a family follow the sides that are strained along it; a period is strained itself.
  void strain_sides(bool warp, double value) {
    const BodyDof axis = axis_of(warp);
    if (is_periodic(warp)) return strain(period_name(warp), axis, value);
    strain(fmt::format("side/{}/*", family_of(warp)), axis, value);
    for (const char* end : {"start", "end"})
      follow(fmt::format("{}/*/{}", family_of(warp), end), {axis}, fmt::format("side/{}/{}", family_of(warp), end));
  }
  [[nodiscard]] Stage stage() const { return stage_; }

 private:
  Stage stage_;
  Amplitude amplitude_;
  const Weave* weave_;  // nullptr: there is none
};

/// Both families by their strains; yarn ends spread with the patch across them.
void biaxial(const NamedTest& test, StageBuilder& stage) {
  const double warp = test.warp_strain.value_or(0), weft = test.weft_strain.value_or(0);
  stage.strain_sides(true, warp);
  if (!stage.is_periodic(false)) stage.strain("weft/*", BodyDof::x, warp);
  stage.strain_sides(false, weft);
  if (!stage.is_periodic(true)) stage.strain("warp/*", BodyDof::y, weft);
}

/// A yarn of one rod has nothing that resists a turn of its ends about its axis.
bool may_turn(const Scene& scene, const YarnKind& kind) {
  return kind.n_fibers > 1 || scene.fiber_types[kind.type].model != FiberModel::rod;
}

/// The ends of a family may turn about their yarns.
void release_turn(bool warp, const Scene& scene, StageBuilder& stage) {
  const YarnSystem& yarns = warp ? scene.weave->warp : scene.weave->weft;
  const BodyDof turn = rotation(axis_of(warp));
  if (std::all_of(yarns.kinds.begin(), yarns.kinds.end(), [&](const auto& kind) { return may_turn(scene, kind); }))
    return stage.release(fmt::format("{}/*", family_of(warp)), {turn});
  for (Index yarn = 0; yarn < yarns.n_yarns; ++yarn)
    if (may_turn(scene, yarns.kind_of(yarn))) stage.release(fmt::format("{}/{}/*", family_of(warp), yarn + 1), {turn});
}

/// All of a family's ends, or its period.
void release_all(bool warp, const Scene& scene, StageBuilder& stage) {
  if (stage.is_periodic(warp)) return stage.release(period_name(warp), {axis_of(warp)});
  const BodyDof tilt = rotation(axis_of(!warp));
  stage.release(fmt::format("{}/*", family_of(warp)), {BodyDof::x, BodyDof::y, BodyDof::z, tilt, BodyDof::rz});
  release_turn(warp, scene, stage);
}

/// The other family's ends are free.
void uniaxial(const NamedTest& test, const Scene& scene, StageBuilder& stage) {
  stage.strain_sides(along_warp(test), *test.strain);
  release_all(!along_warp(test), scene, stage);
}

/// The arms of a picture frame about its middle: one points along the warp, the other along the weft.
std::string arm_name(bool warp) { return fmt::format("frame/{}", family_of(warp)); }

/// A picture frame. Two arms turn about its middle, each by half the angle, and carry the sides across them, which turn
/// with the other arm: bars hinged at the corners. Yarn ends go with their side and turn with their yarn, as if hinged
/// on the bar, so that nothing bends at the edge. The curve is the work of all turns per angle and area of the fabric,
/// yarns × spacing of both systems: the shear force normalised as by Cao et al. (2008).
TestCurve picture_frame(const NamedTest& test, const Weave& weave, StageBuilder& stage) {
  TestCurve curve{"shear", "rad", "N/m", stage.stage().name, {}};
  const double area = area_of(weave);
  const auto turn = [&](const std::string& bodies, double sign) {
    stage.move(bodies, BodyDof::rz, sign * 0.5 * *test.angle);
  };
  for (const bool warp : {true, false}) {
    const std::string family = family_of(warp);
    const double sign = warp ? 1 : -1, work = 0.5 / area;
    turn(arm_name(warp), sign);
    turn(fmt::format("side/{}/*", family), -sign);
    turn(family + "/*", sign);
    stage.follow(fmt::format("side/{}/*", family), {BodyDof::x, BodyDof::y}, arm_name(warp));
    curve.terms.push_back({.body = arm_name(warp), .dof = BodyDof::rz, .motion = sign, .reaction = sign * work});
    for (const char* end : {"start", "end"}) {
      const std::string side = fmt::format("side/{}/{}", family, end);
      stage.follow(fmt::format("{}/*/{}", family, end), {BodyDof::x, BodyDof::y}, side);
      curve.terms.push_back({.body = side, .dof = BodyDof::rz, .reaction = -sign * work});
      for (Index yarn = 1; yarn <= (warp ? weave.warp : weave.weft).n_yarns; ++yarn)
        curve.terms.push_back(
            {.body = fmt::format("{}/{}/{}", family, yarn, end), .dof = BodyDof::rz, .reaction = sign * work});
    }
  }
  return curve;
}

/// Of a cell, the weft's period leans along the warp: simple shear.
std::optional<TestCurve> shear(const NamedTest& test, const Scene& scene, StageBuilder& stage) {
  if (test.angle) return picture_frame(test, *scene.weave, stage);
  stage.strain(period_name(false), BodyDof::x, *test.strain);
  return std::nullopt;
}

/// Leads both ends of a yarn across a strip that is bent.
std::string bar_name(bool warp, Index yarn) { return fmt::format("bar/{}/{}", family_of(warp), yarn); }

/// Yarns across a strip that is bent go where it does, both ends alike, and turn about themselves: the strip stays
/// straight across, as a part of a wide one.
void release_across(const NamedTest& test, const Scene& scene, StageBuilder& stage) {
  const bool warp = along_warp(test);
  for (Index yarn = 1; yarn <= (warp ? scene.weave->weft : scene.weave->warp).n_yarns; ++yarn) {
    stage.release(bar_name(!warp, yarn), {axis_of(warp), BodyDof::z});
    stage.follow(fmt::format("{}/{}/*", family_of(!warp), yarn), {axis_of(warp), BodyDof::z}, bar_name(!warp, yarn));
  }
  release_turn(!warp, scene, stage);
}

TieKind clamps(const NamedTest& test) { return test.clamps.value_or(TieKind::sliding); }

/// Pure bending: the sides of a family are rigid clamps that turn by half the angle each, up for a positive curvature.
/// All yarn ends of a side move with it about one axis; one side is free to go where no force acts on it.
TestCurve bending(const NamedTest& test, const Scene& scene, StageBuilder& stage) {
  const bool warp = along_warp(test);
  const std::string family = family_of(warp);
  const auto& [own, across] =
      warp ? std::tie(scene.weave->warp, scene.weave->weft) : std::tie(scene.weave->weft, scene.weave->warp);
  const BodyDof axis = axis_of(warp), turn = rotation(axis_of(!warp));
  const double up = warp ? -1 : 1;  // the sense in which a yarn's end turns up
  TestCurve curve{"bending", "1/m", "N", stage.stage().name, {}, scene.weave->yarn_length(own, across)};
  if (clamps(test) == TieKind::sliding) stage.slide(family + "/*");
  for (const char* end : {"start", "end"}) {
    const std::string side = fmt::format("side/{}/{}", family, end), ends = fmt::format("{}/*/{}", family, end);
    const double sign = (end == std::string_view("end") ? 1 : -1), per_width = 0.5 / cell_width(*scene.weave, warp);
    for (const std::string& bodies : {side, ends})
      stage.move(bodies, turn, sign * up * 0.5 * *test.curvature * curve.length);
    stage.follow(ends, {axis, BodyDof::z}, side);
    curve.terms.push_back({.body = side, .dof = turn, .motion = sign * up, .reaction = sign * up * per_width});
    for (Index yarn = 1; yarn <= own.n_yarns; ++yarn) {
      const std::string body = fmt::format("{}/{}/{}", family, yarn, end);
      curve.terms.push_back({.body = body, .dof = turn, .reaction = sign * up * per_width});
      curve.terms.push_back({.body = body, .dof = axis, .length = sign / own.n_yarns});
    }
  }
  stage.release(fmt::format("side/{}/end", family), {axis, BodyDof::z});
  release_across(test, scene, stage);
  return curve;
}

/// A bundle, by the turns of its ends; the one is held, no force acts on the other.
TestCurve yarn_bending(const NamedTest& test, const Scene& scene, StageBuilder& stage) {
  const BundleSpec& bundle = *bundle_of(test, scene);
  const Vec3 chord = bundle.points.back() - bundle.points.front(), along = chord.normalized();
  const Vec3 upward = std::abs(along.z()) < 1 - 1e-9 ? Vec3::UnitZ() : Vec3::UnitX();
  const Vec3 axis = along.cross(upward).normalized();  // a turn about it turns the yarn's end up
  TestCurve curve{"yarn_bending", "1/m", "N m", stage.stage().name, {}, chord.norm()};
  if (clamps(test) == TieKind::sliding) stage.slide(bundle.name + "/*");
  for (const char* end : {"start", "end"}) {
    const double sign = end == std::string_view("end") ? 1 : -1;
    const std::string body = fmt::format("{}/{}", bundle.name, end);
    for (int d = 0; d < 3; ++d) {
      if (axis[d] == 0) continue;
      const BodyDof turn = rotation(static_cast<BodyDof>(d));
      stage.move(body, turn, sign * 0.5 * *test.curvature * curve.length * axis[d]);
      curve.terms.push_back({.body = body, .dof = turn, .motion = sign * axis[d], .reaction = 0.5 * sign * axis[d]});
    }
  }
  stage.release(bundle.name + "/end", {BodyDof::x, BodyDof::y, BodyDof::z});
  return curve;
}

/// One end is drawn outward, the other one is free to follow through the fabric, all others are held.
void pull_out(const NamedTest& test, StageBuilder& stage) {
  const bool at_end = test.end.value_or(FiberEnd::end) == FiberEnd::end;
  const BodyDof axis = axis_of(is_warp(*test.yarn));
  stage.move(*test.yarn + (at_end ? "/end" : "/start"), axis, at_end ? *test.distance : -*test.distance);
  stage.release(*test.yarn + (at_end ? "/start" : "/end"), {axis});
}

/// A yarn of a weave is pulled at both ends, the end of a bundle away from its start.
void yarn_tension(const NamedTest& test, const Scene& scene, StageBuilder& stage) {
  const BundleSpec* bundle = bundle_of(test, scene);
  if (!bundle) return stage.strain(*test.yarn + "/*", axis_of(is_warp(*test.yarn)), *test.strain);
  const Vec3 chord = bundle->points.back() - bundle->points.front();
  for (int d = 0; d < 3; ++d) stage.move(*test.yarn + "/end", static_cast<BodyDof>(d), *test.strain * chord[d]);
}

/// Plates that touch when it begins close in from both sides, by their heights above and below the middle. On a weave
/// they press on yarns × spacing of both systems.
std::optional<TestCurve> compaction(const NamedTest& test, const Scene& scene, StageBuilder& stage) {
  for (const std::string_view plate : plate_names) stage.strain(std::string(plate), BodyDof::z, -*test.strain);
  if (!scene.weave) return std::nullopt;
  TestCurve curve{"plates", "m", "Pa", stage.stage().name, {}};
  const double area = area_of(*scene.weave);
  for (const std::size_t side : {0, 1}) {
    const double sign = side == 0 ? -1 : 1;
    curve.terms.push_back(
        {.body = std::string(plate_names[side]), .dof = BodyDof::z, .motion = sign, .reaction = 0.5 * sign / area});
  }
  return curve;
}

constexpr const char* indenter_name = "indenter";

/// A sphere that touches when it begins goes down onto the patch, whose yarn ends are held.
TestCurve indentation(const NamedTest& test, StageBuilder& stage) {
  stage.move(indenter_name, BodyDof::z, -*test.depth);
  return {"indentation",
          "m",
          "N",
          stage.stage().name,
          {{.body = indenter_name, .dof = BodyDof::z, .motion = -1, .reaction = -1}}};
}

/// Fibers that lie on each other all through the thickness resist the more steeply, the fewer ways are left to bend:
/// what they press into each other, other tests' hundredth of a radius, would hide the hysteresis.
constexpr double compaction_penetration = 0.001;

/// A body that carries a surface from the stage of the test on, and stands where it touches fibers as that begins.
void add_tool(const SceneValue& kind, const NamedTest& test, const std::string& name, const Surface& surface,
              Scene& scene) {
  NameTable known = body_names(scene);
  add_new_name(kind, name, known);
  SurfaceSpec spec;
  spec.surface = surface;
  spec.from_stage = name_of(test.kind);
  spec.touches = true;
  scene.bodies.push_back({name, Vec3::Zero(), {}, {spec}});
}

void add_plates(const SceneValue& kind, const NamedTest& test, Scene& scene) {
  for (const std::size_t side : {0, 1}) {
    Surface plane;
    plane.direction = (side == 0 ? -1 : 1) * Vec3::UnitZ();
    add_tool(kind, test, std::string(plate_names[side]), plane, scene);
  }
}

void add_indenter(const SceneValue& kind, const NamedTest& test, Scene& scene) {
  Surface sphere;
  sphere.shape = SurfaceShape::sphere;
  sphere.direction = -Vec3::UnitZ();
  sphere.radius = *test.radius;
  add_tool(kind, test, indenter_name, sphere, scene);
}

/// Adds a body without ties, for others to follow.
void add_leader(const SceneValue& kind, const std::string& name, Scene& scene) {
  NameTable known = body_names(scene);
  add_new_name(kind, name, known);
  scene.bodies.push_back({name, Vec3::Zero(), {}});
}

void add_bars(const SceneValue& kind, const NamedTest& test, Scene& scene) {
  const bool warp = along_warp(test);
  const Index n_across = (warp ? scene.weave->weft : scene.weave->warp).n_yarns;
  for (Index yarn = 1; yarn <= n_across; ++yarn) add_leader(kind, bar_name(!warp, yarn), scene);
}

void add_frame(const SceneValue& kind, Scene& scene) {
  for (const bool warp : {true, false}) add_leader(kind, arm_name(warp), scene);
}

/// Bodies at both ends of a bundle.
void add_end_bodies(const SceneValue& yarn, const BundleSpec& bundle, Scene& scene) {
  NameTable known = body_names(scene);
  for (const FiberEnd end : {FiberEnd::start, FiberEnd::end}) {
    const bool at_start = end == FiberEnd::start;
    BodySpec body{bundle.name + (at_start ? "/start" : "/end"),
                  at_start ? bundle.points.front() : bundle.points.back(),
                  {{bundle.name, end, TieKind::clamped}}};
    for (const BodySpec& other : scene.bodies)
      for (const Tie& tie : other.ties)
        if (tie.end == end && matches(tie.fibers, bundle.name))
          yarn.fail(fmt::format("must have free ends, but the {} of \"{}\" is tied to body \"{}\"",
                                at_start ? "start" : "end", bundle.name, other.name));
    add_new_name(yarn, body.name, known);
    scene.bodies.push_back(std::move(body));
  }
}

/// Ends that are let go spring into another shape, now and then at once, so that damping holds them back; the test
/// begins when they have come to rest.
std::optional<Stage> release_stage(const NamedTest& test, const Scene& scene) {
  constexpr Index n_increments = 10;
  constexpr double damping = 1e-3;
  StageBuilder builder(test, scene);
  const bool warp = along_warp(test);
  if (test.kind == NamedTestKind::uniaxial && !builder.is_periodic(!warp)) {
    release_all(!warp, scene, builder);
  } else if (test.kind == NamedTestKind::bending) {
    if (clamps(test) == TieKind::sliding) builder.slide(fmt::format("{}/*", family_of(warp)));
    builder.release(fmt::format("{}/*/end", family_of(warp)), {axis_of(warp)});
    release_across(test, scene, builder);
  } else {
    return std::nullopt;
  }
  Stage stage = builder.stage();
  stage.name = "release";
  stage.n_increments = n_increments;
  stage.proximal_start = damping;
  return stage;
}

}  // namespace

void add_test_bodies(const SceneValue& root, const NamedTest& test, Scene& scene) {
  const SceneValue table = *root.find("test"), kind = *table.find("kind");
  if (test.kind == NamedTestKind::shear && test.angle) add_frame(kind, scene);
  if (test.kind == NamedTestKind::bending) add_bars(kind, test, scene);
  if (test.kind == NamedTestKind::indentation) add_indenter(kind, test, scene);
  if (test.kind == NamedTestKind::compaction) add_plates(kind, test, scene);
  if (const BundleSpec* bundle = bundle_of(test, scene)) add_end_bodies(*table.find("yarn"), *bundle, scene);
}

void add_test_stage(const SceneValue& root, const NamedTest& test, Scene& scene) {
  const auto contact = root.find("contact");
  if (test.kind == NamedTestKind::compaction && !(contact && contact->find("target_penetration")))
    scene.contact.target_penetration = compaction_penetration;
  StageBuilder builder(test, scene);
  switch (test.kind) {
    case NamedTestKind::biaxial: biaxial(test, builder); break;
    case NamedTestKind::uniaxial: uniaxial(test, scene, builder); break;
    case NamedTestKind::shear: scene.test_curve = shear(test, scene, builder); break;
    case NamedTestKind::bending: scene.test_curve = bending(test, scene, builder); break;
    case NamedTestKind::pull_out: pull_out(test, builder); break;
    case NamedTestKind::yarn_tension: yarn_tension(test, scene, builder); break;
    case NamedTestKind::yarn_bending: scene.test_curve = yarn_bending(test, scene, builder); break;
    case NamedTestKind::indentation: scene.test_curve = indentation(test, builder); break;
    case NamedTestKind::compaction: scene.test_curve = compaction(test, scene, builder); break;
  }
  std::vector<Stage> stages;
  if (auto release = release_stage(test, scene)) stages.push_back(std::move(*release));
  stages.push_back(builder.stage());
  NameTable known;
  for (const Stage& earlier : scene.stages) known.add(earlier.name);
  for (Stage& stage : stages) {
    add_new_name(*root.find("test")->find("kind"), stage.name, known);
    stage.friction = scene.contact.friction;
    scene.stages.push_back(std::move(stage));
  }
}

}  // namespace trame::micro
