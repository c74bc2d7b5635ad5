#include "services/job/models/mesh_models.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "engrave/io/whole_file.h"
#include "tests/services/job/models/one_model.h"

namespace intaglio {
namespace {

using ::testing::Contains;
using ::testing::Field;
using ::testing::HasSubstr;

const std::string kKinds = INTAGLIO_SOURCE_DIR "/tests/data/kinds/";

Warnings WarningsOfMaking(const JobSpec& job) {
  const JobSpec whole = WithDefaults(job, GoodMachine());
  const auto files = ReadFilesOf(whole, {});
  EXPECT_TRUE(files) << files.error().message;
  const auto made = MakeSources(whole, *files, {}, {});
  EXPECT_TRUE(made) << made.error().message;
  return made ? made->warnings : Warnings();
}

TEST(MeshModels, WhatTheReaderDidNotObeyIsAWarningOfTheJob) {
  OneModel one;
  one.model.set_file(kKinds + "skin.glb");
  const Warnings warnings = WarningsOfMaking(one.job);
  EXPECT_THAT(warnings,
              Contains(AllOf(Field(&Warning::code, WarningCode::kLeftOut),
                             Field(&Warning::weight, WarningWeight::kWarning),
                             Field(&Warning::text, HasSubstr("skin.glb: 1 x skin")))));
}

}  // namespace
}  // namespace intaglio
