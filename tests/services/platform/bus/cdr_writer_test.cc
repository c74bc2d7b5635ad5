#include "services/platform/bus/cdr_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "services/platform/bus/cdr_sample.h"
#include "services/platform/bus/samples.h"
#include "tests/services/platform/bus/private_bus.h"

namespace intaglio {
namespace {

/// CDR by hand, little endian: the oracle for what the library makes of it.
class Cdr {
 public:
  template <typename T>
  Cdr& Number(T value) {
    bytes_.resize(4 +
                  (bytes_.size() - 4 + sizeof value - 1) / sizeof value * sizeof value);
    const auto* raw = reinterpret_cast<const std::byte*>(&value);
    bytes_.insert(bytes_.end(), raw, raw + sizeof value);
    return *this;
  }
  Cdr& Text(const std::string& text) {
    Number(static_cast<std::uint32_t>(text.size() + 1));
    const auto* raw = reinterpret_cast<const std::byte*>(text.c_str());
    bytes_.insert(bytes_.end(), raw, raw + text.size() + 1);
    return *this;
  }
  const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_ = {std::byte{0}, std::byte{1}, std::byte{0},
                                   std::byte{0}};
};

/// An EmergencyStop.
Cdr Stop(const std::string& cell, std::uint64_t number) {
  Cdr cdr;
  cdr.Text(cell).Text("me").Number(number).Number(std::uint8_t{1});
  cdr.Text("who").Text("why").Number(std::uint32_t{0});  // releases nothing
  return cdr;
}

struct Seen {
  bool alive = false;
  std::int64_t source_ns = 0;
  std::string cell;
  std::uint64_t number = 0;
};

class CdrWriter : public ::testing::Test {
 protected:
  CdrWriter()
      : bus_(test::PrivateBusOptions("els-9")),
        reader_(bus_, bus::kEmergencyStop),
        publisher_(bus_) {
    auto made =
        publisher_.MakeWriter({bus::DomainKind::kControl,
                               bus::kEmergencyStop.name,
                               "els-9",
                               {{"reliability", "reliable"},
                                {"durability", "transient_local"},
                                {"deadline_ns", "200000000"},
                                {"liveliness", "manual_by_topic"},
                                {"lease_ns", "250000000"}}},
                              bus::internal::RecipeOf(*bus::kEmergencyStop.descriptor));
    EXPECT_TRUE(made) << made.error().message;
    writer_ = std::move(*made);
  }
  /// The next one of that kind.
  Seen Await(bool alive) {
    Seen seen;
    EXPECT_TRUE(test::Eventually([&] {
      bool found = false;
      reader_.TakeAll(
          [&](const intaglio_EmergencyStop& sample, const bus::SampleOrigin& origin) {
            if (origin.alive != alive) return;
            found = true;
            seen = {origin.alive, origin.source_ns, std::string(bus::View(sample.cell)),
                    sample.number};
          });
      return found;
    }));
    return seen;
  }
  bus::Bus bus_;
  bus::Reader<intaglio_EmergencyStop> reader_;
  bus::CdrPublisher publisher_;
  std::unique_ptr<bus::CdrWriter> writer_;
};

// The reader asks for lease, deadline and partition: it receives nothing from a writer
// without them.
TEST_F(CdrWriter, TypedReadersGetTheSampleAndItsTime) {
  ASSERT_TRUE(writer_->Write(bus::CdrKind::kValue, Stop("els-9", 77).bytes(), 123456789));
  const Seen seen = Await(true);
  EXPECT_EQ(seen.cell, "els-9");
  EXPECT_EQ(seen.number, 77u);
  EXPECT_EQ(seen.source_ns, 123456789);
}

TEST_F(CdrWriter, EndsInstancesByTheirKey) {
  for (const bus::CdrKind end : {bus::CdrKind::kDisposed, bus::CdrKind::kNoWriter}) {
    ASSERT_TRUE(writer_->Write(bus::CdrKind::kValue, Stop("els-9", 1).bytes(), 1));
    EXPECT_TRUE(Await(true).alive);
    ASSERT_TRUE(writer_->Write(end, Cdr().Text("els-9").Text("me").bytes(), 2));
    EXPECT_EQ(Await(false).cell, "els-9");
  }
}

TEST_F(CdrWriter, BytesThatAreNoSampleAreRefused) {
  auto bytes = Stop("els-9", 1).bytes();
  bytes.resize(bytes.size() - 2);
  EXPECT_FALSE(writer_->Write(bus::CdrKind::kValue, bytes, 1));
  EXPECT_FALSE(writer_->Write(bus::CdrKind::kValue, {}, 1));
}

TEST(CdrSample, IsReadAndEveryCutIsRefused) {
  const auto bytes = Stop("els-9", 42).bytes();
  const auto read =
      bus::CdrSample<intaglio_EmergencyStop>::Read(bus::kEmergencyStop, bytes);
  ASSERT_TRUE(read);
  EXPECT_STREQ((*read)->cell, "els-9");
  EXPECT_EQ((*read)->number, 42u);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(bus::CdrSample<intaglio_EmergencyStop>::Read(
        bus::kEmergencyStop, std::span(bytes).first(size)))
        << size;
  }
}

}  // namespace
}  // namespace intaglio
