#include "services/cli/teach/teach_light.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <iostream>
#include <memory>

#include "services/cli/teach/teach_options.h"
#include "services/cli/terminal/complain.h"
#include "services/cli/terminal/interrupt.h"
#include "services/client/exit_codes.h"

namespace intaglio::cli {
namespace {

using client::TeachClient;
using client::TeachOrder;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

struct LightOptions : TeachOptions {
  std::uint32_t channel = 1;
  double time_s = 0;  ///< 0: until Ctrl-C
};

/// Until the time is over, Ctrl-C, or an answer that ends it.
int Hold(TeachClient& client, const TeachOrder& order, const LightOptions& options) {
  const std::string name =
      order.kind == intaglio_MANUAL_LAMP
          ? "the lamp is on"
          : fmt::format("the shutter of channel {} is open", order.channel);
  const unsigned mask =
      order.kind == intaglio_MANUAL_LAMP ? 0 : 1U << (order.channel - 1);
  const auto is_on = [&] {
    return mask == 0 ? client.view().lamp_on : (client.view().shutters_open & mask) != 0;
  };
  // A lamp may be on for a job: then it is not this command that holds it.
  const auto is_held = [&] {
    return mask == 0 ? client.view().lamp_by_hand
                     : (client.view().shutters_by_hand & mask) != 0;
  };
  ReportWait wait(client);
  std::uint64_t number = client.Hold(order);
  const auto time = std::chrono::duration<double>(options.time_s);
  std::optional<Clock::time_point> on_since;
  while ((!client.IsAnswered(number) || wait.GivesAgain(order, number)) &&
         Interrupts() == 0) {
    client.Poll();
    if (!on_since && is_held() && is_on()) {
      on_since = Clock::now();
      std::cout << name << "; Ctrl-C ends it\n" << std::flush;
    }
    if (on_since && options.time_s > 0 && Clock::now() - *on_since > time) break;
    usleep(5000);
  }
  const bool ended_by_machine = client.IsAnswered(number);
  client.LetGo();
  for (const auto end = Clock::now() + 2s; is_on() && Clock::now() < end;) {
    client.Poll();
    usleep(5000);
  }
  if (ended_by_machine) {
    return Complain({ErrorCode::kRefused, client.view().message, ""},
                    client::kExitMachine);
  }
  return client::kExitGood;
}

void AddTime(command_line::Command command, LightOptions& options) {
  command.AddOption("--for", options.time_s, "s, default until Ctrl-C")
      .Within(0.1, 3600.0);
}

}  // namespace

void AddLightCommands(command_line::Command teach) {
  auto lamp_options = std::make_shared<LightOptions>();
  command_line::Command lamp = teach.AddCommand(
      "lamp", "switch the lamp on while this command runs; no pulse is fired");
  AddTeachFlags(lamp, *lamp_options);
  AddTime(lamp, *lamp_options);
  lamp.SetFooter("Example: intaglio teach lamp --for 10");
  lamp.SetAction([lamp_options] {
    return WithMachine(*lamp_options, [&](TeachClient& client) {
      TeachOrder order;
      order.kind = intaglio_MANUAL_LAMP;
      return Hold(client, order, *lamp_options);
    });
  });
  auto options = std::make_shared<LightOptions>();
  command_line::Command shutter = teach.AddCommand(
      "shutter", "open a shutter while this command runs; no pulse is fired");
  AddTeachFlags(shutter, *options);
  shutter.AddOption("channel", options->channel, "its channel").Within(1, 4).Require();
  AddTime(shutter, *options);
  shutter.SetFooter("Example: intaglio teach shutter 1");
  shutter.SetAction([options] {
    return WithMachine(*options, [&](TeachClient& client) {
      TeachOrder order;
      order.kind = intaglio_MANUAL_SHUTTER;
      order.channel = options->channel;
      return Hold(client, order, *options);
    });
  });
}

}  // namespace intaglio::cli
