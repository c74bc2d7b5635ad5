#include "services/client/preview/preview_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/client/preview/preview_text.h"

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
