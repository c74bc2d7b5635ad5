#include "services/history/history_csv.h"

#include <fmt/format.h>

#include "engrave/core/try.h"
#include "proto/listing.pb.h"
#include "services/history/day_sums.h"
#include "services/history/message_csv.h"

namespace intaglio::history {
namespace {

Status AddLine(const google::protobuf::Message& row, std::size_t max_bytes,
               std::string& text) {
  text += CsvLine(row);
  if (text.size() <= max_bytes) return {};
  return Fail(ErrorCode::kTooLarge,
              fmt::format("the table has more than {} bytes: ask for a part of it, with "
                          "since and until",
                          max_bytes));
}

}  // namespace

Result<std::string> HistoryCsv(const std::string& database, const Filter& filter,
                               CsvRows rows, std::size_t max_bytes) {
  if (rows == CsvRows::kJobs) {
    std::string text = CsvHeader(*JobStatistics::descriptor());
    INTAGLIO_TRY(VisitHistory(database, filter, [&](const JobStatistics& job) {
      return AddLine(job, max_bytes, text);
    }));
    return text;
  }
  DaySums sums;
  INTAGLIO_TRY(
      VisitHistory(database, filter, [&sums](const JobStatistics& job) -> Status {
        sums.Add(job);
        return {};
      }));
  std::string text = CsvHeader(*DayStatistics::descriptor());
  for (const DayStatistics& day : sums.Rows())
    INTAGLIO_TRY(AddLine(day, max_bytes, text));
  return text;
}

}  // namespace intaglio::history
