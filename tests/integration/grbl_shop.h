#pragma once

// A shop with a controller of the grbl family, as processes: the virtual grbl in one of
// its own, whose record of the laser is the judge.

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "tests/integration/run_program.h"

namespace intaglio::testing {

// A step of the virtual grbl.
inline constexpr double kGrblStepMm = 0.004;

struct GrblJudgement {
  std::size_t points = 0, made = 0, doubled = 0, stray = 0, uncertain = 0;
  std::size_t unknown = 0;  ///< fired, and neither known nor uncertain
  double lit_at_rest_us = 0, farthest_mm = 0;
};

class GrblShop {
 public:
  struct Options {
    bool hal = true;   ///< grblHAL, with a buffer of 1023 bytes; else grbl 1.1, 128
    bool tcp = false;  ///< else a pseudo-terminal, as a serial line
    /// The text of a job file: models, block, discretization.
    std::string job = Knot(2.2);
  };
  /// The supplied model, so high; and a file of one's own.
  static std::string Knot(double height_mm);
  static std::string Mesh(const std::filesystem::path& file, double height_mm,
                          double spacing_mm);

  explicit GrblShop(const Options& options);
  ~GrblShop();

  /// Whether it opens.
  bool Open();
  /// Its processes were killed too often for it to go on by itself.
  bool IsOpen() { return shop_ && shop_->running(); }
  std::string Type(std::vector<std::string> arguments);
  bool Submit();
  /// `resuming`: a paused job is resumed, a closed shop opened again.
  bool AwaitDone(std::chrono::seconds bound, bool resuming);
  std::size_t Flashes() const;
  std::size_t UncertainPoints() const;
  /// With SIGKILL; how many there were.
  int Kill(const std::string& service) const;
  GrblJudgement Judge() const;

  std::filesystem::path profile() const { return folder_ / "machine.textproto"; }
  const std::string& shown() const { return shown_; }
  std::string Log() const { return shop_ ? shop_->Output() : ""; }

 private:
  void WriteProfile(const std::string& device) const;
  std::filesystem::path JobFolder() const;

  std::filesystem::path folder_;
  std::string tag_, shown_;
  // Its path is short: that of a socket has 107 bytes.
  std::string socket_;
  int opened_ = 0;
  std::unique_ptr<Running> controller_, shop_;
};

}  // namespace intaglio::testing
