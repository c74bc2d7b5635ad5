#include "services/cli/batch/station_jobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <sstream>

#include "services/job/checks/job_check.h"
#include "services/job/convert/job_defaults.h"

namespace intaglio::cli {
namespace {

constexpr std::uint32_t kMaxStation = 64;

}  // namespace

Result<std::vector<std::uint32_t>> ParseStations(const std::string& text) {
  std::vector<std::uint32_t> stations;
  std::istringstream in(text + ",");
  for (std::string number; std::getline(in, number, ',');) {
    std::uint32_t station = 0;
    const char* end = number.data() + number.size();
    const auto [read, error] = std::from_chars(number.data(), end, station);
    if (error != std::errc() || read != end || station < 1 || station > kMaxStation) {
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("--stations {}: '{}' is no station; give numbers from 1 to "
                              "{} with commas between them, as 1,2,4",
                              text, number, kMaxStation),
                  number);
    }
    if (std::ranges::find(stations, station) != stations.end()) {
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("--stations {}: {} occurs twice; a station has one block",
                              text, station),
                  number);
    }
    stations.push_back(station);
  }
  return stations;
}

Result<std::vector<JobAndMachine>> BuildStationJobs(
    const JobFlags& flags, const std::vector<std::uint32_t>& stations) {
  std::vector<JobAndMachine> jobs;
  std::vector<Error> errors;
  for (const std::uint32_t station : stations) {
    JobFlags at_station = flags;
    at_station.fields.push_back(fmt::format("station={}", station));
    auto built = BuildJobToEngrave(at_station);
    if (!built) {
      errors.push_back(built.error());
      continue;
    }
    const std::string name = WithDefaults(built->job, built->machine).name();
    built->job.set_name(fmt::format("{}, station {}", name, station));
    if (!jobs.empty()) {
      built->notes.clear();
      built->warnings.clear();
    }
    jobs.push_back(std::move(*built));
  }
  if (!errors.empty()) return tl::unexpected(JoinErrors(errors));
  return jobs;
}

}  // namespace intaglio::cli
