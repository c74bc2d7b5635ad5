#include "services/client/shop_flags.h"

namespace intaglio::client {

void AddPrivateShopFlags(command_line::Command command, bus::BusOptions& options,
                         const std::string& identities) {
  command
      .AddOption("--domain", options.control_domain,
                 "DDS domain of the control topics; bulk takes the next one")
      .Within(0, 99)
      .ShowDefault();
  command
      .AddOption("--interface", options.interface,
                 "network interface; lo: this computer only")
      .ShowDefault();
  command.AddOption("--tag", options.tag, "DDS tag, default a private one");
  command.AddOption("--security", options.security, identities)
      .FromEnvironment("INTAGLIO_SECURITY");
}

void AddShopFlags(command_line::Command command, bus::BusOptions& options,
                  const std::string& identities) {
  AddPrivateShopFlags(command, options, identities);
  command.OptionOf("--domain").FromEnvironment("INTAGLIO_DOMAIN");
  command.OptionOf("--interface").FromEnvironment("INTAGLIO_INTERFACE");
  command.OptionOf("--tag")
      .Describe("only participants with the same tag communicate")
      .FromEnvironment("INTAGLIO_TAG");
}

std::vector<std::string> ShopArguments(const bus::BusOptions& options) {
  std::vector<std::string> words = {"--domain", std::to_string(options.control_domain),
                                    "--interface", options.interface};
  if (!options.tag.empty()) words.insert(words.end(), {"--tag", options.tag});
  if (!options.security.empty())
    words.insert(words.end(), {"--security", options.security});
  return words;
}

}  // namespace intaglio::client
