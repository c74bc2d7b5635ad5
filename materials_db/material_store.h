#pragma once

// The material base: glasses by name, in a SQLite file. A new one contains N-BK7, H-K9L,
// fused-silica and soda-lime. Several processes may use one file at once; one object
// belongs to one thread. Only a valid glass (CheckMaterial) can be stored.

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "materials_db/material.h"

namespace SQLite {
class Database;
}

namespace intaglio::materials_db {

/// The user's material base: $INTAGLIO_MATERIALS_DB, else
/// $XDG_DATA_HOME/intaglio/materials.db, else ~/.local/share/intaglio/materials.db, else
/// (no home, a system service) /var/lib/intaglio/materials.db.
std::filesystem::path DefaultDatabasePath();
/// The file that a person named; the user's where none was named.
std::filesystem::path DatabasePathOf(const std::string& named);

/// Another name of a glass with the same index.
struct GlassAlias {
  std::string name;
  std::string glass;   ///< in the material base, unless it was removed
  std::string source;  ///< why both are one glass for the optics
};

class MaterialStore {
 public:
  /// Makes the file and its folder when they are not there, and brings an older database
  /// to this version. ":memory:" is a base of its own that lives as long as the object.
  static Result<MaterialStore> Open(const std::filesystem::path& file);

  MaterialStore(MaterialStore&&) noexcept;
  MaterialStore& operator=(MaterialStore&&) noexcept;
  ~MaterialStore();

  /// All glasses, by name.
  Result<std::vector<Material>> List() const;

  /// By the name itself, else by one that differs only in hyphens and spaces, else by an
  /// alias: the glass found has its own name; else a glass of a known index
  /// (index_glass.h). kNotFound names glasses of similar name.
  Result<Material> Find(std::string_view name) const;

  /// All aliases, by name.
  Result<std::vector<GlassAlias>> Aliases() const;

  /// Refuses a name that is there (kInvalidValue).
  Status Add(const Material& material);

  /// Refuses a name that is not there (kNotFound).
  Status Replace(const Material& material);

  /// All of them or none. Names that are there, or twice in the list, are refused unless
  /// `replace`; the message names them all.
  Status Import(std::span<const Material> materials, bool replace);

  Status Remove(std::string_view name);

 private:
  MaterialStore(std::unique_ptr<SQLite::Database> database, std::filesystem::path file);

  /// Runs `action`, turning what SQLite throws into an error.
  template <typename F>
  auto Guarded(F action) const -> decltype(action());
  Error NotFound(std::string_view name) const;
  std::vector<std::string> Names() const;
  std::vector<GlassAlias> ReadAliases() const;
  /// The name in the base of a glass that is asked for in another way; empty: none.
  std::string NameOfAlias(std::string_view asked) const;
  bool Contains(std::string_view name) const;
  void Write(const Material& material);

  std::unique_ptr<SQLite::Database> database_;
  std::filesystem::path file_;
};

}  // namespace intaglio::materials_db
