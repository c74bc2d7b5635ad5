#pragma once

#include <filesystem>
#include <string>

#include "engrave/render/customer_picture.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// The picture for the customer, as it is asked for.
struct CustomerPictureFlags {
  std::string file;  ///< empty: none
  std::string background = "dark";
  int size_px = render::CustomerPicture().longer_side_px;
  std::string name;

  bool asked() const { return !file.empty(); }
  render::CustomerPicture Picture() const;
  /// Without a file name, `folder`/customer.png.
  std::filesystem::path FileIn(const std::filesystem::path& folder) const;
};

/// --customer-picture[=FILE], --background, --picture-size, --picture-name.
void AddCustomerPictureFlags(command_line::Command command, CustomerPictureFlags& flags);

/// --background, --picture-size: for the customer's pictures that are made unasked.
void AddPictureStyleFlags(command_line::Command command, CustomerPictureFlags& flags);

}  // namespace intaglio::cli
