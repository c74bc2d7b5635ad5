#include "materials_db/material_store.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <optional>
#include <thread>

#include "tests/materials_db/test_glasses.h"
#include "tests/test_folder.h"

namespace intaglio::materials_db {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

MaterialStore InMemory() { return std::move(*MaterialStore::Open(":memory:")); }

std::vector<std::string> NamesOf(const MaterialStore& store) {
  std::vector<std::string> names;
  const auto materials = store.List();
  if (!materials) return names;
  for (const Material& material : *materials) names.push_back(material.name);
  return names;
}

TEST(MaterialStore, ComesWithFourSoundGlassesThatNameTheirSource) {
  const MaterialStore store = InMemory();
  EXPECT_THAT(NamesOf(store), ElementsAre("fused-silica", "H-K9L", "N-BK7", "soda-lime"));
  const auto glasses = store.List();
  ASSERT_TRUE(glasses);
  for (const Material& glass : *glasses) {
    EXPECT_THAT(CheckMaterial(glass), IsEmpty()) << glass.name;
    EXPECT_THAT(glass.source, HasSubstr("ispersion")) << glass.name;
  }
}

TEST(MaterialStore, GivesBackEveryValueAsItWasPutIn) {
  MaterialStore store = InMemory();
  ASSERT_TRUE(store.Add(CompleteGlass()));
  EXPECT_EQ(*store.Find("Test-1"), CompleteGlass());
}

TEST(MaterialStore, NamesAreTheSameInUpperAndLowerCase) {
  MaterialStore store = InMemory();
  EXPECT_EQ(store.Find("n-bk7")->name, "N-BK7");
  Material glass = CompleteGlass();
  glass.name = "h-k9l";
  EXPECT_FALSE(store.Add(glass));
  ASSERT_TRUE(store.Replace(glass));
  EXPECT_THAT(NamesOf(store), ElementsAre("fused-silica", "h-k9l", "N-BK7", "soda-lime"));
  EXPECT_TRUE(store.Remove("FUSED-SILICA"));
}

TEST(MaterialStore, AddRefusesAGlassThatIsThere) {
  MaterialStore store = InMemory();
  Material glass = CompleteGlass();
  glass.name = "N-BK7";
  const Status status = store.Add(glass);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kInvalidValue);
  EXPECT_THAT(status.error().message, HasSubstr("N-BK7"));
  EXPECT_EQ(store.Find("N-BK7")->manufacturer, "SCHOTT");
}

TEST(MaterialStore, ReportsWhichGlassWasMeant) {
  MaterialStore store = InMemory();
  const auto found = store.Find("BK7X");
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(found.error().message, HasSubstr("did you mean N-BK7?"))
      << "nearest is its other name, BK7";
  EXPECT_THAT(store.Find("K9X").error().message, HasSubstr("did you mean H-K9L?"));
  EXPECT_THAT(store.Remove("soda lime").error().message,
              HasSubstr("did you mean soda-lime?"));
  Material glass = CompleteGlass();
  glass.name = "N-BK8";
  EXPECT_THAT(store.Replace(glass).error().message, HasSubstr("did you mean N-BK7?"));
  EXPECT_THAT(store.Find("xyz").error().message, HasSubstr("materials list"));
}

TEST(MaterialStore, FindsAGlassByAnotherSpellingAndByItsAliases) {
  MaterialStore store = InMemory();
  for (const char* name : {"BK7", "bk7", "BK-7", "n bk7", "NBK7", "N-BK7HT"}) {
    const auto found = store.Find(name);
    ASSERT_TRUE(found) << name;
    EXPECT_EQ(found->name, "N-BK7") << name;
  }
  for (const char* name : {"K9", "k9l", "H-K9", "HK9L"}) {
    const auto found = store.Find(name);
    ASSERT_TRUE(found) << name;
    EXPECT_EQ(found->name, "H-K9L") << name;
  }
  EXPECT_EQ(store.Find("Fused Silica")->name, "fused-silica");
  EXPECT_EQ(store.Find("float glass")->name, "soda-lime");
}

TEST(MaterialStore, AGlassOfThatNameComesBeforeAnAlias) {
  MaterialStore store = InMemory();
  Material own = CompleteGlass();
  own.name = "BK7";
  ASSERT_TRUE(store.Add(own));
  EXPECT_EQ(*store.Find("bk7"), own);
  EXPECT_EQ(store.Find("bk-7")->name, "BK7") << "spelled like it";
  EXPECT_EQ(store.Find("N-BK7")->name, "N-BK7");
}

TEST(MaterialStore, AnAliasOfARemovedGlassFindsNothing) {
  MaterialStore store = InMemory();
  ASSERT_TRUE(store.Remove("H-K9L"));
  const auto found = store.Find("K9");
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kNotFound);
}

// What is stored under an alias would be another glass: only a search resolves them.
TEST(MaterialStore, ChangesNeedTheNameItself) {
  MaterialStore store = InMemory();
  EXPECT_FALSE(store.Remove("BK7"));
  EXPECT_TRUE(store.Find("N-BK7"));
}

TEST(MaterialStore, EveryAliasNamesItsGlassAndItsSource) {
  const MaterialStore store = InMemory();
  const auto aliases = store.Aliases();
  ASSERT_TRUE(aliases);
  EXPECT_GE(aliases->size(), 6u);
  for (const GlassAlias& alias : *aliases) {
    EXPECT_TRUE(store.Find(alias.glass)) << alias.name;
    EXPECT_FALSE(alias.source.empty()) << alias.name;
  }
}

TEST(MaterialStore, TakesNothingUnsound) {
  MaterialStore store = InMemory();
  Material glass = CompleteGlass();
  glass.density_kg_m3 = 2.5;
  glass.poisson_ratio = 2;
  const Status status = store.Add(glass);
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().message, HasSubstr("density_kg_m3"));
  EXPECT_THAT(status.error().message, HasSubstr("poisson_ratio"));
  EXPECT_FALSE(store.Find("Test-1"));
}

TEST(MaterialStore, ImportIsAllOrNothing) {
  MaterialStore store = InMemory();
  std::vector<Material> glasses(3, CompleteGlass());
  glasses[1].name = "N-BK7";
  glasses[2].name = "soda-lime";
  const Status status = store.Import(glasses, false);
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().message, HasSubstr("N-BK7, soda-lime"));
  EXPECT_FALSE(store.Find("Test-1"));
  ASSERT_TRUE(store.Import(glasses, true));
  EXPECT_EQ(*store.Find("N-BK7"), glasses[1]);
  EXPECT_EQ(store.List()->size(), 5u);
}

TEST(MaterialStore, NoTextIsTakenForSql) {
  MaterialStore store = InMemory();
  Material glass = CompleteGlass();
  glass.name = "x'); DROP TABLE material; --";
  ASSERT_TRUE(store.Add(glass));
  EXPECT_EQ(*store.Find(glass.name), glass);
  EXPECT_EQ(store.List()->size(), 5u);
}

TEST(MaterialStore, MakesItsFolder) {
  const fs::path file = test::FreshFolder() / "a/b/materials.db";
  ASSERT_TRUE(MaterialStore::Open(file));
  EXPECT_TRUE(fs::exists(file));
}

TEST(MaterialStore, RefusesWhatIsNoDatabase) {
  const fs::path folder = test::FreshFolder();
  const fs::path text = folder / "notes.txt";
  std::ofstream(text) << std::string(4096, 'x');
  const auto store = MaterialStore::Open(text);
  ASSERT_FALSE(store);
  EXPECT_EQ(store.error().code, ErrorCode::kUnreadable);
  EXPECT_THAT(store.error().message, HasSubstr("notes.txt"));
  EXPECT_EQ(test::ContentOf(text), std::string(4096, 'x'));
  // A folder, and a file in the place of a folder.
  EXPECT_EQ(MaterialStore::Open(folder).error().code, ErrorCode::kIo);
  EXPECT_EQ(MaterialStore::Open(text / "materials.db").error().code, ErrorCode::kIo);
}

TEST(MaterialStore, ADamagedDatabaseIsAnErrorNotACrash) {
  const fs::path file = test::FreshFolder() / "materials.db";
  ASSERT_TRUE(MaterialStore::Open(file));
  {
    std::fstream out(file, std::ios::in | std::ios::out | std::ios::binary);
    out.seekp(100);  // behind the file's header, the schema's page begins
    out << std::string(2000, '\xAA');
  }
  EXPECT_FALSE(MaterialStore::Open(file).and_then(
      [](const MaterialStore& store) { return store.List(); }));
}

TEST(MaterialStore, AFileThatMayNotBeWrittenCanBeRead) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write everything: run as another user";
  const fs::path folder = test::FreshFolder();
  const fs::path file = folder / "materials.db";
  ASSERT_TRUE(MaterialStore::Open(file));
  fs::permissions(file, fs::perms::owner_read);
  fs::permissions(folder, fs::perms::owner_read | fs::perms::owner_exec);
  {
    auto store = MaterialStore::Open(file);
    ASSERT_TRUE(store) << store.error().message;
    EXPECT_TRUE(store->Find("N-BK7"));
    const Status status = store->Add(CompleteGlass());
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, ErrorCode::kIo);
    EXPECT_EQ(MaterialStore::Open(folder / "new.db").error().code, ErrorCode::kIo);
  }
  fs::permissions(folder, fs::perms::owner_all);
}

// Several processes start with no base there: each opens the same new file.
TEST(MaterialStore, OpensAtOnceFromSeveralPlaces) {
  const fs::path file = test::FreshFolder() / "materials.db";
  constexpr int kCount = 4;
  std::vector<std::optional<Result<MaterialStore>>> stores(kCount);
  {
    std::vector<std::jthread> threads;
    threads.reserve(kCount);
    for (auto& store : stores) {
      threads.emplace_back([&store, &file] { store = MaterialStore::Open(file); });
    }
  }
  for (int i = 0; i < kCount; ++i) {
    auto& store = *stores[static_cast<std::size_t>(i)];
    ASSERT_TRUE(store) << store.error().message;
    Material glass = CompleteGlass();
    glass.name += std::to_string(i);
    EXPECT_TRUE(store->Add(glass));
  }
  for (auto& store : stores) EXPECT_EQ((*store)->List()->size(), 4u + kCount);
}

TEST(DefaultDatabasePath, FollowsTheEnvironment) {
  const auto set = [](const char* name, const char* value) {
    if (value == nullptr) {
      unsetenv(name);
    } else {
      setenv(name, value, 1);
    }
  };
  const auto value_of = [](const char* name) {
    const char* value = std::getenv(name);
    return value == nullptr ? std::nullopt : std::optional<std::string>(value);
  };
  const auto old_home = value_of("HOME");
  const auto old_base = value_of("INTAGLIO_MATERIALS_DB");
  set("HOME", "/home/anna");
  set("XDG_DATA_HOME", "/data");
  set("INTAGLIO_MATERIALS_DB", "/shop/glass.db");
  EXPECT_EQ(DefaultDatabasePath(), "/shop/glass.db");
  set("INTAGLIO_MATERIALS_DB", nullptr);
  EXPECT_EQ(DefaultDatabasePath(), "/data/intaglio/materials.db");
  set("XDG_DATA_HOME", "relative");  // must be ignored by its specification
  EXPECT_EQ(DefaultDatabasePath(), "/home/anna/.local/share/intaglio/materials.db");
  set("XDG_DATA_HOME", nullptr);
  set("HOME", nullptr);
  EXPECT_EQ(DefaultDatabasePath(), "/var/lib/intaglio/materials.db");
  set("HOME", old_home ? old_home->c_str() : nullptr);
  set("INTAGLIO_MATERIALS_DB", old_base ? old_base->c_str() : nullptr);
}

}  // namespace
}  // namespace intaglio::materials_db
