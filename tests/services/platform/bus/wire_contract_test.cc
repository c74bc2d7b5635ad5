// Whatever was recorded or runs on another host was made with the types of its day. A
// change of a wire type has to be meant: it shows here, and tests/data/idl_types.golden
// is written anew with INTAGLIO_WRITE_GOLDEN=1.

#include <dds/dds.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "services/platform/bus/topics.h"

namespace intaglio {
namespace {

const std::string kGolden = INTAGLIO_SOURCE_DIR "/tests/data/idl_types.golden";

std::string TypeHash(const dds_topic_descriptor_t& type) {
  std::uint64_t hash = 0xcbf29ce484222325u;  // FNV-1a, 64 bits
  for (const char byte : bus::TypeInformationOf(type))
    hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3u;
  return fmt::format("{:016x}", hash);
}

std::string KeysOf(const dds_topic_descriptor_t& type) {
  std::vector<std::string> keys;
  for (std::uint32_t i = 0; i < type.m_nkeys; ++i)
    keys.emplace_back(type.m_keys[i].m_name);
  return keys.empty() ? "-" : fmt::format("{}", fmt::join(keys, ","));
}

const char* ProfileName(bus::Profile profile) {
  constexpr const char* kNames[] = {"command", "state",  "motion", "event",
                                    "stream",  "safety", "bulk"};
  return kNames[static_cast<int>(profile)];
}

std::string Contract() {
  std::string text = "# topic type keys profile domain scope type_hash\n";
  bus::ForEveryTopic([&text](const auto& topic) {
    text +=
        fmt::format("{} {} {} {} {} {} {}\n", topic.name, topic.descriptor->m_typename,
                    KeysOf(*topic.descriptor), ProfileName(topic.profile),
                    topic.domain == bus::DomainKind::kControl ? "control" : "bulk",
                    topic.scope == bus::Scope::kShop   ? "shop"
                    : topic.scope == bus::Scope::kCell ? "cell"
                                                       : "role",
                    TypeHash(*topic.descriptor));
  });
  return text;
}

TEST(WireContract, IsTheOneThatWasAgreed) {
  if (std::getenv("INTAGLIO_WRITE_GOLDEN") != nullptr)
    std::ofstream(kGolden) << Contract();
  std::ifstream file(kGolden);
  std::stringstream golden;
  golden << file.rdbuf();
  EXPECT_EQ(Contract(), golden.str());
}

TEST(WireContract, EveryTypeReportsItsHash) {
  bus::ForEveryTopic([](const auto& topic) {
    EXPECT_GT(topic.descriptor->type_information.sz, 0u) << topic.name;
  });
}

// Nothing but bulk flows in the bulk domain: a full stream there may hold up the rest.
TEST(WireContract, BulkTopicsHaveTheirOwnDomain) {
  std::set<std::string> names;
  bus::ForEveryTopic([&names](const auto& topic) {
    EXPECT_EQ(topic.profile == bus::Profile::kBulk,
              topic.domain == bus::DomainKind::kBulk)
        << topic.name;
    EXPECT_TRUE(names.insert(topic.name).second) << topic.name << " is listed twice";
  });
}

}  // namespace
}  // namespace intaglio
