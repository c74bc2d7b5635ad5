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

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace intaglio::command_line {

/// What may be typed after a command's name. Refers to its program, as Command does.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option Require() const;
  /// Values from `least` to `most`; whole numbers only when both are.
  Option Within(int smallest, int largest) const;
  Option Within(double smallest, double largest) const;
  /// Values above 0.
  Option Positive() const;
  Option OneOf(const std::vector<std::string>& values) const;
  /// Not together with the other.
  Option Exclude(Option other) const;
  /// Not without the other.
  Option Need(Option other) const;
  /// How many values are taken.
  Option TakeValues(int count) const;
  Option TakeValues(int smallest, int largest) const;
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
};

class Command {
 public:
  Command(CLI::App* app, std::function<int()>* chosen) : app_(app), chosen_(chosen) {}

  Command AddCommand(const std::string& name, const std::string& purpose) const;
  /// `names` as in "--mesh,--model"; without dashes it is a positional argument. T: a
  /// string, path, number, an optional or a vector of one; which of them, program.cc
  /// lists.
  template <typename T>
  Option AddOption(const std::string& names, T& value, const std::string& text) const;
  /// "--record,!--no-record"; T: bool, or int, which takes "--flag{1}" or --flag=2.
  template <typename T>
  Option AddFlag(const std::string& names, T& value, const std::string& text) const;
  /// One that was added before.
  Option OptionOf(const std::string& name) const;
  void SetFooter(const std::string& text) const;
  /// One of its commands has to be given.
  void RequireCommand() const;
  /// The options of the command above are understood here as well.
  void TakeOptionsOfParent() const;
  /// What Program::Run() does when this command was given; the exit code is returned.
  void SetAction(std::function<int()> action) const;

 private:
  CLI::App* app_;
  std::function<int()>* chosen_;
};

class Program {
 public:
  Program(const std::string& name, const std::string& purpose);
  ~Program();

  Command root() { return {app_.get(), &chosen_}; }
  void SetVersion(const std::string& version);

  /// None when the arguments are understood and the program goes on; else the exit code
  /// to end with: 0 after --help and --version, kExitMisunderstood after the error was
  /// printed.
  std::optional<int> Parse(int argc, char** argv);
  /// The same for arguments without the program's name; an error has the code
  /// kInvalidValue.
  Status Parse(std::vector<std::string> words);
  /// The action of the command that was given; without one, shows the help.
  int Run() const;

  static constexpr int kExitMisunderstood = 2;

 private:
  std::unique_ptr<CLI::App> app_;
  std::function<int()> chosen_;
};

}  // namespace intaglio::command_line
