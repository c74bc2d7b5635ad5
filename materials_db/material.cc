#include "materials_db/material.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "engrave/optics/focus.h"
#include "engrave/optics/fresnel.h"
#include "engrave/optics/thermal.h"
#include "materials_db/numbers.h"
#include "materials_db/utf8.h"

namespace intaglio::materials_db {
namespace {

constexpr std::size_t kMaxNameBytes = 80;
constexpr std::size_t kMaxManufacturerBytes = 200;
constexpr std::size_t kMaxSourceBytes = 16 * 1024;
constexpr std::size_t kMaxTransmittances = 1000;

bool IsControl(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }

/// Mistakes that any of the texts may have.
void CheckText(const char* field, const std::string& text, std::size_t max_bytes,
               bool may_have_lines, std::vector<Error>& errors) {
  if (text.size() > max_bytes) {
    errors.push_back({ErrorCode::kTooLarge,
                      fmt::format("{} has {} bytes, more than {}; shorten it", field,
                                  text.size(), max_bytes),
                      std::to_string(text.size())});
  }
  if (!IsUtf8(text)) {
    errors.push_back({ErrorCode::kInvalidValue,
                      fmt::format("{} is not UTF-8 text; retype it", field), ""});
  }
  const bool has_control = std::any_of(text.begin(), text.end(), [=](char c) {
    return IsControl(c) && !(may_have_lines && (c == '\n' || c == '\t'));
  });
  if (has_control) {
    errors.push_back({ErrorCode::kInvalidValue,
                      fmt::format("{} contains a control character; retype it", field),
                      ""});
  }
}

void CheckName(const std::string& name, std::vector<Error>& errors) {
  CheckText("name", name, kMaxNameBytes, false, errors);
  if (name.empty()) {
    errors.push_back({ErrorCode::kMissing, "name is missing; give the glass a name", ""});
  } else if (name.front() == ' ' || name.back() == ' ') {
    errors.push_back({ErrorCode::kInvalidValue,
                      "name begins or ends with a space; remove the space", name});
  }
}

void CheckProperties(const Material& material, std::vector<Error>& errors) {
  for (const PropertyRow& row : PropertyRows()) {
    const std::optional<double>& value = material.*row.value;
    if (!value || (*value >= row.min && *value <= row.max)) continue;
    errors.push_back(
        {ErrorCode::kInvalidValue,
         fmt::format("{} must be {}..{}{}{}, is {}; check its unit", row.name, row.min,
                     row.max, *row.unit == '\0' ? "" : " ", row.unit, *value),
         FormatNumber(*value)});
  }
}

void CheckIndex(const optics::Dispersion& dispersion, std::vector<Error>& errors) {
  if (const Status status = optics::CheckDispersion(dispersion); !status) {
    Error error = status.error();
    error.message = "dispersion: " + error.message;
    errors.push_back(std::move(error));
    return;
  }
  const double middle_um =
      0.5 * (dispersion.min_wavelength_um + dispersion.max_wavelength_um);
  for (const double wavelength_um :
       {dispersion.min_wavelength_um, middle_um, dispersion.max_wavelength_um}) {
    const auto index = optics::RefractiveIndex(dispersion, wavelength_um * 1000);
    if (index) continue;
    Error error = index.error();
    error.message = "dispersion: " + error.message;
    errors.push_back(std::move(error));
    return;
  }
}

void CheckTransmittance(const Material& material, std::vector<Error>& errors) {
  const auto complain = [&](std::size_t i, const std::string& what, double value) {
    errors.push_back({ErrorCode::kInvalidValue,
                      fmt::format("transmittance[{}] {}", i, what), FormatNumber(value)});
  };
  const auto& table = material.transmittance;
  if (table.size() > kMaxTransmittances) {
    errors.push_back(
        {ErrorCode::kTooLarge,
         fmt::format("transmittance has {} entries, more than {}; leave some "
                     "out",
                     table.size(), kMaxTransmittances),
         std::to_string(table.size())});
    return;
  }
  for (std::size_t i = 0; i < table.size(); ++i) {
    const optics::Transmittance& entry = table[i];
    if (!(entry.wavelength_um > 0 && entry.wavelength_um <= 1000)) {
      complain(i, fmt::format("must be of 0..1000 um, is of {}", entry.wavelength_um),
               entry.wavelength_um);
    } else if (i > 0 && !(entry.wavelength_um > table[i - 1].wavelength_um)) {
      complain(i,
               fmt::format("of {} um is not behind that of {} um; sort the wavelengths",
                           entry.wavelength_um, table[i - 1].wavelength_um),
               entry.wavelength_um);
    }
    if (!(entry.ratio >= 0 && entry.ratio <= 1)) {
      complain(i, fmt::format("must be 0..1, is {}", entry.ratio), entry.ratio);
    }
    if (!(entry.thickness_mm > 0 && entry.thickness_mm <= 1000)) {
      complain(i, fmt::format("must be over 0..1000 mm, is over {}", entry.thickness_mm),
               entry.thickness_mm);
    }
  }
}

std::optional<double> ThermalStrengthOf(const Material& glass, optics::ThermalLoad load) {
  if (!glass.tensile_strength_mpa || !glass.poisson_ratio || !glass.expansion_per_k ||
      !glass.youngs_modulus_gpa || !(*glass.expansion_per_k > 0)) {
    return std::nullopt;
  }
  return optics::ThermalStrengthK({.tensile_strength_mpa = *glass.tensile_strength_mpa,
                                   .poisson_ratio = *glass.poisson_ratio,
                                   .expansion_per_k = *glass.expansion_per_k,
                                   .youngs_modulus_gpa = *glass.youngs_modulus_gpa},
                                  load);
}

}  // namespace

std::vector<Error> CheckMaterial(const Material& material) {
  std::vector<Error> errors;
  CheckName(material.name, errors);
  CheckText("manufacturer", material.manufacturer, kMaxManufacturerBytes, false, errors);
  CheckText("source", material.source, kMaxSourceBytes, true, errors);
  CheckIndex(material.dispersion, errors);
  CheckProperties(material, errors);
  CheckTransmittance(material, errors);
  return errors;
}

Result<OpticalValues> ComputeOptics(const Material& material, double wavelength_nm,
                                    double numerical_aperture) {
  if (!(numerical_aperture > 0 && numerical_aperture < 1)) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("the lens's numerical aperture must be above 0 and below 1, "
                            "is {}",
                            numerical_aperture),
                FormatNumber(numerical_aperture));
  }
  const auto index = optics::RefractiveIndex(material.dispersion, wavelength_nm);
  if (!index) {
    Error error = index.error();
    error.message = fmt::format("glass {}: {}", material.name, error.message);
    return tl::unexpected(std::move(error));
  }
  OpticalValues values;
  values.refractive_index = *index;
  if (const auto abbe = optics::AbbeNumber(material.dispersion)) {
    values.abbe_number = *abbe;
  }
  values.reflectance_ratio = optics::ReflectanceAtNormalIncidence(*index);
  values.stage_per_glass_ratio = optics::StagePerGlassRatio(*index, numerical_aperture);
  values.cone_tangent = optics::ConeTangentInGlass(*index, numerical_aperture);
  values.thermal_strength_k =
      ThermalStrengthOf(material, optics::ThermalLoad::kWholeBody);
  values.local_thermal_strength_k =
      ThermalStrengthOf(material, optics::ThermalLoad::kLocalHeating);
  values.absorption_per_mm =
      optics::AbsorptionPerMm(material.transmittance, wavelength_nm);
  return values;
}

}  // namespace intaglio::materials_db
