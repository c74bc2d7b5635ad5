#include "services/cli/teach/teach_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <vector>

#include "proto/teach.pb.h"
#include "services/cli/json/print_json.h"
#include "services/cli/teach/mount_command.h"
#include "services/cli/teach/teach_light.h"
#include "services/cli/teach/teach_move.h"
#include "services/cli/teach/teach_options.h"
#include "services/cli/teach/teach_outline.h"
#include "services/cli/teach/teach_pulse.h"
#include "services/cli/terminal/command_outcome.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/job/teach/profile_history.h"

namespace intaglio::cli {
namespace {

using client::TeachClient;
using client::TeachOrder;
using namespace std::chrono_literals;

struct ZeroOptions : TeachOptions {
  std::uint32_t channel = 1;
  std::string lens;
  double height_mm = 0;
  std::string axes = "xyz";
  std::vector<double> by;
};

struct PlaceOptions : TeachOptions {
  bool forget = false;
  std::vector<double> min, max;
};

struct HistoryOptions : TeachOptions {
  std::string file;
};

Vec3 VectorOf(const std::vector<double>& values) {
  return {values[0], values[1], values[2]};
}

int ShowStatus(const TeachOptions& options, const client::MachineView& view) {
  if (!options.json) {
    std::cout << TextOf(view) << std::flush;
    return client::kExitGood;
  }
  TeachStatus status;
  status.set_machine(view.cell);
  for (int i = 0; i < 3; ++i) {
    TeachAxis& axis = *status.add_axes();
    axis.set_name(view.axes[static_cast<std::size_t>(i)]);
    axis.set_unit(view.rotary[static_cast<std::size_t>(i)] ? "rad" : "mm");
    axis.set_position(view.position[i]);
    axis.set_limit_min(view.limit_min[i]);
    axis.set_limit_max(view.limit_max[i]);
  }
  status.set_homed(view.homed);
  status.set_held_by(view.held_by);
  status.set_refusal(view.refusal);
  status.set_interlocks_known(view.interlocks_known);
  status.set_key_on(view.key_on);
  status.set_door_closed(view.door_closed);
  status.set_door_locked(view.door_locked);
  status.set_stop_released(view.stop_released);
  status.set_lamp_on(view.lamp_on);
  status.set_lamp_warm(view.lamp_warm);
  for (std::uint32_t channel = 1; channel <= 4; ++channel) {
    if ((view.shutters_open >> (channel - 1) & 1) != 0) status.add_shutters_open(channel);
  }
  status.set_profile(view.profile);
  status.set_taught_number(view.taught_number);
  return PrintJson(status);
}

void AddStatus(command_line::Command teach) {
  auto options = std::make_shared<TeachOptions>();
  command_line::Command command =
      teach.AddCommand("status", "show axes, limits, interlocks and what is taught");
  AddTeachFlags(command, *options);
  command.AddFlag("--json", options->json, "for programs");
  command.SetFooter("Example: intaglio teach status --json");
  command.SetAction([options] {
    return WithMachine(*options, [&](TeachClient& client) {
      // Key and door come in a sample of their own.
      for (int i = 0; i < 60 && !client.view().interlocks_known; ++i) {
        client.Poll();
        usleep(10000);
      }
      return ShowStatus(*options, client.view());
    });
  });
}

/// "xz": bits 0 and 2; nullopt for other letters.
std::optional<std::uint8_t> BitsOf(const std::string& axes) {
  unsigned bits = 0;
  for (const char axis : axes) {
    if (axis < 'x' || axis > 'z') return std::nullopt;
    bits |= 1u << (axis - 'x');
  }
  if (bits == 0) return std::nullopt;
  return static_cast<std::uint8_t>(bits);
}

int TeachZero(const ZeroOptions& options) {
  const auto bits = BitsOf(options.axes);
  if (!bits) {
    return Complain({ErrorCode::kInvalidValue,
                     fmt::format("--axes: \"{}\" is no choice of x, y and z; give one, "
                                 "as xy",
                                 options.axes),
                     options.axes});
  }
  return WithMachine(options, [&](TeachClient& client) {
    TeachOrder order;
    order.kind = options.by.empty() ? intaglio_TEACH_ZERO : intaglio_TEACH_ZERO_MOVED;
    order.place =
        options.by.empty() ? Vec3(0, 0, options.height_mm) : VectorOf(options.by);
    order.channel = options.channel;
    order.lens = options.lens;
    order.sets = *bits;
    return ExecuteOrder(client, order);
  });
}

void AddZero(command_line::Command teach) {
  auto options = std::make_shared<ZeroOptions>();
  command_line::Command command =
      teach.AddCommand("zero",
                       "the focus is at the block's corner: save it for a channel and "
                       "lens; of a mill or a "
                       "cutter: the tool is at the work zero");
  AddTeachFlags(command, *options);
  command.AddOption("--channel", options->channel, "channel").Within(1, 4).ShowDefault();
  command.AddOption("--lens", options->lens,
                    "name of the mounted lens; default the machine's, if it has one");
  const auto height = command.AddOption(
      "--height", options->height_mm,
      "the focus is at the corner of the top face of a block of this height, mm; default "
      "at the lower corner. Of a mill: the tool is so far above the zero, as on a gauge");
  height.Within(0.0, 1000.0);
  command.AddOption("--axes", options->axes, "the axes that are set, of x, y and z")
      .ShowDefault();
  command
      .AddOption("--by", options->by,
                 "move the zero by x y z instead, mm: the cracks of the next job come "
                 "to lie that much further")
      .TakeValues(3)
      .Exclude(height);
  command.SetFooter(
      "Example: intaglio teach zero --lens f43 --height 40   focus on the top face\n"
      "  intaglio teach zero --lens f43 --by 0.2 0 0         cracks were 0.2 mm too far "
      "left\n"
      "  intaglio teach zero --axes xy                       a mill's tool is over the "
      "corner");
  command.SetAction([options] { return TeachZero(*options); });
}

/// Sample and park position.
void AddPlace(command_line::Command teach, const char* name, const char* purpose,
              intaglio_ManualCommandKind kind) {
  auto options = std::make_shared<PlaceOptions>();
  command_line::Command command = teach.AddCommand(name, purpose);
  AddTeachFlags(command, *options);
  command.AddFlag("--forget", options->forget, "it is not driven to any more");
  command.SetFooter(fmt::format("Example: intaglio teach {}", name));
  command.SetAction([options, kind] {
    return WithMachine(*options, [&](TeachClient& client) {
      TeachOrder order;
      order.kind = kind;
      order.forget = options->forget;
      return ExecuteOrder(client, order);
    });
  });
}

void AddLimits(command_line::Command teach) {
  auto options = std::make_shared<PlaceOptions>();
  command_line::Command command = teach.AddCommand(
      "limits", "show or set the soft limits of jobs and of motion by hand");
  AddTeachFlags(command, *options);
  const auto min =
      command.AddOption("--min", options->min, "lowest coordinates of the three axes");
  min.TakeValues(3);
  const auto max =
      command.AddOption("--max", options->max, "highest coordinates of the three axes");
  max.TakeValues(3).Need(min);
  min.Need(max);
  command.AddFlag("--forget", options->forget, "back to the axes' travel").Exclude(min);
  command.AddFlag("--json", options->json, "for programs");
  command.SetFooter("Example: intaglio teach limits --min 0 0 0 --max 150 150 100");
  command.SetAction([options] {
    return WithMachine(*options, [&](TeachClient& client) {
      if (options->min.empty() && !options->forget)
        return ShowStatus(*options, client.view());
      AnswerWithText();
      TeachOrder order;
      order.kind = intaglio_TEACH_LIMITS;
      order.forget = options->forget;
      if (!options->forget) {
        order.place = VectorOf(options->min);
        order.place_max = VectorOf(options->max);
      }
      return ExecuteOrder(client, order);
    });
  });
}

void AddUndo(command_line::Command teach) {
  auto options = std::make_shared<TeachOptions>();
  command_line::Command command =
      teach.AddCommand("undo", "restore what was taught before the last change");
  AddTeachFlags(command, *options);
  command.SetFooter("Example: intaglio teach undo");
  command.SetAction([options] {
    return WithMachine(*options, [](TeachClient& client) {
      TeachOrder order;
      order.kind = intaglio_TEACH_UNDO;
      return ExecuteOrder(client, order);
    });
  });
}

int ShowHistory(const std::filesystem::path& file, bool json) {
  const auto versions = TaughtHistory(file);
  if (!versions) return Complain(versions.error());
  TaughtHistoryRecord record;
  for (const TaughtVersion& version : *versions) {
    TaughtRecord& entry = *record.add_versions();
    entry.set_number(version.taught().number());
    entry.set_time_utc(version.time_utc());
    entry.set_taught_by(version.taught_by());
    entry.set_change(version.change());
  }
  if (json) return PrintJson(record);
  for (const TaughtRecord& entry : record.versions()) {
    std::cout << fmt::format("{:>4}  {:<24}  {:<20}  {}\n", entry.number(),
                             entry.time_utc(), entry.taught_by(), entry.change());
  }
  return client::kExitGood;
}

void AddHistory(command_line::Command teach) {
  auto options = std::make_shared<HistoryOptions>();
  command_line::Command command =
      teach.AddCommand("history", "list what was taught, oldest first");
  AddTeachFlags(command, *options);
  command.AddOption(
      "--machine", options->file,
      "profile; default that of the machine that is found, on its computer");
  command.AddFlag("--json", options->json, "for programs");
  command.SetFooter("Example: intaglio teach history");
  command.SetAction([options] {
    if (!options->file.empty()) return ShowHistory(options->file, options->json);
    return WithMachine(*options, [&](TeachClient& client) {
      if (!client.view().profile.empty())
        return ShowHistory(client.view().profile, options->json);
      return Complain({ErrorCode::kUnsupported,
                       client.view().cell +
                           " has no history: its work zero is in the controller; see it "
                           "with `intaglio teach status`",
                       ""});
    });
  });
}

}  // namespace

void AddTeachCommand(command_line::Command app, const SubmitFile& submit) {
  command_line::Command teach = app.AddCommand(
      "teach", "move a machine by hand; teach zeros, positions and limits");
  auto options = std::make_shared<TeachOptions>();
  AddTeachFlags(teach, *options);
  teach.SetFooter(
      "Without a command: a screen on which the arrow keys move the machine.\n"
      "Motion ends as soon as this program ends, or is silent for 200 ms. It is refused\n"
      "while a job is armed, and while key, door or a stop is open.\n"
      "Example: intaglio teach");
  teach.SetAction([options] { return WithMachine(*options, ShowTeachScreen); });
  AddStatus(teach);
  AddMoveCommands(teach);
  AddZero(teach);
  AddPlace(teach, "sample", "the axes are at the position before a job: save it",
           intaglio_TEACH_SAMPLE);
  AddPlace(teach, "park", "the axes are at the position after a job: save it",
           intaglio_TEACH_PARK);
  AddLimits(teach);
  AddTestPulseCommands(teach, submit);
  AddLightCommands(teach);
  AddOutlineCommand(teach);
  AddUndo(teach);
  AddHistory(teach);
  AddTeachMount(teach);
}

}  // namespace intaglio::cli
