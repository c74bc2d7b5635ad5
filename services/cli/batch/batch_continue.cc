#include "services/cli/batch/batch_continue.h"

#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>

#include <map>
#include <string>

#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"
#include "services/job/verdict/verdict.h"

namespace intaglio::cli {
namespace {

constexpr std::uint64_t kMaxResultsBytes = 64u << 20;

using ById = std::map<std::string, const BatchJobResult*>;

ById IdsOf(const BatchResults& results) {
  ById by_id;
  for (const BatchJobResult& result : results.jobs()) by_id.emplace(result.id(), &result);
  return by_id;
}

bool IsGood(const BatchJobResult& result) {
  const VerdictKind verdict = VerdictFromName(result.verdict());
  return result.state() == "done" &&
         (verdict == VerdictKind::kGood || verdict == VerdictKind::kGoodWithWarnings);
}

/// It has an end, which another attempt would not change.
bool HasEnded(const BatchJobResult& result) {
  const std::string& state = result.state();
  return state == "done" || state == "failed" || state == "cancelled" ||
         state == "refused";
}

}  // namespace

Result<BatchResults> ReadBatchResults(const std::filesystem::path& file) {
  const auto text = INTAGLIO_TRY(io::ReadWholeFile(file, kMaxResultsBytes));
  BatchResults results;
  const auto read = google::protobuf::util::JsonStringToMessage(text, &results);
  if (read.ok()) return results;
  return Fail(ErrorCode::kUnreadable,
              fmt::format("--continue {}: it is no file that --results has written: {}",
                          file.string(), std::string(read.message())),
              file.string());
}

std::vector<BatchJob> LeaveOutDone(const std::vector<BatchJob>& jobs,
                                   const BatchResults& earlier) {
  const ById by_id = IdsOf(earlier);
  std::vector<BatchJob> left;
  std::map<std::size_t, std::size_t> place;  // in `left`, by place in `jobs`
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const auto result = by_id.find(jobs[i].id);
    if (result != by_id.end() && IsGood(*result->second)) continue;
    place[i] = left.size();
    BatchJob& job = left.emplace_back(jobs[i]);
    if (result != by_id.end() && job.key.empty() && !HasEnded(*result->second))
      job.key = result->second->key();
  }
  for (BatchJob& job : left) {
    std::vector<std::size_t> after;
    for (const std::size_t before : job.planned.after) {
      if (const auto found = place.find(before); found != place.end())
        after.push_back(found->second);
    }
    job.planned.after = std::move(after);
  }
  return left;
}

BatchResults JoinResults(const std::vector<BatchJob>& jobs, const BatchResults& earlier,
                         const BatchResults& now) {
  const ById before = IdsOf(earlier), after = IdsOf(now);
  BatchResults all = now;
  all.clear_jobs();
  for (const BatchJob& job : jobs) {
    if (const auto made = after.find(job.id); made != after.end()) {
      *all.add_jobs() = *made->second;
      continue;
    }
    const BatchJobResult& kept = *before.at(job.id);
    *all.add_jobs() = kept;
    if (VerdictFromName(kept.verdict()) == VerdictKind::kGood) {
      all.set_good(all.good() + 1);
    } else {
      all.set_good_with_warnings(all.good_with_warnings() + 1);
    }
  }
  return all;
}

}  // namespace intaglio::cli
