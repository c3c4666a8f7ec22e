// SPDX-License-Identifier: BSD-3-Clause
// Writes as much of a COLMAP database as matches between photos need.

#ifndef FREEGS_TESTS_SFM_MATCH_DATABASE_WRITER_H_
#define FREEGS_TESTS_SFM_MATCH_DATABASE_WRITER_H_

#include <cstdint>
#include <filesystem>
#include <sqlite3.h>
#include <vector>

#include <gtest/gtest.h>

namespace freegs::sfm {

class MatchDatabaseWriter {
 public:
  explicit MatchDatabaseWriter(const std::filesystem::path& path) {
    EXPECT_EQ(sqlite3_open(path.c_str(), &database_), SQLITE_OK);
    Execute(
        "CREATE TABLE images(image_id, name);"
        "CREATE TABLE two_view_geometries(pair_id INTEGER PRIMARY KEY, "
        "rows INTEGER, data BLOB, config INTEGER, H BLOB);BEGIN");
  }
  MatchDatabaseWriter(const MatchDatabaseWriter&) = delete;
  MatchDatabaseWriter& operator=(const MatchDatabaseWriter&) = delete;
  ~MatchDatabaseWriter() {
    Execute("COMMIT");
    sqlite3_close(database_);
  }

  // matches: pairs of features. config: 2 for a motion, 6 for a homography.
  // homography: row by row, or nothing.
  void Add(int64_t id1,
           int64_t id2,
           const std::vector<uint32_t>& matches,
           int config = 2,
           const std::vector<double>& homography = {}) {
    sqlite3_stmt* statement = nullptr;
    sqlite3_prepare_v2(database_,
                       "INSERT INTO two_view_geometries VALUES(?, ?, ?, ?, ?)",
                       -1,
                       &statement,
                       nullptr);
    sqlite3_bind_int64(statement, 1, id1 * 2147483647 + id2);
    sqlite3_bind_int64(statement, 2, static_cast<int64_t>(matches.size() / 2));
    sqlite3_bind_blob(statement,
                      3,
                      matches.data(),
                      static_cast<int>(4 * matches.size()),
                      SQLITE_TRANSIENT);
    sqlite3_bind_int(statement, 4, config);
    if (!homography.empty()) {
      sqlite3_bind_blob(statement,
                        5,
                        homography.data(),
                        static_cast<int>(8 * homography.size()),
                        SQLITE_TRANSIENT);
    }
    EXPECT_EQ(sqlite3_step(statement), SQLITE_DONE);
    sqlite3_finalize(statement);
  }

 private:
  void Execute(const char* sql) {
    EXPECT_EQ(sqlite3_exec(database_, sql, nullptr, nullptr, nullptr),
              SQLITE_OK);
  }

  sqlite3* database_ = nullptr;
};

}  // namespace freegs::sfm

#endif  // FREEGS_TESTS_SFM_MATCH_DATABASE_WRITER_H_
