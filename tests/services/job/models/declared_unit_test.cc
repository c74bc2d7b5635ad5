// The unit that a file declares, and that of the job in its place.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <optional>

#include "engrave/io/whole_file.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/convert/model_kind.h"
#include "services/job/models/model_sources.h"
#include "tests/services/job/test_job.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

using ::testing::Contains;
using ::testing::Field;
using ::testing::HasSubstr;

class DeclaredUnit : public testing::Test {
 protected:
  /// A line of one unit, of a file whose $INSUNITS is `declared`.
  JobSources SourcesOf(const std::string& declared, std::optional<double> unit_mm) {
    const std::string file = name_ + ".dxf";
    std::ofstream(file) << "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n"
                        << declared
                        << "\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n0\nLINE\n10\n0\n"
                           "20\n0\n11\n1\n21\n0\n0\nENDSEC\n0\nEOF\n";
    return SourcesOfFile(file, unit_mm);
  }
  JobSources SourcesOfFile(const std::string& file, std::optional<double> unit_mm) {
    JobSpec job = GoodJob();
    job.mutable_models(0)->Clear();
    job.mutable_models(0)->set_file(file);
    if (unit_mm) job.mutable_models(0)->mutable_placement()->set_unit_mm(*unit_mm);
    const JobSpec whole = WithDefaults(job, GoodMachine());
    const std::string text = io::ReadWholeFile(file, 1 << 20).value();
    const auto view = std::as_bytes(std::span(text));
    std::vector<FileBytes> bytes(FilesOf(whole).size(), {view.begin(), view.end()});
    auto made = MakeSources(whole, std::move(bytes), {}, {});
    if (made) return std::move(*made);
    ADD_FAILURE() << made.error().message;
    return {};
  }
  static double LengthOf(const JobSources& made) {
    return made.sources.empty() ? 0 : made.sources.front()->Bounds().size_mm().x();
  }

  const std::string name_ = (test::FreshFolder() / "declared_unit").string();
};

TEST_F(DeclaredUnit, OfADrawingIsAppliedOnce) {
  EXPECT_NEAR(LengthOf(SourcesOf("1", {})), 25.4, 1e-6);
  EXPECT_NEAR(LengthOf(SourcesOf("0", {})), 1, 1e-6);
  EXPECT_NEAR(LengthOf(SourcesOf("0", 7)), 7, 1e-6);
}

TEST_F(DeclaredUnit, IsReplacedByThatOfTheJobWithANote) {
  const JobSources made = SourcesOf("1", 7);
  EXPECT_NEAR(LengthOf(made), 7, 1e-6) << "and not 177.8";
  EXPECT_THAT(made.warnings, Contains(Field(&Warning::text, HasSubstr("$INSUNITS"))));
  EXPECT_NEAR(LengthOf(SourcesOf("1", 1)), 1, 1e-6);
}

// One law for every reader: what the format defines is replaced, and not multiplied.
TEST_F(DeclaredUnit, OfAPageOrAPlotterIsReplacedToo) {
  const std::string svg = name_ + ".svg", plot = name_ + ".plt";
  std::ofstream(svg) << "<svg xmlns='http://www.w3.org/2000/svg' width='20mm' "
                        "height='20mm' viewBox='0 0 10 10'>"
                        "<path d='M1 1h4' stroke='red'/></svg>";
  std::ofstream(plot) << "IN;PU0,0;PD80,0;PU;";
  EXPECT_NEAR(LengthOf(SourcesOfFile(svg, {})), 8, 1e-6);
  EXPECT_NEAR(LengthOf(SourcesOfFile(svg, 3)), 12, 1e-6);
  EXPECT_NEAR(LengthOf(SourcesOfFile(plot, {})), 2, 1e-6);
  EXPECT_NEAR(LengthOf(SourcesOfFile(plot, 0.3)), 24, 1e-6);
  for (const std::string& file : {svg, plot}) {
    EXPECT_THAT(SourcesOfFile(file, 0.3).warnings,
                Contains(Field(&Warning::text, HasSubstr("0.3 mm as asked for"))))
        << file;
  }
  EXPECT_NEAR(SourcesOfFile(svg, {}).units_mm.at(0), 2, 1e-9);
  EXPECT_NEAR(SourcesOfFile(plot, {}).units_mm.at(0), 0.025, 1e-9);
  EXPECT_NEAR(SourcesOf("1", {}).units_mm.at(0), 25.4, 1e-9);
}

TEST_F(DeclaredUnit, OfToolPathsIsAMillimetreOrThatOfTheJob) {
  const std::string path = name_ + ".nci";
  std::ofstream(path) << "0\n0 0 0 0 -2 0\n1\n0 2 0 0 9 0\n1003\n\n";
  EXPECT_NEAR(LengthOf(SourcesOfFile(path, {})), 2, 1e-6);
  EXPECT_NEAR(LengthOf(SourcesOfFile(path, 25.4)), 50.8, 1e-6);
  EXPECT_NEAR(SourcesOfFile(path, 25.4).units_mm.at(0), 25.4, 1e-9);
}

TEST_F(DeclaredUnit, ThatIsUnknownNeedsTheOneOfTheJob) {
  EXPECT_NEAR(LengthOf(SourcesOf("25", 7)), 7, 1e-6);
}

}  // namespace
}  // namespace intaglio
