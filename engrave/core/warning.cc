#include "engrave/core/warning.h"

#include <algorithm>
#include <array>

namespace intaglio {
namespace {

using enum WarningWeight;

struct Row {
  WarningCode code;
  const char* name;
  WarningWeight weight;
};

// In the order of WarningCode.
constexpr std::array kRows = {
    Row{WarningCode::kOther, "other", kNote},
    Row{WarningCode::kChosen, "chosen", kNote},
    Row{WarningCode::kOpenSurface, "open_surface", kNote},
    Row{WarningCode::kNonManifoldEdges, "non_manifold_edges", kNote},
    Row{WarningCode::kFlippedTriangles, "flipped_triangles", kNote},
    Row{WarningCode::kOneSided, "one_sided", kNote},
    Row{WarningCode::kInsideOut, "inside_out", kNote},
    Row{WarningCode::kEmptyTriangles, "empty_triangles", kNote},
    Row{WarningCode::kRepeatedTriangles, "repeated_triangles", kNote},
    Row{WarningCode::kImplausibleSize, "implausible_size", kWarning},
    Row{WarningCode::kLeftOut, "left_out", kNote},
    Row{WarningCode::kParallelFaces, "parallel_faces", kWarning},
    Row{WarningCode::kOddRays, "odd_rays", kWarning},
    Row{WarningCode::kThinForShells, "thin_for_shells", kWarning},
    Row{WarningCode::kDoubledPoints, "doubled_points", kWarning},
    Row{WarningCode::kNearPoints, "near_points", kWarning},
    Row{WarningCode::kHole, "hole", kWarning},
    Row{WarningCode::kBreakage, "breakage", kConsent},
    Row{WarningCode::kOrientation, "orientation", kNote},
    Row{WarningCode::kFallbackFont, "fallback_font", kNote},
    Row{WarningCode::kTextShrunk, "text_shrunk", kNote},
    Row{WarningCode::kFocusSpread, "focus_spread", kNote},
    Row{WarningCode::kObliqueBeam, "oblique_beam", kWarning},
    Row{WarningCode::kTwoFoci, "two_foci", kWarning},
    Row{WarningCode::kPulseHeat, "pulse_heat", kWarning},
    Row{WarningCode::kModelsOverlap, "models_overlap", kWarning},
    Row{WarningCode::kSlowDepthAxis, "slow_depth_axis", kNote},
    Row{WarningCode::kUntrustedPoints, "untrusted_points", kWarning}};

constexpr bool RowsAreInOrder() {
  for (std::size_t i = 0; i < kRows.size(); ++i) {
    if (kRows[i].code != static_cast<WarningCode>(i)) return false;
  }
  return true;
}
static_assert(RowsAreInOrder());

constexpr std::array kWeightNames = {"note", "warning", "consent"};

const Row& RowOf(WarningCode code) { return kRows.at(static_cast<std::size_t>(code)); }

}  // namespace

Warning MakeWarning(WarningCode code, std::string text) {
  return {code, RowOf(code).weight, std::move(text)};
}

const char* WarningCodeName(WarningCode code) { return RowOf(code).name; }

const char* WarningWeightName(WarningWeight weight) {
  return kWeightNames.at(static_cast<std::size_t>(weight));
}

WarningCode WarningCodeOf(std::string_view name) {
  const auto* row = std::find_if(kRows.begin(), kRows.end(),
                                 [&](const Row& r) { return r.name == name; });
  return row == kRows.end() ? WarningCode::kOther : row->code;
}

WarningWeight WarningWeightOf(std::string_view name) {
  const auto* found = std::find(kWeightNames.begin(), kWeightNames.end(), name);
  return found == kWeightNames.end()
             ? kNote
             : static_cast<WarningWeight>(found - kWeightNames.begin());
}

WarningWeight GreatestWeight(const Warnings& warnings) {
  WarningWeight greatest = kNote;
  for (const Warning& warning : warnings) greatest = std::max(greatest, warning.weight);
  return greatest;
}

Warnings AtLeast(WarningWeight weight, const Warnings& warnings) {
  Warnings heavy;
  std::copy_if(warnings.begin(), warnings.end(), std::back_inserter(heavy),
               [&](const Warning& warning) { return warning.weight >= weight; });
  std::stable_sort(heavy.begin(), heavy.end(), [](const Warning& a, const Warning& b) {
    return a.weight > b.weight;
  });
  return heavy;
}

const Warning* FindConsent(const Warnings& warnings) {
  const auto found =
      std::find_if(warnings.begin(), warnings.end(),
                   [](const Warning& warning) { return warning.weight == kConsent; });
  return found == warnings.end() ? nullptr : &*found;
}

}  // namespace intaglio
