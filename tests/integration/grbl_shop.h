#pragma once

// A shop with a controller of the grbl family, as processes: the virtual grbl in one of
// its own, whose record of the laser is the judge.

#include <filesystem>
#include <string>

#include "tests/integration/point_shop.h"

namespace intaglio::testing {

// A step of the virtual grbl.
inline constexpr double kGrblStepMm = 0.004;

struct GrblJudgement {
  std::size_t points = 0, made = 0, doubled = 0, stray = 0, uncertain = 0;
  std::size_t unknown = 0;  ///< fired, and neither known nor uncertain
  double lit_at_rest_us = 0, farthest_mm = 0;
};

class GrblShop : public PointShop {
 public:
  struct Options {
    bool hal = true;   ///< grblHAL, with a buffer of 1023 bytes; else grbl 1.1, 128
    bool tcp = false;  ///< else a pseudo-terminal, as a serial line
    std::string job = KnotOf(2.2, 0.3);
  };
  /// A file of one's own, so high.
  static std::string Mesh(const std::filesystem::path& file, double height_mm,
                          double spacing_mm);

  explicit GrblShop(const Options& options);
  std::size_t Flashes() const;
  GrblJudgement Judge() const;
};

}  // namespace intaglio::testing
