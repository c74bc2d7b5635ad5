#include "services/platform/host/version/wire_version.h"

#include <google/protobuf/compiler/parser.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <gtest/gtest.h>

#include <regex>

#include "services/platform/host/version/software_version.h"

namespace intaglio::host {
namespace {

namespace pb = google::protobuf;

/// The checksum of a file that imports another one with this text.
std::uint32_t ChecksumOfImport(const std::string& imported) {
  pb::DescriptorPool pool;
  const pb::FileDescriptor* file = nullptr;
  for (const auto& [name, text] :
       {std::pair<std::string, std::string>{"part.proto", imported},
        {"whole.proto", "import \"part.proto\"; message Whole { Part part = 1; }"}}) {
    const std::string source = "syntax = \"proto3\"; " + text;
    pb::io::ArrayInputStream bytes(source.data(), static_cast<int>(source.size()));
    pb::io::Tokenizer tokens(&bytes, nullptr);
    pb::FileDescriptorProto content;
    EXPECT_TRUE(pb::compiler::Parser().Parse(&tokens, &content));
    content.set_name(name);
    file = pool.BuildFile(content);
    EXPECT_NE(file, nullptr);
  }
  return file == nullptr ? 0 : ChecksumOf(*file);
}

TEST(WireVersion, IsTheSoftwareVersionWithAChecksum) {
  EXPECT_TRUE(std::regex_match(WireVersion(), std::regex("[0-9.]+\\+[0-9a-f]{8}")))
      << WireVersion();
  EXPECT_EQ(WireVersion().rfind(std::string(SoftwareVersion()) + "+", 0), 0u);
}

TEST(WireVersion, AFieldMoreIsAnotherVersionAndACommentIsNot) {
  const auto before = ChecksumOfImport("message Part { int32 one = 1; }");
  EXPECT_EQ(ChecksumOfImport("message Part { /* the first */ int32 one = 1; }"), before);
  for (const char* changed :
       {"message Part { int32 one = 1; int32 two = 2; }",
        "message Part { int32 one = 2; }", "message Part { uint32 one = 1; }",
        "message Part { int32 other = 1; }"}) {
    EXPECT_NE(ChecksumOfImport(changed), before) << changed;
  }
}

}  // namespace
}  // namespace intaglio::host
