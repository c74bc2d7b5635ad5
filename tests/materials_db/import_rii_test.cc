#include "materials_db/import_rii.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engrave/optics/dispersion_formulas.h"
#include "materials_db/export_rii.h"
#include "tests/materials_db/test_glasses.h"

namespace intaglio::materials_db {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr char kFlint[] = R"(# F2
REFERENCES: |
    <a href="https://x/y.agf">SCHOTT Zemax catalog 2017-01-20b</a> (obtained
    from <a href="https://www.schott.com">http://www.schott.com</a>)<br>See also more
COMMENTS: |
    lead containing glass type
DATA:
  - type: tabulated k
    data: |
        0.334 1.6542E-06
        0.350 2.7681E-07
  - type: formula 2
    wavelength_range: 0.32 2.5
    coefficients: 0 1.34533359 0.00997743871 0.209073176 0.0470450767 0.937357162 111.886764
PROPERTIES:
    nd: 1.62004
    density:
      - value: 3599
    thermal_expansion:
      - temperature_range: 293 573
        value: 9.2e-06
      - temperature_range: 243 343
        value: 8.2e-06
)";

/// A record with this entry in DATA and these lines at its end.
std::string Record(std::string_view entry, std::string_view end = "") {
  return fmt::format("DATA:\n  - {}\n{}", entry, end);
}

/// The only error's message.
std::string ErrorOf(std::string_view yaml) {
  const Imported imported = ImportRii(yaml, "glass");
  EXPECT_THAT(imported.materials, IsEmpty());
  EXPECT_THAT(imported.errors, SizeIs(1));
  return imported.errors.empty() ? "" : imported.errors.front().message;
}

TEST(ImportRii, ReadsARecord) {
  const Imported imported = ImportRii(kFlint, "F2");
  ASSERT_THAT(imported.errors, IsEmpty()) << imported.errors.front().message;
  ASSERT_THAT(imported.materials, SizeIs(1));
  const Material& glass = imported.materials.front();
  EXPECT_EQ(glass.name, "F2");
  EXPECT_EQ(glass.source,
            "SCHOTT Zemax catalog 2017-01-20b (obtained from http://www.schott.com)\n"
            "See also more\nlead containing glass type");
  EXPECT_EQ(glass.dispersion.formula, optics::DispersionFormula::kRiiSellmeier2);
  EXPECT_THAT(glass.dispersion.coefficients, SizeIs(7));
  EXPECT_EQ(glass.density_kg_m3, 3599);
  EXPECT_EQ(glass.expansion_per_k, 8.2e-6);  // -30..70 C, not 20..300 C
  EXPECT_FALSE(glass.youngs_modulus_gpa);
}

TEST(ImportRii, TakesTheFirstFormulaAndOldRecords) {
  const Imported imported = ImportRii(
      "DATA:\n  - {type: formula 5, range: 0.3 2, coefficients: 1.5 0.004 -2}\n"
      "  - {type: formula 1, range: 0.3 2, coefficients: 0 1 0.1}\n",
      "old");
  ASSERT_THAT(imported.materials, SizeIs(1));
  EXPECT_EQ(imported.materials[0].dispersion.formula,
            optics::DispersionFormula::kRiiCauchy);
}

TEST(ImportRii, NamesTheRemedyAboutTables) {
  const Imported imported =
      ImportRii(Record("{type: tabulated nk, data: 0.5 1.5 0}"), "glass");
  ASSERT_THAT(imported.errors, SizeIs(1));
  EXPECT_EQ(imported.errors[0].code, ErrorCode::kUnsupported);
  EXPECT_THAT(imported.errors[0].message, HasSubstr("materials add"));
}

TEST(ImportRii, NamesEachMistake) {
  EXPECT_THAT(ErrorOf("REFERENCES: none\n"), HasSubstr("no DATA"));
  EXPECT_THAT(ErrorOf("- a\n- b\n"), HasSubstr("no DATA"));
  EXPECT_THAT(ErrorOf("just words"), HasSubstr("no DATA"));
  EXPECT_THAT(ErrorOf(Record("{type: tabulated k}")), HasSubstr("formula N"));
  EXPECT_THAT(ErrorOf(""), HasSubstr("empty"));
  EXPECT_THAT(ErrorOf("DATA: [1, 2"), HasSubstr("not a YAML"));
  for (const char* type : {"formula 10", "formula x", "formula 0", "agf formula 14",
                           "formula 1.5", "my formula 2", "formula 99999999999"}) {
    EXPECT_THAT(ErrorOf(Record(fmt::format("{{type: {}}}", type))), HasSubstr("formula"))
        << type;
  }
  EXPECT_THAT(ErrorOf(Record("{type: formula 5, wavelength_range: 0.3, "
                             "coefficients: 1.5 0.004 -2}")),
              HasSubstr("wavelength_range"));
  EXPECT_THAT(ErrorOf(Record("{type: formula 5, wavelength_range: 0.3 2, "
                             "coefficients: 1.5 oops -2}")),
              HasSubstr("coefficients"));
}

TEST(ImportRii, ReportsAllMistakesOfARecord) {
  const Imported imported =
      ImportRii(Record("{type: formula 5, wavelength_range: zero, coefficients: many}",
                       "INTAGLIO: {poisson_ratio: high, melting_point_c: hot}\n"),
                "glass");
  EXPECT_THAT(imported.errors, SizeIs(4));
}

TEST(ImportRii, NoticesASlipInACoefficient) {
  std::string wrong = kFlint;
  wrong.replace(wrong.find("1.34533359"), 10, "1.43533359");
  EXPECT_THAT(ErrorOf(wrong), HasSubstr("nd of 1.62004"));
}

TEST(ImportRii, RefusesWhatIsTooLarge) {
  EXPECT_THAT(ErrorOf(std::string(kMaxRiiBytes + 1, ' ')), HasSubstr("more than"));
}

TEST(ImportRii, AnswersDeepNestingWithAnError) {
  ErrorOf(std::string(100000, '['));
  ErrorOf(std::string(100000, '{'));
  std::string dashes;
  for (int i = 0; i < 20000; ++i) dashes += "- ";
  ErrorOf(dashes);
}

TEST(ImportRii, ReadsSeveralDocuments) {
  const std::string one = Record("{type: formula 5, range: 0.3 2, coefficients: 1.5}");
  const Imported imported =
      ImportRii("# two\n---\n" + one + "--- # more\n" + one + "---\n", "glass");
  EXPECT_THAT(imported.errors, IsEmpty());
  EXPECT_THAT(imported.materials, SizeIs(2));
}

// The parser's LoadAll never returns from the first of them.
TEST(ImportRii, AnswersScrapsWithAnError) {
  for (const char* scrap :
       {",", "]", "}", ", ,", "- ,", "\t", "---\n,\n---\n,", "%", "&"}) {
    EXPECT_FALSE(ImportRii(scrap, "glass").errors.empty()) << scrap;
  }
}

TEST(ExportRii, ReadsBackAsEqual) {
  std::vector<Material> glasses(4, CompleteGlass());
  glasses[1].name = "null";
  glasses[1].manufacturer = "";
  glasses[1].source = "";
  static_cast<Properties&>(glasses[1]) = {};
  glasses[2].name = "~";
  glasses[2].source = "\n \ttabs,  spaces & <b>tags</b> &amp; ends \n";
  glasses[2].poisson_ratio.reset();
  glasses[3].name = "12e3: #, \"quoted\" 'glass' µ";
  const Imported imported = ImportRii(ExportRii(glasses), "unused");
  ASSERT_THAT(imported.errors, IsEmpty()) << imported.errors.front().message;
  EXPECT_EQ(imported.materials, glasses);
}

TEST(ExportRii, EveryFormulaReadsBackAsItself) {
  for (const optics::FormulaRow& row : optics::FormulaRows()) {
    Material glass = CompleteGlass();
    glass.dispersion.formula = row.formula;
    // Sound or not: only the way there and back matters here.
    glass.dispersion.coefficients.assign(row.min_count, 0.0);
    glass.dispersion.coefficients[0] = 2.25;
    const Imported imported = ImportRii(ExportRii({&glass, 1}), "");
    if (!CheckMaterial(glass).empty()) {
      EXPECT_FALSE(imported.errors.empty()) << row.name;
      continue;
    }
    ASSERT_THAT(imported.materials, SizeIs(1)) << row.name;
    EXPECT_EQ(imported.materials[0], glass) << row.name;
  }
}

TEST(ExportRii, NothingIsAnEmptyFile) {
  EXPECT_THAT(ImportRii(ExportRii({}), "").materials, IsEmpty());
}

}  // namespace
}  // namespace intaglio::materials_db
