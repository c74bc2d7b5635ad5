#include "engrave/mesh/plausible_size.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "engrave/core/check.h"

namespace intaglio::mesh {
namespace {

// Methods leave out the outermost part of a model (sections: a tenth of a layer), so the
// points decide of a model that is only a little too large.
constexpr double kLargerThanBlock = 1.1;
// A part of a large map or scan is cut out with clip.
constexpr double kLargerThanBlockWithClip = 100;
constexpr double kTiny = 0.02, kSmall = 0.1;  // of the block's smallest side
constexpr double kTinyMm = 2;                 // a dozen cracks, in any block
constexpr double kPlausible = 0.2;            // of the block's smallest side
constexpr double kFitShare = 0.9;             // of the block, of the size to fit to
// A block around a model of less than kTinyMm was made for a size that is in doubt, so it
// says nothing of the unit: this is what a piece has at most.
constexpr double kUsualPieceMm = 200;

struct Unit {
  const char* name;
  double mm;
};
constexpr std::array<Unit, 5> kUnits = {{{"inches", 25.4},
                                         {"centimetres", 10},
                                         {"metres", 1000},
                                         {"millimetres", 1},
                                         {"micrometres", 0.001}}};

std::string TextOf(const Vec3& mm) {
  const bool in_metres = mm.maxCoeff() >= 10'000;
  const Vec3 v = in_metres ? Vec3(mm / 1000) : mm;
  return fmt::format("{:.4g} x {:.4g} x {:.4g} {}", v.x(), v.y(), v.z(),
                     in_metres ? "m" : "mm");
}

double LargestShare(const Vec3& size_mm, const SizeInBlock& model) {
  return (size_mm.array() / model.block_size_mm.array()).maxCoeff();
}

bool IsTiny(const SizeInBlock& model) { return model.size_mm.maxCoeff() < kTinyMm; }

/// What a file in this unit would be; empty if that is no size for a piece.
std::string SizeInUnit(const Unit& unit, const SizeInBlock& model) {
  const double ratio = unit.mm / model.unit_mm;
  const Vec3 size_mm = ratio * model.size_mm;
  if (std::abs(ratio - 1) < 1e-3) return {};
  if (size_mm.maxCoeff() < kPlausible * model.block_size_mm.minCoeff()) return {};
  if (LargestShare(size_mm, model) <= 1) return TextOf(size_mm);
  if (!IsTiny(model) || size_mm.maxCoeff() > kUsualPieceMm) return {};
  return TextOf(size_mm) + ", in a larger block";
}

/// "Is the file in inches? Then give --unit 25.4 (...)."; empty when no unit helps.
std::string UnitQuestion(const SizeInBlock& model) {
  std::string question;
  if (model.fitted) return question;
  for (const Unit& unit : kUnits) {
    const std::string size = SizeInUnit(unit, model);
    if (size.empty()) continue;
    question += question.empty()
                    ? fmt::format(
                          "is the file in {}? Then give --unit {:g}, in a job "
                          "file placement.unit_mm: {:g} ({})",
                          unit.name, unit.mm, unit.mm, size)
                    : fmt::format("; in {}? --unit {:g} ({})", unit.name, unit.mm, size);
  }
  return question.empty() ? question : question + ". Or ";
}

/// To a size that the block holds, rounded down.
std::string FitAdvice(const SizeInBlock& model) {
  const double share = LargestShare(model.size_mm, model);
  if (!(share > 0)) return "give it a size with --size (fit_size_mm)";
  const double size_mm = kFitShare * model.size_mm.maxCoeff() / share;
  const double step_mm = size_mm < 5 ? 0.1 : 1;
  const double rounded_mm = std::max(step_mm, std::floor(size_mm / step_mm) * step_mm);
  if (IsTiny(model)) {
    return fmt::format(
        "give it a size with --size (fit_size_mm), at most {:g} in {} of {}", rounded_mm,
        model.room, TextOf(model.block_size_mm));
  }
  return fmt::format("scale it to the block: --size {:g} (fit_size_mm)", rounded_mm);
}

SizeFault FaultOf(const SizeInBlock& model, WarningWeight weight, const char* relation,
                  std::string_view name) {
  Warning warning = MakeWarning(
      WarningCode::kImplausibleSize,
      fmt::format("{}: the model is {}, {} {} of {}: {}{}", name, TextOf(model.size_mm),
                  relation, model.room, TextOf(model.block_size_mm), UnitQuestion(model),
                  FitAdvice(model)));
  warning.weight = weight;
  return {false, std::move(warning)};
}

SizeFault RefusalOf(const SizeInBlock& model, const char* relation,
                    std::string_view name) {
  SizeFault fault = FaultOf(model, WarningWeight::kWarning, relation, name);
  fault.refused = true;
  return fault;
}

}  // namespace

std::optional<SizeFault> FindSizeFault(const SizeInBlock& model,
                                       std::string_view model_name) {
  Require((model.block_size_mm.array() > 0).all() && model.unit_mm > 0,
          "a block of {} x {} x {} mm, a unit of {} mm", model.block_size_mm.x(),
          model.block_size_mm.y(), model.block_size_mm.z(), model.unit_mm);
  const double share = LargestShare(model.size_mm, model);
  if (share > (model.clip ? kLargerThanBlockWithClip : kLargerThanBlock)) {
    return RefusalOf(model, "larger than", model_name);
  }
  if (share > 1 && !model.clip) {
    return FaultOf(model, WarningWeight::kWarning, "larger than", model_name);
  }
  if (model.fitted) return std::nullopt;
  const double largest_mm = model.size_mm.maxCoeff();
  const double side_mm = model.block_size_mm.minCoeff();
  if (largest_mm < model.min_spacing_mm) {
    return RefusalOf(model, "smaller than the minimum spacing and tiny for", model_name);
  }
  if (largest_mm < kTiny * side_mm) {
    return FaultOf(model, WarningWeight::kWarning, "less than 2 % of", model_name);
  }
  if (IsTiny(model)) {
    return FaultOf(model, WarningWeight::kWarning, "less than 2 mm large in", model_name);
  }
  if (largest_mm < kSmall * side_mm && !UnitQuestion(model).empty()) {
    return FaultOf(model, WarningWeight::kNote, "small for", model_name);
  }
  return std::nullopt;
}

}  // namespace intaglio::mesh
