#include "materials_db/import_agf.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "engrave/io/number_text.h"
#include "engrave/optics/dispersion_formulas.h"
#include "materials_db/numbers.h"
#include "materials_db/utf8.h"

namespace intaglio::materials_db {
namespace {

using Tokens = std::vector<std::string_view>;

std::string UpperCase(std::string_view name) {
  std::string upper(name);
  for (char& c : upper) {
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  }
  return upper;
}

std::string_view Trimmed(std::string_view text) {
  const std::size_t start = text.find_first_not_of(" \t\r");
  if (start == std::string_view::npos) return {};
  return text.substr(start, text.find_last_not_of(" \t\r") - start + 1);
}

class CatalogReader {
 public:
  explicit CatalogReader(std::string_view catalog) : catalog_(catalog) {}

  Imported Read(std::string_view text) {
    while (!text.empty() && imported_.errors.size() < kMaxAgfErrors) {
      const std::size_t end = text.find('\n');
      ++line_;
      ReadLine(Trimmed(text.substr(0, end)));
      text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    }
    if (imported_.errors.size() < kMaxAgfErrors) FinishGlass();
    if (first_lines_.empty() && imported_.errors.empty()) {
      Complain(1, ErrorCode::kUnreadable,
               "it contains no glass (no NM line); check that it is an AGF catalog");
    } else if (imported_.errors.size() >= kMaxAgfErrors) {
      Complain(
          line_, ErrorCode::kUnreadable,
          "too many mistakes, the rest is not read; check that it is an AGF catalog");
    }
    return std::move(imported_);
  }

 private:
  void Complain(std::size_t line, ErrorCode code, const std::string& message,
                std::string_view value = {}) {
    imported_.errors.push_back(
        {code, fmt::format("line {}: {}", line, message), std::string(value)});
    is_sound_ = false;
  }

  void ReadLine(std::string_view line) {
    const std::string_view kind = line.substr(0, 2);
    const bool is_token = line.size() == 2 || (line.size() > 2 && line[2] == ' ') ||
                          (line.size() > 2 && line[2] == '\t');
    if (!is_token) return;
    const std::string_view rest = Trimmed(line.substr(2));
    if (kind == "CC") {
      comment_ = rest;
    } else if (kind == "NM") {
      FinishGlass();
      ReadName(SplitTokens(rest));
    } else if (kind == "GC") {
      if (InGlass(kind)) glass_comment_ = rest;
    } else if (kind == "ED") {
      if (InGlass(kind)) ReadExpansionAndDensity(SplitTokens(rest));
    } else if (kind == "MD") {
      if (InGlass(kind)) ReadMechanics(SplitTokens(rest));
    } else if (kind == "CD") {
      if (InGlass(kind)) ReadCoefficients(rest);
    } else if (kind == "LD") {
      if (InGlass(kind)) ReadRange(rest);
    } else if (kind == "IT") {
      if (InGlass(kind)) ReadTransmittance(SplitTokens(rest));
    }
  }

  bool InGlass(std::string_view kind) {
    if (in_glass_) return true;
    Complain(line_, ErrorCode::kUnreadable,
             fmt::format("{} occurs before the first NM line", kind), kind);
    return false;
  }

  void ReadName(const Tokens& words) {
    glass_ = Material();
    glass_comment_ = {};
    nd_.reset();
    in_glass_ = true;
    is_sound_ = true;
    has_coefficients_ = false;
    has_range_ = false;
    glass_line_ = line_;
    if (words.empty()) {
      Complain(line_, ErrorCode::kMissing, "NM has no name");
      return;
    }
    glass_.name = words[0];
    const auto [place, is_new] = first_lines_.emplace(UpperCase(words[0]), line_);
    if (!is_new) {
      Complain(line_, ErrorCode::kInvalidValue,
               fmt::format("glass {} is already in line {}", words[0], place->second),
               words[0]);
    }
    const auto number = words.size() > 1 ? io::ParseFinite(words[1]) : std::nullopt;
    if (!number || !(std::abs(*number) <= 999) || *number != std::floor(*number)) {
      Complain(line_, ErrorCode::kInvalidValue,
               fmt::format("glass {}: NM needs the formula's number after the name",
                           glass_.name),
               words.size() > 1 ? words[1] : "");
      return;
    }
    const auto formula = optics::DispersionFormulaFromAgf(static_cast<int>(*number));
    if (formula) {
      glass_.dispersion.formula = *formula;
    } else {
      Complain(line_, formula.error().code,
               fmt::format("glass {}: {}", glass_.name, formula.error().message),
               words[1]);
    }
    if (words.size() > 3) nd_ = io::ParseFinite(words[3]);
  }

  /// A value of the line times `factor`; unknown where there is none.
  std::optional<double> Value(const Tokens& words, std::size_t place, double factor) {
    if (place >= words.size() || words[place] == "-" || words[place] == "_") {
      return std::nullopt;
    }
    const auto number = io::ParseFinite(words[place]);
    if (!number) {
      Complain(line_, ErrorCode::kInvalidValue,
               fmt::format("glass {}: \"{}\" is not a number", glass_.name, words[place]),
               words[place]);
      return std::nullopt;
    }
    if (!(*number > 0)) return std::nullopt;
    return *number * factor;
  }

  void ReadExpansionAndDensity(const Tokens& words) {
    glass_.expansion_per_k = Value(words, 0, 1e-6);
    glass_.density_kg_m3 = Value(words, 2, 1000);
  }

  void ReadMechanics(const Tokens& words) {
    glass_.youngs_modulus_gpa = Value(words, 0, 1);
    glass_.poisson_ratio = Value(words, 1, 1);
    glass_.knoop_hardness_hk = Value(words, 2, 1);
    glass_.specific_heat_j_kg_k = Value(words, 3, 1000);
    glass_.conductivity_w_m_k = Value(words, 4, 1);
  }

  /// Wavelength in um, internal transmittance, thickness in mm. Catalogs leave out the
  /// numbers of wavelengths that were not measured.
  void ReadTransmittance(const Tokens& words) {
    if (words.size() < 3) return;
    std::array<double, 3> numbers{};
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      if (words[i] == "-" || words[i] == "_") return;
      const auto number = io::ParseFinite(words[i]);
      if (!number) {
        Complain(
            line_, ErrorCode::kInvalidValue,
            fmt::format("glass {}: IT must be a wavelength in um, the internal "
                        "transmittance and a thickness in mm, \"{}\" is not a number",
                        glass_.name, words[i]),
            words[i]);
        return;
      }
      numbers[i] = *number;
    }
    if (!(numbers[0] > 0 && numbers[1] >= 0 && numbers[2] > 0)) return;  // unknown
    glass_.transmittance.push_back({numbers[0], numbers[1], numbers[2]});
  }

  /// By ascending wavelength; of two entries of one wavelength, the longer way, which is
  /// measured more exactly.
  void SortTransmittance() {
    auto& table = glass_.transmittance;
    std::ranges::stable_sort(table, [](const auto& a, const auto& b) {
      return a.wavelength_um != b.wavelength_um ? a.wavelength_um < b.wavelength_um
                                                : a.thickness_mm > b.thickness_mm;
    });
    // Not std::ranges::unique: clang 14, which builds the fuzz targets, cannot.
    const auto repeated = std::unique(
        table.begin(), table.end(),
        [](const auto& a, const auto& b) { return a.wavelength_um == b.wavelength_um; });
    table.erase(repeated, table.end());
  }

  void ReadCoefficients(std::string_view rest) {
    const auto numbers = ParseNumbers(rest);
    if (!numbers) {
      Complain(line_, ErrorCode::kInvalidValue,
               fmt::format("glass {}: CD must be numbers", glass_.name), rest);
      return;
    }
    has_coefficients_ = true;
    glass_.dispersion.coefficients = *numbers;
  }

  void ReadRange(std::string_view rest) {
    const auto range = ParseNumbers(rest);
    if (!range || range->size() < 2) {
      Complain(line_, ErrorCode::kInvalidValue,
               fmt::format("glass {}: LD must be two wavelengths in um", glass_.name),
               rest);
      return;
    }
    has_range_ = true;
    glass_.dispersion.min_wavelength_um = (*range)[0];
    glass_.dispersion.max_wavelength_um = (*range)[1];
  }

  /// As many coefficients as the formula has: catalogs pad with zeros, or leave zeros
  /// out.
  void FitCoefficients() {
    auto& coefficients = glass_.dispersion.coefficients;
    const auto formula = static_cast<std::size_t>(glass_.dispersion.formula);
    const std::size_t count = optics::FormulaRows()[formula].max_count;
    while (coefficients.size() > count && coefficients.back() == 0) {
      coefficients.pop_back();
    }
    if (coefficients.size() < count) coefficients.resize(count, 0.0);
  }

  void FinishGlass() {
    if (!in_glass_) return;
    in_glass_ = false;
    if (is_sound_ && !has_coefficients_) ComplainOfGlass(ErrorCode::kMissing, "no CD");
    if (is_sound_ && !has_range_) ComplainOfGlass(ErrorCode::kMissing, "no LD");
    if (!is_sound_) return;
    FitCoefficients();
    SortTransmittance();
    glass_.manufacturer = catalog_;
    glass_.source = fmt::format("AGF catalog {}", catalog_);
    if (!comment_.empty()) glass_.source += fmt::format(": {}", comment_);
    if (!glass_comment_.empty()) glass_.source += fmt::format("\n{}", glass_comment_);
    for (const Error& error : CheckMaterial(glass_)) {
      ComplainOfGlass(error.code, error.message, error.value);
    }
    if (is_sound_ && nd_ && !AgreesWithIndex(glass_.dispersion, *nd_)) {
      ComplainOfGlass(ErrorCode::kInvalidValue,
                      fmt::format("the formula does not give the nd of {} in its NM "
                                  "line; check CD",
                                  *nd_),
                      FormatNumber(*nd_));
    }
    if (is_sound_) imported_.materials.push_back(std::move(glass_));
  }

  void ComplainOfGlass(ErrorCode code, std::string_view message,
                       std::string_view value = {}) {
    Complain(glass_line_, code, fmt::format("glass {}: {}", glass_.name, message), value);
  }

  std::string catalog_;
  Imported imported_;
  std::size_t line_ = 0;
  std::string comment_;
  std::map<std::string, std::size_t> first_lines_;  // of each name in upper case
  // The glass that is being read.
  Material glass_;
  std::string glass_comment_;
  std::optional<double> nd_;
  std::size_t glass_line_ = 0;
  bool in_glass_ = false;
  bool is_sound_ = false;
  bool has_coefficients_ = false;
  bool has_range_ = false;
};

}  // namespace

Imported ImportAgf(std::string_view bytes, std::string_view catalog) {
  if (bytes.size() > kMaxAgfBytes) {
    Imported refused;
    refused.errors.push_back(
        {ErrorCode::kTooLarge,
         fmt::format("the catalog has {} bytes, more than the {} allowed", bytes.size(),
                     kMaxAgfBytes),
         std::to_string(bytes.size())});
    return refused;
  }
  return CatalogReader(catalog).Read(ToUtf8(bytes));
}

}  // namespace intaglio::materials_db
