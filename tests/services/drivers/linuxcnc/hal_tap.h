#pragma once

// A tap between a driver and HAL, which sees every sample and cuts the line.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "services/drivers/linuxcnc/hal_line.h"
#include "services/drivers/linuxcnc/hal_text.h"

namespace intaglio::linuxcnc {

class HalTap {
 public:
  /// A line for the driver; the same programs of HAL go on when it is not lost.
  drivers::HalOpener Opener();
  /// Takes what HAL has reported.
  void Pump();
  /// HAL has started, or ends.
  void Plug();
  void Unplug() { line_.reset(); }
  void Cut(bool cut);
  void CutAfter(std::uint64_t bytes) { bytes_left_ = bytes; }
  const drivers::HalSample& newest() const { return newest_; }
  bool moves() const { return still_samples_ < 20; }
  /// Periods so far in which the beam was on or an axis moved.
  std::uint64_t work_count() const { return work_count_; }
  /// What it has seen is kept, from now on.
  void Record() {
    records_ = true;
    recorded_.clear();
  }
  const std::vector<drivers::HalSample>& recorded() const { return recorded_; }

 private:
  class Handle;
  bool cut() const { return bytes_left_ == std::uint64_t{0}; }
  std::string_view Pass(std::string_view text);

  std::unique_ptr<drivers::HalLine> line_;
  std::optional<std::uint64_t> bytes_left_;  // until the cut; nullopt: there is none
  std::string to_driver_, partial_;
  drivers::HalSample newest_;
  int still_samples_ = 1000;
  std::uint64_t work_count_ = 0;
  bool records_ = false;
  std::vector<drivers::HalSample> recorded_;
};

}  // namespace intaglio::linuxcnc
