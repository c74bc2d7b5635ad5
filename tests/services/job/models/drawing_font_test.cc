// The font of the texts in a DXF. The block of the sample job is 50 x 50 x 30 mm.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "engrave/drawing/font_list.h"
#include "engrave/io/whole_file.h"
#include "services/job/checks/job_check.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/convert/model_kind.h"
#include "services/job/models/model_sources.h"
#include "services/job/models/text_model.h"
#include "tests/services/job/test_job.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string DxfOf(const std::string& entities) {
  return "0\nSECTION\n2\nENTITIES\n" + entities + "0\nENDSEC\n0\nEOF\n";
}
const std::string kLine = "0\nLINE\n10\n0\n20\n0\n11\n20\n21\n0\n";
const std::string kName = "0\n TEXT\r\n10\n2\n20\n2\n40\n5\n1\nAnna\n";

class DrawingFont : public testing::Test {
 protected:
  void SetUp() override {
    if (!drawing::FindFontFile("DejaVu Sans"))
      GTEST_SKIP() << "no DejaVu Sans: install the package fonts-dejavu-core";
  }
  JobSpec JobWith(const std::string& entities) {
    std::ofstream(file_) << DxfOf(entities);
    JobSpec job = GoodJob();
    job.mutable_models(0)->Clear();
    job.mutable_models(0)->set_file(file_);
    return job;
  }
  static Result<JobSources> SourcesOf(const JobSpec& job) {
    const JobSpec whole = WithDefaults(job, GoodMachine());
    std::vector<FileBytes> bytes;
    for (const std::string& file : FilesOf(whole)) {
      const std::string text = io::ReadWholeFile(file, 1 << 24).value();
      const auto view = std::as_bytes(std::span(text));
      bytes.emplace_back(view.begin(), view.end());
    }
    return MakeSources(whole, std::move(bytes), {}, {});
  }
  static double HeightOf(const JobSources& made) {
    return made.sources.front()->Bounds().size_mm().z();
  }

  const std::string file_ = (test::FreshFolder() / "drawing_font.dxf").string();
};

TEST_F(DrawingFont, IsTheUsualOneAndTravelsWithTheJob) {
  JobSpec job = JobWith(kLine + kName);
  EXPECT_THAT(ResolveFonts(job), IsEmpty());
  const std::string font = drawing::FindFontFile("DejaVu Sans").value();
  EXPECT_EQ(job.models(0).text().font(), font);
  EXPECT_EQ(KindOf(job.models(0)), ModelKind::kDrawing);
  EXPECT_THAT(FilesOf(WithDefaults(job, GoodMachine())), ElementsAre(file_, font));
  const auto made = SourcesOf(job);
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_THAT(made->warnings, IsEmpty());
  EXPECT_NEAR(HeightOf(*made), 7, 0.2) << "2 mm above the line, capitals of 5 mm";
}

TEST_F(DrawingFont, IsThatOfTheModelAndNoneWithoutTexts) {
  JobSpec job = JobWith(kLine + kName);
  job.mutable_models(0)->mutable_text()->set_font("DejaVu Sans:Bold");
  EXPECT_THAT(ResolveFonts(job), IsEmpty());
  EXPECT_THAT(job.models(0).text().font(), HasSubstr("Bold"));
  JobSpec without = JobWith(kLine);
  EXPECT_THAT(ResolveFonts(without), IsEmpty());
  EXPECT_FALSE(without.models(0).has_text());
}

TEST_F(DrawingFont, WithoutOneTheTextIsLeftOutByName) {
  const auto made = SourcesOf(JobWith(kLine + kName));
  ASSERT_TRUE(made) << made.error().message;
  ASSERT_EQ(made->warnings.size(), 1u);
  EXPECT_THAT(made->warnings[0].text, HasSubstr("1 x TEXT"));
  EXPECT_NEAR(HeightOf(*made), 0, 1e-9);
}

TEST_F(DrawingFont, IsAllThatATextBesideAFileMayGive) {
  JobSpec job = JobWith(kLine + kName);
  job.mutable_models(0)->mutable_text()->set_height_mm(3);
  const auto messages = [&job] {
    std::string all;
    for (const Error& error : CheckJob(WithDefaults(job, GoodMachine()))) {
      all += error.message + "\n";
    }
    return all;
  };
  EXPECT_THAT(messages(), HasSubstr("keep text.font alone"));
  job.mutable_models(0)->mutable_text()->Clear();
  job.mutable_models(0)->set_file("plate.svg");
  EXPECT_THAT(messages(), HasSubstr("the font of the texts in a DXF"));
}

}  // namespace
}  // namespace intaglio
