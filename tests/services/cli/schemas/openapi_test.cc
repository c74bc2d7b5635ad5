// docs/openapi.json is made of the table of the console's requests.
// INTAGLIO_WRITE_GOLDEN=1 writes it; tests/integration/console_curl_test.py checks real
// answers against it.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

#include "services/cli/schemas/command_schemas.h"
#include "services/cli/schemas/json_schema.h"
#include "services/console/routes.h"

namespace intaglio::schemas {
namespace {

const std::filesystem::path kDocs = std::filesystem::path(INTAGLIO_SOURCE_DIR) / "docs";

Json Text(std::string_view text) { return {std::string(text)}; }
Json Object(Json::Members members) { return {std::move(members)}; }

/// "StopAnswer" -> "stop_answer"; what the command line prints has a name of its own.
std::string SchemaNameOf(std::string_view message) {
  static const std::map<std::string_view, std::string> kNames = {
      {"ShopStatus", "status"}, {"JobList", "jobs"},       {"JobRecord", "job"},
      {"JobReport", "report"},  {"JobHistory", "history"}, {"JobPreview", "preview"},
      {"JobSpec", "job_file"}};
  if (const auto found = kNames.find(message); found != kNames.end())
    return found->second;
  std::string name;
  for (const char c : message) {
    if (std::isupper(c) && !name.empty()) name += '_';
    name += static_cast<char>(std::tolower(c));
  }
  return name;
}

/// The content of a body: a message, or a media type.
Json ContentOf(std::string_view type) {
  if (type.find('/') != std::string_view::npos)
    return Object({{std::string(type), Object({})}});
  static const auto kSchemas = CommandSchemas(INTAGLIO_SOURCE_DIR);
  const std::string name = SchemaNameOf(type) + ".schema.json";
  EXPECT_TRUE(kSchemas.contains(name)) << name;
  const std::string file = "schemas/" + name;
  return Object(
      {{"application/json", Object({{"schema", Object({{"$ref", Text(file)}})}})}});
}

/// What stands in braces in a path.
Json ParametersOf(std::string_view path) {
  static const std::map<std::string, const char*> kParts = {
      {"cell", "name of a machine"},
      {"job", "number or uid"},
      {"id", "of the submission: 1 to 64 letters, digits, '.', '_' and '-'"},
      {"file", "name of a file, as the job file has it"}};
  std::vector<Json> parameters;
  for (auto begin = path.find('{'); begin != std::string_view::npos;
       begin = path.find('{', begin + 1)) {
    const std::string name(path.substr(begin + 1, path.find('}', begin) - begin - 1));
    parameters.push_back(Object({{"name", Text(name)},
                                 {"in", Text("path")},
                                 {"required", Json{true}},
                                 {"description", Text(kParts.at(name))},
                                 {"schema", Object({{"type", Text("string")}})}}));
  }
  return Json{std::move(parameters)};
}

const char* RightText(console::Right right) {
  switch (right) {
    case console::Right::kOpen:
      return "anybody";
    case console::Right::kRead:
      return "who is logged in";
    case console::Right::kOperate:
      return "an operator";
    case console::Right::kCharge:
      return "the operator in charge";
  }
  return "";
}

Json OperationOf(const console::Route& route) {
  Json::Members operation = {{"summary", Text(route.purpose)},
                             {"description", Text(std::string("May be sent by ") +
                                                  RightText(route.right) + ".")}};
  if (route.right == console::Right::kOpen)
    operation.emplace_back("security", Json{std::vector<Json>{}});
  if (!route.request.empty())
    operation.emplace_back("requestBody",
                           Object({{"content", ContentOf(route.request)}}));
  operation.emplace_back(
      "responses",
      Object({{"200", Object({{"description", Text(route.answer)},
                              {"content", ContentOf(route.answer)}})},
              {"default", Object({{"description", Text("refused; docs/console.md has the "
                                                       "status codes")}})}}));
  return Object(std::move(operation));
}

Json PathsOf() {
  Json::Members paths;
  for (const console::Route& route : console::Routes()) {
    auto* path = paths.empty() ? nullptr : &paths.back();
    if (path == nullptr || path->first != route.path) {
      Json::Members members;
      if (route.path.find('{') != std::string_view::npos)
        members.emplace_back("parameters", ParametersOf(route.path));
      paths.emplace_back(std::string(route.path), Object(std::move(members)));
      path = &paths.back();
    }
    std::get<Json::Members>(path->second.held)
        .emplace_back(route.method == "GET" ? "get" : "post", OperationOf(route));
  }
  return Object(std::move(paths));
}

Json DocumentOf() {
  const auto scheme = [](Json::Members members) { return Object(std::move(members)); };
  return Object(
      {{"openapi", Text("3.1.0")},
       {"info", Object({{"title", Text("The web console of Intaglio")},
                        {"version", Text("1")},
                        {"description", Text("Made from services/console/routes.cc.")}})},
       {"security",
        Json{std::vector<Json>{Object({{"key", Json{std::vector<Json>{}}}}),
                               Object({{"session", Json{std::vector<Json>{}}}})}}},
       {"paths", PathsOf()},
       {"components",
        Object({{"securitySchemes",
                 Object({{"key",
                          scheme({{"type", Text("http")}, {"scheme", Text("bearer")}})},
                         {"session", scheme({{"type", Text("apiKey")},
                                             {"in", Text("cookie")},
                                             {"name", Text("intaglio_PORT")}})}})}})}});
}

TEST(OpenApi, IsMadeOfTheTableOfRequests) {
  const std::filesystem::path file = kDocs / "openapi.json";
  const std::string text = DocumentOf().Text() + "\n";
  if (std::getenv("INTAGLIO_WRITE_GOLDEN") != nullptr)
    std::ofstream(file, std::ios::binary) << text;
  std::ifstream in(file, std::ios::binary);
  const std::string there{std::istreambuf_iterator<char>(in), {}};
  EXPECT_TRUE(there == text) << file
                             << " is not what follows from the table: write it with "
                             << "INTAGLIO_WRITE_GOLDEN=1";
}

}  // namespace
}  // namespace intaglio::schemas
