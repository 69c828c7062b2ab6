#pragma once
/// \file
/// curves.csv: strains and forces of a weave's sides, and motion and reaction of every dof that a scene drives.

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "micro/scene/driven_dofs.h"

namespace trame::workflows {

/// Rows are increments, and the start of each stage at stage time 0; all in SI units.
struct CurvesTable {
  struct Row {
    std::string stage;
    double stage_time = 0;
    std::vector<double> values;  ///< one per column
  };
  std::vector<std::string> columns;  ///< after "stage" and "stage_time"
  std::vector<Row> rows;

  [[nodiscard]] std::optional<std::size_t> find(const std::string& column) const;
};

inline constexpr std::array<const char*, 4> side_columns = {"warp_strain", "weft_strain", "warp_force_N",
                                                            "weft_force_N"};

/// "right.x_m" and "right.x_N", or "right.rx_rad" and "right.rx_Nm".
[[nodiscard]] std::array<std::string, 2> dof_columns(const std::string& body, micro::BodyDof dof);

/// What the columns are of.
struct CurvesLayout {
  bool has_sides = false;
  std::vector<std::string> body_names;
  std::vector<micro::DrivenDof> dofs;

  [[nodiscard]] std::vector<std::string> columns() const;
  /// `motion`, `reaction`: `micro::n_body_dofs` numbers for each body.
  [[nodiscard]] std::vector<double> values(const std::array<double, 2>& strain, const std::array<double, 2>& force,
                                           const std::vector<double>& motion,
                                           const std::vector<double>& reaction) const;
};
[[nodiscard]] CurvesLayout curves_layout(const micro::Scene& scene, const std::vector<std::string>& body_names);

/// Throws WriteError.
void write_curves_csv(const std::filesystem::path& file, const CurvesTable& table);
/// Throws InputError for a file that is missing or not such a table.
[[nodiscard]] CurvesTable read_curves(const std::filesystem::path& file);

}  // namespace trame::workflows
