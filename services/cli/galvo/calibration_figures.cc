#include "services/cli/galvo/calibration_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace intaglio::cli {
namespace {

constexpr int kPlacesASide = 97;  // of the field's figure: twelve from mark to mark of 9
constexpr int kDeviationNodes = 129;

struct Sizes {
  double rms_um = 0, largest_um = 0;
};

Sizes SizesOf(const std::vector<Vec2>& by_mm) {
  Sizes sizes;
  for (const Vec2& v : by_mm) {
    sizes.rms_um += 1e6 * v.squaredNorm();
    sizes.largest_um = std::max(sizes.largest_um, 1e3 * v.norm());
  }
  sizes.rms_um = std::sqrt(sizes.rms_um / static_cast<double>(by_mm.size()));
  return sizes;
}

/// How far places arrive beside what was asked for, by the fitted head with the
/// correction in use: over the square of the marks, between them too. Free of the noise
/// of single marks.
Sizes SizesOverField(const std::vector<galvo::GridMark>& as_marked,
                     const galvo::HeadFit& fit, const galvo::CorrectionTable* before,
                     double width_mm) {
  const auto deviations = galvo::CorrectionTable::Make(
      galvo::DeviationsOf(fit, width_mm, kDeviationNodes), galvo::Interpolation::kSpline);
  if (!deviations) return {};
  Vec2 low = as_marked[0].command_mm, high = low;
  for (const galvo::GridMark& mark : as_marked) {
    low = low.cwiseMin(mark.command_mm);
    high = high.cwiseMax(mark.command_mm);
  }
  std::vector<Vec2> by_mm;
  for (int j = 0; j < kPlacesASide; ++j) {
    for (int i = 0; i < kPlacesASide; ++i) {
      const Vec2 place_mm =
          low + Vec2(i, j).cwiseProduct(high - low) / (kPlacesASide - 1);
      const Vec2 by_table_mm = before == nullptr ? Vec2::Zero() : before->At(place_mm);
      by_mm.push_back(by_table_mm + deviations->At(place_mm + by_table_mm));
    }
  }
  return SizesOf(by_mm);
}

}  // namespace

std::vector<std::string> ModelLines(const galvo::HeadFit& fit) {
  std::vector<std::string> lines;
  const auto numbers = fit.model.Numbers();
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    lines.push_back(fmt::format("{:<13} {:.6g} +- {:.2g}, 95 %",
                                galvo::kHeadModelNames[k], numbers[k],
                                fit.interval95[k]));
  }
  return lines;
}

std::vector<std::string> FitLines(const std::vector<galvo::GridMark>& as_marked,
                                  const galvo::HeadFit& fit,
                                  const galvo::CorrectionTable* before, double width_mm) {
  std::vector<Vec2> measured, left;
  for (std::size_t i = 0; i < as_marked.size(); ++i) {
    if (!fit.used[i]) continue;
    measured.push_back(as_marked[i].measured_mm - as_marked[i].command_mm);
    left.push_back(fit.residuals_mm[i]);
  }
  const Sizes was = SizesOf(measured), is = SizesOf(left);
  const Sizes field = SizesOverField(as_marked, fit, before, width_mm);
  std::vector<std::string> lines = {
      fmt::format("marks         {}, {} left out as too far from all others",
                  measured.size(), as_marked.size() - measured.size()),
      fmt::format("measured      {:.1f} um rms, {:.1f} um largest beside the commands",
                  was.rms_um, was.largest_um),
      fmt::format("field         {:.1f} um rms, {:.1f} um largest, between the marks too "
                  "and without their noise",
                  field.rms_um, field.largest_um),
      fmt::format("fitted        {:.2f} um rms, {:.2f} um largest left", is.rms_um,
                  is.largest_um),
      fmt::format("sigma         {:.2f} um of a coordinate of a mark",
                  1e3 * fit.sigma_mm),
      fmt::format("unseen marks  {:.2f} um rms by the ten numbers, {:.2f} um with a "
                  "surface of what they leave",
                  1e3 * fit.unseen_rms_mm, 1e3 * fit.unseen_rms_with_surface_mm)};
  lines.push_back(fit.surface_cells > 0
                      ? fmt::format("surface       {0} x {0} cells", fit.surface_cells)
                      : "surface       none: what is left is chance");
  return lines;
}

}  // namespace intaglio::cli
