#pragma once
/// \file
/// Physical quantities with their units, as text.

#include <stdexcept>
#include <string_view>

namespace trame {

/// The machine lacks the database of units, which no input could make up for.
class NoUnits : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The value of a quantity such as "19 um", "3 GPa" or "45 deg" in `si_unit` ("m", "Pa", "rad", "N m", "1" …).
/// Units are those of UDUNITS. An angle is not a plain number: "rad" and "1" do not convert into each other.
/// Throws InputError that says what is wrong with the text, but not where it stands: that is for the caller to add.
/// Throws NoUnits. Not thread-safe, because UDUNITS is not.
[[nodiscard]] double parse_quantity(std::string_view text, std::string_view si_unit);

}  // namespace trame
