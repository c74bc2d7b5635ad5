#include "services/job_service/worker_reports.h"

#include "services/platform/bus/role_names.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/peers/identity_role.h"
#include "services/platform/host/process/log.h"

namespace intaglio::job_service {
namespace {

using bus::View;
using namespace std::chrono_literals;

constexpr auto kWarningPeriod = 1min;

}  // namespace

WorkerReports::WorkerReports(bus::Bus& bus) : bus_(bus) { Open(bus::kStageWorkerRole); }

void WorkerReports::OpenCell(const std::string& cell) { Open(bus::CellRole(cell)); }

void WorkerReports::Open(const std::string& role) {
  const std::string partition = bus::RolePartition(role);
  if (readers_.contains(partition)) return;
  constexpr auto kAudience = bus::Source::kEverybody;
  constexpr auto kKeeps = bus::Keeps::kEverySample;
  readers_.emplace(partition,
                   Readers{bus::Reader<intaglio_TaskStatus>(bus_, bus::kTaskStatus,
                                                            partition, kAudience, kKeeps),
                           bus::Reader<intaglio_ServiceHealth>(
                               bus_, bus::kServiceHealth, partition, kAudience, kKeeps)});
}

void WorkerReports::TakeTasks(const TaskSink& sink, Nanoseconds now) {
  for (auto& [partition, readers] : readers_) {
    readers.tasks.TakeAll(
        [&](const intaglio_TaskStatus& status, const bus::SampleOrigin& origin) {
          if (!origin.alive) return;
          if (host::IsOwnTask(status, origin)) return sink(status);
          Refuse(bus::kTaskStatus.name, View(status.worker), origin, now);
        });
  }
}

void WorkerReports::TakeHealth(const HealthSink& sink, Nanoseconds now) {
  for (auto& [partition, readers] : readers_) {
    readers.health.TakeAll(
        [&](const intaglio_ServiceHealth& health, const bus::SampleOrigin& origin) {
          if (host::IsOwnHealth(health, origin)) {
            if (!origin.alive) instances_.End(View(health.instance));
            if (!origin.alive || instances_.Admit(View(health.instance)))
              sink(health, origin.alive);
            return;
          }
          Refuse(bus::kServiceHealth.name, View(health.instance), origin, now);
        });
  }
}

void WorkerReports::Refuse(const char* topic, std::string_view named,
                           const bus::SampleOrigin& origin, Nanoseconds now) {
  if (now < next_warning_) return;
  next_warning_ = now + kWarningPeriod;
  host::LogWarning(
      "a {} that names {} is ignored: it was written by another process, the participant "
      "{} of {}; if this is not a test, renew the identities",
      topic, named, origin.writer == nullptr ? "(gone)" : origin.writer->participant,
      origin.writer == nullptr ? "(unknown)" : origin.writer->partition);
}

}  // namespace intaglio::job_service
