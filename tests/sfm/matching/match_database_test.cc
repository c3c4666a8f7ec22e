// SPDX-License-Identifier: BSD-3-Clause
// Questions to a COLMAP database, and copies of its matches.

#include "sfm/matching/match_database.h"

#include <cmath>
#include <csignal>
#include <cstring>
#include <sqlite3.h>
#include <sys/resource.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/sfm/match_database_writer.h"
#include "tests/temporary_folder.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

void RunSql(const fs::path& path, const std::string& sql) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
  char* message = nullptr;
  EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, &message),
            SQLITE_OK)
      << message;
  sqlite3_close(database);
}

// The columns of COLMAP 3.8 that matter here.
void MakeDatabase(const fs::path& path) {
  RunSql(path,
         "CREATE TABLE images(image_id INTEGER PRIMARY KEY, name TEXT UNIQUE);"
         "CREATE TABLE keypoints(image_id INTEGER PRIMARY KEY, rows INTEGER, "
         "cols INTEGER, data BLOB);"
         "CREATE TABLE descriptors(image_id INTEGER PRIMARY KEY, rows INTEGER, "
         "cols INTEGER, data BLOB);"
         "CREATE TABLE matches(pair_id INTEGER PRIMARY KEY, rows INTEGER, "
         "data BLOB);"
         "CREATE TABLE two_view_geometries(pair_id INTEGER PRIMARY KEY, rows "
         "INTEGER, data BLOB);"
         "INSERT INTO images VALUES(2,'b.jpg'),(1,'a.jpg'),(3,'c d.jpg');"
         "INSERT INTO keypoints VALUES(1,100,2,zeroblob(800)),"
         "(2,50,6,x'00');"
         "INSERT INTO descriptors VALUES(2,1,128,CAST(REPLACE(HEX(ZEROBLOB("
         "64)),'0',CHAR(1)) AS BLOB))");
}

constexpr int64_t kPair12 = int64_t{1} * 2147483647 + 2;
constexpr int64_t kPair23 = int64_t{2} * 2147483647 + 3;

std::string Hex(const std::vector<float>& values) {
  std::string text;
  for (const float value : values) {
    uint8_t bytes[4];
    std::memcpy(bytes, &value, 4);
    for (const uint8_t byte : bytes) {
      text += "0123456789abcdef"[byte >> 4];
      text += "0123456789abcdef"[byte & 15];
    }
  }
  return text;
}

TEST(MatchDatabase, ScalesOfFeatures) {
  const TemporaryFolder folder;
  MakeDatabase(folder / "a.db");
  RunSql(folder / "a.db",
         "INSERT INTO keypoints VALUES(4,2,4,x'" +
             Hex({1, 2, 3, 4, 5, 6, std::nanf(""), 8}) + "'),(5,1,6,x'" +
             Hex({1, 2, 3, 0, 4, 7}) + "'),(6,0,6,NULL),(7,-1,4,NULL)," +
             "(8,3,4,x'" + Hex({1, 2, 3, 4}) + "')");
  const auto database = MatchDatabase::Open(folder / "a.db");
  ASSERT_TRUE(database.ok()) << database.status().message();
  EXPECT_EQ(database->FeatureScales(4).value(), (std::vector<float>{3, 0}));
  EXPECT_EQ(database->FeatureScales(5).value(), std::vector<float>{6});
  // Positions only; a photo that is not there; no features.
  for (const uint32_t id : {1, 9, 6}) {
    const auto scales = database->FeatureScales(id);
    ASSERT_TRUE(scales.ok()) << scales.status().message();
    EXPECT_TRUE(scales->empty());
  }
  // Sizes that do not fit.
  for (const uint32_t id : {2, 7, 8}) {
    const auto scales = database->FeatureScales(id);
    EXPECT_EQ(scales.status().code(), StatusCode::kBadInput);
    EXPECT_THAT(scales.status().message(),
                testing::HasSubstr("photo " + std::to_string(id)));
  }
}

TEST(MatchDatabase, PositionsOfFeatures) {
  const TemporaryFolder folder;
  MakeDatabase(folder / "a.db");
  RunSql(folder / "a.db",
         "INSERT INTO keypoints VALUES(4,2,4,x'" +
             Hex({1, 2, 3, 4, 5, std::nanf(""), 7, 8}) + "'),(5,1,6,x'" +
             Hex({1, 2, 3, 0, 4, 7}) + "'),(6,1,2,x'" + Hex({1, 2}) +
             "'),(7,1,3,x'" + Hex({1, 2, 3}) + "'),(8,2,2,x'" + Hex({1, 2}) +
             "')");
  const auto database = MatchDatabase::Open(folder / "a.db");
  ASSERT_TRUE(database.ok()) << database.status().message();
  using Positions = std::vector<Eigen::Vector2f>;
  EXPECT_EQ(database->FeaturePositions(4).value(),
            (Positions{{1, 2}, {0, 0}}));  // NaN becomes 0.
  EXPECT_EQ(database->FeaturePositions(5).value(), (Positions{{1, 2}}));
  EXPECT_EQ(database->FeaturePositions(6).value(), (Positions{{1, 2}}));
  // No kind of keypoints that COLMAP has; a photo that is not there.
  for (const uint32_t id : {7, 9}) {
    const auto positions = database->FeaturePositions(id);
    ASSERT_TRUE(positions.ok()) << positions.status().message();
    EXPECT_TRUE(positions->empty());
  }
  EXPECT_EQ(database->FeaturePositions(8).status().code(),
            StatusCode::kBadInput);
}

TEST(MatchDatabase, MotionOfPairs) {
  const TemporaryFolder folder;
  const fs::path path = folder / "a.db";
  const std::vector<double> matrix = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  {
    MatchDatabaseWriter writer(path);
    writer.Add(1, 2, {0, 0}, 6, matrix, matrix);
    writer.Add(1, 3, {0, 0}, 2, {1, 2}, {std::nan(""), 2, 3, 4, 5, 6, 7, 8, 9});
    writer.Add(2, 3, {0, 0}, 2);
  }
  const auto database = MatchDatabase::Open(path);
  ASSERT_TRUE(database.ok()) << database.status().message();
  const auto pairs = database->VerifiedPairs();
  ASSERT_TRUE(pairs.ok()) << pairs.status().message();
  ASSERT_EQ(pairs->size(), 3u);
  EXPECT_TRUE((*pairs)[0].is_homography);
  EXPECT_EQ((*pairs)[0].homography.value()(0, 1), 2);
  EXPECT_EQ((*pairs)[0].fundamental.value()(1, 0), 4);
  // Nothing is taken from what is damaged or missing.
  for (const int i : {1, 2}) {
    EXPECT_FALSE((*pairs)[i].homography);
    EXPECT_FALSE((*pairs)[i].fundamental);
  }
}

TEST(MatchDatabase, ListsPhotosAndMatches) {
  const TemporaryFolder folder;
  MakeDatabase(folder / "a.db");
  RunSql(folder / "a.db",
         "INSERT INTO two_view_geometries VALUES(" + std::to_string(kPair12) +
             ",30,x'00'),(" + std::to_string(kPair23) + ",0,NULL)");
  const auto database = MatchDatabase::Open(folder / "a.db");
  ASSERT_TRUE(database.ok()) << database.status().message();
  const auto photos = database->Photos();
  ASSERT_TRUE(photos.ok());
  ASSERT_EQ(photos->size(), 3u);
  EXPECT_EQ((*photos)[0].name, "a.jpg");
  EXPECT_EQ((*photos)[0].num_features, 100);
  EXPECT_EQ((*photos)[2].name, "c d.jpg");
  EXPECT_EQ((*photos)[2].num_features, 0);
  // This database does not tell what motion it was.
  const auto pairs = database->VerifiedPairs();
  ASSERT_TRUE(pairs.ok());
  ASSERT_EQ(pairs->size(), 1u);
  EXPECT_EQ((*pairs)[0].id1, 1u);
  EXPECT_EQ((*pairs)[0].id2, 2u);
  EXPECT_EQ((*pairs)[0].num_matches, 30);
  EXPECT_FALSE((*pairs)[0].is_homography);
  // The second pair was compared in vain.
  EXPECT_THAT(*database->ComparedPairs(),
              testing::ElementsAre(testing::Pair(1, 2), testing::Pair(2, 3)));
}

TEST(MatchDatabase, NumbersThatAreNoPairsAreRefused) {
  constexpr int64_t kMax = 2147483647;
  for (const int64_t pair :
       {int64_t{-5}, int64_t{0}, int64_t{2}, 2 * kMax + 1, 2 * kMax + 2}) {
    const TemporaryFolder folder;
    MakeDatabase(folder / "a.db");
    RunSql(folder / "a.db",
           "INSERT INTO two_view_geometries VALUES(" + std::to_string(pair) +
               ",1,x'0000000000000000')");
    const auto database = MatchDatabase::Open(folder / "a.db");
    ASSERT_TRUE(database.ok()) << database.status().message();
    EXPECT_EQ(database->VerifiedPairs().status().code(), StatusCode::kBadInput);
    EXPECT_EQ(database->ComparedPairs().status().code(), StatusCode::kBadInput);
    const Status status = database->ForEachVerifiedPair(
        [](uint32_t, uint32_t, std::span<const FeatureMatch>) { FAIL(); });
    EXPECT_EQ(status.code(), StatusCode::kBadInput);
    EXPECT_THAT(status.message(),
                testing::HasSubstr("not the number of a pair"));
  }
}

// SQLite takes a text for larger than any number.
TEST(MatchDatabase, TextInPlaceOfACountIsRefused) {
  const TemporaryFolder folder;
  MakeDatabase(folder / "a.db");
  RunSql(folder / "a.db",
         "INSERT INTO two_view_geometries VALUES(" + std::to_string(kPair12) +
             ",'x',x'')");
  const auto database = MatchDatabase::Open(folder / "a.db");
  ASSERT_TRUE(database.ok()) << database.status().message();
  EXPECT_EQ(database->VerifiedPairs().status().code(), StatusCode::kBadInput);
  const Status status = database->ForEachVerifiedPair(
      [](uint32_t, uint32_t, std::span<const FeatureMatch>) { FAIL(); });
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), testing::HasSubstr("not of their size"));
}

TEST(MatchDatabase, ReadsTheMatricesOfPairsAndSkipsDamagedOnes) {
  const TemporaryFolder folder;
  // Doubles as COLMAP stores them, little endian.
  const std::string one = "000000000000F03F";  // 1.0
  const std::string two = "0000000000000040";  // 2.0
  const std::string nan = "000000000000F87F";
  const std::string zero = "0000000000000000";
  const std::string diagonal =
      one + two + zero + zero + one + zero + zero + zero + one;
  RunSql(folder / "a.db",
         "CREATE TABLE images(image_id INTEGER PRIMARY KEY, name TEXT);"
         "CREATE TABLE two_view_geometries(pair_id INTEGER PRIMARY KEY, rows "
         "INTEGER, cols INTEGER, data BLOB, config INTEGER, F BLOB, E BLOB, "
         "H BLOB);");
  RunSql(folder / "a.db",
         "INSERT INTO two_view_geometries VALUES"
         "(" +
             std::to_string(kPair12) + ",30,2,NULL,6,NULL,NULL,x'" + diagonal +
             "'),"
             "(" +
             std::to_string(kPair23) + ",20,2,NULL,3,NULL,NULL,x'" + diagonal +
             "'),"
             "(" +
             std::to_string(kPair23 + 1) + ",20,2,NULL,4,NULL,NULL,x'" + nan +
             diagonal.substr(16) +
             "'),"
             "(" +
             std::to_string(kPair23 + 2) + ",20,2,NULL,5,NULL,NULL,x'00')");
  const auto database = MatchDatabase::Open(folder / "a.db");
  ASSERT_TRUE(database.ok()) << database.status().message();
  const auto pairs = database->VerifiedPairs();
  ASSERT_TRUE(pairs.ok());
  ASSERT_EQ(pairs->size(), 4u);
  EXPECT_TRUE((*pairs)[0].is_homography);
  ASSERT_TRUE((*pairs)[0].homography.has_value());
  EXPECT_EQ((*(*pairs)[0].homography)(0, 1), 2);
  EXPECT_EQ((*(*pairs)[0].homography)(1, 0), 0);
  // Another motion fits better, but some matches are of one plane.
  EXPECT_FALSE((*pairs)[1].is_homography);
  EXPECT_TRUE((*pairs)[1].homography.has_value());
  // Not a number; cut short.
  EXPECT_TRUE((*pairs)[2].is_homography);
  EXPECT_FALSE((*pairs)[2].homography.has_value());
  EXPECT_FALSE((*pairs)[3].homography.has_value());
}

TEST(MatchDatabase, CopiesMatchesBetweenCopies) {
  const TemporaryFolder folder;
  MakeDatabase(folder / "main.db");
  auto main = MatchDatabase::Open(folder / "main.db");
  ASSERT_TRUE(main.ok());
  const fs::path copy_path = folder / "it's a copy.db";
  ASSERT_TRUE(main->CopyTo(copy_path).ok());
  EXPECT_FALSE(main->CopyTo(copy_path).ok());  // Never overwrites.
  {
    auto copy = MatchDatabase::Open(copy_path);
    ASSERT_TRUE(copy.ok());
    ASSERT_TRUE(
        copy->RenamePhotos([](uint32_t id) { return std::to_string(id); })
            .ok());
    EXPECT_EQ((*copy->Photos())[2].name, "3");
  }
  RunSql(copy_path,
         "INSERT INTO matches VALUES(" + std::to_string(kPair12) +
             ",9,x'01');INSERT INTO two_view_geometries VALUES(" +
             std::to_string(kPair12) + ",9,x'02')");
  // Twice: after a crash a portion is copied again.
  EXPECT_TRUE(main->CopyMatchesFrom(copy_path).ok());
  EXPECT_TRUE(main->CopyMatchesFrom(copy_path).ok());
  EXPECT_EQ((*main->VerifiedPairs())[0].num_matches, 9);
  EXPECT_EQ((*main->Photos())[2].name, "c d.jpg");
  EXPECT_EQ(main->Descriptors(2)->count(), 1u);
  EXPECT_TRUE(main->ClearMatchesAndDescriptors().ok());
  EXPECT_TRUE(main->VerifiedPairs()->empty());
  EXPECT_EQ(main->Descriptors(2)->count(), 0u);
}

TEST(MatchDatabase, DamagedDescriptorsAreAnErrorAndMissingOnesAreNot) {
  const TemporaryFolder folder;
  MakeDatabase(folder / "a.db");
  RunSql(folder / "a.db",
         "INSERT INTO descriptors VALUES(1,3,128,zeroblob(384)),"
         "(3,3,128,zeroblob(383)),(4,3,64,zeroblob(192)),(5,0,128,NULL),"
         "(6,-1,128,x'')");
  const auto database = MatchDatabase::Open(folder / "a.db");
  ASSERT_TRUE(database.ok());
  EXPECT_EQ(database->Descriptors(1)->count(), 3u);
  EXPECT_EQ(database->Descriptors(2)->values[0], 1);
  EXPECT_FALSE(database->Descriptors(3).ok());
  EXPECT_FALSE(database->Descriptors(4).ok());
  EXPECT_EQ(database->Descriptors(5)->count(), 0u);
  EXPECT_FALSE(database->Descriptors(6).ok());
  EXPECT_EQ(database->Descriptors(77)->count(), 0u);
}

TEST(MatchDatabase, AddsAndClearsFeatures) {
  const TemporaryFolder folder;
  for (const bool typed : {false, true}) {
    const fs::path path = folder / (typed ? "new.db" : "old.db");
    MakeDatabase(path);
    if (typed) {
      // As releases from 4.0 on.
      RunSql(path,
             "DROP TABLE descriptors; CREATE TABLE descriptors(image_id "
             "INTEGER PRIMARY KEY, type INTEGER NOT NULL, rows INTEGER, cols "
             "INTEGER, data BLOB)");
    }
    auto database = MatchDatabase::Open(path);
    ASSERT_TRUE(database.ok()) << database.status().message();
    const std::vector<Keypoint> keypoints = {{1, 2, 3, 0.5f}, {4, 5, 2, 0}};
    const std::vector<Keypoint> none;
    SiftDescriptors descriptors;
    for (size_t i = 0; i < 2 * kSiftDimensions; ++i) {
      descriptors.values.push_back(static_cast<uint8_t>(i));
    }
    const SiftDescriptors empty;
    const std::vector<PhotoKeypoints> photos = {{2, &keypoints, &descriptors},
                                                {3, &none, &empty}};
    const Status added = database->AddFeatures(photos);
    ASSERT_TRUE(added.ok()) << added.message();
    EXPECT_EQ(database->Photos()->at(1).num_features, 2);
    EXPECT_EQ(database->Photos()->at(2).num_features, 0);
    EXPECT_EQ(database->FeatureScales(2).value(), (std::vector<float>{3, 2}));
    EXPECT_EQ(database->Descriptors(2)->values, descriptors.values);
    EXPECT_EQ(database->Descriptors(3)->count(), 0u);

    ASSERT_TRUE(database->ClearFeatures().ok());
    const auto cleared = database->Photos();
    ASSERT_TRUE(cleared.ok()) << cleared.status().message();
    for (const auto& photo : *cleared) {
      EXPECT_EQ(photo.num_features, 0);
      EXPECT_EQ(database->Descriptors(photo.id)->count(), 0u);
    }
  }
}

TEST(MatchDatabase, OtherFilesAreRefused) {
  const TemporaryFolder folder;
  EXPECT_FALSE(MatchDatabase::Open(folder / "missing.db").ok());
  WriteText(folder / "text.db", std::string(5000, 'x'));
  EXPECT_FALSE(MatchDatabase::Open(folder / "text.db").ok());
  RunSql(folder / "other.db", "CREATE TABLE t(x)");
  const auto other = MatchDatabase::Open(folder / "other.db");
  ASSERT_FALSE(other.ok());
  EXPECT_EQ(other.status().code(), StatusCode::kBadInput);
  EXPECT_THAT(other.status().message(), testing::HasSubstr("other.db"));
  MakeDatabase(folder / "main.db");
  auto main = MatchDatabase::Open(folder / "main.db");
  EXPECT_FALSE(main->CopyMatchesFrom(folder / "other.db").ok());
  EXPECT_TRUE(main->Photos().ok());  // Still usable.
}

// As on a full disk: no file can grow beyond a limit.
TEST(MatchDatabase, AFullDiskIsNoDamage) {
  const TemporaryFolder folder;
  MakeDatabase(folder / "a.db");
  rlimit old = {};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old), 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small = {4096, old.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const Status status = CopyDatabase(folder / "a.db", folder / "b.db");
  setrlimit(RLIMIT_FSIZE, &old);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_EQ(status.code(), StatusCode::kInternal) << status.message();

  WriteText(folder / "c.db", std::string(5000, 'x'));
  EXPECT_EQ(MatchDatabase::Open(folder / "c.db").status().code(),
            StatusCode::kBadInput);
}

}  // namespace
}  // namespace freegs::sfm
