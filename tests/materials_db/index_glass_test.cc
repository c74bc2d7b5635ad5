#include "materials_db/index_glass.h"

#include <gtest/gtest.h>

#include "materials_db/material_store.h"

namespace intaglio::materials_db {
namespace {

TEST(IndexGlass, HasItsIndexAtEveryWavelengthAndNothingElse) {
  const auto store = MaterialStore::Open(":memory:");
  const auto glass = store->Find("n=1.52");
  ASSERT_TRUE(glass) << glass.error().message;
  EXPECT_EQ(glass->name, "n=1.52");
  EXPECT_TRUE(CheckMaterial(*glass).empty());
  for (const double wavelength_nm : {355.0, 532.0, 1064.0}) {
    const auto values = ComputeOptics(*glass, wavelength_nm, 0.1);
    ASSERT_TRUE(values) << values.error().message;
    EXPECT_DOUBLE_EQ(values->refractive_index, 1.52);
    EXPECT_FALSE(values->thermal_strength_k);
  }
  EXPECT_EQ(store->Find(NameOfIndexGlass(1.5168))->dispersion.coefficients.front(),
            1.5168);
}

TEST(IndexGlass, RefusesWhatIsNoIndexAndLeavesOtherNames) {
  const auto store = MaterialStore::Open(":memory:");
  for (const char* name : {"n=0.9", "n=", "n=glass", "n=1.5 1.6", "n=4.1", "n=nan"}) {
    const auto glass = store->Find(name);
    ASSERT_FALSE(glass) << name;
    EXPECT_EQ(glass.error().code, ErrorCode::kInvalidValue) << name;
  }
  EXPECT_FALSE(IndexGlass("N-BK7"));
  EXPECT_FALSE(IndexGlass(""));
}

TEST(IndexGlass, AStoredGlassOfThatNameComesFirst) {
  auto store = MaterialStore::Open(":memory:");
  Material own = **IndexGlass("n=1.52");
  own.density_kg_m3 = 2500;
  ASSERT_TRUE(store->Add(own));
  EXPECT_EQ(store->Find("n=1.52")->density_kg_m3, 2500);
}

}  // namespace
}  // namespace intaglio::materials_db
