#pragma once

// What a driver itself has seen of the newest marks: the answer to RequestPast of a
// controller that remembers none.

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "services/drivers/interface/mark_driver.h"

namespace intaglio::drivers {

class SeenMarks {
 public:
  void Receive(const MarkEvent& event) {
    fates_[{event.run, event.mark}] = event.fate;
    while (fates_.size() > kRememberedMarks) fates_.erase(fates_.begin());
  }
  /// An event for each of these marks is appended. kRefused: more than are remembered.
  Status Answer(std::uint32_t run, std::uint32_t first, std::uint32_t count,
                std::vector<MarkEvent>& events) const {
    if (count > kRememberedMarks) {
      return Fail(ErrorCode::kRefused,
                  std::to_string(count) + " marks are more than the " +
                      std::to_string(kRememberedMarks) + " that are remembered");
    }
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto found = fates_.find({run, first + i});
      events.push_back(
          {run, first + i, found == fates_.end() ? MarkFate::kUncertain : found->second});
    }
    return {};
  }

 private:
  std::map<std::pair<std::uint32_t, std::uint32_t>, MarkFate> fates_;
};

}  // namespace intaglio::drivers
