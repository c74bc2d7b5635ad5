#include "services/client/preview/preview_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/client/preview/preview_text.h"
#include "services/client/preview/preview_view.h"

namespace intaglio::client {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

Preview Sample() {
  Preview preview;
  JobPreview& figures = preview.figures;
  figures.set_name("cup <1>");
  figures.set_verdict(kReadyWithWarnings);
  figures.set_point_count(16'179);
  figures.set_min_spacing_mm(0.2);
  figures.mutable_time()->set_machining_time_s(159);
  figures.mutable_time()->set_rate_hz(100);
  figures.mutable_time()->set_warm_up_s(30);
  figures.mutable_time()->set_planned_count(16'179);
  WarningRecord& warning = *figures.add_warnings();
  warning.set_weight("warning");
  warning.set_text("cup.stl: \"rays\" cross it & leave");
  preview.pictures.push_back({"preview.png", {'M', 'a', 'n', '!'}});
  return preview;
}

TEST(PreviewPage, HasEverythingInside) {
  const std::string page = PageOf(Sample());
  EXPECT_THAT(page,
              AllOf(HasSubstr("<!doctype html>"), HasSubstr("<h1>cup &lt;1&gt;</h1>"),
                    HasSubstr("READY, with warnings"),
                    HasSubstr("2 min 39 s at 100 Hz, after 30 s of lamp warm-up"),
                    HasSubstr("16 179"),
                    HasSubstr("cup.stl: &quot;rays&quot; cross it &amp; leave"),
                    HasSubstr("src=\"data:image/png;base64,TWFuIQ==\"")));
  // RFC 4648, 10: "Man!" is TWFuIQ==. Nothing is loaded, and nothing runs.
  EXPECT_THAT(page, AllOf(Not(HasSubstr("http")), Not(HasSubstr("<script"))));
  EXPECT_EQ(page, PageOf(Sample()));
}

/// The text between `begin` and the next quote.
std::string AttributeOf(const std::string& page, const std::string& begin) {
  const auto from = page.find(begin) + begin.size();
  return page.substr(from, page.find('"', from) - from);
}

// RFC 4648: six bits a letter.
std::vector<int> BytesOfBase64(const std::string& text) {
  const std::string letters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<int> bytes;
  int bits = 0, held = 0;
  for (const char c : text) {
    if (c == '=') break;
    held = (held << 6 | static_cast<int>(letters.find(c))) & 0xffff;
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes.push_back(held >> bits & 0xff);
  }
  return bytes;
}

// Places are true to a 65536th of the block; nothing is loaded.
TEST(PreviewPage, TurnsItsPointsInTheBrowser) {
  Preview preview = Sample();
  preview.figures.mutable_block_size_mm()->set_x(60);
  preview.figures.mutable_block_size_mm()->set_y(30);
  preview.figures.mutable_block_size_mm()->set_z(20);
  preview.points_mm = {{0, 15, 20}, {12.34, 5.6, 7.8}, {60, 30, 0}};
  const std::string page = PageOf(preview);
  EXPECT_EQ(AttributeOf(page, "data-block=\""), "60 30 20");
  const std::vector<int> bytes = BytesOfBase64(AttributeOf(page, "data-points=\""));
  ASSERT_EQ(bytes.size(), 18u);
  const Vec3 block_mm(60, 30, 20);
  for (std::size_t i = 0; i < 9; ++i) {
    const auto axis = static_cast<Eigen::Index>(i % 3);
    const double share = (bytes[2 * i] + 256 * bytes[2 * i + 1]) / 65535.0;
    EXPECT_NEAR(share * block_mm[axis], preview.points_mm[i / 3][axis],
                block_mm[axis] / 65535);
  }
  EXPECT_THAT(page, AllOf(HasSubstr("<script>"), Not(HasSubstr("http")),
                          Not(HasSubstr("import ")), Not(HasSubstr("fetch"))));
}

TEST(PreviewPage, OfALargeCloudHasAPart) {
  Preview preview = Sample();
  preview.figures.mutable_block_size_mm()->set_x(1);
  preview.figures.mutable_block_size_mm()->set_y(1);
  preview.figures.mutable_block_size_mm()->set_z(1);
  preview.points_mm.assign(2 * kShownPoints + 1, Vec3(0.5, 0.5, 0.5));
  const std::string points = AttributeOf(PageOf(preview), "data-points=\"");
  EXPECT_EQ(BytesOfBase64(points).size(), 6 * ((2 * kShownPoints + 3) / 3));
}

TEST(PreviewPage, ASampleIsCalledOne) {
  Preview preview = Sample();
  preview.figures.mutable_time()->set_planned_count(5000);
  EXPECT_THAT(PageOf(preview), AllOf(HasSubstr("about 2 min 39 s"),
                                     HasSubstr("from a sample of 5 000 points")));
}

TEST(PreviewPage, AGlassThatMayBreakIsMarked) {
  Preview preview = Sample();
  BreakagePreview& breakage = *preview.figures.mutable_breakage();
  breakage.set_crack_share_ratio(0.5);
  breakage.set_max_share_ratio(0.35);
  EXPECT_THAT(PageOf(preview), Not(HasSubstr("class=\"bad\"")));
  breakage.set_risky_count(12);
  EXPECT_THAT(PageOf(preview),
              HasSubstr("<td class=\"bad\">may break: cracks take 50 % of the densest "
                        "place, 35 % are sound; more at 12 points"));
}

TEST(PreviewPage, TextIsEscaped) {
  EXPECT_EQ(HtmlOf("<a b='\"'>&"), "&lt;a b=&#39;&quot;&#39;&gt;&amp;");
}

}  // namespace
}  // namespace intaglio::client
