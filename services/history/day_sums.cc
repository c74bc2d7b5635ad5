#include "services/history/day_sums.h"

#include <algorithm>
#include <chrono>

#include "services/platform/host/times/utc_time.h"

namespace intaglio::history {
namespace {

constexpr std::size_t kDayLength = sizeof("2026-11-21") - 1;

/// 0 where one of the times is not known.
double SecondsBetween(const std::string& begin_utc, const std::string& end_utc) {
  const auto begin = host::TimeOfUtc(begin_utc), end = host::TimeOfUtc(end_utc);
  if (!begin || !end) return 0;
  return std::max(0.0, std::chrono::duration<double>(*end - *begin).count());
}

void CountVerdict(const std::string& verdict, DayStatistics& day) {
  if (verdict == "good")
    day.set_good(day.good() + 1);
  else if (verdict == "good_with_warnings")
    day.set_good_with_warnings(day.good_with_warnings() + 1);
  else if (verdict == "not_good")
    day.set_not_good(day.not_good() + 1);
  else if (verdict == "none")
    day.set_none(day.none() + 1);
  else
    day.set_unknown(day.unknown() + 1);
}

void AddTimes(const JobStatistics& job, DayStatistics& day) {
  const bool has_fired = !job.engraving_utc().empty();
  const std::string& prepared = has_fired ? job.engraving_utc() : job.ended_utc();
  day.set_preparing_s(day.preparing_s() + SecondsBetween(job.started_utc(), prepared));
  day.set_engraving_s(day.engraving_s() + job.machining_s());
  const double at_work_s =
      has_fired ? SecondsBetween(job.engraving_utc(), job.ended_utc()) : 0;
  day.set_interrupted_s(day.interrupted_s() +
                        std::max(0.0, at_work_s - job.machining_s()));
}

}  // namespace

void DaySums::Add(const JobStatistics& job) {
  if (job.ended_utc().empty()) return;
  const std::string date = job.ended_utc().substr(0, kDayLength);
  DayStatistics& day = rows_[{date, job.cell()}];
  day.set_day(date);
  day.set_cell(job.cell());
  day.set_pieces(day.pieces() + 1);
  CountVerdict(job.verdict(), day);
  day.set_planned(day.planned() + job.planned());
  day.set_made(day.made() + job.made());
  AddTimes(job, day);
}

std::vector<DayStatistics> DaySums::Rows() const {
  std::vector<DayStatistics> rows;
  for (const auto& [name, day] : rows_) rows.push_back(day);
  return rows;
}

}  // namespace intaglio::history
