#include "materials_db/material_store.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <utility>

#include "engrave/core/try.h"
#include "materials_db/index_glass.h"
#include "materials_db/near_names.h"
#include "materials_db/numbers.h"
#include "materials_db/open_database.h"

namespace intaglio::materials_db {
namespace {

/// The columns in the order of Bind and ReadRow.
std::string Columns() {
  std::string columns =
      "name, manufacturer, source, dispersion_formula, dispersion_coefficients, "
      "min_wavelength_um, max_wavelength_um";
  for (const PropertyRow& row : PropertyRows()) columns += fmt::format(", {}", row.name);
  return columns + ", transmittance";
}

constexpr int kFirstProperty = 7;
constexpr std::size_t kMaxSuggestions = 3;

void Bind(SQLite::Statement& statement, const Material& material) {
  const optics::Dispersion& dispersion = material.dispersion;
  statement.bind(1, material.name);
  statement.bind(2, material.manufacturer);
  statement.bind(3, material.source);
  statement.bind(4, optics::DispersionFormulaName(dispersion.formula));
  statement.bind(5, FormatNumbers(dispersion.coefficients));
  statement.bind(6, dispersion.min_wavelength_um);
  statement.bind(7, dispersion.max_wavelength_um);
  int index = kFirstProperty + 1;
  for (const PropertyRow& row : PropertyRows()) {
    const std::optional<double>& value = material.*row.value;
    if (value) {
      statement.bind(index, *value);
    } else {
      statement.bind(index);
    }
    ++index;
  }
  statement.bind(index, FormatNumbers(NumbersOf(material.transmittance)));
}

Result<Material> ReadRow(SQLite::Statement& statement) {
  Material material;
  material.name = statement.getColumn(0).getString();
  material.manufacturer = statement.getColumn(1).getString();
  material.source = statement.getColumn(2).getString();
  const std::string formula = statement.getColumn(3).getString();
  const std::string coefficients = statement.getColumn(4).getString();
  const auto known = optics::DispersionFormulaFromName(formula);
  const auto numbers = ParseNumbers(coefficients);
  if (!known || !numbers) {
    return Fail(ErrorCode::kUnreadable,
                fmt::format("glass {} of the material base has a damaged dispersion; "
                            "replace or remove it",
                            material.name),
                known ? coefficients : formula);
  }
  material.dispersion = {.formula = *known,
                         .coefficients = *numbers,
                         .min_wavelength_um = statement.getColumn(5).getDouble(),
                         .max_wavelength_um = statement.getColumn(6).getDouble()};
  int index = kFirstProperty;
  for (const PropertyRow& row : PropertyRows()) {
    const SQLite::Column column = statement.getColumn(index++);
    if (!column.isNull()) material.*row.value = column.getDouble();
  }
  const std::string transmittance = statement.getColumn(index).getString();
  auto table = TransmittanceIn(transmittance);
  if (!table) {
    return Fail(ErrorCode::kUnreadable,
                fmt::format("glass {} of the material base has a damaged transmittance; "
                            "replace or remove it",
                            material.name),
                transmittance);
  }
  material.transmittance = std::move(*table);
  return material;
}

/// All mistakes of all materials as one error.
Status CheckAll(std::span<const Material> materials) {
  Error all;
  for (const Material& material : materials) {
    for (const Error& error : CheckMaterial(material)) {
      if (all.message.empty()) {
        all = Error{error.code, "", error.value};
      } else {
        all.message += '\n';
      }
      all.message += fmt::format("glass {}: {}", material.name, error.message);
    }
  }
  if (all.message.empty()) return {};
  return tl::unexpected(std::move(all));
}

std::filesystem::path PathFrom(const char* variable) {
  const char* value = std::getenv(variable);
  return value == nullptr ? "" : value;
}

}  // namespace

std::filesystem::path DefaultDatabasePath() {
  constexpr auto kFile = "intaglio/materials.db";
  if (auto file = PathFrom("INTAGLIO_MATERIALS_DB"); !file.empty()) return file;
  // The XDG base directory specification: a relative path must be ignored.
  if (const auto xdg = PathFrom("XDG_DATA_HOME"); xdg.is_absolute()) return xdg / kFile;
  if (const auto home = PathFrom("HOME"); !home.empty()) {
    return home / ".local/share" / kFile;
  }
  return std::filesystem::path("/var/lib") / kFile;
}

std::filesystem::path DatabasePathOf(const std::string& named) {
  return named.empty() ? DefaultDatabasePath() : std::filesystem::path(named);
}

MaterialStore::MaterialStore(std::unique_ptr<SQLite::Database> database,
                             std::filesystem::path file)
    : database_(std::move(database)), file_(std::move(file)) {}
MaterialStore::MaterialStore(MaterialStore&&) noexcept = default;
MaterialStore& MaterialStore::operator=(MaterialStore&&) noexcept = default;
MaterialStore::~MaterialStore() = default;

Result<MaterialStore> MaterialStore::Open(const std::filesystem::path& file) {
  auto database = INTAGLIO_TRY(OpenDatabase(file));
  return MaterialStore(std::move(database), file);
}

template <typename F>
auto MaterialStore::Guarded(F action) const -> decltype(action()) {
  try {
    return action();
  } catch (const SQLite::Exception& exception) {
    return tl::unexpected(ErrorFrom(exception, file_));
  }
}

Result<std::vector<Material>> MaterialStore::List() const {
  return Guarded([&]() -> Result<std::vector<Material>> {
    SQLite::Statement query(
        *database_, fmt::format("SELECT {} FROM material ORDER BY name", Columns()));
    std::vector<Material> materials;
    while (query.executeStep()) {
      auto material = INTAGLIO_TRY(ReadRow(query));
      materials.push_back(std::move(material));
    }
    return materials;
  });
}

Result<Material> MaterialStore::Find(std::string_view name) const {
  return Guarded([&]() -> Result<Material> {
    SQLite::Statement query(
        *database_, fmt::format("SELECT {} FROM material WHERE name = ?", Columns()));
    query.bind(1, std::string(name));
    if (query.executeStep()) return ReadRow(query);
    query.reset();
    query.bind(1, NameOfAlias(name));
    if (query.executeStep()) return ReadRow(query);
    if (auto glass = IndexGlass(name)) return std::move(*glass);
    return tl::unexpected(NotFound(name));
  });
}

Result<std::vector<GlassAlias>> MaterialStore::Aliases() const {
  return Guarded([&]() -> Result<std::vector<GlassAlias>> { return ReadAliases(); });
}

Status MaterialStore::Add(const Material& material) {
  return Import({&material, 1}, false);
}

Status MaterialStore::Replace(const Material& material) {
  INTAGLIO_TRY(CheckAll({&material, 1}));
  return Guarded([&]() -> Status {
    SQLite::Transaction transaction(*database_, SQLite::TransactionBehavior::IMMEDIATE);
    if (!Contains(material.name)) return tl::unexpected(NotFound(material.name));
    Write(material);
    transaction.commit();
    return {};
  });
}

Status MaterialStore::Import(std::span<const Material> materials, bool replace) {
  INTAGLIO_TRY(CheckAll(materials));
  return Guarded([&]() -> Status {
    SQLite::Transaction transaction(*database_, SQLite::TransactionBehavior::IMMEDIATE);
    std::string taken;
    for (const Material& material : materials) {
      if (!replace && Contains(material.name)) {
        taken += (taken.empty() ? "" : ", ") + material.name;
      } else {
        Write(material);
      }
    }
    if (!taken.empty()) {
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("{} is already in the material base; replace or remove it, "
                              "or choose another name",
                              taken),
                  taken);
    }
    transaction.commit();
    return {};
  });
}

Status MaterialStore::Remove(std::string_view name) {
  return Guarded([&]() -> Status {
    SQLite::Statement statement(*database_, "DELETE FROM material WHERE name = ?");
    statement.bind(1, std::string(name));
    if (statement.exec() == 0) return tl::unexpected(NotFound(name));
    return {};
  });
}

bool MaterialStore::Contains(std::string_view name) const {
  SQLite::Statement query(*database_, "SELECT 1 FROM material WHERE name = ?");
  query.bind(1, std::string(name));
  return query.executeStep();
}

void MaterialStore::Write(const Material& material) {
  std::string marks = "?";
  for (int i = 0; i < kFirstProperty + static_cast<int>(PropertyRows().size()); ++i) {
    marks += ", ?";
  }
  SQLite::Statement statement(
      *database_,
      fmt::format("INSERT OR REPLACE INTO material ({}) VALUES ({})", Columns(), marks));
  Bind(statement, material);
  statement.exec();
}

std::vector<std::string> MaterialStore::Names() const {
  SQLite::Statement query(*database_, "SELECT name FROM material ORDER BY name");
  std::vector<std::string> names;
  while (query.executeStep()) names.push_back(query.getColumn(0).getString());
  return names;
}

std::vector<GlassAlias> MaterialStore::ReadAliases() const {
  SQLite::Statement query(*database_,
                          "SELECT name, material, source FROM alias ORDER BY name");
  std::vector<GlassAlias> aliases;
  while (query.executeStep()) {
    aliases.push_back({query.getColumn(0).getString(), query.getColumn(1).getString(),
                       query.getColumn(2).getString()});
  }
  return aliases;
}

std::string MaterialStore::NameOfAlias(std::string_view asked) const {
  const std::string spelling = SpellingOf(asked);
  std::vector<std::string> alike;
  for (std::string& name : Names()) {
    if (SpellingOf(name) == spelling) alike.push_back(std::move(name));
  }
  if (alike.size() == 1) return alike.front();
  if (!alike.empty()) return "";  // which of them?
  for (const GlassAlias& alias : ReadAliases()) {
    if (SpellingOf(alias.name) == spelling) return alias.glass;
  }
  return "";
}

Error MaterialStore::NotFound(std::string_view name) const {
  std::vector<std::string> names = Names();
  // A name that is nearer to an alias was meant as that.
  std::map<std::string, std::string> glass_of;
  for (const GlassAlias& alias : ReadAliases()) {
    if (!Contains(alias.glass)) continue;
    names.push_back(alias.name);
    glass_of.emplace(alias.name, alias.glass);
  }
  std::vector<std::string> near;
  for (const std::string& found : NearNames(name, names, names.size())) {
    const auto alias = glass_of.find(found);
    const std::string& glass = alias == glass_of.end() ? found : alias->second;
    if (std::find(near.begin(), near.end(), glass) != near.end()) continue;
    if (near.size() < kMaxSuggestions) near.push_back(glass);
  }
  return {ErrorCode::kNotFound,
          near.empty() ? fmt::format("there is no glass \"{}\" in the material base; "
                                     "`intaglio materials list` lists the glasses",
                                     name)
                       : fmt::format("there is no glass \"{}\" in the material base; did "
                                     "you mean {}?",
                                     name, fmt::join(near, " or ")),
          std::string(name)};
}

}  // namespace intaglio::materials_db
