#pragma once
/// \file
/// What is found in yarns between two states, beside their strains: sections, shear bands, shear zones, validity of the
/// continuum. CSV files, and a line per yarn for the terminal.

#include <filesystem>
#include <string>
#include <vector>

#include "meso/comparison.h"

namespace trame::workflows {

/// Writers of CSV files; lengths in m, or in fiber distances (`_d`). Empty fields, or nan, where there is no value.
/// Each throws WriteError where the file cannot be written.

/// One line per yarn and section: its stations, then the places where it passes others.
void write_sections_csv(const std::filesystem::path& file, const std::vector<micro::Yarn>& yarns,
                        const meso::Comparison& comparison);
/// One line per yarn, section, component and band. `mesh`: index in the comparison's meshes.
void write_bands_csv(const std::filesystem::path& file, const std::vector<micro::Yarn>& yarns,
                     const meso::Comparison& comparison, std::size_t mesh);
/// One line per yarn and component: correlation of the strain with itself, by direction.
void write_orientation_csv(const std::filesystem::path& file, const std::vector<micro::Yarn>& yarns,
                           const meso::Comparison& comparison, std::size_t mesh);
/// One line per yarn and zone.
void write_zones_csv(const std::filesystem::path& file, const std::vector<micro::Yarn>& yarns,
                     const meso::Comparison& comparison, std::size_t mesh);
/// One line per yarn.
void write_continuum_csv(const std::filesystem::path& file, const std::vector<micro::Yarn>& yarns,
                         const meso::Comparison& comparison);

/// One line per yarn: means over its stations, counts of bands and zones.
void print_findings(const std::vector<micro::Yarn>& yarns, const meso::Comparison& comparison, std::size_t mesh);
/// One line per yarn: the verdict on it as a continuum, in words.
void print_validity(const std::vector<micro::Yarn>& yarns, const meso::Comparison& comparison);

}  // namespace trame::workflows
