// Codes in glass: the points of the cloud, drawn as the cracks that they become, are read
// by libraries that share nothing with the one that makes codes.

#include "services/job/models/code_model.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "services/job/checks/job_check.h"
#include "tests/engrave/matrix_code/code_reader.h"
#include "tests/services/job/finding_matcher.h"
#include "tests/services/job/models/one_model.h"

namespace intaglio {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kSpacingMm = 0.1;

struct OneCode : OneModel {
  OneCode(MarkCodeKind kind, const std::string& text) {
    model.mutable_code()->set_kind(kind);
    model.mutable_code()->set_text(text);
    job.mutable_discretization()->set_min_spacing_mm(kSpacingMm);
  }
};

/// The section of the block through an upright code, as a camera in front of it sees it:
/// a crack is a disc a spacing wide, and a pixel, half as wide, has the mean of a square
/// of two spacings about it: it resolves no crack. Cracks are dark before a bright
/// ground; `bright_cracks`: the reverse.
mark::BurntPicture SectionOf(const PointList& points_mm, bool bright_cracks) {
  constexpr int kParts = 4, kBlurParts = 16;  // of a pixel, along each side
  constexpr double kPixelMm = kSpacingMm / 2, kPartMm = kPixelMm / kParts, kRimMm = 3,
                   kRadiusMm = kSpacingMm / 2;
  Box3 box;
  for (const Vec3& p : points_mm) box.Extend(p);
  const Vec3 size_mm = box.size_mm() + Vec3::Constant(2 * kRimMm);
  mark::BurntPicture picture;
  picture.width = static_cast<int>(size_mm.x() / kPixelMm);
  picture.height = static_cast<int>(size_mm.z() / kPixelMm);
  const int columns = kParts * picture.width, rows = kParts * picture.height;
  std::vector<bool> cracked(static_cast<std::size_t>(columns * rows));
  const int reach = static_cast<int>(std::ceil(kRadiusMm / kPartMm));
  for (const Vec3& p : points_mm) {
    const double x = (p.x() - box.min_mm.x() + kRimMm) / kPartMm;
    const double y = (box.max_mm.z() + kRimMm - p.z()) / kPartMm;
    for (int v = static_cast<int>(y) - reach; v <= static_cast<int>(y) + reach; ++v)
      for (int u = static_cast<int>(x) - reach; u <= static_cast<int>(x) + reach; ++u)
        if (std::hypot(u + 0.5 - x, v + 0.5 - y) * kPartMm <= kRadiusMm)
          cracked[static_cast<std::size_t>(v * columns + u)] = true;
  }
  for (int row = 0; row < picture.height; ++row) {
    for (int column = 0; column < picture.width; ++column) {
      int count = 0;
      const int left = kParts * column + (kParts - kBlurParts) / 2,
                top = kParts * row + (kParts - kBlurParts) / 2;
      for (int v = std::max(0, top); v < std::min(rows, top + kBlurParts); ++v)
        for (int u = std::max(0, left); u < std::min(columns, left + kBlurParts); ++u)
          count += cracked[static_cast<std::size_t>(v * columns + u)] ? 1 : 0;
      const int share = 255 * count / (kBlurParts * kBlurParts);
      picture.pixels.push_back(
          static_cast<std::uint8_t>(bright_cracks ? share : 255 - share));
    }
  }
  return picture;
}

TEST(CodeModel, AQrIsReadFromTheSectionOfTheBlock) {
  if (!matrix_code::CanReadQr()) GTEST_SKIP() << "zbar is not installed";
  const std::string text = "https://example.org/piece/17";
  OneCode one(MARK_CODE_KIND_QR, text);
  const auto made = one.Make({});
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_EQ(matrix_code::ReadQr(SectionOf(made->cloud.points_mm, false)), text);
  // On a dark ground the cracks are the bright modules, with a rim of them around.
  one.model.mutable_code()->set_invert(true);
  const auto inverted = one.Make({});
  ASSERT_TRUE(inverted) << inverted.error().message;
  EXPECT_EQ(matrix_code::ReadQr(SectionOf(inverted->cloud.points_mm, true)), text);
}

TEST(CodeModel, ADataMatrixIsReadFromTheSectionOfTheBlock) {
  if (!matrix_code::CanReadDataMatrix()) GTEST_SKIP() << "libdmtx is not installed";
  for (int i = 0; i < 10; ++i) {
    const std::string text = fmt::format("SN-{:05} {}", 7919 * i, std::string(i, 'x'));
    const auto made = OneCode(MARK_CODE_KIND_DATA_MATRIX, text).Make({});
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ(matrix_code::ReadDataMatrix(SectionOf(made->cloud.points_mm, false)), text);
  }
}

// A module is filled: as many points as spacings, and it stands upright in the middle.
TEST(CodeModel, IsUprightWithModulesAsLargeAsAsked) {
  OneCode one(MARK_CODE_KIND_DATA_MATRIX, "A");  // 10 x 10 modules
  one.model.mutable_code()->set_module_mm(1);
  const auto made = one.Make({});
  ASSERT_TRUE(made) << made.error().message;
  Box3 box;
  for (const Vec3& p : made->cloud.points_mm) box.Extend(p);
  // Cracks as wide as the spacing end where the modules do.
  EXPECT_NEAR(box.size_mm().x(), 10 - 0.785 * kSpacingMm, 1e-3);
  EXPECT_NEAR(box.size_mm().y(), 0, 1e-9);
  EXPECT_NEAR(box.size_mm().z(), 10 - 0.785 * kSpacingMm, 1e-3);
  const Vector3& block = one.job.block().size_mm();
  EXPECT_NEAR(box.center_mm().x(), block.x() / 2, 1e-9);
  // About half of the 100 modules are dark; a lattice of 0.1 mm has at most
  // 2 / sqrt(3) * 100 points in one, and thinning at the outlines takes some.
  const auto count = static_cast<double>(made->cloud.points_mm.size());
  EXPECT_GT(count, 50 * 60);
  EXPECT_LT(count, 70 * 116);
}

TEST(CodeModel, WhatCannotBeEncodedIsNamed) {
  const auto large = OneCode(MARK_CODE_KIND_DATA_MATRIX, std::string(4000, 'x')).Make({});
  ASSERT_FALSE(large);
  EXPECT_THAT(large.error().message, HasSubstr("code.text: "));
  OneCode one(MARK_CODE_KIND_QR, "A");
  EXPECT_THAT(CheckJob(one.job), IsEmpty());
  one.model.set_file("horse.stl");
  EXPECT_THAT(CheckJob(one.job).front().message, HasSubstr("models[0]"));
  one.model.clear_file();
  one.model.mutable_code()->set_text("{serial}");
  ASSERT_EQ(CheckJob(one.job).size(), 1u);
  EXPECT_THAT(CheckJob(one.job).front().message, HasSubstr("is not filled in"));
  one.model.mutable_code()->set_text("");
  EXPECT_THAT(CheckJob(one.job).front().message, HasSubstr("give the text to encode"));
  one.model.mutable_code()->set_text("\xFF");
  EXPECT_THAT(CheckJob(one.job).front().message,
              HasSubstr("code.text: the text is not UTF-8"));
}

TEST(CodeModel, AModuleHasRoomForThreeRowsOfPoints) {
  OneCode one(MARK_CODE_KIND_QR, "A");
  one.model.mutable_code()->set_module_mm(0.3);
  EXPECT_THAT(CheckAll(one.job, GoodMachine()), IsEmpty());
  if (matrix_code::CanReadQr()) {
    const auto made = one.Make({});
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ(matrix_code::ReadQr(SectionOf(made->cloud.points_mm, false)), "A");
  }
  one.model.mutable_code()->set_module_mm(0.2);
  const auto found = CheckAll(one.job, GoodMachine());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_THAT(found.front().message,
              HasSubstr("models[0].code.module_mm: 0.2 is below three times the minimum "
                        "spacing of 0.1 mm"));
  EXPECT_THAT(found.front().message, HasSubstr("give 0.3 or more"));
  one.model.mutable_placement()->set_fit_size_mm(40);
  EXPECT_THAT(CheckAll(one.job, GoodMachine()), IsEmpty());
}

}  // namespace
}  // namespace intaglio
