#include "micro/core/quantity.h"

#include <fmt/format.h>
#include <udunits2.h>

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <memory>
#include <string>

#include "micro/core/error.h"

namespace trame {

namespace {

using Unit = std::unique_ptr<ut_unit, decltype(&ut_free)>;
using Converter = std::unique_ptr<cv_converter, decltype(&cv_free)>;

using UnitSystem = std::unique_ptr<ut_system, decltype(&ut_free_system)>;

/// The units of UDUNITS, and "deg", which it only knows as degree, arc_degree or °.
UnitSystem load_units() {
  ut_set_error_message_handler(ut_ignore);  // the default writes to stderr
  UnitSystem system(ut_read_xml(nullptr), ut_free_system);
  if (!system) throw InputError("the unit database of UDUNITS (udunits2.xml) cannot be read: is it installed?");
  const Unit degree(ut_get_unit_by_name(system.get(), "arc_degree"), ut_free);
  if (degree) ut_map_name_to_unit("deg", UT_ASCII, degree.get());
  return system;
}

ut_system* unit_system() {
  static const UnitSystem system = load_units();
  return system.get();
}

Unit parse_unit(const std::string& text) { return {ut_parse(unit_system(), text.c_str(), UT_UTF8), ut_free}; }

/// Whether the definition in base units holds a radian, which UDUNITS takes for a plain 1.
bool is_angular(const ut_unit* unit) {
  char text[256];
  const int length = ut_format(unit, text, sizeof text, UT_ASCII | UT_DEFINITION);
  return length > 0 &&
         std::string_view(text, std::min<std::size_t>(length, sizeof text)).find("rad") != std::string_view::npos;
}

/// Whether one unit is a multiple of the other. UDUNITS itself also converts reciprocals (s to Hz), angles to numbers
/// and scales with another zero (m from 10).
bool are_multiples(ut_unit* a, ut_unit* b) {
  const Unit quotient(ut_divide(a, b), ut_free);
  if (!quotient || !ut_is_dimensionless(quotient.get()) || is_angular(a) != is_angular(b)) return false;
  const Converter converter(ut_get_converter(a, b), cv_free);
  return converter && cv_convert_double(converter.get(), 0.0) == 0;
}

/// How many `to` one `from` is.
double conversion_factor(ut_unit* from, ut_unit* to) {
  const Converter converter(ut_get_converter(from, to), cv_free);
  return cv_convert_double(converter.get(), 1.0);
}

/// Whether a number stands where a unit should, which UDUNITS takes for a factor: "m 3", "3/m".
bool has_number(std::string_view unit) {
  constexpr std::string_view separators = " \t.*/", number_starts = "0123456789+-";
  for (std::size_t i = 0; i < unit.size(); ++i)
    if (number_starts.find(unit[i]) != unit.npos && (i == 0 || separators.find(unit[i - 1]) != unit.npos)) return true;
  return false;
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blank = " \t";
  const auto first = text.find_first_not_of(blank);
  return first == text.npos ? std::string_view() : text.substr(first, text.find_last_not_of(blank) - first + 1);
}

}  // namespace

double parse_quantity(std::string_view text, std::string_view si_unit) {
  const std::string_view all = trimmed(text);
  double value = 0;
  const auto [rest, status] = std::from_chars(all.data(), all.data() + all.size(), value);
  if (status == std::errc::result_out_of_range || (status == std::errc() && !std::isfinite(value)))
    throw InputError("the number is not finite");
  if (status != std::errc()) throw InputError("does not start with a number");

  const std::string unit_text(trimmed(all.substr(rest - all.data())));
  if (unit_text.empty()) throw InputError("the unit is missing");
  const Unit expected = parse_unit(std::string(si_unit));
  assert(expected && "si_unit must be known to UDUNITS");
  const Unit unit = has_number(unit_text) ? Unit(nullptr, ut_free) : parse_unit(unit_text);
  if (!unit) throw InputError(fmt::format("\"{}\" is not a unit", unit_text));
  if (!are_multiples(unit.get(), expected.get()))
    throw InputError(fmt::format("\"{}\" does not convert to {}", unit_text, si_unit));
  // A small unit divides, because 10^6 is a double and 10^-6 is not: "19 um" is the double nearest to 19e-6.
  const double factor = conversion_factor(unit.get(), expected.get());
  const double si = factor < 1 ? value / conversion_factor(expected.get(), unit.get()) : value * factor;
  if (!std::isfinite(si)) throw InputError("the number is not finite");
  return si;
}

}  // namespace trame
