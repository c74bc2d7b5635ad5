#include "tests/integration/grbl_shop.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "tests/integration/course/flashes.h"

namespace intaglio::testing {

std::string GrblShop::Mesh(const std::filesystem::path& file, double height_mm,
                           double spacing_mm) {
  return fmt::format(
      "models {{ file: \"{}\" placement {{ rotate_deg {{ x: 90 }} fit_height_mm: {} }} "
      "}}\n"
      "discretization {{ min_spacing_mm: {} }}\n",
      file.string(), height_mm, spacing_mm);
}

GrblShop::GrblShop(const Options& options)
    : PointShop({.controller = "grbl",
                 .profile = "grbl",
                 .more_of_motion_line = "serial_number: \"G-03\"",
                 .line = options.tcp ? "tcp:127.0.0.1:0" : "",
                 .controller_options = options.hal ? std::vector<std::string>{"--hal"}
                                                   : std::vector<std::string>{},
                 .job = options.job +
                        "laser { photosensor_feedback: false rate_hz: 100 }\n"}) {}

std::size_t GrblShop::Flashes() const {
  std::ifstream lines(record());
  std::size_t count = 0;
  for (std::string line; std::getline(lines, line);) count += line.starts_with("flash");
  return count;
}

GrblJudgement GrblShop::Judge() const {
  GrblJudgement judgement;
  const Points job = PointsOfJob();
  EXPECT_FALSE(job.at_mm.empty());
  const FlashRecord record = ReadFlashes(this->record());
  judgement.lit_at_rest_us = record.lit_at_rest_us;
  const PointList &points = job.at_mm, &flashes = record.began_mm;
  const HeightFit fit = FitHeight(points, flashes);
  judgement.points = points.size();
  std::vector<int> count(points.size(), 0);
  for (const Vec3& flash : flashes) {
    double nearest_mm = 1e9;
    std::size_t nearest = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double off_mm = (fit.AxesAt(points[i]) - flash).cwiseAbs().maxCoeff();
      if (off_mm < nearest_mm) nearest_mm = off_mm, nearest = i;
    }
    judgement.farthest_mm = std::max(judgement.farthest_mm, nearest_mm);
    judgement.stray += nearest_mm > 0.05;
    ++count[nearest];
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool uncertain = job.last[i] == formats::PointOutcome::kUncertain;
    judgement.made += count[i] > 0;
    judgement.doubled += count[i] > 1;
    judgement.uncertain += uncertain;
    judgement.unknown += !uncertain && formats::IsFired(job.last[i]) != (count[i] > 0);
  }
  return judgement;
}

}  // namespace intaglio::testing
