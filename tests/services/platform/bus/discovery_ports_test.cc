#include "services/platform/bus/discovery_ports.h"

#include <gmock/gmock.h>

#include <set>
#include <string>
#include <thread>

#include "services/platform/bus/bus.h"
#include "services/platform/bus/samples.h"
#include "tests/services/platform/bus/child_program.h"

namespace intaglio::bus {
namespace {

using test::ChildProgram;
using test::Eventually;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::UnorderedElementsAre;

// 7400 + 250 * domain, DDSI 2.5, 9.6.1.1.
TEST(DiscoveryPorts, AreThoseOfTheDomain) {
  EXPECT_THAT(internal::DiscoveryPorts(40, "operator"),
              AllOf(HasSubstr("239.255.0.1:17402\""), Not(HasSubstr("<Ports>"))));
  EXPECT_EQ(internal::DiscoveryPorts(40, ""), internal::DiscoveryPorts(40, "observer"));
  EXPECT_THAT(internal::DiscoveryPorts(41, "cell-els-03"),
              AllOf(HasSubstr("239.255.0.1:17650\""),
                    HasSubstr("<MulticastDataOffset>2</MulticastDataOffset>")));
  EXPECT_THAT(internal::DiscoveryPorts(40, "operator", false),
              AllOf(HasSubstr("239.255.0.1:17400\""), Not(HasSubstr(":17402")),
                    HasSubstr("<MulticastMetaOffset>4</MulticastMetaOffset>")));
  // Only what meets no cell by itself.
  EXPECT_EQ(internal::DiscoveryPorts(40, "cell-els-03", false),
            internal::DiscoveryPorts(40, "cell-els-03"));
}

TEST(Announcements, AreRepeatedSlowlyByServicesOfOneComputerAlone) {
  for (const char* service : {"cell-els-03", "job-service", "stage-worker", "recorder"}) {
    EXPECT_THAT(internal::AnnouncementInterval(service, true), HasSubstr(">1600ms<"));
    EXPECT_THAT(internal::AnnouncementInterval(service, false), HasSubstr(">500ms<"));
  }
  for (const char* client : {"", "operator", "submitter", "observer"})
    EXPECT_THAT(internal::AnnouncementInterval(client, true), HasSubstr(">500ms<"));
}

TEST(DiscoveryPorts, OfACellStayInTheDomainAndAreAlikeInItsServicesAlone) {
  std::set<std::string> different;
  constexpr int kCells = 30;
  for (int cell = 0; cell < kCells; ++cell) {
    const std::string text =
        internal::DiscoveryPorts(40, "cell-els-03-" + std::to_string(cell));
    different.insert(text);
    const std::string name = "<MulticastMetaOffset>";
    const int offset = std::stoi(text.substr(text.find(name) + name.size()));
    EXPECT_GE(offset, 20);
    EXPECT_LT(offset, 250);
  }
  // With 30 cells on 200 ports two pairs share one, as a rule (30 * 29 / 2 / 200).
  EXPECT_GE(different.size(), 24u);
}

/// Roles of other processes that this one, with a role, discovers; the instance of each
/// is its role.
class Discovery : public ::testing::Test {
 protected:
  std::set<std::string> Found(const std::string& role, std::size_t expected,
                              bool meets_cells = true) {
    BusOptions options = test::PrivateBusOptions("", role);
    options.meets_cells = meets_cells;
    Bus bus(options);
    Reader<intaglio_ServiceHealth> reader(bus, kServiceHealth);
    std::set<std::string> found;
    const auto take = [&] {
      reader.Take([&](const intaglio_ServiceHealth& health) {
        found.insert(std::string(View(health.instance)));
      });
      return found.size() >= expected;
    };
    EXPECT_TRUE(Eventually(take));
    // Another one would be discovered meanwhile.
    std::this_thread::sleep_for(bus.discovery_time());
    take();
    return found;
  }

  static ChildProgram Peer(const std::string& role) {
    return {INTAGLIO_BUS_PEER, {test::PrivateTag(), "health", role, role}};
  }
  ChildProgram left_ = Peer("cell-left"), right_ = Peer("cell-right"),
               shop_ = Peer("job-service"), client_ = Peer("operator");
};

TEST_F(Discovery, OfAClientHasEverybody) {
  EXPECT_THAT(Found("observer", 4),
              UnorderedElementsAre("cell-left", "cell-right", "job-service", "operator"));
}

TEST_F(Discovery, OfAJobClientHasAllWithoutACell) {
  EXPECT_THAT(Found("submitter", 2, false),
              UnorderedElementsAre("job-service", "operator"));
}

TEST_F(Discovery, OfACellHasItsOwnServicesAndAllWithoutACell) {
  EXPECT_THAT(Found("cell-left", 3),
              UnorderedElementsAre("cell-left", "job-service", "operator"));
}

}  // namespace
}  // namespace intaglio::bus
