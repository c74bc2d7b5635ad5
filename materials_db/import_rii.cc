#include "materials_db/import_rii.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engrave/io/number_text.h"
#include "materials_db/html_text.h"
#include "materials_db/numbers.h"

namespace intaglio::materials_db {
namespace {

constexpr double kRoomTemperatureK = 293.15;

/// The text of a scalar; none for anything else.
std::optional<std::string> TextOf(const YAML::Node& node) {
  if (!node.IsScalar()) return std::nullopt;
  return node.Scalar();
}

std::optional<double> NumberOf(const YAML::Node& node) {
  const auto text = TextOf(node);
  return text ? io::ParseFinite(*text) : std::nullopt;
}

/// A child of a map; null when there is none.
YAML::Node Child(const YAML::Node& parent, const char* key) {
  if (!parent.IsMap()) return {};
  const YAML::Node child = parent[key];
  return child.IsDefined() ? child : YAML::Node();
}

/// Reads one record; every mistake becomes an error.
class RecordReader {
 public:
  RecordReader(const YAML::Node& record, std::string_view name)
      : record_(record), own_(Child(record, "INTAGLIO")) {
    material_.name = TextOf(Child(own_, "name")).value_or(std::string(name));
  }

  void Read(Imported& imported) {
    material_.manufacturer = TextOf(Child(own_, "manufacturer")).value_or("");
    ReadSource();
    ReadDispersion();
    ReadProperties();
    if (errors_.empty()) {
      errors_ = CheckMaterial(material_);
      CheckIndex();
    }
    if (errors_.empty()) imported.materials.push_back(std::move(material_));
    for (Error& error : errors_) {
      if (!material_.name.empty()) {
        error.message = fmt::format("glass {}: {}", material_.name, error.message);
      }
      imported.errors.push_back(std::move(error));
    }
  }

 private:
  void Complain(ErrorCode code, std::string message, std::string value = {}) {
    errors_.push_back({code, std::move(message), std::move(value)});
  }

  void ReadSource() {
    for (const char* key : {"REFERENCES", "COMMENTS"}) {
      const auto html = TextOf(Child(record_, key));
      const std::string text = html ? TextFromHtml(*html) : "";
      if (text.empty()) continue;
      if (!material_.source.empty()) material_.source += '\n';
      material_.source += text;
    }
  }

  /// The first entry of DATA that is a formula; tabulated n and k are left aside.
  void ReadDispersion() {
    const YAML::Node entries = Child(record_, "DATA");
    if (!entries.IsSequence()) {
      Complain(
          ErrorCode::kMissing,
          "the record has no DATA; check that it is a record of refractiveindex.info");
      return;
    }
    bool has_table = false;
    for (const YAML::Node& entry : entries) {
      const std::string type = TextOf(Child(entry, "type")).value_or("");
      if (type.find("formula ") != std::string::npos) {
        ReadFormula(entry, type);
        return;
      }
      has_table = has_table || type.starts_with("tabulated n");
    }
    if (has_table) {
      Complain(ErrorCode::kUnsupported,
               "the record has a table and no formula; use a record of this glass that "
               "has a formula, or fit one and use `intaglio materials add`");
    } else {
      Complain(ErrorCode::kMissing, "DATA has no entry of a type \"formula N\"");
    }
  }

  void ReadFormula(const YAML::Node& entry, const std::string& type) {
    const bool is_agf = type.starts_with("agf formula ");
    const bool is_rii = type.starts_with("formula ");
    const auto number =
        io::ParseFinite(std::string_view(type).substr(type.rfind(' ') + 1));
    if (!(is_agf || is_rii) || !number || !(*number >= 1 && *number <= 99) ||
        *number != static_cast<int>(*number)) {
      Complain(ErrorCode::kUnsupported,
               fmt::format("DATA has the type \"{}\", which is unknown", type), type);
      return;
    }
    const auto formula =
        is_agf ? optics::DispersionFormulaFromAgf(static_cast<int>(*number))
               : optics::DispersionFormulaFromRii(static_cast<int>(*number));
    if (!formula) {
      errors_.push_back(formula.error());
      return;
    }
    material_.dispersion.formula = *formula;
    ReadRange(entry);
    const auto text = TextOf(Child(entry, "coefficients"));
    const auto coefficients = text ? ParseNumbers(*text) : std::nullopt;
    if (!coefficients) {
      Complain(ErrorCode::kInvalidValue,
               "coefficients must be numbers separated by spaces", text.value_or(""));
      return;
    }
    material_.dispersion.coefficients = *coefficients;
  }

  /// "wavelength_range" since 2021, "range" before.
  void ReadRange(const YAML::Node& entry) {
    auto text = TextOf(Child(entry, "wavelength_range"));
    if (!text) text = TextOf(Child(entry, "range"));
    const auto range = text ? ParseNumbers(*text) : std::nullopt;
    if (!range || range->size() != 2) {
      Complain(ErrorCode::kInvalidValue,
               "wavelength_range must be two wavelengths in um, e.g. 0.3 2.5",
               text.value_or(""));
      return;
    }
    material_.dispersion.min_wavelength_um = (*range)[0];
    material_.dispersion.max_wavelength_um = (*range)[1];
  }

  void ReadProperties() {
    const YAML::Node properties = Child(record_, "PROPERTIES");
    material_.density_kg_m3 = ValueNearRoom(Child(properties, "density"));
    material_.expansion_per_k = ValueNearRoom(Child(properties, "thermal_expansion"));
    for (const PropertyRow& row : PropertyRows()) {
      const YAML::Node value = Child(own_, row.name);
      if (value.IsNull()) continue;
      material_.*row.value = NumberOf(value);
      if (material_.*row.value) continue;
      Complain(ErrorCode::kInvalidValue, fmt::format("{} must be a number", row.name),
               TextOf(value).value_or(""));
    }
    ReadTransmittance();
  }

  void ReadTransmittance() {
    const YAML::Node value = Child(own_, "transmittance");
    if (value.IsNull()) return;
    const std::string text = TextOf(value).value_or("-");
    if (auto table = TransmittanceIn(text)) {
      material_.transmittance = std::move(*table);
    } else {
      Complain(ErrorCode::kInvalidValue,
               "transmittance must be a wavelength in um, a ratio and a thickness in mm "
               "for each entry",
               text);
    }
  }

  /// Chooses, of values in different ranges of temperature, the one whose range reaches
  /// room temperature and ends first: thermal expansion grows with the temperature.
  static std::optional<double> ValueNearRoom(const YAML::Node& node) {
    if (!node.IsSequence()) return NumberOf(node);
    std::optional<double> nearest;
    double nearest_end_k = 0;
    for (const YAML::Node& entry : node) {
      const auto value = NumberOf(Child(entry, "value"));
      if (!value) continue;
      const auto text = TextOf(Child(entry, "temperature_range"));
      const auto range_k = text ? ParseNumbers(*text) : std::nullopt;
      if (!range_k || range_k->size() != 2) {
        if (!nearest) nearest = value;
        continue;
      }
      const double end_k = (*range_k)[1];
      if (end_k < kRoomTemperatureK) continue;
      if (!nearest || end_k < nearest_end_k) {
        nearest = value;
        nearest_end_k = end_k;
      }
    }
    return nearest;
  }

  void CheckIndex() {
    const auto nd = NumberOf(Child(Child(record_, "PROPERTIES"), "nd"));
    if (!nd || !errors_.empty() || AgreesWithIndex(material_.dispersion, *nd)) return;
    Complain(ErrorCode::kInvalidValue,
             fmt::format("the formula does not give the record's nd of {}; check the "
                         "coefficients",
                         *nd),
             FormatNumber(*nd));
  }

  YAML::Node record_;
  YAML::Node own_;
  Material material_;
  std::vector<Error> errors_;
};

/// The documents of a file, each from its "---" on. YAML::LoadAll never returns for a
/// file that contains only a comma, so each document is loaded separately.
std::vector<std::string> Documents(std::string_view yaml) {
  std::vector<std::string> documents(1);
  while (!yaml.empty()) {
    const std::size_t end = yaml.find('\n');
    const std::string_view line =
        yaml.substr(0, end == std::string_view::npos ? yaml.size() : end + 1);
    const bool begins = line.starts_with("---") &&
                        (line.size() == 3 || line.find_first_of(" \t\r\n", 3) == 3);
    if (begins) documents.emplace_back();
    documents.back() += line;
    yaml.remove_prefix(line.size());
  }
  return documents;
}

}  // namespace

Imported ImportRii(std::string_view yaml, std::string_view name) {
  Imported imported;
  const auto refuse = [&](ErrorCode code, std::string message) {
    imported.errors.push_back({code, std::move(message), std::string(name)});
  };
  if (yaml.size() > kMaxRiiBytes) {
    refuse(ErrorCode::kTooLarge,
           fmt::format("the record has {} bytes, more than the {} allowed", yaml.size(),
                       kMaxRiiBytes));
    return imported;
  }
  try {
    for (const std::string& document : Documents(yaml)) {
      const YAML::Node record = YAML::Load(document);
      if (record.IsNull()) continue;
      RecordReader(record, name).Read(imported);
    }
  } catch (const YAML::Exception& exception) {
    imported.materials.clear();
    refuse(ErrorCode::kUnreadable,
           fmt::format("this is not a YAML record: {}", exception.what()));
  }
  if (imported.materials.empty() && imported.errors.empty()) {
    refuse(ErrorCode::kMissing, "the file is empty");
  }
  return imported;
}

}  // namespace intaglio::materials_db
