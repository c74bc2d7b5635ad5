#pragma once

// A program with two commands, one of which has commands of its own.

#include <utility>

#include "services/platform/command_line/description.h"

namespace intaglio::command_line {

inline OptionDescription SampleOption(std::vector<std::string> names,
                                      std::string meaning) {
  OptionDescription option;
  option.names = std::move(names);
  option.meaning = std::move(meaning);
  option.group = "Options";
  return option;
}

inline CommandDescription SampleCommand(std::vector<std::string> words,
                                        std::string purpose,
                                        std::vector<OptionDescription> options) {
  CommandDescription command;
  command.words = std::move(words);
  command.purpose = std::move(purpose);
  command.options = std::move(options);
  return command;
}

inline CommandDescription SampleCommands() {
  const auto help = SampleOption({"-h", "--help"}, "Print this help message and exit");
  auto order = SampleOption({"--order"}, "order of the points");
  order.value = "TEXT:{anneal,layers}";
  order.choices = {"anneal", "layers"};
  order.default_value = "anneal";
  auto domain =
      SampleOption({"--domain", "--dds-domain"}, "where the shop's programs meet");
  domain.group = "Of the bus:";
  domain.value = "INT:INT in [0 - 99]";
  domain.variable = "SHOP_DOMAIN";
  domain.required = true;
  auto hidden = SampleOption({"--private"}, "for tests");
  hidden.group = "";
  auto job = SampleOption({"JOB"}, ".textproto file");
  job.value = "TEXT";
  job.positional = true;
  auto recording = SampleCommand({"recording"}, "files of recordings", {help});
  recording.commands = {
      SampleCommand({"recording", "info"}, "what is in it", {help}),
      SampleCommand({"recording", "cut"}, "a span of time", {help, order})};
  auto root = SampleCommand({}, "engraves; it's a sample", {help});
  root.footer = "Where to begin:\n  shop run FILE\n.a line that begins with a dot\n";
  root.commands = {
      SampleCommand({"run"}, "engrave one job", {help, order, domain, hidden, job}),
      recording};
  return root;
}

}  // namespace intaglio::command_line
