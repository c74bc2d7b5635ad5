#include "services/job/checks/accessory_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>

#include "services/job/machine/profile_errors.h"

namespace intaglio {
namespace {

constexpr int kMaxCount = 8;  // the bits of a byte on the line
constexpr std::size_t kMaxName = 40, kMaxRemedy = 200;

void CheckText(const std::string& text, const std::string& path, std::size_t max,
               const char* what, std::vector<Error>& errors) {
  if (text.empty()) return Missing(errors, path, what);
  const bool printable =
      std::ranges::all_of(text, [](char c) { return c >= ' ' && c <= '~'; });
  if (printable && text.size() <= max) return;
  Wrong(errors, path,
        fmt::format("{:?} is not 1 to {} printable ASCII characters; shorten or correct "
                    "it",
                    text, max));
}

// Names and numbers of one kind, each once.
class Taken {
 public:
  Taken(std::string kind, std::vector<Error>& errors)
      : kind_(std::move(kind)), errors_(errors) {}

  void Add(const std::string& path, const std::string& name, std::uint32_t number) {
    CheckText(name, path + ".name", kMaxName, "give it a name, as people call it",
              errors_);
    if (const auto [at, fresh] = names_.try_emplace(name, path);
        !fresh && !name.empty()) {
      Wrong(errors_, path + ".name",
            fmt::format("{:?} is already the name of {}; give another one", name,
                        at->second));
    }
    // 0 is out of its range, which is an error of its own.
    if (const auto [at, fresh] = numbers_.try_emplace(number, path);
        !fresh && number != 0) {
      Wrong(
          errors_, fmt::format("{}.{}", path, kind_),
          fmt::format("{} is already that of {}; give another one", number, at->second));
    }
  }

 private:
  std::string kind_;
  std::vector<Error>& errors_;
  std::map<std::string, std::string> names_;
  std::map<std::uint32_t, std::string> numbers_;
};

void CheckCount(int count, const char* field, std::vector<Error>& errors) {
  if (count <= kMaxCount) return;
  Wrong(errors, field,
        fmt::format("{} of them are more than {}; remove some", count, kMaxCount));
}

}  // namespace

void CheckAccessories(const MachineSpec& machine, std::vector<Error>& errors) {
  if (machine.has_mark_line()) {
    for (const auto& [count, field] : {std::pair(machine.outputs_size(), "outputs"),
                                       std::pair(machine.inputs_size(), "inputs")}) {
      if (count == 0) continue;
      Wrong(errors, field,
            "are served by a laser controller alone, and mark_line is given; remove "
            "them, and connect what they switch to the machine's own controller");
    }
    return;
  }
  CheckCount(machine.outputs_size(), "outputs", errors);
  CheckCount(machine.inputs_size(), "inputs", errors);
  Taken outputs("output", errors), inputs("input", errors);
  for (int i = 0; i < machine.outputs_size(); ++i) {
    const MachineOutput& output = machine.outputs(i);
    const std::string path = fmt::format("outputs[{}]", i);
    outputs.Add(path, output.name(), output.output());
    if (OutputTime_IsValid(output.on())) continue;
    Wrong(errors, path + ".on",
          fmt::format("{} is neither OUTPUT_WHILE_ARMED nor OUTPUT_WHILE_ENGRAVING",
                      static_cast<int>(output.on())));
  }
  for (int i = 0; i < machine.inputs_size(); ++i) {
    const MachineInput& input = machine.inputs(i);
    const std::string path = fmt::format("inputs[{}]", i);
    inputs.Add(path, input.name(), input.input());
    CheckText(input.remedy(), path + ".remedy", kMaxRemedy,
              "give what a person does when it is not so, e.g. \"close the clamp\"",
              errors);
    if (InputState_IsValid(input.state())) continue;
    Wrong(errors, path + ".state",
          fmt::format("{} is neither INPUT_ON nor INPUT_OFF",
                      static_cast<int>(input.state())));
  }
}

}  // namespace intaglio
