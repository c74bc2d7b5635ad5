#include "services/cli/misspelt.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>

namespace intaglio::cli {
namespace {

TEST(NearestWord, IsWhatWasProbablyMeant) {
  const std::vector<std::string> known = {"submit", "stop", "show", "list"};
  EXPECT_EQ(NearestWord("sumbit", known), "submit") << "two letters changed places";
  EXPECT_EQ(NearestWord("submt", known), "submit") << "left out";
  EXPECT_EQ(NearestWord("lists", known), "list") << "put in";
  EXPECT_EQ(NearestWord("shop", known), "stop") << "nearer ones first, then the first";
  EXPECT_EQ(NearestWord("engrave", known), std::nullopt);
  EXPECT_EQ(NearestWord("ls", known), std::nullopt) << "too short to say";
  EXPECT_EQ(NearestWord("", known), std::nullopt);
  EXPECT_EQ(NearestWord("list", {}), std::nullopt);
}

class UnknownWords : public testing::Test {
 protected:
  UnknownWords() : app_("an app", "intaglio") {
    CLI::App* run = app_.add_subcommand("run");
    run->add_option("--height", height_);
    app_.add_subcommand("recording")->add_subcommand("repair");
  }
  std::string Said(std::vector<std::string> words) {
    std::reverse(words.begin(), words.end());  // as the library takes them
    try {
      app_.parse(words);
    } catch (const CLI::ExtrasError&) {
      return TextOfUnknownWords(app_);
    }
    return "understood";
  }
  double height_ = 0;
  CLI::App app_;
};

TEST_F(UnknownWords, ACommandIsNamedWithTheNearestOne) {
  EXPECT_EQ(
      Said({"rum", "--height", "3"}),
      "intaglio has no command 'rum', did you mean run?; intaglio --help tells what "
      "there is");
  EXPECT_EQ(Said({"engrave"}),
            "intaglio has no command 'engrave'; intaglio --help tells what there is");
}

TEST_F(UnknownWords, AnOptionIsThatOfTheInnermostCommand) {
  EXPECT_EQ(Said({"run", "--hieght=3"}),
            "intaglio run has no option '--hieght', did you mean --height?; intaglio run "
            "--help tells what there is");
  EXPECT_EQ(Said({"recording", "repiar", "x"}),
            "intaglio recording has no command 'repiar', did you mean repair?; intaglio "
            "recording --help tells what there is");
}

TEST_F(UnknownWords, AWordTooManyIsNotTakenForACommand) {
  EXPECT_EQ(
      Said({"run", "--height", "3", "more"}),
      "intaglio run has no use for 'more'; intaglio run --help tells what there is");
  EXPECT_EQ(Said({"run", "--height", "3"}), "understood");
}

}  // namespace
}  // namespace intaglio::cli
