#include "micro/scene/named_test.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <tuple>

#include "micro/scene/stages.h"
#include "micro/scene/weave.h"

namespace trame::micro {

namespace {

constexpr std::array<std::string_view, 6> kind_names = {"biaxial",  "uniaxial",     "shear",
                                                        "pull_out", "yarn_tension", "compaction"};

using Names = std::vector<std::string>;

NameTable yarns_of(const Scene& scene) {
  NameTable names(scene.weave ? yarn_names(*scene.weave) : Names());
  for (const BundleSpec& bundle : scene.bundles) names.add(bundle.name);
  return names;
}

bool is_warp(const std::string& yarn) { return yarn.starts_with("warp/"); }
BodyDof axis_of(bool warp) { return warp ? BodyDof::x : BodyDof::y; }

/// The bundle of that name, where there is one; yarns of a weave are none.
const BundleSpec* find_bundle(const Scene& scene, const std::string& name) {
  const auto found =
      std::find_if(scene.bundles.begin(), scene.bundles.end(), [&](const auto& bundle) { return bundle.name == name; });
  return found == scene.bundles.end() ? nullptr : &*found;
}

/// A stage under construction, all of whose drives go the same way.
class StageBuilder {
 public:
  StageBuilder(const NamedTest& test, const Scene& scene) : weave_(scene.weave ? &*scene.weave : nullptr) {
    stage_.name = kind_names[static_cast<std::size_t>(test.kind)];
    const Index n_ways = std::max(1, 2 * test.n_cycles);
    stage_.n_increments = n_ways * test.n_increments;
    for (Index way = 1; way <= n_ways && test.n_cycles > 0; ++way)
      amplitude_.points.push_back({static_cast<double>(way) / n_ways, way % 2 == 1 ? 1.0 : 0.0});
  }
  void strain(const std::string& bodies, BodyDof dof, double value) {
    stage_.drives.push_back({bodies, dof, DriveMode::strain, value, "", amplitude_});
  }
  void move(const std::string& bodies, BodyDof dof, double value) {
    stage_.drives.push_back({bodies, dof, DriveMode::displacement, value, "", amplitude_});
  }
  void release(const std::string& bodies, std::initializer_list<BodyDof> dofs) {
    for (const BodyDof dof : dofs) stage_.drives.push_back({bodies, dof, DriveMode::force, 0, "", {}});
  }
  [[nodiscard]] bool is_periodic(const std::string& family) const {
    return weave_ && (family == "warp" ? weave_->warp : weave_->weft).periodic;
  }
  /// Ends of a family follow the sides that are strained along it; a period is strained itself.
  void strain_sides(const std::string& family, double value) {
    const BodyDof axis = axis_of(family == "warp");
    if (is_periodic(family)) return strain(period_name(family == "warp"), axis, value);
    strain(fmt::format("side/{}/*", family), axis, value);
    for (const char* end : {"start", "end"})
      stage_.drives.push_back({fmt::format("{}/*/{}", family, end),
                               axis,
                               DriveMode::follow,
                               0,
                               fmt::format("side/{}/{}", family, end),
                               {}});
  }
  [[nodiscard]] Stage stage() const { return stage_; }

 private:
  Stage stage_;
  Amplitude amplitude_;
  const Weave* weave_;  // nullptr: there is none
};

/// Fails for keys that the kind of test does not know, and for those that it lacks.
void check_keys(const SceneValue& table, NamedTestKind kind) {
  struct Own {
    Names needed, allowed;
  };
  static const std::array<Own, 6> keys = {{{{}, {"warp_strain", "weft_strain"}},
                                           {{"strain"}, {"direction"}},
                                           {{"strain"}, {}},
                                           {{"yarn", "distance"}, {"end"}},
                                           {{"yarn", "strain"}, {}},
                                           {{"strain"}, {}}}};
  const Own& own = keys[static_cast<std::size_t>(kind)];
  const std::string name(kind_names[static_cast<std::size_t>(kind)]);
  for (const std::string& key : own.needed)
    if (!table.find(key)) table.fail_missing(key, fmt::format("what test \"{}\" needs", name));
  for (const char* key : {"warp_strain", "weft_strain", "strain", "direction", "yarn", "end", "distance"}) {
    const bool known = std::find(own.needed.begin(), own.needed.end(), key) != own.needed.end() ||
                       std::find(own.allowed.begin(), own.allowed.end(), key) != own.allowed.end();
    if (const auto value = table.find(key); value && !known)
      value->fail(fmt::format("is none of test \"{}\"; it has {}", name, [&] {
        Names all = own.needed;
        all.insert(all.end(), own.allowed.begin(), own.allowed.end());
        return allowed_names(all);
      }()));
  }
}

NamedTest read_test_table(const SceneValue& table, const Scene& scene) {
  NamedTest test;
  read_table(table, named_test_keys(yarns_of(scene)), {}, test);
  check_keys(table, test.kind);
  const bool needs_weave = test.kind != NamedTestKind::yarn_tension && test.kind != NamedTestKind::compaction;
  if (needs_weave && !scene.weave)
    table.find("kind")->fail("needs a [weave]; of a bundle there are \"yarn_tension\" and \"compaction\"");
  if (test.kind == NamedTestKind::compaction && !(*test.strain > 0 && *test.strain < 1))
    table.find("strain")->fail("must be greater than 0 and less than 1: the part of the thickness that is pressed out");
  if (test.kind == NamedTestKind::shear && !(scene.weave->warp.periodic && scene.weave->weft.periodic))
    table.find("kind")->fail("needs a [weave] that is periodic both ways; at a patch it would be its sides that shear");
  if (test.yarn && !find_bundle(scene, *test.yarn) &&
      (is_warp(*test.yarn) ? scene.weave->warp : scene.weave->weft).periodic)
    table.find("yarn")->fail("must be a yarn with ends, but the weave is periodic along it");
  if (test.kind == NamedTestKind::biaxial && test.warp_strain.value_or(0) == 0 && test.weft_strain.value_or(0) == 0)
    table.fail("test \"biaxial\" must have a warp_strain or a weft_strain other than 0");
  if (test.kind == NamedTestKind::pull_out) {
    if (find_bundle(scene, *test.yarn)) table.find("yarn")->fail("must be a yarn of the weave");
    const Weave& weave = *scene.weave;
    const auto& [own, across] =
        is_warp(*test.yarn) ? std::tie(weave.warp, weave.weft) : std::tie(weave.weft, weave.warp);
    const double most = weave.yarn_length(own, across);
    if (*test.distance > most)
      table.find("distance")->fail(fmt::format("must be at most {:g} m, the length of the yarn", most));
  }
  return test;
}

/// Both families by their strains; yarn ends spread with the patch across them.
void biaxial(const NamedTest& test, StageBuilder& stage) {
  const double warp = test.warp_strain.value_or(0), weft = test.weft_strain.value_or(0);
  stage.strain_sides("warp", warp);
  if (!stage.is_periodic("weft")) stage.strain("weft/*", BodyDof::x, warp);
  stage.strain_sides("weft", weft);
  if (!stage.is_periodic("warp")) stage.strain("warp/*", BodyDof::y, weft);
}

/// A yarn of one rod has nothing that resists a turn of its ends about its axis.
bool may_turn(const Scene& scene, const YarnKind& kind) {
  return kind.n_fibers > 1 || scene.fiber_types[kind.type].model != FiberModel::rod;
}

/// The ends of the family that is not pulled.
void release_ends(const NamedTest& test, const Scene& scene, StageBuilder& stage) {
  const bool warp = test.along_warp.value_or(true);
  const std::string other = warp ? "weft" : "warp";
  if (stage.is_periodic(other)) return stage.release(period_name(!warp), {axis_of(!warp)});
  const YarnSystem& yarns = warp ? scene.weave->weft : scene.weave->warp;
  const BodyDof turn = warp ? BodyDof::ry : BodyDof::rx, tilt = warp ? BodyDof::rx : BodyDof::ry;
  stage.release(other + "/*", {BodyDof::x, BodyDof::y, BodyDof::z, tilt, BodyDof::rz});
  if (std::all_of(yarns.kinds.begin(), yarns.kinds.end(), [&](const auto& kind) { return may_turn(scene, kind); }))
    return stage.release(other + "/*", {turn});
  for (Index yarn = 0; yarn < yarns.n_yarns; ++yarn)
    if (may_turn(scene, yarns.kind_of(yarn))) stage.release(fmt::format("{}/{}/*", other, yarn + 1), {turn});
}

/// The other family's ends are free.
void uniaxial(const NamedTest& test, const Scene& scene, StageBuilder& stage) {
  stage.strain_sides(test.along_warp.value_or(true) ? "warp" : "weft", *test.strain);
  release_ends(test, scene, stage);
}

/// Ends that are let go spring into another shape, now and then at once, so that damping holds them back; the test
/// begins when they have come to rest.
Stage release_stage(const NamedTest& test, const Scene& scene) {
  constexpr Index n_increments = 10;
  constexpr double damping = 1e-3;
  StageBuilder builder(test, scene);
  release_ends(test, scene, builder);
  Stage stage = builder.stage();
  stage.name = "release";
  stage.n_increments = n_increments;
  stage.proximal_start = damping;
  return stage;
}

/// The weft's period leans along the warp: simple shear.
void shear(const NamedTest& test, StageBuilder& stage) { stage.strain(period_name(false), BodyDof::x, *test.strain); }

/// One end is drawn outward, the other one is free to follow through the fabric, all others are held.
void pull_out(const NamedTest& test, StageBuilder& stage) {
  const bool at_end = test.end.value_or(FiberEnd::end) == FiberEnd::end;
  const BodyDof axis = axis_of(is_warp(*test.yarn));
  stage.move(*test.yarn + (at_end ? "/end" : "/start"), axis, at_end ? *test.distance : -*test.distance);
  stage.release(*test.yarn + (at_end ? "/start" : "/end"), {axis});
}

/// A yarn of a weave is pulled at both ends, the end of a bundle away from its start.
void yarn_tension(const NamedTest& test, const Scene& scene, StageBuilder& stage) {
  const BundleSpec* bundle = find_bundle(scene, *test.yarn);
  if (!bundle) return stage.strain(*test.yarn + "/*", axis_of(is_warp(*test.yarn)), *test.strain);
  const Vec3 chord = bundle->points.back() - bundle->points.front();
  for (int d = 0; d < 3; ++d) stage.move(*test.yarn + "/end", static_cast<BodyDof>(d), *test.strain * chord[d]);
}

/// Plates that touch when it begins close in from both sides, by their heights above and below the middle.
void compaction(const NamedTest& test, StageBuilder& stage) {
  for (const std::string_view plate : plate_names) stage.strain(std::string(plate), BodyDof::z, -*test.strain);
}

/// Fibers that lie on each other all through the thickness resist the more steeply, the fewer ways are left to bend:
/// what they press into each other, other tests' hundredth of a radius, would hide the hysteresis.
constexpr double compaction_penetration = 0.001;

void add_plates(const SceneValue& kind, Scene& scene) {
  NameTable known = body_names(scene);
  for (const std::size_t side : {0, 1}) {
    SurfaceSpec surface;
    surface.surface.direction = (side == 0 ? -1 : 1) * Vec3::UnitZ();
    surface.from_stage = kind_names[static_cast<std::size_t>(NamedTestKind::compaction)];
    surface.touches = true;
    BodySpec plate{std::string(plate_names[side]), Vec3::Zero(), {}, {surface}};
    add_new_name(kind, plate.name, known);
    scene.bodies.push_back(std::move(plate));
  }
}

}  // namespace

std::vector<Key<NamedTest>> named_test_keys(const NameTable& yarns) {
  using T = NamedTest;
  NamedValues<NamedTestKind> kinds;
  for (std::size_t k = 0; k < kind_names.size(); ++k) kinds.emplace_back(kind_names[k], static_cast<NamedTestKind>(k));
  const auto strains = quantity(ratio, between(-10, 10));
  return {
      key<T>("kind", &T::kind, choice(kinds), "which test; its stage has this name and comes after all others")
          .needed(),
      key<T>("warp_strain", &T::warp_strain, strains, "biaxial: of the patch along the warp").otherwise("default: 0"),
      key<T>("weft_strain", &T::weft_strain, strains, "biaxial: of the patch along the weft").otherwise("default: 0"),
      key<T>("strain", &T::strain, strains,
             "uniaxial: of the patch; shear: of a cell's weft along its warp; yarn_tension: of the yarn's length; "
             "compaction: part of the thickness by which the plates plate/upper and plate/lower close in")
          .otherwise("needed there"),
      key<T>("direction", &T::along_warp, choice<bool>({{"warp", true}, {"weft", false}}),
             "uniaxial: the family that is pulled; the ends of the other are free")
          .otherwise("default: \"warp\""),
      key<T>("yarn", &T::yarn, existing_name("a yarn", yarns),
             "pull_out, yarn_tension: which; other yarns are held. A bundle gets the bodies NAME/start and NAME/end")
          .otherwise("needed there"),
      key<T>("end", &T::end, choice<FiberEnd>({{"start", FiberEnd::start}, {"end", FiberEnd::end}}),
             "pull_out: the end that is drawn; the other one is free along the yarn")
          .otherwise("default: \"end\""),
      key<T>("distance", &T::distance, quantity(length, above(0)), "pull_out: that the end is drawn")
          .otherwise("needed there"),
      key<T>("increments", &T::n_increments, integer(between(1, 100000)), "of a way, there or back"),
      key<T>("cycles", &T::n_cycles, integer(between(0, 1000)), "there and back; 0: there only")};
}

std::optional<NamedTest> read_test(const SceneValue& root, const Scene& scene) {
  const auto table = root.find("test");
  return table ? std::optional(read_test_table(*table, scene)) : std::nullopt;
}

void add_test_bodies(const SceneValue& root, const NamedTest& test, Scene& scene) {
  if (test.kind == NamedTestKind::compaction) return add_plates(*root.find("test")->find("kind"), scene);
  const BundleSpec* bundle = test.yarn ? find_bundle(scene, *test.yarn) : nullptr;
  if (!bundle) return;
  const SceneValue yarn = *root.find("test")->find("yarn");
  NameTable known = body_names(scene);
  for (const FiberEnd end : {FiberEnd::start, FiberEnd::end}) {
    const bool at_start = end == FiberEnd::start;
    BodySpec body{bundle->name + (at_start ? "/start" : "/end"),
                  at_start ? bundle->points.front() : bundle->points.back(),
                  {{bundle->name, end, TieKind::clamped}}};
    for (const BodySpec& other : scene.bodies)
      for (const Tie& tie : other.ties)
        if (tie.end == end && matches(tie.fibers, bundle->name))
          yarn.fail(fmt::format("must have free ends, but the {} of \"{}\" is tied to body \"{}\"",
                                at_start ? "start" : "end", bundle->name, other.name));
    add_new_name(yarn, body.name, known);
    scene.bodies.push_back(std::move(body));
  }
}

void add_test_stage(const SceneValue& root, const NamedTest& test, Scene& scene) {
  const auto contact = root.find("contact");
  if (test.kind == NamedTestKind::compaction && !(contact && contact->find("target_penetration")))
    scene.contact.target_penetration = compaction_penetration;
  StageBuilder builder(test, scene);
  switch (test.kind) {
    case NamedTestKind::biaxial: biaxial(test, builder); break;
    case NamedTestKind::uniaxial: uniaxial(test, scene, builder); break;
    case NamedTestKind::shear: shear(test, builder); break;
    case NamedTestKind::pull_out: pull_out(test, builder); break;
    case NamedTestKind::yarn_tension: yarn_tension(test, scene, builder); break;
    case NamedTestKind::compaction: compaction(test, builder); break;
  }
  std::vector<Stage> stages;
  const bool lets_ends_go =
      test.kind == NamedTestKind::uniaxial && !builder.is_periodic(test.along_warp.value_or(true) ? "weft" : "warp");
  if (lets_ends_go) stages.push_back(release_stage(test, scene));
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
