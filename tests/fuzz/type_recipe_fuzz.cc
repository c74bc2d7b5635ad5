// Any text, in lines of "NAME VALUE", as what a recording keeps of a type: an error that
// names the entry, or a descriptor whose parts have the sizes that it names.

#include <dds/dds.h>

#include <cstdint>
#include <sstream>
#include <string>

#include "engrave/core/check.h"
#include "services/platform/bus/type_recipe.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio;
  std::istringstream lines(std::string(reinterpret_cast<const char*>(bytes), size));
  bus::TypeRecipe recipe;
  for (std::string line; std::getline(lines, line);) {
    const auto space = line.find(' ');
    if (space != std::string::npos)
      recipe[line.substr(0, space)] = line.substr(space + 1);
  }
  const auto type = bus::RecipeDescriptor::Parse(recipe);
  if (!type) {
    Require(!type.error().message.empty(), "an error without a sentence");
    return 0;
  }
  const dds_topic_descriptor& made = type->descriptor();
  Require(recipe["name"].starts_with(made.m_typename), "another name");
  std::uint32_t sum = 0;  // every byte can be read
  for (std::uint32_t i = 0; i < recipe["ops"].size() / 8; ++i) sum += made.m_ops[i];
  for (std::uint32_t i = 0; i < made.m_nkeys; ++i)
    sum += static_cast<std::uint32_t>(std::string(made.m_keys[i].m_name).size());
  for (std::uint32_t i = 0; i < made.type_information.sz; ++i)
    sum += made.type_information.data[i];
  for (std::uint32_t i = 0; i < made.type_mapping.sz; ++i)
    sum += made.type_mapping.data[i];
  // So that the compiler leaves the reads in.
  asm volatile("" : : "r"(sum));
  return 0;
}
