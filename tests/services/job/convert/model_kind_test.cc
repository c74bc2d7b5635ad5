#include "services/job/convert/model_kind.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/job/convert/job_defaults.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

Model ModelOf(const std::string& file) {
  Model model;
  model.set_file(file);
  return model;
}

TEST(ModelKind, FollowsFromTheEndingInAnyCase) {
  EXPECT_EQ(KindOf(ModelOf("a/horse.STL")), ModelKind::kMesh);
  EXPECT_EQ(KindOf(ModelOf("wrench.dxf")), ModelKind::kDrawing);
  EXPECT_EQ(KindOf(ModelOf("face.Jpg")), ModelKind::kImage);
  EXPECT_EQ(KindOf(ModelOf("points.scl")), ModelKind::kCloud);
  Model text;
  text.mutable_text()->set_text("Anna");
  EXPECT_EQ(KindOf(text), ModelKind::kText);
  const auto unknown = KindOf(ModelOf("letter.doc"));
  ASSERT_FALSE(unknown.has_value());
  EXPECT_EQ(unknown.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(unknown.error().message, HasSubstr(".stl"));
}

TEST(ModelKind, EveryKindHasAMethodByDefaultThatSuitsIt) {
  for (const char* file : {"a.stl", "a.svg", "a.png", "a.xyz"}) {
    JobSpec job = GoodJob();
    *job.mutable_models(0) = ModelOf(file);
    const Model model = WithDefaults(job, GoodMachine()).models(0);
    EXPECT_TRUE(Suits(model.method_case(), KindOf(model).value())) << file;
  }
  EXPECT_FALSE(Suits(Model::kHalftone, ModelKind::kMesh));
  EXPECT_FALSE(Suits(Model::kEven, ModelKind::kDrawing));
  EXPECT_FALSE(Suits(Model::kCurves, ModelKind::kCloud));
}

TEST(ModelKind, FilesAreNamedInTheOrderOfTheModels) {
  JobSpec job = GoodJob();
  *job.mutable_models(0) = ModelOf("a.stl");
  job.mutable_models(0)->mutable_even()->set_image("shade.png");
  *job.add_models() = ModelOf("depth.png");
  job.mutable_models(1)->mutable_relief()->set_photo("photo.jpg");
  Text& text = *job.add_models()->mutable_text();
  text.set_text("Anna");
  text.set_font("sans.ttf");
  EXPECT_THAT(FilesOf(job),
              ElementsAre("a.stl", "shade.png", "depth.png", "photo.jpg", "sans.ttf"));
  std::vector<std::string> fields;
  ForEachFile(job,
              [&](std::string&, const std::string& field) { fields.push_back(field); });
  EXPECT_THAT(fields,
              ElementsAre("models[0].file", "models[0].even.image", "models[1].file",
                          "models[1].relief.photo", "models[2].text.font"));
}

}  // namespace
}  // namespace intaglio
