#include "services/cli/materials/materials_command.h"

#include <gmock/gmock.h>
#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "materials_db/import_file.h"
#include "materials_db/material_store.h"
#include "proto/report.pb.h"
#include "tests/services/job/material_of_record.h"
#include "tests/test_folder.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

struct Outcome {
  int exit_code = -1;
  std::string out;
  std::string err;
};

/// Runs `intaglio materials WORDS` on the base in `folder`.
Outcome RunMaterials(const fs::path& folder, std::vector<std::string> words) {
  command_line::Program program("intaglio", "");
  AddMaterialsCommand(program.root());
  words.insert(words.begin(), "materials");
  words.insert(words.end(), {"--db", (folder / "materials.db").string()});
  Outcome outcome;
  if (const Status parsed = program.Parse(words); !parsed) {
    outcome.err = parsed.error().message;
    return outcome;
  }
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  outcome.exit_code = program.Run();
  outcome.out = testing::internal::GetCapturedStdout();
  outcome.err = testing::internal::GetCapturedStderr();
  return outcome;
}

fs::path WriteFile(const fs::path& file, std::string_view text) {
  std::ofstream(file) << text;
  return file;
}

constexpr char kCauchyRecord[] =
    "DATA:\n"
    "  - {type: formula 5, wavelength_range: 0.3 2, coefficients: 1.5 0.004 -2}\n";

const std::vector<std::string> kAddCrown = {
    "add",          "crown",         "--formula",    "schott",       "--coefficients",
    "2.2718929",    "-1.0108077e-2", "1.0592509e-2", "2.0816965e-4", "-7.6472538e-6",
    "4.9240991e-7", "--range",       "0.334",        "2.325",        "--density-kg-m3",
    "2510",         "--source",      "old catalog"};

TEST(MaterialsCommand, ListsTheGlasses) {
  const Outcome list = RunMaterials(test::FreshFolder(), {"list"});
  EXPECT_EQ(list.exit_code, 0);
  EXPECT_THAT(list.out, HasSubstr("N-BK7         SCHOTT        1.51947"));
  EXPECT_THAT(list.out, HasSubstr("n(532 nm)"));
  const Outcome infrared =
      RunMaterials(test::FreshFolder(), {"list", "--wavelength", "1064"});
  EXPECT_THAT(infrared.out, HasSubstr("1.50663"));
}

TEST(MaterialsCommand, ShowsAGlass) {
  const Outcome show = RunMaterials(
      test::FreshFolder(), {"show", "n-bk7", "--wavelength", "355", "--na", "0.2"});
  EXPECT_EQ(show.exit_code, 0);
  EXPECT_THAT(show.out, HasSubstr("1.53815"));
  EXPECT_THAT(show.out, HasSubstr("64.17"));
  EXPECT_THAT(show.out, HasSubstr("2510 kg/m3"));
  EXPECT_THAT(show.out, HasSubstr("SCHOTT data sheet"));
}

// The object's two members, read back as the messages of report.json.
JobReport AsReport(const std::string& json) {
  JobReport report;
  EXPECT_TRUE(google::protobuf::util::JsonStringToMessage(json, &report).ok()) << json;
  return report;
}

TEST(MaterialsCommand, ShowsAGlassToPrograms) {
  const fs::path folder = test::FreshFolder();
  const Outcome show = RunMaterials(
      folder, {"show", "n-bk7", "--wavelength", "355", "--na", "0.2", "--json"});
  EXPECT_EQ(show.exit_code, 0);
  const JobReport glass = AsReport(show.out);
  EXPECT_EQ(glass.material().name(), "N-BK7");
  EXPECT_EQ(glass.material().density_kg_m3(), 2510);
  EXPECT_EQ(glass.material().dispersion_coefficients_size(), 7);
  EXPECT_EQ(glass.optics().wavelength_nm(), 355);
  EXPECT_EQ(glass.optics().numerical_aperture(), 0.2);
  EXPECT_NEAR(glass.optics().refractive_index(), 1.53815, 5e-6) << "as the table has it";
  // Nothing is lost or rounded: what was read is what the base holds.
  const auto store = materials_db::MaterialStore::Open(folder / "materials.db");
  ASSERT_TRUE(store);
  EXPECT_EQ(MaterialOf(glass.material()), store->Find("N-BK7").value());
}

TEST(MaterialsCommand, ListsTheGlassesToPrograms) {
  const fs::path folder = test::FreshFolder();
  ASSERT_EQ(RunMaterials(folder, kAddCrown).exit_code, 0);
  // Beyond the range of the others; only fused silica goes so far.
  const Outcome list = RunMaterials(folder, {"list", "--wavelength", "5500", "--json"});
  EXPECT_EQ(list.exit_code, 0);
  google::protobuf::ListValue array;
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(list.out, &array).ok())
      << list.out;
  EXPECT_EQ(array.values_size(), 5);
  for (const auto& value : array.values()) {
    const auto& members = value.struct_value().fields();
    const std::string name =
        members.at("material").struct_value().fields().at("name").string_value();
    EXPECT_EQ(members.contains("optics"), name == "fused-silica") << name;
  }
}

TEST(MaterialsCommand, ShowsWhatIsKeptAlsoOutsideTheWavelengths) {
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{}, std::vector<std::string>{"--json"}}) {
    std::vector<std::string> words = {"show", "N-BK7", "--wavelength", "10600"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome show = RunMaterials(test::FreshFolder(), words);
    EXPECT_EQ(show.exit_code, 2);
    EXPECT_THAT(show.out, HasSubstr("2510"));
    EXPECT_THAT(show.err, HasSubstr("10600"));
  }
}

TEST(MaterialsCommand, ShowsAGlassByAnyOfItsNamesAndWhyItHasThem) {
  const fs::path folder = test::FreshFolder();
  const Outcome show = RunMaterials(folder, {"show", "K9"});
  EXPECT_EQ(show.exit_code, 0) << show.err;
  EXPECT_THAT(show.out, HasSubstr("H-K9L"));
  EXPECT_THAT(show.out, HasSubstr("also called"));
  EXPECT_THAT(show.out, HasSubstr("K9: Chinese trade name"));
  const Outcome list = RunMaterials(folder, {"list"});
  EXPECT_THAT(list.out, HasSubstr("ALSO CALLED"));
  EXPECT_THAT(list.out, HasSubstr("BK7, BK7HT, N-BK7HT"));
}

TEST(MaterialsCommand, ReportsWhatIsWrong) {
  const fs::path folder = test::FreshFolder();
  const Outcome unknown = RunMaterials(folder, {"show", "BK7X"});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("did you mean N-BK7?"));
  EXPECT_EQ(RunMaterials(folder, {"show", "N-BK7", "--wavelength", "10600"}).exit_code,
            2);
  EXPECT_EQ(RunMaterials(folder, {"show", "N-BK7", "--na", "1.5"}).exit_code, 2);
  EXPECT_EQ(RunMaterials(folder, {"remove", "none"}).exit_code, 2);
  EXPECT_EQ(RunMaterials(folder, {"replace", "N-BK7"}).exit_code, 2);
  EXPECT_EQ(RunMaterials(folder, {"import", (folder / "absent.yml").string()}).exit_code,
            2);
  EXPECT_EQ(RunMaterials(folder, {"import", "photo.png"}).exit_code, 2);
  EXPECT_THAT(RunMaterials(folder, {"add", "x"}).err, HasSubstr("required"));
}

TEST(MaterialsCommand, AddsReplacesAndRemoves) {
  const fs::path folder = test::FreshFolder();
  const Outcome add = RunMaterials(folder, kAddCrown);
  ASSERT_EQ(add.exit_code, 0) << add.err;
  EXPECT_EQ(RunMaterials(folder, kAddCrown).exit_code, 2);
  ASSERT_EQ(
      RunMaterials(folder, {"replace", "crown", "--poisson-ratio", "0.2"}).exit_code, 0);
  const auto store = materials_db::MaterialStore::Open(folder / "materials.db");
  const auto glass = store->Find("crown");
  ASSERT_TRUE(glass);
  EXPECT_EQ(glass->density_kg_m3, 2510);
  EXPECT_EQ(glass->poisson_ratio, 0.2);
  EXPECT_EQ(glass->source, "old catalog");
  EXPECT_THAT(glass->dispersion.coefficients, testing::SizeIs(6));
  EXPECT_EQ(RunMaterials(folder, {"remove", "CROWN"}).exit_code, 0);
  EXPECT_FALSE(store->Find("crown"));
}

TEST(MaterialsCommand, CoefficientsMayBeOneText) {
  const fs::path folder = test::FreshFolder();
  EXPECT_EQ(
      RunMaterials(folder, {"add", "c", "--formula", "rii_formula_5", "--coefficients",
                            "1.5 0.004 -2", "--range", "0.3", "2"})
          .exit_code,
      0);
  const Outcome wrong =
      RunMaterials(folder, {"add", "d", "--formula", "conrady", "--coefficients", "1.5 x",
                            "--range", "0.3", "2"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("--coefficients must be numbers"));
}

TEST(MaterialsCommand, ReplacesFromAFile) {
  const fs::path folder = test::FreshFolder();
  const auto file = WriteFile(folder / "melt.yml", kCauchyRecord);
  ASSERT_EQ(RunMaterials(
                folder, {"replace", "n-bk7", "--from", file.string(), "--source", "melt"})
                .exit_code,
            0);
  const auto glass =
      materials_db::MaterialStore::Open(folder / "materials.db")->Find("N-BK7");
  EXPECT_EQ(glass->name, "N-BK7");
  EXPECT_EQ(glass->source, "melt");
  EXPECT_FALSE(glass->density_kg_m3);
}

TEST(MaterialsCommand, ImportsUnderAName) {
  const fs::path folder = test::FreshFolder();
  const std::string file = WriteFile(folder / "melt.yml", kCauchyRecord).string();
  EXPECT_EQ(RunMaterials(folder, {"import", file}).out, "melt\n");
  EXPECT_EQ(RunMaterials(folder, {"import", file}).exit_code, 2);
  EXPECT_EQ(RunMaterials(folder, {"import", file, "--replace"}).exit_code, 0);
  EXPECT_EQ(RunMaterials(folder, {"import", file, "--as", "melt 4711"}).out,
            "melt 4711\n");
  const Outcome two = RunMaterials(folder, {"import", file, file, "--as", "one"});
  EXPECT_EQ(two.exit_code, 2);
  EXPECT_THAT(two.err, HasSubstr("--as is the name of one glass"));
}

TEST(MaterialsCommand, SkipsBadGlassesOnlyWhenAsked) {
  const fs::path folder = test::FreshFolder();
  const std::string file = WriteFile(folder / "half.agf",
                                     "NM good 5 0 0\nCD 1.5 0.01 0.001\nLD 0.4 0.7\n"
                                     "NM bad 5 0 0\nLD 0.4 0.7\n")
                               .string();
  const Outcome refused = RunMaterials(folder, {"import", file});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("line 4: glass bad: no CD"));
  EXPECT_THAT(refused.err, HasSubstr("--skip-bad"));
  EXPECT_EQ(RunMaterials(folder, {"show", "good"}).exit_code, 2);
  const Outcome skipped = RunMaterials(folder, {"import", file, "--skip-bad"});
  EXPECT_EQ(skipped.exit_code, 0);
  EXPECT_EQ(skipped.out, "good\n");
  EXPECT_THAT(skipped.err, HasSubstr("skipped: "));
}

TEST(MaterialsCommand, WhatIsExportedImportsAsEqual) {
  const fs::path folder = test::FreshFolder();
  ASSERT_EQ(RunMaterials(folder, kAddCrown).exit_code, 0);
  const fs::path file = folder / "all.yml";
  ASSERT_EQ(RunMaterials(folder, {"export", "--out", file.string()}).exit_code, 0);
  const auto store = materials_db::MaterialStore::Open(folder / "materials.db");
  EXPECT_EQ(materials_db::ImportFile(file).materials, *store->List());
  const Outcome one = RunMaterials(folder, {"export", "soda-lime"});
  EXPECT_EQ(one.exit_code, 0);
  EXPECT_THAT(one.out, HasSubstr("formula 5"));
  EXPECT_THAT(one.out, Not(HasSubstr("N-BK7")));
  EXPECT_EQ(RunMaterials(folder, {"export", "--out", (folder / "no/such.yml").string()})
                .exit_code,
            2);
}

}  // namespace
}  // namespace intaglio::cli
