#include "services/cli/flags/customer_picture_flags.h"

#include <fmt/format.h>

namespace intaglio::cli {
namespace {

constexpr const char* kInFolder = "customer.png";

}  // namespace

render::CustomerPicture CustomerPictureFlags::Picture() const {
  return {.longer_side_px = size_px,
          .ground = background == "transparent" ? render::Ground::kTransparent
                                                : render::Ground::kDark,
          .name = name};
}

std::filesystem::path CustomerPictureFlags::FileIn(
    const std::filesystem::path& folder) const {
  return file == kInFolder ? folder / kInFolder : std::filesystem::path(file);
}

void AddPictureStyleFlags(command_line::Command command, CustomerPictureFlags& flags) {
  command
      .AddOption("--background", flags.background,
                 "of the customer's picture: dark or transparent")
      .OneOf({"dark", "transparent"})
      .ShowDefault();
  command
      .AddOption("--picture-size", flags.size_px,
                 "longer side of the customer's picture, pixels")
      .Within(render::kMinCustomerPicturePx, render::kMaxCustomerPicturePx)
      .ShowDefault();
}

void AddCustomerPictureFlags(command_line::Command command, CustomerPictureFlags& flags) {
  command.AddFlag(
      fmt::format("--customer-picture{{{}}}", kInFolder), flags.file,
      "a large picture for the customer, without figures, as FILE.png "
      "(--customer-picture=FILE.png); without FILE, customer.png in the folder");
  AddPictureStyleFlags(command, flags);
  command.AddOption("--picture-name", flags.name,
                    "a line below the piece in the customer's picture");
}

}  // namespace intaglio::cli
