// The schemas of each JSON that a command writes are a contract with scripts:
// docs/schemas.sha256 has the checksum of each, so that a change is one of that file,
// too. INTAGLIO_WRITE_GOLDEN=1 writes it; tests/integration/scripts_test.py validates
// what the commands really write.

#include "services/cli/schemas/json_schema.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openssl/sha.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

#include "proto/shop.pb.h"
#include "services/cli/schemas/command_schemas.h"

namespace intaglio::schemas {
namespace {

using ::testing::HasSubstr;

std::string TextIn(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string ChecksumOf(const std::string& text) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  SHA256(reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest.data());
  std::string checksum;
  for (const unsigned char byte : digest) checksum += fmt::format("{:02x}", byte);
  return checksum;
}

TEST(JsonSchemas, AreThoseOfTheContract) {
  const std::string file = INTAGLIO_SOURCE_DIR "/docs/schemas.sha256";
  std::string made;
  for (const auto& [name, text] : CommandSchemas(INTAGLIO_SOURCE_DIR))
    made += fmt::format("{}  {}\n", ChecksumOf(text), name);
  if (std::getenv("INTAGLIO_WRITE_GOLDEN") != nullptr)
    std::ofstream(file, std::ios::binary) << made;
  EXPECT_EQ(TextIn(file), made)
      << "a schema is another one: scripts that read it may break. When that is meant, "
         "INTAGLIO_WRITE_GOLDEN=1 writes the checksums";
}

TEST(JsonSchemas, AreAllNamedInTheDocuments) {
  const std::string document = TextIn(INTAGLIO_SOURCE_DIR "/docs/cli.md");
  for (const auto& [name, text] : CommandSchemas(INTAGLIO_SOURCE_DIR))
    EXPECT_THAT(document, HasSubstr("schemas/" + name));
}

TEST(JsonSchemas, RequireWhatIsAlwaysWrittenAndGiveTheComments) {
  const std::string text = CommandSchemas(INTAGLIO_SOURCE_DIR).at("event.schema.json");
  EXPECT_THAT(text, HasSubstr("\"required\": [\n    \"time\","));
  EXPECT_THAT(text, HasSubstr("\"description\": \"UTC, ISO 8601, ms\""));
  EXPECT_THAT(text,
              HasSubstr("\"$schema\": \"https://json-schema.org/draft/2020-12/schema\""));
}

// What the rule of a field adds to its comment.
TEST(JsonSchemas, GiveRangesAndDefaults) {
  const std::string text = CommandSchemas(INTAGLIO_SOURCE_DIR).at("job_file.schema.json");
  EXPECT_THAT(text, HasSubstr("0.001..100, default 0.2"));
  EXPECT_THAT(text, HasSubstr("0.01..100, default: the minimum spacing"));
}

}  // namespace
}  // namespace intaglio::schemas
