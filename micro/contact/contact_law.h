#pragma once
/// \file
/// Numbers of contact: where it is looked for, and how it presses and rubs.

#include <functional>

#include "micro/core/types.h"

namespace trame::micro {

struct ProximitySearch {
  double spacing = 0.5;        ///< of samples, in element lengths
  double search_margin = 0.5;  ///< pairs up to this surface distance are returned, in radii (the mean of both)
  bool self_contact = false;
  std::function<bool(Index, Index)> wanted;  ///< pairs of fibers to look at, but for images; empty: all
};

/// Numbers of the contact law, in the unit system of the model.
struct ContactLaw {
  ProximitySearch search;
  double penalty = 0.02;             ///< starting stiffness per length over the softer fiber's transverse modulus
  double target_penetration = 0.01;  ///< in radii
  double regularisation = 0.1;       ///< p_reg of the penalty, in radii
  bool adapt_penalty = true;         ///< preloads and penalties follow what the scene needs
  bool friction = true;
  double friction_coefficient = 0.2;  ///< µ
  double reversible_slip = 0.05;      ///< u_rev, elastic slip before sliding, in radii
};

}  // namespace trame::micro
