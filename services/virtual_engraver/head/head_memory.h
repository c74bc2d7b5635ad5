#pragma once

// What a scan head's controller remembers of marks since its power-up, and has to report.

#include <cstdint>
#include <deque>
#include <vector>

#include "services/platform/link/scan_head_protocol.h"

namespace intaglio::virtual_engraver {

class HeadMemory {
 public:
  static constexpr std::uint32_t kMarks = 1024;

  /// To be reported, and remembered in place of what was known of this mark.
  void Note(std::uint32_t run, std::uint32_t mark, link::HeadMarkFate fate);
  link::HeadPast Past(const link::HeadPastRequest& asked) const;
  /// Since the last call, in order.
  std::vector<link::HeadMarks> TakeReports();
  /// Drops those of a session that has ended.
  void DropReports() { reports_.clear(); }

 private:
  struct Known {
    std::uint32_t run, mark;
    link::HeadMarkFate fate;
  };
  std::deque<Known> known_;
  bool forgot_ = false;
  std::uint32_t forgotten_run_ = 0;  // the newest of which a mark was forgotten
  std::vector<link::HeadMarks> reports_;
};

}  // namespace intaglio::virtual_engraver
