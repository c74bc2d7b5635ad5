#include "engrave/io/dxf_unit.h"

#include <array>
#include <cmath>

#include "engrave/io/number_text.h"

namespace intaglio::io {
namespace {

constexpr double kSurveyFoot_mm = 1200.0 / 3937 * 1000;
constexpr std::array<double, 25> kUnits_mm = {1,                       // none
                                              25.4,                    // inch
                                              304.8,                   // foot
                                              1609344,                 // mile
                                              1,                       // millimetre
                                              10,                      // centimetre
                                              1000,                    // metre
                                              1e6,                     // kilometre
                                              25.4e-6,                 // microinch
                                              0.0254,                  // mil
                                              914.4,                   // yard
                                              1e-7,                    // angstrom
                                              1e-6,                    // nanometre
                                              1e-3,                    // micrometre
                                              100,                     // decimetre
                                              1e4,                     // decametre
                                              1e5,                     // hectometre
                                              1e12,                    // gigametre
                                              1.495978707e14,          // astronomical
                                              9.4607304725808e18,      // light year
                                              3.0856775814913673e19,   // parsec
                                              kSurveyFoot_mm,          // US survey foot
                                              kSurveyFoot_mm / 12,     // and inch
                                              3 * kSurveyFoot_mm,      // and yard
                                              5280 * kSurveyFoot_mm};  // and mile

}  // namespace

std::optional<double> DxfUnitMm(std::string_view insunits) {
  constexpr std::string_view kBlanks = " \t\r";
  const std::size_t first = insunits.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return std::nullopt;
  const std::size_t last = insunits.find_last_not_of(kBlanks);
  const auto code = ParseFinite(insunits.substr(first, last - first + 1));
  if (!code || *code != std::trunc(*code) || *code < 0 || *code >= kUnits_mm.size()) {
    return std::nullopt;
  }
  return kUnits_mm[static_cast<std::size_t>(*code)];
}

}  // namespace intaglio::io
