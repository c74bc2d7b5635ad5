#include "services/cli/teach/teach_options.h"

#include <gtest/gtest.h>

#include <sstream>

namespace intaglio::cli {
namespace {

TEST(TeachPlace, HasEachAxisWithItsUnit) {
  client::MachineView view;
  view.axes = {"x", "y", "c"};
  view.rotary = {false, false, true};
  view.position = {1.5, -20, 0.25};
  EXPECT_EQ(PlaceText(view), "x 1.5000 mm, y -20.0000 mm, c 0.2500 rad");
}

bool Allows(const std::string& typed, std::string* question = nullptr) {
  std::istringstream in(typed);
  std::ostringstream out;
  const bool allows = AllowsHome(in, out, "mill-2");
  if (question != nullptr) *question = out.str();
  return allows;
}

TEST(TeachHome, IsAllowedByYesAlone) {
  std::string question;
  EXPECT_TRUE(Allows("y\n", &question));
  EXPECT_EQ(question,
            "mill-2 drives its axes to where they count from: is the way free? [y/N] ");
  EXPECT_TRUE(Allows("yes\n"));
  for (const char* typed : {"", "\n", "n\n", "no\n", "yep\n", " \n"})
    EXPECT_FALSE(Allows(typed)) << typed;
}

}  // namespace
}  // namespace intaglio::cli
