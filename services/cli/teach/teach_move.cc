#include "services/cli/teach/teach_move.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "services/cli/teach/teach_options.h"
#include "services/cli/terminal/complain.h"

namespace intaglio::cli {
namespace {

using client::TeachClient;
using client::TeachOrder;
using namespace std::chrono_literals;

constexpr double kStepSpeedMmS = 10;
// kInterlockTime and kMaxSpeedMmS of services/cell/manual; a test holds the figures
// equal.
constexpr const char* kSpeedHelp =
    "mm/s, at most 50; when key, door and stop are no longer reported, the machine rests "
    "after 0.15 s of it and its braking distance: 7.5 mm and that at 50 mm/s";

/// A command below `teach`: its options, all of TeachOptions among them.
struct MoveOptions : TeachOptions {
  std::string axis;
  double by = 0;
  std::vector<double> to;
  double speed_mm_s = kStepSpeedMmS;
};

struct HomeOptions : TeachOptions {
  bool yes = false;
};

struct ToZeroOptions : TeachOptions {
  std::uint32_t channel = 1;
  std::string lens;
  double height_mm = 0;
  double speed_mm_s = kStepSpeedMmS;
};

/// As long as the whole travel takes, and more.
std::chrono::milliseconds TimeFor(const client::MachineView& view, double speed_mm_s) {
  const double way = (view.limit_max - view.limit_min).norm();
  return std::chrono::milliseconds(
      static_cast<std::int64_t>(1000 * std::min(3600.0, 10 + 2 * way / speed_mm_s)));
}

int MoveTo(TeachClient& client, const Vec3& place, double speed_mm_s) {
  TeachOrder order;
  order.kind = intaglio_MANUAL_MOVE;
  order.place = place;
  order.speed_mm_s = speed_mm_s;
  return ExecuteMove(client, order, TimeFor(client.view(), speed_mm_s));
}

void AddJog(command_line::Command teach) {
  auto options = std::make_shared<MoveOptions>();
  command_line::Command command = teach.AddCommand(
      "jog", "move one axis by a step; let go with Ctrl-C, and the stage rests");
  AddTeachFlags(command, *options);
  command.AddOption("axis", options->axis, "name of the axis: x, y, z").Require();
  command.AddOption("step", options->by, "mm, of a rotary axis rad").Require();
  command.AddOption("--speed", options->speed_mm_s, kSpeedHelp)
      .Within(0.01, 50.0)
      .ShowDefault();
  command.SetFooter("Example: intaglio teach jog x 1.5");
  command.SetAction([options] {
    return WithMachine(*options, [&](TeachClient& client) {
      const auto axis = AxisByName(client.view(), options->axis);
      if (!axis) return Complain(axis.error());
      Vec3 place = client.view().position;
      place[*axis] += options->by;
      return MoveTo(client, place, options->speed_mm_s);
    });
  });
}

void AddMove(command_line::Command teach) {
  auto options = std::make_shared<MoveOptions>();
  command_line::Command command =
      teach.AddCommand("move", "move the axes straight to a place");
  AddTeachFlags(command, *options);
  command.AddOption("place", options->to, "coordinates of the three axes, mm or rad")
      .Require()
      .TakeValues(3);
  command.AddOption("--speed", options->speed_mm_s, kSpeedHelp)
      .Within(0.01, 50.0)
      .ShowDefault();
  command.SetFooter("Example: intaglio teach move 10 20 5 --speed 20");
  command.SetAction([options] {
    return WithMachine(*options, [&](TeachClient& client) {
      return MoveTo(client, {options->to[0], options->to[1], options->to[2]},
                    options->speed_mm_s);
    });
  });
}

// The height has to be given: at the lower corner of a block the lens would meet it.
void AddToZero(command_line::Command teach) {
  auto options = std::make_shared<ToZeroOptions>();
  command_line::Command command = teach.AddCommand(
      "to-zero", "move the focus to the zero of a channel and lens: the block's corner");
  AddTeachFlags(command, *options);
  command.AddOption("--channel", options->channel, "channel").Within(1, 4).ShowDefault();
  command.AddOption("--lens", options->lens,
                    "name of the mounted lens; default the machine's, if it has one");
  command
      .AddOption("--height", options->height_mm,
                 "to the corner of the top face of a block of this height, mm; 0: to the "
                 "table, without a block")
      .Require()
      .Within(0.0, 1000.0);
  command.AddOption("--speed", options->speed_mm_s, kSpeedHelp)
      .Within(0.01, 50.0)
      .ShowDefault();
  command.SetFooter("Example: intaglio teach to-zero --lens f43 --height 40");
  command.SetAction([options] {
    return WithMachine(*options, [&](TeachClient& client) {
      TeachOrder order;
      order.kind = intaglio_MANUAL_ZERO;
      order.place = Vec3(0, 0, options->height_mm);
      order.channel = options->channel;
      order.lens = options->lens;
      order.speed_mm_s = options->speed_mm_s;
      return ExecuteMove(client, order, TimeFor(client.view(), options->speed_mm_s));
    });
  });
}

void AddHome(command_line::Command teach) {
  auto options = std::make_shared<HomeOptions>();
  command_line::Command command = teach.AddCommand(
      "home", "drive to where the axes count from, as the controller does it");
  AddTeachFlags(command, *options);
  command.AddFlag("--yes", options->yes,
                  "the way is free: no question; in a terminal it is asked else");
  command.SetFooter("Example: intaglio teach home --yes");
  command.SetAction([options] {
    return WithMachine(*options, [&](TeachClient& client) {
      const bool asks = !options->yes && isatty(STDIN_FILENO) != 0;
      if (asks && !AllowsHome(std::cin, std::cerr, client.view().cell))
        return Complain({ErrorCode::kCancelled, "not homed: the answer was not y", ""});
      TeachOrder order;
      order.kind = intaglio_MANUAL_HOME;
      return ExecuteMove(client, order, 300s);
    });
  });
}

}  // namespace

void AddMoveCommands(command_line::Command teach) {
  AddJog(teach);
  AddMove(teach);
  AddToZero(teach);
  AddHome(teach);
}

}  // namespace intaglio::cli
