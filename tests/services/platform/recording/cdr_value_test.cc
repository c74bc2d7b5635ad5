#include "services/platform/recording/cdr_value.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace intaglio::recording {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr char kIdl[] = R"(// A comment.
module shop {
  enum Colour { RED, @value(5) GREEN, BLUE };
  module inner {
    @final struct Place { double x_mm; double y_mm; };
  };
  @final
  struct Thing {
    @key string name;       /* another */
    shop::Colour colour;
    boolean on;
    uint64 number;
    int16 small;
    sequence<double> x;
    sequence<octet, 10> raw;
    inner::Place place;
    octet guid[4];
    sequence<string> words;
  };
};)";

/// Little-endian CDR by hand, from the rules of alignment: the oracle of the decoder.
class ByHand {
 public:
  ByHand() { bytes_ = {std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}}; }
  template <typename T>
  ByHand& operator<<(T value) {
    while ((bytes_.size() - 4) % sizeof(T) != 0) bytes_.push_back({});
    Put(bytes_, value);
    return *this;
  }
  ByHand& Text(const std::string& text) {
    *this << static_cast<std::uint32_t>(text.size() + 1);
    for (const char c : text) bytes_.push_back(std::byte(c));
    bytes_.push_back({});
    return *this;
  }
  const Bytes& bytes() const { return bytes_; }

 private:
  Bytes bytes_;
};

Bytes Thing() {
  ByHand cdr;
  cdr.Text("a \"b\"") << std::int32_t{5} << std::uint8_t{1}
                      << std::numeric_limits<std::uint64_t>::max() << std::int16_t{-3}
                      << std::uint32_t{2} << 1.5 << -2.25 << std::uint32_t{3}
                      << std::uint8_t{7} << std::uint8_t{8} << std::uint8_t{9} << 10.0
                      << 20.0;
  for (std::uint8_t i = 1; i <= 4; ++i) cdr << i;
  cdr << std::uint32_t{2};
  cdr.Text("x").Text("");
  return cdr.bytes();
}

TEST(CdrValue, ReadsEveryKindOfMember) {
  const auto types = ParseIdl(kIdl);
  ASSERT_TRUE(types) << types.error().message;
  const auto value = DecodeCdr(*types, "shop::Thing", Thing());
  ASSERT_TRUE(value) << value.error().message;
  EXPECT_EQ(JsonOf(*value),
            R"({"name":"a \"b\"","colour":"GREEN","on":true,)"
            R"("number":18446744073709551615,"small":-3,"x":[1.5,-2.25],"raw":[7,8,9],)"
            R"("place":{"x_mm":10,"y_mm":20},"guid":[1,2,3,4],"words":["x",""]})");
  EXPECT_THAT(*value->Find("x")->As<std::vector<double>>(), ElementsAre(1.5, -2.25));
}

TEST(CdrValue, CutAnywhereIsAnError) {
  const auto types = ParseIdl(kIdl).value();
  const Bytes bytes = Thing();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto value = DecodeCdr(types, "shop::Thing", ByteView(bytes).first(size));
    ASSERT_FALSE(value) << size;
    EXPECT_FALSE(value.error().message.empty());
  }
}

TEST(CdrValue, LengthsBeyondTheMessageAreRefused) {
  const auto types = ParseIdl("struct S { sequence<double> x; };").value();
  ByHand cdr;
  cdr << std::uint32_t{0xffffffff};
  EXPECT_THAT(DecodeCdr(types, "S", cdr.bytes()).error().message, HasSubstr("longer"));
}

// Doubled 29 times, from nothing: half a thousand million parts.
TEST(CdrValue, PartsWithoutBytesAreBounded) {
  std::string idl = "struct S0 { octet none[0]; };";
  for (int i = 1; i < 30; ++i)
    idl += fmt::format("struct S{} {{ S{} a; S{} b; }};", i, i - 1, i - 1);
  idl += "struct Few { S2 a; };";
  const auto types = ParseIdl(idl).value();
  const Bytes empty = {std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}};
  const auto decoded = DecodeCdr(types, "S29", empty);
  ASSERT_FALSE(decoded);
  EXPECT_EQ(decoded.error().code, ErrorCode::kUnreadable);
  EXPECT_TRUE(DecodeCdr(types, "Few", empty));
}

TEST(CdrValue, OtherByteOrderAndSecondVersion) {
  const auto types = ParseIdl("struct S { uint32 a; double b; };").value();
  // XCDR2: nothing is aligned to more than four bytes.
  const Bytes second = [] {
    Bytes bytes = {std::byte{0}, std::byte{7}, std::byte{0}, std::byte{0}};
    Put<std::uint32_t>(bytes, 9);
    Put(bytes, 0.5);
    return bytes;
  }();
  EXPECT_EQ(JsonOf(DecodeCdr(types, "S", second).value()), R"({"a":9,"b":0.5})");
  Bytes big = {std::byte{0}, std::byte{0}, std::byte{0}, std::byte{0}};
  for (const int byte : {0, 0, 0, 9, 0, 0, 0, 0, 0x3f, 0xe0, 0, 0, 0, 0, 0, 0}) {
    big.push_back(std::byte(byte));
  }
  EXPECT_EQ(JsonOf(DecodeCdr(types, "S", big).value()), R"({"a":9,"b":0.5})");
}

TEST(IdlTypes, WhatIsNotUnderstoodIsNamed) {
  EXPECT_EQ(ParseIdl("union U switch (long) {};").error().value, "union");
  EXPECT_EQ(ParseIdl("struct S { Unknown u; };").error().value, "Unknown");
  EXPECT_EQ(ParseIdl("struct S { uint32 a }").error().code, ErrorCode::kUnreadable);
  EXPECT_FALSE(ParseIdl("module m {"));
}

TEST(IdlTypes, NestsAsDeepAsItUnderstandsAndNoDeeper) {
  EXPECT_EQ(ParseIdl("struct S { sequence<sequence<octet>> a; };").error().value,
            "sequence of sequences");
  std::string deep = "struct S { ";
  for (int i = 0; i < 1'000'000; ++i) deep += "sequence<";
  EXPECT_EQ(ParseIdl(deep).error().value, "sequence of sequences");
  EXPECT_TRUE(ParseIdl("enum E { @value(9223372036854775807) last };"));
}

}  // namespace
}  // namespace intaglio::recording
