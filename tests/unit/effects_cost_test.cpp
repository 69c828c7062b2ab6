/// \file
/// What a scene does not call for costs nothing: unknowns, couplings, searches, terms and memory of every combination
/// of effects, counted.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "micro/fiber/enriched_beam.h"
#include "micro/fiber/rod.h"
#include "micro/model/model.h"
#include "tests/support/finite_differences.h"
#include "tests/support/run_scene.h"

namespace trame::micro {
namespace {

struct Combination {
  FiberModel model = FiberModel::enriched;
  ContactScope scope = ContactScope::all;
  bool self_contact = false, friction = false, adapt_penalty = false, twist_stretch = false, body = false;
};

std::string text(const Combination& c) {
  return fmt::format("{}, contact {}{}{}{}{}{}", c.model == FiberModel::rod ? "rods" : "enriched",
                     c.scope == ContactScope::all             ? "all"
                     : c.scope == ContactScope::between_yarns ? "between yarns"
                                                              : "none",
                     c.self_contact ? ", self" : "", c.friction ? ", friction" : "", c.adapt_penalty ? ", adapted" : "",
                     c.twist_stretch ? ", twist-stretch" : "", c.body ? ", a body" : "");
}

/// Every combination that a scene file may ask for.
std::vector<Combination> combinations() {
  std::vector<Combination> all;
  for (int bits = 0; bits < 1 << 6; ++bits)
    for (const auto scope : {ContactScope::all, ContactScope::between_yarns, ContactScope::none}) {
      const auto bit = [&](int i) { return (bits >> i & 1) != 0; };
      const Combination c{
          bit(0) ? FiberModel::rod : FiberModel::enriched, scope, bit(1), bit(2), bit(3), bit(4), bit(5)};
      if (scope == ContactScope::none && (c.self_contact || c.friction || c.adapt_penalty)) continue;
      if (c.model == FiberModel::rod && c.twist_stretch) continue;
      all.push_back(c);
    }
  return all;
}

constexpr Index bundle_elements = 6, hairpin_elements = 12;
/// Fibers come before bundles.
constexpr Index first_of_a = 1, first_of_b = 4;

/// Two bundles of three fibers of radius 1, one pressed into the other, and a fiber that comes back along itself.
Scene touching_fibers(const Combination& c) {
  Scene scene;
  scene.materials = {test::isotropic(1, 0.3)};
  scene.fiber_types = {{"f", 0, 1.0, c.model}};
  const auto bundle = [](const char* name, double z) {
    return BundleSpec{name, 0, {{0, 0, z}, {24, 0, z}}, bundle_elements, 3, 1, 1.05, 0};
  };
  scene.bundles = {bundle("a", 0), bundle("b", 1.9)};
  FiberSpec hairpin{"hairpin", 0, {}, hairpin_elements, {}};
  for (int i = 0; i <= 7; ++i) hairpin.points.emplace_back(2 * i, 20, 0);
  hairpin.points.emplace_back(15.1, 20, 1.1);
  for (int i = 7; i >= 0; --i) hairpin.points.emplace_back(2 * i, 20, 2.2);
  scene.fibers = {hairpin};
  if (c.body) scene.bodies = {{"grip", {0, 0, 0}, {{"a", FiberEnd::start, TieKind::clamped}}}};
  scene.contact.scope = c.scope;
  scene.contact.self_contact = c.self_contact;
  scene.contact.friction = c.friction;
  scene.contact.adapt_penalty = c.adapt_penalty;
  scene.twist_stretch = c.twist_stretch;
  return scene;
}

Stage quiet_stage() {
  Stage stage;
  stage.name = "s";
  return stage;
}

/// A stage that has gone through two detections and one accepted increment, in which bundle b slid along a.
struct Counted {
  explicit Counted(const Scene& scene, const Stage& stage = quiet_stage())
      : assembly(assemble_scene(scene)), model(scene, assembly, stage, start_of(assembly)), state(model.start) {
    for (Index f = first_of_b; f < assembly.mesh.n_fibers(); ++f)
      for (Index n = model.field.element_node(f, 0); n <= model.field.last_node(f); ++n)
        state.q[model.layout.first_vector(n)] += Vec3(0.02, 0, 0);
    for (const auto& effect : model.effects) {
      effect->begin_step(model.start, 0.5);
      effect->update(model.start);
      effect->update(model.start);
      effect->commit(state);
    }
    Pattern::Builder builder;
    for (const auto& effect : model.effects) effect->add_sparsity(builder);
    pattern = Pattern(model.layout, std::move(builder));
  }

  [[nodiscard]] std::vector<std::string> effects() const {
    std::vector<std::string> names;
    for (const auto& effect : model.effects) names.emplace_back(effect->name());
    return names;
  }
  template <class T>
  [[nodiscard]] const T* find() const {
    for (const auto& effect : model.effects)
      if (const auto* found = dynamic_cast<const T*>(effect.get())) return found;
    return nullptr;
  }

  Assembly assembly;
  StageModel model;
  State state;
  Pattern pattern;
};

Index expected_dofs(const Combination& c) {
  const auto of_fiber = [&](Index n) { return c.model == FiberModel::enriched ? 9 * (2 * n + 1) : 6 * (n + 1); };
  return 6 * of_fiber(bundle_elements) + of_fiber(hairpin_elements) + (c.body ? 6 : 0);
}

/// Nodes that a contact at arc length s of a fiber may come to act on before it is looked for again: those to either
/// side of s, of an enriched beam also the next ones, and the same at 1 % of the distance of nodes to either side.
std::vector<Index> nodes_beside(const FiberField& field, Index fiber, double s) {
  const bool enriched = field.model(fiber) == FiberModel::enriched;
  const Index first = field.element_node(fiber, 0), n = field.last_node(fiber) - first + 1, more = enriched ? 1 : 0;
  const double place = s / field.mesh().length(fiber) * (n - 1), beside = enriched ? 0.01 : 0.005;
  const auto before = [&](double x) { return std::clamp(static_cast<Index>(std::floor(x)), Index{0}, n - 2); };
  Index low = before(place - beside) - more, high = before(place + beside) + 1 + more;
  // At an end as many as elsewhere.
  if (enriched && low < 0) high = std::max(high, 3);
  if (enriched && high > n - 1) low = std::min(low, n - 4);
  std::vector<Index> nodes;
  for (Index k = std::max(low, 0); k <= std::min(high, n - 1); ++k) nodes.push_back(first + k);
  return nodes;
}

/// Entries of the lower triangle, diagonal blocks whole, that the items of the scene couple: counted one by one.
std::size_t expected_entries(const Combination& c, const Counted& counted) {
  const FiberField& field = counted.model.field;
  std::set<std::pair<Index, Index>> pairs;
  const auto couple = [&](const std::vector<Index>& nodes) {
    for (const Index i : nodes)
      for (const Index j : nodes)
        if (i >= j) pairs.emplace(i, j);
  };
  const int per_element = c.model == FiberModel::enriched ? 3 : 2;
  for (Index f = 0; f < field.mesh().n_fibers(); ++f)
    for (Index e = 0; e < field.mesh().n_elements(f); ++e) {
      std::vector<Index> nodes;
      for (int n = 0; n < per_element; ++n) nodes.push_back(field.element_node(f, e) + n);
      couple(nodes);
    }
  for (Index f = first_of_a; f < first_of_b && c.body; ++f) couple({0, field.element_node(f, 0)});
  if (counted.model.contact)
    for (const ContactElement& e : counted.model.contact->elements()) {
      std::vector<Index> nodes = nodes_beside(field, e.fiber_a, e.s_a);
      const std::vector<Index> of_b = nodes_beside(field, e.fiber_b, e.s_b);
      nodes.insert(nodes.end(), of_b.begin(), of_b.end());
      couple(nodes);
    }
  std::size_t entries = 0;
  const Layout& layout = counted.model.layout;
  for (const auto& [i, j] : pairs) entries += static_cast<std::size_t>(9 * layout.n_vectors(i) * layout.n_vectors(j));
  return entries;
}

TEST(EffectsCost, OnlyWhatIsCalledForIsBuilt) {
  for (const Combination& c : combinations()) {
    SCOPED_TRACE(text(c));
    const Counted counted(touching_fibers(c));
    std::vector<std::string> expected = {c.model == FiberModel::rod ? "rods" : "enriched beams"};
    if (c.scope != ContactScope::none) expected.emplace_back("contact");
    if (c.body) expected.emplace_back("ties");
    EXPECT_EQ(counted.effects(), expected);
    EXPECT_EQ(counted.model.layout.n_dofs(), expected_dofs(c));
    EXPECT_EQ(counted.pattern.n_values(), expected_entries(c, counted));
  }
}

TEST(EffectsCost, SearchesLookOnlyForWhatIsAsked) {
  for (const Combination& c : combinations()) {
    SCOPED_TRACE(text(c));
    const Counted counted(touching_fibers(c));
    const Contact* contact = counted.model.contact;
    ASSERT_EQ(contact != nullptr, c.scope != ContactScope::none);
    if (!contact) continue;
    EXPECT_EQ(contact->n_searches(), 2);
    int within = 0, between = 0, self = 0;
    for (const ContactElement& e : contact->elements()) {
      const bool same_yarn =
          counted.assembly.mesh.yarn_of_fiber[e.fiber_a] == counted.assembly.mesh.yarn_of_fiber[e.fiber_b];
      ++(e.fiber_a == e.fiber_b ? self : same_yarn ? within : between);
    }
    EXPECT_GT(between, 0);
    EXPECT_EQ(within > 0, c.scope == ContactScope::all);
    EXPECT_EQ(self > 0, c.self_contact);
  }
}

TEST(EffectsCost, FrictionAndAdaptationKeepNothingWhereTheyAreOff) {
  for (const Combination& c : combinations()) {
    SCOPED_TRACE(text(c));
    if (c.scope == ContactScope::none) continue;
    Counted counted(touching_fibers(c));
    Contact& contact = *counted.model.contact;
    const std::size_t n = contact.elements().size();
    EXPECT_EQ(contact.history().size(), n);
    EXPECT_EQ(contact.stick_slip().size(), c.friction ? n : 0);
    EXPECT_EQ(contact.tractions().size(), c.friction ? n : 0);
    int n_adapted = 0;
    for (const ContactHistory& h : contact.history()) {
      EXPECT_EQ(h.traction >= 0, c.friction);
      n_adapted += h.penalty_scale != 1;
    }
    EXPECT_EQ(n_adapted > 0, c.adapt_penalty);
    const auto work = [&] { return contact.ledger(counted.model.start)[Source::preloads]; };
    EXPECT_EQ(work(), 0);  // what the first commit has adapted acts from the next step on
    contact.begin_step(counted.model.start, 0.6);
    contact.update(counted.model.start);
    contact.commit(counted.model.start);
    EXPECT_EQ(std::abs(work()) > 1e-9, c.adapt_penalty);
  }
}

TEST(EffectsCost, FrictionAloneActsAlongTheFibers) {
  // The bundles are straight along x and stay so: normals have no x, penalties no force and no stiffness along it. Feet
  // settle to 1e-10 of an element, by which chords and with them normals may lean.
  constexpr double lean = 1e-10 * 24 / bundle_elements;  // over a distance of about 2
  for (const Combination& c : combinations()) {
    SCOPED_TRACE(text(c));
    if (c.scope == ContactScope::none || c.self_contact) continue;
    const Counted counted(touching_fibers(c));
    const auto assembled = test::assemble(*counted.model.contact, counted.model.layout, counted.state);
    double normal = 0, along = 0, stiffness = 0, stiffness_along = 0;
    for (Index n = 0; n < counted.model.layout.n_nodes(); ++n) {
      const Index dof = counted.model.layout.first_dof(n);
      along = std::max(along, std::abs(assembled.force[dof]));
      normal = std::max(normal, std::abs(assembled.force[dof + 2]));
      stiffness = std::max(stiffness, std::abs(assembled.tangent(dof + 2, dof + 2)));
      stiffness_along = std::max(stiffness_along, std::abs(assembled.tangent(dof, dof)));
    }
    EXPECT_GT(normal, 1e-4);
    EXPECT_EQ(along > lean * normal, c.friction);
    EXPECT_EQ(stiffness_along > lean * stiffness, c.friction);
  }
}

TEST(EffectsCost, TwistStretchHasItsMeasuresAndNoOther) {
  for (const Combination& c : combinations()) {
    SCOPED_TRACE(text(c));
    const Counted counted(touching_fibers(c));
    const auto* beams = counted.find<EnrichedBeams>();
    ASSERT_EQ(beams != nullptr, c.model == FiberModel::enriched);
    if (!beams) continue;
    const std::size_t n_points = 2 * (6 * bundle_elements + hairpin_elements), n_measures = c.twist_stretch ? 15 : 12;
    EXPECT_EQ(static_cast<std::size_t>(beams->n_measures_in_use()), n_measures);
    EXPECT_EQ(beams->n_reference_values(), n_points * n_measures);
  }
}

TEST(EffectsCost, AFrictionCoefficientOfZeroIsNoFriction) {
  Combination c;
  c.friction = true;
  Scene scene = touching_fibers(c);
  scene.contact.friction_coefficient = 0;
  const Counted counted(scene);
  EXPECT_TRUE(counted.model.contact->stick_slip().empty());
  EXPECT_TRUE(counted.model.contact->tractions().empty());
}

TEST(EffectsCost, AStageMayDoWithout) {
  Combination c;
  c.friction = c.body = true;
  const Scene scene = touching_fibers(c);
  Stage stage = quiet_stage();
  stage.friction = false;
  stage.fiber_model = FiberModel::rod;
  const Counted without(scene, stage);
  EXPECT_EQ(without.effects(), (std::vector<std::string>{"rods", "contact", "ties"}));
  EXPECT_TRUE(without.model.contact->stick_slip().empty());
  stage.proximal_start = 1e-3;
  stage.drives = {{"grip", BodyDof::x, DriveMode::force, 1, ""}};
  const Counted with(scene, stage);
  EXPECT_EQ(with.effects(), (std::vector<std::string>{"rods", "contact", "ties", "body loads", "proximal damping"}));
  // A load and the damping of positions act on what is there: no unknown and no coupling of their own.
  EXPECT_EQ(with.model.layout.n_dofs(), without.model.layout.n_dofs());
  EXPECT_EQ(with.pattern.n_values(), without.pattern.n_values());
}

TEST(EffectsCost, MixedModelsPayForWhatEachFiberIs) {
  Combination c;
  Scene scene = touching_fibers(c);
  scene.fiber_types.push_back({"rod", 0, 1.0, FiberModel::rod});
  scene.bundles[1].type = 1;
  const Counted counted(scene);
  EXPECT_EQ(counted.effects(), (std::vector<std::string>{"enriched beams", "rods", "contact"}));
  EXPECT_EQ(counted.model.layout.n_dofs(),
            3 * 9 * (2 * bundle_elements + 1) + 3 * 6 * (bundle_elements + 1) + 9 * (2 * hairpin_elements + 1));
  EXPECT_EQ(counted.find<EnrichedBeams>()->n_reference_values(), 12u * 2 * (3 * bundle_elements + hairpin_elements));
}

/// Two warp over two weft yarns of three fibers.
Scene small_weave() {
  Scene scene;
  scene.materials = {test::isotropic(1, 0.3)};
  scene.fiber_types = {{"f", 0, 1.0, FiberModel::rod}};
  const YarnSystem yarns{{{.type = 0, .n_fibers = 3, .n_layers = 1, .lattice_spacing = 1.05}}, {0}, 2, 6, 14, 10};
  scene.weave = Weave{{{true, false}, {false, true}}, yarns, yarns};
  return scene;
}

TEST(EffectsCost, CrossingOrderActsInTheSeparationOnly) {
  const Scene scene = small_weave();
  Stage separate = quiet_stage();
  separate.separate_yarns = true;
  const Counted separation(scene, separate), relaxation(scene);
  EXPECT_EQ(separation.effects(), (std::vector<std::string>{"rods", "contact", "crossing order", "ties"}));
  EXPECT_EQ(relaxation.effects(), (std::vector<std::string>{"rods", "contact", "ties"}));
  // Meanwhile ordinary contact leaves warp against weft alone.
  const FiberMesh& mesh = separation.assembly.mesh;
  for (const ContactElement& e : separation.model.contact->elements())
    EXPECT_EQ(mesh.yarns[mesh.yarn_of_fiber[e.fiber_a]].family, mesh.yarns[mesh.yarn_of_fiber[e.fiber_b]].family);
}

TEST(EffectsCost, BodiesThatHoldNothingCoupleNothing) {
  // A patch side that no stage drives or follows has its six unknowns, all prescribed, and no coupling.
  const Counted counted(small_weave());
  const std::vector<std::string>& names = counted.assembly.body_names;
  int n_sides = 0;
  for (std::size_t b = 0; b < names.size(); ++b) {
    const auto rows = counted.pattern.rows(static_cast<Index>(b));
    if (names[b].starts_with("side/")) {
      ++n_sides;
      EXPECT_EQ(rows.size(), 1u) << names[b];
    } else {
      EXPECT_EQ(rows.size(), 1u + 3) << names[b];  // itself and an end of each of the yarn's fibers
    }
  }
  EXPECT_EQ(n_sides, 4);
  const PrescribedMotion motion = counted.model.motion(counted.state, 0, 1);
  for (Index d = 0; d < 6 * counted.model.bodies.n_bodies(); ++d) EXPECT_TRUE(motion.fixed[d]);
}

}  // namespace
}  // namespace trame::micro
