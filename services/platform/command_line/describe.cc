#include <CLI/CLI.hpp>

#include "services/platform/command_line/program.h"
#include "services/platform/command_line/state.h"

namespace intaglio::command_line {
namespace {

std::vector<std::string> NamesOf(const CLI::Option& option) {
  if (option.get_positional()) return {option.get_name(true, false)};
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

OptionDescription DescriptionOf(const CLI::Option& option, const ProgramState& state) {
  OptionDescription description;
  description.names = NamesOf(option);
  description.meaning = option.get_description();
  description.group = option.get_group();
  if (option.get_type_size_max() > 0) description.value = option.get_type_name();
  if (const auto choices = state.choices.find(&option); choices != state.choices.end()) {
    description.choices = choices->second;
  }
  description.default_value = option.get_default_str();
  description.variable = option.get_envname();
  description.positional = option.get_positional();
  description.required = option.get_required();
  description.repeatable =
      option.get_expected_max() >= CLI::detail::expected_max_vector_size;
  return description;
}

void AddOptions(const CLI::App& app, const ProgramState& state,
                std::vector<OptionDescription>& options) {
  for (const CLI::Option* option : app.get_options()) {
    options.push_back(DescriptionOf(*option, state));
  }
}

CommandDescription DescriptionOf(const CLI::App& app, std::vector<std::string> words,
                                 const ProgramState& state) {
  CommandDescription description;
  description.purpose = app.get_description();
  description.footer = app.get_footer();
  description.acts = state.with_action.contains(&app);
  AddOptions(app, state, description.options);
  if (app.get_fallthrough() && app.get_parent() != nullptr) {
    for (const CLI::Option* option : app.get_parent()->get_options()) {
      if (option->check_lname("help")) continue;
      description.options.push_back(DescriptionOf(*option, state));
    }
  }
  for (const CLI::App* command :
       app.get_subcommands([](const CLI::App*) { return true; })) {
    std::vector<std::string> path = words;
    path.push_back(command->get_name());
    description.commands.push_back(DescriptionOf(*command, std::move(path), state));
  }
  description.words = std::move(words);
  return description;
}

}  // namespace

CommandDescription Program::Describe() const { return DescriptionOf(*app_, {}, *state_); }

}  // namespace intaglio::command_line
