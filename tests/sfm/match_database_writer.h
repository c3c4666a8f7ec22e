// SPDX-License-Identifier: BSD-3-Clause
// Writes as much of a COLMAP database as matches between photos need.

#ifndef FREEGS_TESTS_SFM_MATCH_DATABASE_WRITER_H_
#define FREEGS_TESTS_SFM_MATCH_DATABASE_WRITER_H_

#include <cstdint>
#include <filesystem>
#include <sqlite3.h>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace freegs::sfm {

class MatchDatabaseWriter {
 public:
  explicit MatchDatabaseWriter(const std::filesystem::path& path) {
    EXPECT_EQ(sqlite3_open(path.c_str(), &database_), SQLITE_OK);
    Execute(
        "CREATE TABLE images(image_id, name);"
        "CREATE TABLE keypoints(image_id INTEGER PRIMARY KEY, rows INTEGER, "
        "cols INTEGER, data BLOB);"
        "CREATE TABLE two_view_geometries(pair_id INTEGER PRIMARY KEY, rows "
        "INTEGER, data BLOB, config INTEGER, H BLOB, F BLOB);BEGIN");
  }
  MatchDatabaseWriter(const MatchDatabaseWriter&) = delete;
  MatchDatabaseWriter& operator=(const MatchDatabaseWriter&) = delete;
  ~MatchDatabaseWriter() {
    Execute("COMMIT");
    sqlite3_close(database_);
  }

  // features: x and y of each.
  void AddPhoto(int64_t id,
                const std::string& name,
                const std::vector<float>& features) {
    Row photo(database_, "INSERT INTO images VALUES(?, ?)");
    photo.Bind(1, id);
    sqlite3_bind_text(photo.statement(), 2, name.c_str(), -1, SQLITE_TRANSIENT);
    photo.Insert();
    Row row(database_, "INSERT INTO keypoints VALUES(?, ?, 2, ?)");
    row.Bind(1, id);
    row.Bind(2, static_cast<int64_t>(features.size() / 2));
    row.Bind(3, features);
    row.Insert();
  }

  // matches: pairs of features. config: 2 for a motion, 6 for a homography.
  // homography and fundamental matrix: row by row, or nothing.
  void Add(int64_t id1,
           int64_t id2,
           const std::vector<uint32_t>& matches,
           int config = 2,
           const std::vector<double>& homography = {},
           const std::vector<double>& fundamental = {}) {
    Row row(database_,
            "INSERT INTO two_view_geometries VALUES(?, ?, ?, ?, ?, ?)");
    row.Bind(1, id1 * 2147483647 + id2);
    row.Bind(2, static_cast<int64_t>(matches.size() / 2));
    row.Bind(3, matches);
    row.Bind(4, config);
    row.Bind(5, homography);
    row.Bind(6, fundamental);
    row.Insert();
  }

 private:
  // A row that is inserted.
  class Row {
   public:
    Row(sqlite3* database, const char* sql) {
      sqlite3_prepare_v2(database, sql, -1, &statement_, nullptr);
    }
    ~Row() { sqlite3_finalize(statement_); }
    Row(const Row&) = delete;
    Row& operator=(const Row&) = delete;

    sqlite3_stmt* statement() const { return statement_; }
    void Bind(int index, int64_t value) {
      sqlite3_bind_int64(statement_, index, value);
    }
    // Empty ones stay NULL.
    template <typename T>
    void Bind(int index, const std::vector<T>& values) {
      if (values.empty()) return;
      sqlite3_bind_blob(statement_,
                        index,
                        values.data(),
                        static_cast<int>(sizeof(T) * values.size()),
                        SQLITE_TRANSIENT);
    }
    void Insert() { EXPECT_EQ(sqlite3_step(statement_), SQLITE_DONE); }

   private:
    sqlite3_stmt* statement_ = nullptr;
  };

  void Execute(const char* sql) {
    EXPECT_EQ(sqlite3_exec(database_, sql, nullptr, nullptr, nullptr),
              SQLITE_OK);
  }

  sqlite3* database_ = nullptr;
};

}  // namespace freegs::sfm

#endif  // FREEGS_TESTS_SFM_MATCH_DATABASE_WRITER_H_
