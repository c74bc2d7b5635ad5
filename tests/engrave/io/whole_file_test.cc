#include "engrave/io/whole_file.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <fstream>
#include <vector>

#include "tests/test_folder.h"

namespace intaglio::io {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class WholeFileTest : public testing::Test {
 protected:
  static Error Refusal(const fs::path& file) {
    const auto bytes = ReadWholeFile(file, 100);
    EXPECT_FALSE(bytes) << file;
    if (bytes) return {};
    EXPECT_THAT(bytes.error().message, HasSubstr(file.string()));
    return bytes.error();
  }
  fs::path folder_ = test::FreshFolder();
};

TEST_F(WholeFileTest, ReadsAFileUpToItsBound) {
  const std::string bytes("a\0b\n", 4);
  std::ofstream(folder_ / "small") << bytes;
  EXPECT_EQ(ReadWholeFile(folder_ / "small", 4), bytes);
  EXPECT_EQ(ReadWholeFile(folder_ / "small", 3).error().code, ErrorCode::kTooLarge);
  std::ofstream(folder_ / "empty") << "";
  EXPECT_EQ(ReadWholeFile(folder_ / "empty", 0), "");
  fs::create_symlink(folder_ / "small", folder_ / "link");
  EXPECT_EQ(ReadWholeFile(folder_ / "link", 4), bytes);
}

TEST_F(WholeFileTest, IsReadInPieces) {
  std::ofstream(folder_ / "letters") << "abcdefgh";
  std::vector<std::string> pieces;
  const auto take = [&](std::span<const std::byte> piece, std::uint64_t size) -> Status {
    EXPECT_EQ(size, 8u);
    pieces.emplace_back(reinterpret_cast<const char*>(piece.data()), piece.size());
    if (pieces.size() == 4) return Fail(ErrorCode::kUnreadable, "is enough");
    return {};
  };
  EXPECT_TRUE(ReadInPieces(folder_ / "letters", 8, 3, take));
  EXPECT_THAT(pieces, ::testing::ElementsAre("abc", "def", "gh"));
  const auto ended = ReadInPieces(folder_ / "letters", 8, 3, take);
  EXPECT_THAT(ended.error().message, HasSubstr("letters: is enough"));
  EXPECT_EQ(ReadInPieces(folder_ / "letters", 7, 3, take).error().code,
            ErrorCode::kTooLarge);
  EXPECT_EQ(ReadInPieces(folder_, 7, 3, take).error().code, ErrorCode::kIo);
  EXPECT_EQ(pieces.size(), 4u);
}

// A FIFO would block until it gets a writer; a device never ends.
TEST_F(WholeFileTest, RefusesWhatIsNoFileAtOnce) {
  ASSERT_EQ(mkfifo((folder_ / "fifo").c_str(), 0600), 0);
  for (const fs::path& file : {folder_, folder_ / "fifo", fs::path("/dev/zero"),
                               fs::path("/dev/tty"), fs::path("/proc/self/fd")}) {
    EXPECT_EQ(Refusal(file).code, ErrorCode::kIo);
    EXPECT_THAT(Refusal(file).message, HasSubstr("name a file"));
  }
  EXPECT_EQ(Refusal(folder_ / "absent").code, ErrorCode::kNotFound);
  EXPECT_EQ(Refusal(folder_ / "fifo" / "below").code, ErrorCode::kNotFound);
  fs::create_symlink(folder_ / "loop", folder_ / "loop");
  EXPECT_EQ(Refusal(folder_ / "loop").code, ErrorCode::kIo);
}

TEST_F(WholeFileTest, ReadsNothingOfAFileThatIsTooLarge) {
  std::ofstream(folder_ / "huge") << "x";
  fs::resize_file(folder_ / "huge", std::uintmax_t{1} << 40);
  EXPECT_EQ(Refusal(folder_ / "huge").code, ErrorCode::kTooLarge);
}

}  // namespace
}  // namespace intaglio::io
