#include "micro/cost_estimate.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "micro/model.h"
#include "micro/solve/elimination.h"

namespace trame::micro {

namespace {

/// How often things are done in an increment. Runs of the shipped scenes take 10 iterations (plain_small) to 14
/// (twill_small) an increment.
constexpr double n_iterations = 11, n_detections = 4, assemblies_per_iteration = 3, substitutions_per_iteration = 6;

/// Seconds for one of each: CPU time of one thread on a twisted bundle of 37 fibers with 7,146 contact elements, halved
/// for two cores.
constexpr double beam_element = 3.1e-6, twist_stretch_element = 6.5e-7, rod_element = 1.3e-7;
constexpr double contact_element = 1.8e-7, contact_block = 4.4e-9,
                 friction_block = 3e-9;   // block: 3 × 3, of an element's tangent
constexpr double contact_history = 2e-7;  // element made, matched with its history and committed
constexpr double adapted_element = 1.9e-7, search_sample = 3e-6, self_search_share = 0.045;
/// The same, from the number of operations.
constexpr double tie_term = 2e-7, node_of_vectors = 1e-8;
constexpr double flops_per_second = 7e10, entries_per_second = 1.2e9;  // factorisation, substitution; double precision
constexpr double increment_file = 5e-3, file_node = 4e-6, program_bytes = 4e7;

/// Bytes for each entry of K (values, pattern, elimination), and for each of L (factor and fronts) in double precision.
constexpr double bytes_per_matrix_entry = 16, bytes_per_factor_entry = 15;

/// A matrix and its factor.
struct Fill {
  double entries = 0, factor_entries = 0, flops = 0;
};

Fill analyse(const StageModel& model, bool with_contact) {
  Pattern::Builder builder;
  for (const auto& effect : model.effects)
    if (with_contact || (effect.get() != model.contact && effect.get() != model.crossing_order))
      effect->add_sparsity(builder);
  const Pattern pattern(model.layout, std::move(builder));
  const std::vector<char> all(pattern.coupling_start(pattern.n_nodes()), 1);
  const Elimination elimination(pattern, all);
  return {static_cast<double>(pattern.n_values()), static_cast<double>(elimination.value_start.back()),
          elimination.n_flops};
}

/// The start with the fibers of each yarn shifted along themselves by thirds of an element: as in a woven yarn, and
/// unlike at the start, nodes of neighbours do not face each other. Measured on woven patches and twisted bundles, this
/// takes five to eight times the flops of the aligned start.
State shifted_start(const StageModel& model) {
  State state = model.start;
  const FiberField& field = model.field;
  for (const Yarn& yarn : field.mesh().yarns)
    for (Index i = 0; i < yarn.n_fibers; ++i) {
      const Index f = yarn.first_fiber + i;
      const Vec3 shift = i % 3 / 3.0 * field.element_length(f) * field.curve(model.start, f, 0).tangent;
      for (Index n = field.element_node(f, 0); n <= field.last_node(f); ++n)
        state.q[model.layout.first_vector(n)] += shift;
    }
  return state;
}

/// Costs of one stage, by effect.
class StageCost {
 public:
  StageCost(const Scene& scene, const Assembly& assembly, const Stage& stage, const StageStart& start)
      : scene_(scene), stage_(stage), model_(scene, assembly, stage, start) {
    begin_at(model_.effects, shifted_start(model_), 0.5);
    price_fibers();
    price_bodies();
    price_contact();
    price_matrix();
    if (model_.proximal)
      add(PricedEffect::proximal, iterations() * assemblies_per_iteration * model_.layout.n_nodes() * node_of_vectors,
          state_bytes());
  }

  [[nodiscard]] const EffectCost& operator[](int effect) const { return costs_[effect]; }
  [[nodiscard]] bool has(int effect) const { return present_[effect]; }

 private:
  EffectCost& add(PricedEffect effect, double seconds, double bytes) {
    const auto i = static_cast<std::size_t>(effect);
    present_[i] = true;
    costs_[i].effect = effect;
    costs_[i].seconds += seconds;
    costs_[i].bytes += bytes;
    return costs_[i];
  }
  [[nodiscard]] double increments() const { return stage_.n_increments; }
  [[nodiscard]] double iterations() const { return n_iterations * increments(); }
  [[nodiscard]] double assemblies() const { return assemblies_per_iteration * iterations(); }
  [[nodiscard]] double state_bytes() const { return static_cast<double>(sizeof(Vec3)) * model_.layout.n_vectors(); }

  /// Elements, and the states between which the solver goes to and fro.
  void price_fibers() {
    constexpr int n_states = 6;
    const FiberMesh& mesh = model_.field.mesh();
    for (Index f = 0; f < mesh.n_fibers(); ++f) {
      const bool enriched = model_.field.model(f) == FiberModel::enriched;
      const Layout& layout = model_.layout;
      const Index n_dofs =
          layout.first_dof(model_.field.last_node(f) + 1) - layout.first_dof(model_.field.element_node(f, 0));
      add(enriched ? PricedEffect::enriched_beams : PricedEffect::rods,
          assemblies() * mesh.n_elements(f) * (enriched ? beam_element : rod_element), n_states * 8.0 * n_dofs)
          .n_dofs += n_dofs;
      if (enriched && scene_.twist_stretch)
        add(PricedEffect::twist_stretch, assemblies() * mesh.n_elements(f) * twist_stretch_element,
            3 * 2 * 8.0 * mesh.n_elements(f));
    }
  }

  void price_bodies() {
    if (model_.bodies.n_bodies() == 0) return;
    const double n_ties = model_.ties ? static_cast<double>(model_.ties->n_terms()) : 0;
    add(PricedEffect::bodies, assemblies() * n_ties * tie_term, n_ties * sizeof(TieTerm)).n_dofs =
        model_.layout.first_dof(model_.bodies.n_bodies());  // their nodes come first
    const auto driven = [&](DofDrive::Kind kind) {
      return static_cast<double>(
          std::count_if(model_.drives.begin(), model_.drives.end(), [=](const DofDrive& d) { return d.kind == kind; }));
    };
    if (model_.follow) {
      const double n = driven(DofDrive::Kind::follow);
      add(PricedEffect::follow, assemblies() * n * tie_term, n * sizeof(FollowTerm));
    }
    if (model_.loads) {
      const double n = driven(DofDrive::Kind::force);
      add(PricedEffect::loads, assemblies() * n * node_of_vectors, n * sizeof(LoadTerm));
    }
  }

  /// 3 × 3 blocks of the tangents of contact elements.
  static double blocks_of(const CurveShape& a, const CurveShape& b) {
    const double n = a.n_nodes * a.n_vectors + b.n_nodes * b.n_vectors;
    return 0.5 * n * n;
  }
  [[nodiscard]] double count_blocks(const std::vector<ContactElement>& elements) const {
    double blocks = 0;
    for (const ContactElement& e : elements)
      blocks += blocks_of(model_.field.shape(e.fiber_a, e.s_a), model_.field.shape(e.fiber_b, e.s_b));
    return blocks;
  }
  [[nodiscard]] double count_blocks(const std::vector<CrossingOrder::Element>& elements) const {
    double blocks = 0;
    for (const CrossingOrder::Element& e : elements)
      blocks += blocks_of(model_.field.shape(e.a.fiber, e.a.s), model_.field.shape(e.b.fiber, e.b.s));
    return blocks;
  }
  /// Seconds for contact elements: to make them anew at every detection, and to assemble them.
  template <typename Elements>
  [[nodiscard]] double element_seconds(const Elements& elements) const {
    const auto n = static_cast<double>(elements.size());
    return increments() * n_detections * contact_history * n +
           assemblies() * (contact_element * n + contact_block * count_blocks(elements));
  }

  void price_contact() {
    if (model_.crossing_order) {
      const auto& elements = model_.crossing_order->elements();
      add(PricedEffect::crossing_order, element_seconds(elements),
          static_cast<double>(elements.size() * sizeof(CrossingOrder::Element)));
    }
    if (!model_.contact) return;
    const auto& elements = model_.contact->elements();
    const auto n = static_cast<double>(elements.size());
    double n_samples = 0;
    for (Index f = 0; f < model_.field.mesh().n_fibers(); ++f)
      n_samples += model_.field.mesh().n_elements(f) / scene_.contact.spacing;
    const double search = increments() * n_detections * n_samples * search_sample;
    add(PricedEffect::contact, search + element_seconds(elements),
        n * (sizeof(ContactElement) + sizeof(ContactHistory)));
    if (scene_.contact.self_contact) add(PricedEffect::self_contact, self_search_share * search, 0);
    if (scene_.contact.adapt_penalty)
      add(PricedEffect::adaptation, increments() * n * adapted_element, n * 2 * 3 * sizeof(double));
    if (!model_.contact->stick_slip().empty())
      add(PricedEffect::friction, assemblies() * friction_block * count_blocks(elements),
          n * (sizeof(StickSlip) + sizeof(Vec3)) + state_bytes());
  }

  /// Factorisations and substitutions. What touching fibers cost more than loose ones is shared among contact and
  /// crossing order by their elements.
  void price_matrix() {
    const Fill loose = analyse(model_, false);
    const auto fiber_share = [&](PricedEffect effect) {
      return static_cast<double>(costs_[static_cast<std::size_t>(effect)].n_dofs) / model_.layout.n_dofs();
    };
    for (const auto effect : {PricedEffect::enriched_beams, PricedEffect::rods, PricedEffect::bodies})
      if (fiber_share(effect) > 0) add_matrix(effect, loose, fiber_share(effect));
    if (!model_.contact && !model_.crossing_order) return;
    const Fill touching = analyse(model_, true);
    const Fill more = {touching.entries - loose.entries, std::max(0.0, touching.factor_entries - loose.factor_entries),
                       std::max(0.0, touching.flops - loose.flops)};
    const auto count = [](const auto* effect) { return effect ? static_cast<double>(effect->elements().size()) : 0.0; };
    const double n_contacts = count(model_.contact), n_ordered = count(model_.crossing_order);
    if (n_contacts > 0) add_matrix(PricedEffect::contact, more, n_contacts / (n_contacts + n_ordered));
    if (n_ordered > 0) add_matrix(PricedEffect::crossing_order, more, n_ordered / (n_contacts + n_ordered));
  }
  void add_matrix(PricedEffect effect, const Fill& fill, double share) {
    const double gain = scene_.solver.factor_precision == FactorPrecision::single_precision ? 2 : 1;
    add(effect,
        share * iterations() / gain *
            (fill.flops / flops_per_second + substitutions_per_iteration * fill.factor_entries / entries_per_second),
        share * (fill.entries * bytes_per_matrix_entry + fill.factor_entries * bytes_per_factor_entry / gain));
  }

  const Scene& scene_;
  const Stage& stage_;
  StageModel model_;
  std::array<EffectCost, n_priced_effects> costs_;
  std::array<bool, n_priced_effects> present_{};
};

}  // namespace

namespace {

/// The estimate of a scene as it is.
CostEstimate cost_of(const Scene& scene) {
  const Scene natural = nondimensional(scene, natural_scales(scene));
  const Assembly assembly = assemble_scene(natural);
  const StageStart start = start_of(assembly);
  std::array<EffectCost, n_priced_effects> costs;
  std::array<bool, n_priced_effects> present{};
  CostEstimate total;
  double most_bytes = 0;
  for (const Stage& stage : natural.stages) {
    const StageCost cost(natural, assembly, stage, start);
    double bytes = 0;
    for (int i = 0; i < n_priced_effects; ++i) {
      if (!cost.has(i)) continue;
      present[i] = true;
      costs[i].effect = cost[i].effect;
      costs[i].n_dofs = std::max(costs[i].n_dofs, cost[i].n_dofs);
      costs[i].bytes = std::max(costs[i].bytes, cost[i].bytes);
      costs[i].seconds += cost[i].seconds;
      total.seconds += cost[i].seconds;
      bytes += cost[i].bytes;
    }
    most_bytes = std::max(most_bytes, bytes);
    total.seconds += stage.n_increments / static_cast<double>(stage.save_every) *
                     (increment_file + file_node * assembly.mesh.n_nodes());
  }
  total.bytes = program_bytes + most_bytes;
  for (int i = 0; i < n_priced_effects; ++i)
    if (present[i]) total.effects.push_back(costs[i]);
  return total;
}

double n_fibers(const Scene& scene) {
  double n = static_cast<double>(scene.fibers.size());
  for (const BundleSpec& bundle : scene.bundles) n += bundle.n_fibers;
  if (scene.weave) n += static_cast<double>(scene.weave->warp.n_fibers() + scene.weave->weft.n_fibers());
  return n;
}

/// Pairs of fibers that cross in a weave: each is an element of the crossing order, and in the end many are contacts.
double n_crossing_pairs(const Scene& scene) {
  return scene.weave
             ? static_cast<double>(scene.weave->warp.n_fibers()) * static_cast<double>(scene.weave->weft.n_fibers())
             : 0;
}

/// The scene with a share of the fibers of each yarn and bundle, in as many layers as keep the section's shape.
Scene thinned(Scene scene, double share) {
  const auto thin = [&](Index& n, Index& n_layers) {
    n = std::max<Index>(1, static_cast<Index>(std::lround(share * n)));
    if (n_layers > 0) n_layers = std::clamp<Index>(static_cast<Index>(std::lround(std::sqrt(share) * n_layers)), 1, n);
  };
  for (BundleSpec& bundle : scene.bundles) thin(bundle.n_fibers, bundle.n_layers);
  if (scene.weave)
    for (YarnSystem* yarns : {&scene.weave->warp, &scene.weave->weft})
      for (YarnKind& kind : yarns->kinds) {
        thin(kind.n_fibers, kind.n_layers);
        kind.volume_fraction = 0;  // a random lay of few fibers may not be
      }
  return scene;
}

/// What costs `small` for n_small fibers and `large` for n_large, for n by a power law.
double extrapolated(double small, double n_small, double large, double n_large, double n) {
  if (!(small > 0) || !(large > 0)) return large;
  return large * std::pow(n / n_large, std::clamp(std::log(large / small) / std::log(n_large / n_small), 0.0, 3.0));
}

}  // namespace

CostEstimate estimate_cost(const Scene& scene) {
  constexpr double most_pairs = 2e5, most_fibers = 3000;  // what is looked at within seconds
  const double n = n_fibers(scene), excess = std::max(std::sqrt(n_crossing_pairs(scene) / most_pairs), n / most_fibers);
  if (excess <= 1) return cost_of(scene);
  const Scene large_scene = thinned(scene, 0.5 / excess), small_scene = thinned(scene, 0.25 / excess);
  const double n_large = n_fibers(large_scene), n_small = n_fibers(small_scene);
  if (n_small >= n_large) return cost_of(scene);  // single fibers, which cannot be thinned
  CostEstimate cost = cost_of(large_scene);
  const CostEstimate small = cost_of(small_scene);
  const auto of_effects = [](const CostEstimate& c) {
    double seconds = 0;
    for (const EffectCost& effect : c.effects) seconds += effect.seconds;
    return seconds;
  };
  const double files =
      extrapolated(small.seconds - of_effects(small), n_small, cost.seconds - of_effects(cost), n_large, n);
  cost.extrapolated = true;
  cost.bytes = extrapolated(small.bytes, n_small, cost.bytes, n_large, n);
  for (EffectCost& effect : cost.effects) {
    const auto same = std::find_if(small.effects.begin(), small.effects.end(),
                                   [&](const EffectCost& e) { return e.effect == effect.effect; });
    if (same == small.effects.end()) continue;
    effect.seconds = extrapolated(same->seconds, n_small, effect.seconds, n_large, n);
    effect.bytes = extrapolated(same->bytes, n_small, effect.bytes, n_large, n);
    effect.n_dofs = std::llround(
        extrapolated(static_cast<double>(same->n_dofs), n_small, static_cast<double>(effect.n_dofs), n_large, n));
    cost.bytes = std::max(cost.bytes, effect.bytes);
  }
  cost.seconds = of_effects(cost) + files;
  return cost;
}

}  // namespace trame::micro
