#include "services/virtual_engraver/head/head_memory.h"

#include <algorithm>
#include <utility>

namespace intaglio::virtual_engraver {

using link::HeadMarkFate;

void HeadMemory::Note(std::uint32_t run, std::uint32_t mark, HeadMarkFate fate) {
  if (reports_.empty() || reports_.back().run != run ||
      reports_.back().events.size() == link::kMaxHeadEvents)
    reports_.push_back({run, {}});
  reports_.back().events.push_back({mark, fate});
  // A mark is noted again soon after its beginning, so the newest are searched first.
  const auto known = std::find_if(known_.rbegin(), known_.rend(), [&](const Known& k) {
    return k.run == run && k.mark == mark;
  });
  if (known != known_.rend()) {
    known->fate = fate;
    return;
  }
  known_.push_back({run, mark, fate});
  if (known_.size() <= kMarks) return;
  forgot_ = true;
  forgotten_run_ = std::max(forgotten_run_, known_.front().run);
  known_.pop_front();
}

link::HeadPast HeadMemory::Past(const link::HeadPastRequest& asked) const {
  // A mark that never came was not begun; of a run that was partly forgotten it is not
  // known whether it came.
  const bool all_known = !forgot_ || asked.run > forgotten_run_;
  link::HeadPast past{asked.run, asked.first_mark, {}};
  past.fates.assign(asked.count,
                    all_known ? HeadMarkFate::kNotBegun : HeadMarkFate::kNoLongerKnown);
  for (const Known& k : known_) {
    if (k.run != asked.run || k.mark < asked.first_mark) continue;
    if (k.mark - asked.first_mark < asked.count)
      past.fates[k.mark - asked.first_mark] = k.fate;
  }
  return past;
}

std::vector<link::HeadMarks> HeadMemory::TakeReports() {
  return std::exchange(reports_, {});
}

}  // namespace intaglio::virtual_engraver
