#include "micro/fiber/enriched_beam.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <numbers>

#include "micro/fiber/axial_law.h"

namespace trame::micro {

namespace {

constexpr double gauss = 0.57735026918962576451;  // 1/√3
constexpr std::array<double, 2> gauss_points = {-gauss, gauss};

/// ½(zᵢ·zⱼ) for i = j and zᵢ·zⱼ otherwise, times `factor`, as the matrix A of e = ½ zᵀ A z.
void add_product(Eigen::Matrix<double, 5, 5>& a, int i, int j, double factor = 1) {
  a(i, j) += factor;
  if (i != j) a(j, i) += factor;
}

bool same(const Material& a, const Material& b) {
  return a.young_modulus_axial == b.young_modulus_axial && a.young_modulus_transverse == b.young_modulus_transverse &&
         a.shear_modulus_axial == b.shear_modulus_axial && a.poisson_ratio_axial == b.poisson_ratio_axial &&
         a.poisson_ratio_transverse == b.poisson_ratio_transverse;
}

/// Nodal unknowns of an element to z at a Gauss point.
template <typename Z>
Z interpolate(const Vec3* q, const std::array<double, 3>& n, const std::array<double, 3>& dn) {
  Z z = Z::Zero();
  for (int a = 0; a < 3; ++a) {
    z.col(0) += dn[a] * q[3 * a];
    z.col(1) += n[a] * q[3 * a + 1];
    z.col(2) += n[a] * q[3 * a + 2];
    z.col(3) += dn[a] * q[3 * a + 1];
    z.col(4) += dn[a] * q[3 * a + 2];
  }
  return z;
}

// Second difference over the nodes of an element, and what the square of a quadratic's highest term integrates to over
// it, in half lengths, more than two Gauss points see: 2/5 − 2/9.
constexpr std::array<double, 3> second_difference = {0.5, -1, 0.5};
constexpr double unseen = 8.0 / 45;

std::array<double, 3> shape_derivative_by_arc(double t, double h) {
  auto d = quadratic_shape_derivative(t);
  for (double& x : d) x *= 2 / h;
  return d;
}

}  // namespace

Eigen::Matrix<double, 6, 6> material_stiffness(const Material& m) {
  const double el = m.young_modulus_axial, et = m.young_modulus_transverse, nu = m.poisson_ratio_axial;
  Mat3 compliance;
  compliance << 1 / el, -nu / el, -nu / el,                //
      -nu / el, 1 / et, -m.poisson_ratio_transverse / et,  //
      -nu / el, -m.poisson_ratio_transverse / et, 1 / et;
  Eigen::Matrix<double, 6, 6> c = Eigen::Matrix<double, 6, 6>::Zero();
  c.topLeftCorner<3, 3>() = compliance.inverse();
  c(3, 3) = et / (2 * (1 + m.poisson_ratio_transverse));
  c(4, 4) = c(5, 5) = m.shear_modulus_axial;
  return c;
}

EnrichedBeams::EnrichedBeams(const FiberField& field, std::vector<Material> materials,
                             const FiberConfiguration& reference, bool twist_stretch)
    : field_(field), n_measures_(twist_stretch ? n_measures_twist_stretch : n_measures) {
  const FiberMesh& mesh = field.mesh();
  std::vector<std::pair<Material, double>> kinds;
  for (Index f = 0; f < mesh.n_fibers(); ++f) {
    const double radius = mesh.radius[f];
    std::size_t k = 0;
    while (k < kinds.size() && !(same(kinds[k].first, materials[f]) && kinds[k].second == radius)) ++k;
    section_of_fiber_.push_back(static_cast<Index>(k));
    if (k < kinds.size()) continue;
    kinds.emplace_back(materials[f], radius);

    const double area = std::numbers::pi * radius * radius, inertia = area * radius * radius / 4;
    Section s;
    s.axial_stiffness = materials[f].young_modulus_axial * area;
    s.stiffness.setZero();
    for (auto& a : s.measure) a.setZero();
    s.stiffness.topLeftCorner<6, 6>() = area * material_stiffness(materials[f]);
    // Zero transverse stress for what is linear in ξ: the constant section strain could not follow it (Poisson
    // locking).
    for (const int k_bending : {6, 7}) s.stiffness(k_bending, k_bending) = materials[f].young_modulus_axial * inertia;
    for (int k_shear = 8; k_shear < 12; ++k_shear)
      s.stiffness(k_shear, k_shear) = materials[f].shear_modulus_axial * inertia;
    for (int i = 0; i < 3; ++i) add_product(s.measure[i], i, i);  // E_ss, E_11, E_22
    add_product(s.measure[3], 1, 2);                              // 2E_12
    add_product(s.measure[4], 0, 1);                              // 2E_s1
    add_product(s.measure[5], 0, 2);                              // 2E_s2
    add_product(s.measure[6], 0, 3);                              // κ_1
    add_product(s.measure[7], 0, 4);                              // κ_2
    add_product(s.measure[8], 3, 2);                              // g₁'·g₂
    add_product(s.measure[9], 4, 1);                              // g₂'·g₁
    add_product(s.measure[10], 3, 1);                             // g₁'·g₁
    add_product(s.measure[11], 4, 2);                             // g₂'·g₂
    // ½ ξα ξβ gα'·gβ' of E_ss: its mean over the section, (R²/8) m₁, joins E_ss. Without the coupling it joins by as
    // much as balances the axial pull of torsion that narrows the section: 4 ν G/E of it.
    const Material& m = materials[f];
    const double share = twist_stretch ? 1 : 4 * m.poisson_ratio_axial * m.shear_modulus_axial / m.young_modulus_axial;
    add_product(s.measure[0], 3, 3, share * radius * radius / 4);
    add_product(s.measure[0], 4, 4, share * radius * radius / 4);
    if (twist_stretch) {
      // With ρ the distance from the centre, its deviation from the mean is (ρ² − R²/2)/4 m₁ + ρ²/4 (m₂ cos 2φ + m₃ sin
      // 2φ), m₁ = |g₁'|² + |g₂'|², m₂ = |g₁'|² − |g₂'|², m₃ = 2 g₁'·g₂'.
      add_product(s.measure[12], 3, 3, 2);
      add_product(s.measure[12], 4, 4, 2);
      add_product(s.measure[13], 3, 3, 2);
      add_product(s.measure[13], 4, 4, -2);
      add_product(s.measure[14], 3, 4, 2);
      const double fourth_moment = materials[f].young_modulus_axial * area * std::pow(radius, 4) / 16;
      s.stiffness(12, 12) = fourth_moment / 12;
      s.stiffness(13, 13) = s.stiffness(14, 14) = fourth_moment / 6;
    }
    sections_.push_back(s);
  }
  State state;
  state.q.resize(field.layout().n_vectors());
  field.read_configuration(reference, state);
  for (Index f = 0; f < mesh.n_fibers(); ++f) {
    first_element_.push_back(static_cast<Index>(reference_.size() / (2 * n_measures_)));
    if (field.model(f) != FiberModel::enriched) continue;
    ElementNodes::Buffer buffer;
    for (Index e = 0; e < mesh.n_elements(f); ++e)
      reference_swelling_.push_back(swelling(field.element(f, e).gather(field.layout(), state.q.data(), buffer)));
    for (Index e = 0; e < mesh.n_elements(f); ++e)
      for (const double t : gauss_points) {
        const Vec3* q = field.element(f, e).gather(field.layout(), state.q.data(), buffer);
        const Measures e =
            measures(interpolate<Z>(q, quadratic_shape(t), shape_derivative_by_arc(t, field.element_length(f))),
                     sections_[section_of_fiber_[f]]);
        reference_.insert(reference_.end(), e.data(), e.data() + n_measures_);
      }
  }
}

EnrichedBeams::Measures EnrichedBeams::reference(Index fiber, Index element, int gauss_point) const {
  const std::size_t point = 2 * static_cast<std::size_t>(first_element_[fiber] + element) + gauss_point;
  Measures e = Measures::Zero();
  e.head(n_measures_) = Eigen::Map<const Eigen::VectorXd>(reference_.data() + point * n_measures_, n_measures_);
  return e;
}

Vec3 EnrichedBeams::swelling(const Vec3* q) {
  Vec3 e = Vec3::Zero();
  for (int a = 0; a < 3; ++a) {
    const Vec3 &g1 = q[3 * a + 1], &g2 = q[3 * a + 2];
    e += second_difference[a] * Vec3(0.5 * g1.squaredNorm(), 0.5 * g2.squaredNorm(), g1.dot(g2));
  }
  return e;
}

EnrichedBeams::Measures EnrichedBeams::measures(const Z& z, const Section& section) const {
  const Eigen::Matrix<double, 5, 5> gram = z.transpose() * z;
  Measures e = Measures::Zero();
  for (int k = 0; k < n_measures_; ++k) e[k] = 0.5 * section.measure[k].cwiseProduct(gram).sum();
  return e;
}

void EnrichedBeams::add_sparsity(Pattern::Builder& builder) const {
  for (Index f = 0; f < field_.mesh().n_fibers(); ++f) {
    if (field_.model(f) != FiberModel::enriched) continue;
    for (Index e = 0; e < field_.mesh().n_elements(f); ++e) field_.element(f, e).add_clique(builder);
  }
}

double EnrichedBeams::energy(const State& state) const {
  double sum = 0;
  for (Index f = 0; f < field_.mesh().n_fibers(); ++f) {
    if (field_.model(f) != FiberModel::enriched) continue;
    const double h = field_.element_length(f);
    const Section& section = sections_[section_of_fiber_[f]];
    ElementNodes::Buffer buffer;
    for (Index e = 0; e < field_.mesh().n_elements(f); ++e) {
      const Vec3* q = field_.element(f, e).gather(field_.layout(), state.q.data(), buffer);
      const Vec3 swollen = swelling(q) - reference_swelling_[first_element_[f] + e];
      sum += 0.5 * (h / 2) * unseen * swollen.dot(section.stiffness.block<3, 3>(1, 1) * swollen);
      for (int g = 0; g < 2; ++g) {
        const double t = gauss_points[g];
        const Measures strain =
            measures(interpolate<Z>(q, quadratic_shape(t), shape_derivative_by_arc(t, h)), section) -
            reference(f, e, g);
        sum += 0.5 * (h / 2) * strain.dot(section.stiffness * strain);
        sum += h / 2 * section.axial_stiffness * (axial_law(strain[0]).energy - 0.5 * strain[0] * strain[0]);
      }
    }
  }
  return sum;
}

template <typename Visit>
void EnrichedBeams::for_each_gauss_point(const State& state, Visit&& visit) const {
  for (Index f = 0; f < field_.mesh().n_fibers(); ++f) {
    if (field_.model(f) != FiberModel::enriched) continue;
    const double h = field_.element_length(f);
    ElementNodes::Buffer buffer;
    for (Index e = 0; e < field_.mesh().n_elements(f); ++e) {
      const Vec3* q = field_.element(f, e).gather(field_.layout(), state.q.data(), buffer);
      for (int g = 0; g < 2; ++g) {
        const double t = gauss_points[g];
        const Z z = interpolate<Z>(q, quadratic_shape(t), shape_derivative_by_arc(t, h));
        const double strain = 0.5 * sections_[section_of_fiber_[f]].measure[0].cwiseProduct(z.transpose() * z).sum() -
                              reference(f, e, g)[0];
        visit(f, h * (e + 0.5 * (1 + t)), strain, z);
      }
    }
  }
}

std::string EnrichedBeams::inadmissibility(const State& /*start*/, const State& state) const {
  std::string text;
  for_each_gauss_point(state, [&](Index fiber, double s, double strain, const Z& z) {
    const bool inside_out = z.col(0).dot(z.col(1).cross(z.col(2))) <= 0;
    if (text.empty() && (inside_out || stretch_of(strain) <= least_stretch))
      text = collapse_text(field_, fiber, s, strain, inside_out);
  });
  return text;
}

std::string EnrichedBeams::doubt(const State& state) const {
  MostPressed most;
  for_each_gauss_point(state, [&](Index fiber, double s, double strain, const Z&) { most.see(fiber, s, strain); });
  return most.text(field_);
}

void EnrichedBeams::add(const State& state, Assembler& assembler) const {
  for (Index f = 0; f < field_.mesh().n_fibers(); ++f) {
    if (field_.model(f) != FiberModel::enriched) continue;
    if (!field_.touches(f, assembler)) continue;
    const double h = field_.element_length(f);
    ElementNodes::Buffer buffer, step_buffer;
    for (Index e = 0; e < field_.mesh().n_elements(f); ++e) {
      const ElementNodes nodes = field_.element(f, e);
      if (!nodes.touches(assembler)) continue;
      const Section& section = sections_[section_of_fiber_[f]];
      const Vec3* q = nodes.gather(field_.layout(), state.q.data(), buffer);
      const Vec3* last_step =
          assembler.last_step() ? nodes.gather(field_.layout(), assembler.last_step(), step_buffer) : nullptr;
      for (int g = 0; g < 2; ++g) {
        const auto n = quadratic_shape(gauss_points[g]);
        const auto dn = shape_derivative_by_arc(gauss_points[g], h);
        const Z step = last_step ? interpolate<Z>(last_step, n, dn) : Z(Z::Zero());
        add_gauss_point(interpolate<Z>(q, n, dn), step, section, reference(f, e, g), nodes, n, dn, h / 2, assembler);
      }
      add_swelling(q, last_step, section, reference_swelling_[first_element_[f] + e], nodes, h / 2 * unseen, assembler);
    }
  }
}

void EnrichedBeams::add_swelling(const Vec3* q, const Vec3* last_step, const Section& section, const Vec3& reference,
                                 const ElementNodes& nodes, double weight, Assembler& assembler) const {
  const Mat3 d = weight * section.stiffness.block<3, 3>(1, 1);
  const Vec3 actual = d * (swelling(q) - reference);
  const Vec3 expected = last_step ? Vec3(actual - d * swelling(last_step)) : actual;
  const Vec3& stress = assembler.expects_forces() ? expected : actual;
  Eigen::Matrix2d s;
  s << expected[0], expected[2], expected[2], expected[1];
  Eigen::Matrix<double, 3, 18> b;  // derivative by g₁, g₂ of the nodes
  for (int a = 0; a < 3; ++a) {
    const Vec3 g1 = second_difference[a] * q[3 * a + 1], g2 = second_difference[a] * q[3 * a + 2];
    b.middleCols<3>(6 * a) << g1.transpose(), Eigen::RowVector3d::Zero(), g2.transpose();
    b.middleCols<3>(6 * a + 3) << Eigen::RowVector3d::Zero(), g2.transpose(), g1.transpose();
    nodes.add_force(a, 1, b.middleCols<3>(6 * a).transpose() * stress, assembler);
    nodes.add_force(a, 2, b.middleCols<3>(6 * a + 3).transpose() * stress, assembler);
  }
  if (!assembler.wants_tangent()) return;
  const bool exact = assembler.tangent() == Assembler::Tangent::exact;
  for (int a = 0; a < 3; ++a)
    for (int c = 0; c < 3; ++c) {
      if (!nodes.is_wanted(a, c, assembler)) continue;
      Eigen::Matrix<double, 6, 6> k = b.middleCols<6>(6 * a).transpose() * d * b.middleCols<6>(6 * c);
      if (exact && a == c)
        for (int v = 0; v < 2; ++v)
          for (int w = 0; w < 2; ++w) k.block<3, 3>(3 * v, 3 * w).diagonal().array() += second_difference[a] * s(v, w);
      const auto block = assembler.block(nodes.node[a], nodes.node[c]);
      for (int col = 0; col < 6; ++col)
        for (int row = 0; row < 6; ++row)
          block.data[static_cast<std::size_t>(col + 3) * block.stride + row + 3] += k(row, col);
    }
}

void EnrichedBeams::add_gauss_point(const Z& z, const Z& last_step, const Section& section, const Measures& reference,
                                    const ElementNodes& nodes, const std::array<double, 3>& n,
                                    const std::array<double, 3>& dn, double weight, Assembler& assembler) const {
  const Measures strain = measures(z, section) - reference;
  const AxialLaw law = axial_law(strain[0]);
  const double stiffer = section.axial_stiffness * (law.stiffness - 1),  // than linear, by E_ss
      offset = section.axial_stiffness * (law.stress - law.stiffness * strain[0]);
  // S of the gradient z S, and of the geometric part S ⊗ I₃ of the tangent.
  const auto stress = [&](const Measures& strain) {
    Measures by_measure = section.stiffness * strain;
    by_measure[0] += stiffer * strain[0] + offset;
    MeasureMatrix s = MeasureMatrix::Zero();
    for (int k = 0; k < n_measures_; ++k) s += by_measure[k] * section.measure[k];
    return s;
  };
  MeasureMatrix s = stress(assembler.last_step() ? strain - measures(last_step, section) : strain);
  const bool differs_for_forces = assembler.last_step() && !assembler.expects_forces();
  const Z force = weight * z * (differs_for_forces ? stress(strain) : s);

  // Node vector v of node a enters z through at most two columns: r through z₀; g₁ through z₁, z₃; g₂ through z₂, z₄.
  static constexpr int by_value[3] = {-1, 1, 2}, by_derivative[3] = {0, 3, 4};
  for (int a = 0; a < 3; ++a)
    for (int v = 0; v < 3; ++v) {
      Vec3 f = dn[a] * force.col(by_derivative[v]);
      if (v > 0) f += n[a] * force.col(by_value[v]);
      nodes.add_force(a, v, f, assembler);
    }
  if (!assembler.wants_tangent()) return;

  if (assembler.tangent() == Assembler::Tangent::projected) {
    const Eigen::SelfAdjointEigenSolver<MeasureMatrix> eigen(s);
    s = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() * eigen.eigenvectors().transpose();
  }
  // Map from the element's 27 unknowns to z, as 9 node vectors → 5 columns, then Kᵉ = (N⊗I)ᵀ (BᵀDB + S⊗I) (N⊗I) with
  // B, the derivative of the measures by z.
  Eigen::Matrix<double, 5, 9> map = Eigen::Matrix<double, 5, 9>::Zero();
  for (int a = 0; a < 3; ++a) {
    map(0, 3 * a) = dn[a];
    map(1, 3 * a + 1) = map(2, 3 * a + 2) = n[a];
    map(3, 3 * a + 1) = map(4, 3 * a + 2) = dn[a];
  }
  // Measure by measure: products of matrices of no fixed size would cost more in packing than in flops.
  Eigen::Matrix<double, 27, n_measures_twist_stretch> by_measure;  // (B (N⊗I))ᵀ
  for (int m = 0; m < n_measures_; ++m) {
    const Z by_z = z * section.measure[m];
    auto column = by_measure.col(m);
    for (int a = 0; a < 3; ++a)
      for (int v = 0; v < 3; ++v) {
        column.segment<3>(9 * a + 3 * v) = dn[a] * by_z.col(by_derivative[v]);
        if (v > 0) column.segment<3>(9 * a + 3 * v) += n[a] * by_z.col(by_value[v]);
      }
  }
  Eigen::Matrix<double, 27, 27> k = Eigen::Matrix<double, 27, 27>::Zero();
  for (int m = 0; m < n_measures_; ++m) {
    Eigen::Matrix<double, 27, 1> by_stress = Eigen::Matrix<double, 27, 1>::Zero();  // that times D
    for (int l = 0; l < n_measures_; ++l)
      if (const double d = weight * section.stiffness(l, m); d != 0) by_stress += d * by_measure.col(l);
    if (m == 0) by_stress += weight * stiffer * by_measure.col(0);
    for (int c = 0; c < 27; ++c) k.col(c) += by_stress[c] * by_measure.col(m);
  }
  const Eigen::Matrix<double, 9, 9> geometric = weight * map.transpose() * s * map;
  for (int v = 0; v < 9; ++v)
    for (int w = 0; w < 9; ++w) k.block<3, 3>(3 * v, 3 * w).diagonal().array() += geometric(v, w);
  nodes.add_tangent(k, assembler);
}

}  // namespace trame::micro
