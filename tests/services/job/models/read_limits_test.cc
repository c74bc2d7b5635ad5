#include "services/job/models/read_limits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "engrave/core/check.h"
#include "engrave/image/grey_image.h"
#include "engrave/render/canvas.h"
#include "engrave/render/png_file.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/models/model_sources.h"
#include "tests/services/job/test_job.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

TEST(ReadLimits, OneIsWhatTheReadersHaveByThemselves) {
  const ReadLimits one = ReadLimitsTimes(1), untouched;
  EXPECT_EQ(one.max_file_bytes, untouched.max_file_bytes);
  EXPECT_EQ(one.meshes.max_triangles, mesh::ImportOptions().max_triangles);
  EXPECT_EQ(one.drawings.max_entities, drawing::DrawingLimits().max_entities);
  EXPECT_EQ(one.images.max_pixels, image::ImageLimits().max_pixels);
  EXPECT_EQ(one.points.max_points, formats::PointFileLimits().max_points);
  EXPECT_EQ(ReadLimitsTimes(4).images.max_pixels, 400'000'000u);
  EXPECT_THROW(ReadLimitsTimes(0), PreconditionError);
  EXPECT_THROW(ReadLimitsTimes(std::nan("")), PreconditionError);
}

/// A file of each kind that is sound, and too large for a thousandth of the limits.
struct Sample {
  std::string name, text;
};

std::string Lines(int count, const std::string& line) {
  std::string text;
  for (int i = 0; i < count; ++i) text += line;
  return text;
}

std::string LargePicture() {
  const fs::path file = test::FreshFolder() / "large.png";
  EXPECT_TRUE(render::WritePng(file, render::Canvas(400, 300)));
  return test::ContentOf(file);
}

std::vector<Sample> Samples() {
  return {{"cloud.xyz", Lines(20'001, "1 2 3\n")},
          {"cloud.ply",
           "ply\nformat ascii 1.0\nelement vertex 20001\nproperty double x\n"
           "property double y\nproperty double z\nend_header\n" +
               Lines(20'001, "1 2 3\n")},
          {"mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 1\n" + Lines(10'001, "f 1 2 3\n")},
          {"drawing.svg", "<svg xmlns=\"http://www.w3.org/2000/svg\">" +
                              Lines(501, "<path d=\"M0 0L9 9\"/>") + "</svg>"},
          {"drawing.plt", "IN;" + Lines(3'001, "PU0,0;PD900,900;")},
          {"drawing.nci", Lines(3'001, "0\n0 0 0 0 -2 0\n1\n0 9 9 0 1 0\n")},
          {"picture.png", LargePicture()}};
}

Status Read(const Sample& sample, const ReadLimits& limits) {
  JobSpec job = GoodJob();
  Model& model = *job.mutable_models(0);
  model.Clear();
  model.set_file(sample.name);
  const auto bytes = std::as_bytes(std::span(sample.text));
  const auto made = MakeSources(WithDefaults(job, GoodMachine()),
                                {FileBytes(bytes.begin(), bytes.end())}, limits, {});
  if (!made) return tl::unexpected(made.error());
  return {};
}

TEST(ReadLimits, HoldForEveryKindOfFileAndReportHowTheyAreRaised) {
  for (const Sample& sample : Samples()) {
    const Status read = Read(sample, {});
    EXPECT_TRUE(read) << sample.name << ": " << read.error().message;
    const Status refused = Read(sample, ReadLimitsTimes(0.001));
    ASSERT_FALSE(refused) << sample.name;
    EXPECT_EQ(refused.error().code, ErrorCode::kTooLarge) << refused.error().message;
    EXPECT_THAT(refused.error().message, HasSubstr(sample.name));
    EXPECT_THAT(refused.error().message, HasSubstr("--size-limits FACTOR"));
    EXPECT_THAT(refused.error().message, HasSubstr("now 0.001"));
  }
}

TEST(ReadLimits, HoldForAFileThatIsReadHere) {
  const fs::path file = test::FreshFolder() / "large.xyz";
  std::ofstream(file).close();
  fs::resize_file(file, 1'100'000);
  JobSpec job = GoodJob();
  job.mutable_models(0)->set_file(file.string());
  EXPECT_TRUE(ReadFilesOf(job, {}));
  const auto refused = ReadFilesOf(job, ReadLimitsTimes(0.001));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("--size-limits"));
}

}  // namespace
}  // namespace intaglio
