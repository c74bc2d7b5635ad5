#include "services/cli/status/status_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "services/cli/progress/time_left.h"
#include "services/client/figure_text.h"
#include "services/client/job_view.h"
#include "services/client/shop/shop_status.h"
#include "services/platform/bus/open_chain.h"

namespace intaglio::cli {
namespace {

std::string LampText(const MachineStatus& machine) {
  if (machine.lamp() == "warming_up")
    return fmt::format("lamp warms up ({:.0f} %)", 100 * machine.lamp_warm_ratio());
  return "lamp " + machine.lamp();
}

std::string StopText(const MachineStatus& machine) {
  if (machine.stops_held_size() > 0)
    return fmt::format("STOP PRESSED by {}", fmt::join(machine.stops_held(), ", "));
  return machine.stop_released() ? "stop released"
                                 : "STOP of the machine pressed or latched";
}

std::string DoorText(const MachineStatus& machine) {
  if (!machine.door_closed()) return "DOOR OPEN";
  return machine.door_locked() ? "door locked" : "door closed";
}

void AddInterlocks(const MachineStatus& machine, std::vector<std::string>& parts) {
  if (bus::IsChainOpen(machine.key_on(), machine.door_closed(),
                       machine.stop_released())) {
    parts.emplace_back("KEY, DOOR OR STOP OPEN");
    if (!machine.stops_held().empty()) parts.push_back(StopText(machine));
    return;
  }
  parts.emplace_back(machine.key_on() ? "key on" : "KEY OFF");
  parts.push_back(DoorText(machine));
  parts.push_back(StopText(machine));
}

std::string LineOf(const MachineStatus& machine) {
  std::vector<std::string> parts;
  if (machine.other_version()) {
    return fmt::format("{:<10} OTHER VERSION, its state is not understood here\n",
                       machine.cell());
  }
  if (machine.age_s() > client::kStaleAge_s)
    parts.push_back(fmt::format("AS IT WAS {:.0f} s AGO", machine.age_s()));
  if (machine.laser_line_up()) {
    if (!machine.one_line()) parts.push_back(LampText(machine));
    AddInterlocks(machine, parts);
    if (!machine.open_input().empty()) parts.push_back(machine.open_input());
    if (!machine.outputs_on().empty())
      parts.push_back(fmt::format("on: {}", machine.outputs_on()));
    if (machine.safe_state()) parts.emplace_back("safe state");
  } else {
    parts.emplace_back(machine.one_line() ? "LINE DOWN" : "LASER LINE DOWN");
  }
  if (!machine.motion_line_up() && !machine.one_line()) {
    parts.emplace_back("MOTION LINE DOWN");
  } else if (!machine.motion_message().empty()) {
    parts.push_back("stage: " + machine.motion_message());
  }
  if (machine.has_block_stage()) {
    parts.push_back(fmt::format("block stage at {:.3f}, {:.3f} mm",
                                machine.block_stage().x_mm(),
                                machine.block_stage().y_mm()));
  }
  parts.push_back(machine.job() == 0 ? "no job" : fmt::format("job {}", machine.job()));
  return fmt::format("{:<10} {}\n", machine.cell(), fmt::join(parts, ", "));
}

std::string MountedLine(const MachineStatus& machine) {
  if (machine.mounted().empty()) return "";
  return fmt::format("mounted    {:<10} {} ({}, {})\n", machine.cell(), machine.mounted(),
                     machine.mounted_by(), machine.mounted_utc());
}

std::string LineOf(const OpenJob& job, std::time_t now) {
  std::string progress;
  if (job.total() > 0) {
    progress = fmt::format("{} {} / {}", job.stage(), client::GroupedDigits(job.done()),
                           client::GroupedDigits(job.total()));
  }
  std::string line = fmt::format("{:>6}  {:<23} {:<10} {:<26} {}\n", job.job(),
                                 client::StateOf(job.state(), job.armed(), job.message()),
                                 job.cell(), progress, job.name());
  const std::string pace =
      PaceText({job.progress_ratio(), job.left_s()}, job.speed_percent(), now);
  if (!pace.empty()) line += fmt::format("        {}\n", pace);
  if (!job.message().empty()) line += fmt::format("        {}\n", job.message());
  return line;
}

std::string LineOf(const DiskStatus& disk) {
  return fmt::format("{:.1f} GB of {:.1f} GB free{}  {}\n", disk.free_bytes() / 1e9,
                     disk.total_bytes() / 1e9, disk.low() ? ", NEARLY FULL" : "",
                     disk.folder());
}

std::string AgeText(const ShopStatus& status) {
  double age_s = 0;
  for (const MachineStatus& machine : status.machines())
    age_s = std::max(age_s, machine.age_s());
  if (status.machines().empty()) return "";
  return fmt::format(", machines as of {:.1f} s ago", age_s);
}

std::string ServicesText(const ShopStatus& status) {
  std::vector<std::string> names;
  for (const ServiceStatus& service : status.services())
    names.push_back(
        fmt::format("{} {}", service.role(),
                    service.left_out().empty() ? service.state() : "LEFT OUT"));
  return fmt::format("{}\n", fmt::join(names, ", "));
}

}  // namespace

std::string TextOf(const ShopStatus& status, std::time_t now) {
  std::string text = fmt::format("shop       {}, {}{}\n", status.time(),
                                 status.needs_person() ? "NEEDS A PERSON" : "all is well",
                                 AgeText(status));
  for (const MachineStatus& machine : status.machines())
    text += "machine    " + LineOf(machine) + MountedLine(machine);
  for (const DiskStatus& disk : status.disks()) text += "disk       " + LineOf(disk);
  text += "services   " + ServicesText(status);
  text += fmt::format("jobs       {} open, {} ended\n", status.jobs_size(),
                      status.ended_jobs());
  for (const OpenJob& job : status.jobs()) text += LineOf(job, now);
  for (const std::string& need : status.needs()) text += "to do      " + need + "\n";
  return text;
}

}  // namespace intaglio::cli
