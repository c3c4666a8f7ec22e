// SPDX-License-Identifier: BSD-3-Clause

#include "core/base64.h"

#include <string>

#include <gtest/gtest.h>

namespace freegs {
namespace {

TEST(Base64Test, VectorsOfTheStandard) {
  // RFC 4648, section 10.
  const std::string text = "foobar";
  const char* encoded[] = {
      "", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"};
  for (size_t n = 0; n <= text.size(); ++n) {
    EXPECT_EQ(EncodeBase64(text.substr(0, n)), encoded[n]);
    EXPECT_EQ(DecodeBase64(encoded[n]).value(), text.substr(0, n));
  }
}

TEST(Base64Test, AllBytesComeBack) {
  std::string bytes;
  for (int i = 0; i < 256; ++i) bytes.push_back(static_cast<char>(i));
  for (size_t n = 250; n <= bytes.size(); ++n) {
    const std::string part = bytes.substr(bytes.size() - n);
    EXPECT_EQ(DecodeBase64(EncodeBase64(part)).value(), part);
  }
}

TEST(Base64Test, RefusesWhatIsNoBase64) {
  for (const char* text : {"Z",
                           "Zg",
                           "Zg=",
                           "Zg===",
                           "====",
                           "Z===",
                           "Zg==Zg==",
                           "Zm 9",
                           "Zm9\n",
                           "Zm9-",
                           "Zh==",
                           "Zm9=",
                           "=Zm9"}) {
    EXPECT_EQ(DecodeBase64(text).status().code(), StatusCode::kBadInput)
        << text;
  }
}

}  // namespace
}  // namespace freegs
