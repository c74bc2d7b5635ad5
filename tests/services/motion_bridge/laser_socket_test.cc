// The socket at which a bridge serves a laser, with the system's own sockets; what passes
// over it is checked by laser_output_test.

#include "services/motion_bridge/laser_socket.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <optional>

#include "services/drivers/laser_drivers.h"
#include "tests/patience.h"
#include "tests/services/cell/one_controller.h"
#include "tests/services/cell/one_controller_rig.h"

namespace intaglio::motion_bridge {
namespace {

namespace fs = std::filesystem;
using drivers::LaserController;
using ::testing::HasSubstr;

// The folders of tests are longer than a socket's path may be.
std::string ShortFolder() {
  std::string made = "/tmp/intaglio-laser-XXXXXX";
  return mkdtemp(made.data()) == nullptr ? std::string() : made;
}

class ServedLaser : public ::testing::Test {
 protected:
  ~ServedLaser() override { fs::remove_all(folder); }

  std::unique_ptr<LaserController> NewHost() const {
    MachineSpec profile;
    profile.set_name("els-03");
    profile.mutable_motion_line()->set_protocol("virtual-cell");
    profile.mutable_laser_line()->set_protocol("motion-output");
    profile.mutable_laser_line()->set_device("unix:" + path);
    return drivers::MakeLaserDriver(profile).value();
  }
  bool Until(const std::function<bool()>& condition) {
    return test::Eventually([&] {
      machine.Advance();
      both.Poll();
      socket->Turn();
      for (LaserController* host : {first.get(), second.get()})
        if (host != nullptr) host->Poll([](const auto&) {}, [](const auto&) {});
      return condition();
    });
  }
  void Connect() {
    first = NewHost();
    ASSERT_TRUE(Until([&] { return first->up(); })) << first->message();
    ASSERT_TRUE(first->Reset());
    ASSERT_TRUE(first->Lamp(true, cell::OneMachine::kRateHz));
    ASSERT_TRUE(first->OpenShutters(1));
    ASSERT_TRUE(Until([&] { return machine.laser->shutters() == 1; }));
  }

  std::string folder = ShortFolder(), path = folder + "/own/laser";
  cell::OneMachine machine{cell::StageOfOne(), cell::LaserOfOne()};
  cell::OneController both{machine, cell::kOneSerialNumber};
  std::optional<LaserSocket> socket{std::in_place, both, "unix:" + path};
  std::unique_ptr<LaserController> first, second;
};

TEST_F(ServedLaser, HasOneHostAtATime) {
  Connect();
  second = NewHost();
  EXPECT_TRUE(Until([&] { return !second->message().empty(); }));
  EXPECT_TRUE(Until([&] {
    return second->message().find("it may have another host") != std::string::npos;
  })) << second->message();
  EXPECT_TRUE(first->up());
  EXPECT_EQ(machine.laser->shutters(), 1) << "the first is not disturbed";
  first.reset();
  EXPECT_TRUE(Until([&] { return second->up(); })) << second->message();
}

TEST_F(ServedLaser, IsClosedAsSoonAsItsHostHasGone) {
  Connect();
  first.reset();
  EXPECT_TRUE(Until([&] { return machine.laser->shutters() == 0; }));
}

TEST_F(ServedLaser, IsClosedAndDarkAfterAnOrderlyEnd) {
  Connect();
  socket->Close();
  EXPECT_TRUE(Until([&] { return socket->closed(); }));
  EXPECT_EQ(machine.laser->shutters(), 0);
  EXPECT_EQ(machine.laser->Report().interlocks & link::kLampOn, 0);
  EXPECT_FALSE(fs::exists(path));
}

TEST_F(ServedLaser, HasNoHostWithoutAController) {
  machine.Cut(true);
  first = NewHost();
  EXPECT_TRUE(Until([&] {
    return first->message().find("without an answer") != std::string::npos;
  })) << first->message();
  machine.Cut(false);
  EXPECT_TRUE(Until([&] { return first->up(); })) << first->message();
}

TEST_F(ServedLaser, OnADeviceThatIsNoSocketReportsIt) {
  socket.emplace(both, "/dev/ttyUSB0");
  EXPECT_TRUE(Until([&] { return !socket->message().empty(); }));
  EXPECT_THAT(socket->message(), HasSubstr("/dev/ttyUSB0"));
  EXPECT_THAT(socket->message(), HasSubstr("give unix:/PATH"));
}

}  // namespace
}  // namespace intaglio::motion_bridge
