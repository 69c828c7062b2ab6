#pragma once
/// \file
/// What a test by name is done for: one curve, made of what drives move and bear.

#include <string>
#include <vector>

#include "micro/rigid/body_dof.h"

namespace trame::micro {

/// A reaction over a motion, both sums over driven dofs of bodies, each times a weight.
struct TestCurve {
  struct Term {
    std::string body;
    BodyDof dof = BodyDof::x;
    double motion = 0, reaction = 0;  ///< weights
    double length = 0;                ///< weight of its motion before the test, in the length that motions are over
  };
  std::string name;                        ///< "plates"
  std::string motion_unit, reaction_unit;  ///< "m", "Pa"
  std::string stage;
  std::vector<Term> terms;
  double length = 0;  ///< as laid out, m: motions count over this and what became of it before the test; 0: they do not

  bool operator==(const TestCurve&) const = default;
};

}  // namespace trame::micro
