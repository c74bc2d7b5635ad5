#include "services/console/shop_metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

namespace intaglio::console {
namespace {

using namespace std::chrono_literals;

constexpr auto kMaxGap = 2s;

std::string Escaped(std::string_view value) {
  std::string text;
  for (const char c : value) {
    if (c == '\\' || c == '"') text += '\\';
    if (c == '\n')
      text += "\\n";
    else
      text += c;
  }
  return text;
}

void Head(std::string& text, const char* name, const char* kind, const char* help) {
  text += fmt::format("# HELP {0} {2}\n# TYPE {0} {1}\n", name, kind, help);
}

/// 1 or 0 of every machine.
void Flag(std::string& text, const ShopStatus& shop, const char* name, const char* help,
          bool (*flag)(const MachineStatus&)) {
  Head(text, name, "gauge", help);
  for (const MachineStatus& machine : shop.machines())
    text += fmt::format("{}{{machine=\"{}\"}} {}\n", name, Escaped(machine.cell()),
                        flag(machine) ? 1 : 0);
}

void AddMachines(std::string& text, const ShopStatus& shop) {
  Flag(text, shop, "intaglio_laser_line_up", "1: the laser answers",
       [](const MachineStatus& one) { return one.laser_line_up(); });
  Flag(text, shop, "intaglio_motion_line_up", "1: the stage answers",
       [](const MachineStatus& one) { return one.motion_line_up(); });
  Flag(text, shop, "intaglio_door_closed", "1: closed, as the laser reports",
       [](const MachineStatus& one) { return one.laser_line_up() && one.door_closed(); });
  Flag(text, shop, "intaglio_stop_pressed", "1: an emergency stop of the bus is pressed",
       [](const MachineStatus& one) { return one.stops_held_size() > 0; });
}

void AddJobs(std::string& text, const ShopStatus& shop) {
  Head(text, "intaglio_jobs", "gauge", "open jobs by state");
  std::map<std::string, int> counts;
  for (const OpenJob& job : shop.jobs()) ++counts[job.state()];
  for (const auto& [state, count] : counts)
    text += fmt::format("intaglio_jobs{{state=\"{}\"}} {}\n", Escaped(state), count);
}

}  // namespace

std::string OccupationOf(const MachineStatus& machine, const ShopStatus& shop) {
  if (machine.other_version() || !machine.laser_line_up() || !machine.motion_line_up())
    return "unknown";
  if (machine.stops_held_size() > 0) return "stopped";
  const auto job =
      std::find_if(shop.jobs().begin(), shop.jobs().end(), [&](const OpenJob& one) {
        return machine.job() != 0 && one.job() == machine.job();
      });
  if (job == shop.jobs().end()) return "idle";
  if (!job->pause_reason().empty()) return "paused_" + job->pause_reason();
  if (job->state() == "engraving" && !job->alarm().empty()) return "no_progress";
  return job->state();
}

void ShopMetrics::Follow(const ShopStatus& shop, Clock::time_point now) {
  const auto passed = now - followed_;
  if (followed_ != Clock::time_point() && passed <= kMaxGap) {
    for (const MachineStatus& machine : shop_.machines()) {
      seconds_[{machine.cell(), OccupationOf(machine, shop_)}] +=
          std::chrono::duration<double>(passed).count();
    }
  }
  followed_ = now;
  shop_ = shop;
}

void ShopMetrics::CountPiece(const std::string& cell, const std::string& verdict) {
  ++pieces_[{cell, verdict.empty() ? "none" : verdict}];
}

std::string ShopMetrics::Text() const {
  std::string text;
  Head(text, "intaglio_machine_seconds_total", "counter", "time of a machine by use");
  for (const auto& [labels, seconds] : seconds_) {
    text +=
        fmt::format("intaglio_machine_seconds_total{{machine=\"{}\",use=\"{}\"}} {}\n",
                    Escaped(labels.first), Escaped(labels.second), seconds);
  }
  Head(text, "intaglio_pieces_total", "counter", "jobs that ended, by verdict");
  for (const auto& [labels, count] : pieces_) {
    text += fmt::format("intaglio_pieces_total{{machine=\"{}\",verdict=\"{}\"}} {}\n",
                        Escaped(labels.first), Escaped(labels.second), count);
  }
  AddMachines(text, shop_);
  AddJobs(text, shop_);
  Head(text, "intaglio_needs", "gauge", "what waits for a person");
  text += fmt::format("intaglio_needs {}\n", shop_.needs_size());
  Head(text, "intaglio_alarms", "gauge", "alarms that are raised");
  return text + fmt::format("intaglio_alarms {}\n", shop_.alarms_size());
}

}  // namespace intaglio::console
