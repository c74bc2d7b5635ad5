#include "services/cli/security_command.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <iostream>
#include <memory>

#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/platform/bus/identity.h"
#include "services/platform/security/identity_folders.h"
#include "services/platform/security/roles.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

struct SecurityOptions {
  std::string folder;
  security::ShopOptions shop;
  security::Lifetime lifetime;
};

std::chrono::sys_seconds Now() {
  return std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
}

int PrintFolders(const SecurityOptions& options, const security::ShopOptions& shop) {
  for (const security::Role& role : security::RolesOf(shop.cells)) {
    std::cout << (fs::path(options.folder) / role.name).string() << "\n";
  }
  std::cerr << "valid for " << options.lifetime.identity_days
            << " days; copy each of these folders to the hosts of its role "
               "(docs/deployment.md), and keep "
            << (fs::path(options.folder) / "authority").string()
            << " where nobody else has access\n";
  return client::kExitGood;
}

int New(SecurityOptions options) {
  options.lifetime.now = Now();
  if (options.shop.cells.empty()) options.shop.cells = {"els-03"};
  if (auto made = security::NewIdentities(options.folder, options.shop, options.lifetime);
      !made) {
    return Complain(made.error());
  }
  return PrintFolders(options, options.shop);
}

int Renew(SecurityOptions options) {
  options.lifetime.now = Now();
  const auto shop =
      security::RenewIdentities(options.folder, options.shop.cells, options.lifetime);
  return shop ? PrintFolders(options, *shop) : Complain(shop.error());
}

/// One identity as a program would take it.
bool Check(const fs::path& folder, int domain) {
  const auto identity = bus::ReadIdentity(folder, domain, Now());
  if (!identity) {
    std::cout << identity.error().message << "\n";
    return false;
  }
  std::cout << fmt::format(
      "{}: good for domain {} until {:%Y-%m-%d %H:%M} UTC, {}\n", identity->role, domain,
      fmt::gmtime(std::chrono::system_clock::to_time_t(identity->not_after)),
      identity->folder.string());
  return true;
}

int CheckAll(const SecurityOptions& options) {
  const fs::path folder = options.folder;
  const int domain = options.shop.domains.front();
  std::error_code error;
  if (fs::exists(folder / bus::kCertificateFile, error)) {
    return Check(folder, domain) ? client::kExitGood : client::kExitWrongInput;
  }
  std::vector<fs::path> roles;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.is_directory() && entry.path().filename() != "authority")
      roles.push_back(entry.path());
  }
  if (roles.empty()) {
    return Complain(
        {ErrorCode::kNotFound,
         fmt::format("{} is not an identity and contains none", folder.string()),
         folder.string()});
  }
  std::sort(roles.begin(), roles.end());
  bool good = true;
  for (const fs::path& role : roles) good = Check(role, domain) && good;
  return good ? client::kExitGood : client::kExitWrongInput;
}

int PrintRoles() {
  const auto names = [](const std::vector<security::RoleTopic>& topics) {
    std::vector<std::string> all;
    for (const security::RoleTopic& topic : topics) all.push_back(topic.name);
    return all.empty() ? std::string("nothing") : fmt::format("{}", fmt::join(all, ", "));
  };
  for (const security::Role& role : security::RolesOf({"NAME"})) {
    std::cout << fmt::format("{}\n  writes  {}\n  reads   {}\n", role.name,
                             names(role.writes), names(role.reads));
  }
  return client::kExitGood;
}

void AddDays(command_line::Command command, security::Lifetime& lifetime) {
  command
      .AddOption("--days", lifetime.identity_days,
                 "how long identities and permissions are valid")
      .Within(1, 36500)
      .ShowDefault();
}

}  // namespace

void AddSecurityCommand(command_line::Command app) {
  auto options = std::make_shared<SecurityOptions>();
  command_line::Command group =
      app.AddCommand("security", "manage the identities that may command the machines");
  group.RequireCommand();
  group.SetFooter("Example: intaglio security new shop-keys --cell els-03");
  const auto add = [&](const char* name, const char* text, auto action) {
    command_line::Command command = group.AddCommand(name, text);
    command.SetFooter(fmt::format("Example: intaglio security {}{}", name,
                                  name == std::string("roles") ? "" : " shop-keys"));
    command.SetAction([options, action] { return action(*options); });
    return command;
  };
  const auto add_folder = [&](command_line::Command command, const char* text) {
    command.AddOption("FOLDER", options->folder, text).Require();
  };
  command_line::Command fresh =
      add("new", "make authorities and the identities of all roles", New);
  add_folder(fresh, "an empty or new folder");
  fresh.AddOption("--cell", options->shop.cells,
                  "machines, as named in their profiles; default els-03");
  fresh.AddOption("--domain", options->shop.domains, "control domains of the shop")
      .Within(0, 99)
      .ShowDefault();
  fresh.AddOption("--name", options->shop.name, "name of the shop").ShowDefault();
  AddDays(fresh, options->lifetime);
  fresh
      .AddOption("--authority-days", options->lifetime.authority_days,
                 "how long the authorities are valid")
      .Within(1, 36500)
      .ShowDefault();
  command_line::Command renew =
      add("renew", "make new keys and permissions before the old ones expire", Renew);
  add_folder(renew, "the folder that `new` made");
  renew.AddOption("--cell", options->shop.cells, "machines to add");
  AddDays(renew, options->lifetime);
  command_line::Command check =
      add("check", "check an identity, or all in a folder", CheckAll);
  add_folder(check, "an identity, or a folder of several");
  check.AddOption("--domain", options->shop.domains, "control domain")
      .Within(0, 99)
      .TakeValues(1)
      .ShowDefault();
  add("roles", "print which role writes and reads what",
      [](const SecurityOptions&) { return PrintRoles(); });
}

}  // namespace intaglio::cli
