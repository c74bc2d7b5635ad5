#include "materials_db/index_glass.h"

#include <fmt/format.h>

#include "materials_db/numbers.h"

namespace intaglio::materials_db {
namespace {

constexpr std::string_view kPrefix = "n=";
constexpr double kMaxIndex = 4;
constexpr double kMinWavelengthUm = 0.2, kMaxWavelengthUm = 10;

}  // namespace

std::string NameOfIndexGlass(double refractive_index) {
  return fmt::format("{}{}", kPrefix, refractive_index);
}

std::optional<Result<Material>> IndexGlass(std::string_view name) {
  if (!name.starts_with(kPrefix) && !name.starts_with("N=")) return std::nullopt;
  const auto numbers = ParseNumbers(name.substr(kPrefix.size()));
  if (!numbers || numbers->size() != 1 ||
      !(numbers->front() >= 1 && numbers->front() <= kMaxIndex)) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("\"{}\" is not the index of a glass, 1..{}; write it as n=1.52", name,
                    kMaxIndex),
        std::string(name));
  }
  Material glass;
  glass.name = NameOfIndexGlass(numbers->front());
  glass.source = "The index is as it was given, the same at all wavelengths.";
  glass.dispersion.formula = optics::DispersionFormula::kRiiCauchy;
  glass.dispersion.coefficients = {numbers->front()};
  glass.dispersion.min_wavelength_um = kMinWavelengthUm;
  glass.dispersion.max_wavelength_um = kMaxWavelengthUm;
  return glass;
}

}  // namespace intaglio::materials_db
