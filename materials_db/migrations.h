#pragma once

#include <span>

namespace intaglio::materials_db {

/// SQL that brings a database from version N - 1 to N; N is the place in the list, from
/// 1. The files are in materials_db/migrations/. One that was released never changes.
struct Migration {
  const char* name;  ///< e.g. "001_schema"
  const char* sql;
};

std::span<const Migration> Migrations();

}  // namespace intaglio::materials_db
