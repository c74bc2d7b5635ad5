#include "materials_db/migrations.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "materials_db/material_store.h"
#include "tests/test_folder.h"

namespace intaglio::materials_db {
namespace {

namespace fs = std::filesystem;

SQLite::Database NewDatabase(const fs::path& file) {
  return SQLite::Database(file.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
}

std::string GoldenSql() {
  return test::ContentOf(fs::path(INTAGLIO_SOURCE_DIR) /
                         "tests/materials_db/golden/version_1.sql");
}

/// The SQL of its tables as SQLite reports it.
std::string SchemaOf(SQLite::Database& database) {
  SQLite::Statement query(database, "SELECT sql FROM sqlite_master WHERE sql NOT NULL");
  std::string schema;
  while (query.executeStep()) schema += query.getColumn(0).getString() + "\n";
  return schema;
}

TEST(Migrations, TheFirstIsWhatItWasWhenItWasReleased) {
  SQLite::Database golden = NewDatabase(":memory:");
  golden.exec(GoldenSql());
  SQLite::Database now = NewDatabase(":memory:");
  now.exec(Migrations()[0].sql);
  EXPECT_EQ(SchemaOf(now), SchemaOf(golden));
}

TEST(Migrations, AnOldDatabaseIsBroughtUpAndKeepsItsGlasses) {
  const fs::path file = test::FreshFolder() / "old.db";
  NewDatabase(file).exec(GoldenSql());
  const auto store = MaterialStore::Open(file);
  ASSERT_TRUE(store) << store.error().message;
  const auto own = store->Find("our-crown");
  ASSERT_TRUE(own);
  EXPECT_EQ(own->source, "measured in 2019");
  EXPECT_EQ(own->density_kg_m3, 2511.5);
  EXPECT_FALSE(own->poisson_ratio);
  // The classic coefficients of BK7: n_d = 1.51680 (SCHOTT catalog, 5 digits).
  EXPECT_NEAR(ComputeOptics(*own, 587.5618, 0.1)->refractive_index, 1.5168, 1e-5);
  EXPECT_EQ(store->Find("N-BK7")->source, "melt 4711");
  EXPECT_TRUE(store->Find("N-BK7")->transmittance.empty());
  EXPECT_TRUE(store->Find("soda-lime"));
  EXPECT_EQ(store->List()->size(), 5u);
}

TEST(Migrations, AGlassThatWasRemovedStaysAway) {
  const fs::path file = test::FreshFolder() / "materials.db";
  {
    auto store = MaterialStore::Open(file);
    ASSERT_TRUE(store && store->Remove("N-BK7"));
  }
  EXPECT_FALSE(MaterialStore::Open(file)->Find("N-BK7"));
}

TEST(Migrations, ANewerDatabaseIsRefusedAndLeftAsItIs) {
  const fs::path file = test::FreshFolder() / "newer.db";
  ASSERT_TRUE(MaterialStore::Open(file));
  NewDatabase(file).exec("PRAGMA user_version = 99");
  const std::string before = test::ContentOf(file);
  const auto store = MaterialStore::Open(file);
  ASSERT_FALSE(store);
  EXPECT_EQ(store.error().code, ErrorCode::kUnsupported);
  EXPECT_NE(store.error().message.find("version 99"), std::string::npos);
  EXPECT_EQ(test::ContentOf(file), before);
}

TEST(Migrations, AnotherProgramsDatabaseIsRefusedAndLeftAsItIs) {
  const fs::path file = test::FreshFolder() / "jobs.db";
  NewDatabase(file).exec("CREATE TABLE job (name TEXT)");
  const std::string before = test::ContentOf(file);
  const auto store = MaterialStore::Open(file);
  ASSERT_FALSE(store);
  EXPECT_EQ(store.error().code, ErrorCode::kUnreadable);
  EXPECT_EQ(test::ContentOf(file), before);
}

TEST(Migrations, GlassesOfBeforeHaveNoTransmittanceAndMayGetOne) {
  const fs::path file = test::FreshFolder() / "old.db";
  NewDatabase(file).exec(GoldenSql());
  auto store = MaterialStore::Open(file);
  ASSERT_TRUE(store) << store.error().message;
  Material own = *store->Find("our-crown");
  EXPECT_TRUE(own.transmittance.empty());
  EXPECT_FALSE(own.knoop_hardness_hk);
  EXPECT_FALSE(own.brittleness_per_sqrt_um);
  own.transmittance = {{0.5, 0.99, 10}, {0.6, 0.995, 25}};
  own.bending_strength_mpa = 55;
  own.impact_strength_kj_m2 = 1.9;
  ASSERT_TRUE(store->Replace(own));
  EXPECT_EQ(*store->Find("our-crown"), own);
}

}  // namespace
}  // namespace intaglio::materials_db
