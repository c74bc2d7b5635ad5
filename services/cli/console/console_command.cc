#include "services/cli/console/console_command.h"

#include <fmt/format.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>

#include "engrave/core/try.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/client/shop/service_set.h"
#include "services/platform/access/users.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

struct UserOptions {
  std::string name;
  std::string role;
  std::string file = (fs::path("intaglio-shop") / client::kConsoleUsersFile).string();
};

/// What is typed is not shown, until this ends.
class HiddenTyping {
 public:
  HiddenTyping() {
    hidden_ = tcgetattr(STDIN_FILENO, &before_) == 0;
    if (!hidden_) return;
    termios quiet = before_;
    quiet.c_lflag &= ~static_cast<tcflag_t>(ECHO);
    tcsetattr(STDIN_FILENO, TCSAFLUSH, &quiet);
  }
  ~HiddenTyping() {
    if (hidden_) tcsetattr(STDIN_FILENO, TCSAFLUSH, &before_);
  }
  HiddenTyping(const HiddenTyping&) = delete;
  HiddenTyping& operator=(const HiddenTyping&) = delete;

 private:
  termios before_{};
  bool hidden_ = false;
};

std::string AskFor(const char* question) {
  const bool by_person = isatty(STDIN_FILENO) != 0;
  const HiddenTyping hidden;
  if (by_person) std::cerr << question << std::flush;
  std::string line;
  std::getline(std::cin, line);
  if (by_person) std::cerr << "\n";
  return line;
}

/// Asks twice at a terminal; else it is the first line of the standard input.
Result<std::string> AskForPassword() {
  std::string password = AskFor("password: ");
  INTAGLIO_TRY(access::CheckPassword(password));
  if (isatty(STDIN_FILENO) != 0 && AskFor("again: ") != password)
    return Fail(ErrorCode::kInvalidValue, "the two passwords differ: type them again");
  return password;
}

/// None when there is no file yet.
Result<std::vector<access::User>> UsersIn(const std::string& file) {
  auto users = access::ReadUsers(file);
  if (!users && users.error().code == ErrorCode::kNotFound)
    return std::vector<access::User>();
  return users;
}

auto Find(std::vector<access::User>& users, const std::string& name) {
  return std::find_if(users.begin(), users.end(),
                      [&](const access::User& user) { return user.name == name; });
}

Status Add(const UserOptions& options) {
  INTAGLIO_TRY(access::CheckUserName(options.name));
  auto users = INTAGLIO_TRY(UsersIn(options.file));
  const auto role = INTAGLIO_TRY(access::UserRoleNamed(options.role));
  const auto password = INTAGLIO_TRY(AskForPassword());
  const access::User user{options.name, role, access::HashOf(password)};
  const auto before = Find(users, options.name);
  if (before == users.end())
    users.push_back(user);
  else
    *before = user;
  INTAGLIO_TRY(access::WriteUsers(options.file, users));
  std::cout << fmt::format("{} may log in as {} ({})\n", user.name,
                           access::NameOf(user.role), options.file);
  return {};
}

Status Remove(const UserOptions& options) {
  auto users = INTAGLIO_TRY(UsersIn(options.file));
  const auto user = Find(users, options.name);
  if (user == users.end()) {
    return Fail(ErrorCode::kNotFound,
                fmt::format("{} has no user {}: see intaglio console user list",
                            options.file, options.name),
                options.name);
  }
  users.erase(user);
  return access::WriteUsers(options.file, users);
}

Status List(const UserOptions& options) {
  const auto users = INTAGLIO_TRY(UsersIn(options.file));
  for (const access::User& user : users)
    std::cout << user.name << " " << access::NameOf(user.role) << "\n";
  return {};
}

}  // namespace

void AddConsoleCommand(command_line::Command app) {
  auto options = std::make_shared<UserOptions>();
  command_line::Command console =
      app.AddCommand("console", "manage who may log in to the web console");
  console.RequireCommand();
  console.SetFooter("Example: intaglio console user add anna --role operator");
  command_line::Command user =
      console.AddCommand("user", "add, remove and list the people who may log in");
  user.RequireCommand();
  user.SetFooter("Example: intaglio console user list");
  const auto add = [&](const char* name, const char* text, const char* example,
                       Status (*action)(const UserOptions&)) {
    command_line::Command command = user.AddCommand(name, text);
    command
        .AddOption("--users", options->file,
                   "file of the users; of a shop console.users in its folder")
        .ShowDefault();
    command.SetFooter(fmt::format("Example: intaglio console user {} {}", name, example));
    command.SetAction([options, action] {
      const Status done = action(*options);
      return done ? client::kExitGood : Complain(done.error(), client::kExitWrongInput);
    });
    return command;
  };
  command_line::Command fresh =
      add("add",
          "add a user, or change role and password; the password is asked for, or read "
          "from the standard input",
          "anna --role operator", Add);
  fresh.AddOption("NAME", options->name, "of the user").Require();
  fresh
      .AddOption("--role", options->role,
                 "observer: looks, and presses Stop; operator: also commands")
      .OneOf({"observer", "operator"})
      .Require();
  command_line::Command remove =
      add("remove", "remove a user, who is logged out at once", "anna", Remove);
  remove.AddOption("NAME", options->name, "of the user").Require();
  add("list", "list the users with their roles", "", List);
}

}  // namespace intaglio::cli
