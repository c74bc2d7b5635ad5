// The print of the virtual web, against its formula and against counting.

#include "services/virtual_engraver/head/printed_web.h"

#include <gtest/gtest.h>

#include <cmath>

namespace intaglio::virtual_engraver {
namespace {

/// All that passes until the web has moved so far, in steps of a tick.
std::vector<PrintedWeb::Passed> Passing(const PrintOptions& options, double until_mm) {
  PrintedWeb web(options);
  std::vector<PrintedWeb::Passed> passed;
  for (int step = 0; 0.01 * step <= until_mm; ++step) {
    while (const auto next = web.Next(0.01 * step)) {
      EXPECT_LE(next->place_mm, 0.01 * step);
      EXPECT_GT(next->place_mm, 0.01 * (step - 1) - 1e-9);
      passed.push_back(*next);
    }
  }
  return passed;
}

TEST(PrintedWeb, RepeatsItsMarksAtAStretchedPitch) {
  const auto passed = Passing({.pitch_mm = 30, .stretch_ratio = 0.01}, 200);
  ASSERT_EQ(passed.size(), 7u);
  for (std::size_t i = 0; i < passed.size(); ++i) {
    EXPECT_NEAR(passed[i].place_mm, 1.01 * 30 * (static_cast<double>(i) + 0.5), 1e-9);
    EXPECT_TRUE(passed[i].printed);
  }
}

// The pitch is that of the print times 1 + stretch + the ripple's mean over it.
TEST(PrintedWeb, RipplesAsItsStretchDoes) {
  const PrintOptions options{
      .pitch_mm = 1, .stretch_ratio = 0.02, .ripple_ratio = 0.1, .ripple_mm = 200};
  const PrintedWeb web(options);
  for (std::uint32_t i = 0; i < 400; ++i) {
    const double pitch_mm = web.PlaceOf(i + 1) - web.PlaceOf(i);
    EXPECT_NEAR(pitch_mm, 1.02 + 0.1 * std::sin(2 * M_PI * (i + 1) / 200), 1e-3) << i;
  }
}

TEST(PrintedWeb, LeavesOutMissingMarksAndShowsDirt) {
  const auto passed =
      Passing({.pitch_mm = 10, .missing = {2, 3}, .false_mm = {31, 8}}, 60);
  ASSERT_EQ(passed.size(), 6u);
  const double places[] = {5, 8, 15, 31, 45, 55};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(passed[i].place_mm, places[i]);
  EXPECT_FALSE(passed[1].printed);
  EXPECT_FALSE(passed[3].printed);
}

TEST(PrintedWeb, IsBlankWithoutAPitch) { EXPECT_TRUE(Passing({}, 1000).empty()); }

}  // namespace
}  // namespace intaglio::virtual_engraver
