#include <cstdint>
#include <string_view>

#include "engrave/contour/files/project_file.h"
#include "engrave/core/check.h"

// A project is refused with its file, or written and read again it is the same text.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using intaglio::Require;
  using intaglio::contour::ReadProject;
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  const auto project = ReadProject(text, "a.xml");
  if (!project) {
    Require(project.error().message.starts_with("a.xml: "), "an error without the file");
    return 0;
  }
  (void)intaglio::contour::BoardOf(*project);
  const std::string written = intaglio::contour::WriteProject(*project);
  const auto again = ReadProject(written, "b.xml");
  Require(again.has_value(), "what was written is not read: {}",
          again ? "" : again.error().message);
  Require(intaglio::contour::WriteProject(*again) == written, "another text");
  return 0;
}
