#include "micro/cost_estimate.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "micro/model/model.h"
#include "micro/run/stage_settings.h"
#include "micro/solve/linear_solver.h"

namespace trame::micro {

namespace {

/// How often things are done in an increment. Runs of the shipped scenes take 5 (plain_small) to 20 iterations (plain)
/// an increment.
constexpr double n_iterations = 11, n_detections = 4, n_assemblies = 3 * n_iterations,
                 n_substitutions = 6 * n_iterations;
/// Two levels take more iterations, each of which reads their entries more often than those of a factor.
constexpr double with_two_levels = 13.0 / 6 * 7 / 3;

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

/// A matrix and what takes its place in conjugate gradients: a factor, or two levels.
struct Fill {
  double entries = 0, factor_entries = 0, flops = 0;
  double entries_read = 0;  ///< by a substitution, as if by a factor's
};

/// Of the tangent at `state`, as the solver itself would have it.
Fill analyse(const Scene& scene, const StageModel& model, const State& state, bool with_contact) {
  const auto counts = [&](const auto& effect) {
    return with_contact || (effect.get() != model.contact && effect.get() != model.crossing_order);
  };
  Pattern::Builder builder;
  for (const auto& effect : model.effects)
    if (counts(effect)) effect->add_sparsity(builder);
  const Pattern pattern(model.layout, std::move(builder));
  std::vector<double> values(pattern.n_values()), force(model.layout.n_dofs()), magnitude(model.layout.n_vectors());
  Assembler assembler(model.layout, &pattern, 0, model.layout.n_nodes(), force.data(), magnitude.data(), values.data(),
                      Assembler::Tangent::projected);
  for (const auto& effect : model.effects)
    if (counts(effect)) effect->add(state, assembler);
  const NewtonSettings settings = newton_settings(scene, model, {});
  LinearSolver solver(model.layout, settings.linear.precision, 1, settings.linear.preconditioner);
  solver.set_pattern(pattern);
  solver.analyze(values, [&] { return settings.linear.coarse_space(state); });
  return {static_cast<double>(pattern.n_values()), solver.n_factor_entries(), solver.n_factor_flops(),
          solver.n_factor_entries() * (solver.has_two_levels() ? with_two_levels : 1)};
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

/// Costs by effect: seconds of one increment, or of many.
struct EffectCosts {
  std::array<EffectCost, n_priced_effects> costs;
  std::array<bool, n_priced_effects> present{};
};

/// Costs of a stage's increment.
class StageCost {
 public:
  StageCost(const Scene& scene, const Assembly& assembly, const Stage& stage, const StageStart& start)
      : scene_(scene), model_(scene, assembly, stage, start), at_(shifted_start(model_)) {
    begin_at(model_.effects, at_, 0.5);
    price_fibers();
    price_bodies();
    price_fiber_loads();
    price_contact();
    price_surfaces();
    price_matrix();
    if (model_.proximal)
      add(PricedEffect::proximal, n_assemblies * model_.layout.n_nodes() * node_of_vectors, state_bytes());
  }

  [[nodiscard]] const EffectCosts& of_effects() const { return of_effects_; }

 private:
  EffectCost& add(PricedEffect effect, double seconds, double bytes) {
    const auto i = static_cast<std::size_t>(effect);
    of_effects_.present[i] = true;
    EffectCost& cost = of_effects_.costs[i];
    cost.effect = effect;
    cost.seconds += seconds;
    cost.bytes += bytes;
    return cost;
  }
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
          n_assemblies * mesh.n_elements(f) * (enriched ? beam_element : rod_element), n_states * 8.0 * n_dofs)
          .n_dofs += n_dofs;
      if (enriched && scene_.twist_stretch)
        add(PricedEffect::twist_stretch, n_assemblies * mesh.n_elements(f) * twist_stretch_element,
            3 * 2 * 8.0 * mesh.n_elements(f));
    }
  }

  void price_bodies() {
    if (model_.bodies.n_bodies() == 0) return;
    const double n_ties = model_.ties ? static_cast<double>(model_.ties->n_terms()) : 0;
    add(PricedEffect::bodies, n_assemblies * n_ties * tie_term, n_ties * sizeof(TieTerm)).n_dofs =
        model_.layout.first_dof(model_.bodies.n_bodies());  // their nodes come first
    const auto driven = [&](DofDrive::Kind kind) {
      return static_cast<double>(
          std::count_if(model_.drives.begin(), model_.drives.end(), [=](const DofDrive& d) { return d.kind == kind; }));
    };
    if (model_.follow) {
      const double n = driven(DofDrive::Kind::follow);
      add(PricedEffect::follow, n_assemblies * n * tie_term, n * sizeof(FollowTerm));
    }
    if (model_.loads) {
      const double n = driven(DofDrive::Kind::force);
      add(PricedEffect::loads, n_assemblies * n * node_of_vectors, n * sizeof(LoadTerm));
    }
  }

  void price_fiber_loads() {
    if (!model_.fiber_loads) return;
    const auto n = static_cast<double>(model_.fiber_loads->terms().size());
    add(PricedEffect::fiber_loads, n_assemblies * model_.layout.n_nodes() * node_of_vectors,
        n * sizeof(FiberLoadTerm) + state_bytes());
  }

  /// 3 × 3 blocks of the tangents of contact elements.
  static double blocks_of(const CurveShape& a, const CurveShape& b) {
    const double n = a.slots.n_nodes * a.slots.n_vectors + b.slots.n_nodes * b.slots.n_vectors;
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
    return n_detections * contact_history * n +
           n_assemblies * (contact_element * n + contact_block * count_blocks(elements));
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
    const double search = n_detections * n_samples * search_sample;
    add(PricedEffect::contact, search + element_seconds(elements),
        n * (sizeof(ContactElement) + sizeof(ContactHistory)));
    if (scene_.contact.self_contact) add(PricedEffect::self_contact, self_search_share * search, 0);
    if (scene_.contact.adapt_penalty) add(PricedEffect::adaptation, n * adapted_element, n * 2 * 3 * sizeof(double));
    if (!model_.contact->stick_slip().empty())
      add(PricedEffect::friction, n_assemblies * friction_block * count_blocks(elements),
          n * (sizeof(StickSlip) + sizeof(Vec3)) + state_bytes());
  }

  /// As if what touches them at the start went on doing so.
  void price_surfaces() {
    if (!model_.surface_contact) return;
    constexpr double vectors_of_body = 2;
    const auto& elements = model_.surface_contact->elements();
    const auto n = static_cast<double>(elements.size());
    const double places =
        static_cast<double>(model_.surface_contact->surfaces().size()) * model_.field.mesh().n_fibers();
    double blocks = 0;
    for (const SurfaceContactElement& e : elements) {
      const double vectors = e.shape.slots.n_nodes * e.shape.slots.n_vectors + vectors_of_body;
      blocks += 0.5 * vectors * vectors;
    }
    add(PricedEffect::surfaces,
        n_detections * (places * search_sample + n * contact_history) +
            n_assemblies * (n * contact_element + blocks * contact_block),
        n * (sizeof(SurfaceContactElement) + sizeof(SurfaceContactHistory)));
  }

  /// Factorisations and substitutions. What touching fibers cost more than loose ones is shared among contact and
  /// crossing order by their elements.
  void price_matrix() {
    const Fill loose = analyse(scene_, model_, at_, false);
    const auto fiber_share = [&](PricedEffect effect) {
      return static_cast<double>(of_effects_.costs[static_cast<std::size_t>(effect)].n_dofs) / model_.layout.n_dofs();
    };
    for (const auto effect : {PricedEffect::enriched_beams, PricedEffect::rods, PricedEffect::bodies})
      if (fiber_share(effect) > 0) add_matrix(effect, loose, fiber_share(effect));
    if (!model_.contact && !model_.crossing_order) return;
    const Fill touching = analyse(scene_, model_, at_, true);
    const Fill more = {touching.entries - loose.entries, std::max(0.0, touching.factor_entries - loose.factor_entries),
                       std::max(0.0, touching.flops - loose.flops),
                       std::max(0.0, touching.entries_read - loose.entries_read)};
    const auto count = [](const auto* effect) { return effect ? static_cast<double>(effect->elements().size()) : 0.0; };
    const double n_contacts = count(model_.contact), n_ordered = count(model_.crossing_order);
    if (n_contacts > 0) add_matrix(PricedEffect::contact, more, n_contacts / (n_contacts + n_ordered));
    if (n_ordered > 0) add_matrix(PricedEffect::crossing_order, more, n_ordered / (n_contacts + n_ordered));
  }
  void add_matrix(PricedEffect effect, const Fill& fill, double share) {
    const double gain = is_in_single_precision(scene_.solver.factor_precision, fill.factor_entries) ? 2 : 1;
    add(effect,
        share / gain *
            (n_iterations * fill.flops / flops_per_second + n_substitutions * fill.entries_read / entries_per_second),
        share * (fill.entries * bytes_per_matrix_entry + fill.factor_entries * bytes_per_factor_entry / gain));
  }

  const Scene& scene_;
  StageModel model_;
  State at_;  // where contacts and the matrix are looked at
  EffectCosts of_effects_;
};

}  // namespace

namespace {

/// A stage without name, numbers of increments and values.
Stage without_values(Stage stage) {
  stage.name.clear();
  stage.n_increments = stage.save_every = 1;
  for (Drive& drive : stage.drives) {
    drive.value = 0;
    drive.amplitude = {};
  }
  for (FiberLoad& load : stage.loads) {
    load.value = Vec3::Ones();  // one of zero would not be there
    load.amplitude = {};
  }
  return stage;
}

/// The estimate of a scene as it is.
CostEstimate cost_of(const Scene& scene) {
  const Scene natural = nondimensional(scene, natural_scales(scene));
  const Assembly assembly = assemble_scene(natural);
  const StageStart start = start_of(assembly);
  // Stages that differ in values alone cost the same; their models are built once.
  std::vector<std::pair<Stage, EffectCosts>> known;
  EffectCosts all;
  CostEstimate total;
  double most_bytes = 0;
  for (const Stage& stage : natural.stages) {
    const Stage alike = without_values(stage);
    auto found = std::find_if(known.begin(), known.end(), [&](const auto& k) { return k.first == alike; });
    if (found == known.end())
      found = known.emplace(known.end(), alike, StageCost(natural, assembly, alike, start).of_effects());
    double bytes = 0;
    for (std::size_t i = 0; i < n_priced_effects; ++i) {
      if (!found->second.present[i]) continue;
      const EffectCost& cost = found->second.costs[i];
      all.present[i] = true;
      all.costs[i].effect = cost.effect;
      all.costs[i].n_dofs = std::max(all.costs[i].n_dofs, cost.n_dofs);
      all.costs[i].bytes = std::max(all.costs[i].bytes, cost.bytes);
      all.costs[i].seconds += stage.n_increments * cost.seconds;
      total.seconds += stage.n_increments * cost.seconds;
      bytes += cost.bytes;
    }
    most_bytes = std::max(most_bytes, bytes);
    total.seconds += stage.n_increments / static_cast<double>(stage.save_every) *
                     (increment_file + file_node * assembly.mesh.n_nodes());
  }
  total.bytes = program_bytes + most_bytes;
  for (std::size_t i = 0; i < n_priced_effects; ++i)
    if (all.present[i]) total.effects.push_back(all.costs[i]);
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

/// The scene with a share of its fibers: of those of each yarn and bundle, in as many layers, and where bundles are of
/// too few fibers for that, of the bundles.
Scene thinned(Scene scene, double share) {
  const double wanted = share * n_fibers(scene);
  const auto thin = [&](Index& n, Index& n_layers) {
    n = std::max<Index>(1, static_cast<Index>(std::lround(share * n)));
    n_layers = std::min(n_layers, n);
  };
  for (BundleSpec& bundle : scene.bundles) thin(bundle.n_fibers, bundle.n_layers);
  if (scene.weave)
    for (YarnSystem* yarns : {&scene.weave->warp, &scene.weave->weft})
      for (YarnKind& kind : yarns->kinds) {
        thin(kind.n_fibers, kind.n_layers);
        kind.volume_fraction = 0;  // a random lay of few fibers may not be
      }
  const double still = wanted / n_fibers(scene);
  const auto keep_first = [&](auto& specs) {
    if (!specs.empty()) specs.resize(std::max<std::size_t>(1, static_cast<std::size_t>(still * specs.size())));
  };
  if (still < 0.7) {
    keep_first(scene.fibers);
    keep_first(scene.bundles);
  }
  return scene;
}

/// The scene with a share of the elements along each fiber.
Scene coarsened(Scene scene, double share) {
  const auto coarsen = [&](Index& n) { n = std::max<Index>(1, static_cast<Index>(std::lround(share * n))); };
  for (FiberSpec& fiber : scene.fibers) coarsen(fiber.n_elements);
  for (BundleSpec& bundle : scene.bundles) coarsen(bundle.n_elements);
  if (scene.weave)
    for (YarnSystem* yarns : {&scene.weave->warp, &scene.weave->weft}) coarsen(yarns->n_elements);
  return scene;
}

/// What costs `small` for n_small fibers or elements and `large` for n_large, for n by a power law.
double extrapolated(double small, double n_small, double large, double n_large, double n) {
  if (!(small > 0) || !(large > 0)) return large;
  return large * std::pow(n / n_large, std::clamp(std::log(large / small) / std::log(n_large / n_small), 0.0, 3.0));
}

CostEstimate extrapolated(const CostEstimate& small, double n_small, CostEstimate cost, double n_large, double n) {
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
    // Nodes are one more than what is between them: a line, not a power.
    effect.n_dofs +=
        std::llround(static_cast<double>(effect.n_dofs - same->n_dofs) / (n_large - n_small) * (n - n_large));
    cost.bytes = std::max(cost.bytes, effect.bytes);
  }
  cost.seconds = of_effects(cost) + files;
  return cost;
}

Index most_elements_of_a_fiber(const Scene& scene) {
  Index most = 0;
  for (const FiberSpec& fiber : scene.fibers) most = std::max(most, fiber.n_elements);
  for (const BundleSpec& bundle : scene.bundles) most = std::max(most, bundle.n_elements);
  if (scene.weave) most = std::max({most, scene.weave->warp.n_elements, scene.weave->weft.n_elements});
  return most;
}

/// From two scenes that are `excess` times smaller than what is looked at within seconds, and more; by `estimate` where
/// there is no need, or they cannot be made smaller.
template <typename Smaller, typename Size, typename Estimate>
CostEstimate from_smaller(const Scene& scene, double excess, const Smaller& smaller, const Size& size,
                          const Estimate& estimate) {
  if (excess <= 1) return estimate(scene);
  const Scene large = smaller(scene, 0.5 / excess), small = smaller(scene, 0.25 / excess);
  const double n_large = size(large), n_small = size(small);
  if (n_small >= n_large) return estimate(scene);
  return extrapolated(estimate(small), n_small, estimate(large), n_large, size(scene));
}

/// From scenes with fewer fibers where there are many, with the same elements.
CostEstimate estimate_by_fibers(const Scene& scene) {
  constexpr double most_pairs = 2e5, most_fibers = 3000;  // what is looked at within seconds
  const double excess = std::max(std::sqrt(n_crossing_pairs(scene) / most_pairs), n_fibers(scene) / most_fibers);
  return from_smaller(scene, excess, thinned, n_fibers, cost_of);
}

}  // namespace

CostEstimate estimate_cost(const Scene& scene) {
  constexpr double most_elements = 60'000, most_of_a_fiber = 400;  // what is looked at within seconds
  const double most = most_elements_of_a_fiber(scene),
               excess = std::max(most / most_of_a_fiber, std::min(n_fibers(scene), 1500.0) * most / most_elements);
  return from_smaller(scene, excess, coarsened, most_elements_of_a_fiber, estimate_by_fibers);
}

}  // namespace trame::micro
