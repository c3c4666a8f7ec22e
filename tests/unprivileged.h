// SPDX-License-Identifier: BSD-3-Clause
// Tests of what a user may not read or write, run by root.

#ifndef FREEGS_TESTS_UNPRIVILEGED_H_
#define FREEGS_TESTS_UNPRIVILEGED_H_

#include <filesystem>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

namespace freegs {

// Root may read everything: gives up its rights while the object lives, after
// giving the folders to nobody. Does nothing for other users.
class Unprivileged {
 public:
  explicit Unprivileged(const std::vector<std::filesystem::path>& folders)
      : active_(geteuid() == 0) {
    if (!active_) return;
    constexpr uid_t kNobody = 65534;
    for (const std::filesystem::path& folder : folders) {
      EXPECT_EQ(chown(folder.c_str(), kNobody, kNobody), 0);
    }
    EXPECT_EQ(seteuid(kNobody), 0);
  }
  ~Unprivileged() {
    if (active_) {
      EXPECT_EQ(seteuid(0), 0);
    }
  }
  Unprivileged(const Unprivileged&) = delete;
  Unprivileged& operator=(const Unprivileged&) = delete;

 private:
  bool active_;
};

}  // namespace freegs

#endif  // FREEGS_TESTS_UNPRIVILEGED_H_
