#pragma once

// The command line of a program: its commands, and their options, flags and positional
// arguments.
//
//   command_line::Program program("intaglio", "A mesh goes in.");
//   command_line::Command list = program.root().AddCommand("list", "the jobs of a shop");
//   list.AddOption("--folder", folder, "of the shop").ShowDefault();
//   list.SetAction([&folder] { return List(folder); });
//   if (const auto exit_code = program.Parse(argc, argv)) return *exit_code;
//   return program.Run();
//
// CLI11 does the work. Each file that included it would take seconds to compile, so it
// is seen by program.cc alone.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "services/platform/command_line/description.h"

namespace CLI {
class App;
class Error;
class Option;
}  // namespace CLI

namespace intaglio::command_line {

struct ProgramState;

/// What may be typed after a command's name. Refers to its program, as Command does.
class Option {
 public:
  Option(CLI::Option* option, ProgramState* state) : option_(option), state_(state) {}

  Option Require() const;
  /// Values from `smallest` to `largest`; whole numbers only when both are.
  Option Within(int smallest, int largest) const;
  Option Within(double smallest, double largest) const;
  /// Values above 0.
  Option Positive() const;
  Option OneOf(const std::vector<std::string>& values) const;
  /// Not together with the other.
  Option Exclude(Option other) const;
  /// Not without the other.
  Option Need(Option other) const;
  /// How many values are taken. Several may be one word, XxYxZ or X,Y,Z
  /// (joined_values.h).
  Option TakeValues(int count) const;
  Option TakeValues(int smallest, int largest) const;
  /// Of a vector: one value after each of its names, which may be repeated; what follows
  /// is another argument.
  Option TakeOneAtATime() const;
  /// Of values in one argument: "1,2,3".
  Option SplitAt(char separator) const;
  /// --help shows the variable's present value.
  Option ShowDefault() const;
  /// The variable of the environment that counts when the option is not given.
  Option FromEnvironment(const std::string& variable) const;
  Option Describe(const std::string& text) const;
  /// Under which heading --help shows it.
  Option Group(const std::string& heading) const;

 private:
  CLI::Option* option_;
  ProgramState* state_;
};

class Command {
 public:
  Command(CLI::App* app, ProgramState* state) : app_(app), state_(state) {}

  Command AddCommand(const std::string& name, const std::string& purpose) const;
  /// `names` as in "--mesh,--model"; without dashes it is a positional argument. T: a
  /// string, path, number, an optional or a vector of one; which of them, program.cc
  /// lists.
  template <typename T>
  Option AddOption(const std::string& names, T& value, const std::string& text) const;
  /// "--record,!--no-record"; T: bool, or int or string, which takes "--flag{1}" or
  /// --flag=2.
  template <typename T>
  Option AddFlag(const std::string& names, T& value, const std::string& text) const;
  /// One that was added before.
  Option OptionOf(const std::string& name) const;
  bool HasOption(const std::string& name) const;
  /// "recording info"; of the program "".
  std::string path() const;
  /// Those directly below it.
  std::vector<Command> commands() const;
  /// SetAction() was called.
  bool acts() const;
  void SetFooter(const std::string& text) const;
  /// One of its commands has to be given.
  void RequireCommand() const;
  /// The options of the command above are understood here as well.
  void TakeOptionsOfParent() const;
  /// What Program::Run() does when this command was given, and none below it that has an
  /// action; the exit code is returned.
  void SetAction(std::function<int()> action) const;

 private:
  CLI::App* app_;
  ProgramState* state_;
};

class Program {
 public:
  Program(const std::string& name, const std::string& purpose);
  ~Program();

  Command root() { return {app_.get(), state_.get()}; }
  void SetVersion(const std::string& version);
  /// `PROGRAM help [COMMAND]...` prints what `PROGRAM COMMAND --help` does.
  void AddHelpCommand();
  /// Its commands and options as data.
  CommandDescription Describe() const;
  /// Errors of a command line that has this flag, as "--json", go to `refuse`, and no
  /// text for people is printed.
  void SetRefusal(const std::string& flag, std::function<void(const Error&)> refuse);
  /// Runs the action of the command that was given, in place of a plain call. The exit
  /// code is returned.
  void SetRunner(std::function<int(const std::function<int()>& action)> runner);
  /// Whether the last parse found this option behind the command that was given, or
  /// behind one above it.
  bool IsGiven(const std::string& option) const;

  /// None when the arguments are understood and the program goes on; else the exit code
  /// to end with: 0 after --help and --version, kExitMisunderstood after the error was
  /// printed, which may be a limit of the system (open_files.h).
  std::optional<int> Parse(int argc, char** argv);
  /// The same for arguments without the program's name; an error has the code
  /// kInvalidValue, or kMissing for a required option.
  Status Parse(const std::vector<std::string>& words);
  /// The action of the command that was given; without one, shows the help.
  int Run() const;

  static constexpr int kExitMisunderstood = 2;

 private:
  void ParseDivided(const std::vector<std::string>& words);
  int ShowHelp() const;
  /// The exit code, after the error was printed.
  int Refuse(const std::vector<std::string>& words, const Error& error,
             const std::function<void()>& print) const;
  /// About what the parse did not know; "" when the error is another one.
  std::string UnknownIn(const CLI::Error& error) const;

  std::unique_ptr<CLI::App> app_;
  std::unique_ptr<ProgramState> state_;
};

}  // namespace intaglio::command_line
