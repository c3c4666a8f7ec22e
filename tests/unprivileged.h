// SPDX-License-Identifier: BSD-3-Clause
// Tests of what a user may not read or write, run by root.

#ifndef FREEGS_TESTS_UNPRIVILEGED_H_
#define FREEGS_TESTS_UNPRIVILEGED_H_

#include <fcntl.h>
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
      : was_root_(geteuid() == 0) {
    if (!was_root_) return;
    constexpr uid_t kNobody = 65534;
    for (const std::filesystem::path& folder : folders) {
      given_ = chown(folder.c_str(), kNobody, kNobody) == 0 && given_;
    }
    given_ = seteuid(kNobody) == 0 && given_;
    for (const std::filesystem::path& folder : folders) {
      given_ =
          faccessat(AT_FDCWD, folder.c_str(), F_OK, AT_EACCESS) == 0 && given_;
    }
  }
  ~Unprivileged() {
    if (was_root_) {
      EXPECT_EQ(seteuid(0), 0);
    }
  }

  // Not where there are no other users, or where a folder lies in one that
  // nobody else may enter.
  bool works() const { return given_; }

  Unprivileged(const Unprivileged&) = delete;
  Unprivileged& operator=(const Unprivileged&) = delete;

 private:
  bool was_root_;
  bool given_ = true;
};

}  // namespace freegs

#endif  // FREEGS_TESTS_UNPRIVILEGED_H_
