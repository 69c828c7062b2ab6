#pragma once
/// \file
/// Included before every file of the programs that tell of yarns. Everything between two states is computed once, by
/// `meso::YarnComparer`, and they only read it: to compute any of it again is an error of the compiler.

#include "meso/comparison.h"
#include "meso/continuum/non_affine.h"

#pragma GCC poison mesh_yarn section_coordinates strain_between nodal_strain summarise weighted_statistics
#pragma GCC poison YarnSections section_pairs section_pair section_means axial_strains
#pragma GCC poison longitudinal_plane find_shear_bands survey_bands survey_orientation find_shear_zones
#pragma GCC poison yarn_continuum exchanged_neighbours non_affine_residual
#pragma GCC poison fabric_facts fiber_densities plan_cover
// The report draws sections on cuts of its own, finer than those of a comparison; nothing is measured on them.
#ifndef TRAME_DRAWS_CUTS
#pragma GCC poison cut_yarn
#endif
