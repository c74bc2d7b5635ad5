#include "services/console/routes.h"

#include <algorithm>

namespace intaglio::console {
namespace {

// clang-format off
constexpr Route kRoutes[] = {
    {"POST", "/api/v1/login", Right::kOpen, "LogInRequest", "ConsoleSession",
     "Log in; the answer sets the cookie of the session"},
    {"POST", "/api/v1/logout", Right::kRead, "", "ConsoleSession", "End the session"},
    {"GET", "/api/v1/session", Right::kRead, "", "ConsoleSession", "Who is logged in"},
    {"POST", "/api/v1/charge", Right::kOperate, "", "ConsoleSession",
     "Take over: the commands of everybody else are refused from now on"},
    {"POST", "/api/v1/stop", Right::kRead, "StopRequest", "StopAnswer",
     "Stop every machine"},
    {"GET", "/api/v1/status", Right::kRead, "", "ShopStatus", "The shop"},
    {"GET", "/api/v1/jobs", Right::kRead, "", "JobList", "Its jobs"},
    {"GET", "/api/v1/jobs/{job}", Right::kRead, "", "JobRecord", "A job"},
    {"GET", "/api/v1/jobs/{job}/plan", Right::kRead, "", "application/octet-stream",
     "Its planned points"},
    {"GET", "/api/v1/jobs/{job}/made", Right::kRead, "", "application/octet-stream",
     "What was made of them, from the record `from` on"},
    {"GET", "/api/v1/jobs/{job}/ticks", Right::kRead, "", "application/octet-stream",
     "At which ticks, from the record `from` on"},
    {"GET", "/api/v1/jobs/{job}/channels", Right::kRead, "", "application/octet-stream",
     "In which channels its points are made"},
    {"GET", "/api/v1/jobs/{job}/report", Right::kRead, "", "JobReport", "Its report"},
    {"GET", "/api/v1/jobs/{job}/picture", Right::kRead, "", "image/png",
     "The customer's picture"},
    {"GET", "/api/v1/jobs/{job}/views", Right::kRead, "", "image/png", "Its views"},
    {"POST", "/api/v1/jobs/{job}/hold", Right::kCharge, "HoldRequest", "HoldAnswer",
     "Begin to hold the button of an arm or a resume"},
    {"POST", "/api/v1/jobs/{job}/arm", Right::kCharge, "ArmRequest", "CommandAnswer",
     "Arm at the end of the hold"},
    {"POST", "/api/v1/jobs/{job}/resume", Right::kCharge, "ResumeRequest", "CommandAnswer",
     "Resume at the end of the hold"},
    {"POST", "/api/v1/jobs/{job}/pause", Right::kOperate, "", "CommandAnswer", "Pause"},
    {"POST", "/api/v1/jobs/{job}/cancel", Right::kCharge, "", "CommandAnswer",
     "Cancel for good"},
    {"POST", "/api/v1/jobs/{job}/speed", Right::kCharge, "SpeedRequest", "CommandAnswer",
     "Set the speed"},
    {"POST", "/api/v1/jobs/{job}/move", Right::kCharge, "MoveRequest", "CommandAnswer",
     "Change the place of a job that waits for its machine"},
    {"GET", "/api/v1/photos/{job}", Right::kRead, "", "image/jpeg",
     "The photograph of a job's block, which may be a PNG"},
    {"POST", "/api/v1/photos/{job}", Right::kOperate, "application/octet-stream",
     "CommandAnswer", "Add it, or another in its place; `name` is that of the file"},
    {"GET", "/api/v1/machines/{cell}/teaching", Right::kRead, "", "MachineTeaching",
     "What there is to teach at a machine: lenses, channels, zeros"},
    {"GET", "/api/v1/machines/{cell}/zero_move", Right::kRead, "", "SeriesZeroMove",
     "How the focus series of `job` has the zero move, whose crack `first` is visible"},
    {"POST", "/api/v1/machines/{cell}/reset", Right::kCharge, "ResetRequest",
     "CommandAnswer", "Release the emergency stops that were read"},
    {"POST", "/api/v1/machines/{cell}/pulse", Right::kCharge, "TestJobRequest",
     "SubmitAnswer", "Submit a job of one weak pulse where the focus is"},
    {"POST", "/api/v1/machines/{cell}/focus", Right::kCharge, "TestJobRequest",
     "SubmitAnswer", "Submit a row of points at growing depth from there on"},
    {"GET", "/api/v1/submissions/{id}/files/{file}", Right::kRead, "", "UploadAnswer",
     "How much of a file of a submission has come"},
    {"POST", "/api/v1/submissions/{id}/files/{file}", Right::kOperate,
     "application/octet-stream", "UploadAnswer",
     "Send a file of a submission, from the byte `offset` on; it has `size` bytes"},
    {"POST", "/api/v1/submissions/{id}", Right::kOperate, "JobSpec", "SubmitAnswer",
     "Submit the job of this job file, which names the files that were sent"},
    {"POST", "/api/v1/submissions/{id}/preview", Right::kOperate, "JobSpec", "JobPreview",
     "What the job of this job file will look like and take"},
    {"GET", "/api/v1/submissions/{id}/preview", Right::kRead, "", "image/png",
     "The picture of the last preview"},
    {"GET", "/api/v1/choices", Right::kRead, "", "JobChoices",
     "The glasses and machines that a job may name"},
    {"GET", "/api/v1/history", Right::kRead, "", "JobHistory",
     "The jobs that have ended; since, until, name, glass, verdict and cell choose some"},
    {"GET", "/api/v1/history.csv", Right::kRead, "", "text/csv",
     "The same as a table, with a row for each job"},
    {"GET", "/api/v1/days.csv", Right::kRead, "", "text/csv",
     "A row for each day and machine: pieces by verdict, and times"},
    {"GET", "/api/v1/events", Right::kRead, "", "text/event-stream",
     "The lines of --events"},
    {"GET", "/metrics", Right::kRead, "", "text/plain", "For Prometheus"},
};
// clang-format on

/// The first part of a path, which is shortened by it and its '/'.
std::string_view TakePart(std::string_view& path) {
  const auto end = std::min(path.find('/'), path.size());
  const std::string_view part = path.substr(0, end);
  path.remove_prefix(std::min(end + 1, path.size()));
  return part;
}

bool IsPath(std::string_view pattern, std::string_view path) {
  if (std::count(pattern.begin(), pattern.end(), '/') !=
      std::count(path.begin(), path.end(), '/'))
    return false;
  while (!pattern.empty() || !path.empty()) {
    const std::string_view expected = TakePart(pattern), part = TakePart(path);
    const bool is_any = expected.starts_with('{');
    if (is_any ? part.empty() : part != expected) return false;
  }
  return true;
}

}  // namespace

std::span<const Route> Routes() { return kRoutes; }

const Route* FindRoute(std::string_view method, std::string_view path) {
  const auto* found =
      std::find_if(std::begin(kRoutes), std::end(kRoutes), [&](const Route& route) {
        return route.method == method && IsPath(route.path, path);
      });
  return found == std::end(kRoutes) ? nullptr : found;
}

std::string MethodsOf(std::string_view path) {
  std::string methods;
  for (const Route& route : kRoutes) {
    if (!IsPath(route.path, path) || methods.find(route.method) != std::string::npos)
      continue;
    methods += (methods.empty() ? "" : ", ") + std::string(route.method);
  }
  return methods;
}

}  // namespace intaglio::console
