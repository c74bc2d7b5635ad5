#include "services/console/arm_holds.h"

#include <fmt/format.h>

#include <algorithm>

#include "services/job/machine/block_fit.h"
#include "services/platform/access/new_key.h"
#include "services/platform/bus/open_chain.h"
#include "services/platform/web/request_rules.h"

namespace intaglio::console {

std::string ArmHolds::Begin(const client::JobView& job, const std::string& block,
                            Clock::time_point now) {
  std::erase_if(holds_, [&](const Hold& hold) { return hold.job.uid == job.uid; });
  if (holds_.size() >= kMaxCount) holds_.pop_front();
  holds_.push_back({access::NewKey(), job, block, now});
  return holds_.back().token;
}

Result<client::JobView> ArmHolds::End(const std::string& token, const std::string& uid,
                                      const std::string& block, Clock::time_point now) {
  const auto refuse = [](const char* why) {
    return Fail(ErrorCode::kRefused,
                fmt::format("{}: check the machine, then press and hold again", why));
  };
  const auto found = std::find_if(holds_.begin(), holds_.end(), [&](const Hold& hold) {
    return web::IsSameKey(hold.token, token);
  });
  if (found == holds_.end()) return refuse("not held, or held before");
  const Hold hold = std::move(*found);
  holds_.erase(found);
  if (hold.job.uid != uid) return refuse("held for another job");
  if (now < hold.begun + kHoldTime) return refuse("not held long enough");
  if (now > hold.begun + kHoldTime + kEndTime) return refuse("held too long ago");
  if (hold.block != block) return refuse("another block is mounted meanwhile");
  return hold.job;
}

Obstacle ObstacleOf(const client::ShopSnapshot& shop, const std::string& cell) {
  if (client::HasAnotherVersion(cell, shop.services)) {
    return {"other_version",
            fmt::format("a service of {} has another version than the job service, so "
                        "that what the machine reports is not understood: restart the "
                        "older one when no job is engraved",
                        cell)};
  }
  const auto found = shop.cells.find(cell);
  if (found == shop.cells.end() || !found->second.has_interlock ||
      !found->second.laser_line_up) {
    return {"line_down", cell +
                             ": the laser does not answer, so it is not known whether "
                             "the door is closed: check its cable and its power"};
  }
  const client::CellSnapshot& machine = found->second;
  if (machine.stop_pressed) {
    return {"stop_pressed",
            fmt::format("{0}: the emergency stop is pressed: check the machine, then "
                        "intaglio stop {0} --reset",
                        cell)};
  }
  if (bus::IsChainOpen(machine.key_on, machine.door_closed, machine.stop_released)) {
    return {"door_open", fmt::format("{}: {}: close them", cell, bus::kChainIsOpen)};
  }
  if (!machine.key_on) return {"key_off", cell + ": the key is off: turn it on"};
  if (!machine.door_closed) return {"door_open", cell + ": the door is open: close it"};
  if (!machine.open_input.empty())
    return {"input_open", fmt::format("{}: {}", cell, machine.open_input)};
  if (BlockIn(shop, cell).empty()) {
    return {"not_mounted",
            fmt::format("{}: nobody has reported what is mounted: {} --block X Y Z "
                        "--glass NAME, or --piece TEXT",
                        cell, MountCommand(cell))};
  }
  return {};
}

std::string BlockIn(const client::ShopSnapshot& shop, const std::string& cell) {
  const auto found = shop.mounts.find(cell);
  return found == shop.mounts.end() ? std::string() : TextOf(found->second.parts);
}

std::string ReportIn(const client::ShopSnapshot& shop, const std::string& cell) {
  const auto found = shop.mounts.find(cell);
  const std::string utc =
      found == shop.mounts.end() ? std::string() : found->second.mounted_utc;
  return fmt::format("{} {}", BlockIn(shop, cell), utc);
}

}  // namespace intaglio::console
