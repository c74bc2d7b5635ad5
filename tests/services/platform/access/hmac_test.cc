// The test vectors of RFC 4231, chapter 4. Case 5 is of a truncated code, which is not
// used here.

#include "services/platform/access/hmac.h"

#include <gtest/gtest.h>

namespace intaglio::access {
namespace {

std::string Repeated(std::size_t count, char byte) { return std::string(count, byte); }

TEST(Hmac, IsThatOfTheTestVectorsOfRfc4231) {
  std::string counting;
  for (char byte = 1; byte <= 25; ++byte) counting += byte;
  struct Vector {
    std::string secret, message, code;
  };
  const Vector vectors[] = {
      {Repeated(20, '\x0b'), "Hi There",
       "b0344c61d8db38535ca8afceaf0bf12b881dc200c9833da726e9376c2e32cff7"},
      {"Jefe", "what do ya want for nothing?",
       "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843"},
      {Repeated(20, '\xaa'), Repeated(50, '\xdd'),
       "773ea91e36800e46854db8ebd09181a72959098b3ef8c122d9635514ced565fe"},
      {counting, Repeated(50, '\xcd'),
       "82558a389a443c0ea4cc819899f2083a85f0faa3e578f8077a2e3ff46729665b"},
      {Repeated(131, '\xaa'), "Test Using Larger Than Block-Size Key - Hash Key First",
       "60e431591ee0b67f0d8a26aacbf5b77f8e0bc6213728c5140546040f0ee37f54"},
      {Repeated(131, '\xaa'),
       "This is a test using a larger than block-size key and a larger than block-size "
       "data. The key needs to be hashed before being used by the HMAC algorithm.",
       "9b09ffa71b942fcb27635fbcd5b0e944bfdc63644f0713938a7f51535c3a35e2"}};
  for (const Vector& vector : vectors)
    EXPECT_EQ(HmacSha256(vector.secret, vector.message), vector.code);
}

}  // namespace
}  // namespace intaglio::access
