#include "services/virtual_engraver/commands.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <sstream>

#include "engrave/core/try.h"

namespace intaglio::virtual_engraver {
namespace {

template <typename T>
std::optional<T> NumberOf(const std::string& text) {
  T value{};
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// The one before frees its name first; a port that was chosen stays the same.
Status PlugIn(Plugs::Plug& plug, const std::string& name) {
  plug.line.reset();
  auto line = INTAGLIO_TRY(OpenMachineLine(plug.device, name));
  plug.line = std::move(line);
  plug.device = plug.line->device();
  return {};
}

std::vector<std::string> TokensOf(const std::string& line) {
  std::istringstream in(line);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

}  // namespace

Status Commands::PlugLaser() {
  INTAGLIO_TRY(PlugIn(plugs_.laser, "laser line"));
  PlugEnd(plugs_.laser.line->MachineEnd());
  return {};
}

void Commands::PlugEnd(std::unique_ptr<link::ByteStream> end) {
  plugs_.one_line ? machine_.PlugOneLine(std::move(end))
                  : machine_.PlugLaserLine(std::move(end));
}

Status Commands::PlugMotion() {
  if (plugs_.one_line) return {};
  INTAGLIO_TRY(PlugIn(plugs_.motion, "motion line"));
  machine_.PlugMotionLine(plugs_.motion.line->MachineEnd());
  return {};
}

void Commands::TakeHangUps() {
  if (plugs_.laser.line && plugs_.laser.line->HostHasGone())
    PlugEnd(plugs_.laser.line->MachineEnd());
  if (plugs_.motion.line && plugs_.motion.line->HostHasGone())
    machine_.PlugMotionLine(plugs_.motion.line->MachineEnd());
}

std::string Commands::Do(const std::string& command) {
  const auto words = TokensOf(command);
  if (words.empty()) return "error empty command";
  const std::string answer = DoCommand(words);
  return answer.empty() ? "error unknown command '" + command + "'; see docs/protocols.md"
                        : answer;
}

std::string Commands::Line(const std::string& verb, const std::string& which) {
  if (which != "laser" && which != "motion") return {};
  const bool laser = which == "laser" || plugs_.one_line;
  if (verb == "unplug") {
    if (laser) {
      machine_.PlugLaserLine(nullptr);
      plugs_.laser.line.reset();
    } else {
      machine_.PlugMotionLine(nullptr);
      plugs_.motion.line.reset();
    }
    return "ok";
  }
  const auto plugged = laser ? PlugLaser() : PlugMotion();
  return plugged ? "ok" : "error " + plugged.error().message;
}

std::string Commands::DoLamp(const std::vector<std::string>& words) {
  if (words.size() == 2 && words[0] == "lamp" && words[1] == "cold") {
    machine_.laser().CoolLamp();
    return "ok";
  }
  if (words.size() != 3 || words[0] != "lamp-sync") return "";
  const auto count = NumberOf<std::uint32_t>(words[2]);
  const auto late_ms = NumberOf<double>(words[2]);
  if (words[1] == "miss" && count && *count <= 100000) {
    machine_.DelaySync(*count / machine_.laser().rate_hz());
    return "ok";
  }
  if (words[1] == "late" && late_ms && *late_ms >= 0 && *late_ms <= 60000) {
    machine_.DelaySync(*late_ms / 1000);
    return "ok";
  }
  return "error lamp-sync miss 0..100000 or late 0..60000, in ms";
}

// A person cannot open a locked door; who forces it still opens the door switch.
std::string Commands::DoDoor(const std::string& verb, const std::string& what) {
  Laser& laser = machine_.laser();
  if (verb == "lock") {
    if (what != "break" && what != "mend") return "";
    laser.BreakLock(what == "break");
    return "ok";
  }
  if (what != "open" && what != "close" && what != "force") return "";
  if (what == "open" && laser.door_locked()) {
    return "error the door is locked while a shutter is open: pause the job, or force it "
           "(door force)";
  }
  laser.SetDoor(what == "close");
  return "ok";
}

std::string Commands::DoInput(const std::vector<std::string>& words) {
  if (words.size() != 3 || (words[2] != "on" && words[2] != "off")) return "";
  const auto number = NumberOf<unsigned>(words[1]);
  const unsigned count = machine_.laser().accessories().input_count;
  if (!number || *number < 1 || *number > count)
    return fmt::format("error input 1..{} on|off: the machine has {} inputs", count,
                       count);
  machine_.laser().SetInput(*number - 1, words[2] == "on");
  return "ok";
}

std::string Commands::DoStage(const std::vector<std::string>& words) {
  const std::string& verb = words[0];
  const std::string what = words.size() > 1 ? words[1] : "";
  if (verb == "unstick") {
    machine_.stage().Unstick();
    return "ok";
  }
  if (verb == "stick" && (what == "all" || what == "x" || what == "y" || what == "z")) {
    machine_.stage().Stick(what == "all" ? -1 : what[0] - 'x');
    return "ok";
  }
  if (verb == "air" && (what == "on" || what == "off")) {
    machine_.stage().SetAir(what == "on");
    return "ok";
  }
  if (verb == "push-block" && words.size() == 3) {
    const auto x_mm = NumberOf<double>(words[1]), y_mm = NumberOf<double>(words[2]);
    if (!x_mm || !y_mm) return "error push-block X Y, in mm";
    machine_.stage().PushBlock({*x_mm, *y_mm});
    return "ok";
  }
  if (verb == "limit" && words.size() == 1) {
    machine_.stage().Fail(link::StageFault::kLimit);
    return "ok";
  }
  if (verb == "buffer" && (what == "starved" || what == "full")) {
    machine_.stage().Fail(what == "full" ? link::StageFault::kBadSequence
                                         : link::StageFault::kStarved);
    return "ok";
  }
  return "";
}

std::string Commands::DoCommand(const std::vector<std::string>& words) {
  const std::string& verb = words[0];
  const std::string what = words.size() > 1 ? words[1] : "";
  const auto either = [&](const char* yes, const char* no) -> std::optional<bool> {
    if (words.size() != 2 || (what != yes && what != no)) return std::nullopt;
    return what == yes;
  };
  if (verb == "status") return "ok " + machine_.StatusLine();
  if (verb == "quit") {
    quit_ = true;
    return "ok";
  }
  if (verb == "key") {
    const auto on = either("on", "off");
    if (on) machine_.laser().SetKey(*on);
    return on ? "ok" : "";
  }
  if (verb == "door" || verb == "lock")
    return DoDoor(verb, words.size() == 2 ? what : "");
  if (verb == "estop") {
    const auto pressed = either("press", "release");
    if (!pressed) return "";
    machine_.laser().SetStopButton(*pressed);
    // The button cuts all drives at once.
    if (*pressed) machine_.stage().Abort();
    return "ok";
  }
  if (const std::string done = DoStage(words); !done.empty()) return done;
  if (verb == "lamp" || verb == "lamp-sync") return DoLamp(words);
  if (verb == "input") return DoInput(words);
  if (verb == "miss" || verb == "blind") {
    const auto count = NumberOf<std::uint64_t>(what);
    if (!count) return "";
    if (verb == "miss") {
      machine_.MissPulses(*count);
    } else if (words.size() == 2) {
      machine_.BlindSensor(*count);
    } else {
      const auto channel = NumberOf<unsigned>(words[2]);
      if (!channel || *channel < 1 || *channel > 4) return "error blind N 1..4";
      machine_.BlindSensor(*count, static_cast<std::uint8_t>(1u << (*channel - 1)));
    }
    return "ok";
  }
  if (verb == "drop-bytes" && words.size() == 3) {
    const auto ratio = NumberOf<double>(what);
    const bool laser = words[2] == "laser";
    const auto& line = (laser ? plugs_.laser : plugs_.motion).line;
    if (!ratio || !(*ratio >= 0 && *ratio <= 1) || !line ||
        (!laser && words[2] != "motion"))
      return "error drop-bytes 0..1 laser|motion";
    line->DropBytes(*ratio, plugs_.seed);
    return "ok";
  }
  if (verb == "clock-drift") {
    const auto drift_ppm = NumberOf<double>(what);
    if (!drift_ppm || !(std::abs(*drift_ppm) <= 200)) {
      return "error clock-drift -200..200, in ppm";
    }
    OwnClock* own = machine_.stage().own_clock();
    if (own == nullptr) {
      return "error the stage counts the laser's ticks: give it a clock of its own by "
             "stage.clock_drift_ppm in the truth file";
    }
    own->SetDrift(*drift_ppm);
    return "ok";
  }
  return verb == "plug" || verb == "unplug" ? Line(verb, what) : "";
}

Result<ScheduledFault> ParseFault(const std::string& text) {
  const auto space = text.find(' ');
  const auto tick = NumberOf<std::uint64_t>(text.substr(0, space));
  if (!tick || space == std::string::npos) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("--fault '{}': write \"AT_TICK COMMAND\", e.g. \"2000 door open\"",
                    text),
        text);
  }
  return ScheduledFault{*tick, text.substr(space + 1)};
}

}  // namespace intaglio::virtual_engraver
