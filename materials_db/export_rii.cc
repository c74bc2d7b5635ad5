#include "materials_db/export_rii.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "materials_db/html_text.h"
#include "materials_db/numbers.h"

namespace intaglio::materials_db {
namespace {

std::string FormulaType(optics::DispersionFormula formula) {
  using optics::DispersionFormula;
  constexpr int kFirstRii = static_cast<int>(DispersionFormula::kRiiSellmeier);
  const int place = static_cast<int>(formula);
  return place < kFirstRii ? fmt::format("agf formula {}", place + 1)
                           : fmt::format("formula {}", place - kFirstRii + 1);
}

/// Quoted always: a glass may be called "null" or "1e5".
void WriteText(YAML::Emitter& out, const char* key, const std::string& text) {
  out << YAML::Key << key << YAML::Value << YAML::DoubleQuoted << text;
}

void WriteNumber(YAML::Emitter& out, const char* key, double number) {
  out << YAML::Key << key << YAML::Value << FormatNumber(number);
}

void WriteDispersion(YAML::Emitter& out, const optics::Dispersion& dispersion) {
  out << YAML::Key << "DATA" << YAML::Value << YAML::BeginSeq << YAML::BeginMap;
  out << YAML::Key << "type" << YAML::Value << FormulaType(dispersion.formula);
  out << YAML::Key << "wavelength_range" << YAML::Value
      << FormatNumbers({dispersion.min_wavelength_um, dispersion.max_wavelength_um});
  out << YAML::Key << "coefficients" << YAML::Value
      << FormatNumbers(dispersion.coefficients);
  out << YAML::EndMap << YAML::EndSeq;
}

/// The format of the site's own records: a list of values.
void WriteProperty(YAML::Emitter& out, const char* key, std::optional<double> value) {
  if (!value) return;
  out << YAML::Key << key << YAML::Value << YAML::BeginSeq << YAML::BeginMap;
  WriteNumber(out, "value", *value);
  out << YAML::EndMap << YAML::EndSeq;
}

void WriteProperties(YAML::Emitter& out, const Material& material) {
  if (!material.density_kg_m3 && !material.expansion_per_k) return;
  out << YAML::Key << "PROPERTIES" << YAML::Value << YAML::BeginMap;
  WriteProperty(out, "density", material.density_kg_m3);
  WriteProperty(out, "thermal_expansion", material.expansion_per_k);
  out << YAML::EndMap;
}

void WriteOwn(YAML::Emitter& out, const Material& material) {
  out << YAML::Key << "INTAGLIO" << YAML::Value << YAML::BeginMap;
  WriteText(out, "name", material.name);
  if (!material.manufacturer.empty()) {
    WriteText(out, "manufacturer", material.manufacturer);
  }
  for (const PropertyRow& row : PropertyRows()) {
    if (row.value == &Properties::density_kg_m3) continue;
    if (row.value == &Properties::expansion_per_k) continue;
    const std::optional<double>& value = material.*row.value;
    if (value) WriteNumber(out, row.name, *value);
  }
  if (!material.transmittance.empty()) {
    out << YAML::Key << "transmittance" << YAML::Value
        << FormatNumbers(NumbersOf(material.transmittance));
  }
  out << YAML::EndMap;
}

}  // namespace

std::string ExportRii(std::span<const Material> materials) {
  YAML::Emitter out;
  for (const Material& material : materials) {
    out << YAML::BeginDoc << YAML::BeginMap;
    if (!material.source.empty()) {
      WriteText(out, "REFERENCES", HtmlFromText(material.source));
    }
    WriteDispersion(out, material.dispersion);
    WriteProperties(out, material);
    WriteOwn(out, material);
    out << YAML::EndMap;
  }
  return std::string(out.c_str()) + "\n";
}

}  // namespace intaglio::materials_db
