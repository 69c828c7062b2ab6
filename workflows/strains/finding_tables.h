#pragma once
/// \file
/// What is found in yarns between two states, beside their strains: sections, shear bands, shear zones, validity of the
/// continuum. CSV files, and a line per yarn for the terminal.

#include <filesystem>
#include <string>
#include <vector>

#include "meso/findings.h"
#include "workflows/strains/strain_tables.h"

namespace trame::workflows {

/// Writers of CSV files; lengths in m, or in fiber distances (`_d`). Empty fields, or nan, where there is no value.
/// Each throws WriteError where the file cannot be written.

/// One line per yarn and station.
void write_sections_csv(const std::filesystem::path& file, const std::vector<micro::Yarn>& yarns,
                        const std::vector<meso::YarnFindings>& findings);
/// One line per yarn, station, component and band.
void write_bands_csv(const std::filesystem::path& file, const std::vector<micro::Yarn>& yarns,
                     const MeshedStrains& strains);
/// One line per yarn and component: correlation of the strain with itself, by direction.
void write_orientation_csv(const std::filesystem::path& file, const std::vector<micro::Yarn>& yarns,
                           const MeshedStrains& strains);
/// One line per yarn and zone.
void write_zones_csv(const std::filesystem::path& file, const std::vector<micro::Yarn>& yarns,
                     const MeshedStrains& strains);
/// One line per yarn.
void write_continuum_csv(const std::filesystem::path& file, const std::vector<micro::Yarn>& yarns,
                         const std::vector<meso::YarnFindings>& findings);

/// One line per yarn: means over its sections, counts of bands and zones. `strains`: of the same yarns.
void print_findings(const std::vector<micro::Yarn>& yarns, const std::vector<meso::YarnFindings>& findings,
                    const MeshedStrains& strains);
/// One line per yarn: the verdict on it as a continuum, in words.
void print_validity(const std::vector<micro::Yarn>& yarns, const std::vector<meso::YarnFindings>& findings);

}  // namespace trame::workflows
