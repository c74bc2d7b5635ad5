#include "services/client/shop/shop_status.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <set>

#include "services/client/job_need.h"
#include "services/client/shop/set_counts.h"
#include "services/client/shop/stop_reset.h"
#include "services/client/shop/work_left.h"
#include "services/history/job_names.h"
#include "services/platform/bus/open_chain.h"
#include "services/platform/host/times/utc_time.h"

namespace intaglio::client {
namespace {

const char* RoleName(intaglio_ServiceRole role) {
  constexpr std::array kNames = {"job-service",  "discretizer",   "sorter",
                                 "synchronizer", "motion-bridge", "recorder",
                                 "replayer",     "console"};
  const auto index = static_cast<std::size_t>(role);
  return index < kNames.size() ? kNames.at(index) : "unknown";
}

const char* ServiceNameOf(const ServiceView& service) {
  return service.is_marker() ? "marker" : RoleName(service.role);
}

const char* HealthName(intaglio_HealthState state) {
  constexpr std::array kNames = {"starting", "ready", "busy", "fault", "stopping"};
  const auto index = static_cast<std::size_t>(state);
  return index < kNames.size() ? kNames.at(index) : "unknown";
}

const char* LampName(const CellSnapshot& cell) {
  if (!cell.has_interlock || !cell.laser_line_up) return "unknown";
  if (!cell.lamp_on) return "off";
  return cell.lamp_warm ? "warm" : "warming_up";
}

class Builder {
 public:
  Builder(const ShopSnapshot& shop, std::chrono::system_clock::time_point now)
      : shop_(shop), now_(now) {}

  ShopStatus Build() {
    status_.set_time(host::UtcText(now_));
    AddServices();
    AddJobs();
    AddMachines();
    AddDisks();
    for (const ShopAlarm& alarm : status_.alarms())
      Need(fmt::format("{}: {}", alarm.source(), alarm.message()));
    status_.set_needs_person(status_.needs_size() > 0);
    return std::move(status_);
  }

 private:
  void Need(const std::string& what) { status_.add_needs(what); }
  void Alarm(const std::string& source, std::uint32_t job, const std::string& message) {
    ShopAlarm& alarm = *status_.add_alarms();
    alarm.set_source(source);
    alarm.set_job(job);
    alarm.set_message(message);
  }

  void AddServices() {
    std::set<intaglio_ServiceRole> roles;
    for (const ServiceView& service : shop_.services) {
      roles.insert(service.role);
      NoteAge(service);
      if (service.role == intaglio_ROLE_SYNCHRONIZER) synchronizers_.insert(service.cell);
      if (service.is_marker()) markers_.insert(service.cell);
      if (service.role == intaglio_ROLE_MOTION_BRIDGE) bridges_.insert(service.cell);
      ServiceStatus& line = *status_.add_services();
      line.set_instance(service.instance);
      line.set_role(ServiceNameOf(service));
      line.set_cell(service.cell);
      line.set_host(service.host);
      line.set_pid(service.pid);
      line.set_state(HealthName(service.state));
      line.set_message(service.message);
      line.set_version(service.version);
      line.set_left_out(service.left_out);
      const bool fault = service.state == intaglio_HEALTH_FAULT;
      // The message of a console is its address.
      if (fault || (!service.message.empty() && service.role != intaglio_ROLE_CONSOLE)) {
        const std::string of_cell = IsOfMachine(service) ? " of " + service.cell : "";
        Alarm(ServiceNameOf(service) + of_cell, 0,
              service.message.empty() ? "reports a fault" : service.message);
      }
    }
    NeedOneVersion();
    for (const intaglio_ServiceRole role :
         {intaglio_ROLE_JOB_SERVICE, intaglio_ROLE_DISCRETIZER, intaglio_ROLE_SORTER}) {
      if (!roles.contains(role)) Need(fmt::format("no {} runs", RoleName(role)));
    }
    if (synchronizers_.empty() && bridges_.empty()) Need("no machine is there");
  }

  void NoteAge(const ServiceView& service) {
    const std::chrono::duration<double> age = shop_.taken_at - service.reported_at;
    double& oldest = age_of_[service.cell];
    oldest = std::max(oldest, age.count());
  }

  // A service that another host has kept from before an upgrade gets no task.
  void NeedOneVersion() {
    const ServiceView* job_service = FindJobService(shop_.services);
    for (const ServiceView& service : shop_.services) {
      if (!HasAnotherVersion(service, job_service)) continue;
      Need(fmt::format(
          "{} on {} has version {}, the job service {}: restart the older one when no "
          "job is engraved; until then it is given nothing to do",
          service.instance, service.host, service.version, job_service->version));
    }
  }

  void AddJobs() {
    for (const JobView& job : shop_.jobs) {
      if (job.ended()) {
        status_.set_ended_jobs(status_.ended_jobs() + 1);
        continue;
      }
      if (job.state != intaglio_JOB_QUEUED) job_of_[job.cell] = job.number;
      AddJob(job);
      if (const std::string need = NeedOf(job); !need.empty()) Need(need);
      if (!job.alarm.empty())
        Alarm(fmt::format("job {}", job.number), job.number, job.alarm);
    }
  }

  void AddJob(const JobView& job) {
    OpenJob& line = *status_.add_jobs();
    line.set_job(job.number);
    line.set_uid(job.uid);
    line.set_name(job.name);
    line.set_cell(job.cell);
    line.set_state(history::StateName(job.state));
    line.set_pause_reason(history::PauseReasonName(job.pause_reason));
    line.set_armed(job.armed);
    const JobView::Progress* stage = StageAtWork(job);
    if (stage != nullptr && job.state != intaglio_JOB_QUEUED) {
      line.set_stage(NameOf(stage->stage));
      line.set_done(ShownCount(stage->done_count));
      line.set_total(ShownCount(stage->total_count));
    }
    AddTimeLeft(job, line);
    SetCounts(job.counts, line);
    line.set_makes(job.makes);
    line.set_message(job.message);
    line.set_alarm(job.alarm);
    line.set_speed_percent(job.speed_percent);
  }

  void AddTimeLeft(const JobView& job, OpenJob& line) {
    const WorkLeft work = WorkLeftOf(job);
    if (work.left_s <= 0) return;
    line.set_progress_ratio(work.share);
    line.set_left_s(work.left_s);
    line.set_ends_utc(EndUtc(now_, work.left_s));
  }

  void AddMachines() {
    std::set<std::string> names = synchronizers_;
    names.insert(bridges_.begin(), bridges_.end());
    for (const std::string& name : names) {
      if (!synchronizers_.contains(name)) Need(name + ": no synchronizer runs");
      if (!bridges_.contains(name) && !markers_.contains(name))
        Need(name + ": no motion-bridge runs");
      const auto found = shop_.cells.find(name);
      AddMachine(name, found == shop_.cells.end() ? CellSnapshot{} : found->second);
    }
  }

  void AddMachine(const std::string& name, const CellSnapshot& cell) {
    MachineStatus& line = *status_.add_machines();
    line.set_cell(name);
    line.set_age_s(age_of_[name]);
    line.set_other_version(HasAnotherVersion(name, shop_.services));
    line.set_one_line(markers_.contains(name));
    line.set_lamp(line.one_line() ? "none" : LampName(cell));
    line.set_lamp_warm_ratio(cell.warm_ratio);
    line.set_rate_hz(cell.rate_hz);
    line.set_laser_line_up(cell.has_interlock && cell.laser_line_up);
    line.set_key_on(cell.key_on);
    line.set_door_closed(cell.door_closed);
    line.set_door_locked(cell.door_locked);
    line.set_open_input(cell.open_input);
    line.set_outputs_on(cell.outputs_on);
    line.set_stop_released(cell.stop_released);
    line.set_safe_state(cell.safe_state);
    line.set_shutters_open(cell.shutters_open);
    for (const host::StopPress& press : cell.stops_held)
      line.add_stops_held(TextOf({press.source, press.number}));
    const bool stage_answers = cell.has_motion &&
                               cell.motion_fault != intaglio_MOTION_LINK_LOST &&
                               cell.motion_fault != intaglio_MOTION_WRONG_CONTROLLER;
    line.set_motion_line_up(line.one_line() ? line.laser_line_up() : stage_answers);
    line.set_motion_message(cell.motion_message);
    if (line.motion_line_up() && cell.has_block_stage) {
      line.mutable_block_stage()->set_x_mm(cell.block_x_mm);
      line.mutable_block_stage()->set_y_mm(cell.block_y_mm);
    }
    if (const auto mount = shop_.mounts.find(name); mount != shop_.mounts.end()) {
      line.set_mounted(TextOf(mount->second.parts));
      line.set_mounted_by(mount->second.operator_name);
      line.set_mounted_utc(mount->second.mounted_utc);
    }
    const auto job = job_of_.find(name);
    if (job != job_of_.end()) line.set_job(job->second);
    NeedAtMachine(name, cell, line);
  }

  void NeedAtMachine(const std::string& name, const CellSnapshot& cell,
                     const MachineStatus& line) {
    if (line.age_s() > kStaleAge_s) {
      Need(
          fmt::format("{}: a service of it has reported nothing for {:.0f} s: see its "
                      "log, and start it again",
                      name, line.age_s()));
    }
    if (cell.stop_pressed) {
      Need(
          fmt::format("{0}: the emergency stop is pressed ({1}): check the machine, then "
                      "intaglio stop {0} --reset",
                      name, fmt::join(line.stops_held(), ", ")));
    }
    // Nobody here understands what it reports about its lines.
    if (line.other_version()) return;
    if (synchronizers_.contains(name) && !line.laser_line_up()) {
      Need(fmt::format("{}: the {} does not answer: check its cable and its power", name,
                       line.one_line() ? "controller" : "laser"));
    }
    if (bridges_.contains(name) && !line.motion_line_up())
      Need(name + ": the stage does not answer: check its cable and its power");
    if (!line.laser_line_up() || line.job() == 0) return;
    if (bus::IsChainOpen(cell.key_on, cell.door_closed, cell.stop_released))
      return Need(fmt::format("{}: {}", name, bus::kChainIsOpen));
    if (!cell.key_on) Need(name + ": the key is off");
    if (!cell.door_closed) Need(name + ": the door is open");
    if (!cell.open_input.empty()) Need(name + ": " + cell.open_input);
    if (!cell.stop_released && !cell.stop_pressed)
      Need(
          fmt::format("{0}: the machine's own emergency stop is pressed or latched: "
                      "release its button, then intaglio stop {0} --reset",
                      name));
  }

  void AddDisks() {
    for (const DiskView& disk : shop_.disks) {
      DiskStatus& line = *status_.add_disks();
      line.set_folder(disk.folder);
      line.set_free_bytes(static_cast<double>(disk.free_bytes));
      line.set_total_bytes(static_cast<double>(disk.total_bytes));
      line.set_low(line.free_bytes() < kLowDiskBytes);
      if (line.low()) {
        Need(fmt::format("the disk of {} is nearly full, {:.1f} MB are free: make room",
                         disk.folder, line.free_bytes() / 1e6));
      }
    }
  }

  const ShopSnapshot& shop_;
  const std::chrono::system_clock::time_point now_;
  ShopStatus status_;
  std::set<std::string> synchronizers_, bridges_;  // cells
  std::set<std::string> markers_;                  // cells, among those of synchronizers_
  std::map<std::string, std::uint32_t> job_of_;    // by cell
  std::map<std::string, double> age_of_;           // s, by cell; of its oldest report
};

}  // namespace

ShopStatus StatusOf(const ShopSnapshot& shop, std::chrono::system_clock::time_point now) {
  return Builder(shop, now).Build();
}

}  // namespace intaglio::client
