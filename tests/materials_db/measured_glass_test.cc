// The glasses that come with the base and the published records, against the index that
// refractiveindex.info shows for them.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "engrave/optics/absorption.h"
#include "materials_db/import_file.h"
#include "materials_db/material_store.h"

namespace intaglio::materials_db {
namespace {

namespace fs = std::filesystem;

struct PublishedIndex {
  const char* name;
  const char* record;  ///< below the folder of glasses
  double n_355nm;
  double n_532nm;
  double n_1064nm;
};

constexpr PublishedIndex kPublished[] = {
    {"N-BK7", "specs/schott/optical/N-BK7.yml", 1.53815, 1.51947, 1.50663},
    {"H-K9L", "specs/cdgm/optical/H-K9L.yml", 1.53818, 1.51947, 1.50669},
    {"fused-silica", "main/SiO2/nk/Malitson.yml", 1.47607, 1.46071, 1.44963},
};

// The published values are rounded to five digits.
constexpr double kTolerance = 1e-5;

void ExpectPublished(const Material& glass, const PublishedIndex& published) {
  const auto n = [&](double wavelength_nm) {
    return ComputeOptics(glass, wavelength_nm, 0.1)->refractive_index;
  };
  EXPECT_NEAR(n(355), published.n_355nm, kTolerance) << published.name;
  EXPECT_NEAR(n(532), published.n_532nm, kTolerance) << published.name;
  EXPECT_NEAR(n(1064), published.n_1064nm, kTolerance) << published.name;
}

fs::path GlassFolder() { return fs::path(INTAGLIO_SOURCE_DIR) / "tests/data/glass"; }

TEST(MeasuredGlass, SeedsHaveThePublishedIndex) {
  const auto store = MaterialStore::Open(":memory:");
  ASSERT_TRUE(store);
  for (const PublishedIndex& published : kPublished) {
    const auto glass = store->Find(published.name);
    ASSERT_TRUE(glass) << published.name;
    ExpectPublished(*glass, published);
  }
}

TEST(MeasuredGlass, RecordsHaveThePublishedIndexAndAreWhatTheSeedsState) {
  const auto store = MaterialStore::Open(":memory:");
  ASSERT_TRUE(store);
  for (const PublishedIndex& published : kPublished) {
    const Imported imported = ImportFile(GlassFolder() / published.record);
    ASSERT_TRUE(imported.errors.empty()) << imported.errors.front().message;
    ASSERT_EQ(imported.materials.size(), 1u);
    const Material& glass = imported.materials.front();
    ExpectPublished(glass, published);
    const auto seed = store->Find(published.name);
    EXPECT_EQ(glass.dispersion, seed->dispersion) << published.name;
    EXPECT_EQ(glass.density_kg_m3.value_or(*seed->density_kg_m3), seed->density_kg_m3);
    EXPECT_EQ(glass.expansion_per_k.value_or(*seed->expansion_per_k),
              seed->expansion_per_k);
  }
}

struct Extinction {
  double wavelength_um = 0, k = 0;
};

/// The rows behind "tabulated k" of a record.
std::vector<Extinction> ExtinctionsOf(const fs::path& record) {
  std::ifstream file(record);
  std::vector<Extinction> rows;
  bool in_table = false;
  for (std::string line; std::getline(file, line);) {
    std::istringstream numbers(line);
    if (line.find("tabulated k") != std::string::npos) in_table = true;
    if (Extinction row; in_table && numbers >> row.wavelength_um >> row.k)
      rows.push_back(row);
  }
  return rows;
}

// The absorption coefficient is 4 pi k over the wavelength.
TEST(MeasuredGlass, SeedsAbsorbWhatTheRecordsState) {
  const auto store = MaterialStore::Open(":memory:");
  ASSERT_TRUE(store);
  for (const auto& [name, record] :
       {std::pair("N-BK7", "specs/schott/optical/N-BK7.yml"),
        std::pair("H-K9L", "specs/cdgm/optical/H-K9L.yml"),
        std::pair("soda-lime", "glass/misc/soda-lime/nk/Rubin-clear.yml")}) {
    const auto glass = store->Find(name);
    ASSERT_TRUE(glass) << name;
    int count = 0;
    for (const Extinction& row : ExtinctionsOf(GlassFolder() / record)) {
      if (row.wavelength_um < 0.34 || row.wavelength_um > 1.2) continue;
      ++count;
      const auto per_mm =
          optics::AbsorptionPerMm(glass->transmittance, 1000 * row.wavelength_um);
      ASSERT_TRUE(per_mm) << name << " " << row.wavelength_um;
      const double expected = 4 * std::numbers::pi * row.k / (row.wavelength_um / 1000);
      // The record has five digits, the seed three or five of the ratio.
      EXPECT_NEAR(*per_mm, expected, 1e-6 + 0.003 * expected)
          << name << " " << row.wavelength_um;
    }
    EXPECT_GT(count, 10) << name;
    // R + A + T of a block of 100 mm at 532 nm: R of both faces and what comes back.
    const OpticalValues values = *ComputeOptics(*glass, 532, 0.1);
    ASSERT_TRUE(values.absorption_per_mm) << name;
    const auto shares =
        optics::SharesOfLight(values.reflectance_ratio, *values.absorption_per_mm, 100);
    EXPECT_NEAR(shares.reflected + shares.absorbed + shares.transmitted, 1, 1e-12);
    EXPECT_GT(shares.absorbed, 0.01) << name;
  }
  // The source of fused silica has no transmittance.
  EXPECT_TRUE(store->Find("fused-silica")->transmittance.empty());
}

TEST(MeasuredGlass, EveryRecordIsRead) {
  int record_count = 0;
  for (const auto& entry : fs::recursive_directory_iterator(GlassFolder())) {
    if (entry.path().extension() != ".yml") continue;
    ++record_count;
    const Imported imported = ImportFile(entry.path());
    ASSERT_TRUE(imported.errors.empty()) << imported.errors.front().message;
    ASSERT_EQ(imported.materials.size(), 1u);
    const Material& glass = imported.materials.front();
    EXPECT_EQ(glass.name, entry.path().stem().string());
    EXPECT_FALSE(glass.source.empty());
    EXPECT_EQ(glass.source.find("</"), std::string::npos) << glass.source;
  }
  EXPECT_GE(record_count, 7);
}

// H. G. Pfaender, Schott Guide to Glass, 1996: n_d of soda-lime glass is 1.51 to 1.53.
TEST(MeasuredGlass, SodaLimeIsAWindowGlass) {
  const auto store = MaterialStore::Open(":memory:");
  const auto values = ComputeOptics(*store->Find("soda-lime"), 587.5618, 0.1);
  ASSERT_TRUE(values);
  EXPECT_NEAR(values->refractive_index, 1.52, 0.01);
  // 41 MPa * 0.77 / (8.3e-6 / K * 72 GPa)
  EXPECT_NEAR(*values->thermal_strength_k, 52.8, 0.05);
}

}  // namespace
}  // namespace intaglio::materials_db
