#include "services/history/job_history.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <memory>
#include <string_view>

#include "engrave/core/try.h"
#include "proto/task.pb.h"
#include "services/history/job_database.h"
#include "services/history/job_names.h"
#include "services/history/write_ahead_log.h"
#include "services/platform/host/times/utc_time.h"
#include "services/sql/address.h"

namespace intaglio::history {
namespace {

namespace fs = std::filesystem;
using SystemTime = std::chrono::system_clock::time_point;

constexpr std::array kVerdicts = {"good", "good_with_warnings", "not_good", "none",
                                  "unknown"};

// From this version of the database on, jobs have their warnings.
constexpr int kWarningsVersion = 9;
// And from this one on, their first estimates and what these are compared with.
constexpr int kEstimatesVersion = 11;
// And from this one on, what became of workers.
constexpr int kWorkersVersion = 16;

// From this share on, the pace so far predicts the end better than the plan does: it
// includes pauses and the speed override.
constexpr double kPaceIsKnown = 0.05;

// Comes behind every text that begins like it: until a day is until its end.
constexpr char kBehindAll[] = "\x7f";

constexpr const char* kSelect = R"sql(
SELECT j.number, j.uid, j.name, j.cell, j.material, j.state, j.verdict, j.attempt,
  j.priority, j.message, j.result_directory, j.rate_hz, j.estimate_ticks, j.used_ticks,
  j.planned_count, j.made_count, j.missed_count, j.skipped_count, j.uncertain_count,
  coalesce(s.taken_utc, '') AS submitted_utc, j.started_utc, j.engraving_utc, j.ended_utc,
  j.report, j.recording, {0}, {1},
  coalesce(e.done_count, 0) AS done_count, coalesce(e.total_count, 0) AS total_count,
  coalesce(e.elapsed_s, 0) AS worked_s
FROM jobs AS j
LEFT JOIN submissions AS s ON s.submission_uid = j.submission_uid
LEFT JOIN stages AS e ON e.job_uid = j.uid AND e.stage = 2
)sql";

/// The conditions of a filter, each with its value.
class Conditions {
 public:
  explicit Conditions(const Filter& filter) {
    if (filter.job) {
      texts_.push_back(fmt::format("j.number = {}", *filter.job));
      return;
    }
    // The plus keeps SQLite from the index of it, in which all ended jobs are one: that
    // of the ends, jobs_history, has a day in one place, and the order.
    texts_.push_back("+j.ended = 1");
    Add("j.ended_utc >= {}", filter.since);
    if (!filter.until.empty()) Add("j.ended_utc < {}", filter.until + kBehindAll);
    Add("instr(lower(j.name), lower({})) > 0", filter.piece);
    Add("lower(j.material) = lower({})", filter.material);
    Add("j.verdict = {}", filter.verdict);
    Add("j.cell = {}", filter.cell);
  }

  std::string Text() const {
    return fmt::format("WHERE {} ORDER BY j.ended_utc, j.number",
                       fmt::join(texts_, " AND "));
  }
  void Bind(sql::Statement& statement) const {
    int place = 0;
    for (const std::string& value : values_) statement.Bind(++place, value);
  }

 private:
  void Add(const char* condition, const std::string& value) {
    if (value.empty()) return;
    values_.push_back(value);
    texts_.push_back(fmt::format(fmt::runtime(condition), "?"));
  }
  std::vector<std::string> texts_, values_;
};

/// The report of a shop's job is made after the row is written.
std::string ReportOf(const std::string& stored, const std::string& folder) {
  std::error_code error;
  const auto report = std::filesystem::path(folder) / "report.json";
  return std::filesystem::exists(report, error) ? report.string() : stored;
}

/// From a time of the database to another; 0: there is no first one.
double SecondsBetween(const std::string& begin_utc, SystemTime end) {
  const auto begin = host::TimeOfUtc(begin_utc);
  return begin ? std::chrono::duration<double>(end - *begin).count() : 0;
}

JobStatistics RowOf(sql::Statement& row, SystemTime now) {
  JobStatistics s;
  const auto text = [&row](const char* column) { return row.Text(column); };
  const auto u32 = [&row](const char* column) {
    return static_cast<std::uint32_t>(row.Integer(column));
  };
  const auto number = [&row](const char* column) { return row.Real(column); };
  s.set_job(u32("number"));
  s.set_uid(text("uid"));
  s.set_name(text("name"));
  s.set_cell(text("cell"));
  s.set_material(text("material"));
  s.set_state(
      StateName(static_cast<intaglio_JobState>(static_cast<int>(row.Integer("state")))));
  s.set_verdict(text("verdict"));
  s.set_planned(u32("planned_count"));
  s.set_made(u32("made_count"));
  s.set_missed(u32("missed_count"));
  s.set_skipped(u32("skipped_count"));
  s.set_uncertain(u32("uncertain_count"));
  s.set_submitted_utc(text("submitted_utc"));
  s.set_started_utc(text("started_utc"));
  s.set_engraving_utc(text("engraving_utc"));
  s.set_ended_utc(text("ended_utc"));
  s.set_duration_s(
      SecondsBetween(s.started_utc(), host::TimeOfUtc(s.ended_utc()).value_or(now)));
  const double rate_hz = number("rate_hz");
  if (rate_hz > 0) {
    s.set_estimated_s(number("estimate_ticks") / rate_hz);
    s.set_machining_s(number("used_ticks") / rate_hz);
    s.set_first_estimated_s(number("first_estimate_ticks") / rate_hz);
    s.set_undisturbed_s(number("undisturbed_ticks") / rate_hz);
  } else if (!s.ended_utc().empty()) {
    // Marks and contours have no ticks.
    s.set_machining_s(number("worked_s"));
  }
  if (s.undisturbed_s() > 0) {
    s.set_first_estimate_ratio(s.first_estimated_s() / s.undisturbed_s());
    s.set_estimate_ratio(s.estimated_s() / s.undisturbed_s());
  }
  s.set_attempt(u32("attempt"));
  s.set_priority(static_cast<int>(row.Integer("priority")));
  s.set_message(text("message"));
  s.set_result_directory(text("result_directory"));
  s.set_report(ReportOf(text("report"), text("result_directory")));
  s.set_recording(text("recording"));
  WarningList warnings;
  if (warnings.ParseFromString(text("warnings"))) {
    s.mutable_warnings()->Swap(warnings.mutable_warnings());
  }
  s.set_breakage_accepted_by(text("breakage_accepted_by"));
  return s;
}

bool IsTime(std::string_view text) {
  constexpr std::string_view kDay = "2026-11-21", kSecond = "2026-11-21T15:30:05";
  return text.size() >= kDay.size() && text.size() <= kSecond.size() &&
         host::HasShapeOfUtc(text);
}

Status CheckTime(const char* name, const std::string& text) {
  if (text.empty() || IsTime(text)) return {};
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("{} '{}': write a day as 2026-11-21, or a day and a time as "
                          "2026-11-21T15:30, UTC",
                          name, text),
              text);
}

Status VisitJobs(sql::Connection& database, const Filter& filter, SystemTime now,
                 const std::function<Status(const JobStatistics&)>& visit) {
  const Conditions conditions(filter);
  const int version = database.Version();
  const char* const columns = version < kWarningsVersion
                                  ? "'' AS warnings, '' AS breakage_accepted_by"
                                  : "j.warnings, j.breakage_accepted_by";
  const char* const estimates = version < kEstimatesVersion
                                    ? "0 AS first_estimate_ticks, 0 AS undisturbed_ticks"
                                    : "j.first_estimate_ticks, j.undisturbed_ticks";
  const auto select = database.Prepare(
      fmt::format(fmt::runtime(kSelect), columns, estimates) + conditions.Text());
  conditions.Bind(*select);
  while (select->Step()) {
    JobStatistics job = RowOf(*select, now);
    const auto count = [&select](const char* column) {
      return static_cast<std::uint64_t>(select->Integer(column));
    };
    AddProgress(job, count("done_count"), count("total_count"), select->Real("worked_s"),
                now);
    INTAGLIO_TRY(visit(job));
  }
  return {};
}

}  // namespace

void AddProgress(JobStatistics& job, std::uint64_t done, std::uint64_t total,
                 double worked_s, SystemTime now) {
  if (total == 0) return;
  const double share = static_cast<double>(done) / static_cast<double>(total);
  job.set_progress_ratio(std::min(1.0, share));
  if (!job.ended_utc().empty()) return;
  job.set_planned(static_cast<std::uint32_t>(total));
  job.set_made(static_cast<std::uint32_t>(done));
  if (job.engraving_utc().empty()) return;
  const bool by_pace = share > kPaceIsKnown && worked_s > 0;
  const double left_s = (by_pace ? worked_s / share : job.estimated_s()) * (1 - share);
  job.set_expected_end_utc(
      host::UtcText(now + std::chrono::duration_cast<SystemTime::duration>(
                              std::chrono::duration<double>(std::min(left_s, 1e8)))));
}

EstimateScore ScoreOf(const std::vector<JobStatistics>& jobs) {
  std::vector<double> ratios;
  for (const JobStatistics& job : jobs) {
    if (job.first_estimate_ratio() > 0) ratios.push_back(job.first_estimate_ratio());
  }
  if (ratios.empty()) return {};
  std::sort(ratios.begin(), ratios.end());
  const std::size_t middle = ratios.size() / 2;
  const double median =
      ratios.size() % 2 == 1 ? ratios[middle] : (ratios[middle - 1] + ratios[middle]) / 2;
  return {ratios.size(), median, ratios.front(), ratios.back()};
}

Status CheckFilter(const Filter& filter) {
  INTAGLIO_TRY(CheckTime("--since", filter.since));
  INTAGLIO_TRY(CheckTime("--until", filter.until));
  if (filter.verdict.empty() ||
      std::find(kVerdicts.begin(), kVerdicts.end(), filter.verdict) != kVerdicts.end()) {
    return {};
  }
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("--verdict '{}': unknown verdict; known are {}", filter.verdict,
                          fmt::join(kVerdicts, ", ")),
              filter.verdict);
}

std::vector<JobStatistics> SelectJobs(sql::Connection& database, const Filter& filter,
                                      SystemTime now) {
  std::vector<JobStatistics> jobs;
  // It ends early for an error of the visitor alone, and this one has none.
  static_cast<void>(VisitJobs(database, filter, now, [&jobs](const JobStatistics& job) {
    jobs.push_back(job);
    return Status();
  }));
  return jobs;
}

namespace {

Status CheckFile(const fs::path& file) {
  std::error_code ignored;
  if (!fs::exists(file, ignored) && !fs::exists(file.string() + "-wal", ignored)) {
    return Fail(ErrorCode::kNotFound,
                fmt::format("{}: the file does not exist: give the folder of the shop "
                            "with --folder, or the job service's --database",
                            file.string()),
                file.string());
  }
  INTAGLIO_TRY(CheckJobDatabase(file));
  return CheckLogInUse(file);
}

/// What `read` makes of the opened database.
template <typename T, typename Read>
Result<T> Opened(const std::string& address, const Read& read) {
  const bool is_file = !sql::IsServerAddress(address);
  const std::string place = sql::WithoutPassword(address);
  if (is_file) INTAGLIO_TRY(CheckFile(address));
  try {
    const auto database = sql::OpenToRead(address);
    const int version = database->Version();
    if (version < kHistoryVersion || version > kJobDatabaseVersion) {
      return Fail(ErrorCode::kUnreadable,
                  fmt::format("{}: has version {}, this program reads {} to {}: start a "
                              "current job service on an older one (intaglio up), or use "
                              "the newer program",
                              place, version, kHistoryVersion, kJobDatabaseVersion),
                  place);
    }
    return read(*database);
  } catch (const sql::SqlError& error) {
    if (is_file && error.kind() == sql::SqlError::Kind::kDamaged)
      return tl::unexpected(DamagedQueue(address, error.what()));
    return Fail(
        ErrorCode::kIo,
        fmt::format("{}: {}: check that it is the database of a job service, and "
                    "that you may read it{}",
                    place, error.what(), is_file ? " and write to its folder" : ""),
        place);
  }
}

}  // namespace

Result<std::vector<JobStatistics>> ReadHistory(const std::string& database,
                                               const Filter& filter) {
  using Jobs = std::vector<JobStatistics>;
  return Opened<Jobs>(database, [&filter](sql::Connection& opened) -> Result<Jobs> {
    return SelectJobs(opened, filter, std::chrono::system_clock::now());
  });
}

Result<WorkerHistory> ReadWorkerHistory(const std::string& database) {
  return Opened<WorkerHistory>(
      database, [](sql::Connection& opened) -> Result<WorkerHistory> {
        WorkerHistory history;
        if (opened.Version() < kWorkersVersion) return history;
        const auto select = opened.Prepare(
            "SELECT at_utc, worker, event, why, operator_name FROM worker_events "
            "ORDER BY number");
        while (select->Step()) {
          WorkerEvent& event = *history.add_events();
          event.set_time_utc(select->Text(0));
          event.set_worker(select->Text(1));
          event.set_event(select->Text(2));
          event.set_why(select->Text(3));
          event.set_operator_name(select->Text(4));
        }
        return history;
      });
}

Status VisitHistory(const std::string& database, const Filter& filter,
                    const std::function<Status(const JobStatistics&)>& visit) {
  const auto visited =
      Opened<bool>(database, [&](sql::Connection& opened) -> Result<bool> {
        INTAGLIO_TRY(VisitJobs(opened, filter, std::chrono::system_clock::now(), visit));
        return true;
      });
  if (!visited) return tl::unexpected(visited.error());
  return {};
}

namespace {

/// The row of a job, stepped to; kNotFound.
Result<std::unique_ptr<sql::Statement>> SelectJob(sql::Connection& opened,
                                                  const char* columns,
                                                  const std::string& place,
                                                  const std::string& uid_or_number) {
  // As it is written: 12, not 012. A uid has a hyphen.
  std::uint32_t number = 0;
  const char* const end = uid_or_number.data() + uid_or_number.size();
  const auto read = std::from_chars(uid_or_number.data(), end, number);
  const bool is_number =
      !uid_or_number.starts_with('0') && read.ec == std::errc() && read.ptr == end;
  auto select = opened.Prepare(fmt::format("SELECT {} FROM jobs WHERE {} = ?", columns,
                                           is_number ? "number" : "uid"));
  if (is_number) {
    select->Bind(1, number);
  } else {
    select->Bind(1, uid_or_number);
  }
  if (select->Step()) return select;
  return Fail(ErrorCode::kNotFound,
              fmt::format("{}: no job '{}'; intaglio history lists the jobs", place,
                          uid_or_number),
              uid_or_number);
}

}  // namespace

Result<JobSpec> ReadJob(const std::string& database, const std::string& uid_or_number) {
  return Opened<JobSpec>(database, [&](sql::Connection& opened) -> Result<JobSpec> {
    const std::string place = sql::WithoutPassword(database);
    const auto row = INTAGLIO_TRY(SelectJob(opened, "frozen_job", place, uid_or_number));
    FrozenJob frozen;
    if (frozen.ParseFromString(row->Text(0))) return frozen.job();
    return Fail(ErrorCode::kUnreadable,
                fmt::format("{}: job {} cannot be read; submit its job file again", place,
                            uid_or_number),
                uid_or_number);
  });
}

Result<JobFolder> FindJobFolder(const std::string& database,
                                const std::string& uid_or_number) {
  return Opened<JobFolder>(database, [&](sql::Connection& opened) -> Result<JobFolder> {
    const auto row =
        INTAGLIO_TRY(SelectJob(opened, "number, result_directory",
                               sql::WithoutPassword(database), uid_or_number));
    return JobFolder{static_cast<std::uint32_t>(row->Integer(0)), row->Text(1)};
  });
}

}  // namespace intaglio::history
