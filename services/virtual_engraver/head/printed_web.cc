#include "services/virtual_engraver/head/printed_web.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace intaglio::virtual_engraver {

PrintedWeb::PrintedWeb(const PrintOptions& options) : options_(options) {
  std::ranges::sort(options_.false_mm);
  std::ranges::sort(options_.missing);
  found_ = FindNext();
}

// The first is half a pitch from the eye at power-up. The integral of 1 + s + r sin(2 pi
// u / L) along the print before it stretched.
double PrintedWeb::PlaceOf(std::uint32_t number) const {
  const double along_mm = options_.pitch_mm * (number + 0.5);
  const double wave_mm = options_.ripple_mm / (2 * std::numbers::pi);
  return (1 + options_.stretch_ratio) * along_mm +
         options_.ripple_ratio * wave_mm * (1 - std::cos(along_mm / wave_mm));
}

std::optional<PrintedWeb::Passed> PrintedWeb::FindNext() {
  std::optional<Passed> first;
  if (options_.pitch_mm > 0) {
    while (std::ranges::binary_search(options_.missing, next_)) ++next_;
    first = Passed{PlaceOf(next_), true};
  }
  if (next_false_ < options_.false_mm.size()) {
    const double false_mm = options_.false_mm[next_false_];
    if (!first || false_mm < first->place_mm) first = Passed{false_mm, false};
  }
  return first;
}

std::optional<PrintedWeb::Passed> PrintedWeb::Next(double web_mm) {
  if (!found_ || found_->place_mm > web_mm) return std::nullopt;
  const auto passed = found_;
  if (passed->printed) {
    ++next_;
  } else {
    ++next_false_;
  }
  found_ = FindNext();
  return passed;
}

}  // namespace intaglio::virtual_engraver
