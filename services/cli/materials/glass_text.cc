#include "services/cli/materials/glass_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/core/counted.h"
#include "materials_db/near_names.h"
#include "materials_db/numbers.h"
#include "services/cli/terminal/text_table.h"
#include "services/job/files/json_text.h"
#include "services/job/files/material_record.h"
#include "services/job/quality/pulse_focus.h"

namespace intaglio::cli {
namespace {

using materials_db::GlassAlias;
using materials_db::Material;
using materials_db::OpticalValues;
using materials_db::PropertyRow;
using materials_db::PropertyRows;

using Row = std::vector<std::string>;

/// Columns as wide as their widest entry, two spaces between.
std::string Table(const std::vector<Row>& rows) {
  std::vector<std::size_t> widths;
  for (const Row& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) {
      widths[i] = std::max(widths[i], ColumnsOf(row[i]));
    }
  }
  std::string text;
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      text += i + 1 == row.size() ? row[i] : fmt::format("{:<{}}  ", row[i], widths[i]);
    }
    text += "\n";
  }
  return text;
}

std::string OrUnknown(const std::optional<double>& value, int digits) {
  return value ? fmt::format("{:.{}f}", *value, digits) : "-";
}

constexpr std::size_t kTextColumns = 72;

/// Text in the second column, its lines broken at spaces.
void AddLines(const char* title, std::string_view text, std::vector<Row>& rows) {
  while (!text.empty()) {
    std::size_t end = std::min(text.find('\n'), text.size());
    if (end > kTextColumns) {
      const std::size_t space = text.rfind(' ', kTextColumns);
      end = space == 0 || space == std::string_view::npos ? kTextColumns : space;
    }
    rows.push_back({title, std::string(text.substr(0, end))});
    const bool drops_one = end < text.size() && (text[end] == ' ' || text[end] == '\n');
    text.remove_prefix(end + (drops_one ? 1 : 0));
    title = "";
  }
}

std::string TransmittanceText(std::span<const optics::Transmittance> table) {
  if (table.empty()) return "unknown";
  return fmt::format("{}, {:g}-{:g} nm", Counted(table.size(), "wavelength"),
                     table.front().wavelength_um * 1000,
                     table.back().wavelength_um * 1000);
}

std::string KelvinText(const std::optional<double>& kelvin) {
  return kelvin ? fmt::format("{:.0f} K", *kelvin) : "unknown";
}

std::vector<Row> KeptRows(const Material& material) {
  const optics::Dispersion& dispersion = material.dispersion;
  std::vector<Row> rows = {{"glass", material.name}};
  if (!material.manufacturer.empty()) {
    rows.push_back({"manufacturer", material.manufacturer});
  }
  rows.push_back(
      {"dispersion",
       fmt::format("{}, {:g}-{:g} nm", optics::DispersionFormulaName(dispersion.formula),
                   dispersion.min_wavelength_um * 1000,
                   dispersion.max_wavelength_um * 1000)});
  rows.push_back({"coefficients", materials_db::FormatNumbers(dispersion.coefficients)});
  constexpr double kLineGNm = 435.8343, kLineFNm = 486.1327;
  const auto total = optics::TotalDispersion(dispersion);
  rows.push_back(
      {"total dispersion nF - nC", total ? fmt::format("{:.6f}", *total) : "-"});
  const auto partial = optics::PartialDispersionRatio(dispersion, kLineGNm, kLineFNm);
  rows.push_back(
      {"partial dispersion P(g,F)", partial ? fmt::format("{:.4f}", *partial) : "-"});
  for (const PropertyRow& row : PropertyRows()) {
    const std::optional<double>& value = material.*row.value;
    rows.push_back({row.title, value ? fmt::format("{:g}{}{}", *value,
                                                   *row.unit == '\0' ? "" : " ", row.unit)
                                     : "unknown"});
  }
  rows.push_back({"transmittance", TransmittanceText(material.transmittance)});
  AddLines("source", material.source, rows);
  return rows;
}

bool IsAliasOf(const GlassAlias& alias, const Material& material) {
  return materials_db::SpellingOf(alias.glass) == materials_db::SpellingOf(material.name);
}

std::vector<std::string> NamesOf(const Material& material,
                                 std::span<const GlassAlias> aliases) {
  std::vector<std::string> names;
  for (const GlassAlias& alias : aliases) {
    if (IsAliasOf(alias, material)) names.push_back(alias.name);
  }
  return names;
}

/// R + A + T of blocks of usual heights, and what arrives at their lowest points.
std::string LightAsTable(const OpticalValues& values) {
  if (!values.absorption_per_mm) {
    return "Absorption at this wavelength: unknown; the glass has no transmittance "
           "there\n";
  }
  std::vector<Row> rows = {
      {"BLOCK MM", "REFLECTED", "ABSORBED", "TRANSMITTED", "AT THE BOTTOM"}};
  for (const double height_mm : {10.0, 25.0, 50.0, 100.0, 170.0}) {
    const optics::LightShares shares = optics::SharesOfLight(
        values.reflectance_ratio, *values.absorption_per_mm, height_mm);
    const double deepest = optics::LightAtDepth(values.reflectance_ratio,
                                                *values.absorption_per_mm, height_mm);
    Row row = {fmt::format("{:g}", height_mm)};
    for (const double share :
         {shares.reflected, shares.absorbed, shares.transmitted, deepest}) {
      row.push_back(fmt::format("{:.2f} %", 100 * share));
    }
    rows.push_back(std::move(row));
  }
  return fmt::format("Absorption: {:.3g} of the light in a millimetre\n",
                     1 - std::exp(-*values.absorption_per_mm)) +
         Table(rows);
}

std::string Json(const google::protobuf::Message& message) {
  const auto json = JsonTextOf(message, JsonLayout::kOneLine);
  Require(json.has_value(), "{} as JSON: {}", message.GetTypeName(),
          json ? "" : json.error().message);
  return *json;
}

}  // namespace

std::string GlassesAsTable(std::span<const Material> materials,
                           std::span<const GlassAlias> aliases,
                           const PrintedLight& light) {
  std::vector<Row> rows = {{"GLASS", "MANUFACTURER",
                            fmt::format("n({:g} nm)", light.wavelength_nm), "ABBE",
                            "RANGE nm", "DENSITY kg/m3", "ALSO CALLED"}};
  for (const Material& material : materials) {
    const optics::Dispersion& dispersion = material.dispersion;
    const auto index = optics::RefractiveIndex(dispersion, light.wavelength_nm);
    const auto abbe = optics::AbbeNumber(dispersion);
    rows.push_back({material.name,
                    material.manufacturer.empty() ? "-" : material.manufacturer,
                    index ? fmt::format("{:.5f}", *index) : "-",
                    abbe ? fmt::format("{:.2f}", *abbe) : "-",
                    fmt::format("{:g}-{:g}", dispersion.min_wavelength_um * 1000,
                                dispersion.max_wavelength_um * 1000),
                    OrUnknown(material.density_kg_m3, 0),
                    fmt::format("{}", fmt::join(NamesOf(material, aliases), ", "))});
  }
  return Table(rows);
}

std::string GlassesAsJson(std::span<const Material> materials,
                          const PrintedLight& light) {
  std::string json = "[";
  for (const Material& material : materials) {
    json += (json.size() == 1 ? "\n" : ",\n") + GlassAsJson(material, light);
  }
  return json + "\n]";
}

std::string GlassAsTable(const Material& material, std::span<const GlassAlias> aliases) {
  std::vector<Row> rows = KeptRows(material);
  for (const GlassAlias& alias : aliases) {
    if (!IsAliasOf(alias, material)) continue;
    AddLines("also called", fmt::format("{}: {}", alias.name, alias.source), rows);
  }
  return Table(rows);
}

std::string OpticsAsTable(const OpticalValues& optics, const PrintedLight& light) {
  return fmt::format("At {:g} nm with a lens of NA {:g}:\n", light.wavelength_nm,
                     light.numerical_aperture) +
         Table({{"refractive index", fmt::format("{:.5f}", optics.refractive_index)},
                {"Abbe number", OrUnknown(optics.abbe_number, 2)},
                {"stage travel per mm in glass",
                 fmt::format("{:.5f} mm", optics.stage_per_glass_ratio)},
                {"cone's tangent in glass", fmt::format("{:.5f}", optics.cone_tangent)},
                {"reflected at the top face",
                 fmt::format("{:.2f} %", 100 * optics.reflectance_ratio)},
                {"thermal strength, heated locally",
                 KelvinText(optics.local_thermal_strength_k)},
                {"thermal strength, heated as a whole",
                 KelvinText(optics.thermal_strength_k)}}) +
         LightAsTable(optics);
}

std::string FocusAsTable(const PulseFocusRecord& focus) {
  const auto known = [](bool has, const std::string& text) {
    return has ? text : std::string("unknown");
  };
  const auto um = [&](bool has, double diameter_um) {
    return known(has, fmt::format("{:.0f} um", diameter_um));
  };
  return fmt::format("A pulse of {:g} mJ at the focus of lens {}:\n",
                     focus.pulse_energy_mj(), focus.lens()) +
         Table({{"spot, by the beam's divergence",
                 um(focus.has_spot_diameter_um(), focus.spot_diameter_um())},
                {"peak power", known(focus.has_peak_power_mw(),
                                     fmt::format("{:.2f} MW", focus.peak_power_mw()))},
                {"peak power over the spot",
                 known(focus.has_peak_irradiance_gw_cm2(),
                       fmt::format("{:.0f} GW/cm2", focus.peak_irradiance_gw_cm2()))},
                {"heat, by the melted volume of a crack",
                 known(focus.has_heated_ratio(),
                       fmt::format("{:.1f} % of the pulse", 100 * focus.heated_ratio()))},
                {"heated to the melting point",
                 um(focus.has_melted_diameter_um(), focus.melted_diameter_um())},
                {"heated to the thermal strength",
                 um(focus.has_strained_diameter_um(), focus.strained_diameter_um())},
                {"condition of a crack", CrackConditionText(focus)},
                {"a crack cools in",
                 known(focus.has_cooling_s(),
                       fmt::format("{:.2f} ms", 1e3 * focus.cooling_s()))},
                {fmt::format("the next point is warmer, at {:g} Hz", focus.rate_hz()),
                 known(focus.has_next_point_rise_k(),
                       fmt::format("{:.1f} K", focus.next_point_rise_k()))},
                {"a crack grows in",
                 known(focus.has_crack_growth_s(),
                       fmt::format("{:.0f} ns", 1e9 * focus.crack_growth_s()))}});
}

std::string GlassAsJson(const Material& material, const PrintedLight& light,
                        const std::optional<PulseFocusRecord>& focus) {
  std::string json = "{\"material\":" + Json(RecordOf(material));
  const auto optics = materials_db::ComputeOptics(material, light.wavelength_nm,
                                                  light.numerical_aperture);
  if (optics) {
    json += ",\"optics\":" +
            Json(RecordOf(*optics, light.wavelength_nm, light.numerical_aperture));
  }
  if (focus) json += ",\"focus\":" + Json(*focus);
  return json + "}";
}

}  // namespace intaglio::cli
